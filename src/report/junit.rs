//! Results as JUnit XML, for GitLab, Jenkins and their like: one testsuite per scenario, one testcase per trial; one more
//! testsuite per kind of block.

use chrono::{DateTime, Utc};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use super::digest::Digest;
use super::experiment::render_block;
use super::failure::{render_block_failure, render_failure};
use super::gate::render_gate_report;
use super::replay::{block_command, replay_command};
use super::wording::{in_words, stopping, untested};
use super::{
    BlockReport, BlockState, GateReport, GateState, RecordedReport, SuiteReport, TrialReport, TrialState,
};
use crate::experiment::BlockResult;
use crate::judge::Verdict;
use crate::metrics;
use crate::run::Requests;

/// The report as an XML document. A failed criterion is a failure; a trial that could not run is an error.
pub fn to_junit(reports: &[SuiteReport], requests: &Requests) -> Result<String, quick_junit::SerializeError> {
    let mut document = Report::new("scenario-runner");
    if let Some(first) = reports.first() {
        document.set_timestamp(DateTime::<Utc>::from(first.started));
    }
    document.set_time(reports.iter().map(|report| report.wall_time).sum());
    for report in reports {
        document.add_test_suites(test_suites(report, requests));
    }
    document.to_string()
}

fn test_suites(report: &SuiteReport, requests: &Requests) -> Vec<TestSuite> {
    let mut suites: Vec<TestSuite> = Vec::new();
    for recorded in &report.recorded {
        let name = format!("{}.recorded", report.identity.suite);
        let suite = suite_named(&mut suites, report, &name);
        suite.time = Some(suite.time.unwrap_or_default() + recorded.wall_time);
        suite.add_test_case(recorded_case(report, recorded, &name));
    }
    for trial in &report.trials {
        let name = format!("{}.{}", report.identity.suite, trial.trial.scenario);
        let suite = suite_named(&mut suites, report, &name);
        suite.time = Some(suite.time.unwrap_or_default() + trial.wall_time);
        suite.add_test_case(test_case(report, trial, &name, requests));
    }
    for block in &report.blocks {
        let name = format!("{}.{}", report.identity.suite, block.block.kind());
        let suite = suite_named(&mut suites, report, &name);
        suite.time = Some(suite.time.unwrap_or_default() + block.wall_time);
        suite.add_test_case(block_case(report, block, &name));
    }
    for gate in &report.gates {
        let name = format!("{}.gate", report.identity.suite);
        let case = gate_case(report, gate, &name);
        suite_named(&mut suites, report, &name).add_test_case(case);
    }
    suites
}

/// The suite of that name, made if there is none.
fn suite_named<'a>(suites: &'a mut Vec<TestSuite>, report: &SuiteReport, name: &str) -> &'a mut TestSuite {
    // From the end: trials of a scenario stand together.
    let index = suites.iter().rposition(|suite| suite.name.as_str() == name).unwrap_or_else(|| {
        let mut suite = TestSuite::new(name);
        suite
            .set_timestamp(DateTime::<Utc>::from(report.started))
            .add_property(("seed", report.identity.seed.to_string().as_str()))
            .add_property(("file", report.identity.file))
            .add_property(("tool", concat!("scenario-runner ", env!("CARGO_PKG_VERSION"))));
        suites.push(suite);
        suites.len() - 1
    });
    &mut suites[index]
}

fn skipped(reason: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::skipped();
    status.set_message(reason);
    status
}

/// One that did not succeed: what it is about in a line, and all there is to say.
fn problem(kind: NonSuccessKind, name: &str, message: &str, text: String) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    status.set_message(message).set_type(name).set_description(text);
    status
}

fn test_case(report: &SuiteReport, trial: &TrialReport, class: &str, requests: &Requests) -> TestCase {
    let mut case = TestCase::new(trial.trial.key.as_str(), status(report, &trial.state));
    case.set_classname(class).set_time(trial.wall_time);
    let mut property = |name: &str, value: &str| {
        case.add_property((name, value));
    };
    property("seed", &report.identity.seed.to_string());
    property("runs", &trial.outcomes.len().to_string());
    if let Some(stopped) = trial.stopping() {
        property("stopping", &stopping(stopped));
    }
    for (index, reference) in requests.iter().enumerate() {
        let Some(metric) = metrics::metric(&reference.name) else { continue };
        property(&reference.label(), &Digest::new(metric, &trial.outcomes, index).long());
    }
    for finding in trial.findings() {
        property(&format!("criterion {}", finding.criterion), &in_words(finding));
    }
    untested(trial.findings()).iter().for_each(|warning| property("warning", warning));
    let worst = trial.findings().iter().flat_map(|finding| &finding.worst).next();
    if let Some(key) = worst.map(|run| &run.key).or(trial.trial.cases.first().map(|case| &case.key)) {
        property("replay", &replay_command(&report.identity, key));
    }
    case
}

