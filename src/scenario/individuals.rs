//! Whose parameter sets a pedestrian walks with.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::Origin;

/// Where a pedestrian's parameter sets come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Individuals {
    /// Which sets of the population.
    pub selection: PopulationShare,
    /// `standard` or a file's path, resolved against the file that names it.
    pub population: String,
    /// What stands in the file, or why it cannot be read; `None` of what ships.
    #[serde(skip)]
    pub text: Option<Result<Arc<str>, String>>,
    /// Where it is written.
    pub origin: Origin,
}

/// How many of a population walk.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PopulationShare {
    /// Everybody.
    All,
    /// This many, drawn without replacement by the suite's seed.
    Count(u32),
    /// One by its number.
    Number(u32),
    /// Somebody else in every run, drawn with replacement.
    Drawn,
}
