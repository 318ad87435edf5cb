//! The surrogate on friedrich's Gaussian process: friedrich computes posteriors, we choose hyper-parameters and guard its edges.

use super::dense::{Factor, dot};
use super::fantasies::Fantasies;
use super::fit::{self, Effort};
use super::kernel::{ArdMatern52, HyperParameters};
use super::likelihood::{Likelihood, Prior};
use super::{Dataset, Noise, Posterior, Surrogate};
use crate::optimise::Error;
use friedrich::gaussian_process::GaussianProcess;
use friedrich::prior::ConstantPrior;
use nalgebra::DVector;

/// Least noise variance that reaches friedrich, as a share of the amplitude: keeps every covariance matrix invertible.
const NOISE_FLOOR: f64 = 1e-9;
/// What friedrich puts in place of a pivot that rounding made negative.
const CHOLESKY_EPSILON: f64 = 1e-8;

/// A Gaussian process with zero mean and our Matérn 5/2 kernel, its posterior computed by friedrich.
pub struct FriedrichSurrogate {
    data: Dataset,
    hyper: HyperParameters,
    /// Added to every noise variance so that the covariance can be factored.
    jitter: f64,
    process: GaussianProcess<ArdMatern52, ConstantPrior>,
}

impl FriedrichSurrogate {
    /// Like [`Surrogate::fit`] with bounds on the hyper-parameters but no priors, as scikit-optimize has it.
    pub(crate) fn fit_without_priors(data: Dataset, previous: Option<&HyperParameters>) -> Result<Self, Error> {
        Self::fit_with(data, previous, Effort::MultiStart, Prior::Bounds)
    }

    fn fit_with(
        data: Dataset,
        previous: Option<&HyperParameters>,
        effort: Effort,
        prior: Prior,
    ) -> Result<Self, Error> {
        data.check()?;
        let found = fit::fit(&Likelihood::new(&data, prior), previous, effort);
        // No start could be factored: the last good hyper-parameters, else neutral ones with ample noise.
        let hyper = found.or_else(|| previous.cloned()).unwrap_or_else(|| HyperParameters {
            length_scales: vec![0.3 * (data.categorical.len() as f64).sqrt(); data.categorical.len()],
            amplitude: 1.0,
            noise: 0.1,
        });
        Self::with_hyper_parameters(data, hyper)
    }

    /// The posterior for given hyper-parameters.
    ///
    /// # Errors
    /// [`Error::Surrogate`] when the data are unfit (see [`Surrogate::fit`]) or no jitter up to 1 % of the amplitude makes the
    /// covariance matrix positive definite.
    pub fn with_hyper_parameters(data: Dataset, hyper: HyperParameters) -> Result<Self, Error> {
        data.check()?;
        let kernel = ArdMatern52::new(&hyper, &data.categorical);
        let n = data.points.len();
        let floor = NOISE_FLOOR * hyper.amplitude;
        let mut covariance = prior_covariance(&kernel, &data.points);
        for i in 0..n {
            covariance[i * n + i] += data.noise_variance(i, hyper.noise).max(floor);
        }
        // friedrich panics on a matrix it cannot factor: try it here first.
        let (_, jitter) = Factor::with_jitter(n, &covariance, hyper.amplitude)
            .ok_or_else(|| Error::Surrogate("the covariance of the evaluated points cannot be factored".to_owned()))?;
        let rows = ArdMatern52::training_rows(&data.points, |i| {
            data.noise_variance(i, hyper.noise).max(floor) + jitter
        });
        let values = DVector::from_column_slice(&data.values);
        let prior = ConstantPrior::new(0.0);
        // Noise is in the rows, by point; friedrich's own, a standard deviation common to all, stays zero.
        let process = GaussianProcess::new(prior, kernel, 0.0, Some(CHOLESKY_EPSILON), rows, values);
        Ok(FriedrichSurrogate { data, hyper, jitter, process })
    }

    /// The data it was fitted to.
    pub fn data(&self) -> &Dataset {
        &self.data
    }

    /// What had to be added to the noise variances to factor the covariance; usually zero.
    pub fn jitter(&self) -> f64 {
        self.jitter
    }
}

/// Prior covariance of the latent function between points: lower triangle, row-major n × n.
fn prior_covariance(kernel: &ArdMatern52, points: &[Vec<f64>]) -> Vec<f64> {
    let n = points.len();
    let mut covariance = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            covariance[i * n + j] = kernel.covariance(&points[i], &points[j]);
        }
    }
    covariance
}

impl Surrogate for FriedrichSurrogate {
    fn fit(data: Dataset, previous: Option<&HyperParameters>, refine: bool) -> Result<Self, Error> {
        let effort = if refine { Effort::Refine } else { Effort::MultiStart };
        Self::fit_with(data, previous, effort, Prior::LogNormal)
    }

    fn posterior(&self, points: &[Vec<f64>]) -> Vec<Posterior> {
        if points.is_empty() {
            return Vec::new();
        }
        let (means, variances) = self.process.predict_mean_variance(&ArdMatern52::query_rows(points));
        let both = means.iter().zip(variances.iter());
        // Rounding can take a variance at an evaluated point just below zero.
        both.map(|(&mean, &variance)| Posterior { mean, variance: variance.max(0.0) }).collect()
    }

    fn sample(&self, points: &[Vec<f64>], normals: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, Error> {
        let n = points.len();
        if n == 0 {
            return Ok(vec![Vec::new(); normals.len()]);
        }
        // friedrich's own sampler panics on close points; its joint covariance is sound.
        let rows = ArdMatern52::query_rows(points);
        let means = self.process.predict(&rows);
        let covariance = self.process.predict_covariance(&rows);
        let (factor, _) = Factor::with_jitter(n, covariance.as_slice(), self.hyper.amplitude)
            .ok_or_else(|| Error::Surrogate("the joint covariance of the points to sample cannot be factored".to_owned()))?;
        let draw = |normal: &Vec<f64>| (0..n).map(|i| means[i] + dot(factor.row(i), &normal[..=i])).collect();
        Ok(normals.iter().map(draw).collect())
    }

    fn condition(&self, point: Vec<f64>, value: f64, noise: Noise) -> Result<Self, Error> {
        let mut data = self.data.clone();
        match data.points.iter().position(|known| *known == point) {
            // Another look at a known place: the precision-weighted mean of both.
            Some(i) => {
                let (old, new) = (
                    data.noise_variance(i, self.hyper.noise).max(NOISE_FLOOR),
                    (noise.shared * self.hyper.noise + noise.known).max(NOISE_FLOOR),
                );
                data.values[i] = (data.values[i] * new + value * old) / (old + new);
                data.noise[i] = Noise { shared: 0.0, known: old * new / (old + new) };
            }
            None => {
                data.points.push(point);
                data.values.push(value);
                data.noise.push(noise);
            }
        }
        // friedrich's `add_samples` panics on near duplicates: a new factorisation costs a fraction of a millisecond.
        Self::with_hyper_parameters(data, self.hyper.clone())
    }

    fn fantasies(&self, points: &[Vec<f64>], normals: &[Vec<f64>]) -> Result<Fantasies, Error> {
        let kernel = ArdMatern52::new(&self.hyper, &self.data.categorical);
        let draws = self.sample(points, normals)?;
        Fantasies::new(kernel, prior_covariance, points.to_vec(), draws)
    }

    fn hyper_parameters(&self) -> &HyperParameters {
        &self.hyper
    }
}
