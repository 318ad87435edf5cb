//! A session whose units are run when somebody asks what became of them, each at most once.

use std::sync::{Arc, OnceLock};

use super::earlier::Usable;
use super::gates::{judge_one_gate, measured_trials};
use super::shared::Runner;
use super::unit::{Unit, Work, units};
use crate::experiment::Silent;
use crate::project::Project;
use crate::run::Executor;
use results::{GateReport, Requests, Skip, SuiteIdentity, UnitReport};
use scenario::Gate;

/// A session for whoever asks for one unit after another, from any thread, such as tests that are chosen by name.
///
/// What a unit or a gate needs is run with it, unless somebody has asked for that before.
pub struct OnDemand<'a> {
    runner: Runner<'a>,
    units: Vec<Unit<'a>>,
    done: Vec<OnceLock<UnitDone>>,
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
        Self { runner, units, done }
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
        let of_suite = self.units.iter().enumerate().filter(|(_, unit)| unit.suite == suite);
        let trials: Vec<_> = of_suite
            .filter(|(_, unit)| matches!(unit.work, Work::Trial(_)))
            .filter_map(|(index, _)| match self.report(index) {
                UnitReport::Trial(trial) => Some(trial),
                UnitReport::Recorded(_) | UnitReport::Block(_) => None,
            })
            .collect();
        let measured = measured_trials(&self.runner, suite, &trials);
        judge_one_gate(&self.runner, suite, gate, measured.as_ref(), false)
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
        self.runner.run_unit(unit, &Usable::gather(kept), &Silent)
    }
}
