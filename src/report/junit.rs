//! Results as JUnit XML, for GitLab, Jenkins and their like: one testsuite per scenario, one testcase per trial; one more
//! testsuite per kind of block.

use chrono::{DateTime, Utc};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use super::digest::Digest;
use super::experiment::render_block;
use super::failure::{render_block_failure, render_failure};
use super::gate::{blindness as gate_blindness, render_gate_report};
use super::replay::{block_command, replay_command};
use super::wording::{in_words, interruption, stopping, trial_warnings};
use super::{
    BlockReport, BlockState, Cut, CutBy, GateReport, GateState, NotJudged, RecordedReport, Repository,
    SuiteReport, TrialReport, TrialState,
};
use crate::escape::{xml, xml_line};
use crate::experiment::BlockResult;
use crate::judge::Verdict;
use crate::metrics;
use crate::run::Requests;
use crate::scenario::Origin;

/// The report as an XML document. A failed criterion is a failure; a trial that could not run is an error.
/// Every testcase says where it stands, in `file` and `line`, from the root of the repository on.
pub fn to_junit(
    reports: &[SuiteReport],
    requests: &Requests,
    repository: &Repository,
) -> Result<String, quick_junit::SerializeError> {
    let mut document = Report::new("scenario-runner");
    if let Some(first) = reports.first() {
        document.set_timestamp(DateTime::<Utc>::from(first.started));
    }
    document.set_time(reports.iter().map(|report| report.wall_time).sum());
    for report in reports {
        document.add_test_suites(test_suites(report, requests, repository));
    }
    document.to_string()
}

fn test_suites(report: &SuiteReport, requests: &Requests, repository: &Repository) -> Vec<TestSuite> {
    let mut suites: Vec<TestSuite> = Vec::new();
    for recorded in &report.recorded {
        let name = format!("{}.recorded", report.identity.suite);
        let suite = suite_named(&mut suites, report, &name);
        suite.time = Some(suite.time.unwrap_or_default() + recorded.wall_time);
        let case = recorded_case(report, recorded, &name);
        let declared = report.trials.iter().find(|one| one.trial.scenario == recorded.recorded.scenario);
        suite.add_test_case(placed(case, declared.map(|one| &one.trial.origin), repository));
    }
    for trial in &report.trials {
        let name = format!("{}.{}", report.identity.suite, trial.trial.scenario);
        let suite = suite_named(&mut suites, report, &name);
        suite.time = Some(suite.time.unwrap_or_default() + trial.wall_time);
        let case = test_case(report, trial, &name, requests);
        suite.add_test_case(placed(case, Some(&trial.trial.origin), repository));
    }
    for block in &report.blocks {
        let name = format!("{}.{}", report.identity.suite, block.block.kind());
        let suite = suite_named(&mut suites, report, &name);
        suite.time = Some(suite.time.unwrap_or_default() + block.wall_time);
        let case = block_case(report, block, &name);
        suite.add_test_case(placed(case, Some(block.block.origin()), repository));
    }
    for gate in &report.gates {
        let name = format!("{}.gate", report.identity.suite);
        let case = placed(gate_case(report, gate, &name), Some(&gate.gate.origin), repository);
        suite_named(&mut suites, report, &name).add_test_case(case);
    }
    if report.interrupted {
        // An error of its own: should nothing have been under way, there would be none, and a CI would show green.
        let name = report.identity.suite;
        let message = interruption(report);
        let status = problem(NonSuccessKind::Error, CutBy::Interrupted.word(), &message, message.clone());
        let mut case = TestCase::new(format!("{name}/interrupted"), status);
        case.set_classname(name);
        suite_named(&mut suites, report, name).add_test_case(case);
    }
    suites
}

/// With the place where it is declared, if that is known.
fn placed(mut case: TestCase, origin: Option<&Origin>, repository: &Repository) -> TestCase {
    if let Some(origin) = origin.filter(|origin| !origin.file.is_empty()) {
        case.extra.insert("file".into(), xml_line(&repository.path(&origin.file)).into());
        case.extra.insert("line".into(), origin.line.to_string().into());
    }
    case
}

/// The suite of that name, made if there is none.
fn suite_named<'a>(suites: &'a mut Vec<TestSuite>, report: &SuiteReport, name: &str) -> &'a mut TestSuite {
    // From the end: trials of a scenario stand together.
    let index = suites.iter().rposition(|suite| suite.name.as_str() == xml_line(name)).unwrap_or_else(|| {
        let mut suite = TestSuite::new(xml_line(name));
        suite
            .set_timestamp(DateTime::<Utc>::from(report.started))
            .add_property(("seed", report.identity.seed.to_string().as_str()))
            .add_property(("file", xml_line(report.identity.file).as_str()))
            .add_property(("tool", concat!("scenario-runner ", env!("CARGO_PKG_VERSION"))));
        if report.interrupted {
            suite.add_property(("interrupted", interruption(report).as_str()));
        }
        report.identity.set.iter().for_each(|set| _ = suite.add_property(("set", set.as_str())));
        suites.push(suite);
        suites.len() - 1
    });
    &mut suites[index]
}

