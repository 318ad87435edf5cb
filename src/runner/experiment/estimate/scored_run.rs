//! What became of a run of an estimate.

use serde::{Deserialize, Serialize};

use numbers::rare::RareOutcome;

/// What became of a run, as the journal keeps it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ScoredRun {
    /// Whether it has the event, or may have.
    pub event: bool,
    /// Whether it may have, and may not.
    pub undecided: bool,
    /// How far it was from the event, the less the nearer; `None` where the metric says nothing.
    pub score: Option<f64>,
}

impl ScoredRun {
    pub fn outcome(self) -> RareOutcome {
        RareOutcome { event: self.event, score: self.score.unwrap_or(f64::INFINITY) }
    }
}
