//! Cases that a block found or ran, with what came of them.

use serde::{Deserialize, Serialize};

use super::outcome::Outcome;
use numbers::json;
use scenario::{Assignment, Individual, MetricKind, Target, Value};

/// Cases with a name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedSet {
    /// As the block that made it is called.
    pub name: String,
    /// What made it: suite, seed, version of the tool.
    pub source: String,
    /// In the order in which they are run.
    pub cases: Vec<SavedCase>,
}

/// One case, told apart from the rest of its scenario by everything that a search or a draw decided.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedCase {
    /// The key of the run it was found in.
    pub key: String,
    /// The scenario's name.
    pub scenario: String,
    /// The values of its variations, those that a search chose included.
    pub variation: Vec<Assignment>,
    /// What was set besides what the scenario says.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub settings: Vec<(Target, Value)>,
    /// The people who walk in it.
    pub individuals: Vec<Individual>,
    /// The seed of the run.
    #[serde(with = "json::whole")]
    pub seed: u64,
    /// What the search minimised or maximised, as observed in the run.
    pub value: Option<f64>,
    /// The share of all encounters, as they are declared to be drawn, that are no more usual; `None` where nothing says that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plausibility: Option<f64>,
}

/// A case that was run, with what came of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseRun {
    /// What was run.
    pub case: SavedCase,
    /// Its metrics are in the order of the requests of whoever ran it.
    pub outcome: Outcome,
    /// Who passed first, in the words of the metric `passed_first`; `None` if that was not measured or nobody did.
    pub passed_first: Option<String>,
}

/// One metric over a set of runs; flags are shares.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MetricSummary {
    /// Its label, such as `pet` or `max_deceleration(window=0.5)`.
    pub metric: String,
    /// What its values are.
    #[serde(default)]
    pub kind: Option<MetricKind>,
    /// All runs of the set.
    pub runs: usize,
    /// Runs in which the metric exists and was decided before the horizon: what the other numbers are of.
    pub defined: usize,
    /// Over the defined runs, SI units; `None` without one.
    pub mean: Option<f64>,
    /// The smallest of the defined runs, SI units.
    pub min: Option<f64>,
    /// The largest of the defined runs, SI units.
    pub max: Option<f64>,
}
