//! What draws and sampled variations draw from: distributions whose numbers may depend on variations and on other draws, and all that
//! has to be known of each.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{EvaluationError, Expression, KnownDistribution, Value, VariedValue};

/// What a draw or a sampled variation is drawn from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Distribution {
    /// Any number between two equally likely.
    Uniform {
        /// The low end, SI units.
        low: Expression,
        /// The high end, SI units.
        high: Expression,
    },
    /// A normal distribution.
    Normal {
        /// SI units.
        mean: Expression,
        /// SI units, at least 0.
        standard_deviation: Expression,
    },
    /// A normal distribution without what lies outside of two ends.
    TruncatedNormal {
        /// Before it is cut, SI units.
        mean: Expression,
        /// Before it is cut, SI units, at least 0.
        standard_deviation: Expression,
        /// The low end, SI units.
        low: Expression,
        /// The high end, SI units.
        high: Expression,
    },
    /// A normal distribution of the logarithm.
    LogNormal {
        /// SI units, above 0.
        median: Expression,
        /// Standard deviation of the natural logarithm, at least 0.
        sigma: Expression,
    },
    /// Between two ends, likeliest at a mode, falling in straight lines.
    Triangular {
        /// The low end, SI units.
        low: Expression,
        /// The likeliest value, SI units.
        mode: Expression,
        /// The high end, SI units.
        high: Expression,
    },
    /// A beta distribution, stretched to lie between two ends.
    Beta {
        /// Above 0.
        alpha: Expression,
        /// Above 0.
        beta: Expression,
        /// The low end, SI units.
        low: Expression,
        /// The high end, SI units.
        high: Expression,
    },
    /// An exponential distribution.
    Exponential {
        /// SI units, above 0.
        mean: Expression,
    },
    /// One of these, all equally likely.
    Choice(Vec<VariedValue>),
    /// One of these, as likely as its weight is of the sum of all.
    Weighted {
        /// What may be drawn.
        options: Vec<VariedValue>,
        /// One for each: at least 0, some of them above.
        weights: Vec<f64>,
    },
}

/// How scenarios call a distribution, and what they give it.
#[derive(Debug, Clone, Copy)]
pub struct DistributionWord {
    /// Such as `uniform`.
    pub word: &'static str,
    /// What stands in its parentheses.
    pub of: DistributionOf,
}

/// What a distribution is made of.
#[derive(Debug, Clone, Copy)]
pub enum DistributionOf {
    /// Numbers of one dimension, and plain ones: what each is, and the distribution of so many.
    Numbers(&'static [NumberOf], fn(Vec<Expression>) -> Option<Distribution>),
    /// Any number of values of one kind, each with a weight or all without.
    Values,
}

/// A number that a distribution is given.
#[derive(Debug, Clone, Copy)]
pub struct NumberOf {
    /// What it is, such as `mean`.
    pub name: &'static str,
    /// Whether it is a plain number, whatever the dimension of what is drawn.
    pub is_plain: bool,
}

/// Every distribution there is.
pub const DISTRIBUTIONS: [DistributionWord; 8] = {
    use DistributionOf::{Numbers, Values};
    const fn word(word: &'static str, of: DistributionOf) -> DistributionWord {
        DistributionWord { word, of }
    }
    const fn own(name: &'static str) -> NumberOf {
        NumberOf { name, is_plain: false }
    }
    const fn plain(name: &'static str) -> NumberOf {
        NumberOf { name, is_plain: true }
    }
    [
        word(
            "uniform",
            Numbers(&[own("low"), own("high")], |numbers| {
                let [low, high] = numbers.try_into().ok()?;
                Some(Distribution::Uniform { low, high })
            }),
        ),
        word(
            "normal",
            Numbers(&[own("mean"), own("standard deviation")], |numbers| {
                let [mean, standard_deviation] = numbers.try_into().ok()?;
                Some(Distribution::Normal { mean, standard_deviation })
            }),
        ),
        word(
            "truncated_normal",
            Numbers(&[own("mean"), own("standard deviation"), own("low"), own("high")], |numbers| {
                let [mean, standard_deviation, low, high] = numbers.try_into().ok()?;
                Some(Distribution::TruncatedNormal { mean, standard_deviation, low, high })
            }),
        ),
        word(
            "log_normal",
            Numbers(&[own("median"), plain("sigma")], |numbers| {
                let [median, sigma] = numbers.try_into().ok()?;
                Some(Distribution::LogNormal { median, sigma })
            }),
        ),
        word(
            "triangular",
            Numbers(&[own("low"), own("mode"), own("high")], |numbers| {
                let [low, mode, high] = numbers.try_into().ok()?;
                Some(Distribution::Triangular { low, mode, high })
            }),
        ),
        word(
            "beta",
            Numbers(&[plain("alpha"), plain("beta"), own("low"), own("high")], |numbers| {
                let [alpha, beta, low, high] = numbers.try_into().ok()?;
                Some(Distribution::Beta { alpha, beta, low, high })
            }),
        ),
        word(
            "exponential",
            Numbers(&[own("mean")], |numbers| {
                let [mean] = numbers.try_into().ok()?;
                Some(Distribution::Exponential { mean })
            }),
        ),
        word("choice", Values),
    ]
};

impl DistributionWord {
    /// The distribution of that word.
    pub fn find(word: &str) -> Option<&'static Self> {
        DISTRIBUTIONS.iter().find(|known| known.word == word)
    }
}

