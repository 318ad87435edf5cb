//! Vehicles: controllers and longitudinal dynamics, one file or folder each, and lists of them.

mod autoware;
mod careful_human;
mod carla_behavior;
mod commotions;
mod constant_deceleration;
mod constant_speed;
mod dynamics;
mod hazard;
mod idm;
mod idm_aeb;
mod idm_aes;
mod perception;
mod period;
mod red_light;
#[cfg(test)]
mod test_track;
mod timeline;
mod yielding;

pub use perception::perception;
pub use scenario::{CommandKind, ControllerContext, ControllerModel, DynamicsModel, PerceptionModel};

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
        idm_aes::idm_aes(),
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
