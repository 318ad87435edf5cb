//! Results on GitHub: annotations at the criteria that did not hold, and the summary of a step in Markdown.

use std::fmt::Write;

use super::digest::Digest;
use super::experiment::render_block;
use super::failure::{render_block_failure, render_failure};
use super::figures::{scenarios, short_name};
use super::findings::{data, property};
use super::gate::render_gate_report;
use super::gate_markdown::gate_markdown;
use super::replay::{block_command, replay_command};
use super::wording::{closest_calls, nearest_run, observed, stopping, untested, verdict_mark, verdict_word};
use super::{
    BlockReport, BlockState, GateReport, GateState, RecordedReport, Standing, SuiteReport, TrialReport,
    TrialState,
};
use crate::judge::Verdict;
use crate::run::Requests;
use crate::scenario::Origin;

/// GitHub shows ten annotations of a kind per step, so a criterion has one for all the trials it failed in.
struct Annotation {
    level: &'static str,
    origin: Origin,
    title: String,
    trials: Vec<String>,
}

/// A step summary may have a mebibyte; this leaves room for those of others.
const MOST_SUMMARY_BYTES: usize = 900_000;
/// More trials are only counted in an annotation.
const MOST_TRIALS_NAMED: usize = 5;
/// Trials whose failures are written out in full.
const MOST_FAILURES: usize = 20;

/// Workflow commands such as `::error file=…,line=…::message`, one a line.
pub fn annotations(reports: &[SuiteReport]) -> String {
    let mut annotations: Vec<Annotation> = Vec::new();
    let mut add = |level, origin, title: String, said: String| match annotations
        .iter_mut()
        .find(|one| one.origin == origin && one.title == title && one.level == level)
    {
        Some(known) => known.trials.push(said),
        None => annotations.push(Annotation { level, origin, title, trials: vec![said] }),
    };
    for report in reports {
        let recorded = report.recorded.iter().map(|one| (one.key.as_str(), None, one.trial_state()));
        let trials = &report.trials;
        let trials =
            trials.iter().map(|one| (one.trial.key.as_str(), Some(&one.trial.origin), one.state.clone()));
        for (key, origin, state) in recorded.chain(trials) {
            match state {
                TrialState::Skipped(_) => {}
                TrialState::Errored(message) => {
                    let file = || report.identity.file.to_string();
                    let origin = origin.cloned();
                    let origin = origin.unwrap_or_else(|| Origin {
                        file: file(),
                        line: 1,
                        column: 1,
                        ..Origin::default()
                    });
                    add("error", origin, "could not run".to_string(), message);
                }
                TrialState::Judged(judged) => {
                    for finding in judged.findings.iter().filter(|one| one.vacuous.is_some()) {
                        let title = format!("{} untested", finding.criterion);
                        let said = untested(std::slice::from_ref(finding)).concat();
                        add("warning", finding.origin.clone(), title, format!("{key}: {said}"));
                    }
                    for finding in judged.findings.into_iter().filter(|one| one.verdict != Verdict::Passed) {
                        let level = if finding.verdict == Verdict::Failed { "error" } else { "warning" };
                        let said = [Some(observed(&finding)), nearest_run(&finding)];
                        let said: Vec<_> = said.into_iter().flatten().collect();
                        let said = format!("{key}: {}", said.join(", "));
                        let title = format!("{} {}", finding.criterion, verdict_word(finding.verdict));
                        add(level, finding.origin, title, said);
                    }
                }
            }
        }
    }
    for (report, block) in reports.iter().flat_map(|one| one.blocks.iter().map(move |block| (one, block))) {
        let title = format!("{} {}", block.block.kind(), block.block.name());
        let (said, what) = match &block.state {
            BlockState::Skipped(_) => continue,
            BlockState::Errored(message) => ("could not run", message.clone()),
            BlockState::Finished(result) => match result.failure() {
                Some(reason) => ("failed", reason),
                None => continue,
            },
        };
        let again = block_command(&report.identity, &block.key);
        add("error", block.block.origin().clone(), format!("{title} {said}"), format!("{what}\n{again}"));
    }
    for (report, gate) in reports.iter().flat_map(|one| one.gates.iter().map(move |gate| (one, gate))) {
        let (level, what) = match &gate.state {
            GateState::Skipped(_) => continue,
            GateState::Refused(_) => ("error", "cannot be judged"),
            GateState::Judged(verdict) => match verdict.verdict {
                Verdict::Passed => continue,
                Verdict::Inconclusive => ("warning", "inconclusive"),
                Verdict::Failed => ("error", "regressed"),
            },
        };
        let said = render_gate_report(&report.identity, gate, false);
        add(level, gate.gate.origin.clone(), format!("gate {} {what}", gate.gate.name), said);
    }
    let mut text = String::new();
    for Annotation { level, origin, title, trials } in annotations {
        let mut message = trials.iter().take(MOST_TRIALS_NAMED).cloned().collect::<Vec<_>>().join("\n");
        if trials.len() > MOST_TRIALS_NAMED {
            write!(message, "\nand {} more trials", trials.len() - MOST_TRIALS_NAMED)
                .expect("writing to a string cannot fail");
        }
        let end = origin.column + origin.length.max(1);
        writeln!(
            text,
            "::{level} file={},line={},col={},endColumn={end},title={}::{}",
            property(&origin.file),
            origin.line,
            origin.column,
            property(&title),
            data(&message),
        )
        .expect("writing to a string cannot fail");
    }
    text
}

