//! What happens while suites run: every report is fed by it.

use std::time::Duration;

use super::block::BlockReport;
use super::recorded::RecordedReport;
use super::requests::Requests;
use super::skip::{Skip, Stopping};
use super::standing::Standing;
use super::suite::{SuiteIdentity, SuiteReport};
use super::trial::TrialReport;

/// One thing that happened; they come in order and from one thread.
#[derive(Debug)]
pub enum Event<'e> {
    /// The session begins: the first event.
    Begun(&'e Workload),
    /// A unit begins; `runs` is how many a trial has, 0 for a block.
    UnitBegun {
        /// The unit's index in the session.
        unit: usize,
        /// The unit's key.
        key: &'e str,
        /// 0 for a block.
        runs: usize,
    },
    /// One more run of a trial is done.
    RunDone {
        /// The unit's index in the session.
        unit: usize,
    },
    /// A run of a trial was made before that begins, to know what its runs take; that it is done is told besides.
    PilotRun {
        /// The unit's index in the session.
        unit: usize,
        /// How many runs the trial has.
        runs: usize,
        /// What it took by itself.
        took: Duration,
    },
    /// A block has got further.
    Evaluated {
        /// The unit's index in the session.
        unit: usize,
        /// How far it is.
        evaluations: Evaluations,
    },
    /// A unit is over.
    Finished {
        /// Its index in the session.
        unit: usize,
        /// The suite that it belongs to.
        suite: &'e SuiteIdentity,
        /// What became of it.
        report: &'e UnitReport,
        /// What was measured in every run.
        requests: &'e Requests,
    },
    /// No more units begin.
    Stopping(Stopping),
    /// Nothing happened; time goes on.
    Tick,
    /// All units are over.
    Ended {
        /// What became of every suite.
        reports: &'e [SuiteReport],
        /// What was measured in every run.
        requests: &'e Requests,
        /// Wall-clock time of the session.
        elapsed: Duration,
    },
    /// After that, what takes all runs is judged: the key of a gate; `None` once all are.
    Judging(Option<&'e str>),
}

/// What is going to be done.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Workload {
    /// Suites with anything to do.
    pub suites: usize,
    /// Trials to run.
    pub trials: usize,
    /// Of those trials: all that there may be.
    pub runs: usize,
    /// Of them, those that there will be for certain.
    pub certain_runs: usize,
    /// Blocks to run.
    pub blocks: usize,
    /// Runs that failed before and are run again.
    pub recorded: usize,
    /// Units that were not selected.
    pub left_out: usize,
}

/// How far a block is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evaluations {
    /// Evaluations that are done.
    pub done: usize,
    /// Evaluations that there will be at most.
    pub all: usize,
    /// The best value of the objective so far, or what is estimated so far.
    pub best: Option<f64>,
    /// Of an estimate, between what it lies so far at 95 %.
    pub within: Option<(f64, f64)>,
}

/// Told everything that happens.
pub trait Reporter {
    /// Takes note of what happened. It is called in the order of events; the session waits for it.
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
    /// A run that failed before and was run again.
    Recorded(RecordedReport),
    /// A trial.
    Trial(TrialReport),
    /// A block.
    Block(BlockReport),
}

impl UnitReport {
    /// The unit's key.
    pub fn key(&self) -> &str {
        match self {
            Self::Recorded(recorded) => &recorded.key,
            Self::Trial(trial) => &trial.trial.key,
            Self::Block(block) => &block.key,
        }
    }

    /// How long the unit took.
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

    /// How it stands, for counts and exit codes.
    pub fn standing(&self) -> Standing {
        match self {
            Self::Recorded(recorded) => recorded.standing(),
            Self::Trial(trial) => trial.standing(),
            Self::Block(block) => block.standing(),
        }
    }
}
