//! What `estimate` blocks declare: an event whose probability is to be known.

use serde::{Deserialize, Serialize};

use super::{Comparison, MetricReference, Origin};
use numbers::inference::runs_needed;
use numbers::rare::{CrudeSampling, ImportanceSampling, SplittingSampling};

/// Fewer runs are not enough for replicates that say anything.
pub const FEWEST_ESTIMATE_RUNS: u32 = numbers::rare::FEWEST_RUNS as u32;

/// How probable an event is in a scenario that draws.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// As the suite calls it.
    pub name: String,
    /// What the suite says of it, in a sentence.
    pub doc: Option<String>,
    /// The scenario, which draws something in every run and varies nothing.
    pub scenario: String,
    /// A scenario that draws the same, whose runs are made in the same encounters; `None` where nothing is compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared_with: Option<String>,
    /// What the probability is of. A run of which it cannot be said counts as one with the event.
    pub event: Comparison,
    /// In canonical words, such as `pet < 0.5 s`.
    pub event_text: String,
    /// What gets worse the nearer a run is to the event; runs as they are drawn need none.
    pub score: Option<MetricReference>,
    /// Runs in all; of two that are compared half are of each.
    pub budget: u32,
    /// How they are made.
    pub method: EstimateMethod,
    /// How many encounters there are; `None` where nobody says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure: Option<Exposure>,
    /// What the probability is at most.
    pub claims: Vec<EstimateClaim>,
    /// Where it is declared.
    pub origin: Origin,
}

/// How many encounters of a kind there are along a distance, as somebody says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Exposure {
    /// At least so many in 1,000 km.
    pub low: f64,
    /// At most so many in 1,000 km, at least `low`.
    pub high: f64,
    /// How sure it is that they are between both; `None`: they are taken for granted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
    /// How that is known.
    pub source: String,
    /// As it is written, without its source.
    pub text: String,
    /// Where it stands.
    pub origin: Origin,
}

/// How the runs of an estimate are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EstimateMethod {
    /// Where the event is likely, weighed by multiple importance sampling.
    Importance,
    /// Level by level nearer to the event, from those that came nearest.
    Splitting,
    /// As they are drawn.
    Crude,
}

/// What a claim is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EstimateClaimOf {
    /// The probability of the event.
    #[default]
    Probability,
    /// That less the probability of what it is compared with.
    Difference,
    /// That over the probability of what it is compared with.
    Ratio,
}

/// What a probability is at most, or how much or how many times more probable an event is at most.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EstimateClaim {
    /// What is at most that.
    #[serde(default, skip_serializing_if = "EstimateClaimOf::is_probability")]
    pub of: EstimateClaimOf,
    /// Whether the bound that needs no assumption decides, and not the estimate.
    pub guaranteed: bool,
    /// The largest probability, difference or ratio with which it holds, whatever the exposure may be.
    pub at_most: f64,
    /// Of a claim about a distance: the events that it says there are at most in 1,000 km.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub per_1000_km: Option<f64>,
    /// One-sided, between 1/2 and 1; of a claim about a distance so much more as the exposure may be wrong.
    pub confidence: f64,
    /// As it is written.
    pub text: String,
    /// Where it stands.
    pub origin: Origin,
}

impl EstimateMethod {
    /// As it is written.
    pub fn word(self) -> &'static str {
        match self {
            Self::Importance => "importance",
            Self::Splitting => "splitting",
            Self::Crude => "crude",
        }
    }

    /// How many of so many runs are drawn as they are without a method.
    pub fn nominal_runs(self, budget: usize) -> usize {
        match self {
            Self::Importance => ImportanceSampling::nominal_runs_of(budget),
            Self::Splitting => SplittingSampling::nominal_runs_of(budget),
            Self::Crude => CrudeSampling::nominal_runs_of(budget),
        }
    }
}

impl EstimateClaimOf {
    fn is_probability(&self) -> bool {
        *self == Self::Probability
    }
}

impl Estimate {
    /// Encounters in all: of two that are compared each makes a run in every one.
    pub fn encounters(&self) -> u32 {
        if self.compared_with.is_some() { self.budget / 2 } else { self.budget }
    }
}

impl EstimateClaim {
    /// Runs drawn as they are that a guarantee takes at least, all of them without the event; `None` where no number suffices.
    pub fn runs_needed(&self) -> Option<u64> {
        runs_needed(1.0 - self.at_most, self.confidence).filter(|_| self.at_most > 0.0)
    }
}