/// The summary of a step in GitHub's Markdown.
pub fn step_summary(reports: &[SuiteReport], requests: &Requests) -> String {
    let mut text = String::new();
    for report in reports {
        suite_summary(&mut text, report, requests);
        for gate in &report.gates {
            text += &match &gate.state {
                GateState::Judged(verdict) => {
                    gate_markdown(verdict, &|key| Some(replay_command(&report.identity, key)))
                }
                GateState::Refused(refusal) => {
                    let reasons: String =
                        refusal.reasons.iter().map(|reason| format!("- {}\n", markdown(reason))).collect();
                    format!(
                        "### 💥 {}: cannot be judged\n\n{}\n\n{reasons}\n{}\n",
                        markdown(&gate.gate.name),
                        markdown(&refusal.message),
                        markdown(&refusal.help)
                    )
                }
                GateState::Skipped(message) => {
                    format!("### {}: not judged\n\n{}\n", markdown(&gate.gate.name), markdown(message))
                }
            };
            text.push('\n');
        }
    }
    if text.len() > MOST_SUMMARY_BYTES {
        let most = (0..=MOST_SUMMARY_BYTES).rev().find(|end| text.is_char_boundary(*end)).unwrap_or(0);
        let end = text[..most].rfind("\n\n").unwrap_or(0);
        text.truncate(end);
        text.push_str("\n\n…cut: the whole report is too long for a step summary.\n");
    }
    text
}

