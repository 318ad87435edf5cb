//! What `gate` blocks declare: by how much a metric may be worse than a baseline.

use serde::{Deserialize, Serialize};

use super::{MetricReference, Notation, Origin, Relation, WhenUndefined};

/// A comparison with a baseline that a change must survive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gate {
    /// As the suite calls it.
    pub name: String,
    /// What the suite says of it, in a sentence.
    pub doc: Option<String>,
    /// A path resolved against the file that names it.
    pub baseline: String,
    /// Whether it is judged while runs come in, too, and fails as soon as there is no doubt.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub sequential: bool,
    /// Never empty.
    pub rules: Vec<GateRule>,
    /// Where it is declared.
    pub origin: Origin,
}

/// By how much one metric may be worse.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GateRule {
    /// `None`: every quantity that the suite measures and no other rule of the gate names.
    pub metric: Option<MetricReference>,
    /// What of the metric is compared: the share of runs in which this holds. `None`: its value, or the share of runs with a yes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<GateRate>,
    /// How much worse is accepted.
    pub tolerance: Tolerance,
    /// Whether it shares its error with other primary rules alone, not with all comparisons of the gate.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub primary: bool,
    /// Confidence (0..1) with which it must be shown that the tolerance is kept.
    pub confidence: f64,
    /// In canonical words, such as `no metric worse by more than 5 % with 95 % confidence`.
    pub text: String,
    /// The unit that an absolute tolerance is written in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub notation: Option<Notation>,
    /// Where it is written.
    pub origin: Origin,
}

/// `rate(pet < 1.5 s)`: whether the metric of a run compares so.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GateRate {
    /// How the metric must compare to the bound.
    pub relation: Relation,
    /// SI units; flags compare to 0 and 1.
    pub bound: f64,
    /// What it says of a run in which the metric does not exist.
    pub when_undefined: WhenUndefined,
    /// Whether more runs in which it holds are worse.
    pub bad: bool,
    /// In canonical words, such as `rate(pet < 1.5 s)`.
    pub text: String,
}

/// How much worse is still acceptable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Tolerance {
    /// A share of the baseline's mean; of metrics that are true or false, and of rates, a difference of rates.
    Relative(f64),
    /// In the metric's SI unit.
    Absolute(f64),
    /// No run may have it that had not on the same seed; of metrics that are true or false only, and without statistics.
    NoneNew {
        /// Only in scenarios in which no run of the base has it.
        where_none_was: bool,
    },
}
