//! One trial: its cases on any number of threads, taken in in order, within the time limit, until they are enough.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use thiserror::Error;

use super::build::RunError;
use super::stop::Stop;
use crate::plan::PlannedTrial;
use crate::results::Outcome;
use crate::scenario::Case;
use crate::sim::Trace;

/// Why a trial has no verdict.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TrialError {
    #[error("{key}: {error}")]
    Run { key: String, error: RunError },
    #[error("time limit of {} s exceeded after {finished} of {runs} runs", .limit.as_secs_f64())]
    TimeLimit { limit: Duration, finished: usize, runs: usize },
    #[error("interrupted after {finished} of {runs} runs")]
    Stopped { finished: usize, runs: usize },
}

/// What came of a case, and its course if somebody wants it.
#[derive(Debug)]
pub struct Ran {
    pub outcome: Outcome,
    pub trace: Option<Trace>,
}

/// A trial under way, whose cases any thread may run. Its own thread takes in what came of them, in the order of the
/// cases: nothing depends on who ran which.
pub struct SharedTrial<'a> {
    pub trial: &'a PlannedTrial,
    state: Mutex<State>,
    /// Told when a run has ended.
    ended: Condvar,
}

struct State {
    /// Index of the first case that nobody has begun.
    next: usize,
    /// How many runs were taken in.
    taken: usize,
    /// Runs that have ended and were not taken in yet, by index of their case; `Err` for one that panicked.
    ended: BTreeMap<usize, thread::Result<Result<Ran, RunError>>>,
}

/// How far runs may be ahead of what was taken in: their courses need memory.
const AHEAD: usize = 256;

