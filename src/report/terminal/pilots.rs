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

/// A trial of which other runs are done, and more are to come.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnderWay {
    pub unit: usize,
    pub done: usize,
    pub left: usize,
    /// Of each run, s of wall time.
    pub cost: f64,
}

/// Of all trials of which there are any.
#[derive(Debug, Default)]
pub(super) struct Pilots {
    /// Those of which no other run is done yet, by their units.
    ahead: BTreeMap<usize, Pilot>,
    /// The others.
    begun: BTreeMap<usize, Pilot>,
    /// Those that are over, in that order.
    over: Vec<Over>,
}

/// What came of pilot runs.
#[derive(Debug, Clone, Copy, Default)]
struct Over {
    /// What the other runs of a trial cost, s of wall time.
    cost: f64,
    /// What was expected of them.
    expected: f64,
    /// As [`square_of_error`] has it.
    square: f64,
}

impl Over {
    fn of(pilot: &Pilot, runs: usize, cost: f64) -> Self {
        let expected = runs as f64 * pilot.mean();
        let square = square_of_error(expected, pilot.made(), runs);
        Self { cost: runs as f64 * cost, expected, square }
    }

    fn and(self, other: Self) -> Self {
        Self {
            cost: self.cost + other.cost,
            expected: self.expected + other.expected,
            square: self.square + other.square,
        }
    }
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
        self.over.push(Over::of(pilot, runs, cost));
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

    /// What a second of a pilot run costs, s of wall time, with the square of its relative error in units of what runs scatter: by the later half of
    /// what was done, and by the last tenth of it. They differ where a machine has more or less to do beside it than it had.
    fn paces(&self, under_way: &[UnderWay]) -> Vec<(f64, f64)> {
        let now =
            under_way.iter().filter_map(|one| Some(Over::of(self.begun.get(&one.unit)?, one.done, one.cost)));
        let all: Vec<Over> = self.over.iter().copied().chain(now).collect();
        let cost: f64 = all.iter().map(|one| one.cost).sum();
        let pace = |share: f64| {
            let mut later = Over::default();
            for one in all.iter().rev() {
                later = later.and(*one);
                if later.cost >= share * cost {
                    break;
                }
            }
            let Over { cost, expected, square } = later;
            (expected > 0.0 && cost > 0.0).then(|| (cost / expected, square / (expected * expected)))
        };
        [0.5, 0.1].into_iter().filter_map(pace).collect()
    }

    /// How far what trials cost that are over was off what was expected at a pace, in the units of [`Self::scatter`], and from how many that is
    /// known. It is more than runs scatter where pilot runs are unlike others: where their people are others, or other work was done beside.
    fn error_of_pilots(&self, pace: f64) -> (f64, f64) {
        let (mut squares, mut foreseen) = (0.0, 0.0);
        for one in &self.over {
            let off = one.cost - pace * one.expected;
            squares += off * off;
            foreseen += pace * pace * one.square;
        }
        if foreseen > 0.0 { ((squares / foreseen).sqrt(), self.over.len() as f64) } else { (0.0, 0.0) }
    }

    /// Between what lies at a pace what trials under way still cost, and those with pilot runs that have yet to begin, at 95 %.
    fn known(&self, under_way: &[UnderWay], (pace, pace_error): (f64, f64)) -> (f64, f64) {
        let (runs, pilots) = (self.scatter(), self.error_of_pilots(pace));
        // Of one or two trials it may be luck.
        let are_unlike = pilots.1 >= 3.0 && pilots.0 > runs.0;
        let (scatter, freedom) = if are_unlike { (pilots.0, runs.1.max(pilots.1)) } else { runs };
        let mut expected = 0.0;
        let mut squares = 0.0;
        for pilot in self.ahead.values() {
            let left = pilot.runs.saturating_sub(pilot.made());
            let one = left as f64 * pilot.mean();
            expected += one;
            squares += square_of_error(one, pilot.made(), left);
        }
        let mut known = pace * expected;
        let mut variance = pace * pace * (squares + pace_error * expected * expected);
        for one in under_way {
            let own = one.left as f64 * one.cost;
            known += own;
            // What they cost is taken from the later half of those that are done.
            variance += square_of_error(own, one.done.div_ceil(2), one.left);
        }
        let off = student_quantile(0.975, freedom) * scatter * variance.sqrt() + FLOOR * known;
        (known - off, known + off)
    }

