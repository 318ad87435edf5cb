//! What became of a run of an estimate, and of an encounter of two.

use serde::{Deserialize, Serialize};

use numbers::rare::{PairedEvent, RareOutcome};

/// What became of a run, as the journal keeps it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ScoredRun {
    /// Whether it has the event, or may have.
    pub event: bool,
    /// Whether it may have, and may not.
    pub undecided: bool,
    /// Whether it has not the event, and ended before the end of what that is about was seen.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub cut_off: bool,
    /// Whether anything that the event is about was at stake.
    pub encounter: bool,
    /// Whether the encounter cannot be, in either scenario: the probability leaves it out.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub left_out: bool,
    /// How far it was from the event, the less the nearer; `None` where the metric says nothing.
    pub score: Option<f64>,
}

/// What became of an encounter: of a run of the estimate's own scenario, and of one of the scenario that it is compared with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScoredEncounter {
    pub own: ScoredRun,
    pub other: Option<ScoredRun>,
}

impl ScoredRun {
    /// Of a point that nobody draws.
    pub const NOBODY: Self = Self {
        event: false,
        undecided: false,
        cut_off: false,
        encounter: false,
        left_out: false,
        score: None,
    };
    /// Of an encounter that there is not.
    pub const LEFT_OUT: Self = Self { left_out: true, ..Self::NOBODY };

    fn distance(self) -> f64 {
        self.score.unwrap_or(f64::INFINITY)
    }
}

impl ScoredEncounter {
    /// Where it cannot be said it counts against what is claimed: as if the first had it, and the second had not.
    pub fn event(self) -> PairedEvent {
        let second = self.other.is_some_and(|other| other.event && !other.undecided);
        PairedEvent { first: self.own.event, second }
    }

    /// What methods are told: whether either has it, and how near the nearer came.
    pub fn outcome(self) -> RareOutcome {
        let PairedEvent { first, second } = self.event();
        let other = self.other.map_or(f64::INFINITY, ScoredRun::distance);
        RareOutcome { event: first || second, score: self.own.distance().min(other) }
    }
}
