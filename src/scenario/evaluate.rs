//! What `evaluate` blocks declare: parameter sets compared on the same cases.

use serde::{Deserialize, Serialize};

use super::{Aggregate, CaseSet, Notation, Origin, Target, Value};

/// Runs the same cases under several conditions and sets the metrics side by side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evaluate {
    /// As the suite calls it.
    pub name: String,
    /// What the suite says of it, in a sentence.
    pub doc: Option<String>,
    /// The cases that every condition runs.
    pub on: CaseSet,
    /// Never empty, names unique; the others are compared with the first.
    pub conditions: Vec<Condition>,
    /// Runs of every case under fresh seeds; 0: once, with the case's own seed.
    pub fresh: u32,
    /// The columns of its table; empty: every metric that the suite measures.
    pub measures: Vec<Measure>,
    /// Where the reported rows come from, such as `Wang et al., Table 1`.
    pub source: Option<String>,
    /// Rows of a source to show beside ours: a condition's name and a value per measure, SI units.
    pub reported: Vec<(String, Vec<f64>)>,
    /// The units that conditions give parameters in, where those are others than the SI units.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub given_in: Vec<(Target, Notation)>,
    /// Where it is declared.
    pub origin: Origin,
}

/// A set of parameters under which the cases run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// As tables call it.
    pub name: String,
    /// What it runs with.
    pub parameters: ParameterSet,
    /// Where it is declared.
    pub origin: Origin,
}

/// What a condition changes of the cases that it runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ParameterSet {
    /// What the scenarios declare.
    Declared,
    /// What a tune of this name chose.
    Tuned(String),
    /// What another scenario declares: its world with the cases' own variations, individuals and seeds.
    Scenario(String),
    /// Given in place, such as `av.controller.braking_distance: 10 m`.
    Given(Vec<(Target, Value)>),
    /// What a tune saved; a path resolved against the file that names it.
    Saved(String),
}

/// A column of the table: an aggregate over the runs of a condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measure {
    /// What sums them up.
    pub aggregate: Aggregate,
    /// In canonical words, such as `mean(pet)`.
    pub text: String,
    /// SI unit of its values.
    pub unit: String,
    /// The unit that people are shown, if that is another one: that of its reported values, or of a comparison with its metric.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub notation: Option<Notation>,
}
