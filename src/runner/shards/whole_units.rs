//! Units that decide themselves which runs they make: each is run as in a session, and then once more from what was kept, which asks for those
//! runs alone that a session over the results will ask for.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError};

use super::error::ShardError;
use super::planned_unit::Planner;
use super::slices::SliceRuns;
use crate::experiment::Silent;
use crate::run::{AbsentRuns, Executor, FromResults, RunDigest, RunResults, Stop, StoredRun, VerifyRuns};
use crate::session::{Runner, Usable, Work, second_runs, tested_controllers, with_needs};

/// Results in memory, which note what is asked for.
#[derive(Default)]
struct InMemory {
    runs: Mutex<HashMap<RunDigest, StoredRun>>,
    asked: Mutex<Vec<RunDigest>>,
}

impl RunResults for InMemory {
    fn find(&self, run: &RunDigest) -> Result<Option<StoredRun>, String> {
        self.asked.lock().unwrap_or_else(PoisonError::into_inner).push(*run);
        Ok(self.runs.lock().unwrap_or_else(PoisonError::into_inner).get(run).cloned())
    }

    fn keep(&self, run: RunDigest, stored: StoredRun) {
        self.runs.lock().unwrap_or_else(PoisonError::into_inner).insert(run, stored);
    }
}

impl InMemory {
    fn asked(&self) -> Vec<RunDigest> {
        std::mem::take(&mut self.asked.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Makes all runs of a unit and returns those that it needs, each once. What it builds on is made, too, and is not returned: that is in the
/// results of other units.
pub fn run_whole(
    planner: &Planner,
    executor: &dyn Executor,
    unit: usize,
    verify: VerifyRuns,
    number: Option<usize>,
    stop: &Stop,
) -> Result<SliceRuns, ShardError> {
    let results = InMemory::default();
    let pass = |absent: AbsentRuns| {
        // One that ends itself for want of a run must not end the others.
        let own = if absent == AbsentRuns::Refused { Stop::default() } else { stop.clone() };
        let from = FromResults::new(executor, planner.digests, &results, absent, &own);
        run_from(planner, &from, unit, verify, number, &own, &results);
        from.troubles()
    };
    pass(AbsentRuns::Made);
    if stop.is_requested() {
        return Err(ShardError::Stopped);
    }
    results.asked();
    if let Some(trouble) = pass(AbsentRuns::Refused).into_iter().next() {
        let message =
            format!("{} asked for other runs when it was repeated: {trouble}", planner.units.key(unit));
        return Err(ShardError::OtherFiles { message });
    }
    let mut known = HashSet::new();
    let asked = results.asked().into_iter().filter(|run| known.insert(*run));
    let runs = results.runs.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(asked.filter_map(|run| Some((run, runs.get(&run)?.clone()))).collect())
}

fn run_from(
    planner: &Planner,
    executor: &FromResults,
    unit: usize,
    verify: VerifyRuns,
    number: Option<usize>,
    stop: &Stop,
    results: &InMemory,
) {
    let (project, units) = (planner.project, planner.units);
    let runner = Runner::new(project.suites(), executor, project.registry())
        .verifying(verify)
        .reading(project.files())
        .stopped_by(stop);
    let mut only = vec![false; units.len()];
    only[unit] = true;
    let wanted = with_needs(units, only);
    let mut kept: HashMap<usize, Arc<Usable>> = HashMap::new();
    for index in (0..=unit).filter(|index| wanted[*index]) {
        let one = units.get(index);
        let needs: Option<Vec<_>> = one.needs.iter().map(|need| kept.get(need).cloned()).collect();
        // Without what it builds on it is not run here either.
        let Some(needs) = needs else { continue };
        if index == unit {
            results.asked();
            if let (Some(number), Work::Trial(trial)) = (number, &one.work) {
                runner.first_runs(one.suite).number(&trial.scenario, number);
            }
        }
        let report = runner.run_unit(&one, &Usable::gather(needs), &Silent);
        let mut controllers = tested_controllers(&runner.suites()[one.suite].suite);
        second_runs(runner.batch(), runner.first_runs(one.suite), &mut controllers);
        kept.extend(Usable::of(&one.work, &report).map(|usable| (index, Arc::new(usable))));
    }
}
