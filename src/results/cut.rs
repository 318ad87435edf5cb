//! What was begun and not finished: cut off from outside, so that nothing is known of it.

use std::time::Duration;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Who cut it off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CutBy {
    /// Somebody pressed Ctrl-C, or ended the program by a signal.
    Interrupted,
    /// The wall-clock limit: an error of the machine or of the limit, which says nothing of what is tested.
    TimeLimit,
    /// A sequential gate of its suite that failed, whatever the rest would have come to.
    GateFailed,
}

/// How far a unit came that is not finished. What it had found until then counts nowhere.
#[derive(Debug, Clone, PartialEq, Eq, Error, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cut {
    /// Somebody interrupted a trial.
    #[error("interrupted after {finished} of {runs} runs")]
    Trial {
        /// Runs that were done.
        finished: usize,
        /// Runs that the trial has.
        runs: usize,
    },
    /// A trial took longer than its scenario's `time_limit`.
    #[error("time limit of {} s exceeded after {finished} of {runs} runs", .limit.as_secs_f64())]
    TimeLimit {
        /// Of wall-clock time.
        limit: Duration,
        /// Runs that were done.
        finished: usize,
        /// Runs that the trial has.
        runs: usize,
    },
    /// A sequential gate failed before a trial had all its runs. Those that were made are told with it.
    #[error("a gate failed after {finished} of {runs} runs")]
    Gate {
        /// Runs that were done.
        finished: usize,
        /// Runs that the trial has.
        runs: usize,
    },
    /// A block; in words, with what is left of it.
    #[error("{0}")]
    Block(String),
}

impl Cut {
    /// What cut it off.
    pub fn by(&self) -> CutBy {
        match self {
            Self::Trial { .. } | Self::Block(_) => CutBy::Interrupted,
            Self::TimeLimit { .. } => CutBy::TimeLimit,
            Self::Gate { .. } => CutBy::GateFailed,
        }
    }

    /// Runs of a trial that were done.
    pub fn finished(&self) -> usize {
        match self {
            Self::Trial { finished, .. } | Self::TimeLimit { finished, .. } | Self::Gate { finished, .. } => {
                *finished
            }
            Self::Block(_) => 0,
        }
    }

    /// All there is to say about it.
    pub fn explained(&self) -> String {
        match self {
            Self::Trial { .. } | Self::Block(_) | Self::Gate { .. } => format!("not finished: {self}"),
            Self::TimeLimit { .. } => format!(
                "not finished: {self}. `time_limit` is wall-clock time: this machine was too slow, or the limit is too \
                 tight. Nothing is known of the trial; `horizon` is what bounds simulated time."
            ),
        }
    }
}

impl CutBy {
    /// The kind of error that it is in JUnit and the like.
    pub fn word(self) -> &'static str {
        match self {
            Self::Interrupted => "interrupted",
            Self::TimeLimit => "time_limit",
            Self::GateFailed => "gate_failed",
        }
    }
}
