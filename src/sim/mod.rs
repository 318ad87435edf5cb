//! One run: clock, kinematics, collision and observation, and the seams that road users plug into.

mod contact;
mod control;
mod course;
mod fingerprint;
#[cfg(test)]
pub mod fixture;
pub mod geometry;
mod observer;
pub mod random;
mod road_users;
pub mod script;
mod start;
mod timeline;
mod trace;

pub use crate::scenario::agent::{
    Command, Controller, ControllerError, Dynamics, EgoState, Longitudinal, Mode, ModelError, Motion,
    Observation, Pedestrian, PedestrianState, Perception, RoadView, Scene, Schedule, SeenPedestrian,
    SeenVehicle, Snapshot, Stated, StatedBy, VehicleState, velocity_inside,
};
pub use contact::{Contacts, Solid, Touch};
pub use course::{Course, Fault, Progress, has_arrived, has_crossed, longest_run, simulate};
pub use fingerprint::Fingerprint;
pub use observer::{Ending, Observer, Step, StopReason};
pub use road_users::{Driven, Driver, RoadUsers};
pub use start::{blocked_lanes, collision_course, overlaps};
pub use timeline::{Happening, Timeline, TimelineEvent};
pub use trace::{Sample, Trace, TraceMark};
