//! Results as JUnit XML, for GitLab, Jenkins and their like: one testsuite per scenario, one testcase per trial; one more
//! testsuite per kind of block.

mod document;

use std::collections::HashMap;
use std::io::{self, Write};
use std::time::Duration;

use self::document::{Counts, JunitReport, Problem, TestCase, TestOutcome, TestSuite};
use super::controllers;
use super::digest::{Digest, written_unit};
use super::experiment::render_block;
use super::failure::{render_block_failure, render_failure};
use super::gate::{blindness as gate_blindness, render_gate_report};
use super::rating::{points_rows, render_rating};
use super::wording::{
    FOUND, in_words, interruption, nothing_claimed, recorded_remark, several_claims, stopping, trial_warnings,
};
use super::{Repository, need_every_trial};
use results::{
    BlockReport, BlockResult, BlockState, Cut, CutBy, EstimateResult, GateReport, GateState, NotJudged,
    RatingReport, RatingState, RecordedReport, RecordedState, Requests, Results, SuiteReport, TrialReport,
    TrialState, UnitError, Verdict,
};
use scenario::{FaultKind, Origin};

/// Writes the report as an XML document, a testcase at a time. A failed criterion is a failure; a trial that could not run
/// is an error. Every testcase says where it stands, in `file` and `line`, from the root of the repository on.
///
/// # Errors
/// Those of `out`; or the results do not hold every trial.
pub fn write_junit(results: &Results, repository: &Repository, out: &mut dyn Write) -> io::Result<()> {
    need_every_trial(results)?;
    let Results { requests, suites: reports, recordings: _, denies_untested: _ } = results;
    let suites: Vec<_> = reports.iter().map(|report| (report, grouped(report))).collect();
    let mut counts = Counts::default();
    for item in suites.iter().flat_map(|(_, groups)| groups).flat_map(|group| &group.items) {
        counts.add(item.kind());
    }
    let time = reports.iter().map(|report| report.wall_time).sum();
    let started = reports.first().map(|report| report.started);
    let mut document = JunitReport::begin(out, counts, started, time)?;
    for (report, groups) in &suites {
        for group in groups {
            let mut counts = Counts::default();
            group.items.iter().for_each(|item| counts.add(item.kind()));
            let time = group.items.iter().filter_map(Item::time).reduce(|sum, time| sum + time);
            let properties = suite_properties(report);
            document.suite(&TestSuite {
                name: &group.name,
                counts,
                started: report.started,
                time,
                properties,
            })?;
            for item in &group.items {
                document.case(&item.case(report, &group.name, requests, repository))?;
            }
            document.end_suite()?;
        }
    }
    document.end()
}

/// What has a testcase of its own.
enum Item<'r> {
    Recorded(&'r RecordedReport),
    Trial(&'r TrialReport),
    Block(&'r BlockReport),
    Rating(&'r RatingReport),
    Gate(&'r GateReport),
    /// Should nothing have been under way when somebody interrupted it, there would be no error, and a CI would show green.
    Interruption,
}

/// What belongs to one testsuite.
struct Group<'r> {
    name: String,
    items: Vec<Item<'r>>,
}

/// The testsuites of a suite, in the order of what comes first in each.
fn grouped<'r>(report: &'r SuiteReport) -> Vec<Group<'r>> {
    let suite = &report.identity.suite;
    let mut groups: Vec<Group> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut put = |name: String, item: Item<'r>| {
        let place = *places.entry(name).or_insert_with_key(|name| {
            groups.push(Group { name: name.clone(), items: Vec::new() });
            groups.len() - 1
        });
        groups[place].items.push(item);
    };
    report.recorded.iter().for_each(|one| put(format!("{suite}.recorded"), Item::Recorded(one)));
    report.trials.iter().for_each(|one| put(format!("{suite}.{}", one.trial.scenario), Item::Trial(one)));
    report.blocks.iter().for_each(|one| put(format!("{suite}.{}", one.block.kind()), Item::Block(one)));
    report.ratings.iter().for_each(|one| put(format!("{suite}.rating"), Item::Rating(one)));
    report.gates.iter().for_each(|one| put(format!("{suite}.gate"), Item::Gate(one)));
    if report.interrupted {
        put(suite.to_string(), Item::Interruption);
    }
    groups
}

