//! The exact log marginal likelihood of a Gaussian process and its analytic gradient, with weak priors.
//!
//! Rasmussen and Williams (2006), eq. 5.8 and 5.9. friedrich's `likelihood()` sums the logarithm of the kernel matrix's
//! diagonal where the log-determinant belongs, so it can rank neither models nor starting points.

use super::Dataset;
use super::dense::{Factor, dot};
use super::kernel::{HyperParameters, matern52_in_place, squared_difference};

/// What holds hyper-parameters in place besides the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Prior {
    /// Weak log-normal priors: length scales LN(ln 0.3 + ½ ln d, 1.2), amplitude LN(0, 1), noise variance LN(−4, 1.5).
    LogNormal,
    /// Bounds only, as scikit-optimize has them.
    Bounds,
}

impl Prior {
    /// Bounds of each logarithm for `d` dimensions.
    pub fn bounds(self, d: usize) -> Vec<(f64, f64)> {
        let (length_scale, amplitude, noise) = match self {
            Prior::LogNormal => ((0.005, 100.0), (1e-3, 1e3), (1e-6, 10.0)),
            Prior::Bounds => ((0.01, 100.0), (0.01, 1000.0), (1e-5, 1e5)),
        };
        let mut bounds = vec![length_scale; d];
        bounds.extend([amplitude, noise]);
        bounds.into_iter().map(|(low, high): (f64, f64)| (libm::log(low), libm::log(high))).collect()
    }

    /// Mean and standard deviation of logarithm `i` of `d + 2`.
    fn of(d: usize, i: usize) -> (f64, f64) {
        match i {
            i if i < d => (libm::log(0.3) + 0.5 * libm::log(d as f64), 1.2),
            i if i == d => (0.0, 1.0),
            _ => (-4.0, 1.5),
        }
    }

    /// Log density up to a constant; adds its gradient when one is given.
    fn log_density(self, logarithms: &[f64], gradient: Option<&mut [f64]>) -> f64 {
        if self == Prior::Bounds {
            return 0.0;
        }
        let d = logarithms.len() - 2;
        let scaled = |i: usize| {
            let (mean, deviation) = Prior::of(d, i);
            ((logarithms[i] - mean) / deviation, deviation)
        };
        if let Some(gradient) = gradient {
            for (i, slope) in gradient.iter_mut().enumerate() {
                let (z, deviation) = scaled(i);
                *slope -= z / deviation;
            }
        }
        (0..logarithms.len()).map(|i| -0.5 * (scaled(i).0 * scaled(i).0)).sum()
    }
}

/// The likelihood of one data set as a function of the hyper-parameters' logarithms.
pub(crate) struct Likelihood<'a> {
    data: &'a Dataset,
    prior: Prior,
    /// Of each dimension the squared differences of all pairs i > j.
    differences: Vec<Vec<f64>>,
}

/// The likelihood at one place, with what the gradient needs.
pub(crate) struct Evaluation {
    /// Log marginal likelihood plus log prior density.
    pub value: f64,
    hyper: HyperParameters,
    factor: Factor,
    weights: Vec<f64>,
    /// Of each pair i > j, for amplitude 1.
    kernels: Vec<f64>,
    slopes: Vec<f64>,
}

impl<'a> Likelihood<'a> {
    /// Prepares the pairwise differences of `data`.
    pub fn new(data: &'a Dataset, prior: Prior) -> Self {
        let n = data.points.len();
        let of_dimension = |(k, &categorical): (usize, &bool)| {
            let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
            pairs
                .map(|(i, j)| squared_difference(data.points[i][k], data.points[j][k], categorical))
                .collect()
        };
        let differences = data.categorical.iter().enumerate().map(of_dimension).collect();
        Likelihood { data, prior, differences }
    }

    /// Number of hyper-parameters.
    pub fn parameters(&self) -> usize {
        self.data.categorical.len() + 2
    }

    /// Bounds of the hyper-parameters' logarithms.
    pub fn bounds(&self) -> Vec<(f64, f64)> {
        self.prior.bounds(self.data.categorical.len())
    }

    /// The likelihood; `None` where the covariance is not positive definite to working precision.
    pub fn evaluate(&self, logarithms: &[f64]) -> Option<Evaluation> {
        let n = self.data.points.len();
        let hyper = HyperParameters::from_logarithms(logarithms);
        let mut kernels = vec![0.0; n * (n - 1) / 2];
        for (differences, l) in self.differences.iter().zip(&hyper.length_scales) {
            let inverse_square = 1.0 / (l * l);
            kernels.iter_mut().zip(differences).for_each(|(sum, x)| *sum += inverse_square * x);
        }
        let mut slopes = vec![0.0; kernels.len()];
        matern52_in_place(&mut kernels, &mut slopes);
        let mut triangle = Vec::with_capacity(n * (n + 1) / 2);
        let mut rest = kernels.as_slice();
        for i in 0..n {
            let (row, after) = rest.split_at(i);
            triangle.extend(row.iter().map(|kernel| hyper.amplitude * kernel));
            triangle.push(hyper.amplitude + self.data.noise_variance(i, hyper.noise));
            rest = after;
        }
        let factor = Factor::new(triangle)?;
        let mut weights = self.data.values.clone();
        factor.solve_lower(&mut weights);
        let misfit = dot(&weights, &weights);
        factor.solve_upper(&mut weights);
        let constant = n as f64 * libm::log(2.0 * std::f64::consts::PI);
        let likelihood = -0.5 * (misfit + factor.log_determinant() + constant);
        let value = likelihood + self.prior.log_density(logarithms, None);
        value.is_finite().then_some(Evaluation { value, hyper, factor, weights, kernels, slopes })
    }

