//! One metric over a trial's runs in a few numbers.

use super::format::{quantity, share};
use crate::metrics::{Metric, MetricKind, Worst};
use crate::run::Outcome;

/// What a metric came to over several runs.
pub struct Digest<'a> {
    metric: &'a Metric,
    runs: usize,
    /// The values there are, sorted.
    values: Vec<f64>,
}

impl<'a> Digest<'a> {
    /// Of the metric at `index` of the outcomes.
    pub fn new(metric: &'a Metric, outcomes: &[Outcome], index: usize) -> Self {
        let mut values: Vec<f64> = outcomes.iter().filter_map(|outcome| outcome.metrics[index]).collect();
        values.sort_by(f64::total_cmp);
        Self { metric, runs: outcomes.len(), values }
    }

    /// Runs in which the metric does not exist.
    pub fn undefined(&self) -> usize {
        self.runs - self.values.len()
    }

    /// Everything in words: the value of one run, the range of several, the share of a flag.
    pub fn long(&self) -> String {
        let Some((low, high)) = self.range() else { return "undefined".to_string() };
        let show = |value| quantity(self.metric, Some(value));
        let defined = match self.undefined() {
            0 => String::new(),
            _ => format!(" in {} of {} runs", self.values.len(), self.runs),
        };
        match self.metric.kind {
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
        match self.metric.kind {
            MetricKind::Flag => share(self.holding() as f64 / self.values.len() as f64),
            MetricKind::Category(words) => self.words(words),
            MetricKind::Quantity(_) if low == high => number(low),
            MetricKind::Quantity(_) => {
                let worst = if self.metric.worst == Worst::Smallest { low } else { high };
                format!("{} ({})", number(self.mean()), number(worst))
            }
        }
    }

    /// The heading of a column of [`Self::short`]s: name, and unit with what the numbers are.
    pub fn heading(metric: &Metric, label: &str) -> (String, String) {
        let below = match metric.kind {
            MetricKind::Flag => "of runs".to_string(),
            MetricKind::Category(_) => "runs each".to_string(),
            MetricKind::Quantity(dimension) => {
                let worst = if metric.worst == Worst::Smallest { "min" } else { "max" };
                format!("{} mean ({worst})", dimension.si_unit()).trim_start().to_string()
            }
        };
        (label.to_string(), below)
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

    fn words(&self, words: &[&str]) -> String {
        let count = |index| self.values.iter().filter(|value| **value as usize == index).count();
        let counts = words.iter().enumerate().map(|(index, word)| (word, count(index)));
        let said = counts.filter(|(_, count)| *count > 0).map(|(word, count)| format!("{word} {count}"));
        said.collect::<Vec<_>>().join(", ")
    }
}

/// Three significant digits: cells are for comparing, not for calculating.
fn number(value: f64) -> String {
    crate::scenario::significant(value, 3)
}
