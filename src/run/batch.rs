//! Many cases side by side.

use rayon::prelude::*;
use thiserror::Error;

use super::build::RunError;
use super::case::{Unwatched, run_case};
use super::free_flow::FreeFlows;
use super::stop::Stop;
use crate::results::{Outcome, Requests};
use crate::scenario::Case;

/// Why there are no outcomes.
#[derive(Debug, Error)]
pub enum BatchError {
    #[error("{key}: {error}")]
    Run { key: String, error: RunError },
    /// Somebody wished it.
    #[error("interrupted")]
    Stopped,
}

/// Runs every case, on all cores; the outcomes are in the order of the cases. `done` is told after each, from several
/// threads.
///
/// # Errors
/// The first case, in order, that cannot be run, or was not begun since somebody wished to stop.
pub fn run_batch(
    cases: &[&Case],
    requests: &Requests,
    free_flows: &FreeFlows,
    stop: &Stop,
    done: impl Fn() + Sync,
) -> Result<Vec<Outcome>, BatchError> {
    let run = |case: &&Case| {
        if stop.is_requested() {
            return Err(BatchError::Stopped);
        }
        let outcome = run_case(case, requests, free_flows, &mut Unwatched);
        done();
        outcome.map_err(|error| BatchError::Run { key: case.key.clone(), error })
    };
    let outcomes: Vec<_> = cases.par_iter().map(run).collect();
    outcomes.into_iter().collect()
}
