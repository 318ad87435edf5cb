//! Gates, once everything is judged: each suite's runs against its baseline.

use std::path::Path;
use std::sync::Arc;

use super::shared::Runner;
use super::tested_programs::{nondeterministic, verify_suite};
use crate::baseline::{self, measured_metrics, program_titles, record};
use crate::plan::PlannedTrial;
use crate::run::{BatchError, Panicked};
use files::Files;
use results::judge::baseline::{Baseline, Incompatible};
use results::judge::gate::judge_gate;
use results::{
    Event, GateReport, GateState, NotJudged, Refusal, Reporter, Skip, SuiteIdentity, SuiteReport,
    TrialReport, TrialState, is_use, is_value, record_command,
};
use scenario::{Gate, Suite};

/// Judges every gate of every suite and puts what it came to into the suite's report. With `lenient`, trials that a
/// baseline lacks are left out instead of being a reason not to compare. Which gate it is, `reporter` is told.
pub fn judge_gates<'a>(
    runner: &Runner<'a>,
    reports: &mut [SuiteReport],
    lenient: bool,
    reporter: &mut dyn Reporter,
) {
    let mut judging = |key: Option<&str>| {
        reporter.tell(&Event::Judging(key));
        reporter.flush();
    };
    for (suite, report) in reports.iter_mut().enumerate() {
        let gates = &runner.suites()[suite].suite.gates;
        // Where one failed while runs came in, all is said.
        if gates.is_empty() || !report.gates.is_empty() {
            continue;
        }
        assert!(report.summary.is_none(), "a suite with gates has every trial");
        let identity = runner.identity(suite);
        let refusals: Vec<_> =
            gates.iter().map(|gate| other_runs(gate, &identity.set, runner.files())).collect();
        judging(Some(&gate_key(&identity.suite, &gates[0])));
        // Runs that a trial did not need itself are made up for only where something is compared.
        let mut measured = refusals.contains(&None).then(|| {
            let trials: Vec<_> = report.trials.iter().collect();
            measured_trials(runner, suite, &trials)
        });
        if let Some(Ok(candidate)) = &mut measured {
            // Of the runs that were made up for some are made twice, too.
            verify_suite(runner, suite, report);
            candidate.nondeterministic = nondeterministic(&runner.suites()[suite].suite, &report.controllers);
        }
        report.interrupted |= matches!(measured, Some(Err(_))) && runner.stop().is_requested();
        let judged = |(gate, refusal): (&'a Gate, Option<Refusal>)| {
            judging(Some(&gate_key(&identity.suite, gate)));
            match (refusal, &measured) {
                (None, Some(measured)) => judge_one_gate(runner, suite, gate, measured.as_ref(), lenient),
                (refusal, _) => {
                    let state = GateState::Refused(refusal.expect("whatever is not refused was measured"));
                    GateReport { gate: Arc::new(gate.clone()), key: gate_key(&identity.suite, gate), state }
                }
            }
        };
        report.gates = gates.iter().zip(refusals).map(judged).collect();
        judging(None);
    }
}

/// Whether a gate's baseline is of other runs, so that none need be made to be compared with it.
pub(super) fn other_runs(gate: &Gate, set: &[String], files: &dyn Files) -> Option<Refusal> {
    let base = Baseline::read_named(Path::new(&gate.baseline), files).ok()?;
    refusal(&base, set)
}

/// Values that were set and controllers in the place of others make other runs, whatever their names: those of a baseline only if it has
/// the same.
fn refusal(base: &Baseline, set: &[String]) -> Option<Refusal> {
    // Values alone that only the baseline has are among the reasons that are told together.
    if base.has_set(set) || set.is_empty() && base.set.iter().all(|one| is_value(one)) {
        return None;
    }
    let help = "leave out `--set`, `--repeat` and `--controller` to judge the gate, or record a baseline with them; `compare SUITE \
                --parameters FILE` compares other parameters of what is tested, `compare BASELINE BASELINE` other controllers";
    let words =
        |set: &[String]| set.iter().filter(|one| !is_use(one)).cloned().collect::<Vec<_>>().join(", ");
    let (own, its_own) = (words(set), words(&base.set));
    let with = if own.is_empty() { String::new() } else { format!("with {own} ") };
    let its_own = if its_own.is_empty() { its_own } else { format!(", which were run with {its_own}") };
    Some(Refusal {
        message: format!("{with}these are not the runs that the baseline is of{its_own}"),
        reasons: Vec::new(),
        help: help.to_string(),
    })
}

