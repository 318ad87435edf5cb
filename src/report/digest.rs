//! One metric over a trial's runs in a few numbers.

use super::format::{in_notation, quantity, share};
use results::Outcome;
use scenario::{Criterion, Dimension, Metric, MetricKind, MetricReference, Notation, Text, Worst};

/// What a metric came to over several runs.
pub struct Digest<'a> {
    metric: &'a Metric,
    /// What quantities are shown in; `None` for the SI unit.
    unit: Option<Notation>,
    runs: usize,
    /// The values there are, sorted, in SI units.
    values: Vec<f64>,
}

impl<'a> Digest<'a> {
    /// Of the metric at `index` of the outcomes, to be shown in `unit` instead of the SI unit.
    pub fn new(metric: &'a Metric, unit: Option<Notation>, outcomes: &[Outcome], index: usize) -> Self {
        let mut values: Vec<f64> = outcomes.iter().filter_map(|outcome| outcome.metrics[index]).collect();
        values.sort_by(f64::total_cmp);
        Self { metric, unit, runs: outcomes.len(), values }
    }

    /// Runs in which the metric does not exist.
    pub fn undefined(&self) -> usize {
        self.runs - self.values.len()
    }

    /// Everything in words: the value of one run, the range of several, the share of a flag.
    pub fn long(&self) -> String {
        let Some((low, high)) = self.range() else { return "undefined".to_string() };
        let show = |value| match self.unit {
            Some(unit) => in_notation(value, unit),
            None => quantity(self.metric, Some(value)),
        };
        let defined = match self.undefined() {
            0 => String::new(),
            _ => format!(" in {} of {} runs", self.values.len(), self.runs),
        };
        match &self.metric.kind {
            _ if low == high => format!("{}{defined}", show(low)),
            MetricKind::Flag => format!("yes in {} of {} runs", self.holding(), self.runs),
            MetricKind::Category(words) => self.words(words),
            MetricKind::Quantity(_) => {
                format!("min {}, mean {}, max {}{defined}", show(low), show(self.mean()), show(high))
            }
        }
    }

    /// For a cell under a heading with [`Self::heading`]: `10 %`, `2.31 (1.05)`; `–` where there is no value.
    pub fn short(&self) -> String {
        let Some((low, high)) = self.range() else { return "–".to_string() };
        match &self.metric.kind {
            MetricKind::Flag => share(self.holding() as f64 / self.values.len() as f64),
            MetricKind::Category(words) => self.words(words),
            MetricKind::Quantity(_) if low == high => self.number(low),
            MetricKind::Quantity(_) => {
                let worst = if self.metric.worst == Worst::Smallest { low } else { high };
                format!("{} ({})", self.number(self.mean()), self.number(worst))
            }
        }
    }

    /// The heading of a column of [`Self::short`]s: name, and unit with what the numbers are.
    pub fn heading(metric: &Metric, label: &str, unit: Option<Notation>) -> (String, String) {
        let below = match &metric.kind {
            MetricKind::Flag => "of runs".to_string(),
            MetricKind::Category(_) => "runs each".to_string(),
            MetricKind::Quantity(dimension) => {
                let worst = if metric.worst == Worst::Smallest { "min" } else { "max" };
                let unit = unit.map_or_else(|| dimension.si_unit(), |unit| unit.symbol.to_string());
                format!("{unit} mean ({worst})").trim_start().to_string()
            }
        };
        (label.to_string(), below)
    }

    /// Three significant digits: cells are for comparing, not for calculating.
    fn number(&self, value: f64) -> String {
        scenario::significant(self.unit.map_or(value, |unit| unit.of_si(value)), 3)
    }

    fn range(&self) -> Option<(f64, f64)> {
        Some((*self.values.first()?, *self.values.last()?))
    }

    fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }

    fn holding(&self) -> usize {
        self.values.iter().filter(|value| **value != 0.0).count()
    }

    fn words(&self, words: &[Text]) -> String {
        let count = |index| self.values.iter().filter(|value| **value as usize == index).count();
        let counts = words.iter().enumerate().map(|(index, word)| (word, count(index)));
        let said = counts.filter(|(_, count)| *count > 0).map(|(word, count)| format!("{word} {count}"));
        said.collect::<Vec<_>>().join(", ")
    }
}

/// The unit that the first of the criteria about a metric is written in, if it is a quantity.
pub fn written_unit<'c>(
    criteria: impl IntoIterator<Item = &'c Criterion>,
    reference: &MetricReference,
    metric: &Metric,
) -> Option<Notation> {
    let MetricKind::Quantity(dimension) = metric.kind else { return None };
    let mut about = criteria.into_iter().filter(|criterion| criterion.claim.metric() == reference);
    about.find_map(|criterion| lang::unit_in(&criterion.text, dimension))
}

/// The unit that the first of the criteria is written in that is about a quantity of a dimension.
pub fn unit_for<'c>(
    criteria: impl IntoIterator<Item = &'c Criterion>,
    dimension: Dimension,
) -> Option<Notation> {
    let about = |criterion: &&Criterion| {
        criterion.claim.metric().known().is_some_and(|metric| metric.kind == MetricKind::Quantity(dimension))
    };
    criteria.into_iter().filter(about).find_map(|criterion| lang::unit_in(&criterion.text, dimension))
}