    /// What all trials still cost: those under way, those with pilot runs that have yet to begin, and so many `others` with so many `runs`, of
    /// which nothing is known but that those with pilot runs are spread over all. It is within that at 95 %; `None` before any trial has begun.
    pub fn left(&self, under_way: &[UnderWay], others: usize, runs: usize) -> Option<TimeLeft> {
        let paces = self.paces(under_way);
        let within = paces.iter().map(|pace| self.known(under_way, *pace));
        let (mut low, mut high) = within.reduce(|one, other| (one.0.min(other.0), one.1.max(other.1)))?;
        if runs > 0 {
            let means: Vec<f64> = self
                .ahead
                .values()
                .chain(self.begun.values())
                .map(|pilot| paces[0].0 * pilot.mean())
                .collect();
            let unknown = by_sample(&means, others)?;
            low += runs as f64 * unknown.0;
            high += runs as f64 * unknown.1;
        }
        Some(TimeLeft { least: low.max(0.0), most: Some(high) })
    }
}

/// How far what so many `runs` take is off what it is `expected` to be after so many that are `known`, in units of what runs scatter, squared:
/// both scatter.
fn square_of_error(expected: f64, known: usize, runs: usize) -> f64 {
    expected * expected * (1.0 / known.max(1) as f64 + 1.0 / runs.max(1) as f64)
}

/// Between what the mean cost of so many `others` lies at 95 %, of which these are a sample; `None` of fewer than two.
fn by_sample(costs: &[f64], others: usize) -> Option<(f64, f64)> {
    if costs.len() < 2 {
        return None;
    }
    let number = costs.len() as f64;
    let mean = costs.iter().sum::<f64>() / number;
    let variance = costs.iter().map(|cost| (cost - mean) * (cost - mean)).sum::<f64>() / (number - 1.0);
    let off = student_quantile(0.975, number - 1.0)
        * (variance * (1.0 / others.max(1) as f64 + 1.0 / number)).sqrt();
    Some(((mean - off).max(0.0), mean + off))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten trials of ten runs that pilot runs expect to take 1 s each; of those that are over a run cost so much.
    fn left(costs: &[f64]) -> TimeLeft {
        let mut pilots = Pilots::default();
        (0..10).for_each(|unit| (0..2).for_each(|_| pilots.made(unit, 10, Duration::from_secs(1))));
        costs.iter().enumerate().for_each(|(unit, cost)| pilots.over(unit, 8, Some(*cost)));
        pilots.left(&[], 0, 0).unwrap()
    }

    #[test]
    fn a_machine_that_gets_faster_or_slower_makes_a_range_with_the_truth_in_it() {
        let steady = left(&[1.0; 8]);
        assert!(steady.is_one() && (steady.middle() - 16.0).abs() < 1e-9, "{steady:?}");
        let faster = left(&[4.0, 4.0, 4.0, 4.0, 4.0, 1.0, 1.0, 1.0]);
        let slower = left(&[1.0, 1.0, 1.0, 1.0, 1.0, 4.0, 4.0, 4.0]);
        for (said, truth) in [(faster, 16.0), (slower, 64.0)] {
            assert!(said.least <= truth && said.most.unwrap() >= truth, "{said:?}");
        }
        assert!(!faster.is_one(), "{faster:?}");
    }

    #[test]
    fn trials_that_cost_something_else_than_their_pilot_runs_said_make_a_range() {
        // The pace of all, of the later half and of the last is the same, and runs of one trial do not scatter.
        assert!(left(&[2.0; 8]).is_one());
        let unlike = left(&[1.0, 3.0, 1.0, 3.0, 1.0, 3.0, 1.0, 2.0]);
        assert!(!unlike.is_one(), "{unlike:?}");
        assert!(unlike.least < 32.0 && unlike.most.unwrap() > 32.0, "{unlike:?}");
        // Of two that may be luck.
        assert!(left(&[1.9, 2.1]).is_one());
    }
}
