//! What a run says of a metric, and what it counts as where that is no number: undefined, or cut off by the horizon.

use super::confidence::Bounds;
use crate::{Outcome, Requests};
use scenario::{Absence, Comparison, MetricKind, MetricReference, Relation, WhenUndefined, Worst};
use sim::measure::Open;

/// A metric in one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Seen {
    /// The metric's number, in its own unit.
    Value(f64),
    /// The metric does not exist in the run.
    Undefined,
    /// The horizon ended the run before it was decided; what it is so far, if that is anything, and what it could still
    /// have come to.
    Open {
        /// In the metric's own unit.
        so_far: Option<f64>,
        /// All that it could have come to.
        range: Open,
    },
}

impl Seen {
    /// The metric with this index in an outcome.
    pub fn of(outcome: &Outcome, index: usize) -> Self {
        let value = outcome.metrics[index];
        match (outcome.open(index), value) {
            (Some(range), so_far) => Self::Open { so_far, range },
            (None, Some(value)) => Self::Value(value),
            (None, None) => Self::Undefined,
        }
    }

    /// Whether there is a number.
    pub fn is_value(self) -> bool {
        matches!(self, Self::Value(_))
    }

    /// Whether the run ended before there could be one for certain.
    pub fn is_open(self) -> bool {
        matches!(self, Self::Open { .. })
    }

    /// Its value, if that is decided.
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Value(value) => Some(value),
            Self::Undefined | Self::Open { .. } => None,
        }
    }

    /// Its value, decided or not.
    pub fn so_far(self) -> Option<f64> {
        match self {
            Self::Value(value) => Some(value),
            Self::Open { so_far, .. } => so_far,
            Self::Undefined => None,
        }
    }

    /// Whether a comparison holds whatever would have come; `unknown` where that depends.
    pub fn holds(self, comparison: &Comparison, unknown: bool) -> bool {
        let (relation, bound) = (comparison.relation, comparison.constant_bound());
        match self {
            Self::Value(value) => relation.holds(value, bound),
            Self::Undefined => holds_undefined(comparison, unknown),
            Self::Open { so_far, range: Open { low, high } } => {
                let is_word = comparison
                    .metric
                    .known()
                    .is_some_and(|metric| matches!(metric.kind, MetricKind::Category(_)));
                let inside = low <= bound && bound <= high;
                let point = low == high && inside;
                let (always, sometimes) = match relation {
                    // That it is as it is so far is what such a claim is about: `passed_first = none`.
                    Relation::Equal | Relation::NotEqual if is_word && so_far == Some(bound) => {
                        (relation == Relation::Equal, relation == Relation::Equal)
                    }
                    Relation::Equal => (point, inside),
                    Relation::NotEqual => (!inside, !point),
                    _ => {
                        let (one, other) = (relation.holds(low, bound), relation.holds(high, bound));
                        (one && other, one || other)
                    }
                };
                always || (sometimes && unknown)
            }
        }
    }

    /// What it counts as for a claim that an aggregate of `metric` is in `relation` to a bound: of all that is possible
    /// what speaks most against it. `None`: it is left out, which no value could be worse than.
    pub fn worst(self, metric: &MetricReference, relation: Relation) -> Option<f64> {
        match self {
            Self::Value(value) => Some(value),
            Self::Open { range, .. } => match relation {
                Relation::Less | Relation::LessOrEqual => Some(range.high),
                Relation::Greater | Relation::GreaterOrEqual => Some(range.low),
                Relation::Equal | Relation::NotEqual => None,
            },
            Self::Undefined => {
                let value = extreme(metric)?;
                let against = match relation {
                    Relation::Less | Relation::LessOrEqual => value > 0.0,
                    Relation::Greater | Relation::GreaterOrEqual => value < 0.0,
                    Relation::Equal | Relation::NotEqual => false,
                };
                against.then_some(value)
            }
        }
    }

    /// Of all that is possible, what speaks most for such a claim; `None` where nothing bounds it.
    pub fn best(self, relation: Relation) -> Option<f64> {
        let best = match (self, relation) {
            (Self::Value(value), _) => value,
            (Self::Open { range, .. }, Relation::Less | Relation::LessOrEqual) => range.low,
            (Self::Open { range, .. }, Relation::Greater | Relation::GreaterOrEqual) => range.high,
            (Self::Open { .. } | Self::Undefined, _) => return None,
        };
        best.is_finite().then_some(best)
    }
}

/// Whether a comparison holds for a metric's value, which may not exist.
pub fn holds(comparison: &Comparison, value: Option<f64>) -> bool {
    value.map_or(Seen::Undefined, Seen::Value).holds(comparison, false)
}

/// Whether a comparison holds in a run in which its metric does not exist: as the criterion says or else the metric itself;
/// `unknown` where neither does.
pub fn holds_undefined(comparison: &Comparison, unknown: bool) -> bool {
    match comparison.when_undefined {
        WhenUndefined::Passes => true,
        WhenUndefined::Fails => false,
        WhenUndefined::AsDeclared => extreme(&comparison.metric)
            .map_or(unknown, |value| comparison.relation.holds(value, comparison.constant_bound())),
    }
}

