//! One concrete run: every expression evaluated, every parameter filled in.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Draw, Settings, Value, World};
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
    /// What the scenario drew for this run, in the order in which it is declared, people last; empty of one that draws nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drawn: Vec<Draw>,
    /// Why there is no such run, where what was drawn is not possible: whoever is to make it says so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub impossible: Option<String>,
    /// The parameter sets of pedestrians, in the order of the pedestrians that have one.
    pub individuals: Vec<Individual>,
    /// Counted from 1.
    pub repetition: u32,
    /// What every random stream of the run is derived from.
    #[serde(with = "json::whole")]
    pub seed: u64,
    /// Shared by all repetitions.
    pub world: Arc<World>,
}

impl Case {
    /// What it drew, but for people, as if it were given from outside.
    pub fn drawn_values(&self) -> impl Iterator<Item = Assignment> {
        let value = |one: &Draw| Assignment {
            name: one.name.clone(),
            label: one.label.clone(),
            value: one.value.clone(),
        };
        self.drawn.iter().filter(|one| !one.is_person()).map(value)
    }
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