fn suite_properties(report: &SuiteReport) -> Vec<(String, String)> {
    let mut properties = vec![
        ("seed".to_string(), report.identity.seed.to_string()),
        ("file".to_string(), report.identity.file.to_string()),
        ("tool".to_string(), format!("scenario-runner {}", report.program.version)),
    ];
    properties.extend(report.identity.tried_words().map(|tried| ("seeds".to_string(), tried)));
    properties.extend(several_claims(report).map(|said| ("claims".to_string(), said)));
    if report.interrupted {
        properties.push(("interrupted".to_string(), interruption(report)));
    }
    for tested in &report.controllers {
        let said = [("controller", controllers::in_words(tested)), ("warning", tested.nondeterminism())];
        properties.extend(said.into_iter().filter_map(|(name, said)| Some((name.to_string(), said?))));
    }
    properties.extend(report.identity.set.iter().map(|set| ("set".to_string(), set.clone())));
    properties.extend(report.identity.tested.iter().map(|one| ("tested".to_string(), one.to_string())));
    properties
}

impl Item<'_> {
    /// What it counts as.
    fn kind(&self) -> TestOutcome {
        match self {
            Self::Recorded(recorded) => kind_of(&recorded.trial_state()),
            Self::Trial(trial) if trial.claims_nothing() => TestOutcome::Skipped,
            Self::Trial(trial) => kind_of(&trial.state),
            Self::Block(block) => match &block.state {
                BlockState::Skipped(_) => TestOutcome::Skipped,
                BlockState::NotFinished(_) | BlockState::Errored(_) => TestOutcome::Error,
                BlockState::Finished(result) => match result.verdict() {
                    Some(Verdict::Passed) => TestOutcome::Passed,
                    Some(Verdict::Inconclusive | Verdict::Failed) => TestOutcome::Failure,
                    None => TestOutcome::Skipped,
                },
            },
            Self::Rating(rating) => match rating.verdict() {
                Some(Verdict::Passed) => TestOutcome::Passed,
                Some(Verdict::Inconclusive | Verdict::Failed) => TestOutcome::Failure,
                None => TestOutcome::Skipped,
            },
            Self::Gate(gate) => match &gate.state {
                GateState::NotJudged(NotJudged::Broken(_)) | GateState::Refused(_) => TestOutcome::Error,
                GateState::NotJudged(_) => TestOutcome::Skipped,
                GateState::Judged(verdict) if verdict.verdict == Verdict::Passed => TestOutcome::Passed,
                GateState::Judged(_) => TestOutcome::Failure,
            },
            Self::Interruption => TestOutcome::Error,
        }
    }

    fn time(&self) -> Option<Duration> {
        match self {
            Self::Recorded(recorded) => Some(recorded.wall_time),
            Self::Trial(trial) => Some(trial.wall_time),
            Self::Block(block) => Some(block.wall_time),
            Self::Rating(_) | Self::Gate(_) | Self::Interruption => None,
        }
    }

    fn case(
        &self,
        report: &SuiteReport,
        class: &str,
        requests: &Requests,
        repository: &Repository,
    ) -> TestCase {
        let mut case = match self {
            Self::Recorded(recorded) => recorded_case(report, recorded),
            Self::Trial(trial) => trial_case(report, trial, requests),
            Self::Block(block) => block_case(report, block),
            Self::Rating(rating) => rating_case(report, rating),
            Self::Gate(gate) => gate_case(report, gate),
            Self::Interruption => interruption_case(report),
        };
        case.class = class.to_string();
        case.kind = self.kind();
        case.time = self.time();
        let origin = self.origin(report).filter(|origin| !origin.file.is_empty());
        case.place = origin.map(|origin| (repository.path(&origin.file), origin.line));
        case
    }

    /// Where it is declared, if that is known.
    fn origin<'o>(&'o self, report: &'o SuiteReport) -> Option<&'o Origin> {
        match self {
            Self::Recorded(recorded) => {
                let is_its_own = |one: &&TrialReport| one.trial.scenario == recorded.recorded.scenario;
                report.trials.iter().find(is_its_own).map(|one| &one.trial.origin)
            }
            Self::Trial(trial) => Some(&trial.trial.origin),
            Self::Block(block) => Some(block.block.origin()),
            Self::Rating(rating) => Some(&rating.rating.origin),
            Self::Gate(gate) => Some(&gate.gate.origin),
            Self::Interruption => None,
        }
    }
}

