//! One run: clock, kinematics, collision and observation, and the seams that road users plug into.

mod agent;
pub mod geometry;
mod observer;
pub mod random;
mod state;
mod world;

pub use agent::{
    Command, Controller, Dynamics, EgoState, ModelError, Motion, Observation, Pedestrian, RoadView, Scene,
    SeenPedestrian, SeenVehicle,
};
pub use observer::{Ending, Observer, Step, StopReason};
pub use state::{Longitudinal, PedestrianState, Snapshot, VehicleState};
pub use world::{Driven, RoadUsers, simulate};
