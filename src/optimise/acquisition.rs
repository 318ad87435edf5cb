//! Acquisition functions: how much is to be gained by evaluating at a point, in logarithms.

use super::Error;
use super::models::{Models, Scaled};
use super::normal::{improvement, log_cumulative, log_improvement};
use super::random::{Purpose, fill_normal, stream};
use super::surrogate::{Fantasies, Posterior, Surrogate};
use serde::{Deserialize, Serialize};

/// Fantasies of noisy expected improvement; half are mirror images of the other half.
const FANTASIES: usize = 32;
/// Standard deviations below this count as this: no logarithm of zero.
const SMALLEST_DEVIATION: f64 = 1e-9;
/// Past this z-score the plain improvement is averaged, below it the logarithms.
const LINEAR_LIMIT: f64 = -5.0;

/// Why a point was proposed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Acquisition {
    /// Expected improvement on the smallest observed value (Jones et al. 1998).
    ExpectedImprovement,
    /// Expected improvement averaged over what the observed values may truly be (Letham et al. 2019).
    NoisyExpectedImprovement,
    /// Expected improvement on the effective best, discounted where noise hides it (Huang et al. 2006).
    AugmentedExpectedImprovement,
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

/// Log augmented expected improvement: on the effective best, times 1 − σ/√(s² + σ²) with σ² the noise of one evaluation.
pub(super) fn log_augmented_expected_improvement(
    posteriors: &[Posterior],
    best: f64,
    noise: f64,
) -> Vec<f64> {
    let plain = log_expected_improvement(posteriors, best);
    let discounted = plain.iter().zip(posteriors).map(|(log, posterior)| {
        let variance = posterior.variance.max(SMALLEST_DEVIATION * SMALLEST_DEVIATION);
        // 1 − σ/√(s² + σ²) without cancellation: s²/(√(s² + σ²) (√(s² + σ²) + σ))
        let (total, sigma) = ((variance + noise).sqrt(), noise.sqrt());
        log + libm::log(variance / (total * (total + sigma)))
    });
    discounted.collect()
}

/// Log probability of a value below `best`.
pub(super) fn log_probability_of_improvement(posteriors: &[Posterior], best: f64) -> Vec<f64> {
    let log = |p: &Posterior| log_cumulative((best - p.mean) / p.deviation().max(SMALLEST_DEVIATION));
    posteriors.iter().map(log).collect()
}

/// Which places count as incumbents: those with at least an even chance of being feasible; if there are none, the likeliest.
pub(super) fn incumbents(models: &Models, places: &[Vec<f64>]) -> Vec<bool> {
    let feasibility = models.log_feasibility(places);
    let likeliest = feasibility.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    feasibility.iter().map(|log| *log >= likeliest.min(libm::log(0.5))).collect()
}

/// The effective best: the mean at the incumbent with the lowest mean + one standard deviation.
pub(super) fn effective_best(models: &Models, objective: &Scaled, places: &[Vec<f64>]) -> Option<f64> {
    let posteriors = objective.surrogate.posterior(places);
    let counting = posteriors.iter().zip(incumbents(models, places)).filter(|(_, counts)| *counts);
    let cautious = |p: &Posterior| p.mean + p.deviation();
    counting.map(|(p, _)| p).min_by(|a, b| cautious(a).total_cmp(&cautious(b))).map(|p| p.mean)
}

/// Noisy expected improvement: prepared once per proposal, evaluated at many points.
pub(super) struct NoisyExpectedImprovement {
    fantasies: Fantasies,
    /// The lowest value of each fantasy at an incumbent.
    lowest: Vec<f64>,
}

impl NoisyExpectedImprovement {
    /// Draws what the values at `places` (evaluated and pending) may be; the best of `incumbents` is to be improved on.
    ///
    /// # Errors
    /// [`Error::Surrogate`] when the joint covariance cannot be factored.
    pub fn new(
        objective: &Scaled,
        places: &[Vec<f64>],
        incumbents: &[bool],
        seed: u64,
        proposal: u64,
    ) -> Result<Self, Error> {
        let mut generator = stream(seed, proposal, Purpose::Fantasies);
        let mut normals = Vec::with_capacity(FANTASIES);
        for _ in 0..FANTASIES / 2 {
            let mut normal = vec![0.0; places.len()];
            fill_normal(&mut generator, &mut normal);
            normals.push(normal.iter().map(|x| -x).collect());
            normals.push(normal);
        }
        let fantasies = objective.surrogate.fantasies(places, &normals)?;
        let lowest = |draw: &Vec<f64>| {
            let counting = draw.iter().zip(incumbents).filter(|(_, counts)| **counts);
            counting.map(|(value, _)| *value).fold(f64::INFINITY, f64::min)
        };
        let lowest = fantasies.draws().iter().map(lowest).collect();
        Ok(NoisyExpectedImprovement { fantasies, lowest })
    }

    /// Its logarithm at each point.
    pub fn log(&self, points: &[Vec<f64>]) -> Vec<f64> {
        let (mut scratch, mut scores) = (Vec::new(), Vec::new());
        points
            .iter()
            .map(|point| {
                let variance = self.fantasies.posterior(point, &mut scratch, &mut scores);
                let deviation = variance.sqrt().max(SMALLEST_DEVIATION);
                for (score, lowest) in scores.iter_mut().zip(&self.lowest) {
                    *score = (lowest - *score) / deviation;
                }
                libm::log(deviation) + log_mean_improvement(&scores)
            })
            .collect()
    }
}

/// ln of the mean of h(z).
fn log_mean_improvement(scores: &[f64]) -> f64 {
    let highest = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let count = scores.len() as f64;
    if highest > LINEAR_LIMIT {
        // Terms far below the highest are lost in its last digits anyway.
        let far = highest.min(0.0) - 8.0;
        return libm::log(scores.iter().filter(|z| **z > far).map(|&z| improvement(z)).sum::<f64>() / count);
    }
    let top = log_improvement(highest);
    top + libm::log(scores.iter().map(|&z| libm::exp(log_improvement(z) - top)).sum::<f64>() / count)
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

    #[test]
    fn augmentation_discounts_what_noise_hides() {
        let p = [Posterior { mean: 0.0, variance: 0.01 }, Posterior { mean: 0.0, variance: 1.0 }];
        let plain = log_expected_improvement(&p, 0.0);
        let noiseless = log_augmented_expected_improvement(&p, 0.0, 0.0);
        assert!(plain.iter().zip(noiseless).all(|(a, b)| (a - b).abs() < 1e-12));
        let noisy = log_augmented_expected_improvement(&p, 0.0, 1.0);
        assert!((noisy[1] - plain[1] - (1.0 - 1.0 / 2f64.sqrt()).ln()).abs() < 1e-12);
        assert!(plain[0] - noisy[0] > plain[1] - noisy[1]);
    }

    #[test]
    fn mean_improvement_joins_its_branches() {
        let scores = |top: f64| [top, top - 1.0, top - 3.0];
        let (a, b) = (
            log_mean_improvement(&scores(LINEAR_LIMIT - 1e-9)),
            log_mean_improvement(&scores(LINEAR_LIMIT + 1e-9)),
        );
        assert!((a - b).abs() < 1e-6, "{a} {b}");
        assert!(log_mean_improvement(&scores(-1e5)).is_finite());
    }
}