fn kind_of(state: &TrialState) -> TestOutcome {
    match state {
        TrialState::Skipped(_) => TestOutcome::Skipped,
        TrialState::NotFinished(cut) if cut.by() == CutBy::GateFailed => TestOutcome::Skipped,
        TrialState::NotFinished(_) | TrialState::Errored(_) => TestOutcome::Error,
        TrialState::Judged(judged) if judged.verdict == Verdict::Passed => TestOutcome::Passed,
        TrialState::Judged(_) => TestOutcome::Failure,
    }
}

/// One that was cut off: what is known of it is no result.
fn not_finished(cut: &Cut) -> Problem {
    Problem::new(cut.by().word(), &cut.to_string(), cut.explained())
}

fn trial_case(report: &SuiteReport, trial: &TrialReport, requests: &Requests) -> TestCase {
    let problem = if trial.claims_nothing() {
        let reason = nothing_claimed(trial);
        Some(Problem::skipped(reason.as_deref().unwrap_or("not judged: its scenario has no criterion")))
    } else {
        problem(report, &trial.state)
    };
    let mut case = TestCase::new(&trial.trial.key, problem);
    case.property("seed", &report.identity.seed.to_string());
    case.property("runs", &trial.made().to_string());
    case.errors = trial.error().and_then(log_tail);
    if let Some(stopped) = trial.stopping() {
        case.property("stopping", &stopping(stopped));
    }
    for (index, reference) in requests.iter().enumerate() {
        let Some(metric) = reference.known() else { continue };
        let unit = written_unit(trial.trial.criteria.iter(), reference, metric);
        case.property(&reference.label(), &Digest::new(metric, unit, &trial.outcomes, index).long());
    }
    for finding in trial.findings() {
        case.property(&format!("criterion {}", finding.criterion), &in_words(finding));
    }
    trial_warnings(trial).iter().for_each(|warning| case.property("warning", warning));
    let worst = trial.findings().iter().flat_map(|finding| &finding.worst).next();
    if let Some(key) = Some(worst.map_or(&trial.trial.first_run, |run| &run.key)) {
        case.property("replay", &report.identity.replay_command(key));
    }
    case
}

/// What there is to say of a trial that did not pass.
fn problem(report: &SuiteReport, state: &TrialState) -> Option<Problem> {
    Some(match state {
        TrialState::Skipped(reason) => Problem::skipped(&reason.to_string()),
        // The gate is the test that fails.
        TrialState::NotFinished(cut) if cut.by() == CutBy::GateFailed => Problem::skipped(&cut.to_string()),
        TrialState::NotFinished(cut) => not_finished(cut),
        TrialState::Errored(error) => errored(error, error.message.clone()),
        TrialState::Judged(judged) if judged.verdict == Verdict::Passed => return None,
        TrialState::Judged(judged) => {
            let failing = judged.findings.iter().filter(|finding| finding.verdict != Verdict::Passed);
            let criteria: Vec<_> = failing.map(|finding| finding.criterion.as_str()).collect();
            let name = if judged.verdict == Verdict::Failed { "criterion" } else { "inconclusive" };
            Problem::new(name, &criteria.join("; "), render_failure(&report.identity, state, false))
        }
    })
}

/// What could not be run to its end; one that a program is to blame for is of a type of its own.
fn errored(error: &UnitError, text: String) -> Problem {
    let kind = error.faults.first().map_or("error", |one| match one.fault.kind {
        FaultKind::Exited => "controller-exited",
        FaultKind::Timeout => "controller-timeout",
        FaultKind::Garbage => "controller-garbage",
        FaultKind::BadValue => "controller-bad_value",
        FaultKind::Refused => "controller-refused",
        FaultKind::OnlyTogether => "controller-only_together",
    });
    Problem::new(kind, error.first_line(), text)
}

/// The end of a program's log, if it is to blame.
fn log_tail(error: &UnitError) -> Option<String> {
    let fault = &error.faults.first()?.fault;
    (!fault.log_tail.is_empty()).then(|| fault.log_tail.join("\n"))
}

