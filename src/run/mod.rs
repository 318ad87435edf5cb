//! Executing cases: road users built from registered models, metrics read off, trials within their time limit.

mod batch;
mod build;
mod case;
mod chance;
mod cut_off;
mod departure;
mod free_flow;
mod name;
mod panic;
mod rehearsal;
mod stop;
mod trial;

pub use batch::{BatchError, run_batch};
pub use build::{RunError, road_users};
pub use case::{Unwatched, run_case};
pub use chance::drawing;
pub use departure::{Departing, departing, departures};
pub use free_flow::FreeFlows;
pub use panic::{Panicked, note_places};
pub use rehearsal::{Obstacle, Stage, rehearse, rehearse_trials};
pub use stop::Stop;
pub use trial::{Ran, SharedTrial, TrialError};
