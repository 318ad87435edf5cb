//! Vehicles: controllers and longitudinal dynamics, one file or folder each, and lists of them.

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

use scenario::{Dimension, Parameter};

pub use perception::perception;
pub use scenario::{CommandKind, ControllerContext, ControllerModel, DynamicsModel, PerceptionModel};

/// How often a controller decides for which no period was published. Declared by each of them, so that their results
/// do not depend on the simulation step.
fn period() -> Parameter {
    Parameter::number(
        "period",
        Dimension::TIME,
        0.025,
        (0.001, 1.0),
        "Time between decisions; the command is held in between.",
        "free choice: 40 Hz; nothing published",
    )
}

/// The controllers that ship, by name.
pub fn controllers() -> Vec<ControllerModel> {
    vec![
        autoware::autoware(),
        careful_human::careful_human(),
        carla_behavior::carla_behavior(),
        commotions::commotions(),
        constant_deceleration::constant_deceleration(),
        constant_speed::constant_speed(),
        idm_aeb::idm_aeb(),
        timeline::timeline(),
        yielding::yielding(),
    ]
}

/// The vehicle dynamics that ship, the simplest first.
pub fn dynamics() -> Vec<DynamicsModel> {
    vec![
        dynamics::ideal(),
        dynamics::delay_lag(),
        dynamics::prius(),
        dynamics::model3(),
        dynamics::mkz2020(),
        dynamics::generic(),
    ]
}
