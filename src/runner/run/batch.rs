//! Many cases, and what came of each in their order.

use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::sync::Arc;

use thiserror::Error;

use super::build::RunError;
use super::executor::Executor;
use super::first_runs::FirstRuns;
use super::job::{Done, Job, JobFailure, JobPlace, MeasuredMetrics, Ran, Wanted};
use super::sequence::{Sequence, Sequences, run_sequences};
use super::stop::Stop;
use results::Outcome;
use scenario::Case;
use sim::RunChange;

/// Why there are no outcomes.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BatchError {
    /// A run could not be made, or not to its end.
    #[error("{key}: {error}")]
    Run {
        /// The run's key.
        key: String,
        /// Why.
        error: Box<RunError>,
    },
    /// Somebody wished it.
    #[error("interrupted")]
    Stopped,
}

/// Whatever makes runs, what is measured in them, and whether they are still wished for.
#[derive(Clone, Copy)]
pub struct RunBatch<'b> {
    /// Makes the runs.
    pub executor: &'b dyn Executor,
    /// What is measured in each.
    pub measured: &'b Arc<MeasuredMetrics>,
    /// Ends the batch when it is wished for.
    pub stop: &'b Stop,
}

impl RunBatch<'_> {
    /// Makes `runs` runs, whose cases are `case` of their index, and gives what came of each to `take`, in their order.
    ///
    /// # Errors
    /// The first, in order, that could not be made; or that not all were, since somebody wished to stop.
    ///
    /// # Panics
    /// As the first run, in order, that did.
    pub fn each(
        self,
        runs: usize,
        wanted: Wanted,
        case: impl FnMut(usize) -> Case + Send,
        take: impl FnMut(Case, Ran) + Send,
    ) -> Result<(), BatchError> {
        self.made(runs, |_, _: &Case| wanted, case, take)
    }

    fn made(
        self,
        runs: usize,
        wanted: impl FnMut(usize, &Case) -> Wanted + Send,
        case: impl FnMut(usize) -> Case + Send,
        take: impl FnMut(Case, Ran) + Send,
    ) -> Result<(), BatchError> {
        self.made_otherwise(None, runs, wanted, case, take)
    }

    fn made_otherwise(
        self,
        change: Option<&RunChange>,
        runs: usize,
        wanted: impl FnMut(usize, &Case) -> Wanted + Send,
        case: impl FnMut(usize) -> Case + Send,
        mut take: impl FnMut(Case, Ran) + Send,
    ) -> Result<(), BatchError> {
        let take = move |case: Case, ran: Option<Ran>| {
            if let Some(ran) = ran {
                take(case, ran);
            }
        };
        self.made_leaving_out(false, change, runs, wanted, case, take)
    }

    /// Gives nothing to `take` for a run that is left out.
    fn made_leaving_out(
        self,
        leaves_out: bool,
        change: Option<&RunChange>,
        runs: usize,
        wanted: impl FnMut(usize, &Case) -> Wanted + Send,
        case: impl FnMut(usize) -> Case + Send,
        take: impl FnMut(Case, Option<Ran>) + Send,
    ) -> Result<(), BatchError> {
        let Self { executor, measured, stop } = self;
        let one = One { runs, wanted, case, take, measured, change, leaves_out, failed: None };
        let mut only = Only { one: Some(one), begun: false, taken: 0 };
        run_sequences(executor, &mut only, stop);
        match only.one.and_then(|one| one.failed) {
            Some((key, JobFailure::Error(error))) => Err(BatchError::Run { key, error: Box::new(error) }),
            Some((_, JobFailure::Panicked(panicked))) => resume_unwind(Box::new(panicked)),
            None if only.taken < runs => Err(BatchError::Stopped),
            None => Ok(()),
        }
    }

    /// The outcomes of the cases, in their order. `done` is told after each.
    ///
    /// # Errors
    /// As for [`Self::each`].
    ///
    /// # Panics
    /// As for [`Self::each`].
    pub fn outcomes(
        self,
        cases: impl ExactSizeIterator<Item = Case> + Send,
        mut done: impl FnMut() + Send,
    ) -> Result<Vec<Outcome>, BatchError> {
        let mut cases = cases;
        let runs = cases.len();
        let mut outcomes = Vec::with_capacity(runs);
        let case = |_| cases.next().expect("there are as many as were counted");
        self.each(runs, Wanted::Outcome, case, |_, ran| {
            outcomes.push(ran.outcome);
            done();
        })?;
        Ok(outcomes)
    }

    /// As [`Self::outcomes`], the first case being the one of that number among those of which some runs are made a second time: they are
    /// kept.
    ///
    /// # Errors
    /// As for [`Self::each`].
    ///
    /// # Panics
    /// As for [`Self::each`].
    pub fn outcomes_keeping(
        self,
        first_runs: &FirstRuns,
        number: usize,
        cases: impl ExactSizeIterator<Item = Case> + Send,
        mut done: impl FnMut() + Send,
    ) -> Result<Vec<Outcome>, BatchError> {
        let mut cases = cases;
        let runs = cases.len();
        let mut outcomes = Vec::with_capacity(runs);
        let wanted = |run: usize, case: &Case| first_runs.wanted(number + run, case);
        let case = |_| cases.next().expect("there are as many as were counted");
        self.made(runs, wanted, case, |case, mut ran| {
            if first_runs.takes(number + outcomes.len(), &case) {
                first_runs.keep(&case, &mut ran);
            }
            outcomes.push(ran.outcome);
            done();
        })?;
        Ok(outcomes)
    }

    /// As [`Self::outcomes_keeping`]; `None` of a case in which [there is no encounter](RunError::is_no_encounter).
    ///
    /// # Errors
    /// As for [`Self::each`].
    ///
    /// # Panics
    /// As for [`Self::each`].
    pub fn outcomes_leaving_out(
        self,
        first_runs: &FirstRuns,
        number: usize,
        cases: impl ExactSizeIterator<Item = Case> + Send,
    ) -> Result<Vec<Option<Outcome>>, BatchError> {
        let mut cases = cases;
        let runs = cases.len();
        let mut outcomes = Vec::with_capacity(runs);
        let wanted = |run: usize, case: &Case| first_runs.wanted(number + run, case);
        let case = |_| cases.next().expect("there are as many as were counted");
        self.made_leaving_out(true, None, runs, wanted, case, |case, ran| {
            let keep = |mut ran: Ran| {
                if first_runs.takes(number + outcomes.len(), &case) {
                    first_runs.keep(&case, &mut ran);
                }
                ran.outcome
            };
            let outcome = ran.map(keep);
            outcomes.push(outcome);
        })?;
        Ok(outcomes)
    }

    /// What came of one case.
    ///
    /// # Errors
    /// As for [`Self::each`].
    ///
    /// # Panics
    /// As for [`Self::each`].
    pub fn one(self, case: &Case, wanted: Wanted) -> Result<Ran, BatchError> {
        self.one_otherwise(case, None, wanted)
    }

    /// What would have come of a case if something had gone otherwise.
    ///
    /// # Errors
    /// As for [`Self::each`].
    ///
    /// # Panics
    /// As for [`Self::each`].
    pub fn one_otherwise(
        self,
        case: &Case,
        change: Option<&RunChange>,
        wanted: Wanted,
    ) -> Result<Ran, BatchError> {
        let mut result = None;
        self.made_otherwise(change, 1, |_, _| wanted, |_| case.clone(), |_, ran| result = Some(ran))?;
        Ok(result.expect("a run that was made came to something"))
    }
}

