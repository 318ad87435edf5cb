//! Traffic: vehicles of one lane that arrive one after the other.

use std::collections::BTreeMap;

use numbers::random::Stream as RandomStream;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{
    Distribution, DistributionError, DrawnValue, EvaluationError, Expression, KnownDistribution, Value,
};

/// The vehicles of a stream in one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrafficStream {
    /// As the scenario calls it.
    pub name: String,
    /// Indices into [`World::vehicles`](crate::World::vehicles), in the order in which they arrive; at least 1. All drive on one lane.
    pub vehicles: Vec<usize>,
    /// When the centre of each would be at the middle of the crossing if it kept its cruise, s: one for each vehicle, rising.
    pub arrivals: Vec<f64>,
}

impl TrafficStream {
    /// More vehicles than this are taken for a mistake.
    pub const MOST: usize = 200;

    /// What the member with this index from 0 is called: `cars_1` is the first of `cars`.
    pub fn member_name(name: &str, index: usize) -> String {
        format!("{name}_{}", index + 1)
    }

    /// The name of the stream and the index from 0 of what may be called so as one of its members.
    pub fn of_member(name: &str) -> Option<(&str, usize)> {
        let (stream, number) = name.rsplit_once('_')?;
        let is_number = !number.starts_with('0') && number.bytes().all(|byte| byte.is_ascii_digit());
        let index = number.parse::<usize>().ok().filter(|_| is_number)?.checked_sub(1)?;
        (index < Self::MOST && !stream.is_empty()).then_some((stream, index))
    }
}

/// When the vehicles of a stream arrive, as it is declared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeclaredStream {
    /// Time to arrival of the first vehicle's centre at the middle of the crossing at time 0, s.
    pub first: Expression,
    /// From the front of one vehicle to that of the next in order, s.
    pub gaps: Vec<Expression>,
    /// What comes after those gaps.
    pub then: FurtherGaps,
}

/// The gaps of a stream after those that are listed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FurtherGaps {
    /// None: the stream ends.
    #[default]
    None,
    /// All alike, s.
    Alike(Expression),
    /// Drawn one by one in every run.
    Drawn {
        /// Of gaps, s.
        distribution: Distribution,
        /// A number between 0 and 1 that is drawn in every run: the gaps follow from it.
        chance: Expression,
    },
}

