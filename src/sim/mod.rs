//! One run: clock, kinematics, collision and observation, and the seams that road users plug into.

mod agent;
mod contact;
mod fingerprint;
#[cfg(test)]
pub mod fixture;
pub mod geometry;
mod model_error;
mod observer;
pub mod random;
mod schedule;
pub mod script;
mod start;
mod state;
mod timeline;
mod trace;
mod world;

pub use agent::{
    Command, Controller, Dynamics, EgoState, Motion, Observation, Pedestrian, RoadView, Scene,
    SeenPedestrian, SeenVehicle,
};
pub use contact::{Contacts, Solid, Touch};
pub use fingerprint::Fingerprint;
pub use model_error::{ModelError, Stated, StatedBy};
pub use observer::{Ending, Observer, Step, StopReason};
pub use schedule::Schedule;
pub use start::{blocked_lanes, collision_course, overlaps};
pub use state::{Longitudinal, PedestrianState, Snapshot, VehicleState, velocity_inside};
pub use timeline::{Event, Happening, Timeline};
pub use trace::{Mark, Sample, Trace};
pub use world::{Driven, RoadUsers, has_arrived, longest_run, simulate};