/// One that was cut off: what is known of it is no result.
fn not_finished(cut: &Cut) -> TestCaseStatus {
    problem(NonSuccessKind::Error, cut.by().word(), &cut.to_string(), cut.explained())
}

fn skipped(reason: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::skipped();
    status.set_message(xml_line(reason));
    status
}

/// One that did not succeed: what it is about in a line, and all there is to say.
fn problem(kind: NonSuccessKind, name: &str, message: &str, text: String) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    status.set_message(xml_line(message)).set_type(name).set_description(xml(&text));
    status
}

fn test_case(report: &SuiteReport, trial: &TrialReport, class: &str, requests: &Requests) -> TestCase {
    let mut case = TestCase::new(xml_line(&trial.trial.key), status(report, &trial.state));
    case.set_classname(xml_line(class)).set_time(trial.wall_time);
    let mut property = |name: &str, value: &str| {
        case.add_property((xml_line(name).as_str(), xml_line(value).as_str()));
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
    trial_warnings(trial).iter().for_each(|warning| property("warning", warning));
    let worst = trial.findings().iter().flat_map(|finding| &finding.worst).next();
    if let Some(key) = worst.map(|run| &run.key).or(trial.trial.cases.first().map(|case| &case.key)) {
        property("replay", &replay_command(&report.identity, key));
    }
    case
}

fn status(report: &SuiteReport, state: &TrialState) -> TestCaseStatus {
    match state {
        TrialState::Skipped(reason) => skipped(&reason.to_string()),
        TrialState::NotFinished(cut) => not_finished(cut),
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
    let mut case = TestCase::new(xml_line(&recorded.key), status(report, &recorded.trial_state()));
    case.set_classname(xml_line(class)).set_time(recorded.wall_time);
    case.add_property(("seed", recorded.recorded.seed.to_string().as_str()));
    case.add_property(("recorded", xml_line(&recorded.recorded.against.join("; ")).as_str()));
    let remark = recorded.remark();
    let now = remark.trim_start_matches([':', ' ']);
    case.add_property(("now", xml_line(if now.is_empty() { "still fails" } else { now }).as_str()));
    case.add_property(("replay", xml_line(&replay_command(&report.identity, &recorded.key)).as_str()));
    case
}

/// A gate: what it compared is the output of the test.
fn gate_case(report: &SuiteReport, gate: &GateReport, class: &str) -> TestCase {
    let text = render_gate_report(&report.identity, gate, false);
    let status = match &gate.state {
        GateState::NotJudged(NotJudged::Broken(why)) => {
            problem(NonSuccessKind::Error, "error", first_line(why), why.clone())
        }
        GateState::NotJudged(why) => skipped(&why.to_string()),
        GateState::Refused(refusal) => {
            problem(NonSuccessKind::Error, "baseline", &refusal.message, text.clone())
        }
        GateState::Judged(verdict) => match verdict.verdict {
            Verdict::Passed => TestCaseStatus::success(),
            Verdict::Inconclusive => problem(
                NonSuccessKind::Failure,
                "inconclusive",
                &gate_blindness(verdict).join("; "),
                text.clone(),
            ),
            Verdict::Failed => {
                problem(NonSuccessKind::Failure, "regression", &verdict.rules.join("; "), text.clone())
            }
        },
    };
    let mut case = TestCase::new(xml_line(&gate.key), status);
    case.set_classname(xml_line(class));
    case.add_property(("seed", report.identity.seed.to_string().as_str()));
    case.add_property(("baseline", xml_line(&gate.gate.baseline).as_str()));
    if let GateState::Judged(_) = gate.state {
        case.set_system_out(xml(&text));
    }
    case
}

/// A block: its result in words is the output of the test.
fn block_case(report: &SuiteReport, block: &BlockReport, class: &str) -> TestCase {
    let text = || render_block_failure(&report.identity, block, false);
    let failure = block.result().and_then(BlockResult::failure);
    let status = match (&block.state, &failure) {
        (BlockState::Skipped(reason), _) => skipped(&reason.to_string()),
        (BlockState::NotFinished(cut), _) => not_finished(cut),
        (BlockState::Errored(message), _) => {
            problem(NonSuccessKind::Error, "error", first_line(message), text())
        }
        (BlockState::Finished(_), Some(reason)) => {
            problem(NonSuccessKind::Failure, block.block.kind(), reason, text())
        }
        (BlockState::Finished(_), None) => TestCaseStatus::success(),
    };
    let mut case = TestCase::new(xml_line(&block.key), status);
    case.set_classname(xml_line(class)).set_time(block.wall_time);
    case.add_property(("seed", report.identity.seed.to_string().as_str()));
    case.add_property(("replay", xml_line(&block_command(&report.identity, &block.key)).as_str()));
    if let Some(result) = block.result() {
        case.set_system_out(xml(&render_block(result)));
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
        let repository = Repository::around(std::path::Path::new(env!("CARGO_MANIFEST_DIR")));
        let xml = to_junit(&[session.report()], &session.requests, &repository)
            .expect("the report has no odd characters");
        insta::assert_snapshot!(xml.replace(env!("CARGO_PKG_VERSION"), "[version]"));
    }
}
