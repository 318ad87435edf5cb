//! Output scaling: mean and standard deviation for well-behaved values, median and absolute deviation when there are outliers.

use serde::{Deserialize, Serialize};

use numbers::summary::median_of;

/// Robust z-score past which a value counts as an outlier.
const OUTLIER: f64 = 12.0;
/// Robust z-score past which values are compressed, once there are outliers.
const KNEE: f64 = 4.0;
/// The factor from median absolute deviation to standard deviation of a normal distribution.
const NORMAL_CONSISTENCY: f64 = 1.482_602_218_505_602;
/// Deviations up to this share of the largest value are rounding: those of equal values are about 1e-16 of their size.
const ROUNDING: f64 = 1e-12;

/// Which values may be called outliers and compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Outliers {
    /// None: plain mean and standard deviation.
    Keep,
    /// Large values only: an objective to minimise keeps its deepest wells as they are.
    CompressHigh,
    /// Large values of either sign.
    CompressBoth,
}

/// A monotone map from a family of values to numbers of order one.
///
/// z = (y − centre)/scale; with outliers, z past a knee grows only as its logarithm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Standardisation {
    /// What becomes zero.
    pub centre: f64,
    /// What becomes one.
    pub scale: f64,
    compress: Outliers,
}

impl Standardisation {
    /// The map for these finite values. Constant values keep their unit.
    pub fn of(values: &[f64], outliers: Outliers) -> Self {
        let usual = Standardisation { compress: Outliers::Keep, ..Self::by_moments(values) };
        if outliers == Outliers::Keep {
            return usual;
        }
        let median = |values: &[f64]| median_of(values).unwrap_or(0.0);
        let centre = median(values);
        let deviations: Vec<f64> = values.iter().map(|value| (value - centre).abs()).collect();
        let rounding = ROUNDING * largest_of(values);
        let mut scale = NORMAL_CONSISTENCY * median(&deviations);
        if scale <= rounding {
            // More than half the values are equal: the typical size of the others' deviations.
            let others: Vec<f64> = deviations.into_iter().filter(|&deviation| deviation > rounding).collect();
            if others.is_empty() {
                return usual;
            }
            scale = median(&others);
        }
        let worst = values.iter().map(|value| match outliers {
            Outliers::CompressBoth => (value - centre).abs(),
            _ => value - centre,
        });
        let worst = worst.fold(0.0, f64::max) / scale;
        if worst > OUTLIER && scale.is_finite() {
            Standardisation { centre, scale, compress: outliers }
        } else {
            usual
        }
    }

    fn by_moments(values: &[f64]) -> Self {
        // Scaled by the largest first, so that squares of very large values stay finite.
        let largest = largest_of(values);
        let unit = if largest > 0.0 { largest } else { 1.0 };
        let n = values.len().max(1) as f64;
        let mean = values.iter().map(|value| value / unit).sum::<f64>() / n;
        let variance =
            values.iter().map(|value| (value / unit - mean) * (value / unit - mean)).sum::<f64>() / n;
        let deviation = unit * variance.sqrt();
        let scale = if deviation > ROUNDING * largest { deviation } else { 1.0 };
        Standardisation { centre: mean * unit, scale, compress: Outliers::Keep }
    }

    /// The number a value becomes.
    pub fn apply(&self, value: f64) -> f64 {
        let z = (value - self.centre) / self.scale;
        let compressed = |z: f64| if z > KNEE { KNEE + libm::log1p(z - KNEE) } else { z };
        match self.compress {
            Outliers::Keep => z,
            Outliers::CompressHigh => compressed(z),
            Outliers::CompressBoth => compressed(z.abs()).copysign(z),
        }
    }

    /// The value that becomes this number.
    pub fn undo(&self, z: f64) -> f64 {
        let expanded = |z: f64| if z > KNEE { KNEE + libm::expm1(z - KNEE) } else { z };
        let z = match self.compress {
            Outliers::Keep => z,
            Outliers::CompressHigh => expanded(z),
            Outliers::CompressBoth => expanded(z.abs()).copysign(z),
        };
        self.centre + self.scale * z
    }
}

/// The largest absolute value.
fn largest_of(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| value.abs().max(largest))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_penalty_does_not_flatten_the_rest() {
        let mut values: Vec<f64> = (0..20).map(|i| 3.0 + 0.1 * f64::from(i)).collect();
        values.push(1e6);
        let plain = Standardisation::of(&values, Outliers::Keep);
        let robust = Standardisation::of(&values, Outliers::CompressHigh);
        let spread = |map: Standardisation| map.apply(values[19]) - map.apply(values[0]);
        assert!(spread(plain) < 1e-4);
        assert!(spread(robust) > 1.5);
        assert!(robust.apply(1e6) < 20.0);
    }

    #[test]
    fn a_deep_well_is_not_an_outlier_of_an_objective() {
        let mut values = vec![3.0; 20];
        values.iter_mut().enumerate().for_each(|(i, value)| *value += 0.01 * i as f64);
        values.push(0.0);
        let map = Standardisation::of(&values, Outliers::CompressHigh);
        assert_eq!(map, Standardisation::of(&values, Outliers::Keep));
    }

    #[test]
    fn constants_keep_their_unit() {
        for value in [0.0, 3.25, 1e6, -1e150] {
            for outliers in [Outliers::Keep, Outliers::CompressHigh, Outliers::CompressBoth] {
                let map = Standardisation::of(&[value; 4], outliers);
                assert_eq!(map.scale, 1.0);
                assert!(map.apply(value).is_finite());
            }
        }
    }

    #[test]
    fn rounding_on_a_plateau_is_no_signal() {
        // Times lost on a plateau at 0: sums in another order differ in their last bit.
        let plateau = |jitter: f64| -> Vec<f64> {
            let flat = (0..30).map(|i| if i % 3 == 0 { jitter } else { 0.0 });
            flat.chain((0..10).map(|i| 0.5 + 0.2 * f64::from(i))).collect()
        };
        for outliers in [Outliers::Keep, Outliers::CompressHigh, Outliers::CompressBoth] {
            let (exact, rounded) = (
                Standardisation::of(&plateau(0.0), outliers),
                Standardisation::of(&plateau(3e-16), outliers),
            );
            assert!((exact.scale - rounded.scale).abs() < 1e-9, "{exact:?} {rounded:?}");
            assert!((exact.apply(2.3) - rounded.apply(2.3)).abs() < 1e-9);
        }
        // The same where half of all deviations are of the last bit.
        let values: Vec<f64> =
            (0..20).map(|i| if i % 2 == 0 { 0.75 } else { 0.750_000_000_000_000_1 }).collect();
        let values = [values, vec![4.0; 5]].concat();
        assert!(Standardisation::of(&values, Outliers::CompressHigh).scale > 0.1);
    }

    proptest! {
        #[test]
        fn it_is_monotone_and_can_be_undone(
            values in prop::collection::vec(prop_oneof![-5.0..5.0f64, Just(1e6), Just(-1e6), Just(0.0)], 1..30),
        ) {
            for outliers in [Outliers::Keep, Outliers::CompressHigh, Outliers::CompressBoth] {
                let map = Standardisation::of(&values, outliers);
                for a in &values {
                    let z = map.apply(*a);
                    prop_assert!(z.is_finite());
                    prop_assert!((map.undo(z) - a).abs() <= 1e-9 * a.abs().max(map.scale));
                    for b in &values {
                        prop_assert!(a >= b || z <= map.apply(*b));
                    }
                }
            }
        }
    }
}