impl<'a> SharedTrial<'a> {
    pub fn new(trial: &'a PlannedTrial) -> Self {
        let state = State { next: 0, taken: 0, ended: BTreeMap::new() };
        Self { trial, state: Mutex::new(state), ended: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Index of a case that may be run now; whoever asks has to run it.
    pub fn begin(&self) -> Option<usize> {
        let mut state = self.lock();
        let index = state.next;
        let may_begin = index < self.trial.cases.len().min(state.taken + AHEAD);
        may_begin.then(|| {
            state.next += 1;
            index
        })
    }

    /// Runs a case that was begun, by `run`, for which [`super::run_case`] is made.
    pub fn run(&self, index: usize, run: impl FnOnce(&Case) -> Result<Ran, RunError>) {
        let ran = catch_unwind(AssertUnwindSafe(|| run(&self.trial.cases[index])));
        self.lock().ended.insert(index, ran);
        self.ended.notify_one();
    }

    /// Runs the cases, with whoever else does, until `enough` of what came of them so far, or to the end. What came of
    /// each is given to `done` first.
    ///
    /// The time limit and the wish to stop are looked at between runs: one run always comes to its end, since its
    /// simulated time is bounded.
    ///
    /// # Panics
    /// As the first run that did, whichever thread it was on.
    pub fn run_all(
        &self,
        time_limit: Option<Duration>,
        stop: &Stop,
        mut enough: impl FnMut(&[Outcome]) -> bool,
        run: impl Fn(&Case) -> Result<Ran, RunError>,
        mut done: impl FnMut(&Case, &Ran),
    ) -> Result<Vec<Outcome>, TrialError> {
        let begun = Instant::now();
        let (cases, runs) = (&self.trial.cases, self.trial.cases.len());
        let mut outcomes = Vec::with_capacity(self.trial.certain_runs());
        while outcomes.len() < runs {
            let finished = outcomes.len();
            if let Some(ran) = self.take(finished) {
                let case = &cases[finished];
                let ran = ran.unwrap_or_else(|panic| resume_unwind(panic));
                let ran = ran.map_err(|error| TrialError::Run { key: case.key.clone(), error })?;
                done(case, &ran);
                outcomes.push(ran.outcome);
                if enough(&outcomes) {
                    break;
                }
            } else if stop.is_requested() {
                return Err(TrialError::Stopped { finished, runs });
            } else if let Some(limit) = time_limit.filter(|limit| begun.elapsed() > *limit) {
                return Err(TrialError::TimeLimit { limit, finished, runs });
            } else if let Some(index) = self.begin() {
                self.run(index, &run);
            } else {
                self.wait_for(finished);
            }
        }
        self.lock().next = runs;
        Ok(outcomes)
    }

    /// What came of the case that is next to be taken in, if its run has ended.
    fn take(&self, index: usize) -> Option<thread::Result<Result<Ran, RunError>>> {
        let mut state = self.lock();
        let ran = state.ended.remove(&index)?;
        state.taken = index + 1;
        Some(ran)
    }

    /// Waits for the end of a run that another thread has begun.
    fn wait_for(&self, index: usize) {
        let running = |state: &mut State| !state.ended.contains_key(&index);
        drop(self.ended.wait_while(self.lock(), running).unwrap_or_else(PoisonError::into_inner));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::scenario::{Direction, Origin, Road, World};
    use crate::sim::{Ending, StopReason};

    fn trial(runs: u32) -> PlannedTrial {
        let road = Road::zebra(&[Direction::Forward], 10.0);
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
        let cases: Vec<Case> = (1..=runs).map(case).collect();
        let trial = crate::scenario::Trial {
            key: "a/b".into(),
            variation: Vec::new(),
            runs: cases.len(),
            first_run: cases[0].key.clone(),
            scenario: "b".into(),
            doc: None,
            tags: Vec::new(),
            rounds: None,
            criteria: Vec::new(),
            declared: 0,
            origin: Origin::default(),
        };
        PlannedTrial { trial: Arc::new(trial), cases }
    }

    fn outcome(case: &Case) -> Outcome {
        Outcome {
            key: case.key.clone(),
            seed: case.seed,
            individuals: Vec::new(),
            ending: Ending { reason: StopReason::Completed, time: 1.0 },
            metrics: Vec::new(),
            critical: Default::default(),
            presences: Vec::new(),
            cut_off: Default::default(),
            fingerprint: 0,
            wall_time: Duration::ZERO,
        }
    }

    fn ran(case: &Case) -> Result<Ran, RunError> {
        Ok(Ran { outcome: outcome(case), trace: None })
    }

    /// Runs a trial on its own thread and as many others.
    fn run_with(
        helpers: usize,
        trial: &PlannedTrial,
        enough: impl FnMut(&[Outcome]) -> bool,
        run: impl Fn(&Case) -> Result<Ran, RunError> + Sync,
    ) -> (Result<Vec<Outcome>, TrialError>, Vec<String>) {
        let shared = SharedTrial::new(trial);
        let over = Stop::default();
        let mut done = Vec::new();
        let outcomes = thread::scope(|scope| {
            for _ in 0..helpers {
                scope.spawn(|| {
                    while !over.is_requested() {
                        match shared.begin() {
                            Some(index) => shared.run(index, &run),
                            None => thread::yield_now(),
                        }
                    }
                });
            }
            let tell = |case: &Case, _: &Ran| done.push(case.key.clone());
            let all = || shared.run_all(None, &Stop::default(), enough, &run, tell);
            let outcomes = catch_unwind(AssertUnwindSafe(all));
            over.request();
            outcomes.unwrap_or_else(|panic| resume_unwind(panic))
        });
        (outcomes, done)
    }

    fn keys(trial: &PlannedTrial, runs: usize) -> Vec<String> {
        trial.cases[..runs].iter().map(|case| case.key.clone()).collect()
    }

    #[test]
    fn it_stops_where_the_outcomes_are_enough() {
        let trial = trial(1000);
        for helpers in [0, 1, 4] {
            let begun = AtomicUsize::new(0);
            let count = |case: &Case| {
                begun.fetch_add(1, Ordering::Relaxed);
                ran(case)
            };
            let (outcomes, done) = run_with(helpers, &trial, |outcomes| outcomes.len() == 41, count);
            let of: Vec<_> = outcomes.unwrap().into_iter().map(|outcome| outcome.key).collect();
            assert_eq!((&of, &done), (&keys(&trial, 41), &of));
            let begun = begun.into_inner();
            if helpers == 0 {
                assert_eq!(begun, 41, "a thread by itself runs nothing in vain");
            } else {
                assert!((41..=41 + AHEAD).contains(&begun), "{begun}");
            }
        }
    }

    #[test]
    fn outcomes_are_in_order_whoever_ran_them() {
        let trial = trial(1000);
        // Every seventh run takes longer, so that others overtake it.
        let run = |case: &Case| {
            if case.repetition.is_multiple_of(7) {
                thread::sleep(Duration::from_micros(300));
            }
            ran(case)
        };
        for helpers in [0, 1, 4] {
            let (outcomes, done) = run_with(helpers, &trial, |_| false, run);
            let of: Vec<_> = outcomes.unwrap().into_iter().map(|outcome| outcome.key).collect();
            assert_eq!((&of, &done), (&keys(&trial, 1000), &of));
        }
    }

    #[test]
    fn the_first_error_in_order_ends_the_trial_and_names_its_run() {
        let trial = trial(1000);
        let run = |case: &Case| match case.repetition {
            5 => {
                thread::sleep(Duration::from_millis(2));
                Err(RunError::Unknown { kind: "controller", name: case.key.clone() })
            }
            6.. => Err(RunError::Unknown { kind: "controller", name: "another".into() }),
            _ => ran(case),
        };
        for helpers in [0, 1, 4] {
            let (outcomes, done) = run_with(helpers, &trial, |_| false, run);
            let error = outcomes.unwrap_err();
            assert!(matches!(&error, TrialError::Run { key, .. } if key == "a/b/rep=5"), "{error}");
            assert_eq!(done, keys(&trial, 4));
        }
    }

    #[test]
    fn a_panic_is_that_of_the_first_run_in_order() {
        let trial = trial(100);
        let run = |case: &Case| match case.repetition {
            ..5 => ran(case),
            other => std::panic::panic_any(other),
        };
        for helpers in [0, 1, 4] {
            let all = || run_with(helpers, &trial, |_| false, run);
            let panic = catch_unwind(AssertUnwindSafe(all)).map(|_| ()).unwrap_err();
            assert_eq!(panic.downcast_ref::<u32>(), Some(&5));
        }
    }

    #[test]
    fn limits_are_kept_between_runs() {
        let trial = trial(20);
        let stop = Stop::default();
        let stopping = |case: &Case| {
            stop.request();
            ran(case)
        };
        let error = SharedTrial::new(&trial).run_all(None, &stop, |_| false, stopping, |_, _| {});
        assert!(matches!(error, Err(TrialError::Stopped { finished: 1, runs: 20 })));
        let limit = Some(Duration::ZERO);
        let late = SharedTrial::new(&trial).run_all(limit, &Stop::default(), |_| false, ran, |_, _| {});
        assert!(matches!(late, Err(TrialError::TimeLimit { .. })));
    }
}
