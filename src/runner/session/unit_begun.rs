//! A unit from its beginning, among others or by itself.

use super::shared::Runner;
use super::unit::{Unit, Work};
use super::unit_run::{RecordedRun, TrialRun, UnitRun};
use crate::experiment::{BlockProgress, EarlierResults};
use crate::run::{Sequences, run_sequences};
use results::{Skip, Stopping, UnitReport};

impl<'a> Runner<'a> {
    /// A unit that is made of runs, at its beginning; `None` for a block. `told` is called after every run of a trial.
    pub(super) fn begin<'s>(
        &'s self,
        unit: Unit<'a>,
        told: Box<dyn FnMut() + Send + 's>,
    ) -> Option<UnitRun<'s, 'a>> {
        match unit.work {
            Work::Recorded(recorded) => {
                Some(UnitRun::Recorded(Box::new(RecordedRun::new(self, unit.suite, &unit.key, recorded))))
            }
            Work::Trial(trial) => {
                Some(UnitRun::Trial(Box::new(TrialRun::new(self, unit.suite, trial, told))))
            }
            Work::Block(_) => None,
        }
    }

    /// Runs one unit by itself. A block finds what it needs in `results`.
    pub fn run_unit(
        &self,
        unit: &Unit<'a>,
        results: &EarlierResults,
        progress: &dyn BlockProgress,
    ) -> UnitReport {
        if let Work::Block(block) = &unit.work {
            return UnitReport::Block(self.block(unit.suite, block, results, progress));
        }
        let mut alone = Alone { first: self.begin(unit.clone(), Box::new(|| ())), report: None };
        run_sequences(self.executor(), &mut alone, self.stop());
        alone.report.unwrap_or_else(|| self.skipped(unit, Skip::Stopped(Stopping::Interrupted)))
    }
}

/// A unit that is run by itself.
struct Alone<'s, 'a> {
    first: Option<UnitRun<'s, 'a>>,
    report: Option<UnitReport>,
}

impl<'s, 'a> Sequences for Alone<'s, 'a> {
    type One = UnitRun<'s, 'a>;

    fn open(&mut self) -> Option<UnitRun<'s, 'a>> {
        self.first.take()
    }

    fn close(&mut self, one: UnitRun<'s, 'a>, taken: usize) {
        self.report = Some(one.report(taken));
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use crate::experiment::Silent;
    use crate::project::Project;
    use crate::run::Threads;
    use crate::session::units;
    use files::Disk;
    use models::standard;

    /// There may be a million runs: each holds what it has of its own, and of that what somebody may still ask for.
    #[test]
    fn of_a_run_no_more_is_kept_than_its_trial_needs() {
        let path =
            Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenarios/zebra/carla_walker.scn");
        let project = Project::open(&path, &standard(), &Disk).unwrap_or_else(|error| panic!("{error}"));
        let suites = project.suites();
        let threads = Threads::new(1);
        let runner = Runner::new(suites, &threads, &standard());
        let trial = suites[0].plan.trial(0);
        let unit = &units(suites).get(0);
        let UnitReport::Trial(report) = runner.run_unit(unit, &EarlierResults::default(), &Silent) else {
            panic!("the first unit is a trial");
        };
        let asked: Vec<_> = trial.criteria.iter().map(|one| one.claim.metric()).collect();
        let (mut kept, mut dropped) = (0, 0);
        for outcome in &report.outcomes {
            for (index, reference) in runner.requests().iter().enumerate() {
                match outcome.critical.get(index) {
                    Some(_) => {
                        assert!(
                            asked.contains(&reference),
                            "nobody asks for the moment of {}",
                            reference.name()
                        );
                        kept += 1;
                    }
                    None => dropped += usize::from(outcome.metrics[index].is_some()),
                }
            }
            let walker = &outcome.presences[0].other;
            assert!(
                Arc::ptr_eq(walker, &report.outcomes[0].presences[0].other),
                "each run has names of its own"
            );
        }
        assert!(kept > 0 && dropped > 0, "{kept} kept, {dropped} dropped");
    }
}
