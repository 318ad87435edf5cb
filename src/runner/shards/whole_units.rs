//! Units that decide themselves which runs they make: each is run as in a session, and then once more from what was kept, which asks for those
//! runs alone that a session over the results will ask for.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::error::ShardError;
use super::planned_unit::Planner;
use super::result_files::ResultFiles;
use super::slices::SliceRuns;
use super::unit_journal::{Resumed, UnitJournal};
use crate::experiment::Silent;
use crate::run::{
    AbsentRuns, Executor, FromResults, RunDigest, RunResults, Stop, StoredRun, VerifyRuns, Wanted,
};
use crate::session::{Runner, Usable, Work, second_runs, tested_controllers, with_needs};
use results::{Cut, TrialState, UnitReport};
use scenario::Block;

/// What is known before a unit is made.
#[derive(Default)]
pub struct KnownRuns {
    /// What a worker that did not come to its end has left.
    pub resumed: Resumed,
    /// Of the units that it builds on.
    pub needed: Option<ResultFiles>,
}

/// Results in memory, which note what is asked for.
struct InMemory {
    runs: Mutex<HashMap<RunDigest, StoredRun>>,
    asked: Mutex<Vec<RunDigest>>,
    journal: Mutex<UnitJournal>,
    needed: Option<ResultFiles>,
}

impl RunResults for InMemory {
    fn find(&self, run: &RunDigest) -> Result<Option<StoredRun>, String> {
        lock(&self.asked).push(*run);
        Ok(self.known(run))
    }

    fn keep(&self, run: RunDigest, stored: StoredRun) {
        lock(&self.journal).record(&run, &stored);
        lock(&self.runs).insert(run, stored);
    }
}

impl InMemory {
    fn known(&self, run: &RunDigest) -> Option<StoredRun> {
        let own = lock(&self.runs).get(run).cloned();
        // What cannot be read is made.
        own.or_else(|| self.needed.as_ref()?.find(run).ok()?)
    }

    fn asked(&self) -> Vec<RunDigest> {
        std::mem::take(&mut lock(&self.asked))
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

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
    /// To be removed when they are where they belong.
    pub journal: UnitJournal,
    /// Whether it is a trial that took longer than its `time_limit`.
    pub is_over_limit: bool,
}

impl WholeUnit<'_, '_> {
    /// Makes all runs that are not known and returns those that it needs, each once. What it builds on is made, too, and is not returned: that is in
    /// the results of other units.
    pub fn run(self, known: KnownRuns, stop: &Stop) -> Result<WholeResults, ShardError> {
        let KnownRuns { resumed: Resumed { journal, runs, .. }, needed } = known;
        let (runs, journal) = (Mutex::new(runs), Mutex::new(journal));
        let results = InMemory { runs, asked: Mutex::default(), journal, needed };
        let pass = |absent: AbsentRuns| {
            // One that ends itself for want of a run must not end the others.
            let own = if absent == AbsentRuns::Refused { Stop::default() } else { stop.clone() };
            let from = FromResults::new(self.executor, self.planner.digests, &results, absent, &own);
            let cut = self.run_from(&from, absent == AbsentRuns::Made, &own, &results);
            (cut, from.troubles())
        };
        let (cut, _) = pass(AbsentRuns::Made);
        if stop.is_requested() {
            return Err(ShardError::Stopped);
        }
        if let Some(finished) = cut {
            self.end_at(finished, &results);
        }
        results.asked();
        if let Some(trouble) = pass(AbsentRuns::Refused).1.into_iter().next() {
            let key = self.planner.units.key(self.unit);
            let message = format!("{key} asked for other runs when it was repeated: {trouble}");
            return Err(ShardError::OtherFiles { message });
        }
        let mut known = HashSet::new();
        let asked = results.asked().into_iter().filter(|run| known.insert(*run));
        let runs = asked.filter_map(|run| Some((run, results.known(&run)?))).collect();
        let journal = results.journal.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(WholeResults { runs, journal, is_over_limit: cut.is_some() })
    }

    /// The run of a trial before which its time was over has no result, though it may have come to its end besides.
    fn end_at(&self, finished: usize, results: &InMemory) {
        let Some(trial) = self.planner.units.get(self.unit).trial() else { return };
        let job = self.planner.job(trial.cases.get(finished), Wanted::Outcome);
        lock(&results.runs).insert(self.planner.digests.of(&job), StoredRun::over_time_limit());
    }

    /// After how many runs its time was over, if it was; with `timed` it is measured.
    fn run_from(
        &self,
        executor: &FromResults,
        timed: bool,
        stop: &Stop,
        results: &InMemory,
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
