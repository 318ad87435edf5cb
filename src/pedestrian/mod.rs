//! Pedestrian models, one file or folder each, and their registry.

pub mod commotions;
pub mod population;

mod carla_walker;
mod interceptor;
mod jaywalker;
mod scripted;
mod social_force;
#[cfg(test)]
mod test_walk;
mod timeline;

use crate::scenario::{Declaration, PedestrianSetup, Settings, World};
use crate::sim::{ModelError, Pedestrian};

/// A registered pedestrian model.
pub struct PedestrianModel {
    pub declaration: Declaration,
    /// Whether its parameter sets may come from a population of individuals.
    pub takes_individuals: bool,
    pub build: fn(&PedestrianContext) -> Result<Box<dyn Pedestrian>, ModelError>,
}

/// What a pedestrian model is built from.
#[derive(Clone, Copy)]
pub struct PedestrianContext<'a> {
    /// Resolved against the model's declaration.
    pub settings: &'a Settings,
    pub setup: &'a PedestrianSetup,
    pub world: &'a World,
    /// Index of the pedestrian in the world.
    pub index: usize,
    /// The run's seed, for [`crate::sim::random::stream`].
    pub seed: u64,
}

/// Every pedestrian model there is, by name.
#[rustfmt::skip]
pub static MODELS: &[&PedestrianModel] = &[
    &carla_walker::CARLA_WALKER,
    &commotions::model::COMMOTIONS,
    &interceptor::INTERCEPTOR,
    &jaywalker::JAYWALKER,
    &scripted::SCRIPTED,
    &social_force::SOCIAL_FORCE,
    &timeline::TIMELINE,
];

/// The model of that name.
pub fn model(name: &str) -> Option<&'static PedestrianModel> {
    MODELS.iter().copied().find(|model| model.declaration.name == name)
}
