//! How far everything is that there is to do, and each unit that is under way.

use std::time::{Duration, Instant};

use indicatif::HumanDuration;

use results::{Evaluations, Workload};

/// What there is to do and what is done.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub outline: Workload,
    pub units_done: usize,
    pub runs_done: usize,
    pub failures: usize,
}

/// A unit under way.
#[derive(Debug)]
pub(super) struct Running {
    pub key: String,
    pub begun: Instant,
    pub runs: usize,
    pub runs_done: usize,
    pub evaluations: Option<Evaluations>,
    /// How often it was called slow.
    pub slow: u32,
}

impl Running {
    pub fn new(key: &str, runs: usize) -> Self {
        Self { key: key.to_string(), begun: Instant::now(), runs, runs_done: 0, evaluations: None, slow: 0 }
    }

    /// How far it is, to be appended to its key.
    pub fn progress(&self) -> String {
        match self.evaluations {
            Some(Evaluations { done, all, best: Some(value), within: Some((low, high)) }) => {
                let [value, low, high] = [value, low, high].map(|one| scenario::significant(one, 2));
                let left = left(self.begun.elapsed(), done, all);
                format!(": {done} of {all} runs, so far {value} [{low}, {high}]{left}")
            }
            Some(Evaluations { done, all, best, .. }) => {
                let best = best.map(|best| format!(", best {}", scenario::significant(best, 4)));
                let left = left(self.begun.elapsed(), done, all);
                format!(": {done} of {all} evaluations{}{left}", best.unwrap_or_default())
            }
            None if self.runs > 1 => format!(": {} of {} runs", self.runs_done, self.runs),
            None => String::new(),
        }
    }
}

/// The time that is left if all goes on as it did, to be appended; empty while that cannot be said.
pub(super) fn left(elapsed: Duration, done: usize, all: usize) -> String {
    if done == 0 || done >= all || elapsed < Duration::from_secs(1) {
        return String::new();
    }
    let left = elapsed.mul_f64((all - done) as f64 / done as f64);
    format!(", {} left", HumanDuration(left))
}
