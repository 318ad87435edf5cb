//! Units that decide themselves which runs they make: each is run as in a session, and then once more from what was kept, which asks for those
//! runs alone that a session over the results will ask for.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::error::ShardError;
use super::planned_unit::Planner;
use super::slices::SliceRuns;
use super::unit_runs::{NotEnded, UnitRuns};
use crate::experiment::Silent;
use crate::run::{AbsentRuns, Executor, FromResults, Stop, StoredRun, VerifyRuns, Wanted};
use crate::session::{Runner, Usable, Work, second_runs, tested_controllers, with_needs};
use results::{Cut, TrialState, UnitReport};
use scenario::Block;

/// A unit that decides itself which runs it makes.
#[derive(Clone, Copy)]
pub struct WholeUnit<'u, 'a> {
    pub planner: &'u Planner<'a>,
    pub executor: &'u dyn Executor,
    pub unit: usize,
    /// Of a search, for which group of people alone.
    pub group: Option<usize>,
    pub verify: VerifyRuns,
    /// Of its first run among those of its scenario, where some runs are made twice.
    pub number: Option<usize>,
}

/// What came of one.
pub struct WholeResults {
    pub runs: SliceRuns,
    /// Whether it is a trial that took longer than its `time_limit`.
    pub is_over_limit: bool,
}

impl WholeUnit<'_, '_> {
    /// Makes all runs that are not known and returns those that it needs, each once. What it builds on is made, too, and is not returned: that is in
    /// the results of other units. It may turn out on the way that it is not to be made here.
    pub fn run(self, results: &UnitRuns, stop: &Stop) -> Result<Result<WholeResults, NotEnded>, ShardError> {
        let pass = |absent: AbsentRuns| {
            // One that ends itself for want of a run must not end the others.
            let own = if absent == AbsentRuns::Refused { Stop::default() } else { results.stop().clone() };
            let from = FromResults::new(self.executor, self.planner.digests, results, absent, &own);
            let cut = self.run_from(&from, absent == AbsentRuns::Made, &own, results);
            (cut, from.troubles().into_iter().next())
        };
        let (cut, trouble) = pass(AbsentRuns::Made);
        if stop.is_requested() {
            return Err(ShardError::Stopped);
        }
        if let Some(why) = results.ended() {
            return Ok(Err(why));
        }
        let other_files = |message: String| Err(ShardError::OtherFiles { message });
        let key = || self.planner.units.key(self.unit);
        if let Some(trouble) = trouble {
            return other_files(format!("{}: {trouble}", key()));
        }
        if let Some(finished) = cut {
            self.end_at(finished, results);
        }
        results.asked();
        if let Some(trouble) = pass(AbsentRuns::Refused).1 {
            return other_files(format!("{} asked for other runs when it was repeated: {trouble}", key()));
        }
        let mut known = HashSet::new();
        let asked = results.asked().into_iter().filter(|run| known.insert(*run));
        let runs = asked.filter_map(|run| Some((run, results.known(&run)?))).collect();
        Ok(Ok(WholeResults { runs, is_over_limit: cut.is_some() }))
    }

    /// The run of a trial before which its time was over has no result, though it may have come to its end besides.
    fn end_at(&self, finished: usize, results: &UnitRuns) {
        let Some(trial) = self.planner.units.get(self.unit).trial() else { return };
        let job = self.planner.job(trial.cases.get(finished), Wanted::Outcome);
        results.put(self.planner.digests.of(&job), StoredRun::over_time_limit());
    }

    /// After how many runs its time was over, if it was; with `timed` it is measured.
    fn run_from(
        &self,
        executor: &FromResults,
        timed: bool,
        stop: &Stop,
        results: &UnitRuns,
    ) -> Option<usize> {
        let (project, units) = (self.planner.project, self.planner.units);
        let runner = || {
            let runner = Runner::new(project.suites(), executor, project.registry());
            runner.verifying(self.verify).reading(project.files()).stopped_by(stop)
        };
        // What it builds on is measured where its own results are made.
        let (own, others) = (if timed { runner() } else { runner().timeless() }, runner().timeless());
        let mut only = vec![false; units.len()];
        only[self.unit] = true;
        let wanted = with_needs(units, only);
        let mut kept: HashMap<usize, Arc<Usable>> = HashMap::new();
        let mut cut = None;
        for index in (0..=self.unit).filter(|index| wanted[*index]) {
            let one = units.get(index);
            let needs: Option<Vec<_>> = one.needs.iter().map(|need| kept.get(need).cloned()).collect();
            // Without what it builds on it is not run here either.
            let Some(needs) = needs else { continue };
            let runner = if index == self.unit { &own } else { &others };
            if index == self.unit {
                results.asked();
                if let (Some(number), Work::Trial(trial)) = (self.number, &one.work) {
                    runner.first_runs(one.suite).number(&trial.scenario, number);
                }
            }
            if let (true, Some(group), Work::Block(block)) = (index == self.unit, self.group, &one.work) {
                if let Block::Search(search) = &**block {
                    runner.search_group(one.suite, search, group);
                }
                continue;
            }
            let report = runner.run_unit(&one, &Usable::gather(needs), &Silent);
            if let (true, UnitReport::Trial(trial)) = (index == self.unit, &report)
                && let TrialState::NotFinished(Cut::TimeLimit { finished, .. }) = trial.state
            {
                cut = Some(finished);
            }
            let mut controllers = tested_controllers(&runner.suites()[one.suite].suite);
            second_runs(runner.batch(), runner.first_runs(one.suite), &mut controllers);
            kept.extend(Usable::of(&one.work, &report).map(|usable| (index, Arc::new(usable))));
        }
        cut
    }
}
