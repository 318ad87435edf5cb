//! Distributions with all of their numbers: where their shares lie.

use numbers::distributions::normal::Normal;
use numbers::distributions::{LogNormal, Triangular, beta_quantile, exponential_quantile};
use numbers::summary::median_of;

use super::VariedValue;

/// A distribution with all of its numbers, SI units; a spread of 0 makes it a constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KnownDistribution<'a> {
    /// Any number between two equally likely.
    Uniform {
        /// The low end.
        low: f64,
        /// The high end, at least `low`.
        high: f64,
    },
    /// A normal distribution.
    Normal {
        /// Any number.
        mean: f64,
        /// At least 0.
        standard_deviation: f64,
    },
    /// A normal distribution without what lies outside of two ends.
    TruncatedNormal {
        /// Before it is cut.
        mean: f64,
        /// Before it is cut, at least 0.
        standard_deviation: f64,
        /// The low end.
        low: f64,
        /// The high end, at least `low`.
        high: f64,
    },
    /// A normal distribution of the logarithm.
    LogNormal {
        /// Above 0.
        median: f64,
        /// Standard deviation of the natural logarithm, at least 0.
        sigma: f64,
    },
    /// Between two ends, likeliest at a mode, falling in straight lines.
    Triangular {
        /// The low end.
        low: f64,
        /// Between the ends.
        mode: f64,
        /// The high end, at least `low`.
        high: f64,
    },
    /// A beta distribution, stretched to lie between two ends.
    Beta {
        /// Above 0.
        alpha: f64,
        /// Above 0.
        beta: f64,
        /// The low end.
        low: f64,
        /// The high end, at least `low`.
        high: f64,
    },
    /// An exponential distribution.
    Exponential {
        /// Above 0.
        mean: f64,
    },
    /// One of these, all equally likely.
    Choice(&'a [VariedValue]),
    /// One of these, as likely as its weight is of the sum of all.
    Weighted {
        /// What may be drawn.
        options: &'a [VariedValue],
        /// One for each: at least 0, some of them above.
        weights: &'a [f64],
    },
}

/// A value of a distribution.
#[derive(Debug, Clone, PartialEq)]
pub enum DrawnValue<'a> {
    /// SI units.
    Number(f64),
    /// One of those that were listed.
    Listed(&'a VariedValue),
}

/// Which of those with these weights lies at `share` of them all: the first before which, with itself, more than that share is.
/// One without weight never does.
pub fn at_share(share: f64, weights: &[f64]) -> usize {
    let all: f64 = weights.iter().sum();
    let mut sum = 0.0;
    let found = weights.iter().position(|weight| {
        sum += weight;
        *weight > 0.0 && sum > share * all
    });
    // Rounding may leave a hair beyond the last.
    found.or_else(|| weights.iter().rposition(|weight| *weight > 0.0)).unwrap_or(0)
}