    /// Gradient of [`Evaluation::value`] by the logarithms: ½ tr((α αᵀ − K⁻¹) ∂K/∂θ) plus the prior's.
    pub fn gradient(&self, at: &Evaluation, logarithms: &[f64]) -> Vec<f64> {
        let inverse = at.factor.inverse();
        let (mut amplitude, mut noise) = (0.0, 0.0);
        // Of each pair i > j, whose share counts twice.
        let mut weighted = Vec::with_capacity(at.kernels.len());
        let mut rest = inverse.as_slice();
        for (i, own) in at.weights.iter().enumerate() {
            let (row, after) = rest.split_at(i + 1);
            weighted.extend(row[..i].iter().zip(&at.weights).map(|(inverse, other)| own * other - inverse));
            let on_diagonal = 0.5 * (own * own - row[i]);
            amplitude += on_diagonal;
            noise += on_diagonal * self.data.noise[i].shared;
            rest = after;
        }
        amplitude += dot(&weighted, &at.kernels);
        weighted.iter_mut().zip(&at.slopes).for_each(|(weight, slope)| *weight *= slope);
        let by_length_scale = self.differences.iter().zip(&at.hyper.length_scales);
        let mut gradient: Vec<f64> =
            by_length_scale.map(|(x, l)| dot(&weighted, x) * at.hyper.amplitude / (l * l)).collect();
        gradient.push(amplitude * at.hyper.amplitude);
        gradient.push(noise * at.hyper.noise);
        self.prior.log_density(logarithms, Some(&mut gradient));
        gradient
    }
}

#[cfg(test)]
mod tests {
    use friedrich::gaussian_process::GaussianProcess;
    use friedrich::prior::ConstantPrior;
    use nalgebra::{DMatrix, DVector};

    use super::super::kernel::ArdMatern52;
    use super::super::{Dataset, Noise};
    use super::*;

    fn data() -> Dataset {
        let points: Vec<Vec<f64>> = (0..14)
            .map(|i| {
                let x = i as f64 / 13.0;
                vec![x, (7.0 * x).fract(), if i % 3 == 0 { 0.25 } else { 0.75 }]
            })
            .collect();
        let values = points.iter().map(|p| (9.0 * p[0]).sin() + 0.5 * p[1] + p[2]).collect();
        let noise = (0..14).map(|i| Noise { shared: 1.0 / (1 + i % 2) as f64, known: 0.01 * (i % 4) as f64 });
        Dataset { points, values, noise: noise.collect(), categorical: vec![false, false, true] }
    }

    const LOGARITHMS: [f64; 5] = [-1.2, -0.3, 0.2, 0.4, -3.0];

    #[test]
    fn analytic_gradient_agrees_with_finite_differences() {
        let data = data();
        for prior in [Prior::LogNormal, Prior::Bounds] {
            let likelihood = Likelihood::new(&data, prior);
            let gradient = likelihood.gradient(&likelihood.evaluate(&LOGARITHMS).unwrap(), &LOGARITHMS);
            for (i, analytic) in gradient.iter().enumerate() {
                let at = |step: f64| {
                    let mut moved = LOGARITHMS;
                    moved[i] += step;
                    likelihood.evaluate(&moved).unwrap().value
                };
                let numeric = (at(1e-5) - at(-1e-5)) / 2e-5;
                assert!(
                    (analytic - numeric).abs() < 1e-6 * numeric.abs().max(1.0),
                    "{i}: {analytic} {numeric}"
                );
            }
        }
    }

    #[test]
    fn trap_friedrich_likelihood_is_not_the_log_marginal_likelihood() {
        let data = data();
        let hyper = HyperParameters::from_logarithms(&LOGARITHMS);
        let kernel = ArdMatern52::new(&hyper, &data.categorical);
        let n = data.points.len();
        let covariance = DMatrix::from_fn(n, n, |i, j| {
            let noise = if i == j { data.noise_variance(i, hyper.noise) } else { 0.0 };
            kernel.covariance(&data.points[i], &data.points[j]) + noise
        });
        let values = DVector::from_vec(data.values.clone());
        let cholesky = covariance.cholesky().unwrap();
        let expected = -0.5
            * (values.dot(&cholesky.solve(&values))
                + cholesky.ln_determinant()
                + n as f64 * (2.0 * std::f64::consts::PI).ln());
        let ours = Likelihood::new(&data, Prior::Bounds).evaluate(&LOGARITHMS).unwrap().value;
        assert!((ours - expected).abs() < 1e-9, "{ours} {expected}");

        let rows = ArdMatern52::training_rows(&data.points, |i| data.noise_variance(i, hyper.noise));
        let process = GaussianProcess::new(ConstantPrior::new(0.0), kernel, 0.0, None, rows, values);
        assert!((process.likelihood() - expected).abs() > 1.0, "friedrich has been mended");
    }
}
