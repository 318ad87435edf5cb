//! One concrete run: every expression evaluated, every parameter filled in.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Settings, Value, World};
use numbers::json;

/// One run. Everything that decides its outcome is in here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Stable name such as `zebra/carla_walker/tta=6s/individual=17/rep=2`: names the run in every report, seeds it,
    /// and is what `scenario-runner replay` takes.
    pub key: String,
    /// Its scenario's name.
    pub scenario: String,
    /// The values of its variations, in the order in which they are declared.
    pub variation: Vec<Assignment>,
    /// The parameter sets drawn for pedestrians, in the order of the pedestrians that have one.
    pub individuals: Vec<Individual>,
    /// Counted from 1.
    pub repetition: u32,
    /// What every random stream of the run is derived from.
    #[serde(with = "json::whole")]
    pub seed: u64,
    /// Shared by all repetitions.
    pub world: Arc<World>,
}

/// A variation's name with the value it has in a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Assignment {
    /// Of the variation.
    pub name: String,
    /// The value as it was written, without spaces: `6s`. It is the part of the key.
    pub label: String,
    /// SI units.
    pub value: Value,
}

/// One person: a parameter set of a population.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Individual {
    /// The pedestrian who is that person, by name.
    pub pedestrian: String,
    /// `standard`, or the path of the file that the sets are in.
    pub population: String,
    /// Its number in the population, counted from 1.
    pub number: u32,
    /// By the names of the model's parameters, SI units.
    pub parameters: Settings,
}
