//! One run: clock, kinematics, collision and observation, and the seams that road users plug into.

mod contact;
mod fingerprint;
#[cfg(test)]
pub mod fixture;
pub mod geometry;
mod observer;
pub mod random;
pub mod script;
mod start;
mod timeline;
mod trace;
mod world;

pub use crate::scenario::agent::{
    Command, Controller, Dynamics, EgoState, Longitudinal, ModelError, Motion, Observation, Pedestrian,
    PedestrianState, RoadView, Scene, Schedule, SeenPedestrian, SeenVehicle, Snapshot, Stated, StatedBy,
    VehicleState, velocity_inside,
};
pub use contact::{Contacts, Solid, Touch};
pub use fingerprint::Fingerprint;
pub use observer::{Ending, Observer, Step, StopReason};
pub use start::{blocked_lanes, collision_course, overlaps};
pub use timeline::{Event, Happening, Timeline};
pub use trace::{Mark, Sample, Trace};
pub use world::{Driven, RoadUsers, has_arrived, longest_run, simulate};
