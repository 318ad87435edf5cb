//! What is kept of a run, to be given to whoever asks for it again.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::build::RunError;
use super::job::{Job, JobFailure, LoggedDecision, Ran, Wanted};
use super::messagepack::{from_messagepack, to_messagepack};
use results::Outcome;

/// What came of a run, without what depends on the clock: equal runs are equal bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredRun {
    /// Whether what programs decided is there.
    decisions: bool,
    result: Result<Ran, JobFailure>,
}

impl StoredRun {
    /// Of what came of a job of which that was wanted. Courses are not kept.
    pub fn of(wanted: Wanted, result: &Result<Ran, JobFailure>) -> Self {
        let decisions = !matches!(wanted, Wanted::Outcome);
        let result = result.as_ref().map_err(Clone::clone).map(|ran| {
            let mut outcome = ran.outcome.clone();
            outcome.wall_time = Duration::ZERO;
            bare(outcome, if decisions { ran.decisions.clone() } else { Vec::new() })
        });
        Self { decisions, result }
    }

    /// Of a run that was not made, since its trial had taken longer than its `time_limit` by then.
    pub fn over_time_limit() -> Self {
        Self { decisions: false, result: Err(JobFailure::Error(RunError::TimeLimit)) }
    }

    /// What it says against another result of the same run, if that is not the same.
    pub(crate) fn against(&self, other: &Self) -> Option<Disagreement> {
        let outcome = |one: &Self| one.outcome_alone().to_bytes();
        if outcome(self) == outcome(other) {
            return None;
        }
        let name =
            |one: &Self| one.result.as_ref().map(|ran| (ran.outcome.key.clone(), ran.outcome.seed)).ok();
        let is_other = matches!((name(self), name(other)), (Some(one), Some(other)) if one != other);
        Some(if is_other { Disagreement::OtherRun } else { Disagreement::OtherResult })
    }

    /// Whether it is [`Self::over_time_limit`].
    pub fn is_over_time_limit(&self) -> bool {
        matches!(self.result, Err(JobFailure::Error(RunError::TimeLimit)))
    }

    /// What [`Self::from_bytes`] reads: MessagePack with names of fields, which carries every number to its last bit.
    pub fn to_bytes(&self) -> Vec<u8> {
        to_messagepack(self)
    }

    /// What [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// In the words of the decoder, if the bytes are something else.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        from_messagepack(bytes)
    }

    /// Whether the run came to its end.
    pub(super) fn has_ended(&self) -> bool {
        self.result.is_ok()
    }

    /// What it came to, of which alone is told.
    pub(super) fn outcome_alone(&self) -> Self {
        Self::of(Wanted::Outcome, &self.result)
    }

    /// Whether it says of itself that it came of that job.
    pub(super) fn is_of(&self, job: &Job) -> bool {
        self.result.as_ref().map_or(true, |Ran { outcome, .. }| {
            (outcome.key.as_str(), outcome.seed) == (job.case.key.as_str(), job.case.seed)
                && outcome.metrics.len() == job.measured.requests.iter().count()
        })
    }

    pub(super) fn is_enough(&self, wanted: Wanted) -> bool {
        // A run that did not come to its end has nothing more to tell.
        self.result.is_err() || wanted == Wanted::Outcome || self.decisions && wanted == Wanted::Decisions
    }

    /// As somebody is told who asked for it, for whom it took that long to be found: never no time, which a report would leave out.
    pub(super) fn told(self, wanted: Wanted, took: Duration) -> Result<Ran, JobFailure> {
        self.result.map(|ran| {
            let outcome = Outcome { wall_time: took.max(Duration::from_nanos(1)), ..ran.outcome };
            let decisions = if wanted == Wanted::Outcome { Vec::new() } else { ran.decisions };
            Ran { outcome, decisions, ..ran }
        })
    }
}

/// How two results of a run differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Disagreement {
    /// One says of itself that it is of another run.
    OtherRun,
    /// A machine computes otherwise, or a program decides otherwise the second time.
    OtherResult,
}

/// A run of which nothing else is told.
fn bare(outcome: Outcome, decisions: Vec<LoggedDecision>) -> Ran {
    Ran {
        outcome,
        decisions,
        trace: sim::Trace::default(),
        events: Vec::new(),
        commands: Vec::new(),
        details: None,
    }
}
