//! Verdicts at a stated confidence: passed or failed only where the runs leave no reasonable doubt.

use super::statistics::{self, ConfidenceSequence, Interval};
use super::verdict::Verdict;
use crate::scenario::{Aggregate, Relation};

/// How bounds are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bounds {
    /// Of a number of runs that was fixed beforehand.
    Fixed,
    /// Of runs that are added while one looks: they hold however often that is.
    Sequential,
}

impl Bounds {
    /// The bounds on the share of all runs that hold, each one-sided at `confidence`.
    pub fn of_share(self, holding: usize, runs: usize, confidence: f64) -> Interval {
        let (holding, runs) = (holding as u64, runs as u64);
        match self {
            Self::Fixed => Interval {
                low: statistics::lower_bound(holding, runs, confidence),
                high: statistics::upper_bound(holding, runs, confidence),
            },
            Self::Sequential => ConfidenceSequence { confidence }.interval(holding, runs),
        }
    }

    /// The bounds on an aggregate of values, each one-sided at `confidence`; `None` where none can be given, as for
    /// extremes, about which a sample says nothing beyond itself, and for means while runs are added.
    pub fn of_values(
        self,
        aggregate: &Aggregate,
        values: &[f64],
        confidence: f64,
        seed: u64,
    ) -> Option<Interval> {
        let two_sided = 2.0 * confidence - 1.0;
        let quantile = |level: f64| {
            let mut sorted = values.to_vec();
            sorted.sort_by(f64::total_cmp);
            let (low, high) = match self {
                Self::Fixed => statistics::quantile_interval(&sorted, level, two_sided),
                Self::Sequential => ConfidenceSequence { confidence }.quantile_interval(&sorted, level),
            };
            // Too few values for a bound bound nothing.
            Some(Interval { low: low.unwrap_or(f64::NEG_INFINITY), high: high.unwrap_or(f64::INFINITY) })
        };
        match aggregate {
            Aggregate::Mean(_) if self == Self::Fixed => statistics::mean_interval(values, two_sided, seed),
            Aggregate::Median(_) => quantile(0.5),
            Aggregate::Quantile(level, _) => quantile(*level),
            _ => None,
        }
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
    use crate::scenario::{MetricReference, Settings};
    use statrs::distribution::{Beta, Binomial, ContinuousCDF, DiscreteCDF};

    fn at_least(share: f64, holding: usize, runs: usize) -> Verdict {
        decide(Relation::GreaterOrEqual, Bounds::Fixed.of_share(holding, runs, 0.95), share)
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
    fn shares_have_the_bounds_of_clopper_and_pearson_each_by_itself() {
        // Tables give [27.20 %, 72.80 %] for 10 of 20 two-sided at 95 %, which is one-sided at 97.5 %.
        let interval = Bounds::Fixed.of_share(10, 20, 0.975);
        assert!(
            (interval.low - 0.2720).abs() < 5e-5 && (interval.high - 0.7280).abs() < 5e-5,
            "{interval:?}"
        );
        // And as quantiles of the beta distribution, by another implementation.
        for (holding, runs, confidence) in [(3_u32, 40_u32, 0.9), (58, 60, 0.95), (199, 200, 0.99)] {
            let interval = Bounds::Fixed.of_share(holding as usize, runs as usize, confidence);
            let (k, n) = (f64::from(holding), f64::from(runs));
            let low = Beta::new(k, n - k + 1.0).unwrap().inverse_cdf(1.0 - confidence);
            let high = Beta::new(k + 1.0, n - k).unwrap().inverse_cdf(confidence);
            assert!((interval.low - low).abs() < 1e-6 && (interval.high - high).abs() < 1e-6, "{interval:?}");
        }
    }

    #[test]
    fn quantiles_are_bounded_by_order_statistics() {
        let metric = MetricReference { name: "pet".into(), settings: Settings::default(), pair: None };
        let interval = |runs: u32, level: f64, confidence: f64| {
            // In no order, as runs come.
            let values: Vec<f64> = (0..runs).map(|k| f64::from(k * 37 % runs + 1)).collect();
            let aggregate = Aggregate::Quantile(level, metric.clone());
            let interval = Bounds::Fixed.of_values(&aggregate, &values, confidence, 1).unwrap();
            (interval.low, interval.high)
        };
        // The largest of 59 is the first upper bound of the 95 % quantile at 95 %.
        assert_eq!(interval(58, 0.95, 0.95).1, f64::INFINITY);
        assert_eq!(interval(59, 0.95, 0.95).1, 59.0);
        for (runs, level, confidence) in [(100_u32, 0.9, 0.95), (200, 0.5, 0.99), (60, 0.25, 0.9)] {
            let (low, high) = interval(runs, level, confidence);
            let below = Binomial::new(level, u64::from(runs)).unwrap();
            let doubt = (1.0 - confidence) * (1.0 + 1e-9);
            // The value at rank r is above the quantile if fewer than r values are below it.
            assert!(below.cdf(low as u64 - 1) <= doubt && below.cdf(low as u64) > doubt, "{low}");
            assert!(below.sf(high as u64 - 1) <= doubt && below.sf(high as u64 - 2) > doubt, "{high}");
        }
    }

    #[test]
    fn looking_again_and_again_takes_more() {
        let at_least =
            |bounds: Bounds, runs| decide(Relation::GreaterOrEqual, bounds.of_share(runs, runs, 0.95), 0.95);
        assert_eq!(at_least(Bounds::Sequential, 87), Verdict::Inconclusive);
        assert_eq!(at_least(Bounds::Sequential, 88), Verdict::Passed);
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
