//! Many cases side by side.

use rayon::prelude::*;

use super::build::RunError;
use super::case::{Unwatched, run_case};
use super::free_flow::FreeFlows;
use super::outcome::{Outcome, Requests};
use crate::scenario::Case;

/// Runs every case, on all cores; the outcomes are in the order of the cases. `done` is told after each, from several
/// threads.
///
/// # Errors
/// The first case, in order, that cannot be run, by its key.
pub fn run_batch(
    cases: &[&Case],
    requests: &Requests,
    free_flows: &FreeFlows,
    done: impl Fn() + Sync,
) -> Result<Vec<Outcome>, (String, RunError)> {
    let run = |case: &&Case| {
        let outcome = run_case(case, requests, free_flows, &mut Unwatched);
        done();
        outcome.map_err(|error| (case.key.clone(), error))
    };
    let outcomes: Vec<_> = cases.par_iter().map(run).collect();
    outcomes.into_iter().collect()
}
