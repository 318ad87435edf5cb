//! What happens while suites run: every report is fed by it.

use std::time::Duration;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::block::BlockReport;
use super::recorded::RecordedReport;
use super::requests::Requests;
use super::skip::Skip;
use super::standing::Standing;
use super::suite::{SuiteIdentity, SuiteReport};
use super::trial::TrialReport;

/// One thing that happened; they come in order and from one thread.
#[derive(Debug)]
pub enum Event<'e> {
    Begun(&'e Workload),
    /// A unit begins; `runs` is how many a trial has, 0 for a block.
    UnitBegun {
        unit: usize,
        key: &'e str,
        runs: usize,
    },
    /// One more run of a trial is done.
    RunDone {
        unit: usize,
    },
    /// A block has got further.
    Evaluated {
        unit: usize,
        evaluations: Evaluations,
    },
    Finished {
        unit: usize,
        suite: &'e SuiteIdentity,
        report: &'e UnitReport,
    },
    /// No more units begin.
    Stopping(Stopping),
    /// Nothing happened; time goes on.
    Tick,
    Ended {
        reports: &'e [SuiteReport],
        requests: &'e Requests,
        elapsed: Duration,
    },
}

/// What is going to be done.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Workload {
    pub suites: usize,
    pub trials: usize,
    /// Of those trials: all that there may be.
    pub runs: usize,
    /// Of them, those that there will be for certain.
    pub certain_runs: usize,
    pub blocks: usize,
    /// Runs that failed before and are run again.
    pub recorded: usize,
    /// Units that were not selected.
    pub left_out: usize,
}

/// How far a block is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evaluations {
    pub done: usize,
    pub all: usize,
    /// The best value of the objective so far.
    pub best: Option<f64>,
}

/// Why no more units begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stopping {
    /// So many failed that the rest does not matter.
    #[error("stopped after {_0} {} (--max-fail {_0})", if *_0 == 1 { "failure" } else { "failures" })]
    MaxFail(usize),
    /// Somebody pressed Ctrl-C.
    #[error("interrupted")]
    Interrupted,
}

/// Told everything that happens.
pub trait Reporter {
    fn tell(&mut self, event: &Event);

    /// Called when there is nothing more to tell for the moment: the time to write what was collected.
    fn flush(&mut self) {}
}

/// Hears nothing: for whoever wants the results alone.
pub struct Unheard;

impl Reporter for Unheard {
    fn tell(&mut self, _: &Event) {}
}

/// What became of one unit.
#[derive(Debug)]
pub enum UnitReport {
    Recorded(RecordedReport),
    Trial(TrialReport),
    Block(BlockReport),
}

impl UnitReport {
    pub fn key(&self) -> &str {
        match self {
            Self::Recorded(recorded) => &recorded.key,
            Self::Trial(trial) => &trial.trial.key,
            Self::Block(block) => &block.key,
        }
    }

    pub fn wall_time(&self) -> Duration {
        match self {
            Self::Recorded(recorded) => recorded.wall_time,
            Self::Trial(trial) => trial.wall_time,
            Self::Block(block) => block.wall_time,
        }
    }

    /// Why it was not run, if it was not.
    pub fn skip(&self) -> Option<&Skip> {
        match self {
            Self::Recorded(recorded) => recorded.skip(),
            Self::Trial(trial) => trial.skip(),
            Self::Block(block) => block.skip(),
        }
    }

    pub fn standing(&self) -> Standing {
        match self {
            Self::Recorded(recorded) => recorded.standing(),
            Self::Trial(trial) => trial.standing(),
            Self::Block(block) => block.standing(),
        }
    }
}
