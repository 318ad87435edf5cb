//! What two runs came to: how both stand to each criterion, and every metric.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::sides::RunDiff;
use crate::format::{quantity, with_unit};
use crate::replay::RunReason;
use scenario::{Criterion, Metric, MetricKind, MetricReference};

/// So many metrics that changed are told with their values.
const METRICS: usize = 10;

/// How both stand to a criterion, each in words; `None` where it is not asked of one of the two.
pub struct CriterionInBoth {
    pub criterion: String,
    pub a: Option<String>,
    pub b: Option<String>,
    /// Whether one has what the criterion wants of it and the other has not.
    pub flips: bool,
}

impl CriterionInBoth {
    /// Whether something of it is otherwise in the one than in the other.
    pub fn changed(&self) -> bool {
        self.a != self.b
    }

    fn in_words(&self) -> String {
        let criterion = &self.criterion;
        match (&self.a, &self.b) {
            (Some(a), Some(b)) if a == b => format!("`{criterion}`: each {a}"),
            (Some(a), Some(b)) => format!("`{criterion}`: A {a}; B {b}"),
            (Some(a), None) => format!("`{criterion}`: A {a}; not asked of B"),
            (None, Some(b)) => format!("`{criterion}`: not asked of A; B {b}"),
            (None, None) => format!("`{criterion}`: asked of neither"),
        }
    }
}

/// How both stand to each criterion, those that changed first. A claim for each member of a group may be told in the same words, and is told once.
pub fn criteria([a, b]: &[Vec<RunReason>; 2]) -> Vec<CriterionInBoth> {
    let find = |all: &[RunReason], text: &str| all.iter().position(|one| one.criterion == text);
    let words = |one: &RunReason| format!("{}, {}", one.verb, one.words);
    let of_a = a.iter().map(|one| {
        let other = find(b, &one.criterion).map(|place| &b[place]);
        CriterionInBoth {
            criterion: one.criterion.clone(),
            a: Some(words(one)),
            b: other.map(words),
            flips: other.is_some_and(|other| one.fulfils() != other.fulfils()),
        }
    });
    let only_b = b.iter().filter(|one| find(a, &one.criterion).is_none()).map(|one| CriterionInBoth {
        criterion: one.criterion.clone(),
        a: None,
        b: Some(words(one)),
        flips: false,
    });
    let mut all: Vec<CriterionInBoth> = of_a.chain(only_b).collect();
    all.sort_by_key(|one| !one.changed());
    let mut told = BTreeSet::new();
    all.retain(|one| told.insert(one.in_words()));
    all
}

/// The same in words, a line each.
pub fn criteria_lines(reasons: &[Vec<RunReason>; 2]) -> Vec<String> {
    criteria(reasons).iter().map(CriterionInBoth::in_words).collect()
}

/// A metric with its value in both, and how it changed.
pub struct MetricPair<'a> {
    pub reference: &'a MetricReference,
    pub metric: &'a Metric,
    pub values: [Option<f64>; 2],
    /// Whether each is decided, or was cut off.
    pub decided: [bool; 2],
}

impl MetricPair<'_> {
    pub fn shown(&self) -> [String; 2] {
        [0, 1].map(|side| {
            let so_far = if self.decided[side] { "" } else { " so far" };
            format!("{}{so_far}", quantity(self.metric, self.values[side]))
        })
    }

    pub fn is_same(&self) -> bool {
        self.values.map(|value| value.map(f64::to_bits)).windows(2).all(|both| both[0] == both[1])
    }

    fn change(&self) -> Option<f64> {
        let [Some(a), Some(b)] = self.values else { return None };
        let is_number = matches!(self.metric.kind, MetricKind::Quantity(_));
        (is_number && a.is_finite() && b.is_finite()).then_some(b - a)
    }

    /// By how much it is more or less in B, if it is a quantity that both have.
    pub fn change_words(&self) -> Option<String> {
        let (change, MetricKind::Quantity(dimension)) = (self.change()?, &self.metric.kind) else {
            return None;
        };
        let sign = if change > 0.0 { "+" } else { "" };
        Some(format!("{sign}{}", with_unit(change, *dimension)))
    }
}

pub fn metric_pairs<'a>(run: &'a RunDiff) -> Vec<MetricPair<'a>> {
    let outcomes = run.outcomes();
    let pair = |(index, reference): (usize, &'a MetricReference)| {
        let values = outcomes.map(|outcome| outcome.metrics[index]);
        let decided = outcomes.map(|outcome| outcome.open(index).is_none());
        Some(MetricPair { reference, metric: reference.known()?, values, decided })
    };
    run.requests.iter().enumerate().filter_map(pair).collect()
}

/// Every metric that changed, those of criteria first, and how many did not.
pub fn metrics(run: &RunDiff) -> Vec<String> {
    let criteria: Vec<&Criterion> = run.sides.iter().flat_map(|side| side.criteria).collect();
    metric_lines(&metric_pairs(run), &criteria)
}

pub fn metric_lines(pairs: &[MetricPair], criteria: &[&Criterion]) -> Vec<String> {
    let asked = |pair: &MetricPair| criteria.iter().any(|one| one.claim.metric().is_same(pair.reference));
    let mut changed: Vec<&MetricPair> =
        pairs.iter().filter(|pair| pair.shown()[0] != pair.shown()[1]).collect();
    changed.sort_by_key(|pair| !asked(pair));
    let in_bits = pairs.iter().filter(|pair| !pair.is_same()).count().saturating_sub(changed.len());
    let width = changed.iter().take(METRICS).map(|pair| pair.reference.label().chars().count()).max();
    let width = width.unwrap_or(0);
    let told = |pair: &&MetricPair| {
        let [a, b] = pair.shown();
        let mut said = format!("{:<width$}  {a} -> {b}", pair.reference.label());
        if let Some(change) = pair.change_words() {
            write!(said, " ({change})").expect("writing to a string cannot fail");
        }
        said
    };
    let mut said: Vec<String> = changed.iter().take(METRICS).map(told).collect();
    if changed.len() > METRICS {
        let more: Vec<String> = changed[METRICS..].iter().map(|pair| pair.reference.label()).collect();
        said.push(format!("changed as well: {}; `--json` has them", more.join(", ")));
    }
    let (all, rest) = (pairs.len(), pairs.len() - changed.len());
    let but = if in_bits > 0 { format!(", {in_bits} of them but for bits") } else { String::new() };
    said.push(match changed.len() {
        0 => format!("all {all} metrics are the same in both{but}"),
        _ => format!("the other {rest} of {all} metrics are the same in both{but}"),
    });
    said
}
