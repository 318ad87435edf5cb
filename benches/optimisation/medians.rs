//! Medians of many runs, with the central 90 % of their bootstrap distribution.

use numbers::summary;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Of values in any order; not a number of none.
pub fn quantile(values: &[f64], level: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    summary::quantile(&sorted, level).unwrap_or(f64::NAN)
}

/// Medians of samples drawn from `values` with replacement.
pub fn bootstrap_medians(values: &[f64], seed: u64) -> Vec<f64> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut again = || values[generator.random_range(0..values.len())];
    let mut median = |_| quantile(&(0..values.len()).map(|_| again()).collect::<Vec<f64>>(), 0.5);
    (0..500).map(&mut median).collect()
}

/// Median with the central 90 % of its bootstrap distribution.
pub fn median_interval(values: &[f64]) -> String {
    let medians = bootstrap_medians(values, 1);
    format!("{:.4} [{:.4}, {:.4}]", quantile(values, 0.5), quantile(&medians, 0.05), quantile(&medians, 0.95))
}
