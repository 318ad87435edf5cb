//! Comparing two variants on the same seeds: did events become more frequent, and which of many findings stand.

use serde::{Deserialize, Serialize};

use super::Interval;
use super::distributions::binomial_at_least;
use super::proportion::{lower_bound, upper_bound};

/// The exact test on pairs of runs of which only one had the event.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct McNemar {
    /// Probability of a difference at least as large in either direction if there is none.
    pub two_sided: f64,
    /// Probability of at least so many pairs with the event in the candidate only, if there is no difference.
    pub more_in_candidate: f64,
}

/// `only_base` and `only_candidate`: pairs in which only that one had the event. Pairs that agree say nothing.
///
/// Source: Q. McNemar, Psychometrika 12, 1947, with exact binomial tails.
pub fn mcnemar(only_base: u64, only_candidate: u64) -> McNemar {
    let pairs = only_base + only_candidate;
    let tail = binomial_at_least(only_base.max(only_candidate), pairs, 0.5);
    McNemar {
        two_sided: (2.0 * tail).min(1.0),
        more_in_candidate: binomial_at_least(only_candidate, pairs, 0.5),
    }
}

/// Change of an event's rate from base to candidate over `pairs` of runs: exact in that it covers at least as often as
/// stated, however rare the event. One-sided bounds at confidence c ask for 2 c - 1.
///
/// The rates of both kinds of disagreeing pairs get exact bounds that share the error between them (Bonferroni).
pub fn rate_change(only_base: u64, only_candidate: u64, pairs: u64, confidence: f64) -> Interval {
    let each = 1.0 - (1.0 - confidence) / 4.0;
    Interval {
        low: lower_bound(only_candidate, pairs, each) - upper_bound(only_base, pairs, each),
        high: upper_bound(only_candidate, pairs, each) - lower_bound(only_base, pairs, each),
    }
}

/// P-values adjusted for how many there are, in the given order: those at most α may all be rejected with probability
/// at most α of any false rejection.
///
/// Source: S. Holm, Scand. J. Stat. 6, 1979.
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|left, right| p_values[*left].total_cmp(&p_values[*right]));
    let mut adjusted = vec![0.0; p_values.len()];
    let mut largest: f64 = 0.0;
    for (rank, index) in order.into_iter().enumerate() {
        largest = largest.max(p_values[index] * (p_values.len() - rank) as f64);
        adjusted[index] = largest.min(1.0);
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::random::Stream;

    #[test]
    fn mcnemar_by_hand() {
        // 1 against 7: 2 (1 + 8)/2^8.
        assert!((mcnemar(7, 1).two_sided - 18.0 / 256.0).abs() < 1e-15);
        assert!((mcnemar(1, 7).more_in_candidate - 9.0 / 256.0).abs() < 1e-15);
        assert_eq!(mcnemar(0, 0), McNemar { two_sided: 1.0, more_in_candidate: 1.0 });
        assert_eq!(mcnemar(3, 3).two_sided, 1.0);
    }

    #[test]
    fn holm_by_hand() {
        let adjusted = holm(&[0.01, 0.04, 0.03, 0.005]);
        let expected = [0.03, 0.06, 0.06, 0.02];
        for (found, expected) in adjusted.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15, "{adjusted:?}");
        }
        assert_eq!(holm(&[]), Vec::<f64>::new());
        assert_eq!(holm(&[0.7, 0.9]), [1.0, 1.0]);
    }

    #[test]
    fn rate_changes_cover_as_stated() {
        // Of 60 pairs, 5 % have the event in the base only and 12 % in the candidate only.
        let mut stream = Stream::seeded(3);
        let experiments = 2000;
        let mut covering = 0;
        for _ in 0..experiments {
            let (mut base, mut candidate) = (0, 0);
            for _ in 0..60 {
                let draw = stream.uniform();
                base += u64::from(draw < 0.05);
                candidate += u64::from(draw > 0.88);
            }
            covering += u32::from(rate_change(base, candidate, 60, 0.95).contains(0.07));
        }
        assert!(f64::from(covering) / f64::from(experiments) >= 0.95, "{covering}");
        let none = rate_change(0, 0, 100, 0.95);
        assert!(none.low < 0.0 && none.high > 0.0 && none.high < 0.05, "{none:?}");
    }
}
