//! Results on GitHub: annotations at the criteria that did not hold, and the summary of a step in Markdown.

use std::fmt::Write;

use super::controllers;
use super::experiment::render_block;
use super::failure::{render_block_failure, render_failure, render_finding};
use super::figures::short_name;
use super::gate::render_gate_report;
use super::gate_markdown::gate_markdown;
use super::groups::groups;
use super::rating::{
    RatingTable, cells_in_words, points_in_words, points_rows, rating_mark, rating_notes, render_rating,
};
use super::wording::{
    FOUND, closest_calls, interruption, judged_words, nearest_run, not_as_declared, nothing_claimed,
    observed, recorded_remark, several_claims, stopping, trial_warnings, untested, verdict_mark,
    verdict_word,
};
use super::{Repository, expect_every_trial};
use files::escape::{
    github_data, github_property, html, markdown, markdown_code, markdown_fenced, terminal_line,
};
use results::{
    BlockReport, BlockState, CutBy, GateReport, GateState, NotJudged, RatingReport, RatingState,
    RecordedReport, Requests, Results, Standing, SuiteReport, TrialReport, TrialState, UnitError, Verdict,
};
use scenario::Origin;

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
/// Failures of one cause that are written out in full, and trials that could not be run.
const MOST_FAILURES: usize = 20;
/// Trials that are named where one of them stands for all.
const MOST_TRIALS_IN_GROUP: usize = 50;

