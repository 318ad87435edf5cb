//! What sums up the runs of a trial in one number, and all that has to be known of each such number.

use numbers::summary;
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

/// How an aggregate of values answers to them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AggregateResponse {
    /// It is one of them, or lies between two: where one grows it does not fall, and those that are infinite have a rank, too.
    Ranked,
    /// Where one grows it grows, and one that is infinite makes it so.
    Summed,
    /// It is at least 0, and which of the values that are possible make it largest nobody can say.
    Spread,
}

/// What bounds are known of an aggregate of all runs that there could be, by those that were made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AggregateBounds {
    /// Those of a mean.
    Mean,
    /// Those of the quantile at this level.
    Quantile(f64),
    /// Those of a share.
    Share,
    /// None.
    Unknown {
        /// Why not, as a sentence.
        why: &'static str,
        /// What to claim instead.
        instead: &'static str,
    },
}

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

    /// Of values from the least to the greatest; `None` where it does not exist, as of none or the spread of one.
    ///
    /// # Panics
    /// For rates and counts, which are of runs.
    pub fn of_sorted(&self, values: &[f64]) -> Option<f64> {
        match self {
            Self::Mean(_) => summary::mean(values),
            Self::Median(_) => summary::median(values),
            Self::Min(_) => values.first().copied(),
            Self::Max(_) => values.last().copied(),
            Self::Std(_) => summary::std(values),
            Self::Quantile(level, _) => summary::quantile(values, *level),
            Self::Rate(_) | Self::Count(_) => unreachable!("rates and counts are not aggregates of values"),
        }
    }

    /// How it answers to the values of runs; a rate or count to whether they hold.
    pub fn response(&self) -> AggregateResponse {
        match self {
            Self::Median(_) | Self::Min(_) | Self::Max(_) | Self::Quantile(..) => AggregateResponse::Ranked,
            Self::Mean(_) | Self::Rate(_) | Self::Count(_) => AggregateResponse::Summed,
            Self::Std(_) => AggregateResponse::Spread,
        }
    }

    /// Whether a single run can be enough to break a bound on it, which is a lower one if `upward`.
    pub fn is_broken_by_one(&self, upward: bool) -> bool {
        match self {
            Self::Min(_) => upward,
            Self::Max(_) => !upward,
            Self::Mean(_)
            | Self::Median(_)
            | Self::Std(_)
            | Self::Quantile(..)
            | Self::Rate(_)
            | Self::Count(_) => false,
        }
    }

    /// The bounds that are known of it.
    pub fn bounds(&self) -> AggregateBounds {
        let (why, instead) = match self {
            Self::Mean(_) => return AggregateBounds::Mean,
            Self::Median(_) => return AggregateBounds::Quantile(0.5),
            Self::Quantile(level, _) => return AggregateBounds::Quantile(*level),
            Self::Rate(_) => return AggregateBounds::Share,
            Self::Count(_) => (
                "a count is of the runs that were done, without confidence",
                "say something of all runs there could be: `rate(…)`",
            ),
            Self::Min(_) => (
                "runs do not tell how small a metric can get, at no confidence",
                "bound a small quantile instead: `quantile(5 %, …)`",
            ),
            Self::Max(_) => (
                "runs do not tell how large a metric can get, at no confidence",
                "bound a large quantile instead: `quantile(95 %, …)`",
            ),
            Self::Std(_) => (
                "runs do not tell how far a metric spreads, at no confidence: no bounds on a spread hold for every metric",
                "bound two quantiles instead: `quantile(5 %, …)` and `quantile(95 %, …)`",
            ),
        };
        AggregateBounds::Unknown { why, instead }
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
