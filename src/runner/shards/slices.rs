//! The units of a batch whose runs are known beforehand, side by side.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use super::error::ShardError;
use super::planned_unit::{Planner, slice_id};
use crate::plan::PlannedTrial;
use crate::run::{
    Done, Executor, FirstRuns, Job, JobPlace, RunDigest, Sequence, Sequences, Stop, StoredRun, Wanted,
    run_sequences,
};

/// Some runs of a trial.
#[derive(Debug, Clone)]
pub struct TrialSlice {
    /// In the batch.
    pub place: usize,
    /// The unit of the session.
    pub unit: usize,
    pub first: usize,
    pub runs: usize,
    /// Of its first run among those of its scenario, where some runs are made twice.
    pub number: Option<usize>,
}

/// What came of a slice.
pub struct SliceResults {
    /// In the batch.
    pub place: usize,
    pub id: RunDigest,
    pub runs: SliceRuns,
    /// Whether its trial took longer than its `time_limit`.
    pub is_over_limit: bool,
}

/// What came of the runs of one, in their order.
pub type SliceRuns = Vec<(RunDigest, StoredRun)>;

/// Makes the runs of each slice.
pub fn run_slices(
    planner: &Planner,
    executor: &dyn Executor,
    first_runs: &FirstRuns,
    slices: Vec<TrialSlice>,
    stop: &Stop,
) -> Result<Vec<SliceResults>, ShardError> {
    let wanted = slices.len();
    let mut all =
        Slices { planner, first_runs, waiting: slices.into_iter(), done: Vec::with_capacity(wanted) };
    run_sequences(executor, &mut all, stop);
    if stop.is_requested() || all.done.len() < wanted {
        return Err(ShardError::Stopped);
    }
    Ok(all.done)
}

struct Slices<'s, 'a> {
    planner: &'s Planner<'a>,
    first_runs: &'s FirstRuns,
    waiting: std::vec::IntoIter<TrialSlice>,
    done: Vec<SliceResults>,
}

impl<'s, 'a> Sequences for Slices<'s, 'a> {
    type One = UnderWay<'s, 'a>;

    fn open(&mut self) -> Option<UnderWay<'s, 'a>> {
        let slice = self.waiting.next()?;
        let trial = self.planner.units.get(slice.unit).trial().expect("slices are of trials");
        let suite = self.planner.units.suite(slice.unit);
        let gated = !self.planner.project.suites()[suite].suite.gates.is_empty();
        let is_taken = |run: &usize| {
            slice.number.is_some_and(|number| {
                let case = trial.cases.get(*run);
                // What a gate asks for besides what its trial needed is counted from the trial's first run.
                self.first_runs.takes(number + run - slice.first, &case)
                    || gated && self.first_runs.takes(*run, &case)
            })
        };
        let twice = (slice.first..slice.first + slice.runs).filter(is_taken).collect();
        let (planner, asked, done) = (self.planner, Vec::new(), Vec::with_capacity(slice.runs));
        let limit = planner.time_limit(slice.unit);
        let (begun, is_over_limit) = (Instant::now(), false);
        Some(UnderWay { planner, slice, trial, twice, asked, done, limit, begun, is_over_limit })
    }

    fn close(&mut self, mut one: UnderWay<'s, 'a>, taken: usize) {
        if taken < one.runs() && !one.is_over_limit {
            return;
        }
        for run in one.done.len()..one.slice.runs {
            let job = self.planner.job(one.trial.cases.get(one.slice.first + run), Wanted::Outcome);
            one.done.push((self.planner.digests.of(&job), StoredRun::over_time_limit()));
        }
        let UnderWay { slice, done: runs, limit, is_over_limit, .. } = one;
        let id = slice_id(limit, runs.iter().take(slice.runs).map(|(run, _)| *run));
        self.done.push(SliceResults { place: slice.place, id, runs, is_over_limit });
    }
}

struct UnderWay<'s, 'a> {
    planner: &'s Planner<'a>,
    slice: TrialSlice,
    trial: PlannedTrial,
    /// The runs that are made a second time, alone.
    twice: Vec<usize>,
    /// Of the jobs that were given.
    asked: Vec<(RunDigest, Wanted)>,
    done: SliceRuns,
    /// Of its trial, of which it is all then.
    limit: Option<Duration>,
    begun: Instant,
    is_over_limit: bool,
}

impl Sequence for UnderWay<'_, '_> {
    fn runs(&self) -> usize {
        self.slice.runs + self.twice.len()
    }

    fn job(&mut self, place: JobPlace) -> Job {
        let TrialSlice { first, runs, .. } = self.slice;
        let alone = place.run >= runs;
        let run = if alone { self.twice[place.run - runs] } else { first + place.run };
        let wanted = if alone || self.twice.contains(&run) { Wanted::Decisions } else { Wanted::Outcome };
        let job = Job { place, alone, ..self.planner.job(self.trial.cases.get(run), wanted) };
        self.asked.push((self.planner.digests.of(&job), wanted));
        job
    }

    /// A run that fails is a result, too, and so are those behind it.
    fn take(&mut self, done: Done) -> ControlFlow<()> {
        let (run, wanted) = self.asked[self.done.len()];
        self.done.push((run, StoredRun::of(wanted, &done.result)));
        ControlFlow::Continue(())
    }

    /// As a trial is cut off in a session: between its runs, whose second times do not count.
    fn between(&mut self, taken: usize) -> ControlFlow<()> {
        let is_over = |limit: Duration| taken < self.slice.runs && self.begun.elapsed() > limit;
        if self.limit.is_some_and(is_over) {
            self.is_over_limit = true;
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}
