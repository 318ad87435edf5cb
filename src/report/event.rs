//! What happens while suites run: every report is fed by it.

use std::time::Duration;

use thiserror::Error;

use super::format::count;
use super::wording::stopping;
use super::{
    BlockReport, BlockState, CutBy, RecordedReport, Skip, SuiteIdentity, SuiteReport, TrialReport, TrialState,
};
use crate::judge::Verdict;
use crate::run::Requests;

/// One thing that happened; they come in order and from one thread.
#[derive(Debug)]
pub enum Event<'e, 'a> {
    Begun(&'e Outline),
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
        suite: &'e SuiteIdentity<'a>,
        report: &'e UnitReport<'a>,
    },
    /// No more units begin.
    Stopping(Stopping),
    /// Nothing happened; time goes on.
    Tick,
    Ended {
        reports: &'e [SuiteReport<'a>],
        requests: &'e Requests,
        elapsed: Duration,
    },
}

/// What is going to be done.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Outline {
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Stopping {
    /// So many failed that the rest does not matter.
    #[error("stopped after {} (--max-fail {_0})", count(*_0, "failure"))]
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

/// What became of one unit.
#[derive(Debug)]
pub enum UnitReport<'a> {
    Recorded(RecordedReport<'a>),
    Trial(TrialReport<'a>),
    Block(BlockReport<'a>),
}

impl UnitReport<'_> {
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

    /// What is to be said behind its key in a line of its own.
    pub fn remark(&self) -> String {
        match self {
            Self::Recorded(recorded) => recorded.remark(),
            Self::Trial(trial) => match (&trial.state, trial.stopping()) {
                (TrialState::Skipped(skip), _) => format!(": {skip}"),
                (TrialState::NotFinished(cut), _) => format!(": {cut}"),
                (_, Some(stopped)) => format!(" ({})", stopping(stopped)),
                _ => String::new(),
            },
            Self::Block(block) => match &block.state {
                BlockState::Skipped(skip) => format!(": {skip}"),
                BlockState::NotFinished(cut) => format!(": {cut}"),
                BlockState::Finished(_) | BlockState::Errored(_) => String::new(),
            },
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

/// How a unit stands, whatever its kind. The order is from good to bad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    Skipped,
    /// It was run, but no criterion applied to it: it is no evidence of anything.
    NotJudged,
    Judged(Verdict),
    /// It was begun, and cut off.
    NotFinished(CutBy),
    /// It could not be run to its end.
    Errored,
}

impl Standing {
    /// Whether it counts for `--max-fail`: an open question is no failure, nor is what somebody interrupted.
    pub fn is_failure(self) -> bool {
        matches!(self, Self::Judged(Verdict::Failed) | Self::NotFinished(CutBy::TimeLimit) | Self::Errored)
    }

    /// Of something that was run and has this verdict, if any.
    pub(super) fn of(skipped: bool, verdict: Option<Verdict>) -> Self {
        match verdict {
            _ if skipped => Self::Skipped,
            Some(verdict) => Self::Judged(verdict),
            None => Self::Errored,
        }
    }
}
