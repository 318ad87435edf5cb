//! What gets a verdict: a scenario with one value for each of its variations.

use serde::{Deserialize, Serialize};

use super::{Assignment, Criterion, Origin};

/// A scenario with one value for each of its variations. Its runs are not in here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Stable name such as `zebra/carla_walker/tta=6s`, the beginning of its runs' keys.
    pub key: String,
    pub scenario: String,
    pub doc: Option<String>,
    pub tags: Vec<String>,
    pub variation: Vec<Assignment>,
    /// All the runs that there may be, one per individual and repetition; at least 1.
    pub runs: usize,
    /// The key of the first of them.
    pub first_run: String,
    /// Where runs are added until the criteria are decided: how.
    pub rounds: Option<Rounds>,
    /// Those whose `when` holds, with every bound a constant.
    pub criteria: Vec<Criterion>,
    /// How many criteria its scenario has, whether they apply to this trial or not.
    pub declared: usize,
    pub origin: Origin,
}

/// Runs that are added until the criteria of a trial are decided, a round at a time: everybody once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rounds {
    /// Runs of a round: one per individual, or one.
    pub size: usize,
    /// Runs before which nobody looks; whole rounds, as is `most`.
    pub least: usize,
    pub most: usize,
}

impl Trial {
    /// How many runs there will be for certain.
    pub fn certain_runs(&self) -> usize {
        self.rounds.map_or(self.runs, |rounds| rounds.least)
    }
}
