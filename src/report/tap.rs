//! Results as TAP 14 (Test Anything Protocol): one test point per recorded failure, trial, block, rating and gate, with a YAML block where there is something to say.

use std::fmt::Write;
use std::io;
use std::time::Duration;

use super::controllers;
use super::experiment::render_block;
use super::failure::{render_block_failure, render_failure};
use super::gate::render_gate_report;
use super::need_every_trial;
use super::rating::render_rating;
use super::wording::{
    FOUND, in_words, interruption, several_claims, stopping, trial_warnings, verdict_word, warnings,
};
use files::escape::{tap_description, tap_text, terminal_line, yaml_quoted};
use results::{
    BlockReport, BlockState, CutBy, Finding, GateReport, GateState, NotJudged, RatingReport, RatingState,
    Results, Standing, SuiteReport, TrialState, TrialVerdict, Verdict,
};

/// Writes the report as TAP, a test point at a time. An inconclusive trial is `not ok`, and its block says so.
///
/// # Errors
/// Those of `out`; or the results do not hold every trial.
pub fn write_tap(results: &Results, out: &mut dyn io::Write) -> io::Result<()> {
    need_every_trial(results)?;
    let points = |report: &SuiteReport| {
        report.recorded.len()
            + report.trials.len()
            + report.blocks.len()
            + report.ratings.len()
            + report.gates.len()
    };
    let reports = &results.suites;
    let points: usize = reports.iter().map(points).sum();
    writeln!(out, "TAP version 14\n1..{points}")?;
    let mut points = Points { out, number: 0 };
    for report in reports {
        let identity = &report.identity;
        writeln!(
            points.out,
            "# suite {}, file {}, {}",
            terminal_line(&identity.suite),
            terminal_line(&identity.file),
            terminal_line(&identity.seed_words())
        )?;
        if let Some(said) = several_claims(report) {
            writeln!(points.out, "# {said}")?;
        }
        for tested in &report.controllers {
            let warning = tested.nondeterminism().map(|said| format!("warning: {said}"));
            for said in controllers::in_words(tested).into_iter().chain(warning) {
                writeln!(points.out, "# {}", terminal_line(&said))?;
            }
        }
        for recorded in &report.recorded {
            let (state, time) = (&recorded.trial_state(), recorded.wall_time);
            let warnings = warnings(state);
            let point = Point { key: &recorded.key, state, runs: 1, time, warnings, unjudged: false };
            points.put(|text, number| point.write(text, number, report))?;
        }
        for trial in &report.trials {
            let (runs, time) = (trial.made(), trial.wall_time);
            let (key, warnings) = (&trial.trial.key, trial_warnings(trial));
            let (state, unjudged) = (&trial.state, trial.claims_nothing());
            let point = Point { key, state, runs, time, warnings, unjudged };
            points.put(|text, number| point.write(text, number, report))?;
        }
        for block in &report.blocks {
            points.put(|text, number| block_point(text, number, report, block))?;
        }
        for rating in &report.ratings {
            points.put(|text, number| rating_point(text, number, rating))?;
        }
        for gate in &report.gates {
            points.put(|text, number| gate_point(text, number, report, gate))?;
        }
    }
    for report in reports.iter().filter(|report| report.interrupted) {
        // Whoever reads this takes the whole for failed, even if nothing was under way.
        let suite = terminal_line(&report.identity.suite);
        writeln!(points.out, "Bail out! suite {suite} {}", interruption(report))?;
    }
    Ok(())
}

/// Test points as they come.
struct Points<'o> {
    out: &'o mut dyn io::Write,
    /// Of the last one, from 1.
    number: usize,
}

impl Points<'_> {
    fn put(&mut self, write: impl FnOnce(&mut String, usize)) -> io::Result<()> {
        self.number += 1;
        let mut text = String::new();
        write(&mut text, self.number);
        self.out.write_all(text.as_bytes())
    }
}
/// The test point of a trial or of a run that failed before.
struct Point<'p> {
    key: &'p str,
    state: &'p TrialState,
    runs: usize,
    time: Duration,
    warnings: Vec<String>,
    /// Whether no criterion applies to it.
    unjudged: bool,
}