/// Why nothing can be drawn.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DistributionError {
    /// A number of it has no value.
    #[error("{0}")]
    Evaluation(#[from] EvaluationError),
    /// Nothing lies between its ends.
    #[error("the low end is above the high end")]
    Reversed,
    /// It would be narrower than a constant.
    #[error("the standard deviation is below 0")]
    NegativeSpread,
    /// The likeliest value is not among those that are possible.
    #[error("the mode is not between the ends")]
    ModeOutside,
    /// A number has to be above 0, of that name.
    #[error("its {0} is not above 0")]
    NotPositive(&'static str),
}

impl DistributionError {
    /// What to do about it, where that is known.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Evaluation(_) => None,
            Self::Reversed => Some("write the smaller value first"),
            Self::NegativeSpread => Some("give a standard deviation of at least 0"),
            Self::ModeOutside => {
                Some("write the low end, the likeliest value and the high end, in this order")
            }
            Self::NotPositive(_) => Some("give a number above 0"),
        }
    }
}

impl Distribution {
    /// The names that its numbers depend on.
    pub fn variables(&self) -> Vec<&str> {
        self.numbers().into_iter().flat_map(Expression::variables).collect()
    }

    pub(crate) fn numbers(&self) -> Vec<&Expression> {
        match self {
            Self::Uniform { low, high } => vec![low, high],
            Self::Normal { mean, standard_deviation } => vec![mean, standard_deviation],
            Self::TruncatedNormal { mean, standard_deviation, low, high } => {
                vec![mean, standard_deviation, low, high]
            }
            Self::LogNormal { median, sigma } => vec![median, sigma],
            Self::Triangular { low, mode, high } => vec![low, mode, high],
            Self::Beta { alpha, beta, low, high } => vec![alpha, beta, low, high],
            Self::Exponential { mean } => vec![mean],
            Self::Choice(_) | Self::Weighted { .. } => Vec::new(),
        }
    }

    pub(crate) fn numbers_mut(&mut self) -> Vec<&mut Expression> {
        match self {
            Self::Uniform { low, high } => vec![low, high],
            Self::Normal { mean, standard_deviation } => vec![mean, standard_deviation],
            Self::TruncatedNormal { mean, standard_deviation, low, high } => {
                vec![mean, standard_deviation, low, high]
            }
            Self::LogNormal { median, sigma } => vec![median, sigma],
            Self::Triangular { low, mode, high } => vec![low, mode, high],
            Self::Beta { alpha, beta, low, high } => vec![alpha, beta, low, high],
            Self::Exponential { mean } => vec![mean],
            Self::Choice(_) | Self::Weighted { .. } => Vec::new(),
        }
    }

