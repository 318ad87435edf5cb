//! Vehicles: controllers and longitudinal dynamics, one file or folder each, and their registries.

mod autoware;
mod careful_human;
mod carla_behavior;
mod commotions;
mod constant_deceleration;
mod constant_speed;
mod dynamics;
mod hazard;
mod idm_aeb;
mod perception;
#[cfg(test)]
mod test_track;
mod timeline;
mod yielding;

use crate::scenario::{Chance, Declaration, Dimension, Parameter, Settings, VehicleSetup, World};
use crate::sim::{Controller, Dynamics, ModelError};

pub use perception::{PERCEPTION, PERCEPTION_CHANCE, with_perception};

/// How often a controller decides for which no period was published. Declared by each of them, so that their results
/// do not depend on the simulation step.
const PERIOD: Parameter = Parameter::number(
    "period",
    Dimension::TIME,
    0.025,
    (0.001, 1.0),
    "Time between decisions; the command is held in between.",
    "free choice: 40 Hz; nothing published",
);

/// A registered controller.
pub struct ControllerModel {
    pub declaration: Declaration,
    /// The dynamics of a vehicle that declares none.
    pub default_dynamics: &'static str,
    pub gives: CommandKind,
    pub chance: Chance,
    pub build: fn(&ControllerContext) -> Result<Box<dyn Controller>, ModelError>,
}

/// What a controller is built from.
#[derive(Clone, Copy)]
pub struct ControllerContext<'a> {
    /// Resolved against the controller's declaration.
    pub settings: &'a Settings,
    pub setup: &'a VehicleSetup,
    pub world: &'a World,
    /// The vehicle's place among the names of its kind, by which it draws.
    pub rank: usize,
    /// The run's seed, for [`crate::sim::random::stream`].
    pub seed: u64,
}

/// Registered longitudinal dynamics.
pub struct DynamicsModel {
    pub declaration: Declaration,
    pub takes: &'static [CommandKind],
    /// Length and width of the vehicle it describes, m.
    pub size: (f64, f64),
    pub build: fn(&Settings) -> Result<Box<dyn Dynamics>, ModelError>,
}

/// The kind of [`crate::sim::Command`] that a controller gives and dynamics take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandKind {
    Pedals,
    Acceleration,
}

/// Every controller there is, by name.
#[rustfmt::skip]
pub static CONTROLLERS: &[&ControllerModel] = &[
    &autoware::AUTOWARE,
    &careful_human::CAREFUL_HUMAN,
    &carla_behavior::CARLA_BEHAVIOR,
    &commotions::COMMOTIONS,
    &constant_deceleration::CONSTANT_DECELERATION,
    &constant_speed::CONSTANT_SPEED,
    &idm_aeb::IDM_AEB,
    &timeline::TIMELINE,
    &yielding::YIELDING,
];

/// Every vehicle dynamics there is, by name.
pub static DYNAMICS: &[&DynamicsModel] = &[
    &dynamics::IDEAL,
    &dynamics::DELAY_LAG,
    &dynamics::PRIUS,
    &dynamics::MODEL3,
    &dynamics::MKZ2020,
    &dynamics::GENERIC,
];

/// The controller of that name.
pub fn controller(name: &str) -> Option<&'static ControllerModel> {
    CONTROLLERS.iter().copied().find(|controller| controller.declaration.name == name)
}

/// The dynamics of that name.
pub fn dynamics(name: &str) -> Option<&'static DynamicsModel> {
    DYNAMICS.iter().copied().find(|dynamics| dynamics.declaration.name == name)
}
