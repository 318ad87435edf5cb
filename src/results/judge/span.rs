//! Between which values an aggregate lies, whatever the runs that were cut off would have come to.

use super::criteria::{aggregate_against, aggregate_of};
use super::horizon::cut_off_of;
use super::seen::Seen;
use crate::Outcome;
use crate::Requests;
use scenario::{Aggregate, AggregateResponse, Comparison, MetricReference, Relation};
use scenario::{MetricKind, MetricRange, Worst};
use sim::measure::Open;

/// All values that something may have, both ends included; one where nothing is open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValueSpan {
    /// The smallest; negative infinity where nothing bounds it.
    pub low: f64,
    /// The largest; infinity where nothing bounds it.
    pub high: f64,
}

impl ValueSpan {
    /// Nothing is known.
    pub const ANYTHING: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// One value alone.
    pub fn point(value: f64) -> Self {
        Self { low: value, high: value }
    }

    /// From the least to the greatest; anything if one of them is no number.
    pub fn around(values: impl IntoIterator<Item = f64>) -> Self {
        let mut span = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };
        for value in values {
            if value.is_nan() {
                return Self::ANYTHING;
            }
            span = Self { low: span.low.min(value), high: span.high.max(value) };
        }
        span
    }

    /// Whether nothing is open.
    pub fn is_point(self) -> bool {
        self.low == self.high
    }

    /// Whether a value is one of them.
    pub fn contains(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// Whether it is in `relation` to `other` whatever the two are; `None` where that depends.
    pub fn holds(self, relation: Relation, other: Self) -> Option<bool> {
        match relation {
            Relation::Equal if self.is_point() && other.is_point() => Some(self.low == other.low),
            Relation::Equal => (self.high < other.low || other.high < self.low).then_some(false),
            Relation::NotEqual => self.holds(Relation::Equal, other).map(|equal| !equal),
            Relation::Less | Relation::LessOrEqual => {
                let (best, worst) =
                    (relation.holds(self.low, other.high), relation.holds(self.high, other.low));
                (best == worst).then_some(best)
            }
            Relation::Greater | Relation::GreaterOrEqual => {
                let (best, worst) =
                    (relation.holds(self.high, other.low), relation.holds(self.low, other.high));
                (best == worst).then_some(best)
            }
        }
    }
}

/// What a run may come to.
enum May {
    Be(ValueSpan),
    /// Or nothing at all.
    BeOrNot(ValueSpan),
    /// It has no value.
    NotBe,
}

/// In which runs the end of what a metric measures was not seen, or it was not decided.
pub fn open_runs<'o>(
    reference: &MetricReference,
    outcomes: impl IntoIterator<Item = &'o Outcome>,
    requests: &Requests,
) -> Vec<&'o Outcome> {
    let index = requests.index(reference);
    let is_open = |outcome: &&Outcome| {
        cut_off_of(reference, outcome) || index.is_some_and(|index| Seen::of(outcome, index).is_open())
    };
    outcomes.into_iter().filter(is_open).collect()
}

/// As [`aggregate_against`] for quantities, and as a comparison says for rates and counts, but with every run that was cut off as
/// the least and the greatest that it could still have come to. `None` where it does not exist.
///
/// A spread, for which nobody can say what is least and greatest, may be anything from 0 on.
pub fn span_of(
    wanted: &Aggregate,
    counting: Relation,
    outcomes: &[Outcome],
    requests: &Requests,
) -> Option<ValueSpan> {
    let reference = wanted.metric();
    match wanted {
        Aggregate::Rate(comparison) if !outcomes.is_empty() => {
            let ValueSpan { low, high } = holding(comparison, outcomes, requests);
            let all = outcomes.len() as f64;
            Some(ValueSpan { low: low / all, high: high / all })
        }
        Aggregate::Rate(_) => None,
        Aggregate::Count(comparison) => Some(holding(comparison, outcomes, requests)),
        _ if open_runs(reference, outcomes, requests).is_empty() => {
            aggregate_against(wanted, counting, outcomes, requests).map(ValueSpan::point)
        }
        spread if spread.response() == AggregateResponse::Spread => {
            Some(ValueSpan { low: 0.0, high: f64::INFINITY })
        }
        of_values => of_quantity(of_values, counting, outcomes, requests),
    }
}