/// Why a stream cannot be what it is declared to be.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StreamError {
    /// A number of it has no value.
    #[error("{0}")]
    Evaluation(#[from] EvaluationError),
    /// Gaps cannot be drawn.
    #[error("{0}")]
    Distribution(#[from] DistributionError),
    /// A gap that is none.
    #[error("gap {number} is {gap} s, and a gap is longer than 0 s")]
    Gap {
        /// Counted from 1.
        number: usize,
        /// s
        gap: f64,
    },
    /// There would be more vehicles than a stream may have.
    #[error("more than {} vehicles arrive within {within} s", TrafficStream::MOST)]
    TooMany {
        /// s
        within: f64,
    },
}

impl DeclaredStream {
    /// When each vehicle arrives (s) where variations and draws have these values: up to the first that does after `until` (s), by which it is
    /// known which gap is open then.
    ///
    /// # Errors
    /// A number without a value, a gap that is not above 0, or more than [`TrafficStream::MOST`] vehicles.
    pub fn arrivals(&self, variables: &BTreeMap<String, Value>, until: f64) -> Result<Vec<f64>, StreamError> {
        let mut further = Further::of(&self.then, variables)?;
        let mut last = self.first.evaluate_number(variables)?;
        let mut arrivals = vec![last];
        while last <= until {
            let number = arrivals.len();
            let gap = match self.gaps.get(number - 1) {
                Some(listed) => listed.evaluate_number(variables)?,
                None => match further.next()? {
                    Some(gap) => gap,
                    None => break,
                },
            };
            if gap.is_nan() || gap <= 0.0 {
                return Err(StreamError::Gap { number, gap });
            }
            if number == TrafficStream::MOST {
                return Err(StreamError::TooMany { within: until });
            }
            last += gap;
            arrivals.push(last);
        }
        Ok(arrivals)
    }

    /// The same with the gaps of a run listed, as [`Self::arrivals`] has them.
    ///
    /// # Errors
    /// As [`Self::arrivals`].
    pub fn with_drawn_gaps(
        &self,
        variables: &BTreeMap<String, Value>,
        until: f64,
    ) -> Result<Self, StreamError> {
        if !matches!(self.then, FurtherGaps::Drawn { .. }) {
            return Ok(self.clone());
        }
        let mut further = Further::of(&self.then, variables)?;
        let count = self.arrivals(variables, until)?.len() - 1;
        let mut gaps = self.gaps.clone();
        while gaps.len() < count {
            gaps.extend(further.next()?.map(Expression::number));
        }
        Ok(Self { first: self.first.clone(), gaps, then: FurtherGaps::None })
    }
}

/// The gaps after those that are listed, one after the other.
enum Further<'a> {
    None,
    Alike(f64),
    Drawn(KnownDistribution<'a>, Box<RandomStream>),
}

impl<'a> Further<'a> {
    fn of(gaps: &'a FurtherGaps, variables: &BTreeMap<String, Value>) -> Result<Self, StreamError> {
        Ok(match gaps {
            FurtherGaps::None => Self::None,
            FurtherGaps::Alike(gap) => Self::Alike(gap.evaluate_number(variables)?),
            FurtherGaps::Drawn { distribution, chance } => {
                let seed = chance.evaluate_number(variables)?.to_bits();
                Self::Drawn(distribution.known(variables)?, Box::new(RandomStream::seeded(seed)))
            }
        })
    }

    fn next(&mut self) -> Result<Option<f64>, StreamError> {
        Ok(match self {
            Self::None => None,
            Self::Alike(gap) => Some(*gap),
            Self::Drawn(distribution, stream) => Some(match distribution.quantile(stream.uniform()) {
                DrawnValue::Number(gap) => gap,
                DrawnValue::Listed(listed) => match &listed.value {
                    Value::Number(gap) => *gap,
                    other => return Err(EvaluationError::NotANumber(other.to_string()).into()),
                },
            }),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VariedValue;

    fn stream(first: f64, gaps: &[f64], then: FurtherGaps) -> DeclaredStream {
        let gaps = gaps.iter().map(|gap| Expression::number(*gap)).collect();
        DeclaredStream { first: Expression::number(first), gaps, then }
    }

    fn drawn(distribution: Distribution) -> FurtherGaps {
        FurtherGaps::Drawn { distribution, chance: Expression::Variable("cars.gaps".into()) }
    }

    fn chance(share: f64) -> BTreeMap<String, Value> {
        BTreeMap::from([("cars.gaps".to_string(), Value::Number(share))])
    }

    #[test]
    fn gaps_follow_each_other_until_the_first_vehicle_after_the_end() {
        let none = BTreeMap::new();
        let ends = stream(2.0, &[3.0, 4.0], FurtherGaps::None);
        assert_eq!(ends.arrivals(&none, 60.0).unwrap(), [2.0, 5.0, 9.0]);
        assert_eq!(ends.arrivals(&none, 5.0).unwrap(), [2.0, 5.0, 9.0]);
        assert_eq!(ends.arrivals(&none, 4.9).unwrap(), [2.0, 5.0]);
        let endless = stream(2.0, &[3.0], FurtherGaps::Alike(Expression::number(2.5)));
        assert_eq!(endless.arrivals(&none, 10.0).unwrap(), [2.0, 5.0, 7.5, 10.0, 12.5]);
    }

    #[test]
    fn a_longer_run_has_the_same_gaps_and_more_of_them() {
        let gaps =
            drawn(Distribution::Uniform { low: Expression::number(2.0), high: Expression::number(6.0) });
        let cars = stream(1.0, &[3.0], gaps);
        let short = cars.arrivals(&chance(0.3), 20.0).unwrap();
        let long = cars.arrivals(&chance(0.3), 200.0).unwrap();
        assert_eq!(long[..short.len()], short);
        assert!(long.len() > 40 && long[1] == 4.0);
        assert!(long.windows(2).skip(1).all(|pair| (2.0..6.0).contains(&(pair[1] - pair[0]))));
        assert_ne!(cars.arrivals(&chance(0.31), 20.0).unwrap(), short);
        let listed = cars.with_drawn_gaps(&chance(0.3), 20.0).unwrap();
        assert_eq!(listed.arrivals(&BTreeMap::new(), 20.0).unwrap(), short);
    }

    #[test]
    fn drawn_gaps_are_as_likely_as_they_are_said_to_be() {
        let option = |gap: f64| VariedValue { value: Value::Number(gap), label: format!("{gap}s") };
        let options = vec![option(2.0), option(4.0)];
        let gaps = drawn(Distribution::Weighted { options, weights: vec![3.0, 1.0] });
        let cars = stream(0.0, &[], gaps);
        let mut short = 0;
        let mut all = 0;
        for run in 0..400 {
            let arrivals = cars.arrivals(&chance((run as f64 + 0.5) / 400.0), 100.0).unwrap();
            let first = arrivals.windows(2).take(25).map(|pair| pair[1] - pair[0]);
            all += 25;
            short += first.filter(|gap| (gap - 2.0).abs() < 1e-9).count();
        }
        // Three standard errors of 10,000 gaps.
        assert!((short as f64 / f64::from(all) - 0.75).abs() < 0.013, "{short} of {all}");
    }

    #[test]
    fn gaps_that_are_none_and_too_many_vehicles_are_refused() {
        let none = BTreeMap::new();
        let message = |stream: DeclaredStream, until| stream.arrivals(&none, until).unwrap_err().to_string();
        assert_eq!(
            message(stream(2.0, &[3.0, 0.0], FurtherGaps::None), 60.0),
            "gap 2 is 0 s, and a gap is longer than 0 s"
        );
        let alike = |gap| FurtherGaps::Alike(Expression::number(gap));
        assert_eq!(
            message(stream(2.0, &[], alike(-1.0)), 60.0),
            "gap 1 is -1 s, and a gap is longer than 0 s"
        );
        assert_eq!(
            message(stream(0.0, &[], alike(1.0)), 1000.0),
            "more than 200 vehicles arrive within 1000 s"
        );
        assert_eq!(stream(0.0, &[], alike(1.0)).arrivals(&none, 198.5).unwrap().len(), 200);
    }

    #[test]
    fn members_have_the_name_of_their_stream_and_a_number() {
        assert_eq!(TrafficStream::member_name("cars", 0), "cars_1");
        assert_eq!(TrafficStream::of_member("far_cars_12"), Some(("far_cars", 11)));
        for none in [
            "cars", "cars_0", "cars_01", "cars_201", "cars_", "cars_-1", "cars_+1", "cars_x", "_1", "cars_1b",
        ] {
            assert_eq!(TrafficStream::of_member(none), None, "{none}");
        }
    }
}