/// Judges one gate of the suite with index `suite` on what [`measured_trials`] gave.
pub fn judge_one_gate<'a>(
    runner: &Runner<'a>,
    suite: usize,
    gate: &'a Gate,
    measured: Result<&Baseline, &NotJudged>,
    lenient: bool,
) -> GateReport {
    let identity = runner.identity(suite);
    let state = match measured {
        Ok(candidate) => {
            let suite = &runner.suites()[suite].suite;
            state(gate, candidate, &identity, suite, lenient, runner.files())
        }
        Err(why) => GateState::NotJudged(why.clone()),
    };
    GateReport { gate: Arc::new(gate.clone()), key: gate_key(&identity.suite, gate), state }
}

/// Such as `zebra/gate=braking`.
pub fn gate_key(suite: &str, gate: &Gate) -> String {
    format!("{suite}/gate={}", gate.name)
}

/// All trials of a suite as a baseline, or why they do not make one.
pub fn measured_trials(
    runner: &Runner,
    suite: usize,
    trials: &[&TrialReport],
) -> Result<Baseline, NotJudged> {
    let left_out = trials.iter().filter(|trial| trial.skipped()).count();
    if trials.iter().all(|trial| trial.skip() == Some(&Skip::NotSelected)) {
        return Err(NotJudged::NotSelected);
    }
    if left_out > 0 {
        return Err(NotJudged::Part { left_out, trials: trials.len() });
    }
    for trial in trials {
        let what = match trial.state {
            TrialState::Errored(_) => "could not be run",
            TrialState::NotFinished(_) => "was not finished",
            TrialState::Judged(_) | TrialState::Skipped(_) => continue,
        };
        return Err(NotJudged::Incomplete(format!("{} {what}", trial.trial.key)));
    }
    let prepared = &runner.suites()[suite];
    let requests = runner.requests();
    let mut outcomes = Vec::with_capacity(trials.len());
    // Reports have all trials of the plan, in its order.
    for (trial, planned) in trials.iter().zip(prepared.plan.trials()) {
        // When a trial was decided must not decide what is compared.
        let mut all = trial.outcomes.clone();
        let known = trial.outcomes.len();
        let more = || {
            let (first_runs, left) = (runner.first_runs(suite), planned.cases.from(known));
            runner.batch().outcomes_keeping(first_runs, known, left, || ())
        };
        let more = Panicked::catch(more);
        let more = more.map_err(|panicked| NotJudged::Broken(panicked.to_string()))?;
        all.extend(more.map_err(|error| match error {
            BatchError::Stopped => {
                NotJudged::Incomplete(format!("interrupted before the last runs of {}", trial.trial.key))
            }
            BatchError::Run { .. } => NotJudged::Broken(error.to_string()),
        })?);
        outcomes.push((planned, all));
    }
    let trials: Vec<_> = outcomes.iter().map(|(trial, outcomes)| (trial, &outcomes[..])).collect();
    Ok(of_suite(runner, suite, record(&prepared.plan, &trials, requests)))
}

/// As [`measured_trials`] gives it, of a suite of which no run was made yet.
pub(super) fn frame<'t>(
    runner: &Runner,
    suite: usize,
    trials: impl Iterator<Item = &'t PlannedTrial>,
) -> Baseline {
    let plan = &runner.suites()[suite].plan;
    of_suite(runner, suite, baseline::frame(plan, trials, runner.requests()))
}

fn of_suite(runner: &Runner, suite: usize, mut all: Baseline) -> Baseline {
    let declared = &runner.suites()[suite].suite;
    all.programs = program_titles(runner.executor(), declared);
    // Other suites of the session may have asked for more.
    all.keep_metrics(&measured_metrics(declared, runner.registry()));
    all
}