/// A run that failed before: what was recorded of it and what is to be said now stand in properties.
fn recorded_case(report: &SuiteReport, recorded: &RecordedReport) -> TestCase {
    let mut case = TestCase::new(&recorded.key, problem(report, &recorded.trial_state()));
    case.errors = match &recorded.state {
        RecordedState::Errored(error) => log_tail(error),
        _ => None,
    };
    case.property("seed", &recorded.recorded.seed.to_string());
    case.property("recorded", &recorded.recorded.against.join("; "));
    let remark = recorded_remark(recorded);
    let now = remark.trim_start_matches([':', ' ']);
    case.property("now", if now.is_empty() { "still fails" } else { now });
    case.property("replay", &report.identity.replay_command(&recorded.key));
    case
}

/// A rating: its table is the output of the test.
fn rating_case(report: &SuiteReport, rating: &RatingReport) -> TestCase {
    let text = render_rating(rating, false);
    let result = match &rating.state {
        RatingState::Rated(result) => result,
        RatingState::NotJudged(why) => {
            let problem = Problem::skipped(&format!("not judged: {why}"));
            let mut case = TestCase::new(&rating.key, Some(problem));
            case.property("seed", &report.identity.seed.to_string());
            return case;
        }
    };
    let problem = match result.verdict() {
        Some(Verdict::Passed) => None,
        None => Some(Problem::skipped("nothing is expected of the points")),
        Some(verdict) => {
            let bad = result.findings.iter().filter(|finding| finding.verdict != Verdict::Passed);
            let bad: Vec<_> = bad.map(|finding| finding.criterion.as_str()).collect();
            let kind = if verdict == Verdict::Failed { "points" } else { "inconclusive" };
            Some(Problem::new(kind, &bad.join("; "), text.clone()))
        }
    };
    let mut case = TestCase::new(&rating.key, problem);
    case.property("seed", &report.identity.seed.to_string());
    for [tag, points, maximum, how] in points_rows(&rating.rating, result) {
        case.property(&format!("points {tag}"), format!("{points} of {maximum} {how}").trim_end());
    }
    case.output = Some(text);
    case
}

/// A gate: what it compared is the output of the test.
fn gate_case(report: &SuiteReport, gate: &GateReport) -> TestCase {
    let text = render_gate_report(&report.identity, gate, false);
    let problem = match &gate.state {
        GateState::NotJudged(NotJudged::Broken(why)) => {
            Some(Problem::new("error", first_line(why), why.clone()))
        }
        GateState::NotJudged(why) => Some(Problem::skipped(&why.to_string())),
        GateState::Refused(refusal) => Some(Problem::new("baseline", &refusal.message, text.clone())),
        GateState::Judged(verdict) => match verdict.verdict {
            Verdict::Passed => None,
            Verdict::Inconclusive => {
                Some(Problem::new("inconclusive", &gate_blindness(verdict).join("; "), text.clone()))
            }
            Verdict::Failed => Some(Problem::new("regression", &verdict.rules.join("; "), text.clone())),
        },
    };
    let mut case = TestCase::new(&gate.key, problem);
    case.property("seed", &report.identity.seed.to_string());
    case.property("baseline", &gate.gate.baseline);
    case.output = matches!(gate.state, GateState::Judged(_)).then_some(text);
    case
}

/// A block: its result in words is the output of the test.
fn estimate_properties(case: &mut TestCase, estimate: &EstimateResult) {
    let unless = |refusals: &[String], interval: String| match refusals.is_empty() {
        true => interval,
        false => "refused".to_string(),
    };
    if let Some(along) = &estimate.per_1000_km {
        let interval = format!("{} .. {}", along.interval.low, along.interval.high);
        case.property("per_1000_km_guaranteed", &along.guaranteed.to_string());
        case.property("per_1000_km_estimate", &unless(&estimate.refusals, interval));
        case.property("exposure_source", &along.source);
    }
    if let Some(compared) = &estimate.compared {
        let difference = compared.difference_interval;
        let difference = format!("{} .. {}", difference.low, difference.high);
        case.property("compared_with", &compared.scenario);
        case.property("difference_estimate", &unless(&compared.difference_refusals, difference));
        let ratio = compared.ratio_interval;
        let high = ratio.high.map_or_else(String::new, |high| high.to_string());
        case.property(
            "ratio_estimate",
            &unless(&compared.ratio_refusals, format!("{} .. {high}", ratio.low)),
        );
    }
}