fn suite_summary(text: &mut String, report: &SuiteReport, requests: &Requests) {
    let mut line = |content: String| {
        text.push_str(&content);
        text.push('\n');
    };
    let recorded = report.recorded.iter().map(RecordedReport::standing);
    let trials = report.trials.iter().map(TrialReport::standing);
    let blocks = report.blocks.iter().map(BlockReport::standing);
    let gates = report.gates.iter().map(GateReport::standing);
    let standings: Vec<_> = recorded.chain(trials).chain(blocks).chain(gates).collect();
    let count = |wanted| standings.iter().filter(|standing| **standing == wanted).count();
    let runs: usize = report.trials.iter().map(|trial| trial.outcomes.len()).sum();
    let counts = [
        (count(Standing::Judged(Verdict::Passed)), "✅ passed"),
        (count(Standing::Judged(Verdict::Failed)), "❌ failed"),
        (count(Standing::Judged(Verdict::Inconclusive)), "❔ inconclusive"),
        (count(Standing::Errored), "💥 could not run"),
    ];
    let said: Vec<_> = counts
        .iter()
        .filter(|(number, _)| *number > 0)
        .map(|(number, word)| format!("{number} {word}"))
        .collect();
    let identity = &report.identity;
    line(format!("## {}: {}\n", markdown(identity.suite), said.join(", ")));
    line(format!(
        "`{}`, seed {}, {} trials, {runs} runs, {:.1} s, scenario-runner {}\n",
        identity.file,
        identity.seed,
        report.trials.iter().filter(|trial| !trial.skipped()).count(),
        report.wall_time.as_secs_f64(),
        env!("CARGO_PKG_VERSION"),
    ));
    for (name, trials) in scenarios(report) {
        let trials: Vec<_> = trials.into_iter().filter(|trial| !trial.skipped()).collect();
        if trials.is_empty() {
            continue;
        }
        let columns = super::table::columns(&trials, requests);
        let mut heading = format!("| {} | |", markdown(name));
        let mut rule = "|---|---|".to_string();
        for (_, metric, label) in &columns {
            let (label, below) = Digest::heading(metric, label);
            write!(heading, " {}<br><sub>{}</sub> |", markdown(&label), markdown(&below))
                .expect("writing to a string cannot fail");
            rule.push_str("--:|");
        }
        line(heading);
        line(rule);
        for trial in &trials {
            let mut mark = match trial.verdict() {
                None => "💥 error".to_string(),
                Some(verdict) => format!("{} {}", verdict_mark(verdict), verdict_word(verdict)),
            };
            if let Some(stopped) = trial.stopping() {
                mark += &format!("<br><sub>{}</sub>", stopping(stopped));
            }
            let mut row = format!("| {} | {mark} |", markdown(&short_name(trial)));
            for (index, metric, _) in &columns {
                let digest = Digest::new(metric, &trial.outcomes, *index).short();
                write!(row, " {} |", markdown(&digest)).expect("writing to a string cannot fail");
            }
            line(row);
        }
        line(String::new());
        let calls = closest_calls(&trials);
        let warnings = trials.iter().flat_map(|trial| {
            let key = &trial.trial.key;
            untested(trial.findings()).into_iter().map(move |warning| format!("⚠️ {key}: {warning}"))
        });
        let notes: Vec<_> = calls.into_iter().chain(warnings).collect();
        notes.iter().for_each(|note| line(format!("- {}", markdown(note))));
        if !notes.is_empty() {
            line(String::new());
        }
    }
    let failed = |trial: &&TrialReport| !trial.skipped() && trial.verdict() != Some(Verdict::Passed);
    for trial in report.trials.iter().filter(failed).take(MOST_FAILURES) {
        line(format!("<details><summary>{}</summary>\n", html(&trial.trial.key)));
        line("~~~~text".into());
        line(render_failure(identity, &trial.state, false));
        line("~~~~\n".into());
        line("</details>\n".into());
    }
    let more = report.trials.iter().filter(failed).count().saturating_sub(MOST_FAILURES);
    if more > 0 {
        line(format!("and {more} more that did not pass\n"));
    }
    blocks_summary(text, report);
    recorded_summary(text, report);
}

/// Every run that failed before, with what is to be said of it now.
fn recorded_summary(text: &mut String, report: &SuiteReport) {
    if report.recorded.is_empty() {
        return;
    }
    text.push_str("Recorded failures, run again:\n\n");
    for one in &report.recorded {
        let mark = match one.standing() {
            Standing::Judged(verdict) => verdict_mark(verdict),
            Standing::Errored => "💥",
            Standing::Skipped => "–",
        };
        writeln!(text, "- {mark} {}", markdown(&format!("{}{}", one.key, one.remark())))
            .expect("writing to a string cannot fail");
    }
    text.push('\n');
}

/// What every block came to, folded up.
fn blocks_summary(text: &mut String, report: &SuiteReport) {
    for block in report.blocks.iter().filter(|block| !block.skipped()) {
        let mark = match block.verdict() {
            None => "💥",
            Some(verdict) => verdict_mark(verdict),
        };
        let failure = render_block_failure(&report.identity, block, false);
        let result = block.result().map(render_block).unwrap_or_default();
        let said: Vec<_> =
            [failure.trim_end(), result.trim_end()].into_iter().filter(|part| !part.is_empty()).collect();
        writeln!(
            text,
            "<details><summary>{mark} {}</summary>\n\n~~~~text\n{}\n~~~~\n\n</details>\n",
            html(&block.key),
            said.join("\n\n"),
        )
        .expect("writing to a string cannot fail");
    }
}

/// Text inside an HTML element, where Markdown's escapes do not count.
fn html(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Text in which nothing means more than it says.
pub(super) fn markdown(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '<' => plain.push_str("&lt;"),
            '>' => plain.push_str("&gt;"),
            '&' => plain.push_str("&amp;"),
            '\n' | '\r' => plain.push(' '),
            '\\' | '`' | '*' | '_' | '|' | '~' | '[' | ']' | '#' => plain.extend(['\\', letter]),
            _ => plain.push(letter),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::fixture::Session;

    #[test]
    fn one_annotation_per_criterion() {
        let session = Session::new();
        insta::assert_snapshot!(annotations(&[session.report()]));
    }

    #[test]
    fn summary_in_markdown() {
        let session = Session::new();
        let summary = step_summary(&[session.report()], &session.requests);
        insta::assert_snapshot!(summary.replace(env!("CARGO_PKG_VERSION"), "[version]"));
    }
}
