//! Statistical inference: intervals with stated confidence, sequential decisions, paired comparisons.

mod bounded_mean;
mod comparison;
mod evidence;
mod max_t;
mod maximum_entropy;
mod mean;
mod paired_means;
mod paired_rates;
mod quantile;
mod sequential;
mod share;
mod smoothed_shares;
mod strata;
mod trinomial;
mod weighed_ratios;

pub use bounded_mean::{IndependentUnit, MeanWatch, mean_of_bounded, runs_for_mean};
pub use comparison::{McNemar, holm, mcnemar};
pub use evidence::evidence_of_worse;
pub use max_t::{PairDifferences, max_t};
pub use maximum_entropy::{
    EntropyWeights, WeightBound, WeightTarget, effective_size, maximum_entropy, maximum_entropy_within,
    nearest_mixture,
};
pub use mean::{mean_interval, paired_difference};
pub use paired_means::MeanChange;
pub use paired_rates::{rate_change, rate_rise};
pub use quantile::quantile_interval;
pub use sequential::{ConfidenceSequence, Sequential, ShareDecision, Sprt};
pub use share::{
    clopper_pearson, confidence_of_worst, failures_allowed, lower_bound, runs_needed, upper_bound, wilson,
};

pub use smoothed_shares::{CandidateShares, HeldCounts};
pub use weighed_ratios::{RatioFeatures, nearest_ratios, ratio_weights, weighed_ratio};

use serde::{Deserialize, Serialize};

use super::json;

/// Where a quantity lies at a stated confidence; both ends belong to it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// In the unit of the quantity; negative infinity where nothing bounds it from below.
    #[serde(with = "json::low")]
    pub low: f64,
    /// In the unit of the quantity; infinity where nothing bounds it from above.
    #[serde(with = "json::high")]
    pub high: f64,
}

impl Interval {
    /// Whether a value lies within; no interval contains NaN.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}

/// The largest of 1..=n for which something holds that holds up to it and not beyond.
fn largest_true(n: u64, holds: impl Fn(u64) -> bool) -> Option<u64> {
    let (mut below, mut above) = (0, n + 1);
    while above - below > 1 {
        let middle = below + (above - below) / 2;
        if holds(middle) { below = middle } else { above = middle }
    }
    (below > 0).then_some(below)
}