fn status(report: &SuiteReport, state: &TrialState) -> TestCaseStatus {
    match state {
        TrialState::Skipped(reason) => skipped(&reason.to_string()),
        TrialState::Errored(message) => {
            problem(NonSuccessKind::Error, "error", first_line(message), message.clone())
        }
        TrialState::Judged(judged) if judged.verdict == Verdict::Passed => TestCaseStatus::success(),
        TrialState::Judged(judged) => {
            let text = render_failure(&report.identity, state, false);
            let failing = judged.findings.iter().filter(|finding| finding.verdict != Verdict::Passed);
            let criteria: Vec<_> = failing.map(|finding| finding.criterion.as_str()).collect();
            let kind = if judged.verdict == Verdict::Failed { "criterion" } else { "inconclusive" };
            problem(NonSuccessKind::Failure, kind, &criteria.join("; "), text)
        }
    }
}

/// A run that failed before: what was recorded of it and what is to be said now stand in properties.
fn recorded_case(report: &SuiteReport, recorded: &RecordedReport, class: &str) -> TestCase {
    let mut case = TestCase::new(recorded.key.as_str(), status(report, &recorded.trial_state()));
    case.set_classname(class).set_time(recorded.wall_time);
    case.add_property(("seed", recorded.recorded.seed.to_string().as_str()));
    case.add_property(("recorded", recorded.recorded.against.join("; ").as_str()));
    let remark = recorded.remark();
    let now = remark.trim_start_matches([':', ' ']);
    case.add_property(("now", if now.is_empty() { "still fails" } else { now }));
    case.add_property(("replay", replay_command(&report.identity, &recorded.key).as_str()));
    case
}

/// A gate: what it compared is the output of the test.
fn gate_case(report: &SuiteReport, gate: &GateReport, class: &str) -> TestCase {
    let text = render_gate_report(&report.identity, gate, false);
    let rules: Vec<_> = gate.gate.rules.iter().map(|rule| rule.text.as_str()).collect();
    let status = match &gate.state {
        GateState::Skipped(reason) => skipped(reason),
        GateState::Refused(refusal) => {
            problem(NonSuccessKind::Error, "baseline", &refusal.message, text.clone())
        }
        GateState::Judged(verdict) => match verdict.verdict {
            Verdict::Passed => TestCaseStatus::success(),
            Verdict::Inconclusive => problem(
                NonSuccessKind::Failure,
                "inconclusive",
                &verdict.blind_rules.join("; "),
                text.clone(),
            ),
            Verdict::Failed => {
                problem(NonSuccessKind::Failure, "regression", &rules.join("; "), text.clone())
            }
        },
    };
    let mut case = TestCase::new(gate.key.as_str(), status);
    case.set_classname(class);
    case.add_property(("seed", report.identity.seed.to_string().as_str()));
    case.add_property(("baseline", gate.gate.baseline.as_str()));
    if let GateState::Judged(_) = gate.state {
        case.set_system_out(text);
    }
    case
}

/// A block: its result in words is the output of the test.
fn block_case(report: &SuiteReport, block: &BlockReport, class: &str) -> TestCase {
    let text = || render_block_failure(&report.identity, block, false);
    let failure = block.result().and_then(BlockResult::failure);
    let status = match (&block.state, &failure) {
        (BlockState::Skipped(reason), _) => skipped(&reason.to_string()),
        (BlockState::Errored(message), _) => {
            problem(NonSuccessKind::Error, "error", first_line(message), text())
        }
        (BlockState::Finished(_), Some(reason)) => {
            problem(NonSuccessKind::Failure, block.block.kind(), reason, text())
        }
        (BlockState::Finished(_), None) => TestCaseStatus::success(),
    };
    let mut case = TestCase::new(block.key.as_str(), status);
    case.set_classname(class).set_time(block.wall_time);
    case.add_property(("seed", report.identity.seed.to_string().as_str()));
    case.add_property(("replay", block_command(&report.identity, &block.key).as_str()));
    if let Some(result) = block.result() {
        case.set_system_out(render_block(result));
    }
    case
}

fn first_line(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::fixture::Session;

    #[test]
    fn every_state_of_a_trial() {
        let session = Session::new();
        let xml = to_junit(&[session.report()], &session.requests).expect("the report has no odd characters");
        insta::assert_snapshot!(xml.replace(env!("CARGO_PKG_VERSION"), "[version]"));
    }
}
