//! One trial: its cases in order, within the time limit, until they are enough.

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

/// Runs the cases of a trial in order by `run`, for which [`super::run_case`] is made, until `enough` of what came of
/// them so far, or to the end.
///
/// The time limit and the wish to stop are looked at between runs: one run always comes to its end, since its simulated
/// time is bounded.
pub fn run_trial(
    trial: &Trial,
    time_limit: Option<Duration>,
    stop: &Stop,
    mut enough: impl FnMut(&[Outcome]) -> bool,
    mut run: impl FnMut(&Case) -> Result<Outcome, RunError>,
) -> Result<Vec<Outcome>, TrialError> {
    let begun = Instant::now();
    let mut outcomes = Vec::with_capacity(trial.certain_cases().len());
    for case in &trial.cases {
        let (finished, runs) = (outcomes.len(), trial.cases.len());
        if stop.is_requested() {
            return Err(TrialError::Stopped { finished, runs });
        }
        if let Some(limit) = time_limit.filter(|limit| begun.elapsed() > *limit) {
            return Err(TrialError::TimeLimit { key: trial.key.clone(), limit, finished, runs });
        }
        outcomes.push(run(case).map_err(|error| TrialError::Run { key: case.key.clone(), error })?);
        if enough(&outcomes) {
            break;
        }
    }
    Ok(outcomes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Crossing, CrossingKind, Origin, Road, World};
    use crate::sim::{Ending, StopReason};
    use std::sync::Arc;

    fn trial(runs: u32) -> Trial {
        let road = Road {
            name: String::new(),
            lanes: Vec::new(),
            lane_width: 3.5,
            speed_limit: 10.0,
            kerbs: true,
            crossing: Crossing { kind: CrossingKind::Zebra, width: 4.0 },
            boxes: Vec::new(),
        };
        let world = Arc::new(World {
            road,
            vehicles: Vec::new(),
            pedestrians: Vec::new(),
            step: 0.025,
            horizon: 1.0,
            finish: 1.0,
            end_on_collision: false,
        });
        let case = |repetition| Case {
            key: format!("a/b/rep={repetition}"),
            scenario: "b".into(),
            variation: Vec::new(),
            individuals: Vec::new(),
            repetition,
            seed: u64::from(repetition),
            world: world.clone(),
        };
        Trial {
            key: "a/b".into(),
            scenario: "b".into(),
            doc: None,
            tags: Vec::new(),
            cases: (1..=runs).map(case).collect(),
            rounds: None,
            criteria: Vec::new(),
            origin: Origin::default(),
        }
    }

    fn outcome(case: &Case) -> Outcome {
        Outcome {
            key: case.key.clone(),
            seed: case.seed,
            individuals: Vec::new(),
            ending: Ending { reason: StopReason::Completed, time: 1.0 },
            metrics: Vec::new(),
            critical: Vec::new(),
            presences: Vec::new(),
            fingerprint: 0,
            wall_time: Duration::ZERO,
        }
    }

    #[test]
    fn it_stops_where_the_outcomes_are_enough() {
        let trial = trial(100);
        let mut run = 0;
        let outcomes = run_trial(
            &trial,
            None,
            &Stop::default(),
            |outcomes| outcomes.len() == 41,
            |case| {
                run += 1;
                Ok(outcome(case))
            },
        );
        let keys: Vec<_> = outcomes.unwrap().into_iter().map(|outcome| outcome.key).collect();
        let first: Vec<_> = trial.cases[..41].iter().map(|case| case.key.clone()).collect();
        assert_eq!((keys, run), (first, 41));
        let all = run_trial(&trial, None, &Stop::default(), |_| false, |case| Ok(outcome(case)));
        assert_eq!(all.unwrap().len(), 100);
    }

    #[test]
    fn an_error_ends_the_trial_and_names_its_run() {
        let run = |case: &Case| match case.repetition {
            5 => Err(RunError::Unknown { kind: "controller", name: case.key.clone() }),
            _ => Ok(outcome(case)),
        };
        let error = run_trial(&trial(20), None, &Stop::default(), |_| false, run).unwrap_err();
        assert!(matches!(&error, TrialError::Run { key, .. } if key == "a/b/rep=5"), "{error}");
    }

    #[test]
    fn limits_are_kept_between_runs() {
        let trial = trial(20);
        let stop = Stop::default();
        let stopping = |case: &Case| {
            stop.request();
            Ok(outcome(case))
        };
        let error = run_trial(&trial, None, &stop, |_| false, stopping);
        assert!(matches!(error, Err(TrialError::Stopped { finished: 1, runs: 20 })));
        let ok = |case: &Case| Ok(outcome(case));
        let late = run_trial(&trial, Some(Duration::ZERO), &Stop::default(), |_| false, ok);
        assert!(matches!(late, Err(TrialError::TimeLimit { .. })));
    }
}
