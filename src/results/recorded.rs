//! What became of runs that failed before and were run again.

use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::finding::Finding;
use super::outcome::Outcome;
use super::skip::Skip;
use super::standing::Standing;
use super::trial::{TrialState, TrialVerdict};
use super::unit_error::UnitError;
use crate::Verdict;
use numbers::json;
use scenario::Assignment;

/// What is kept of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recorded {
    /// The run's key when it was recorded.
    pub key: String,
    /// The scenario's name.
    pub scenario: String,
    /// The seed of the run.
    #[serde(with = "json::whole")]
    pub seed: u64,
    /// The values of its variations.
    pub variation: Vec<Assignment>,
    /// Pedestrian, number and population of each person.
    pub people: Vec<(String, u32, String)>,
    /// Hash over everything that decides the run.
    #[serde(with = "json::hexadecimal")]
    pub case: u64,
    /// The run's fingerprint.
    #[serde(with = "json::hexadecimal")]
    pub fingerprint: u64,
    /// What it spoke against, such as `no collision: collision yes`.
    pub against: Vec<String>,
}

impl Recorded {
    /// Its name as a unit: `zebra/recorded=carla_walker/tta=6s/rep=2`.
    pub fn unit_key(&self) -> String {
        match self.key.split_once('/') {
            Some((suite, rest)) => format!("{suite}/recorded={rest}"),
            None => format!("recorded={}", self.key),
        }
    }
}

/// A recorded run, run again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordedReport {
    /// What was kept of it.
    pub recorded: Arc<Recorded>,
    /// Such as `zebra/recorded=carla_walker/tta=6s/rep=2`.
    pub key: String,
    /// What became of it now.
    pub state: RecordedState,
    /// How long it took.
    pub wall_time: Duration,
}

/// What became of a recorded run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RecordedState {
    /// It was run to its end.
    Ran(Box<Rerun>),
    /// Could not be run to its end.
    Errored(UnitError),
    /// Nobody tried to run it.
    Skipped(Skip),
}

/// One run of a recorded case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rerun {
    /// What the run came to.
    pub outcome: Outcome,
    /// Whether everything that decides the run is as it was when it was recorded.
    pub same_case: bool,
    /// By the criteria that a single run can fail.
    pub judged: TrialVerdict,
    /// Criteria over many runs that it still speaks against; their trials decide.
    pub against: Vec<Finding>,
    /// Whether it may come out differently the next time, since a program that decides in it is not deterministic.
    #[serde(default)]
    pub may_differ: bool,
}

impl RecordedReport {
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

    /// How it stands, for counts and exit codes.
    pub fn standing(&self) -> Standing {
        Standing::of(self.skip().is_some(), self.rerun().map(|rerun| rerun.judged.verdict))
    }

    /// Whether there is no more reason to keep it: it speaks against nothing, or it cannot be run any more.
    pub fn is_obsolete(&self) -> bool {
        match &self.state {
            RecordedState::Ran(rerun) => {
                // What passes by chance may fail again.
                rerun.judged.verdict == Verdict::Passed && rerun.against.is_empty() && !rerun.may_differ
            }
            RecordedState::Skipped(skip) => matches!(skip, Skip::Stale(_)),
            RecordedState::Errored(_) => false,
        }
    }

    /// Its new run as the verdict of a trial, for what draws those.
    pub fn trial_state(&self) -> TrialState {
        match &self.state {
            RecordedState::Ran(rerun) => TrialState::Judged(rerun.judged.clone()),
            RecordedState::Errored(message) => TrialState::Errored(message.clone()),
            RecordedState::Skipped(skip) => TrialState::Skipped(skip.clone()),
        }
    }
}
