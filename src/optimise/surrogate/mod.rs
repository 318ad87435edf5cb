//! The surrogate: what the optimiser believes about an expensive, noisy function from the evaluations it has seen.

pub(crate) mod dense;
pub(crate) mod fit;
mod gaussian_process;
mod kernel;
pub(crate) mod likelihood;
mod standardise;
mod widest;

pub use gaussian_process::FriedrichSurrogate;
pub use kernel::HyperParameters;
pub use standardise::{Outliers, Standardisation};

use std::ops::Range;

use super::Error;
use dense::Lanes;

/// The noise of one datum: a share of the fitted noise, and what is known besides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Factor on the fitted noise variance of one evaluation: 1/n for a mean of n, 0 when only `known` counts.
    pub shared: f64,
    /// Variance known beforehand, added.
    pub known: f64,
}

/// Distinct points of the unit cube with standardised values.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// One vector of unit coordinates per datum.
    pub points: Vec<Vec<f64>>,
    /// One standardised value per datum.
    pub values: Vec<f64>,
    /// One noise per datum.
    pub noise: Vec<Noise>,
    /// Which dimensions hold choices without order.
    pub categorical: Vec<bool>,
}

/// A normal belief about the latent function at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Posterior {
    /// Mean.
    pub mean: f64,
    /// Variance of the latent function (without evaluation noise), never negative.
    pub variance: f64,
}

impl Posterior {
    /// Standard deviation of the latent function.
    pub fn deviation(&self) -> f64 {
        self.variance.sqrt()
    }
}

/// A probabilistic model of a function on the unit cube. Values are standardised: of order one.
pub trait Surrogate: Sized {
    /// Fits the model, starting from the `previous` hyper-parameters and from those of a few fixed places whose turn it is: these
    /// numbers modulo how many there are. Without previous ones it is everyone's.
    ///
    /// # Errors
    /// [`Error::Surrogate`] when the data are empty, not finite, of unequal lengths, or cannot be factored.
    fn fit(data: Dataset, previous: Option<&HyperParameters>, turns: Range<usize>) -> Result<Self, Error>;

    /// The belief at each point.
    fn posterior(&self, points: &[Vec<f64>]) -> Vec<Posterior>;

    /// The same belief, up to rounding, in the shortest time: for the thousand candidates of an acquisition's maximum.
    fn scan(&self, points: &[Vec<f64>]) -> Vec<Posterior>;

    /// What covariances of the latent function at any point with that at these data, in ascending order, are computed from.
    fn covariances_with(&self, data: &[usize]) -> CovariancesWith;

    /// Like [`Surrogate::scan`], point by point, each with its posterior covariance with the latent function at some of the data.
    fn scan_with_covariances(
        &self,
        points: &[Vec<f64>],
        with: &CovariancesWith,
        visit: impl FnMut(Posterior, &[f64]),
    );

    /// Joint draws of the latent function at `points`, one for each vector of standard normal numbers in `normals`.
    ///
    /// # Errors
    /// [`Error::Surrogate`] when the joint covariance cannot be factored.
    fn sample(&self, points: &[Vec<f64>], normals: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, Error>;

    /// The model after one more datum, hyper-parameters unchanged.
    ///
    /// # Errors
    /// As for [`Surrogate::fit`].
    fn condition(&self, point: Vec<f64>, value: f64, noise: Noise) -> Result<Self, Error>;

    /// The hyper-parameters in use.
    fn hyper_parameters(&self) -> &HyperParameters;
}

/// Made by [`Surrogate::covariances_with`].
pub struct CovariancesWith {
    count: usize,
    /// Columns of the inverse of the covariance's factor, times the noise, from the row on that is given first.
    blocks: Vec<(usize, Vec<Lanes>)>,
}

impl Dataset {
    /// Variance of the noise of datum `i` when one evaluation's is `noise`.
    pub(crate) fn noise_variance(&self, i: usize, noise: f64) -> f64 {
        self.noise[i].shared * noise + self.noise[i].known
    }

    /// Variance of the noise of one more evaluation when the fitted one is `noise`; where every datum's is known, the middle
    /// one of them (of two, the larger: rather more noise than less).
    pub(crate) fn noise_of_another(&self, noise: f64) -> f64 {
        let shared = self.noise.iter().map(|datum| datum.shared).fold(0.0, f64::max);
        if shared > 0.0 {
            return shared * noise;
        }
        let mut known: Vec<f64> = self.noise.iter().map(|datum| datum.known).collect();
        known.sort_by(f64::total_cmp);
        known.get(known.len() / 2).copied().unwrap_or(noise)
    }

    /// # Errors
    /// [`Error::Surrogate`] unless there is at least one datum, all numbers are finite, noise is not negative, lengths agree and
    /// no point is given twice.
    fn check(&self) -> Result<(), Error> {
        let refuse = |reason: &str| Err(Error::Surrogate(reason.to_owned()));
        let n = self.points.len();
        if n == 0 {
            return refuse("there is nothing to fit");
        }
        if self.values.len() != n || self.noise.len() != n {
            return refuse("points, values and noise differ in number");
        }
        if self.points.iter().any(|point| point.len() != self.categorical.len()) {
            return refuse("points differ in dimension");
        }
        if !self.points.iter().flatten().chain(&self.values).all(|number| number.is_finite()) {
            return refuse("a coordinate or value is not finite");
        }
        if !self
            .noise
            .iter()
            .all(|noise| noise.shared >= 0.0 && noise.known >= 0.0 && noise.known.is_finite())
        {
            return refuse("a noise variance is negative or not finite");
        }
        let mut order: Vec<&Vec<f64>> = self.points.iter().collect();
        order.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        if order.windows(2).any(|pair| pair[0] == pair[1]) {
            return refuse("a point is given twice: merge duplicates into a mean first");
        }
        Ok(())
    }
}
