//! One run: clock, kinematics, collision and observation, and the seams that road users plug into.
//!
//! A run knows neither the models that drive it nor what is judged of it; that does not compile:
//!
//! ```compile_fail
//! use models::standard;
//! ```
//!
//! ```compile_fail
//! use results::Results;
//! ```

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

mod abreast;
mod arrival;
mod change;
mod clear_ahead;
mod closing;
mod contact;
mod control;
mod course;
mod crossings_ahead;
mod curvature;
mod fingerprint;
mod first_sight;
/// Worlds and states for tests.
#[doc(hidden)]
pub mod fixture;
pub mod geometry;
mod hit;
mod keep_clear;
mod legs;
pub mod measure;
mod observer;
mod order;
mod perceived;
mod permission;
pub mod random;
mod road_users;
pub mod script;
pub mod sight;
mod sighting;
mod solid;
mod start;
mod steering;
mod timeline;
mod too_near;
mod trace;
mod turning;
mod wait_for_green;
mod way;

pub use abreast::Abreast;
pub use arrival::{has_arrived, has_crossed};
pub use change::{GivenCommand, RunChange, brakes};
pub use contact::{Contacts, Touch};
pub use course::{Course, Fault, Progress, longest_run, simulate, walking_time};
pub use fingerprint::{Fingerprint, RunFingerprint};
pub use first_sight::{decides_at_first_sight, looks_until_all_are_past};
pub use hit::{hit_along, hit_at};
pub use observer::{Ending, Minds, Observer, Step, StopReason};
pub use order::{LONGEST_PLAN, Order, SpeedPlan, SpeedPlanError, SteeredOrder, toward};
pub use perceived::{PerceivedOther, PerceivedView, Views};
pub use road_users::{Driven, Driver, RoadUsers};
pub use scenario::agent::{
    Command, Controller, ControllerError, CrossingView, Dynamics, EgoState, Longitudinal, Mode, ModelError,
    ModelState, Motion, Observation, Pedestrian, PedestrianState, Perception, RoadView, Scene, Schedule,
    SeenPedestrian, SeenVehicle, Snapshot, StateQuantity, Stated, StatedBy, Steered, VehicleState,
    velocity_inside,
};
pub use sighting::Sighting;
pub use solid::Solid;
pub use start::{
    PastArrival, appears_after, beginning, blocked_lanes, collision_course, meeting_place, overlaps,
    past_arrival, path_conflicts, vehicles_ahead,
};
pub use timeline::{Happening, Timeline, TimelineEvent};
pub use too_near::{TooNear, too_near};
pub use trace::{Sample, Trace, TraceMark};
pub use turning::{contact_with, vehicles_meet};
