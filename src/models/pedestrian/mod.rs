//! Pedestrian models, one file or folder each, and a list of them.

pub mod commotions;

mod across;
mod carla_walker;
mod interceptor;
mod jaywalker;
mod scripted;
mod social_force;
mod sum;
#[cfg(test)]
mod test_walk;
mod timeline;
mod yielding_cyclist;

pub use scenario::{PedestrianContext, PedestrianModel};

/// The pedestrian models that ship, by name.
pub fn models() -> Vec<PedestrianModel> {
    vec![
        carla_walker::carla_walker(),
        commotions::model::commotions(),
        interceptor::interceptor(),
        jaywalker::jaywalker(),
        scripted::scripted(),
        social_force::social_force(),
        timeline::timeline(),
        yielding_cyclist::yielding_cyclist(),
    ]
}
