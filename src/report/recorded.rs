//! What became of runs that failed before and were run again.

use std::time::Duration;

use super::event::Standing;
use super::{Skip, TrialState};
use crate::corpus::Recorded;
use crate::judge::{Finding, TrialVerdict, Verdict};
use crate::run::Outcome;

/// A recorded run, run again.
#[derive(Debug)]
pub struct RecordedReport<'a> {
    pub recorded: &'a Recorded,
    /// Such as `zebra/recorded=carla_walker/tta=6s/rep=2`.
    pub key: String,
    pub state: RecordedState,
    pub wall_time: Duration,
}

#[derive(Debug, Clone)]
pub enum RecordedState {
    Ran(Box<Rerun>),
    /// Could not be run to its end; the message says why.
    Errored(String),
    Skipped(Skip),
}

/// One run of a recorded case.
#[derive(Debug, Clone)]
pub struct Rerun {
    pub outcome: Outcome,
    /// Whether everything that decides the run is as it was when it was recorded.
    pub same_case: bool,
    /// By the criteria that a single run can fail.
    pub judged: TrialVerdict,
    /// Criteria over many runs that it still speaks against; their trials decide.
    pub against: Vec<Finding>,
}

impl RecordedReport<'_> {
    /// The new run, if there was one.
    pub fn rerun(&self) -> Option<&Rerun> {
        match &self.state {
            RecordedState::Ran(rerun) => Some(rerun),
            RecordedState::Errored(_) | RecordedState::Skipped(_) => None,
        }
    }

    /// Why it was not run, if it was not.
    pub fn skip(&self) -> Option<&Skip> {
        match &self.state {
            RecordedState::Skipped(skip) => Some(skip),
            _ => None,
        }
    }

    pub fn standing(&self) -> Standing {
        Standing::of(self.skip().is_some(), self.rerun().map(|rerun| rerun.judged.verdict))
    }

    /// Whether there is no more reason to keep it: it speaks against nothing, or it cannot be run any more.
    pub fn is_obsolete(&self) -> bool {
        match &self.state {
            RecordedState::Ran(rerun) => rerun.judged.verdict == Verdict::Passed && rerun.against.is_empty(),
            RecordedState::Skipped(skip) => matches!(skip, Skip::Stale(_)),
            RecordedState::Errored(_) => false,
        }
    }

    /// What is to be said of it behind its key; empty if the failure itself says all.
    pub fn remark(&self) -> String {
        let rerun = match &self.state {
            RecordedState::Ran(rerun) => rerun,
            RecordedState::Skipped(skip) => return format!(": {skip}"),
            RecordedState::Errored(_) => return String::new(),
        };
        let against: Vec<_> = rerun.against.iter().map(|one| format!("`{}`", one.criterion)).collect();
        let changed = if rerun.same_case { "" } else { " (the case has changed since)" };
        match rerun.judged.verdict {
            Verdict::Passed if against.is_empty() => format!(": does not fail any more{changed}"),
            Verdict::Passed => format!(": still speaks against {}{changed}", against.join(", ")),
            _ => changed.to_string(),
        }
    }

    /// Its new run as the verdict of a trial, for what draws those.
    pub(super) fn trial_state(&self) -> TrialState {
        match &self.state {
            RecordedState::Ran(rerun) => TrialState::Judged(rerun.judged.clone()),
            RecordedState::Errored(message) => TrialState::Errored(message.clone()),
            RecordedState::Skipped(skip) => TrialState::Skipped(skip.clone()),
        }
    }
}
