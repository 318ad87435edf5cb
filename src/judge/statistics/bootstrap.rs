//! Intervals of means and spreads by resampling, studentised, so that they cover as stated also for skewed metrics.
//!
//! Source: B. Efron & R. Tibshirani, An Introduction to the Bootstrap, 1993, section 12.5 (bootstrap-t).

use super::Interval;
use super::summary::{mean, std};
use crate::sim::random::Stream;

/// One less than a round number, so that the wanted quantiles are resamples themselves.
const RESAMPLES: usize = 1999;

/// The mean of all runs there could be. `None` of fewer than two values, or where so few differ that resampling cannot
/// tell. Values that are all equal give an interval of no width: resampling knows of no other values.
///
/// Coverage at a stated 95 % (`cargo bench --bench coverage`), 20 and 50 values: normal 95.1 and 95.4 %, uniform 97.2
/// and 96.1 %, exponential 94.5 and 94.6 %.
pub fn mean_interval(values: &[f64], confidence: f64, seed: u64) -> Option<Interval> {
    studentised(values, confidence, seed, |sample| {
        Some(Estimate { value: mean(sample)?, error: std(sample)? / (sample.len() as f64).sqrt() })
    })
}

/// The standard deviation of all runs there could be, as [`mean_interval`]; resampled as the logarithm of the variance,
/// whose error depends less on its size.
///
/// For showing, not for verdicts: at a stated 95 % it covers too seldom where tails are heavy. Measured for 20 and 50
/// values: normal 93.4 and 94.6 %, uniform 94.3 and 95.1 %, exponential 88.1 and 91.1 %.
pub fn std_interval(values: &[f64], confidence: f64, seed: u64) -> Option<Interval> {
    let interval = studentised(values, confidence, seed, |sample| {
        let (mean, std) = (mean(sample)?, std(sample)?);
        let n = sample.len() as f64;
        let fourth_power = |value: &f64| {
            let square = (value - mean) * (value - mean) / (std * std);
            square * square
        };
        let kurtosis = sample.iter().map(fourth_power).sum::<f64>() / n;
        // Large-sample variance of a sample variance, relative to its square.
        let error = ((kurtosis - (n - 3.0) / (n - 1.0)) / n).max(0.0).sqrt();
        (std > 0.0).then(|| Estimate { value: 2.0 * libm::log(std), error })
    });
    let spread = |logarithm: f64| libm::exp(logarithm / 2.0);
    match std(values)? {
        0.0 => Some(Interval { low: 0.0, high: 0.0 }),
        _ => interval.map(|ends| Interval { low: spread(ends.low), high: spread(ends.high) }),
    }
}

/// The mean difference `candidate - base` over pairs of runs with common random numbers, as [`mean_interval`].
/// Both have one value per pair, in the same order.
pub fn paired_difference(base: &[f64], candidate: &[f64], confidence: f64, seed: u64) -> Option<Interval> {
    debug_assert_eq!(base.len(), candidate.len());
    let differences: Vec<f64> =
        base.iter().zip(candidate).map(|(base, candidate)| candidate - base).collect();
    mean_interval(&differences, confidence, seed)
}

/// The change of the mean relative to the base's mean, (candidate - base)/|base|, over pairs of runs. `None` also where
/// the base's mean is not clearly away from 0.
pub fn relative_change(base: &[f64], candidate: &[f64], confidence: f64, seed: u64) -> Option<Interval> {
    debug_assert_eq!(base.len(), candidate.len());
    let spread = std(base)? / (base.len() as f64).sqrt();
    mean(base).filter(|mean| mean.abs() > 4.0 * spread)?;
    let pairs: Vec<_> = base.iter().copied().zip(candidate.iter().copied()).collect();
    studentised(&pairs, confidence, seed, |sample| {
        let n = sample.len() as f64;
        let base = sample.iter().map(|pair| pair.0).sum::<f64>() / n;
        let ratio = sample.iter().map(|pair| pair.1).sum::<f64>() / n / base;
        // A ratio errs by what the candidate is off the ratio times the base.
        let off = |pair: &(f64, f64)| pair.1 - ratio * pair.0;
        let squares: f64 = sample.iter().map(|pair| off(pair) * off(pair)).sum();
        let error = (squares / (n - 1.0) / n).sqrt() / base.abs();
        Some(Estimate { value: (ratio - 1.0) * base.signum(), error })
    })
}

/// A statistic of a sample and its standard error.
struct Estimate {
    value: f64,
    error: f64,
}

fn studentised<T: Copy>(
    values: &[T],
    confidence: f64,
    seed: u64,
    estimate: impl Fn(&[T]) -> Option<Estimate>,
) -> Option<Interval> {
    if values.len() < 2 {
        return None;
    }
    let whole = estimate(values)?;
    if whole.error == 0.0 {
        return Some(Interval { low: whole.value, high: whole.value });
    }
    let mut stream = Stream::seeded(seed);
    let mut sample = values.to_vec();
    let mut deviations: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            sample.fill_with(|| values[stream.index(values.len())]);
            match estimate(&sample) {
                Some(again) if again.value == whole.value => 0.0,
                Some(again) => (again.value - whole.value) / again.error,
                None => f64::INFINITY,
            }
        })
        .collect();
    deviations.sort_by(f64::total_cmp);
    let place = ((1.0 - confidence) / 2.0 * (RESAMPLES + 1) as f64).floor().max(1.0) as usize;
    let low = whole.value - deviations[RESAMPLES - place] * whole.error;
    let high = whole.value - deviations[place - 1] * whole.error;
    (low.is_finite() && high.is_finite()).then_some(Interval { low, high })
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(mean_interval(&[2.0, 2.0, 2.0], 0.95, 0), Some(Interval { low: 2.0, high: 2.0 }));
        assert_eq!(std_interval(&[2.0, 2.0, 2.0], 0.95, 0), Some(Interval { low: 0.0, high: 0.0 }));
        // One value among many that differs: every third resample misses it.
        let mut values = [0.0; 30];
        values[7] = 1.0;
        assert_eq!(mean_interval(&values, 0.95, 0), None);
    }

    #[test]
    fn a_relative_change_is_found() {
        let mut stream = Stream::seeded(11);
        let base: Vec<_> = (0..100).map(|_| 10.0 + stream.normal()).collect();
        let candidate: Vec<_> = base.iter().map(|value| 1.05 * value + 0.01 * stream.normal()).collect();
        let change = relative_change(&base, &candidate, 0.95, 1).unwrap();
        assert!(change.contains(0.05) && change.high - change.low < 0.001, "{change:?}");
        let difference = paired_difference(&base, &candidate, 0.95, 1).unwrap();
        assert!(difference.low > 0.4 && difference.high < 0.6, "{difference:?}");
        let nowhere: Vec<_> = (0..100).map(|_| stream.normal()).collect();
        assert_eq!(relative_change(&nowhere, &candidate, 0.95, 1), None);
        // A negative base: going up by half of its size is +50 %.
        let half = relative_change(&[-2.0, -2.0, -2.1], &[-1.0, -1.0, -1.05], 0.95, 1).unwrap();
        assert!(half.contains(0.5), "{half:?}");
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