impl Point<'_> {
    fn write(&self, text: &mut String, number: usize, report: &SuiteReport) {
        let name = tap_description(self.key);
        let verdict = match self.state {
            TrialState::Skipped(reason) => {
                return line(
                    text,
                    &format!("ok {number} - {name} # SKIP {}", tap_description(&reason.to_string())),
                );
            }
            TrialState::NotFinished(cut) if cut.by() == CutBy::GateFailed => {
                return line(
                    text,
                    &format!("ok {number} - {name} # SKIP {}", tap_description(&cut.to_string())),
                );
            }
            TrialState::Judged(judged) => Some(judged.verdict),
            TrialState::Errored(_) | TrialState::NotFinished(_) => None,
        };
        let severity = match self.state {
            TrialState::NotFinished(_) => "not finished",
            _ => verdict.map_or("error", verdict_word),
        };
        let passed = verdict == Some(Verdict::Passed);
        let directive = if self.unjudged { " # SKIP not judged: no criterion applies" } else { "" };
        line(text, &format!("{} {number} - {name}{directive}", if passed { "ok" } else { "not ok" }));
        line(text, "  ---");
        if !passed {
            field(text, "severity", severity);
        }
        if let TrialState::Errored(error) = self.state
            && let Some(first) = error.faults.first()
        {
            field(text, "fault", first.fault.kind);
            field(text, "faults", error.faults.len());
            field(text, "replay", yaml_quoted(&report.identity.replay_command(&first.run)));
        }
        field(text, "runs", self.runs);
        if let TrialState::Judged(TrialVerdict { stopping: Some(stopped), .. }) = self.state {
            field(text, "stopping", stopping(stopped));
        }
        field(text, "duration_ms", self.time.as_millis());
        if let TrialState::Judged(judged) = self.state {
            let said = |finding: &Finding| format!("{} {}", finding.criterion, in_words(finding));
            let said: Vec<_> = judged.findings.iter().map(said).collect();
            if !said.is_empty() {
                block(text, "criteria", &said.join("\n"));
            }
        }
        if !self.warnings.is_empty() {
            block(text, "warning", &self.warnings.join("\n"));
        }
        if !passed {
            if let TrialState::Judged(judged) = self.state {
                let bad = judged.findings.iter().filter(|finding| finding.verdict != Verdict::Passed);
                if let Some(run) = bad.flat_map(|finding| &finding.worst).next() {
                    field(text, "replay", yaml_quoted(&report.identity.replay_command(&run.key)));
                }
            }
            block(text, "message", &render_failure(&report.identity, self.state, false));
        }
        line(text, "  ...");
    }
}

fn block_point(text: &mut String, number: usize, report: &SuiteReport, block: &BlockReport) {
    let name = tap_description(&block.key);
    if let BlockState::Skipped(reason) = &block.state {
        return line(text, &format!("ok {number} - {name} # SKIP {}", tap_description(&reason.to_string())));
    }
    let is_found = block.standing() == Standing::Found;
    let passed = is_found || block.verdict() == Some(Verdict::Passed);
    let skip = if is_found { format!(" # SKIP {FOUND}") } else { String::new() };
    line(text, &format!("{} {number} - {name}{skip}", if passed { "ok" } else { "not ok" }));
    line(text, "  ---");
    if !passed {
        let severity = match &block.state {
            BlockState::NotFinished(_) => "not finished",
            _ => block.verdict().map_or("error", verdict_word),
        };
        field(text, "severity", severity);
    }
    field(text, "duration_ms", block.wall_time.as_millis());
    if !passed {
        field(text, "replay", yaml_quoted(&report.identity.block_command(&block.key)));
        self::block(text, "message", &render_block_failure(&report.identity, block, false));
    }
    if let Some(result) = block.result() {
        self::block(text, "result", &render_block(result));
    }
    line(text, "  ...");
}

