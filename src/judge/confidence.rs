//! Verdicts at a stated confidence: passed or failed only where the runs leave no reasonable doubt.

use super::statistics::{self, Interval};
use super::verdict::Verdict;
use crate::scenario::{Aggregate, Relation};

/// The bounds on the share of all runs that hold, each one-sided at `confidence`.
pub fn share_interval(holding: usize, runs: usize, confidence: f64) -> Interval {
    let (holding, runs) = (holding as u64, runs as u64);
    Interval {
        low: statistics::lower_bound(holding, runs, confidence),
        high: statistics::upper_bound(holding, runs, confidence),
    }
}

/// The bounds on an aggregate of values, each one-sided at `confidence`; `None` where none can be given, as for extremes,
/// about which a sample says nothing beyond itself.
pub fn value_interval(aggregate: &Aggregate, values: &[f64], confidence: f64, seed: u64) -> Option<Interval> {
    let two_sided = 2.0 * confidence - 1.0;
    let quantile = |level: f64| {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (low, high) = statistics::quantile_interval(&sorted, level, two_sided);
        // Too few values for a bound bound nothing.
        Some(Interval { low: low.unwrap_or(f64::NEG_INFINITY), high: high.unwrap_or(f64::INFINITY) })
    };
    match aggregate {
        Aggregate::Mean(_) => statistics::mean_interval(values, two_sided, seed),
        Aggregate::Median(_) => quantile(0.5),
        Aggregate::Quantile(level, _) => quantile(*level),
        _ => None,
    }
}

/// Whether everything in the interval satisfies the relation to `bound`, nothing does, or both.
pub fn decide(relation: Relation, interval: Interval, bound: f64) -> Verdict {
    let (low, high) = (relation.holds(interval.low, bound), relation.holds(interval.high, bound));
    match relation {
        // No interval with a width lies on a point.
        Relation::Equal | Relation::NotEqual => Verdict::Inconclusive,
        _ if low && high => Verdict::Passed,
        _ if !low && !high => Verdict::Failed,
        _ => Verdict::Inconclusive,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_least(share: f64, holding: usize, runs: usize) -> Verdict {
        decide(Relation::GreaterOrEqual, share_interval(holding, runs, 0.95), share)
    }

    #[test]
    fn few_runs_prove_little() {
        // 59 runs without a failure are the fewest that show 95 % at 95 % confidence.
        assert_eq!(at_least(0.95, 20, 20), Verdict::Inconclusive);
        assert_eq!(at_least(0.95, 58, 58), Verdict::Inconclusive);
        assert_eq!(at_least(0.95, 59, 59), Verdict::Passed);
        assert_eq!(at_least(0.95, 10, 20), Verdict::Failed);
    }

    #[test]
    fn relations_point_both_ways() {
        let interval = Interval { low: 0.1, high: 0.2 };
        assert_eq!(decide(Relation::Less, interval, 0.3), Verdict::Passed);
        assert_eq!(decide(Relation::Less, interval, 0.15), Verdict::Inconclusive);
        assert_eq!(decide(Relation::Less, interval, 0.05), Verdict::Failed);
        assert_eq!(decide(Relation::Greater, interval, 0.05), Verdict::Passed);
        assert_eq!(decide(Relation::Equal, interval, 0.15), Verdict::Inconclusive);
    }
}
