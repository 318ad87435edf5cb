//! Comparing two variants on the same seeds: did events become more frequent, and which of many findings stand.

use serde::{Deserialize, Serialize};

use crate::distributions::binomial_at_least;

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
}
