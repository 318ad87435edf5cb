//! Intervals of means by resampling, studentised, so that they cover as stated also for skewed metrics.
//!
//! Source: B. Efron & R. Tibshirani, An Introduction to the Bootstrap, 1993, section 12.5 (bootstrap-t).

use super::Interval;
use super::strata::Strata;

/// The mean of all runs there could be. `None` of fewer than two values, or where so few differ that resampling cannot
/// tell, nor where none do: resampling knows of no other values than those it was given.
///
/// At each end the farther of bootstrap-t's and Student's: bootstrap-t is right for skewed values, and a little short
/// where tails are heavy on both sides. `cargo bench --bench coverage` measures how often it covers; `docs/gates.md` has
/// the table.
pub fn mean_interval(values: &[f64], confidence: f64, seed: u64) -> Option<Interval> {
    if values.len() < 2 {
        return None;
    }
    let strata = Strata::one(values.to_vec());
    let estimate = strata.estimate();
    if estimate.error == 0.0 {
        return None;
    }
    let interval = estimate.interval(&strata.resampled(seed), strata.freedom(), confidence);
    (interval.low.is_finite() && interval.high.is_finite()).then_some(interval)
}

/// The mean difference `candidate - base` over pairs of runs with common random numbers, as [`mean_interval`].
/// Both have one value per pair, in the same order.
pub fn paired_difference(base: &[f64], candidate: &[f64], confidence: f64, seed: u64) -> Option<Interval> {
    debug_assert_eq!(base.len(), candidate.len());
    let differences: Vec<f64> =
        base.iter().zip(candidate).map(|(base, candidate)| candidate - base).collect();
    mean_interval(&differences, confidence, seed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;
    use crate::summary::{mean, std};

    /// The share of experiments in which an interval covers the truth; no interval covers nothing.
    fn coverage(
        experiments: u64,
        truth: f64,
        draw: impl Fn(&mut Stream) -> f64,
        interval: impl Fn(&[f64], u64) -> Option<Interval>,
    ) -> f64 {
        let mut stream = Stream::seeded(20_261_121);
        let covering = (0..experiments).filter(|seed| {
            let values: Vec<_> = (0..30).map(|_| draw(&mut stream)).collect();
            interval(&values, *seed).is_some_and(|interval| interval.contains(truth))
        });
        covering.count() as f64 / experiments as f64
    }

    #[test]
    fn intervals_are_the_same_for_the_same_seed() {
        let values: Vec<_> = (0..20).map(|k| f64::from(k * k % 17)).collect();
        assert_eq!(mean_interval(&values, 0.95, 1), mean_interval(&values, 0.95, 1));
        assert_ne!(mean_interval(&values, 0.95, 1), mean_interval(&values, 0.95, 2));
    }

    #[test]
    fn intervals_of_normal_values_are_near_the_t_interval() {
        let mut stream = Stream::seeded(5);
        let values: Vec<_> = (0..200).map(|_| stream.normal()).collect();
        let interval = mean_interval(&values, 0.95, 3).unwrap();
        let (mean, std) = (mean(&values).unwrap(), std(&values).unwrap());
        // The 97.5 % point of Student's t with 199 degrees of freedom.
        let half = 1.972 * std / 200.0_f64.sqrt();
        assert!((interval.low - (mean - half)).abs() < 0.15 * half, "{interval:?}");
        assert!((interval.high - (mean + half)).abs() < 0.15 * half, "{interval:?}");
    }

    #[test]
    fn what_resampling_cannot_tell() {
        assert_eq!(mean_interval(&[1.0], 0.95, 0), None);
        assert_eq!(mean_interval(&[2.0, 2.0, 2.0], 0.95, 0), None);
        // One value among many that differs: every third resample misses it.
        let mut values = [0.0; 30];
        values[7] = 1.0;
        assert_eq!(mean_interval(&values, 0.95, 0), None);
    }

    // `cargo bench --bench coverage` does this over 10,000 experiments and more distributions.
    #[test]
    fn intervals_cover_about_as_stated() {
        let means = |values: &[f64], seed| mean_interval(values, 0.95, seed);
        let normal = coverage(400, 0.0, |stream| stream.normal(), means);
        let skewed = coverage(400, 1.0, |stream| -libm::log(stream.uniform()), means);
        // Three standard errors of the simulation are 3.3 %.
        assert!(normal > 0.917 && skewed > 0.90, "{normal} {skewed}");
    }
}
