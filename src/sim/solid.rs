//! Bodies by what they are, and their outlines.

use serde::{Deserialize, Serialize};

use super::geometry::Footprint;
use scenario::agent::Snapshot;
use scenario::{Body, World};

/// A body by its index among its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Solid {
    /// By its index in [`World::vehicles`].
    Vehicle(usize),
    /// By their index in [`World::pedestrians`].
    Pedestrian(usize),
    /// Of the road, such as a parked vehicle.
    Box(usize),
}

impl Solid {
    /// Its name in the scenario.
    pub fn name(self, world: &World) -> &str {
        match self {
            Self::Vehicle(index) => &world.vehicles[index].name,
            Self::Pedestrian(index) => &world.pedestrians[index].name,
            Self::Box(index) => &world.road.boxes[index].name,
        }
    }

    /// Its outline, if it is there.
    pub(super) fn footprint(self, state: &Snapshot, boxes: &[Body]) -> Option<Footprint> {
        match self {
            Self::Vehicle(index) => Some((&state.vehicles[index]).into()),
            Self::Pedestrian(index) => {
                let person = &state.pedestrians[index];
                person.present.then(|| person.into())
            }
            Self::Box(index) => Some((&boxes[index]).into()),
        }
    }
}
