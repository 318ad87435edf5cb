//! What the runs of trials cost in time, and from that what trials that have yet to begin may cost. It knows no clock.

use std::time::Duration;

use super::time_left::TimeLeft;
use numbers::distributions::student_quantile;

/// Wall time between runs that come to their end, whoever makes them side by side, counted towards the trial whose run it is.
#[derive(Debug, Default)]
pub(super) struct Costs {
    /// When the last run came to its end, s.
    last: f64,
    /// Trials that are over, in the order of time: when that was (s), and what a run of it cost (s).
    over: Vec<(f64, f64)>,
}

/// So many trials are kept: of more, every second one.
const KEPT: usize = 512;
/// From so many on the mean of those to come is known better than one of them.
const ENOUGH: usize = 8;
/// What costs less is taken to cost this, s.
const SHORTEST: f64 = 1e-7;
/// Where fewer scatter so much that one may cost so many times what the others do, nothing is said.
const FACTOR: f64 = 10.0;

impl Costs {
    /// A run is over: what it cost, s.
    pub fn run_done(&mut self, elapsed: Duration) -> f64 {
        let elapsed = elapsed.as_secs_f64();
        let cost = (elapsed - self.last).max(0.0);
        self.last = elapsed;
        cost
    }

    /// A trial is over, whose runs cost so much each, s.
    pub fn trial_over(&mut self, elapsed: Duration, cost: f64) {
        self.over.push((elapsed.as_secs_f64(), cost));
        if self.over.len() > 2 * KEPT {
            let mut number = 0;
            self.over.retain(|_| {
                number += 1;
                number % 2 == 0
            });
        }
    }

    /// What so many `runs` (at least and at most) of so many trials cost that have yet to begin, where `begun` are what a run costs of those
    /// that are under way. It lies within 95 % of what those so far say: of few as if they were drawn from a log-normal distribution, for one
    /// trial may cost many times what another does, and each that is to come were the next; of more by their mean. Of one trial nobody knows
    /// others: then nothing is known.
    pub fn unbegun(&self, elapsed: Duration, begun: &[f64], trials: usize, runs: (usize, usize)) -> TimeLeft {
        let half = elapsed.as_secs_f64() / 2.0;
        // What is of late is nearer to what comes than what was at the beginning.
        let late = self.over.partition_point(|(time, _)| *time <= half);
        let of = |from: usize| {
            let over = self.over[from..].iter().map(|(_, cost)| *cost);
            over.chain(begun.iter().copied()).collect::<Vec<f64>>()
        };
        let costs = Some(of(late)).filter(|costs| costs.len() >= ENOUGH).unwrap_or_else(|| of(0));
        let runs = (runs.0 as f64, runs.1 as f64);
        if costs.len() < 2 {
            return TimeLeft { least: 0.0, most: None };
        }
        let seen = costs.len() as f64;
        let t = student_quantile(0.975, seen - 1.0);
        if costs.len() < ENOUGH {
            let logs: Vec<f64> = costs.iter().map(|cost| libm::log(cost.max(SHORTEST))).collect();
            let (mean, variance) = moments(&logs);
            let off = t * (variance * (1.0 + 1.0 / seen)).sqrt();
            return match off > libm::log(FACTOR) {
                true => TimeLeft { least: 0.0, most: None },
                false => TimeLeft {
                    least: runs.0 * libm::exp(mean - off),
                    most: Some(runs.1 * libm::exp(mean + off)),
                },
            };
        }
        let cheapest = costs.iter().copied().fold(f64::INFINITY, f64::min);
        let dearest = costs.iter().copied().fold(0.0, f64::max);
        let (mean, variance) = moments(&costs);
        let off = t * (variance * (1.0 / trials.max(1) as f64 + 1.0 / seen)).sqrt();
        let (low, high) = ((mean - off).max(cheapest), (mean + off).min(dearest));
        TimeLeft { least: runs.0 * low, most: Some(runs.1 * high) }
    }
}

/// The mean and the variance of at least two values.
fn moments(values: &[f64]) -> (f64, f64) {
    let number = values.len() as f64;
    let mean = values.iter().sum::<f64>() / number;
    let squares = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
    (mean, squares / (number - 1.0))
}