/// Workflow commands such as `::error file=…,line=…::message`, one a line; files from the root of the repository on.
///
/// # Panics
/// If the results do not hold every trial.
pub fn annotations(results: &Results, repository: &Repository) -> String {
    expect_every_trial(results);
    let reports = &results.suites;
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
                // Those that somebody interrupted are counted once for the suite, and what a gate ended is told with it.
                TrialState::NotFinished(cut) if cut.by() != CutBy::TimeLimit => {}
                TrialState::NotFinished(cut) => {
                    let origin = origin.cloned().unwrap_or_else(|| beginning(report));
                    add("error", origin, "not finished".to_string(), format!("{key}: {}", cut.explained()));
                }
                TrialState::Errored(error) => {
                    let origin = origin.cloned().unwrap_or_else(|| beginning(report));
                    let (origin, title) = blamed(&error, origin);
                    add("error", origin, title, error.message);
                }
                TrialState::Judged(judged) => {
                    for finding in judged.findings.iter().filter(|one| one.untested.is_some()) {
                        let title = format!("{} untested", finding.criterion);
                        let said = untested(std::slice::from_ref(finding)).concat();
                        add("warning", finding.origin.clone(), title, format!("{key}: {said}"));
                    }
                    for said in not_as_declared(&judged) {
                        let origin = origin.cloned().unwrap_or_else(|| beginning(report));
                        add("warning", origin, "not as declared".to_string(), format!("{key}: {said}"));
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
    for trial in reports.iter().flat_map(|report| &report.trials).filter(|trial| !trial.skipped()) {
        if let Some(said) = nothing_claimed(trial) {
            let title = "not judged".to_string();
            add("warning", trial.trial.origin.clone(), title, format!("{}: {said}", trial.trial.key));
        }
        for said in &trial.departures {
            let title = "another model than was published".to_string();
            add("warning", trial.trial.origin.clone(), title, format!("{}: {said}", trial.trial.key));
        }
    }
    for tested in reports.iter().flat_map(|report| &report.controllers) {
        if let Some(said) = tested.nondeterminism() {
            add("warning", tested.declared.clone(), "not deterministic".to_string(), said);
        }
    }
    for (report, block) in reports.iter().flat_map(|one| one.blocks.iter().map(move |block| (one, block))) {
        let title = format!("{} {}", block.block.kind(), block.block.name());
        let (level, said, what) = match &block.state {
            BlockState::Skipped(_) | BlockState::NotFinished(_) => continue,
            BlockState::Errored(error) => ("error", "could not run", error.message.clone()),
            BlockState::Finished(result) => match result.failure() {
                Some(reason) if result.verdict() == Some(Verdict::Inconclusive) => {
                    ("warning", "inconclusive", reason)
                }
                Some(reason) => ("error", "failed", reason),
                None => continue,
            },
        };
        let again = report.identity.block_command(&block.key);
        add(level, block.block.origin().clone(), format!("{title} {said}"), format!("{what}\n{again}"));
    }
    for (report, gate) in reports.iter().flat_map(|one| one.gates.iter().map(move |gate| (one, gate))) {
        let (level, what) = match &gate.state {
            GateState::NotJudged(NotJudged::NotSelected) => continue,
            GateState::NotJudged(_) => ("warning", "is not judged"),
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
    for rating in reports.iter().flat_map(|one| &one.ratings) {
        let (level, what) = match rating.verdict() {
            Some(Verdict::Passed) => continue,
            Some(Verdict::Failed) => ("error", "failed"),
            Some(Verdict::Inconclusive) => ("warning", "inconclusive"),
            None if rating.is_open() => ("warning", "is not judged"),
            None => continue,
        };
        let title = format!("rating {} {what}", rating.rating.name);
        add(level, rating.rating.origin.clone(), title, render_rating(rating, false));
    }
    for report in reports.iter().filter(|report| report.interrupted) {
        let title = format!("suite {} interrupted", report.identity.suite);
        add("error", beginning(report), title, interruption(report));
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
            github_property(&repository.path(&origin.file)),
            origin.line,
            origin.column,
            github_property(&title),
            github_data(&message),
        )
        .expect("writing to a string cannot fail");
    }
    text
}

/// Where to point at for what could not be run, and what to call it: the declaration of a program that is to blame.
fn blamed(error: &UnitError, otherwise: Origin) -> (Origin, String) {
    let program = error.faults.first().map(|one| &one.fault).filter(|fault| fault.declared.line > 0);
    match program {
        Some(fault) => {
            ((*fault.declared).clone(), format!("controller {}: {}", fault.controller, fault.kind))
        }
        None => (otherwise, "could not run".to_string()),
    }
}

/// Where a suite is said to have failed of which no line is to blame.
fn beginning(report: &SuiteReport) -> Origin {
    Origin { file: report.identity.file.as_str().into(), line: 1, column: 1, ..Origin::default() }
}

/// The summary of a step in GitHub's Markdown.
///
/// # Panics
/// If the results do not hold every trial.
pub fn step_summary(results: &Results) -> String {
    expect_every_trial(results);
    let Results { requests, suites: reports, recordings: _, denies_untested: _ } = results;
    let mut text = String::new();
    for report in reports {
        suite_summary(&mut text, report, requests);
        report.ratings.iter().for_each(|rating| text += &rating_markdown(rating));
        for gate in &report.gates {
            text += &match &gate.state {
                GateState::Judged(verdict) => {
                    gate_markdown(verdict, &|key| Some(report.identity.replay_command(key)))
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
                GateState::NotJudged(why) => {
                    let (gate, why) = (markdown(&gate.gate.name), markdown(&why.to_string()));
                    format!("### ❔ {gate}: not judged\n\n{why}\n")
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

/// A rating: its table of cells, its points and what there is to know besides.
fn rating_markdown(report: &RatingReport) -> String {
    let (mark, word) = rating_mark(report);
    let mut text = format!("### {mark} {}: {word}\n\n", markdown(&report.rating.name));
    let result = match &report.state {
        RatingState::Rated(result) => result,
        RatingState::NotJudged(why) => {
            text += &format!("{}\n\n", markdown(&why.to_string()));
            return text;
        }
    };
    text += &format!("{}; {}\n\n", points_in_words(result), markdown(&cells_in_words(&report.rating)));
    let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let table = RatingTable::new(&report.rating, result);
    text += &row(table.headings.iter().map(|heading| markdown(heading)).collect());
    text += &format!("|---|{}\n", "--:|".repeat(table.headings.len() - 1));
    for line in &table.rows {
        let cells =
            line.cells.iter().map(|cell| cell.as_ref().map_or(String::new(), |cell| cell.text.clone()));
        text += &row([markdown(&line.name)].into_iter().chain(cells).collect());
    }
    text += "\n| tag | points | of | by |\n|---|--:|--:|---|\n";
    for [tag, points, maximum, how] in points_rows(&report.rating, result) {
        text += &row(vec![markdown(&tag), points, maximum, how]);
    }
    text.push('\n');
    rating_notes(&report.rating, result).iter().for_each(|note| text += &format!("- {}\n", markdown(note)));
    text.push('\n');
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
    let ratings = report.ratings.iter().map(RatingReport::standing);
    let gates = report.gates.iter().map(GateReport::standing);
    let standings: Vec<_> = recorded.chain(trials).chain(blocks).chain(ratings).chain(gates).collect();
    let count = |wanted| standings.iter().filter(|standing| **standing == wanted).count();
    let runs: usize = report.trials.iter().map(TrialReport::made).sum();
    let counts = [
        (count(Standing::Judged(Verdict::Passed)), "✅", "passed"),
        (count(Standing::Judged(Verdict::Failed)), "❌", "failed"),
        (count(Standing::Judged(Verdict::Inconclusive)), "❔", "inconclusive"),
        (count(Standing::NotJudged), "–", "not judged"),
        (count(Standing::Found), "–", FOUND),
        (count(Standing::Errored), "💥", "could not run"),
        (
            standings.iter().filter(|standing| matches!(standing, Standing::NotFinished(_))).count(),
            "⏹",
            "not finished",
        ),
    ];
    let mut said: Vec<_> = counts
        .iter()
        .filter(|(number, ..)| *number > 0)
        .map(|(number, mark, word)| format!("{number} {mark} {word}"))
        .collect();
    let identity = &report.identity;
    if report.interrupted {
        said.push(format!("⏹ {}", interruption(report)));
    }
    line(format!("## {}: {}\n", markdown(&identity.suite), said.join(", ")));
    let trials = report.trials.iter().filter(|trial| !trial.skipped()).count();
    let made = match report.evaluations() {
        0 => format!("{trials} trials, {runs} runs"),
        evaluations if trials == 0 => format!("{evaluations} evaluations"),
        evaluations => format!("{trials} trials, {runs} runs, {evaluations} evaluations"),
    };
    line(format!(
        "{}, {}, {made}, {:.1} s, scenario-runner {}\n",
        markdown_code(&identity.file),
        markdown(&identity.seed_words()),
        report.wall_time.as_secs_f64(),
        markdown(&report.program.version),
    ));
    if let Some(said) = several_claims(report) {
        line(format!("{}\n", markdown(&said)));
    }
    for tested in &report.controllers {
        let warning = tested.nondeterminism().map(|said| format!("⚠ {said}"));
        for said in controllers::in_words(tested).into_iter().chain(warning) {
            line(format!("{}\n", markdown(&said)));
        }
    }
    let summary = report.summary();
    for (name, trials) in report.scenarios() {
        let numbers: Vec<_> = summary.scenarios.iter().filter(|one| one.scenario == name).collect();
        let trials: Vec<_> = trials.into_iter().filter(|trial| !trial.skipped()).collect();
        if trials.is_empty() {
            continue;
        }
        let columns = super::table::columns(&numbers, requests);
        let mut heading = format!("| {} | |", markdown(name));
        let mut rule = "|---|---|".to_string();
        for column in &columns {
            let (label, below) = column.heading();
            write!(heading, " {}<br><sub>{}</sub> |", markdown(&label), markdown(&below))
                .expect("writing to a string cannot fail");
            rule.push_str("--:|");
        }
        line(heading);
        line(rule);
        for trial in &trials {
            let mut mark = match trial.verdict() {
                None if matches!(trial.state, TrialState::NotFinished(_)) => "⏹ not finished".to_string(),
                None => "💥 error".to_string(),
                Some(_) => {
                    judged_words(trial).map_or_else(String::new, |(word, mark)| format!("{mark} {word}"))
                }
            };
            if let Some(stopped) = trial.stopping() {
                mark += &format!("<br><sub>{}</sub>", markdown(&stopping(stopped)));
            }
            let mut row = format!("| {} | {mark} |", markdown(&short_name(trial)));
            for column in &columns {
                write!(row, " {} |", markdown(&column.cell(trial))).expect("writing to a string cannot fail");
            }
            line(row);
        }
        line(String::new());
        let calls = closest_calls(&numbers);
        let warnings = trials.iter().flat_map(|trial| {
            let key = &trial.trial.key;
            trial_warnings(trial).into_iter().map(move |warning| format!("⚠️ {key}: {warning}"))
        });
        let notes: Vec<_> = calls.into_iter().chain(warnings).collect();
        notes.iter().for_each(|note| line(format!("- {}", markdown(note))));
        if !notes.is_empty() {
            line(String::new());
        }
    }
    failures_summary(text, report);
    blocks_summary(text, report);
    recorded_summary(text, report);
}

/// What did not hold, a cause at a time, worst first; then what could not be run.
fn failures_summary(text: &mut String, report: &SuiteReport) {
    let identity = &report.identity;
    let groups = groups(report);
    let errors: Vec<_> = report
        .trials
        .iter()
        .filter(|trial| match &trial.state {
            TrialState::Errored(_) => true,
            TrialState::NotFinished(cut) => cut.by() != CutBy::GateFailed,
            TrialState::Judged(_) | TrialState::Skipped(_) => false,
        })
        .collect();
    for group in groups.iter().take(MOST_FAILURES) {
        let title = match group.trials[..] {
            [only] => format!("{only}: {}", group.criterion),
            _ => format!("{}/{}: {} {}", identity.suite, group.scenario, group.criterion, group.in_words()),
        };
        let mut body = render_finding(identity, group.worst.1, false);
        if group.trials.len() > 1 {
            let others: Vec<_> = group.trials.iter().filter(|key| **key != group.worst.0).copied().collect();
            let named = others.iter().take(MOST_TRIALS_IN_GROUP).map(|key| format!("\n  {key}"));
            body += &format!("\n\nthis is {}; the others are{}", group.worst.0, named.collect::<String>());
            if others.len() > MOST_TRIALS_IN_GROUP {
                body += &format!("\n  and {} more", others.len() - MOST_TRIALS_IN_GROUP);
            }
        }
        folded(text, &title, &body);
    }
    for trial in errors.iter().take(MOST_FAILURES) {
        folded(text, &trial.trial.key, &render_failure(identity, &trial.state, false));
    }
    let more = groups.len().saturating_sub(MOST_FAILURES) + errors.len().saturating_sub(MOST_FAILURES);
    if more > 0 {
        text.push_str(&format!("and {more} more that did not pass\n\n"));
    }
}

fn folded(text: &mut String, title: &str, body: &str) {
    text.push_str(&format!("<details><summary>{}</summary>\n\n", html(&terminal_line(title))));
    text.push_str(&markdown_fenced(body));
    text.push_str("\n</details>\n\n");
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
            Standing::NotJudged | Standing::Found => "–",
            Standing::Errored => "💥",
            Standing::NotFinished(_) => "⏹",
            Standing::Skipped => "–",
        };
        writeln!(text, "- {mark} {}", markdown(&format!("{}{}", one.key, recorded_remark(one))))
            .expect("writing to a string cannot fail");
    }
    text.push('\n');
}

/// What every block came to, folded up.
fn blocks_summary(text: &mut String, report: &SuiteReport) {
    for block in report.blocks.iter().filter(|block| !block.skipped()) {
        let mark = match block.standing() {
            Standing::NotFinished(_) => "⏹",
            Standing::Errored => "💥",
            Standing::Judged(verdict) => verdict_mark(verdict),
            Standing::Found | Standing::NotJudged | Standing::Skipped => "–",
        };
        let failure = render_block_failure(&report.identity, block, false);
        let result = block.result().map(render_block).unwrap_or_default();
        let said: Vec<_> =
            [failure.trim_end(), result.trim_end()].into_iter().filter(|part| !part.is_empty()).collect();
        writeln!(
            text,
            "<details><summary>{mark} {}</summary>\n\n{}\n</details>\n",
            html(&terminal_line(&block.key)),
            markdown_fenced(&said.join("\n\n")),
        )
        .expect("writing to a string cannot fail");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Session;

    #[test]
    fn one_annotation_per_criterion() {
        let session = Session::new();
        let repository =
            Repository::around(std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")));
        insta::assert_snapshot!(annotations(&session.unrecorded(session.report()), &repository));
    }

    #[test]
    fn summary_in_markdown() {
        let session = Session::new();
        let summary = step_summary(&session.unrecorded(session.report()));
        insta::assert_snapshot!(summary.replace(env!("CARGO_PKG_VERSION"), "[version]"));
    }
}
