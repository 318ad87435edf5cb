//! What an evaluation measured.

use serde::{Deserialize, Serialize};

use super::cases::CaseRun;
use super::finding::Untested;
use numbers::inference::Interval;
use scenario::{Measure, Notation, Target, Value};

/// What an evaluation came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EvaluateResult {
    /// As the suite calls it.
    pub name: String,
    /// What the suite says of it.
    pub doc: Option<String>,
    /// Where the reported values come from.
    pub source: Option<String>,
    /// Labels of the metrics of every run, in their order.
    pub metrics: Vec<String>,
    /// The columns of its table.
    pub measures: Vec<Measure>,
    /// Number of cases in the set.
    pub cases: usize,
    /// Runs of every case under fresh seeds; 0: once, with the case's own seed.
    pub fresh: u32,
    /// In the order of declaration; the others are compared with the first.
    pub conditions: Vec<ConditionResult>,
}

/// Measures of a condition that are of runs in which nothing was at stake.
#[derive(Debug, Clone, PartialEq)]
pub struct UntestedMeasures {
    /// The condition.
    pub condition: String,
    /// In canonical words.
    pub measures: Vec<String>,
    /// Why.
    pub reason: Untested,
}

/// One condition over all the cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConditionResult {
    /// As the suite calls it.
    pub name: String,
    /// What this or another condition of the evaluation sets, with the value that it has in this one.
    pub parameters: Vec<ParameterValue>,
    /// Why it was not run, such as a tune that chose nothing; everything measured is then empty.
    pub missing: Option<String>,
    /// What has to be known of its parameters, such as that they keep no constraint everywhere.
    pub caveat: Option<String>,
    /// One per measure; `None` where no run has the metric, or runs without a value could make it as bad as anything.
    pub measured: Vec<Option<f64>>,
    /// One per measure: runs without a value that was decided before the horizon.
    pub undecided: Vec<usize>,
    /// What the source reports, one per measure, SI units.
    pub reported: Option<Vec<f64>>,
    /// From the first condition, one per measure; none in the first itself.
    pub differences: Vec<Option<Difference>>,
    /// In the order of the cases; with several fresh seeds, all of a case one after the other.
    pub runs: Vec<CaseRun>,
}

/// A parameter with its value under a condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterValue {
    /// What is set.
    pub target: Target,
    /// `None` if the cases do not agree on it, or none of them sets it.
    pub value: Option<Value>,
    /// Whether the cases do not agree on it.
    pub varies: bool,
    /// SI unit; empty for plain numbers and words.
    pub unit: String,
    /// The unit that conditions give it in, if that is another one: what people are shown.
    pub notation: Option<Notation>,
}

/// How much more there is of a measure than in the first condition, case by case.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// Of a mean or rate: the mean of the differences over the pairs. Otherwise what the two aggregates differ by.
    pub value: f64,
    /// At 95 %; `None` where there is none to be had: of extremes, quantiles and spreads, and of too few pairs.
    pub interval: Option<Interval>,
    /// Cases in which both conditions have the metric.
    pub pairs: usize,
}
