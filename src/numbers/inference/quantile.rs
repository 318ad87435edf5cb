//! What order statistics say of a quantile, without assumptions about the distribution.

use super::largest_true;
use crate::distributions::{binomial_at_least, binomial_at_most};

/// Bounds on the quantile at `level` of the distribution behind sorted values: two of the values themselves, without
/// assumptions about the distribution. Each bound is wrong with probability at most (1 - `confidence`)/2, or is `None`
/// if there are too few values for one. For a one-sided bound at confidence c ask for 2 c - 1.
///
/// Source: H. A. David & H. N. Nagaraja, Order Statistics, 3rd ed. 2003, section 7.1.
pub fn quantile_interval(sorted: &[f64], level: f64, confidence: f64) -> (Option<f64>, Option<f64>) {
    let n = sorted.len() as u64;
    // Rounding must not cost the run that is just enough.
    let each = (1.0 - confidence) / 2.0 * (1.0 + 1e-12);
    // The k-th smallest value is too large as a lower bound if fewer than k values lie below the quantile.
    let low = largest_true(n, |k| binomial_at_most(k - 1, n, level) <= each);
    // Mirrored: the k-th largest is too small as an upper bound if fewer than k lie above the quantile.
    let high = largest_true(n, |k| binomial_at_least(n - k + 1, n, level) <= each);
    (low.map(|k| sorted[k as usize - 1]), high.map(|k| sorted[(n - k) as usize]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(n: u64) -> Vec<f64> {
        (1..=n).map(|k| k as f64).collect()
    }

    #[test]
    fn tabulated_bounds_of_the_median() {
        // Tables give the 2nd and 9th of 10 values and the 6th and 15th of 20 at 95 %.
        assert_eq!(quantile_interval(&numbers(10), 0.5, 0.95), (Some(2.0), Some(9.0)));
        assert_eq!(quantile_interval(&numbers(20), 0.5, 0.95), (Some(6.0), Some(15.0)));
    }

    #[test]
    fn a_bound_needs_enough_runs() {
        // One-sided at 95 %: the largest of 59 values bounds the 95 % quantile, of 58 it does not.
        assert_eq!(quantile_interval(&numbers(59), 0.95, 0.9).1, Some(59.0));
        assert_eq!(quantile_interval(&numbers(58), 0.95, 0.9).1, None);
        assert_eq!(quantile_interval(&[], 0.5, 0.95), (None, None));
    }

    #[test]
    fn bounds_cover_as_stated() {
        // For continuous values the number below the quantile is binomial, so coverage is a sum.
        for (n, level) in [(20, 0.5), (100, 0.9), (300, 0.95), (77, 0.1)] {
            let (low, high) = quantile_interval(&numbers(n), level, 0.95);
            let (low, high) = (low.unwrap() as u64, high.unwrap() as u64);
            let covered = binomial_at_most(high - 1, n, level) - binomial_at_most(low - 1, n, level);
            assert!(covered >= 0.95, "{covered} for {n}");
        }
    }
}