fn of_quantity(
    wanted: &Aggregate,
    counting: Relation,
    outcomes: &[Outcome],
    requests: &Requests,
) -> Option<ValueSpan> {
    let reference = wanted.metric();
    let index = requests.index(reference)?;
    let (mut sure, mut maybe) = (Vec::new(), Vec::new());
    for outcome in outcomes {
        match may_be(reference, outcome, index) {
            May::Be(span) => sure.push(span),
            May::BeOrNot(span) => maybe.push(span),
            May::NotBe => sure.extend(Seen::Undefined.worst(reference, counting).map(ValueSpan::point)),
        }
    }
    // Those that may be nothing may all be the same: with none or with all of them it is least and greatest.
    let every = |end: fn(&ValueSpan) -> f64| {
        let some = aggregate_of(wanted, sure.iter().map(end).collect());
        let all = aggregate_of(wanted, sure.iter().chain(&maybe).map(end).collect());
        [some, all]
    };
    let ends = [every(|span| span.low), every(|span| span.high)].concat();
    if ends.iter().all(Option::is_none) {
        return None;
    }
    // Whether there is a value at all depends.
    let known: Option<Vec<f64>> = ends.into_iter().collect();
    let span = known.map_or(ValueSpan::ANYTHING, ValueSpan::around);
    (span.low.is_finite() || span.low != span.high).then_some(span)
}

/// In how many runs a comparison holds.
fn holding(comparison: &Comparison, outcomes: &[Outcome], requests: &Requests) -> ValueSpan {
    let reference = &comparison.metric;
    let index = requests.index(reference).expect("what is measured was requested before the runs");
    let (mut low, mut high) = (0, 0);
    for outcome in outcomes {
        let seen = Seen::of(outcome, index);
        let open = |ValueSpan { low, high }| Seen::Open { so_far: seen.so_far(), range: Open { low, high } };
        let holds = |seen: Seen| (seen.holds(comparison, false), seen.holds(comparison, true));
        let absent = Seen::Undefined.holds(comparison, false);
        let (always, sometimes) = match may_be(reference, outcome, index) {
            May::Be(span) if cut_off_of(reference, outcome) || seen.is_open() => holds(open(span)),
            May::Be(_) => (seen.holds(comparison, false), seen.holds(comparison, false)),
            May::BeOrNot(span) => {
                let (always, sometimes) = holds(open(span));
                (always && absent, sometimes || absent)
            }
            May::NotBe => (absent, absent),
        };
        low += usize::from(always);
        high += usize::from(sometimes);
    }
    ValueSpan { low: low as f64, high: high as f64 }
}

/// What was seen so far of a run whose end was not seen gets worse or stays as it is; a mean over the run may go either way.
fn may_be(reference: &MetricReference, outcome: &Outcome, index: usize) -> May {
    let seen = Seen::of(outcome, index);
    let is_cut_off = cut_off_of(reference, outcome);
    let limits = limits(reference);
    match seen {
        Seen::Open { range: Open { low, high }, .. } => May::Be(ValueSpan { low, high }),
        Seen::Value(value) if !is_cut_off => May::Be(ValueSpan::point(value)),
        Seen::Value(_) if is_either_way(reference) => May::Be(limits),
        Seen::Value(value) => match reference.known().map(|metric| metric.worst) {
            Some(Worst::Smallest) => May::Be(ValueSpan { low: limits.low.min(value), high: value }),
            _ => May::Be(ValueSpan { low: value, high: limits.high.max(value) }),
        },
        Seen::Undefined if is_cut_off => May::BeOrNot(limits),
        Seen::Undefined => May::NotBe,
    }
}

