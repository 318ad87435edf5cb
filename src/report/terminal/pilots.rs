//! What pilot runs say of what trials cost that have yet to begin. It knows no clock.

use std::collections::BTreeMap;
use std::time::Duration;

use super::time_left::TimeLeft;
use numbers::distributions::student_quantile;

/// A trial of which runs were made before it begins.
#[derive(Debug, Clone, Default)]
pub(super) struct Pilot {
    /// Runs that it has at most.
    runs: usize,
    /// What those took that were made, s.
    took: Vec<f64>,
}

impl Pilot {
    fn mean(&self) -> f64 {
        self.took.iter().sum::<f64>() / self.took.len().max(1) as f64
    }

    fn made(&self) -> usize {
        self.took.len()
    }
}

/// Of all trials of which there are any.
#[derive(Debug, Default)]
pub(super) struct Pilots {
    /// Those of which no other run is done yet, by their units.
    ahead: BTreeMap<usize, Pilot>,
    /// The others.
    begun: BTreeMap<usize, Pilot>,
    /// What runs cost of trials that are over, s of wall time, and what was expected of them by their pilot runs.
    cost: f64,
    expected: f64,
    /// The squares of what was expected, each by the pilot runs that it is known from.
    squares: f64,
}

/// Runs of one trial are taken to scatter so much, relative to their mean, where nothing is known of that.
const SCATTER: f64 = 0.5;
/// Nothing is known better than that: machines do other things, too.
const FLOOR: f64 = 0.05;

impl Pilots {
    /// A pilot run of a unit that has so many `runs`.
    pub fn made(&mut self, unit: usize, runs: usize, took: Duration) {
        let pilot = self.ahead.entry(unit).or_default();
        pilot.runs = runs;
        pilot.took.push(took.as_secs_f64());
    }

    pub fn is_empty(&self) -> bool {
        self.ahead.is_empty() && self.begun.is_empty()
    }

    /// How many of a unit were made.
    pub fn of(&self, unit: usize) -> usize {
        self.ahead.get(&unit).map_or(0, Pilot::made)
    }

    /// Another run of a unit is done, or it is over.
    pub fn begin(&mut self, unit: usize) {
        if let Some(pilot) = self.ahead.remove(&unit) {
            self.begun.insert(unit, pilot);
        }
    }

    /// A unit is over of which so many other runs were made; each cost so much, s of wall time.
    pub fn over(&mut self, unit: usize, runs: usize, cost: Option<f64>) {
        self.begin(unit);
        let (Some(pilot), Some(cost)) = (self.begun.get(&unit), cost) else { return };
        let expected = runs as f64 * pilot.mean();
        self.cost += runs as f64 * cost;
        self.expected += expected;
        self.squares += square_of_error(expected, pilot, runs);
    }

    /// How many runs there are of trials that have pilot runs and have yet to begin, without those.
    pub fn runs_ahead(&self) -> usize {
        self.ahead.values().map(|pilot| pilot.runs.saturating_sub(pilot.made())).sum()
    }

    pub fn trials_ahead(&self) -> usize {
        self.ahead.len()
    }

    /// How much runs of one trial scatter, relative to their mean, and from how many that is known.
    fn scatter(&self) -> (f64, f64) {
        let all = self.ahead.values().chain(self.begun.values());
        let (mut squares, mut freedom) = (0.0, 0.0);
        for pilot in all.filter(|pilot| pilot.made() > 1) {
            let mean = pilot.mean().max(1e-9);
            squares += pilot.took.iter().map(|took| (took / mean - 1.0) * (took / mean - 1.0)).sum::<f64>();
            freedom += (pilot.made() - 1) as f64;
        }
        if freedom < 1.0 { (SCATTER, 3.0) } else { ((squares / freedom).sqrt(), freedom) }
    }

    /// What a second of a run costs, s of wall time, with the square of its relative error in units of what runs scatter; `under_way` are
    /// trials by their units, with how many of their runs are done and what each cost.
    fn pace(&self, under_way: &[(usize, usize, f64)]) -> Option<(f64, f64)> {
        let (mut cost, mut expected, mut squares) = (self.cost, self.expected, self.squares);
        for (unit, runs, each) in under_way {
            let Some(pilot) = self.begun.get(unit) else { continue };
            let one = *runs as f64 * pilot.mean();
            cost += *runs as f64 * each;
            expected += one;
            squares += square_of_error(one, pilot, *runs);
        }
        (expected > 0.0 && cost > 0.0).then(|| (cost / expected, squares / (expected * expected)))
    }

    /// What trials that have yet to begin cost: those with pilot runs, and so many `others` with so many runs (at least and at most), of which
    /// nothing is known but that those with pilot runs are spread over all. It is within that at 95 %; `None` before any trial has begun.
    pub fn ahead(
        &self,
        under_way: &[(usize, usize, f64)],
        others: usize,
        (least, most): (usize, usize),
    ) -> Option<TimeLeft> {
        let (pace, pace_error) = self.pace(under_way)?;
        let (scatter, freedom) = self.scatter();
        let mut expected = 0.0;
        let mut squares = 0.0;
        for pilot in self.ahead.values() {
            let left = pilot.runs.saturating_sub(pilot.made());
            let one = left as f64 * pilot.mean();
            expected += one;
            squares += square_of_error(one, pilot, left);
        }
        let own = if expected > 0.0 { squares / (expected * expected) } else { 0.0 };
        let error = scatter * (own + pace_error).sqrt();
        let off = (student_quantile(0.975, freedom) * error + FLOOR).min(1.0);
        let known = pace * expected;
        let (mut low, mut high) = (known * (1.0 - off), known * (1.0 + off));
        if most > 0 {
            let means: Vec<f64> =
                self.ahead.values().chain(self.begun.values()).map(|pilot| pace * pilot.mean()).collect();
            let unknown = by_sample(&means, others)?;
            low += least as f64 * unknown.0;
            high += most as f64 * unknown.1;
        }
        Some(TimeLeft { least: low, most: Some(high) })
    }
}

/// How far pilot runs are off of so many `runs`, which they expect to take so long, in units of what runs scatter, squared: both scatter.
fn square_of_error(expected: f64, pilot: &Pilot, runs: usize) -> f64 {
    expected * expected * (1.0 / pilot.made() as f64 + 1.0 / runs.max(1) as f64)
}

/// Between what the mean cost of so many `others` lies at 95 %, of which these are a sample; `None` of fewer than two.
fn by_sample(costs: &[f64], others: usize) -> Option<(f64, f64)> {
    if costs.len() < 2 {
        return None;
    }
    let number = costs.len() as f64;
    let mean = costs.iter().sum::<f64>() / number;
    let variance = costs.iter().map(|cost| (cost - mean) * (cost - mean)).sum::<f64>() / (number - 1.0);
    let off = student_quantile(0.975, number - 1.0) * (variance * (1.0 / others.max(1) as f64 + 1.0 / number)).sqrt();
    Some(((mean - off).max(0.0), mean + off))
}
