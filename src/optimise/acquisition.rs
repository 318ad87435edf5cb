//! Acquisition functions: how much is to be gained by evaluating at a point, in logarithms.

use serde::{Deserialize, Serialize};

use super::surrogate::Posterior;
use numbers::distributions::normal_tail::{log_cumulative, log_improvement};

/// Standard deviations below this count as this: no logarithm of zero.
pub(super) const SMALLEST_DEVIATION: f64 = 1e-9;

/// Why a point was proposed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Acquisition {
    /// Expected improvement on the smallest observed value (Jones et al. 1998).
    ExpectedImprovement,
    /// By how much the answer is expected to get better (Scott et al. 2011).
    KnowledgeGradient,
    /// Probability of feasibility alone, as long as nothing feasible is known.
    Feasibility,
    /// Lower confidence bound, κ = 1.96 (`gp_minimize_like`).
    LowerConfidenceBound,
    /// Probability of improvement, ξ = 0.01 (`gp_minimize_like`).
    ProbabilityOfImprovement,
}

/// Log expected improvement of each point on `best`, on the surrogate's scale.
pub(super) fn log_expected_improvement(posteriors: &[Posterior], best: f64) -> Vec<f64> {
    let log = |posterior: &Posterior| {
        let deviation = posterior.deviation().max(SMALLEST_DEVIATION);
        libm::log(deviation) + log_improvement((best - posterior.mean) / deviation)
    };
    posteriors.iter().map(log).collect()
}

/// Log probability of a value below `best`.
pub(super) fn log_probability_of_improvement(posteriors: &[Posterior], best: f64) -> Vec<f64> {
    let log = |p: &Posterior| log_cumulative((best - p.mean) / p.deviation().max(SMALLEST_DEVIATION));
    posteriors.iter().map(log).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn improvement_prefers_lower_means_and_wider_beliefs() {
        let p = |mean, variance| Posterior { mean, variance };
        let logs = log_expected_improvement(&[p(0.0, 1.0), p(-1.0, 1.0), p(0.0, 4.0), p(50.0, 1e-30)], 0.0);
        assert!(logs[1] > logs[0] && logs[2] > logs[0]);
        assert!(logs.iter().all(|log| log.is_finite()));
    }
}