fn is_either_way(reference: &MetricReference) -> bool {
    let is_word = reference.known().is_some_and(|metric| matches!(metric.kind, MetricKind::Category(_)));
    is_word || reference.name() == "rms_jerk"
}

/// However long a run would have been.
fn limits(reference: &MetricReference) -> ValueSpan {
    let metric = reference.known();
    let (low, high) = metric
        .and_then(|metric| metric.limits(&reference.settings, f64::INFINITY))
        .unwrap_or_else(|| match metric.map(|metric| (&metric.range, &metric.kind)) {
            Some((_, MetricKind::Category(words))) => (0.0, words.len() as f64 - 1.0),
            Some((MetricRange::NotNegative, _)) => (0.0, f64::INFINITY),
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        });
    ValueSpan { low, high }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use proptest::prelude::*;

    use super::*;
    use crate::{CutOff, Unfinished};
    use scenario::WhenUndefined;
    use sim::{Ending, StopReason};

    /// What a run came to, and what it would have come to had it not been cut off.
    #[derive(Debug, Clone, Copy)]
    struct Run {
        truth: Option<f64>,
        so_far: Option<f64>,
        is_cut_off: bool,
    }

    fn outcome(run: &Run, metric: &str) -> Outcome {
        let pair = Unfinished { vehicle: "av".into(), pedestrian: "walker".into() };
        // A time is open by itself; an extreme is what was seen so far of an encounter that is not over.
        let is_time = metric == "time_lost";
        let open = (run.is_cut_off && is_time).then(|| Open::at_least(run.so_far.unwrap_or(0.0)));
        let cut_off = CutOff {
            open: [open].into_iter().collect(),
            unfinished: if is_time { Vec::new() } else { vec![pair] },
            ..CutOff::default()
        };
        Outcome {
            key: String::new(),
            seed: 1,
            individuals: Vec::new(),
            drawn: Vec::new(),
            ending: Ending { reason: StopReason::Horizon, time: 24.0 },
            metrics: vec![if open.is_some() { None } else { run.so_far }],
            critical: Default::default(),
            presences: Vec::new(),
            waiting_steps: Vec::new(),
            left_road: Vec::new(),
            outlasted: Vec::new(),
            cut_off: run.is_cut_off.then(|| Box::new(cut_off)),
            fingerprint: 0,
            wall_time: Duration::ZERO,
        }
    }

    fn reference(name: &str) -> MetricReference {
        models::known::measured(name)
    }

    const METRICS: [&str; 4] = ["time_lost", "min_distance", "drac", "rms_jerk"];

    /// A run of one of [`METRICS`]; danger may arise after all, a distance exists from the beginning.
    fn run(metric: usize) -> impl Strategy<Value = Run> {
        (0.0..9.0f64, 0.0..9.0f64, any::<bool>(), any::<bool>(), any::<bool>()).prop_map(
            move |(one, other, is_cut_off, was_seen, comes)| {
                let (low, high) = (one.min(other), one.max(other));
                let (truth, so_far) = match metric {
                    0 => (Some(high), Some(low)),
                    1 => (Some(low), Some(high)),
                    2 if was_seen => (Some(high), Some(low)),
                    2 => (comes.then_some(high), None),
                    _ => (Some(one), Some(other)),
                };
                if is_cut_off {
                    Run { truth, so_far, is_cut_off }
                } else {
                    Run { truth, so_far: truth, is_cut_off }
                }
            },
        )
    }

    fn aggregates(name: &str, relation: Relation, bound: f64) -> Vec<Aggregate> {
        let metric = || reference(name);
        let comparison = || Comparison {
            metric: metric(),
            relation,
            bound: bound.into(),
            when_undefined: WhenUndefined::AsDeclared,
        };
        vec![
            Aggregate::Mean(metric()),
            Aggregate::Median(metric()),
            Aggregate::Quantile(0.8, metric()),
            Aggregate::Min(metric()),
            Aggregate::Max(metric()),
            Aggregate::Std(metric()),
            Aggregate::Rate(comparison()),
            Aggregate::Count(comparison()),
        ]
    }

    proptest! {
        #[test]
        fn the_truth_lies_within(
            (metric, runs) in (0usize..4).prop_flat_map(|metric| (Just(metric), prop::collection::vec(run(metric), 1..9))),
            bound in 0.0..9.0f64, is_above: bool, up: bool,
        ) {
            let name = METRICS[metric];
            let relation = if is_above { Relation::GreaterOrEqual } else { Relation::Less };
            let counting = if up { Relation::GreaterOrEqual } else { Relation::LessOrEqual };
            let mut requests = Requests::default();
            requests.add(&reference(name));
            let seen: Vec<_> = runs.iter().map(|run| outcome(run, name)).collect();
            let whole = |run: &Run| outcome(&Run { so_far: run.truth, is_cut_off: false, ..*run }, name);
            let whole: Vec<_> = runs.iter().map(whole).collect();
            for aggregate in aggregates(name, relation, bound) {
                let span = span_of(&aggregate, counting, &seen, &requests);
                let truth = span_of(&aggregate, counting, &whole, &requests);
                if let (Some(span), Some(truth)) = (span, truth) {
                    prop_assert!(truth.is_point());
                    let ValueSpan { low, high } = span;
                    prop_assert!(low - 1e-9 <= truth.low && truth.low <= high + 1e-9, "{aggregate:?}: {truth:?} not in {span:?}");
                }
                if runs.iter().all(|run| !run.is_cut_off) {
                    prop_assert_eq!(span, truth);
                }
            }
        }
    }

    #[test]
    fn it_is_as_wide_as_what_is_open_and_no_wider() {
        let mut requests = Requests::default();
        requests.add(&reference("min_distance"));
        let run = |so_far, is_cut_off| {
            outcome(&Run { truth: None, so_far: Some(so_far), is_cut_off }, "min_distance")
        };
        let outcomes = [run(4.0, true), run(2.0, false), run(6.0, false)];
        let of = |aggregate: Aggregate| span_of(&aggregate, Relation::GreaterOrEqual, &outcomes, &requests);
        let [mean, median, _, min, max, std, rate, count] =
            aggregates("min_distance", Relation::GreaterOrEqual, 3.0).try_into().unwrap();
        let span = |low: f64, high: f64| Some(ValueSpan { low, high });
        assert_eq!(of(mean), span(8.0 / 3.0, 4.0));
        assert_eq!(of(median), span(2.0, 4.0));
        assert_eq!(of(min), span(0.0, 2.0));
        assert_eq!(of(max), span(6.0, 6.0));
        assert_eq!(of(std), span(0.0, f64::INFINITY));
        assert_eq!(of(rate), span(1.0 / 3.0, 2.0 / 3.0));
        assert_eq!(of(count), span(1.0, 2.0));
    }

    #[test]
    fn comparisons_of_what_is_open() {
        let (one, other) = (ValueSpan { low: 1.0, high: 2.0 }, ValueSpan::point(2.0));
        assert_eq!(one.holds(Relation::LessOrEqual, other), Some(true));
        assert_eq!(one.holds(Relation::Less, other), None);
        assert_eq!(one.holds(Relation::Greater, other), Some(false));
        assert_eq!(one.holds(Relation::GreaterOrEqual, other), None);
        assert_eq!(one.holds(Relation::Equal, other), None);
        assert_eq!(one.holds(Relation::NotEqual, ValueSpan::point(3.0)), Some(true));
        assert_eq!(other.holds(Relation::Equal, other), Some(true));
    }
}
