//! The kinds of entries that a registry has, each by the name that errors give it.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What a name of a registry is the name of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EntryKind {
    /// What `model` of a pedestrian names.
    PedestrianModel,
    /// What `controller` of a vehicle names.
    Controller,
    /// What `dynamics` of a vehicle names.
    VehicleDynamics,
    /// What `sees { … }` of a vehicle says.
    Perception,
    /// What criteria, searches and reports name.
    Metric,
}

impl fmt::Display for EntryKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::PedestrianModel => "pedestrian model",
            Self::Controller => "controller",
            Self::VehicleDynamics => "vehicle dynamics",
            Self::Perception => "perception",
            Self::Metric => "metric",
        })
    }
}
