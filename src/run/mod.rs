//! Executing cases: road users built from the registries, metrics read off, trials within their time limit.

mod batch;
mod build;
mod case;
mod free_flow;
mod outcome;
mod rehearsal;
mod stop;
mod trial;

pub use batch::run_batch;
pub use build::{RunError, road_users};
pub use case::{Unwatched, run_case};
pub use free_flow::FreeFlows;
pub use outcome::{Critical, Outcome, Requests};
pub use rehearsal::{Obstacle, Stage, rehearse, rehearse_trials};
pub use stop::Stop;
pub use trial::{Ran, SharedTrial, TrialError};