/// The only sequence of a batch.
struct One<'b, W, C, T> {
    runs: usize,
    wanted: W,
    case: C,
    take: T,
    measured: &'b Arc<MeasuredMetrics>,
    change: Option<&'b RunChange>,
    leaves_out: bool,
    failed: Option<(String, JobFailure)>,
}

impl<W, C, T> Sequence for One<'_, W, C, T>
where
    W: FnMut(usize, &Case) -> Wanted + Send,
    C: FnMut(usize) -> Case + Send,
    T: FnMut(Case, Option<Ran>) + Send,
{
    fn runs(&self) -> usize {
        self.runs
    }

    fn job(&mut self, place: JobPlace) -> Job {
        let case = (self.case)(place.run);
        let wanted = (self.wanted)(place.run, &case);
        let change = self.change.cloned().map(Box::new);
        Job { place, case, measured: self.measured.clone(), wanted, alone: false, change }
    }

    fn take(&mut self, done: Done) -> ControlFlow<()> {
        match done.result {
            Ok(ran) => {
                (self.take)(done.case, Some(ran));
                ControlFlow::Continue(())
            }
            Err(JobFailure::Error(error)) if self.leaves_out && error.is_no_encounter() => {
                (self.take)(done.case, None);
                ControlFlow::Continue(())
            }
            Err(failure) => {
                self.failed = Some((done.case.key, failure));
                ControlFlow::Break(())
            }
        }
    }
}

struct Only<T> {
    one: Option<T>,
    begun: bool,
    taken: usize,
}

impl<T: Sequence> Sequences for Only<T> {
    type One = T;

    fn open(&mut self) -> Option<T> {
        if std::mem::replace(&mut self.begun, true) { None } else { self.one.take() }
    }

    fn close(&mut self, one: T, taken: usize) {
        (self.one, self.taken) = (Some(one), taken);
    }
}
