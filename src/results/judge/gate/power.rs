//! The smallest change that a comparison would have caught.

use crate::Power;

use numbers::distributions::normal;
use numbers::distributions::{beta_quantile, student_quantile};
use numbers::inference::{MeanChange, rate_rise};

/// How often it must be caught to count.
pub const OFTEN: f64 = 0.8;

/// The fewest pairs with which something can be shown at `level`, if all of them get worse.
pub fn pairs_needed(level: f64) -> usize {
    // Rounding must not ask for one pair more.
    (-libm::log2(level) - 1e-9).ceil().max(1.0) as usize
}

/// Of a mean compared at `level` against a tolerance.
pub fn of_mean(change: &MeanChange, tolerance: f64, level: f64) -> Power {
    let needed = pairs_needed(level);
    if change.pairs() < needed {
        return Power::Blind { needed };
    }
    let error = change.error();
    if error > 0.0 {
        let reach = student_quantile(1.0 - level, change.freedom()) + normal::quantile(OFTEN);
        return Power::Shift(tolerance + reach * error);
    }
    Power::Share(share_for(needed, change.pairs()))
}

/// Of a rate over `pairs` compared at `level` against a tolerance, if no run gets better.
pub fn of_rate(pairs: u64, tolerance: f64, level: f64) -> Power {
    let caught = |worse: u64, pairs: u64| rate_rise(0, worse, pairs, tolerance) <= level;
    if !caught(pairs, pairs) {
        let needed = (pairs + 1..pairs + 10_000).find(|more| caught(*more, *more)).unwrap_or(u64::MAX);
        return Power::Blind { needed: needed as usize };
    }
    let (mut missed, mut least) = (0, pairs);
    while least - missed > 1 {
        let middle = missed + (least - missed) / 2;
        if caught(middle, pairs) { least = middle } else { missed = middle }
    }
    Power::Share(share_for(least as usize, pairs as usize))
}

/// The share of `runs` that must have what is new for one of them to have it so often.
pub fn share_of_one(runs: usize) -> f64 {
    share_for(1, runs)
}

/// The share of runs that must get worse for at least `least` of `pairs` to do so often enough.
fn share_for(least: usize, pairs: usize) -> f64 {
    if least >= pairs {
        return libm::pow(OFTEN, 1.0 / pairs as f64);
    }
    beta_quantile(OFTEN, least as f64, (pairs - least) as f64 + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use numbers::distributions::binomial_at_least;

    #[test]
    fn pairs_that_a_comparison_needs() {
        assert_eq!(pairs_needed(0.025), 6);
        assert_eq!(pairs_needed(0.025 / 54.0), 12);
        assert_eq!(pairs_needed(0.25), 2);
    }

    #[test]
    fn shares_are_caught_as_often_as_said() {
        for (least, pairs) in [(6, 20), (12, 80), (20, 20)] {
            let share = share_for(least, pairs);
            let often = binomial_at_least(least as u64, pairs as u64, share);
            assert!((often - OFTEN).abs() < 1e-6, "{least} of {pairs}: {often}");
        }
    }

    #[test]
    fn one_is_there_as_often_as_said() {
        for runs in [1, 20, 320] {
            let none = libm::pow(1.0 - share_of_one(runs), runs as f64);
            assert!((1.0 - none - OFTEN).abs() < 1e-9, "{runs}: {none}");
        }
    }

    #[test]
    fn rates() {
        let Power::Share(share) = of_rate(80, 0.0, 0.025) else { panic!() };
        // Six of 80 pairs suffice.
        assert!((share - share_for(6, 80)).abs() < 1e-9, "{share}");
        assert_eq!(of_rate(4, 0.0, 0.025), Power::Blind { needed: 6 });
        let Power::Share(tolerant) = of_rate(80, 0.05, 0.025) else { panic!() };
        assert!(tolerant > share + 0.02);
    }

    #[test]
    fn shifts_shrink_with_more_runs() {
        let shift = |pairs: usize| {
            let differences = (0..pairs).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 });
            of_mean(&MeanChange::new(differences.collect(), 1).unwrap(), 0.5, 0.001)
        };
        let (Power::Shift(few), Power::Shift(many)) = (shift(20), shift(200)) else { panic!() };
        assert!(few > many && many > 0.5);
        assert_eq!(shift(8), Power::Blind { needed: 10 });
    }
}
