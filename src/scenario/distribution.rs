//! What sampled variations draw from: distributions whose numbers may depend on other variations, and all that has to be known of
//! each.

use std::collections::BTreeMap;

use numbers::distributions::normal::Normal;
use numbers::summary::median_of;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{EvaluationError, Expression, Value};

/// A value with the words it was written in, which name the trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VariedValue {
    /// SI units.
    pub value: Value,
    /// Without spaces, such as `6s` or `30km/h`.
    pub label: String,
}

/// What a sampled variation is drawn from.
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
    /// One of these, all equally likely.
    Choice(Vec<VariedValue>),
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
    /// Numbers of one dimension: what each is, and the distribution of so many.
    Numbers(&'static [&'static str], fn(Vec<Expression>) -> Option<Distribution>),
    /// Any number of values of one kind.
    Values(fn(Vec<VariedValue>) -> Distribution),
}

/// Every distribution there is.
pub const DISTRIBUTIONS: [DistributionWord; 4] = {
    use DistributionOf::{Numbers, Values};
    const fn word(word: &'static str, of: DistributionOf) -> DistributionWord {
        DistributionWord { word, of }
    }
    [
        word(
            "uniform",
            Numbers(&["low", "high"], |numbers| {
                let [low, high] = numbers.try_into().ok()?;
                Some(Distribution::Uniform { low, high })
            }),
        ),
        word(
            "normal",
            Numbers(&["mean", "standard deviation"], |numbers| {
                let [mean, standard_deviation] = numbers.try_into().ok()?;
                Some(Distribution::Normal { mean, standard_deviation })
            }),
        ),
        word(
            "truncated_normal",
            Numbers(&["mean", "standard deviation", "low", "high"], |numbers| {
                let [mean, standard_deviation, low, high] = numbers.try_into().ok()?;
                Some(Distribution::TruncatedNormal { mean, standard_deviation, low, high })
            }),
        ),
        word("choice", Values(Distribution::Choice)),
    ]
};

impl DistributionWord {
    /// The distribution of that word.
    pub fn find(word: &str) -> Option<&'static Self> {
        DISTRIBUTIONS.iter().find(|known| known.word == word)
    }
}

/// A distribution with all of its numbers; a spread of 0 makes it a constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KnownDistribution<'a> {
    /// Any number between two equally likely.
    Uniform {
        /// The low end, SI units.
        low: f64,
        /// The high end, SI units, at least `low`.
        high: f64,
    },
    /// A normal distribution.
    Normal {
        /// SI units.
        mean: f64,
        /// SI units, at least 0.
        standard_deviation: f64,
    },
    /// A normal distribution without what lies outside of two ends.
    TruncatedNormal {
        /// Before it is cut, SI units.
        mean: f64,
        /// Before it is cut, SI units, at least 0.
        standard_deviation: f64,
        /// The low end, SI units.
        low: f64,
        /// The high end, SI units, at least `low`.
        high: f64,
    },
    /// One of these, all equally likely.
    Choice(&'a [VariedValue]),
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
}

impl DistributionError {
    /// What to do about it, where that is known.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Evaluation(_) => None,
            Self::Reversed => Some("write the smaller value first"),
            Self::NegativeSpread => Some("give a standard deviation of at least 0"),
        }
    }
}

/// A value of a distribution.
#[derive(Debug, Clone, PartialEq)]
pub enum DrawnValue<'a> {
    /// SI units.
    Number(f64),
    /// One of those that were listed.
    Listed(&'a VariedValue),
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
            Self::Choice(options) => {
                let index = (share * options.len() as f64) as usize;
                return DrawnValue::Listed(&options[index.min(options.len() - 1)]);
            }
        })
    }

    /// The number that stands for all of it, and what that is; `None` of what is no number.
    pub fn nominal(&self) -> Option<(f64, &'static str)> {
        match *self {
            Self::Uniform { low, high } => Some((low + (high - low) / 2.0, "the middle of its range")),
            Self::Normal { mean, .. } => Some((mean, "its mean")),
            Self::TruncatedNormal { mean, low, high, .. } => {
                Some((mean.clamp(low, high), "its most likely value"))
            }
            Self::Choice(options) => {
                let numbers: Option<Vec<f64>> = options.iter().map(|one| one.value.as_number()).collect();
                Some((median_of(&numbers?)?, "the middle of its values"))
            }
        }
    }
}

impl Distribution {
    /// The names that its numbers depend on.
    pub fn variables(&self) -> Vec<&str> {
        self.numbers().into_iter().flat_map(Expression::variables).collect()
    }

    fn numbers(&self) -> Vec<&Expression> {
        match self {
            Self::Uniform { low, high } => vec![low, high],
            Self::Normal { mean, standard_deviation } => vec![mean, standard_deviation],
            Self::TruncatedNormal { mean, standard_deviation, low, high } => {
                vec![mean, standard_deviation, low, high]
            }
            Self::Choice(_) => Vec::new(),
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
            Self::Choice(options) => KnownDistribution::Choice(options),
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
