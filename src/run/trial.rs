//! One trial: all its cases in order, within the time limit.

use std::time::{Duration, Instant};

use thiserror::Error;

use super::build::RunError;
use super::outcome::Outcome;
use super::stop::Stop;
use crate::plan::Trial;
use crate::scenario::Case;

/// Why a trial has no verdict.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TrialError {
    #[error("{key}: {error}")]
    Run { key: String, error: RunError },
    #[error("{}: time limit of {} s exceeded after {finished} of {runs} runs", .key, .limit.as_secs_f64())]
    TimeLimit { key: String, limit: Duration, finished: usize, runs: usize },
    #[error("interrupted after {finished} of {runs} runs")]
    Stopped { finished: usize, runs: usize },
}

/// Runs every case of a trial in order by `run`, for which [`super::run_case`] is made.
///
/// The time limit and the wish to stop are looked at between runs: one run always comes to its end, since its simulated
/// time is bounded.
pub fn run_trial(
    trial: &Trial,
    time_limit: Option<Duration>,
    stop: &Stop,
    mut run: impl FnMut(&Case) -> Result<Outcome, RunError>,
) -> Result<Vec<Outcome>, TrialError> {
    let begun = Instant::now();
    let mut outcomes = Vec::with_capacity(trial.cases.len());
    for case in &trial.cases {
        if stop.is_requested() {
            return Err(TrialError::Stopped { finished: outcomes.len(), runs: trial.cases.len() });
        }
        if let Some(limit) = time_limit.filter(|limit| begun.elapsed() > *limit) {
            let (key, runs) = (trial.key.clone(), trial.cases.len());
            return Err(TrialError::TimeLimit { key, limit, finished: outcomes.len(), runs });
        }
        outcomes.push(run(case).map_err(|error| TrialError::Run { key: case.key.clone(), error })?);
    }
    Ok(outcomes)
}
