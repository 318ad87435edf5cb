//! Why a trial failed, for the terminal and, in the same words, for JUnit.

use anstyle::AnsiColor;

use super::excerpt::Excerpt;
use super::format::{quantity, share};
use super::replay::{block_command, replay_command};
use super::table::paint;
use super::wording::{run_in_words, run_value, stopping};
use super::{BlockReport, BlockState, SuiteIdentity, TrialState, UnitReport};
use crate::judge::{Finding, Measure, Verdict};
use crate::metrics;
use crate::scenario::significant;

/// Why a unit did not pass.
pub fn explain(suite: &SuiteIdentity, report: &UnitReport, colour: bool) -> String {
    let render = |state: &TrialState| match state {
        TrialState::Errored(message) => {
            paint("error: ", AnsiColor::Red.on_default().bold(), colour) + message
        }
        state => render_failure(suite, state, colour),
    };
    match report {
        UnitReport::Recorded(recorded) => render(&recorded.trial_state()),
        UnitReport::Trial(trial) => render(&trial.state),
        UnitReport::Block(block) => render_block_failure(suite, block, colour),
    }
}

/// Every finding that is not passed, drawn at its place, with the worst runs and how to replay them.
pub fn render_failure(suite: &SuiteIdentity, state: &TrialState, colour: bool) -> String {
    match state {
        TrialState::Skipped(reason) => reason.to_string(),
        TrialState::Errored(message) => message.clone(),
        TrialState::Judged(judged) => {
            let bad = judged.findings.iter().filter(|finding| finding.verdict != Verdict::Passed);
            let drawings = bad.map(|finding| render_finding(suite, finding, colour));
            let stopped =
                judged.stopping.as_ref().map(|stopped| format!("this trial was {}", stopping(stopped)));
            drawings.chain(stopped).collect::<Vec<_>>().join("\n\n")
        }
    }
}

/// Why a block has no result, or one that is not what it was to show; empty for the others.
pub fn render_block_failure(suite: &SuiteIdentity, report: &BlockReport, colour: bool) -> String {
    let block = format!("`{} {}`", report.block.kind(), report.block.name());
    let title = match &report.state {
        BlockState::Skipped(reason) => return reason.to_string(),
        BlockState::Errored(message) => format!("{block} could not be run: {message}"),
        BlockState::Finished(result) => match result.failure() {
            Some(reason) => format!("{block} failed: {reason}"),
            None => return String::new(),
        },
    };
    let again = format!("run it again: {}", block_command(suite, &report.key));
    let origin = report.block.origin();
    Excerpt { title: &title, origin, label: "", notes: &[], help: Some(&again) }.render(colour)
}

fn render_finding(suite: &SuiteIdentity, finding: &Finding, colour: bool) -> String {
    let title = title(finding);
    let mut notes = Vec::new();
    if finding.undefined > 0 {
        notes.push(format!(
            "`{}` does not exist in {} of {} runs",
            finding.metric, finding.undefined, finding.runs
        ));
    }
    if let Some((low, high)) = finding.interval {
        let show = |bound: f64| match finding.measure {
            Measure::Share | Measure::EveryRun => share(bound),
            _ if bound.is_infinite() => "anywhere".to_string(),
            _ => metrics::metric(&finding.metric)
                .map_or_else(|| significant(bound, 4), |metric| quantity(metric, Some(bound))),
        };
        notes.push(format!("at the stated confidence it lies between {} and {}", show(low), show(high)));
    }
    let runs = finding.worst.iter().chain(&finding.closest);
    notes.extend(runs.map(|run| format!("{}  {}", run_in_words(finding, run), run.key)));
    let replay = finding.worst.first().map(|run| format!("replay: {}", replay_command(suite, &run.key)));
    let label =
        finding.worst.first().map_or_else(String::new, |run| format!("worst: {}", run_value(finding, run)));
    Excerpt { title: &title, origin: &finding.origin, label: &label, notes: &notes, help: replay.as_deref() }
        .render(colour)
}

fn title(finding: &Finding) -> String {
    let criterion = &finding.criterion;
    let verb = match finding.verdict {
        Verdict::Inconclusive => "could not be decided",
        _ => "failed",
    };
    let missed = finding.runs - finding.holding;
    let Some(observed) = finding.observed else {
        return format!("`{criterion}` {verb}: no run has a value");
    };
    match finding.measure {
        Measure::EveryRun => format!("`{criterion}` {verb} in {missed} of {} runs", finding.runs),
        Measure::Share => {
            format!(
                "`{criterion}` {verb}: {} ({} of {} runs)",
                share(observed),
                finding.holding,
                finding.runs
            )
        }
        Measure::Count => format!("`{criterion}` {verb}: {observed} of {} runs", finding.runs),
        Measure::Value => {
            let text = metrics::metric(&finding.metric)
                .map_or_else(|| significant(observed, 4), |metric| quantity(metric, Some(observed)));
            format!("`{criterion}` {verb}: {text} over {} runs", finding.runs)
        }
    }
}

/// The criterion with what its worst run has: `pet >= 1.5 s: pet 0.83 s`.
pub fn with_worst(finding: &Finding) -> String {
    let worst = finding.worst.first().map(|run| run_value(finding, run)).unwrap_or_default();
    format!("{}: {worst}", finding.criterion)
}
