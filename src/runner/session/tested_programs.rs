//! What reports say of programs under test: which they are, how fast they answered, and whether some of their runs, made again alone in other
//! processes, came out the same.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use super::shared::Runner;
use crate::run::{
    Done, Executor, FirstRun, FirstRuns, Job, JobFailure, JobPlace, RunBatch, Sequence, Sequences, Wanted,
    programs, run_sequences,
};
use results::{AnswerTimes, DifferingRun, RecordedState, SuiteReport, TestedController};
use scenario::Suite;
use under_test::ProgramUse;

/// Notes in the reports which programs were asked, and how long their answers took.
pub fn note_uses(executor: &dyn Executor, reports: &mut [SuiteReport]) {
    for ProgramUse { program, title, answers } in executor.program_uses() {
        let is_it = |one: &&mut TestedController| one.name == program.name && one.declared == program.origin;
        for known in reports.iter_mut().flat_map(|report| report.controllers.iter_mut().filter(is_it)) {
            known.program.clone_from(&title);
            known.answers = (answers.answers() > 0).then(|| AnswerTimes {
                answers: answers.answers(),
                median: answers.quantile(0.5).as_secs_f64(),
                percentile_99: answers.quantile(0.99).as_secs_f64(),
                worst: answers.worst().as_secs_f64(),
                late: answers.late(),
            });
        }
    }
}

/// The controllers of a suite that are programs, of which nothing is known yet.
pub fn tested_controllers(suite: &Suite) -> Vec<TestedController> {
    let scenarios = suite.scenarios.iter().chain(&suite.supporting);
    let models = scenarios.flat_map(|one| &one.vehicles).flat_map(|car| car.controller.all());
    let mut tested: Vec<TestedController> = Vec::new();
    for program in models.filter_map(|model| model.known()?.program.as_ref()) {
        if tested.iter().all(|one| one.name != program.name || one.declared != program.origin) {
            let (name, declared) = (program.name.clone(), program.origin.clone());
            tested.push(TestedController { name, declared, ..TestedController::default() });
        }
    }
    tested.sort_by(|one, other| one.name.cmp(&other.name));
    tested
}

/// Makes the second runs of all suites, and notes in the reports which came out differently. No report counts them as runs.
pub fn verify(runner: &Runner, reports: &mut [SuiteReport]) {
    for (suite, report) in reports.iter_mut().enumerate() {
        verify_suite(runner, suite, report);
    }
}

/// Makes the second runs of a suite that have not been made yet.
pub fn verify_suite(runner: &Runner, suite: usize, report: &mut SuiteReport) {
    let differing = second_runs(runner.batch(), runner.first_runs(suite), &mut report.controllers);
    for recorded in report.recorded.iter_mut().filter(|one| differing.contains(&one.key)) {
        if let RecordedState::Ran(rerun) = &mut recorded.state {
            rerun.may_differ = true;
        }
    }
}

/// Makes the runs that were kept a second time, each alone in another process, and notes with the controllers what came of it; the keys of those that
/// came out differently. None of them counts as a run.
pub fn second_runs(
    batch: RunBatch,
    first_runs: &FirstRuns,
    controllers: &mut [TestedController],
) -> Vec<String> {
    let first = first_runs.take();
    // Of what was interrupted nothing more is made.
    if first.is_empty() || batch.stop.is_requested() {
        return Vec::new();
    }
    let mut second = SecondRuns { batch, first, found: Vec::new(), begun: false };
    run_sequences(batch.executor, &mut second, batch.stop);
    let SecondRuns { first, found, .. } = second;
    let mut differing = Vec::new();
    for (first, difference) in first.iter().zip(found) {
        if difference.is_some() {
            differing.push(first.case.key.clone());
        }
        note(controllers, first, difference);
    }
    differing
}

/// Which of the programs of a suite do not decide the same each time, by what its files call them, with how that is known: what was seen,
/// or that the file says so.
pub fn nondeterministic(suite: &Suite, controllers: &[TestedController]) -> BTreeMap<String, String> {
    let seen = controllers.iter().filter_map(|one| Some((one.name.clone(), one.first_difference()?)));
    let scenarios = suite.scenarios.iter().chain(&suite.supporting);
    let models = scenarios.flat_map(|one| &one.vehicles).flat_map(|car| car.controller.all());
    let declared = models.filter_map(|model| model.known()?.program.clone()).filter(|one| one.may_differ());
    let declared = declared.map(|one| (one.name.clone(), "its declaration says so".to_string()));
    declared.chain(seen).collect()
}

/// Notes what came of a second run: with which program, since only that may have differed.
fn note(controllers: &mut [TestedController], first: &FirstRun, difference: Option<(usize, String)>) {
    let cars = &first.case.world.vehicles;
    let own = |vehicle: usize| cars.get(vehicle)?.controller.model.known()?.program.clone();
    let blamed = difference.as_ref().and_then(|(vehicle, _)| own(*vehicle));
    for program in programs(&first.case) {
        let is_it = |one: &&mut TestedController| one.name == program.name && one.declared == program.origin;
        let Some(known) = controllers.iter_mut().find(is_it) else { continue };
        known.second_runs += 1;
        if let Some((_, difference)) =
            difference.as_ref().filter(|_| blamed.as_ref().is_none_or(|one| *one == program))
        {
            known
                .differing
                .push(DifferingRun { run: first.case.key.clone(), difference: difference.clone() });
        }
    }
}

/// All of a suite, one after the other for each process.
struct SecondRuns<'b> {
    batch: RunBatch<'b>,
    first: Vec<FirstRun>,
    /// What came of each, in their order.
    found: Vec<Option<(usize, String)>>,
    begun: bool,
}

impl Sequences for SecondRuns<'_> {
    type One = Each;

    fn open(&mut self) -> Option<Each> {
        if std::mem::replace(&mut self.begun, true) {
            return None;
        }
        let measured = self.batch.measured.clone();
        Some(Each { first: self.first.clone(), measured, found: Vec::new() })
    }

    fn close(&mut self, one: Each, _: usize) {
        self.found = one.found;
    }
}

struct Each {
    first: Vec<FirstRun>,
    measured: std::sync::Arc<crate::run::MeasuredMetrics>,
    found: Vec<Option<(usize, String)>>,
}

impl Sequence for Each {
    fn runs(&self) -> usize {
        self.first.len()
    }

    fn job(&mut self, place: JobPlace) -> Job {
        let case = self.first[place.run].case.clone();
        Job {
            place,
            case,
            measured: self.measured.clone(),
            wanted: Wanted::Decisions,
            alone: true,
            change: None,
        }
    }

    fn take(&mut self, done: Done) -> ControlFlow<()> {
        let first = &self.first[self.found.len()];
        self.found.push(match done.result {
            Ok(again) => first.difference(&again),
            Err(failure) => {
                let why = match failure {
                    JobFailure::Error(error) => error.to_string(),
                    JobFailure::Panicked(panicked) => panicked.to_string(),
                };
                let vehicle = first.decisions.first().map_or(0, |one| one.vehicle);
                let line = why.lines().next().unwrap_or_default().to_string();
                Some((vehicle, format!("it came to its end, the second time it did not: {line}")))
            }
        });
        ControlFlow::Continue(())
    }
}
