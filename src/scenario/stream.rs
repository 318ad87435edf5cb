//! Traffic: vehicles of one lane that arrive one after the other.

use serde::{Deserialize, Serialize};

/// The vehicles of a stream in one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stream {
    /// As the scenario calls it.
    pub name: String,
    /// Indices into [`World::vehicles`](crate::World::vehicles), in the order in which they arrive; at least 1. All drive on one lane.
    pub vehicles: Vec<usize>,
    /// When the centre of each would be at the middle of the crossing if it kept its cruise, s: one for each vehicle, rising.
    pub arrivals: Vec<f64>,
}

impl Stream {
    /// What the member with this index from 0 is called: `cars_1` is the first of `cars`.
    pub fn member_name(name: &str, index: usize) -> String {
        format!("{name}_{}", index + 1)
    }
}
