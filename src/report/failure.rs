//! Why a trial failed, for the terminal and, in the same words, for JUnit.

use anstyle::AnsiColor;

use super::format::share;
use super::table::paint;
use super::wording::{metric_value, run_in_words, run_value, stopping, unseen, whom};
use files::escape::terminal;
use lang::Excerpt;
use results::{
    BlockReport, BlockState, CutBy, Finding, FindingMeasure, SuiteIdentity, TrialState, UnitReport, Verdict,
};

/// Why a unit did not pass.
pub fn explain(suite: &SuiteIdentity, report: &UnitReport, colour: bool) -> String {
    let render = |state: &TrialState| match state {
        TrialState::NotFinished(cut) if cut.by() == CutBy::TimeLimit => {
            paint("error: ", AnsiColor::Red.on_default().bold(), colour) + &cut.explained()
        }
        TrialState::Errored(error) => {
            paint("error: ", AnsiColor::Red.on_default().bold(), colour) + &terminal(&error.message)
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
        TrialState::Skipped(reason) => terminal(&reason.to_string()),
        TrialState::Errored(error) => terminal(&error.message),
        TrialState::NotFinished(cut) => terminal(&cut.explained()),
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
        BlockState::Skipped(reason) => return terminal(&reason.to_string()),
        BlockState::NotFinished(cut) => return terminal(&cut.explained()),
        BlockState::Errored(error) => format!("{block} could not be run: {error}"),
        BlockState::Finished(result) => match result.failure() {
            Some(reason) if result.verdict() == Some(Verdict::Inconclusive) => {
                format!("{block} is inconclusive: {reason}")
            }
            Some(reason) => format!("{block} failed: {reason}"),
            None => return String::new(),
        },
    };
    let again = format!("run it again: {}", suite.block_command(&report.key));
    let origin = report.block.origin();
    Excerpt { title: &title, origin, label: "", notes: &[], help: Some(&again) }.render(colour)
}

/// A finding that is not passed, drawn at its place.
pub(super) fn render_finding(suite: &SuiteIdentity, finding: &Finding, colour: bool) -> String {
    let title = title(finding);
    let mut notes = Vec::new();
    if finding.undefined > 0 {
        notes.push(format!(
            "`{}` does not exist in {} of {} runs",
            finding.metric, finding.undefined, finding.runs
        ));
    }
    if finding.cut_off > 0 {
        notes.push(format!(
            "{} of {} runs ended before `{}` was decided; each counts as the worst that could still have come",
            finding.cut_off, finding.runs, finding.metric
        ));
    }
    if finding.unseen > 0 {
        notes.push(format!("{}: what would have come is not in it", unseen(finding)));
    }
    notes.extend(bounds(finding));
    let runs = finding.worst.iter().chain(&finding.closest);
    notes.extend(runs.map(|run| format!("{}  {}", run_in_words(finding, run), run.key)));
    let replay = finding.worst.first().map(|run| format!("replay: {}", suite.replay_command(&run.key)));
    let label =
        finding.worst.first().map_or_else(String::new, |run| format!("worst: {}", run_value(finding, run)));
    Excerpt { title: &title, origin: &finding.origin, label: &label, notes: &notes, help: replay.as_deref() }
        .render(colour)
}

/// What is known at the stated confidence: the side that decides or, where neither does, each by itself.
fn bounds(finding: &Finding) -> Option<String> {
    let ((low, high), confidence) = (finding.interval?, finding.confidence?);
    let show = |bound: f64| match finding.measure {
        FindingMeasure::Share | FindingMeasure::EveryRun => share(bound),
        _ => metric_value(finding, Some(bound)),
    };
    let least = low.is_finite().then(|| format!("at least {}", show(low)));
    let most = high.is_finite().then(|| format!("at most {}", show(high)));
    let at = format!("{} {}", if finding.approximate { "about" } else { "at" }, share(confidence));
    let whom = whom(finding).map_or_else(String::new, |whom| format!(" {whom}"));
    let both = format!("both at {}", share(2.0 * confidence - 1.0));
    Some(match (least, most) {
        (None, None) => format!("{at} confidence nothing bounds it{whom}"),
        // A failing claim is refuted by the end that is nearer to its bound.
        (Some(least), _) if finding.verdict == Verdict::Failed && low >= finding.bound => {
            format!("{at} confidence it is {least}{whom}")
        }
        (_, Some(most)) if finding.verdict == Verdict::Failed => {
            format!("{at} confidence it is {most}{whom}")
        }
        (Some(least), Some(most)) => {
            format!("{at} confidence it is {least}, {at} it is {most}, {both}{whom}")
        }
        (Some(one), None) | (None, Some(one)) => format!("{at} confidence it is {one}{whom}"),
    })
}

fn title(finding: &Finding) -> String {
    let criterion = &finding.criterion;
    let verb = match finding.verdict {
        Verdict::Inconclusive => "could not be decided",
        _ => "failed",
    };
    let missed = finding.runs - finding.holding;
    let Some(observed) = finding.observed else {
        // Only a spread does not exist where there is a value.
        let why = match finding.holding {
            1 if finding.measure == FindingMeasure::Value => "one run has no spread",
            _ => "no run has a value",
        };
        return format!("`{criterion}` {verb}: {why}{}", of_those_cut_off(finding));
    };
    match finding.measure {
        FindingMeasure::EveryRun => format!("`{criterion}` {verb} in {missed} of {} runs", finding.runs),
        FindingMeasure::Share => {
            format!(
                "`{criterion}` {verb}: {} ({} of {} runs)",
                share(observed),
                finding.holding,
                finding.runs
            )
        }
        FindingMeasure::Count => {
            let cut_off = of_those_cut_off(finding);
            format!("`{criterion}` {verb}: {observed} of {} runs{cut_off}", finding.runs)
        }
        FindingMeasure::Value if observed.is_infinite() => {
            let (known, cut_off) = (finding.holding, of_those_cut_off(finding));
            format!(
                "`{criterion}` {verb}: nothing bounds it, with a value in {known} of {} runs{cut_off}",
                finding.runs
            )
        }
        FindingMeasure::Value => {
            let text = metric_value(finding, Some(observed));
            // Only those with a value are in it.
            let (with, all) = (finding.holding, finding.runs);
            let of = if with == all { String::new() } else { format!(" of {all}") };
            format!("`{criterion}` {verb}: {text} over {with}{of} runs")
        }
    }
}

/// `, 3 cut off before it was decided`; nothing if none was.
fn of_those_cut_off(finding: &Finding) -> String {
    match finding.cut_off {
        0 => String::new(),
        runs => format!(", {runs} cut off before it was decided"),
    }
}

/// The criterion with what its worst run has: `pet >= 1.5 s: pet 0.83 s`.
pub fn with_worst(finding: &Finding) -> String {
    let worst = finding.worst.first().map(|run| run_value(finding, run)).unwrap_or_default();
    format!("{}: {worst}", finding.criterion)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::Origin;

    fn finding(measure: FindingMeasure, verdict: Verdict, interval: Option<(f64, f64)>) -> Finding {
        Finding {
            criterion: "mean(time_lost) <= 2 s with 95 % confidence".into(),
            origin: Origin::default(),
            verdict,
            metric: models::known::metric("time_lost"),
            measure,
            runs: 400,
            holding: 356,
            undefined: 4,
            cut_off: 40,
            unseen: 0,
            observed: Some(2.41),
            bound: 2.0,
            margin: Some(-0.41),
            interval,
            confidence: Some(0.95),
            alike: false,
            approximate: false,
            people: None,
            worst: Vec::new(),
            closest: None,
            overlapping: 0,
            tested: None,
            untested: None,
        }
    }

    #[test]
    fn the_side_that_decides_stands_at_the_stated_confidence() {
        let said = |verdict, ends| bounds(&finding(FindingMeasure::Value, verdict, Some(ends))).unwrap();
        assert_eq!(said(Verdict::Failed, (2.1, 2.7)), "at 95 % confidence it is at least 2.1 s");
        assert_eq!(said(Verdict::Failed, (0.5, 1.7)), "at 95 % confidence it is at most 1.7 s");
        // Two ends that are right 95 times in a hundred each are both so 90 times.
        assert_eq!(
            said(Verdict::Inconclusive, (1.9, 2.7)),
            "at 95 % confidence it is at least 1.9 s, at 95 % it is at most 2.7 s, both at 90 %"
        );
        assert_eq!(
            said(Verdict::Inconclusive, (1.9, f64::INFINITY)),
            "at 95 % confidence it is at least 1.9 s"
        );
        let approximate = Finding {
            approximate: true,
            ..finding(FindingMeasure::Value, Verdict::Failed, Some((2.1, 2.7)))
        };
        assert_eq!(bounds(&approximate).unwrap(), "about 95 % confidence it is at least 2.1 s");
    }

    #[test]
    fn a_number_says_of_how_many_runs_it_is() {
        let value = finding(FindingMeasure::Value, Verdict::Failed, None);
        assert_eq!(
            title(&value),
            "`mean(time_lost) <= 2 s with 95 % confidence` failed: 2.41 s over 356 of 400 runs"
        );
        let all = Finding { holding: 400, undefined: 0, cut_off: 0, ..value };
        assert!(title(&all).ends_with("2.41 s over 400 runs"), "{}", title(&all));
    }

    #[test]
    fn what_was_cut_off_is_said_where_a_number_is_missing() {
        let one =
            Finding { runs: 1, undefined: 0, ..finding(FindingMeasure::Value, Verdict::Inconclusive, None) };
        let criterion = "`mean(time_lost) <= 2 s with 95 % confidence` could not be decided: ";
        let said = |finding: Finding| title(&finding).replace(criterion, "");
        let spread = Finding { holding: 1, cut_off: 0, observed: None, ..one.clone() };
        assert_eq!(said(spread), "one run has no spread");
        let none = Finding { holding: 0, cut_off: 1, observed: None, ..one };
        assert_eq!(said(none.clone()), "no run has a value, 1 cut off before it was decided");
        let infinite = Finding { observed: Some(f64::INFINITY), ..none.clone() };
        assert_eq!(
            said(infinite),
            "nothing bounds it, with a value in 0 of 1 runs, 1 cut off before it was decided"
        );
        let counted = Finding { measure: FindingMeasure::Count, observed: Some(0.0), ..none };
        assert_eq!(said(counted), "0 of 1 runs, 1 cut off before it was decided");
    }
}
