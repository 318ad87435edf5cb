//! What became of a trial.

use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::cut::Cut;
use super::finding::Finding;
use super::outcome::{OnCourse, Outcome, Outlasted, WaitingStep};
use super::skip::Skip;
use super::standing::Standing;
use super::unit_error::UnitError;
use crate::Verdict;
use scenario::Trial;

/// A trial's verdict: the worst of its findings; without any it is `Passed`, which [says nothing](Self::claims_nothing).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialVerdict {
    /// The worst of the findings.
    pub verdict: Verdict,
    /// One per criterion that applies to the trial, in order.
    pub findings: Vec<Finding>,
    /// Where runs were added until the criteria were decided: how many it took and why there were no more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopping: Option<RunsTaken>,
    /// What the horizon cut off, if it ended any of the runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizon: Option<Horizon>,
    /// Steps of scripts that began in no run: what they were to bring about was not put to the test.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub never_began: Vec<WaitingStep>,
    /// Vehicles whose bodies left their carriageways, where no criterion is about that.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_road: Vec<LeftRoad>,
    /// Streams whose last vehicle had passed before somebody went across.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outlasted: Vec<OutlastedRuns>,
}

/// A stream that a pedestrian outlasted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct OutlastedRuns {
    /// Which, and who.
    #[serde(flatten)]
    pub outlasted: Outlasted,
    /// In so many runs.
    pub runs: usize,
    /// Of so many in all.
    pub of: usize,
}

/// A vehicle whose body left its carriageway.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftRoad {
    /// The vehicle's name.
    pub vehicle: Arc<str>,
    /// In so many runs.
    pub runs: usize,
    /// Of so many in all.
    pub of: usize,
}

/// The runs of a trial that the horizon ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Horizon {
    /// How many there are.
    pub runs: usize,
    /// Of so many in all.
    pub of: usize,
    /// Those in which somebody who had not been hit had not arrived.
    pub stranded: Vec<Stranded>,
    /// Those that ended with somebody on a collision course, and with whom: one per pair.
    pub on_course: Vec<CourseOfRun>,
}

/// Who had not arrived in a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stranded {
    /// The run's key.
    pub key: String,
    /// Names of vehicles and pedestrians.
    pub who: Vec<Arc<str>>,
}

/// Who would have touched in a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CourseOfRun {
    /// The run's key.
    pub key: String,
    /// Who would have touched, and when.
    #[serde(flatten)]
    pub course: OnCourse,
}

/// How many runs a trial took, and why there were no more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunsTaken {
    /// Runs before which nobody looked.
    pub least: usize,
    /// Runs after which none would have been added.
    pub most: usize,
    /// Runs that were made.
    pub runs: usize,
    /// Why there were no more.
    pub reason: Reason,
}

/// Why no more runs were added.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// Every criterion with stated confidence is decided.
    Decided,
    /// There were as many runs as there may be.
    Budget,
    /// No criterion has a stated confidence.
    NothingToDecide,
}

/// A trial with the outcomes of its runs and what they come to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialReport {
    /// What was run.
    pub trial: Arc<Trial>,
    /// Empty if it was not run, or what it had found counts nowhere.
    pub outcomes: Vec<Outcome>,
    /// What it came to.
    pub state: TrialState,
    /// Models that its world makes other ones than were published, a sentence each.
    pub departures: Vec<String>,
    /// How long it took.
    pub wall_time: Duration,
}

/// Whether a trial was judged, or why not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrialState {
    /// All of its runs were made.
    Judged(TrialVerdict),
    /// Could not be run to its end.
    Errored(UnitError),
    /// Begun, and cut off.
    NotFinished(Cut),
    /// Nobody tried to run it.
    Skipped(Skip),
}

impl TrialVerdict {
    /// Whether something passed that was not put to the test.
    pub fn is_untested(&self) -> bool {
        !self.never_began.is_empty() || self.findings.iter().any(|finding| finding.untested.is_some())
    }
}

impl TrialReport {
    /// What was found of each of its criteria, if it was run.
    pub fn findings(&self) -> &[Finding] {
        match &self.state {
            TrialState::Judged(judged) => &judged.findings,
            TrialState::Errored(_) | TrialState::NotFinished(_) | TrialState::Skipped(_) => &[],
        }
    }

    /// How many runs it took, where they were added until it was decided.
    pub fn stopping(&self) -> Option<&RunsTaken> {
        match &self.state {
            TrialState::Judged(judged) => judged.stopping.as_ref(),
            TrialState::Errored(_) | TrialState::NotFinished(_) | TrialState::Skipped(_) => None,
        }
    }

    /// How many runs were made, be it in vain.
    pub fn made(&self) -> usize {
        match &self.state {
            TrialState::Errored(error) => error.made(),
            TrialState::NotFinished(cut) => cut.finished(),
            TrialState::Judged(_) | TrialState::Skipped(_) => self.outcomes.len(),
        }
    }

    /// Why it could not be run to its end, if it could not.
    pub fn error(&self) -> Option<&UnitError> {
        match &self.state {
            TrialState::Errored(error) => Some(error),
            _ => None,
        }
    }

    /// Whether nobody tried to run it.
    pub fn skipped(&self) -> bool {
        self.skip().is_some()
    }

    /// Why nobody tried to run it.
    pub fn skip(&self) -> Option<&Skip> {
        match &self.state {
            TrialState::Skipped(skip) => Some(skip),
            _ => None,
        }
    }

    /// Of a trial that was judged; `None` for others.
    pub fn verdict(&self) -> Option<Verdict> {
        match &self.state {
            TrialState::Judged(judged) => Some(judged.verdict),
            TrialState::Errored(_) | TrialState::NotFinished(_) | TrialState::Skipped(_) => None,
        }
    }

    /// Whether it was run, but no criterion applied to it: it passed nothing.
    pub fn claims_nothing(&self) -> bool {
        matches!(&self.state, TrialState::Judged(judged) if judged.claims_nothing())
    }

    /// How it stands, for counts and exit codes.
    pub fn standing(&self) -> Standing {
        match &self.state {
            TrialState::NotFinished(cut) => Standing::NotFinished(cut.by()),
            TrialState::Judged(judged) if judged.claims_nothing() => Standing::NotJudged,
            _ => Standing::of(self.skipped(), self.verdict()),
        }
    }
}
