//! Verdicts at a stated confidence: passed or failed only where luck would seldom do the same.

use crate::Verdict;
use numbers::inference::{self, ConfidenceSequence, IndependentUnit, Interval};
use scenario::{Aggregate, AggregateBounds, Relation};

/// How bounds are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bounds<'a> {
    /// Of a number of runs that was fixed beforehand.
    Fixed,
    /// Of runs that are added while one looks: they hold however often that is.
    Sequential,
    /// Of people taken from many, by whose run each is: people are independent, the runs of one are not.
    People(&'a [usize]),
}

impl Bounds<'_> {
    /// The bounds on the share of all runs that hold, each one-sided at `confidence`.
    pub fn of_share(self, held: &[bool], confidence: f64) -> Interval {
        let (holding, runs) = (held.iter().filter(|held| **held).count() as u64, held.len() as u64);
        match self {
            Self::Sequential => ConfidenceSequence { confidence }.interval(holding, runs),
            Self::People(whose) if once_each(whose) => fixed_share(holding, runs, confidence),
            Self::People(whose) => {
                let flags: Vec<_> = held.iter().map(|held| Some(f64::from(*held))).collect();
                let units = per_person(&flags, whose);
                inference::mean_of_bounded(&units, (0.0, 1.0), confidence)
                    .expect("shares lie between 0 and 1")
            }
            Self::Fixed => fixed_share(holding, runs, confidence),
        }
    }

    /// The bounds on an aggregate of each run's value, each one-sided at `confidence`; `None` where none can be given, as
    /// for extremes, about which a sample says nothing beyond itself, and for means of values without limits where they
    /// do not differ, or while runs are added.
    pub fn of_values(
        self,
        aggregate: &Aggregate,
        values: &[Option<f64>],
        limits: Option<(f64, f64)>,
        confidence: f64,
        seed: u64,
    ) -> Option<Interval> {
        match aggregate.bounds() {
            AggregateBounds::Mean => self.of_mean(values, limits, confidence, seed),
            AggregateBounds::Quantile(level) => Some(self.of_quantile(level, values, confidence)),
            AggregateBounds::Share | AggregateBounds::Unknown { .. } => None,
        }
    }

    fn of_mean(
        self,
        values: &[Option<f64>],
        limits: Option<(f64, f64)>,
        confidence: f64,
        seed: u64,
    ) -> Option<Interval> {
        let units = match self {
            Self::People(whose) => per_person(values, whose),
            Self::Fixed | Self::Sequential => {
                values.iter().map(|value| IndependentUnit::of_run(*value)).collect()
            }
        };
        if let Some(limits) = limits {
            return inference::mean_of_bounded(&units, limits, confidence);
        }
        if self == Self::Sequential {
            return None;
        }
        let means: Vec<f64> = units.iter().filter_map(IndependentUnit::mean).collect();
        inference::mean_interval(&means, 2.0 * confidence - 1.0, seed)
    }

    /// Too few values for a bound bound nothing.
    fn of_quantile(self, level: f64, values: &[Option<f64>], confidence: f64) -> Interval {
        let mut sorted: Vec<f64> = values.iter().copied().flatten().collect();
        sorted.sort_by(f64::total_cmp);
        let (low, high) = match self {
            Self::Sequential => ConfidenceSequence { confidence }.quantile_interval(&sorted, level),
            Self::People(whose) if !once_each(whose) => {
                let share = |counts: &dyn Fn(f64) -> bool| {
                    let flags: Vec<_> =
                        values.iter().map(|value| value.map(|value| f64::from(counts(value)))).collect();
                    inference::mean_of_bounded(&per_person(&flags, whose), (0.0, 1.0), confidence)
                        .expect("shares lie between 0 and 1")
                };
                let low = sorted.partition_point(|bound| share(&|value| value < *bound).high < level);
                let high = sorted.partition_point(|bound| share(&|value| value <= *bound).low < level);
                (low.checked_sub(1).map(|place| sorted[place]), sorted.get(high).copied())
            }
            Self::Fixed | Self::People(_) => {
                inference::quantile_interval(&sorted, level, 2.0 * confidence - 1.0)
            }
        };
        Interval { low: low.unwrap_or(f64::NEG_INFINITY), high: high.unwrap_or(f64::INFINITY) }
    }
}

fn fixed_share(holding: u64, runs: u64, confidence: f64) -> Interval {
    Interval {
        low: inference::lower_bound(holding, runs, confidence),
        high: inference::upper_bound(holding, runs, confidence),
    }
}

/// Whether nobody has more than one run.
fn once_each(whose: &[usize]) -> bool {
    whose.iter().max().is_none_or(|last| last + 1 == whose.len())
}