fn state(
    gate: &Gate,
    candidate: &Baseline,
    identity: &SuiteIdentity,
    suite: &Suite,
    lenient: bool,
    files: &dyn Files,
) -> GateState {
    let path = Path::new(&gate.baseline);
    let record = record_command(&identity.file, &identity.set, path);
    let judged = match Baseline::read_named(path, files) {
        Ok(base) => match refusal(&base, &identity.set) {
            Some(refusal) => return GateState::Refused(refusal),
            None => judge_gate(gate, &base, candidate, lenient),
        },
        Err(error) => {
            let (message, help) = (error.to_string(), error.hint(&record));
            return GateState::Refused(Refusal { message, reasons: Vec::new(), help });
        }
    };
    match judged {
        Ok(verdict) => GateState::Judged(Box::new(verdict.written_as(suite))),
        Err(reasons) => {
            let new_ones = reasons.iter().all(|reason| matches!(reason, Incompatible::New(_)));
            let lenient = if new_ones { "; `--baseline-lenient` leaves new trials out" } else { "" };
            GateState::Refused(Refusal {
                message: format!("the baseline {} may not be compared with", path.display()),
                reasons: reasons.iter().map(ToString::to_string).collect(),
                help: format!("record it anew, from the version to compare with, by `{record}`{lenient}"),
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::{EarlierResults, Silent};
    use crate::project::Project;
    use crate::run::Threads;
    use crate::session::units;
    use files::{Disk, Memory};
    use models::standard;
    use results::UnitReport;

    /// Also where the gate is judged by itself, and nothing was said on the command line.
    #[test]
    fn a_baseline_of_another_system_is_refused_whoever_asks() {
        const SUITE: &str = "suite s {
  scenario walk {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller constant_speed; speed 30 km/h; start 60 m before crossing }
    pedestrian walker { model scripted; start 2 m from kerb; appears at 0 s }
    expect { max_deceleration <= 9 m/s^2 }
  }
  gate same { baseline \"base.json\"; collision not worse }
}
";
        let files = Memory::default().with("s.suite", SUITE);
        let project = Project::open("s.suite", &standard(), &files).unwrap_or_else(|error| panic!("{error}"));
        let suites = project.suites();
        let threads = Threads::new(1);
        let runner = Runner::new(suites, &threads, &standard());
        let reports: Vec<_> = units(suites)
            .iter()
            .map(|unit| runner.run_unit(&unit, &EarlierResults::default(), &Silent))
            .collect();
        let trials = reports.iter().filter_map(|report| match report {
            UnitReport::Trial(trial) => Some(trial),
            _ => None,
        });
        let candidate = measured_trials(&runner, 0, &trials.collect::<Vec<_>>()).unwrap();
        let suite = &suites[0].suite;
        let judged = |set: &[&str]| {
            let set = set.iter().map(|one| one.to_string()).collect();
            let base = Baseline { set, ..candidate.clone() };
            let files = Memory::default().with("base.json", base.text().as_str());
            state(&suite.gates[0], &candidate, &runner.identity(0), suite, false, &files)
        };
        assert!(matches!(judged(&[]), GateState::Judged(_)));
        assert!(matches!(judged(&["use own.scn"]), GateState::Judged(_)));
        for other in ["controller av=own", "av.speed=20km/h"] {
            assert!(matches!(judged(&[other]), GateState::Refused(_)), "{other}");
        }
    }

    #[test]
    fn trials_that_were_decided_early_are_run_to_their_end() {
        let path =
            Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenarios/zebra/carla_walker.scn");
        let project = Project::open(&path, &standard(), &Disk).unwrap_or_else(|error| panic!("{error}"));
        let suites = project.suites();
        let threads = Threads::new(2);
        let runner = Runner::new(suites, &threads, &standard());
        let mut trials = Vec::new();
        for unit in units(suites).iter() {
            match runner.run_unit(&unit, &EarlierResults::default(), &Silent) {
                UnitReport::Trial(trial) => trials.push(trial),
                _ => panic!("a scenario has trials only"),
            }
        }
        let measured =
            |trials: &[TrialReport]| measured_trials(&runner, 0, &trials.iter().collect::<Vec<_>>()).unwrap();
        let whole = measured(&trials);
        trials[0].outcomes.truncate(3);
        assert_eq!(measured(&trials), whole);
        trials[0].state = TrialState::Errored(String::from("no").into());
        let error = measured_trials(&runner, 0, &trials.iter().collect::<Vec<_>>()).unwrap_err();
        assert!(error.to_string().contains("could not be run"), "{error}");
    }
}
