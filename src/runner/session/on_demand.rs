//! A session whose units are run when somebody asks what became of them, each at most once.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::earlier::Usable;
use super::gates::{judge_one_gate, measured_trials};
use super::ratings::judge_one_rating;
use super::shared::Runner;
use super::tested_programs::{nondeterministic, second_runs, tested_controllers};
use super::unit::{Unit, Work, units};
use crate::experiment::Silent;
use crate::project::Project;
use crate::run::{Executor, VerifyRuns};
use results::{
    GateReport, RatingReport, RecordedReport, RecordedState, Requests, Skip, SuiteIdentity, TestedController,
    TrialReport, UnitReport,
};
use scenario::{Gate, Rating};

/// A session for whoever asks for one unit after another, from any thread, such as tests that are chosen by name.
///
/// What a unit or a gate needs is run with it, unless somebody has asked for that before.
pub struct OnDemand<'a> {
    runner: Runner<'a>,
    units: Vec<Unit<'a>>,
    done: Vec<OnceLock<UnitDone>>,
    /// What is known of the programs of each suite. Whoever holds it runs a unit of the suite: which runs are made twice depends on their order.
    controllers: Vec<Mutex<Vec<TestedController>>>,
}

struct UnitDone {
    report: UnitReport,
    kept: Option<Arc<Usable>>,
}

impl<'a> OnDemand<'a> {
    /// One whose runs `executor` makes.
    pub fn new(project: &'a Project, executor: &'a dyn Executor) -> Self {
        let runner = Runner::new(project.suites(), executor, project.registry()).reading(project.files());
        let units: Vec<_> = units(project.suites()).iter().collect();
        let done = units.iter().map(|_| OnceLock::new()).collect();
        let controllers = project.suites().iter().map(|one| Mutex::new(tested_controllers(&one.suite)));
        Self { runner, units, done, controllers: controllers.collect() }.verify_runs(VerifyRuns::default())
    }

    /// Which of the runs in which programs decide are made a second time, to see whether they come out the same: the first of each
    /// scenario and every 200th unless this says otherwise.
    pub fn verify_runs(self, verify: VerifyRuns) -> Self {
        Self { runner: self.runner.verifying(verify), ..self }
    }

    /// The programs that are tested in the suite of this index, with what second runs of the units that were run showed.
    pub fn controllers(&self, suite: usize) -> Vec<TestedController> {
        self.controllers[suite].lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The units of the project, in the order of their suites.
    pub fn units(&self) -> &[Unit<'a>] {
        &self.units
    }

    /// What is measured in every run, in the order of the outcomes' metrics.
    pub fn requests(&self) -> &Requests {
        self.runner.requests()
    }

    /// How reports call the suite of this index, and how to run it again.
    pub fn identity(&self, suite: usize) -> SuiteIdentity {
        self.runner.identity(suite)
    }

    /// What became of the unit of this index in [`Self::units`], which is run now if it was not before.
    pub fn report(&self, unit: usize) -> &UnitReport {
        &self.done(unit).report
    }

    /// What became of all units of a suite, as [`Self::report`].
    pub fn reports(&self, suite: usize) -> impl Iterator<Item = &UnitReport> {
        let of_suite = self.units.iter().enumerate().filter(move |(_, unit)| unit.suite == suite);
        of_suite.map(|(index, _)| self.report(index))
    }

    /// What a gate of a suite comes to, for which all trials of that are run.
    pub fn gate(&self, suite: usize, gate: &Gate) -> GateReport {
        let trials = self.trials(suite);
        let mut controllers = self.controllers[suite].lock().unwrap_or_else(PoisonError::into_inner);
        let mut measured = measured_trials(&self.runner, suite, &trials);
        if let Ok(candidate) = &mut measured {
            // Of the runs that were made up for some are made twice, too.
            second_runs(self.runner.batch(), self.runner.first_runs(suite), &mut controllers);
            candidate.nondeterministic = nondeterministic(&self.runner.suites()[suite].suite, &controllers);
        }
        drop(controllers);
        judge_one_gate(&self.runner, suite, gate, measured.as_ref(), false)
    }

    /// What a rating of a suite comes to, for which all trials of that are run.
    pub fn rating(&self, suite: usize, rating: &Rating) -> RatingReport {
        let trials: Vec<TrialReport> = self.trials(suite).into_iter().cloned().collect();
        judge_one_rating(&self.runner, suite, rating, &trials)
    }

    /// All trials of a suite.
    fn trials(&self, suite: usize) -> Vec<&TrialReport> {
        let of_suite = self.units.iter().enumerate().filter(|(_, unit)| unit.suite == suite);
        of_suite
            .filter(|(_, unit)| matches!(unit.work, Work::Trial(_)))
            .filter_map(|(index, _)| match self.report(index) {
                UnitReport::Trial(trial) => Some(trial),
                UnitReport::Recorded(_) | UnitReport::Block(_) => None,
            })
            .collect()
    }

    /// Units need only those before them, so nobody waits for himself.
    fn done(&self, index: usize) -> &UnitDone {
        self.done[index].get_or_init(|| {
            let report = self.run(index);
            let kept = Usable::of(&self.units[index].work, &report).map(Arc::new);
            UnitDone { report, kept }
        })
    }

    fn run(&self, index: usize) -> UnitReport {
        let unit = &self.units[index];
        let mut kept = Vec::new();
        for need in &unit.needs {
            match &self.done(*need).kept {
                Some(one) => kept.push(Arc::clone(one)),
                None => {
                    let skip = Skip::needs(&self.units[*need].key, self.report(*need).standing());
                    return self.runner.skipped(unit, skip);
                }
            }
        }
        let kept = Usable::gather(kept);
        if tested_controllers(&self.runner.suites()[unit.suite].suite).is_empty() {
            return self.runner.run_unit(unit, &kept, &Silent);
        }
        let mut controllers = self.controllers[unit.suite].lock().unwrap_or_else(PoisonError::into_inner);
        let mut report = self.runner.run_unit(unit, &kept, &Silent);
        let first_runs = self.runner.first_runs(unit.suite);
        let differing = second_runs(self.runner.batch(), first_runs, &mut controllers);
        if let UnitReport::Recorded(RecordedReport { key, state: RecordedState::Ran(rerun), .. }) =
            &mut report
        {
            rerun.may_differ |= differing.contains(key);
        }
        report
    }
}
