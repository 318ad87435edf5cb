//! Fantasies: possible noise-free functions, drawn jointly at the evaluated points and interpolated elsewhere.
//!
//! Noisy expected improvement averages over what the values at the evaluated points may truly be (Letham et al. 2019,
//! "Constrained Bayesian optimization with noisy experiments", §3). All fantasies share one factorisation.

use super::dense::{Factor, dot};
use super::kernel::ArdMatern52;
use crate::optimise::Error;

/// Noise-free variance kept at the drawn points, as a share of the amplitude, so that close points can be interpolated.
const NUGGET: f64 = 1e-6;

/// Several possible functions through one set of points.
pub struct Fantasies {
    kernel: ArdMatern52,
    points: Vec<Vec<f64>>,
    factor: Factor,
    /// K⁻¹ f of each draw.
    weights: Vec<Vec<f64>>,
    draws: Vec<Vec<f64>>,
}

impl Fantasies {
    /// `covariance` is the prior's between `points`, its lower triangle row-major; `draws` hold a value for each point.
    pub(super) fn new(
        kernel: ArdMatern52,
        covariance: Vec<f64>,
        points: Vec<Vec<f64>>,
        draws: Vec<Vec<f64>>,
    ) -> Result<Self, Error> {
        let n = points.len();
        let mut rows = covariance;
        let amplitude = rows.first().copied().unwrap_or(1.0);
        (0..n).for_each(|i| rows[i * n + i] += NUGGET * amplitude);
        let (factor, _) = Factor::with_jitter(n, &rows, amplitude).ok_or_else(|| {
            Error::Surrogate("the covariance of the drawn points cannot be factored".to_owned())
        })?;
        let mut weights = draws.clone();
        for draw in &mut weights {
            factor.solve_lower(draw);
            factor.solve_upper(draw);
        }
        Ok(Fantasies { kernel, points, factor, weights, draws })
    }

    /// Each fantasy's values at its points.
    pub fn draws(&self) -> &[Vec<f64>] {
        &self.draws
    }

    /// Writes each fantasy's mean at `point` to `means` and returns their common variance.
    pub fn posterior(&self, point: &[f64], scratch: &mut Vec<f64>, means: &mut Vec<f64>) -> f64 {
        scratch.clear();
        scratch.extend(self.points.iter().map(|known| self.kernel.covariance(known, point)));
        means.clear();
        means.extend(self.weights.iter().map(|weights| dot(scratch, weights)));
        self.factor.solve_lower(scratch);
        (self.kernel.covariance(point, point) - dot(scratch, scratch)).max(0.0)
    }
}