    /// What may be drawn, where that is a list.
    pub fn options(&self) -> Option<&[VariedValue]> {
        match self {
            Self::Choice(options) | Self::Weighted { options, .. } => Some(options),
            _ => None,
        }
    }

    /// The distribution where variations have these values.
    ///
    /// # Errors
    /// If a number cannot be evaluated, or nothing can be drawn with it.
    pub fn known(
        &self,
        variables: &BTreeMap<String, Value>,
    ) -> Result<KnownDistribution<'_>, DistributionError> {
        let number = |expression: &Expression| expression.evaluate_number(variables);
        let ends = |low: &Expression, high: &Expression| {
            let (low, high) = (number(low)?, number(high)?);
            if low <= high { Ok((low, high)) } else { Err(DistributionError::Reversed) }
        };
        let spread = |expression: &Expression| {
            let spread = number(expression)?;
            if spread >= 0.0 { Ok(spread) } else { Err(DistributionError::NegativeSpread) }
        };
        let positive = |expression: &Expression, name: &'static str| {
            let number = number(expression)?;
            if number > 0.0 { Ok(number) } else { Err(DistributionError::NotPositive(name)) }
        };
        Ok(match self {
            Self::Uniform { low, high } => {
                let (low, high) = ends(low, high)?;
                KnownDistribution::Uniform { low, high }
            }
            Self::Normal { mean, standard_deviation } => KnownDistribution::Normal {
                mean: number(mean)?,
                standard_deviation: spread(standard_deviation)?,
            },
            Self::TruncatedNormal { mean, standard_deviation, low, high } => {
                let (low, high) = ends(low, high)?;
                let (mean, standard_deviation) = (number(mean)?, spread(standard_deviation)?);
                KnownDistribution::TruncatedNormal { mean, standard_deviation, low, high }
            }
            Self::LogNormal { median, sigma } => {
                KnownDistribution::LogNormal { median: positive(median, "median")?, sigma: spread(sigma)? }
            }
            Self::Triangular { low, mode, high } => {
                let ((low, high), mode) = (ends(low, high)?, number(mode)?);
                if !(low..=high).contains(&mode) {
                    return Err(DistributionError::ModeOutside);
                }
                KnownDistribution::Triangular { low, mode, high }
            }
            Self::Beta { alpha, beta, low, high } => {
                let (low, high) = ends(low, high)?;
                let (alpha, beta) = (positive(alpha, "alpha")?, positive(beta, "beta")?);
                KnownDistribution::Beta { alpha, beta, low, high }
            }
            Self::Exponential { mean } => KnownDistribution::Exponential { mean: positive(mean, "mean")? },
            Self::Choice(options) => KnownDistribution::Choice(options),
            Self::Weighted { options, weights } => KnownDistribution::Weighted { options, weights },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_follow_what_they_depend_on() {
        let normal = Distribution::Normal {
            mean: Expression::Variable("pace".into()),
            standard_deviation: Expression::number(0.0),
        };
        assert_eq!(normal.variables(), ["pace"]);
        let at = |pace| normal.known(&BTreeMap::from([("pace".to_string(), Value::Number(pace))]));
        assert_eq!(at(2.0), Ok(KnownDistribution::Normal { mean: 2.0, standard_deviation: 0.0 }));
        let unbound = normal.known(&BTreeMap::new()).unwrap_err();
        assert_eq!(unbound, DistributionError::Evaluation(EvaluationError::Unbound("pace".into())));
    }

    #[test]
    fn what_nothing_can_be_drawn_from_says_why() {
        let nothing = BTreeMap::new();
        let reversed = Distribution::Uniform { low: 2.0.into(), high: 1.0.into() };
        assert_eq!(reversed.known(&nothing), Err(DistributionError::Reversed));
        let negative = Distribution::Normal { mean: 2.0.into(), standard_deviation: (-1.0).into() };
        assert_eq!(negative.known(&nothing), Err(DistributionError::NegativeSpread));
        let constant = Distribution::Uniform { low: 2.0.into(), high: 2.0.into() };
        assert!(constant.known(&nothing).is_ok());
    }
}