/// Each person's runs together.
fn per_person(values: &[Option<f64>], whose: &[usize]) -> Vec<IndependentUnit> {
    let people = whose.iter().max().map_or(0, |last| last + 1);
    let of = |person: usize| {
        IndependentUnit::of_runs(
            values.iter().zip(whose).filter(|(_, whose)| **whose == person).map(|(value, _)| *value),
        )
    };
    (0..people).map(of).collect()
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
    use statrs::distribution::{Beta, Binomial, ContinuousCDF, DiscreteCDF};

    use super::*;

    /// So many runs, of which the first ones hold.
    fn held(holding: usize, runs: usize) -> Vec<bool> {
        (0..runs).map(|run| run < holding).collect()
    }

    fn at_least(share: f64, holding: usize, runs: usize) -> Verdict {
        decide(Relation::GreaterOrEqual, Bounds::Fixed.of_share(&held(holding, runs), 0.95), share)
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
        let interval = Bounds::Fixed.of_share(&held(10, 20), 0.975);
        assert!(
            (interval.low - 0.2720).abs() < 5e-5 && (interval.high - 0.7280).abs() < 5e-5,
            "{interval:?}"
        );
        // And as quantiles of the beta distribution, by another implementation.
        for (holding, runs, confidence) in [(3_u32, 40_u32, 0.9), (58, 60, 0.95), (199, 200, 0.99)] {
            let interval = Bounds::Fixed.of_share(&held(holding as usize, runs as usize), confidence);
            let (k, n) = (f64::from(holding), f64::from(runs));
            let low = Beta::new(k, n - k + 1.0).unwrap().inverse_cdf(1.0 - confidence);
            let high = Beta::new(k + 1.0, n - k).unwrap().inverse_cdf(confidence);
            assert!((interval.low - low).abs() < 1e-6 && (interval.high - high).abs() < 1e-6, "{interval:?}");
        }
    }

    #[test]
    fn quantiles_are_bounded_by_order_statistics() {
        let metric = models::known::measured("pet");
        let interval = |runs: u32, level: f64, confidence: f64| {
            // In no order, as runs come.
            let values: Vec<_> = (0..runs).map(|k| Some(f64::from(k * 37 % runs + 1))).collect();
            let aggregate = Aggregate::Quantile(level, metric.clone());
            let interval = Bounds::Fixed.of_values(&aggregate, &values, None, confidence, 1).unwrap();
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
        let at_least = |bounds: Bounds, runs| {
            decide(Relation::GreaterOrEqual, bounds.of_share(&held(runs, runs), 0.95), 0.95)
        };
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

    fn mean_of(values: &[f64], bounds: Bounds, limits: Option<(f64, f64)>) -> Option<Interval> {
        let metric = models::known::measured("stopped_time");
        let values: Vec<_> = values.iter().copied().map(Some).collect();
        bounds.of_values(&Aggregate::Mean(metric), &values, limits, 0.95, 1)
    }

    #[test]
    fn equal_values_say_little_of_the_mean() {
        let limited = mean_of(&[0.0; 20], Bounds::Fixed, Some((0.0, 60.0))).unwrap();
        assert!(limited.low == 0.0 && limited.high > 8.0, "{limited:?}");
        // And nothing where there are no limits.
        assert_eq!(mean_of(&[0.0; 20], Bounds::Fixed, None), None);
        // Looking again and again costs nothing more; without limits it cannot be afforded.
        assert_eq!(mean_of(&[0.0; 20], Bounds::Sequential, Some((0.0, 60.0))), Some(limited));
        assert_eq!(mean_of(&[0.0, 1.0, 2.0], Bounds::Sequential, None), None);
        // A value beyond the limits contradicts them.
        assert_eq!(mean_of(&[61.0, 3.0], Bounds::Fixed, Some((0.0, 60.0))), None);
    }

    #[test]
    fn people_count_once() {
        // Three people of ten runs each, who always do the same.
        let whose: Vec<usize> = (0..30).map(|run| run / 10).collect();
        let held: Vec<bool> = (0..30).map(|run| run < 20).collect();
        let people = Bounds::People(&whose).of_share(&held, 0.95);
        let runs = Bounds::Fixed.of_share(&held, 0.95);
        assert!(people.low < 0.2 && people.high > 0.95, "{people:?}");
        assert!(people.low < runs.low && people.high > runs.high);
        // With one run each they are as independent as runs.
        let once: Vec<usize> = (0..30).collect();
        assert_eq!(Bounds::People(&once).of_share(&held, 0.95), runs);
        let metric = models::known::measured("pet");
        let median = |bounds: Bounds| {
            let values: Vec<_> = (0..30).map(|run| Some(f64::from(run))).collect();
            bounds.of_values(&Aggregate::Median(metric.clone()), &values, None, 0.95, 1).unwrap()
        };
        // Nothing bounds the median of three people; that of 30 is bounded as by runs.
        let three = median(Bounds::People(&whose));
        assert_eq!((three.low, three.high), (f64::NEG_INFINITY, f64::INFINITY));
        assert_eq!(median(Bounds::People(&once)), median(Bounds::Fixed));
        // Thirty people of two runs each: by betting, wider than the order statistics of 60 runs.
        let twice: Vec<usize> = (0..60).map(|run| run / 2).collect();
        let values: Vec<_> = (0..60).map(|run| Some(f64::from(run / 2))).collect();
        let of = |bounds: Bounds| {
            bounds.of_values(&Aggregate::Median(metric.clone()), &values, None, 0.95, 1).unwrap()
        };
        let (clusters, runs) = (of(Bounds::People(&twice)), of(Bounds::Fixed));
        assert!(clusters.low.is_finite() && clusters.high.is_finite(), "{clusters:?}");
        assert!(clusters.low <= runs.low && clusters.high >= runs.high, "{clusters:?} {runs:?}");
    }
}
