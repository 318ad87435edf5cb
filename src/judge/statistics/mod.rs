//! Statistics behind verdicts: intervals with stated confidence, sequential decisions, paired comparisons.
//!
//! Pure functions: the same numbers in give the same numbers out. What is random is drawn from a given seed.

mod betting;
mod bootstrap;
mod comparison;
mod distributions;
mod paired_means;
mod paired_rates;
mod proportion;
mod sequential;
mod summary;

pub use betting::{MeanWatch, Unit, mean_of_bounded, runs_for_mean};
pub use bootstrap::{mean_interval, paired_difference};
pub use comparison::{McNemar, holm, mcnemar};
pub use distributions::{
    beta_quantile, binomial_at_least, binomial_at_most, regularised_beta, student_above, student_quantile,
};
pub use paired_means::MeanChange;
pub use paired_rates::{rate_change, rate_rise};
pub use proportion::{
    clopper_pearson, confidence_of_worst, failures_allowed, lower_bound, runs_needed, upper_bound, wilson,
};
pub use sequential::{ConfidenceSequence, Decision, Sequential, Sprt};
pub use summary::{mean, median, quantile, quantile_interval, std};

use serde::{Deserialize, Serialize};

/// Where a quantity lies at a stated confidence; both ends belong to it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    #[serde(with = "crate::scenario::number::low")]
    pub low: f64,
    #[serde(with = "crate::scenario::number::high")]
    pub high: f64,
}

impl Interval {
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}
