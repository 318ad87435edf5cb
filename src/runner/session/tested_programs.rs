//! What reports say of programs under test: which they are, how fast they answered, and whether some of their runs, made again alone in other
//! processes, came out the same.

use std::ops::ControlFlow;

use super::shared::Runner;
use crate::run::{
    Done, Executor, FirstRun, Job, JobFailure, JobPlace, Sequence, Sequences, Wanted, programs, run_sequences,
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
        let first = runner.first_runs(suite).take();
        // Of a session that was interrupted nothing more is made.
        if first.is_empty() || runner.stop().is_requested() {
            continue;
        }
        let mut second = SecondRuns { runner, first, found: Vec::new(), begun: false };
        run_sequences(runner.executor(), &mut second, runner.stop());
        let SecondRuns { first, found, .. } = second;
        for (first, difference) in first.iter().zip(found) {
            note(report, first, difference);
        }
    }
}

/// Notes what came of a second run: with which program, since only that may have differed.
fn note(report: &mut SuiteReport, first: &FirstRun, difference: Option<(usize, String)>) {
    let cars = &first.case.world.vehicles;
    let own = |vehicle: usize| cars.get(vehicle)?.controller.model.known()?.program.clone();
    let blamed = difference.as_ref().and_then(|(vehicle, _)| own(*vehicle));
    for program in programs(&first.case) {
        let is_it = |one: &&mut TestedController| one.name == program.name && one.declared == program.origin;
        let Some(known) = report.controllers.iter_mut().find(is_it) else { continue };
        known.second_runs += 1;
        if let Some((_, difference)) =
            difference.as_ref().filter(|_| blamed.as_ref().is_none_or(|one| *one == program))
        {
            known
                .differing
                .push(DifferingRun { run: first.case.key.clone(), difference: difference.clone() });
        }
    }
    if difference.is_some() {
        for recorded in report.recorded.iter_mut().filter(|one| one.key == first.case.key) {
            if let RecordedState::Ran(rerun) = &mut recorded.state {
                rerun.may_differ = true;
            }
        }
    }
}

/// All of a suite, one after the other for each process.
struct SecondRuns<'s, 'a> {
    runner: &'s Runner<'a>,
    first: Vec<FirstRun>,
    /// What came of each, in their order.
    found: Vec<Option<(usize, String)>>,
    begun: bool,
}

impl Sequences for SecondRuns<'_, '_> {
    type One = Each;

    fn open(&mut self) -> Option<Each> {
        if std::mem::replace(&mut self.begun, true) {
            return None;
        }
        let measured = self.runner.measured().clone();
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
        Job { place, case, measured: self.measured.clone(), wanted: Wanted::Decisions, alone: true }
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
