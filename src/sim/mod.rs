//! One run: clock, kinematics, collision and observation, and the seams that road users plug into.

mod agent;
mod fingerprint;
#[cfg(test)]
pub mod fixture;
pub mod geometry;
mod observer;
pub mod random;
pub mod script;
mod state;
mod timeline;
mod trace;
mod world;

pub use agent::{
    Command, Controller, Dynamics, EgoState, ModelError, Motion, Observation, Pedestrian, RoadView, Scene,
    SeenPedestrian, SeenVehicle,
};
pub use fingerprint::Fingerprint;
pub use observer::{Ending, Observer, Step, StopReason};
pub use state::{Longitudinal, PedestrianState, Snapshot, VehicleState};
pub use timeline::{Event, Happening, Timeline};
pub use trace::{Sample, Trace};
pub use world::{Driven, RoadUsers, simulate};