impl<'a> KnownDistribution<'a> {
    /// The value below which `share` of it lies; of a list, the one at that share.
    pub fn quantile(&self, share: f64) -> DrawnValue<'a> {
        DrawnValue::Number(match *self {
            Self::Uniform { low, high } => low + (high - low) * share,
            Self::Normal { mean, standard_deviation } => Normal { mean, standard_deviation }.quantile(share),
            Self::TruncatedNormal { mean, standard_deviation: 0.0, low, high } => mean.clamp(low, high),
            Self::TruncatedNormal { mean, standard_deviation, low, high } => {
                Normal { mean, standard_deviation }.quantile_within(share, low, high)
            }
            Self::LogNormal { median, sigma } => LogNormal { median, sigma }.quantile(share),
            Self::Triangular { low, mode, high } => Triangular { low, mode, high }.quantile(share),
            Self::Beta { alpha, beta, low, high } => low + (high - low) * beta_quantile(share, alpha, beta),
            Self::Exponential { mean } => exponential_quantile(share, mean),
            Self::Choice(options) => {
                let index = (share * options.len() as f64) as usize;
                return DrawnValue::Listed(&options[index.min(options.len() - 1)]);
            }
            Self::Weighted { options, weights } => {
                return DrawnValue::Listed(&options[at_share(share, weights)]);
            }
        })
    }

    /// The number that stands for all of it, and what that is; `None` of what is no number.
    pub fn nominal(&self) -> Option<(f64, &'static str)> {
        match *self {
            Self::Uniform { low, high } => Some((low + (high - low) / 2.0, "the middle of its range")),
            Self::Normal { mean, .. } | Self::Exponential { mean } => Some((mean, "its mean")),
            Self::TruncatedNormal { mean, low, high, .. } => {
                Some((mean.clamp(low, high), "its most likely value"))
            }
            Self::LogNormal { median, .. } => Some((median, "its median")),
            Self::Triangular { mode, .. } => Some((mode, "its most likely value")),
            Self::Beta { alpha, beta, low, high } => {
                Some((low + (high - low) * alpha / (alpha + beta), "its mean"))
            }
            Self::Choice(options) => {
                let numbers: Option<Vec<f64>> = options.iter().map(|one| one.value.as_number()).collect();
                Some((median_of(&numbers?)?, "the middle of its values"))
            }
            Self::Weighted { options, weights } => {
                let likeliest =
                    (0..options.len()).rev().max_by(|one, other| weights[*one].total_cmp(&weights[*other]));
                Some((options[likeliest?].value.as_number()?, "its most likely value"))
            }
        }
    }

    /// Whether nothing but one value can be drawn.
    pub fn is_constant(&self) -> bool {
        match *self {
            Self::Normal { standard_deviation: spread, .. } | Self::LogNormal { sigma: spread, .. } => {
                spread == 0.0
            }
            Self::TruncatedNormal { standard_deviation, low, high, .. } => {
                standard_deviation == 0.0 || low == high
            }
            Self::Uniform { low, high }
            | Self::Triangular { low, high, .. }
            | Self::Beta { low, high, .. } => low == high,
            Self::Exponential { .. } => false,
            Self::Choice(options) => options.len() == 1,
            Self::Weighted { weights, .. } => weights.iter().filter(|weight| **weight > 0.0).count() == 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use numbers::distributions::regularised_beta;
    use numbers::random::Stream;

    use super::*;
    use crate::Value;

    fn number(of: KnownDistribution, share: f64) -> f64 {
        match of.quantile(share) {
            DrawnValue::Number(number) => number,
            DrawnValue::Listed(option) => option.value.as_number().unwrap(),
        }
    }

    fn options(count: u32) -> Vec<VariedValue> {
        (0..count)
            .map(|one| VariedValue { value: Value::Number(f64::from(one)), label: one.to_string() })
            .collect()
    }

    /// Mean and variance by their formulas: a second derivation of every quantile function at once.
    #[test]
    fn draws_have_the_moments_that_formulas_give() {
        let (four, weights) = (options(4), [1.0, 0.0, 2.0, 1.0]);
        let s = 0.4_f64;
        let all = [
            (KnownDistribution::Uniform { low: 2.0, high: 5.0 }, 3.5, 9.0 / 12.0),
            (KnownDistribution::Normal { mean: -1.0, standard_deviation: 2.0 }, -1.0, 4.0),
            // Of a standard normal one between -1 and 1: 1 - 2 φ(1) / (2 Φ(1) - 1).
            (
                KnownDistribution::TruncatedNormal {
                    mean: 0.0,
                    standard_deviation: 1.0,
                    low: -1.0,
                    high: 1.0,
                },
                0.0,
                0.291_125_1,
            ),
            (
                KnownDistribution::LogNormal { median: 3.0, sigma: s },
                3.0 * (s * s / 2.0).exp(),
                9.0 * ((s * s).exp() - 1.0) * (s * s).exp(),
            ),
            (
                KnownDistribution::Triangular { low: 1.0, mode: 2.0, high: 6.0 },
                3.0,
                (1.0 + 4.0 + 36.0 - 2.0 - 6.0 - 12.0) / 18.0,
            ),
            (
                KnownDistribution::Beta { alpha: 2.0, beta: 5.0, low: 1.0, high: 8.0 },
                1.0 + 7.0 * 2.0 / 7.0,
                49.0 * 10.0 / (49.0 * 8.0),
            ),
            (KnownDistribution::Exponential { mean: 2.5 }, 2.5, 6.25),
            (KnownDistribution::Choice(&four), 1.5, 1.25),
            (
                KnownDistribution::Weighted { options: &four, weights: &weights },
                7.0 / 4.0,
                17.0 / 4.0 - 49.0 / 16.0,
            ),
        ];
        // The middle of 20,000 equal slices: the integral of the quantile function, without chance.
        let slices = 20_000;
        for (of, mean, variance) in all {
            let values: Vec<f64> =
                (0..slices).map(|k| number(of, (f64::from(k) + 0.5) / f64::from(slices))).collect();
            let found = values.iter().sum::<f64>() / f64::from(slices);
            let spread = values.iter().map(|one| (one - found).powi(2)).sum::<f64>() / f64::from(slices);
            assert!((found - mean).abs() < 2e-4 * variance.sqrt(), "{of:?}: {found}, not {mean}");
            assert!((spread / variance - 1.0).abs() < 3e-3, "{of:?}: {spread}, not {variance}");
        }
    }

    #[test]
    fn beta_quantiles_turn_its_shares_around() {
        let mut stream = Stream::seeded(5);
        for _ in 0..200 {
            let (alpha, beta) = (stream.uniform_in(0.3, 9.0), stream.uniform_in(0.3, 9.0));
            let share = stream.uniform();
            let value = number(KnownDistribution::Beta { alpha, beta, low: 2.0, high: 6.0 }, share);
            let back = regularised_beta((value - 2.0) / 4.0, alpha, beta);
            assert!((back - share).abs() < 1e-9, "{alpha} {beta} {share}: {back}");
        }
    }

    #[test]
    fn larger_shares_never_lie_lower() {
        let (options, weights) = (options(5), [0.0, 3.0, 0.5, 0.0, 1.0]);
        let all = [
            KnownDistribution::TruncatedNormal { mean: 0.0, standard_deviation: 1.0, low: 2.0, high: 7.0 },
            KnownDistribution::LogNormal { median: 3.0, sigma: 1.4 },
            KnownDistribution::Triangular { low: 1.0, mode: 1.0, high: 6.0 },
            KnownDistribution::Beta { alpha: 0.5, beta: 0.5, low: 1.0, high: 8.0 },
            KnownDistribution::Exponential { mean: 2.5 },
            KnownDistribution::Weighted { options: &options, weights: &weights },
        ];
        for of in all {
            let values: Vec<f64> = (1..2000).map(|k| number(of, f64::from(k) / 2000.0)).collect();
            assert!(values.windows(2).all(|pair| pair[0] <= pair[1]), "{of:?}");
            assert!(!of.is_constant());
        }
    }

    #[test]
    fn weights_are_shares_of_their_sum() {
        let weights = [0.0, 3.0, 0.0, 1.0, 0.0];
        assert_eq!(
            [1e-16, 0.2, 0.749, 0.75, 0.99, 1.0].map(|share| at_share(share, &weights)),
            [1, 1, 1, 3, 3, 3]
        );
        // However large they are.
        assert_eq!(at_share(0.74, &weights.map(|weight| weight * 1e300)), 1);
    }

    #[test]
    fn what_has_one_value_is_a_constant() {
        let options = options(2);
        let constant = [
            KnownDistribution::Uniform { low: 1.0, high: 1.0 },
            KnownDistribution::Normal { mean: 1.0, standard_deviation: 0.0 },
            KnownDistribution::LogNormal { median: 1.0, sigma: 0.0 },
            KnownDistribution::Triangular { low: 1.0, mode: 1.0, high: 1.0 },
            KnownDistribution::Choice(&options[..1]),
            KnownDistribution::Weighted { options: &options, weights: &[0.0, 2.0] },
        ];
        assert!(constant.iter().all(KnownDistribution::is_constant));
    }
}
