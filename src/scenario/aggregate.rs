//! What sums up the runs of a trial in one number.

use serde::{Deserialize, Serialize};

use super::{Comparison, MetricReference};

/// One number for all runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Aggregate {
    /// The mean over runs.
    Mean(MetricReference),
    /// The median over runs.
    Median(MetricReference),
    /// The smallest value of any run.
    Min(MetricReference),
    /// The largest value of any run.
    Max(MetricReference),
    /// The standard deviation over runs.
    Std(MetricReference),
    /// The quantile at a level in 0..1.
    Quantile(f64, MetricReference),
    /// Share of runs in which the comparison holds.
    Rate(Comparison),
    /// Number of runs in which the comparison holds.
    Count(Comparison),
}

/// How scenarios call an aggregate, and what they give it.
#[derive(Debug, Clone, Copy)]
pub struct AggregateWord {
    /// Such as `mean` or `rate`.
    pub word: &'static str,
    /// One line.
    pub doc: &'static str,
    /// What stands in its parentheses.
    pub of: AggregateOf,
}

/// What an aggregate is made of.
#[derive(Debug, Clone, Copy)]
pub enum AggregateOf {
    /// `mean(pet)`
    Values(fn(MetricReference) -> Aggregate),
    /// `quantile(95 %, pet)`
    Level(fn(f64, MetricReference) -> Aggregate),
    /// `rate(pet < 1 s)`, with the largest that it can be.
    Runs(fn(Comparison) -> Aggregate, f64),
}

/// Every aggregate there is.
pub const AGGREGATES: [AggregateWord; 8] = {
    use AggregateOf::{Level, Runs, Values};
    const fn word(word: &'static str, of: AggregateOf, doc: &'static str) -> AggregateWord {
        AggregateWord { word, doc, of }
    }
    [
        word("mean", Values(Aggregate::Mean), "The mean over runs."),
        word("median", Values(Aggregate::Median), "The median over runs."),
        word("min", Values(Aggregate::Min), "The smallest of all runs."),
        word("max", Values(Aggregate::Max), "The largest of all runs."),
        word("std", Values(Aggregate::Std), "The standard deviation over runs."),
        word(
            "quantile",
            Level(Aggregate::Quantile),
            "`quantile(95 %, pet)`: what that share of runs stays below.",
        ),
        word("rate", Runs(Aggregate::Rate, 1.0), "The share of runs in which something holds."),
        word("count", Runs(Aggregate::Count, 1e9), "The number of runs in which something holds."),
    ]
};

impl AggregateWord {
    /// The aggregate of that word.
    pub fn find(word: &str) -> Option<&'static Self> {
        AGGREGATES.iter().find(|known| known.word == word)
    }
}

impl Aggregate {
    /// The metric that is aggregated.
    pub fn metric(&self) -> &MetricReference {
        match self {
            Self::Mean(metric)
            | Self::Median(metric)
            | Self::Min(metric)
            | Self::Max(metric)
            | Self::Std(metric)
            | Self::Quantile(_, metric) => metric,
            Self::Rate(comparison) | Self::Count(comparison) => &comparison.metric,
        }
    }

    /// As [`Self::metric`].
    pub fn metric_mut(&mut self) -> &mut MetricReference {
        match self {
            Self::Mean(metric)
            | Self::Median(metric)
            | Self::Min(metric)
            | Self::Max(metric)
            | Self::Std(metric)
            | Self::Quantile(_, metric) => metric,
            Self::Rate(comparison) | Self::Count(comparison) => &mut comparison.metric,
        }
    }

    /// The SI unit of its value; `%` for a rate, which is a share in 0..1, and nothing for plain numbers.
    pub fn unit(&self) -> String {
        match self {
            Self::Rate(_) => "%".to_string(),
            Self::Count(_) => String::new(),
            of_values => of_values.metric().unit(),
        }
    }
}