/// The value that stands for a metric that does not exist: worse or better than any, of flags the worse or the better of the two.
/// `None` where neither is sure.
fn extreme(reference: &MetricReference) -> Option<f64> {
    let metric = reference.known()?;
    let is_flag = metric.kind == MetricKind::Flag;
    match (metric.absence, metric.worst) {
        (Absence::Bad, Worst::Largest) | (Absence::Good, Worst::Smallest) if is_flag => Some(1.0),
        (Absence::Bad, Worst::Smallest) | (Absence::Good, Worst::Largest) if is_flag => Some(0.0),
        (Absence::Open, _) | (_, Worst::Neither) => None,
        (Absence::Bad, Worst::Largest) | (Absence::Good, Worst::Smallest) => Some(f64::INFINITY),
        (Absence::Bad, Worst::Smallest) | (Absence::Good, Worst::Largest) => Some(f64::NEG_INFINITY),
    }
}

/// What a criterion is judged by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Evidence<'a> {
    pub outcomes: &'a [Outcome],
    pub requests: &'a Requests,
    pub bounds: Bounds<'a>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::known::measured;

    fn comparison(name: &str, relation: Relation, bound: f64, when_undefined: WhenUndefined) -> Comparison {
        let metric = measured(name);
        Comparison { metric, relation, bound: bound.into(), when_undefined }
    }

    fn open(low: f64, high: f64) -> Seen {
        Seen::Open { so_far: None, range: Open { low, high } }
    }

    #[test]
    fn what_is_undefined_is_what_the_metric_says() {
        let of = |name: &str, relation, unknown| {
            Seen::Undefined.holds(&comparison(name, relation, 1.5, WhenUndefined::AsDeclared), unknown)
        };
        for unknown in [false, true] {
            // Somebody never got to the end: worse than any value, in either direction.
            assert!(
                of("time_lost", Relation::Greater, unknown)
                    && !of("time_lost", Relation::LessOrEqual, unknown)
            );
            // There never was a danger: better than any.
            assert!(
                of("min_ttc", Relation::GreaterOrEqual, unknown) && !of("min_ttc", Relation::Less, unknown)
            );
            assert!(of("drac", Relation::LessOrEqual, unknown) && !of("drac", Relation::Greater, unknown));
            // Neither is sure.
            assert_eq!(of("pet", Relation::Less, unknown), unknown);
            assert_eq!(of("pet", Relation::GreaterOrEqual, unknown), unknown);
        }
        let said = |when| Seen::Undefined.holds(&comparison("time_lost", Relation::Less, 1.5, when), false);
        assert!(said(WhenUndefined::Passes) && !said(WhenUndefined::Fails));
    }

    #[test]
    fn what_was_cut_off_holds_where_nothing_that_could_come_says_otherwise() {
        let holds = |seen: Seen, relation, unknown| {
            seen.holds(&comparison("time_lost", relation, 10.0, WhenUndefined::AsDeclared), unknown)
        };
        let late = open(12.0, f64::INFINITY);
        let early = open(3.0, f64::INFINITY);
        for unknown in [false, true] {
            assert!(!holds(late, Relation::LessOrEqual, unknown) && holds(late, Relation::Greater, unknown));
            assert_eq!(holds(early, Relation::LessOrEqual, unknown), unknown);
            assert_eq!(holds(early, Relation::Greater, unknown), unknown);
        }
        // `undefined passes` is about what does not exist, not about what was not waited for.
        let generous = comparison("time_lost", Relation::Less, 10.0, WhenUndefined::Passes);
        assert!(!early.holds(&generous, false));
    }

    #[test]
    fn words_that_were_not_decided() {
        let so_far = Some(0.0);
        let nobody = Seen::Open { so_far, range: Open { low: 1.0, high: 2.0 } };
        let holds = |relation, word: f64| {
            nobody.holds(&comparison("passed_first", relation, word, WhenUndefined::AsDeclared), false)
        };
        assert!(holds(Relation::Equal, 0.0) && !holds(Relation::NotEqual, 0.0));
        assert!(!holds(Relation::Equal, 1.0) && !holds(Relation::NotEqual, 1.0));
        assert!(!holds(Relation::Equal, 2.0) && !holds(Relation::NotEqual, 2.0));
    }

    #[test]
    fn aggregates_count_what_speaks_against_them() {
        let (up, down) = (Relation::GreaterOrEqual, Relation::LessOrEqual);
        assert_eq!(open(3.0, f64::INFINITY).worst(&measured("time_lost"), down), Some(f64::INFINITY));
        assert_eq!(open(3.0, f64::INFINITY).worst(&measured("time_lost"), up), Some(3.0));
        assert_eq!(Seen::Undefined.worst(&measured("time_lost"), down), Some(f64::INFINITY));
        assert_eq!(Seen::Undefined.worst(&measured("time_lost"), up), None);
        // Leaving out runs without danger only makes what is left worse; where danger is asked for, they count.
        assert_eq!(Seen::Undefined.worst(&measured("min_ttc"), up), None);
        assert_eq!(Seen::Undefined.worst(&measured("min_ttc"), down), Some(f64::INFINITY));
        assert_eq!(Seen::Undefined.worst(&measured("drac"), up), Some(f64::NEG_INFINITY));
        assert_eq!(Seen::Undefined.worst(&measured("pet"), up), None);
        assert_eq!(open(3.0, f64::INFINITY).best(down), Some(3.0));
        assert_eq!(Seen::Undefined.best(down), None);
    }
}
