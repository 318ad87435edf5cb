//! What gets a verdict: a scenario with one value for each of its variations.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Assignment, Criterion, Origin};

/// A scenario with one value for each of its variations. Its runs are not in here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Stable name such as `zebra/carla_walker/tta=6s`, the beginning of its runs' keys.
    pub key: String,
    /// The scenario's name.
    pub scenario: String,
    /// What the scenario says of itself.
    pub doc: Option<String>,
    /// Those of the scenario.
    pub tags: Vec<String>,
    /// The values of its variations, in the order in which they are declared.
    pub variation: Vec<Assignment>,
    /// All the runs that there may be, one per individual and repetition; at least 1.
    pub runs: usize,
    /// The key of the first of them.
    pub first_run: String,
    /// Where runs are added until the criteria are decided: how.
    pub rounds: Option<Rounds>,
    /// Those whose `when` holds, with every bound a constant; trials to which the same apply share them.
    pub criteria: Arc<[Criterion]>,
    /// How many criteria its scenario has, whether they apply to this trial or not.
    pub declared: usize,
    /// Where the scenario is declared.
    pub origin: Origin,
}

/// Runs that are added until the criteria of a trial are decided, a round at a time: everybody once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rounds {
    /// Runs of a round: one per individual, or one.
    pub size: usize,
    /// Runs before which nobody looks; whole rounds, as is `most`.
    pub least: usize,
    /// Runs after which nothing more is added.
    pub most: usize,
}

impl Trial {
    /// How many runs there will be for certain.
    pub fn certain_runs(&self) -> usize {
        self.rounds.map_or(self.runs, |rounds| rounds.least)
    }
}