fn block_case(report: &SuiteReport, block: &BlockReport) -> TestCase {
    let text = || render_block_failure(&report.identity, block, false);
    let problem = match (&block.state, block.result().and_then(BlockResult::failure)) {
        (BlockState::Skipped(reason), _) => Some(Problem::skipped(&reason.to_string())),
        (BlockState::NotFinished(cut), _) => Some(not_finished(cut)),
        (BlockState::Errored(error), _) => Some(errored(error, text())),
        (BlockState::Finished(_), Some(reason)) => Some(Problem::new(block.block.kind(), &reason, text())),
        (BlockState::Finished(result), None) => result.verdict().is_none().then(|| Problem::skipped(FOUND)),
    };
    let mut case = TestCase::new(&block.key, problem);
    case.property("seed", &report.identity.seed.to_string());
    case.property("replay", &report.identity.block_command(&block.key));
    match block.result() {
        Some(BlockResult::Estimate(estimate)) => estimate_properties(&mut case, estimate),
        Some(result) if result.evaluations() > 0 => {
            case.property("evaluations", &result.evaluations().to_string());
        }
        _ => {}
    }
    case.output = block.result().map(render_block);
    case.errors = match &block.state {
        BlockState::Errored(error) => log_tail(error),
        _ => None,
    };
    case
}

fn interruption_case(report: &SuiteReport) -> TestCase {
    let message = interruption(report);
    let name = format!("{}/interrupted", report.identity.suite);
    TestCase::new(&name, Some(Problem::new(CutBy::Interrupted.word(), &message, message.clone())))
}

fn first_line(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::fixture::{Meter, Session};

    /// All of it.
    pub fn junit(results: &Results) -> String {
        let repository =
            Repository::around(std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")));
        let mut text = Vec::new();
        write_junit(results, &repository, &mut text).expect("there is room");
        String::from_utf8(text).expect("it is text")
    }

    #[test]
    fn every_state_of_a_trial() {
        let session = Session::new();
        let xml = junit(&session.unrecorded(session.report()));
        insta::assert_snapshot!(xml.replace(env!("CARGO_PKG_VERSION"), "[version]"));
    }

    #[test]
    fn it_is_written_testcase_by_testcase() {
        let session = Session::new();
        let mut meter = Meter::default();
        let repository =
            Repository::around(std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")));
        write_junit(&session.unrecorded(session.long_report()), &repository, &mut meter).unwrap();
        assert!(meter.all > 100 * meter.at_once, "{} of {} bytes at once", meter.at_once, meter.all);
    }

    /// Counts stand before what they count, which nobody holds: another reader counts again.
    #[test]
    fn what_is_announced_is_there() {
        let session = Session::new();
        for report in [session.report(), session.interrupted()] {
            let xml = junit(&session.unrecorded(report));
            let read = quick_junit::Report::deserialize_from_str(&xml).expect("it is JUnit");
            let cases = || read.test_suites.iter().flat_map(|suite| &suite.test_cases);
            let of = |wanted: fn(&quick_junit::TestCaseStatus) -> bool| {
                cases().filter(|case| wanted(&case.status)).count()
            };
            use quick_junit::NonSuccessKind::{Error, Failure};
            use quick_junit::TestCaseStatus::{NonSuccess, Skipped};
            assert_eq!(read.tests, cases().count());
            assert_eq!(read.skipped, of(|status| matches!(status, Skipped { .. })));
            assert_eq!(read.errors, of(|status| matches!(status, NonSuccess { kind: Error, .. })));
            assert_eq!(read.failures, of(|status| matches!(status, NonSuccess { kind: Failure, .. })));
            assert_eq!(read.tests, read.test_suites.iter().map(|suite| suite.tests).sum::<usize>());
            assert_eq!(read.errors, read.test_suites.iter().map(|suite| suite.errors).sum::<usize>());
        }
    }
}