/// The test point of a rating. One that expects nothing has nothing to fail; one that expects something of cells that were left
/// out is skipped, which is not green.
fn rating_point(text: &mut String, number: usize, rating: &RatingReport) {
    let name = tap_description(&rating.key);
    match (&rating.state, rating.verdict()) {
        (RatingState::NotJudged(why), _) => {
            let why = tap_description(&why.to_string());
            return line(text, &format!("ok {number} - {name} # SKIP not judged: {why}"));
        }
        (RatingState::Rated(_), None) => {
            line(text, &format!("ok {number} - {name} # SKIP nothing is expected of the points"));
            line(text, "  ---");
        }
        (RatingState::Rated(_), Some(verdict)) => {
            let passed = verdict == Verdict::Passed;
            line(text, &format!("{} {number} - {name}", if passed { "ok" } else { "not ok" }));
            line(text, "  ---");
            if !passed {
                field(text, "severity", verdict_word(verdict));
            }
        }
    }
    block(text, "message", &render_rating(rating, false));
    line(text, "  ...");
}

fn gate_point(text: &mut String, number: usize, report: &SuiteReport, gate: &GateReport) {
    let name = tap_description(&gate.key);
    let (passed, severity) = match &gate.state {
        GateState::NotJudged(NotJudged::Broken(_)) => (false, "error"),
        GateState::NotJudged(why) => {
            let why = tap_description(&why.to_string());
            return line(text, &format!("ok {number} - {name} # SKIP not judged: {why}"));
        }
        GateState::Refused(_) => (false, "error"),
        GateState::Judged(verdict) => (verdict.verdict == Verdict::Passed, verdict_word(verdict.verdict)),
    };
    line(text, &format!("{} {number} - {name}", if passed { "ok" } else { "not ok" }));
    line(text, "  ---");
    if !passed {
        field(text, "severity", severity);
    }
    block(text, "message", &render_gate_report(&report.identity, gate, false));
    line(text, "  ...");
}

fn line(text: &mut String, content: &str) {
    text.push_str(content);
    text.push('\n');
}

fn field(text: &mut String, name: &str, value: impl std::fmt::Display) {
    writeln!(text, "  {name}: {value}").expect("writing to a string cannot fail");
}

/// A YAML literal block; its explicit indentation lets lines begin with blanks. Empty lines are indented as well, for
/// readers that take the first line without indentation for the end.
fn block(text: &mut String, name: &str, content: &str) {
    writeln!(text, "  {name}: |2-").expect("writing to a string cannot fail");
    for content in tap_text(content).lines() {
        writeln!(text, "    {}", content.trim_end()).expect("writing to a string cannot fail");
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::fixture::{Meter, Session};

    /// All of it.
    pub fn tap(results: &Results) -> String {
        let mut text = Vec::new();
        write_tap(results, &mut text).expect("there is room");
        String::from_utf8(text).expect("it is text")
    }

    #[test]
    fn every_state_of_a_trial() {
        let session = Session::new();
        insta::assert_snapshot!(tap(&session.unrecorded(session.report())));
    }

    #[test]
    fn it_is_written_point_by_point() {
        let session = Session::new();
        let mut meter = Meter::default();
        write_tap(&session.unrecorded(session.long_report()), &mut meter).unwrap();
        assert!(meter.all > 100 * meter.at_once, "{} of {} bytes at once", meter.at_once, meter.all);
    }

    #[test]
    fn the_blocks_are_yaml() {
        let session = Session::new();
        let text = tap(&session.unrecorded(session.report()));
        let mut blocks = 0;
        for part in text.split("  ---\n").skip(1) {
            let yaml = part.split("  ...\n").next().expect("a split has a first part");
            let value: serde_yaml::Value = serde_yaml::from_str(yaml).expect("the block is YAML");
            assert!(value["duration_ms"].is_number() || value["message"].is_string());
            blocks += 1;
        }
        assert_eq!(blocks, 16);
    }
}
