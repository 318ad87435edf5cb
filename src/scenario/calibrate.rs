//! What `calibrate` blocks declare: candidates who are weighed until they do what people did.

use serde::{Deserialize, Serialize};

use super::{Comparison, Individuals, Observations, Origin};

/// Weighs candidates so that they do in scenarios what people did who were observed there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibrate {
    /// As the suite calls it, and the population that comes of it.
    pub name: String,
    /// What the suite says of it, in a sentence.
    pub doc: Option<String>,
    /// Who is weighed.
    pub candidates: CandidateSource,
    /// The scenarios whose conditions people were observed in, at least one.
    pub scenarios: Vec<String>,
    /// What is counted of every run; it says itself what an undefined run counts as.
    pub condition: Comparison,
    /// In canonical words, such as `rate(gap_accepted)`.
    pub text: String,
    /// What people did.
    pub observations: Observations,
    /// Whether the spread between persons is matched as well.
    pub spread: bool,
    /// How many of their errors targets are to be matched within; 1: as well as they are known.
    #[serde(default = "one_error", skip_serializing_if = "is_one_error")]
    pub within: f64,
    /// The same of the spread between persons; `None`: as of shares.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread_within: Option<f64>,
    /// In how many parts conditions are held back in turn; 0: in none.
    pub folds: u32,
    /// Runs of every candidate in every condition, at least 2.
    pub runs: u32,
    /// Populations that are put into the same conditions to be shown beside.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub compared: Vec<Individuals>,
    /// Where it is declared.
    pub origin: Origin,
}

/// Where candidates come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CandidateSource {
    /// This many in a Latin hypercube on log scales, over the ranges that the model says.
    LatinHypercube(u32),
    /// Those of a population, all or some.
    Population(Individuals),
}

fn one_error() -> f64 {
    1.0
}

fn is_one_error(within: &f64) -> bool {
    *within == 1.0
}
