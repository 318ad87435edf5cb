//! The surrogate on friedrich's Gaussian process: friedrich computes posteriors, we choose hyper-parameters and guard its edges.

use std::ops::Range;
use std::sync::OnceLock;

use friedrich::gaussian_process::GaussianProcess;
use friedrich::prior::ConstantPrior;
use nalgebra::DVector;

use super::dense::{Factor, LANES, Lanes, dot, products};
use super::fit::{self, ALL_STARTS};
use super::kernel::{ArdMatern52, HyperParameters};
use super::likelihood::{Likelihood, Prior};
use super::{CovariancesWith, Dataset, Noise, Posterior, Surrogate};
use crate::Error;

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
    kernel: ArdMatern52,
    /// Of the covariance of the data, noise included.
    factor: Factor,
    /// L⁻¹ y with L the factor: the mean at a point is L⁻¹ k · L⁻¹ y, with k its prior covariances with the data.
    whitened: Vec<f64>,
    /// friedrich's, made when first needed: proposals do without.
    process: OnceLock<GaussianProcess<ArdMatern52, ConstantPrior>>,
}

impl FriedrichSurrogate {
    /// Like [`Surrogate::fit`] with bounds on the hyper-parameters but no priors, as scikit-optimize has it.
    pub(crate) fn fit_without_priors(
        data: Dataset,
        previous: Option<&HyperParameters>,
    ) -> Result<Self, Error> {
        Self::fit_with(data, previous, ALL_STARTS, Prior::Bounds)
    }

    fn fit_with(
        data: Dataset,
        previous: Option<&HyperParameters>,
        turns: Range<usize>,
        prior: Prior,
    ) -> Result<Self, Error> {
        data.check()?;
        let found = fit::fit(&Likelihood::new(&data, prior), previous, turns);
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
        let covariance = covariance_rows(&kernel, &data, &hyper, 0);
        // friedrich panics on a matrix it cannot factor: try it here first.
        let (factor, jitter) = Factor::with_jitter(&covariance, hyper.amplitude).ok_or_else(|| {
            Error::Surrogate("the covariance of the evaluated points cannot be factored".to_owned())
        })?;
        Ok(Self::from_factor(data, hyper, kernel, factor, jitter))
    }

    /// The posterior for these hyper-parameters and other data, of which the first `keep` have the points and the noise of these:
    /// the same bits as anew.
    fn with_data(&self, data: Dataset, keep: usize) -> Result<Self, Error> {
        if self.jitter == 0.0 {
            let others = covariance_rows(&self.kernel, &data, &self.hyper, keep);
            if let Some(factor) = self.factor.grown(keep, &others) {
                data.check()?;
                return Ok(Self::from_factor(data, self.hyper.clone(), self.kernel.clone(), factor, 0.0));
            }
        }
        Self::with_hyper_parameters(data, self.hyper.clone())
    }

    fn from_factor(
        data: Dataset,
        hyper: HyperParameters,
        kernel: ArdMatern52,
        factor: Factor,
        jitter: f64,
    ) -> Self {
        let mut whitened = data.values.clone();
        factor.solve_lower(&mut whitened);
        FriedrichSurrogate { data, hyper, jitter, kernel, factor, whitened, process: OnceLock::new() }
    }

    fn process(&self) -> &GaussianProcess<ArdMatern52, ConstantPrior> {
        self.process.get_or_init(|| {
            let rows = ArdMatern52::training_rows(&self.data.points, |i| self.noise(i));
            let values = DVector::from_column_slice(&self.data.values);
            let (prior, kernel) = (ConstantPrior::new(0.0), self.kernel.clone());
            // Noise is in the rows, by point; friedrich's own, a standard deviation common to all, stays zero.
            GaussianProcess::new(prior, kernel, 0.0, Some(CHOLESKY_EPSILON), rows, values)
        })
    }

    /// Variance on the diagonal of the covariance of the data besides the amplitude.
    fn noise(&self, i: usize) -> f64 {
        noise_of(&self.data, &self.hyper, i) + self.jitter
    }

    /// Beliefs at `points`, [`LANES`] at a time, each time with L⁻¹ k of every one, side by side.
    fn in_lanes(&self, points: &[Vec<f64>], mut take: impl FnMut(&[Posterior], &[Lanes])) {
        let mut lanes = vec![[0.0; LANES]; self.data.points.len()];
        let origin = points.first().map_or(0.0, |point| self.kernel.covariance(point, point));
        for chunk in points.chunks(LANES) {
            let places = ArdMatern52::side_by_side(chunk);
            self.kernel.covariances(&self.data.points, &places, &mut lanes);
            self.factor.solve_lower_lanes(0, &mut lanes);
            let (mut means, mut explained) = ([0.0; LANES], [0.0; LANES]);
            for (row, value) in lanes.iter().zip(&self.whitened) {
                for lane in 0..LANES {
                    means[lane] += row[lane] * value;
                    explained[lane] += row[lane] * row[lane];
                }
            }
            let belief =
                |lane: usize| Posterior { mean: means[lane], variance: (origin - explained[lane]).max(0.0) };
            let posteriors: [Posterior; LANES] = std::array::from_fn(belief);
            take(&posteriors[..chunk.len()], &lanes);
        }
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

/// Variance of the noise of datum `i`, no less than the floor.
fn noise_of(data: &Dataset, hyper: &HyperParameters, i: usize) -> f64 {
    data.noise_variance(i, hyper.noise).max(NOISE_FLOOR * hyper.amplitude)
}

/// Covariance of the data, noise included, from row `first` on: rows of the lower triangle.
fn covariance_rows(kernel: &ArdMatern52, data: &Dataset, hyper: &HyperParameters, first: usize) -> Vec<f64> {
    let (n, points) = (data.points.len(), &data.points);
    let mut lanes = vec![[0.0; LANES]; n];
    let mut rows = Vec::with_capacity(n * (n + 1) / 2);
    for block in (first..n).step_by(LANES) {
        let end = n.min(block + LANES);
        kernel.covariances(&points[..end], &ArdMatern52::side_by_side(&points[block..end]), &mut lanes);
        for i in block..end {
            rows.extend(lanes[..=i].iter().map(|lanes| lanes[i - block]));
            let last = rows.len() - 1;
            rows[last] += noise_of(data, hyper, i);
        }
    }
    rows
}

impl Surrogate for FriedrichSurrogate {
    fn fit(data: Dataset, previous: Option<&HyperParameters>, turns: Range<usize>) -> Result<Self, Error> {
        Self::fit_with(data, previous, turns, Prior::LogNormal)
    }

    fn posterior(&self, points: &[Vec<f64>]) -> Vec<Posterior> {
        if points.is_empty() {
            return Vec::new();
        }
        let (means, variances) = self.process().predict_mean_variance(&ArdMatern52::query_rows(points));
        let both = means.iter().zip(variances.iter());
        // Rounding can take a variance at an evaluated point just below zero.
        both.map(|(&mean, &variance)| Posterior { mean, variance: variance.max(0.0) }).collect()
    }

    fn scan(&self, points: &[Vec<f64>]) -> Vec<Posterior> {
        let mut posteriors = Vec::with_capacity(points.len());
        self.in_lanes(points, |posterior, _| posteriors.extend_from_slice(posterior));
        posteriors
    }

    fn covariances_with(&self, data: &[usize]) -> CovariancesWith {
        // With K' = K + N, k_i is column i of K' − N, so cov(f(x), f_i | y) = k(x, x_i) − kᵀ K'⁻¹ k_i = N_ii (K'⁻¹ k)_i, which is
        // N_ii times column i of L⁻¹ times L⁻¹ k.
        let blocks = data.chunks(LANES).map(|chunk| {
            let mut columns = self.factor.columns_of_inverse(chunk);
            for lanes in &mut columns {
                lanes.iter_mut().zip(chunk).for_each(|(entry, i)| *entry *= self.noise(*i));
            }
            (chunk[0], columns)
        });
        CovariancesWith { count: data.len(), blocks: blocks.collect() }
    }

    fn scan_with_covariances(
        &self,
        points: &[Vec<f64>],
        with: &CovariancesWith,
        mut visit: impl FnMut(Posterior, &[f64]),
    ) {
        let mut all = vec![[0.0; LANES]; with.blocks.len() * LANES];
        let mut covariances = vec![0.0; with.count];
        self.in_lanes(points, |posteriors, lanes| {
            for (block, (first, columns)) in with.blocks.iter().enumerate() {
                let count = LANES.min(with.count - block * LANES);
                all[block * LANES..][..LANES].copy_from_slice(&products(columns, count, &lanes[*first..]));
            }
            for (lane, posterior) in posteriors.iter().enumerate() {
                covariances.iter_mut().zip(&all).for_each(|(covariance, lanes)| *covariance = lanes[lane]);
                visit(*posterior, &covariances);
            }
        });
    }

    fn sample(&self, points: &[Vec<f64>], normals: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, Error> {
        let n = points.len();
        if n == 0 {
            return Ok(vec![Vec::new(); normals.len()]);
        }
        // friedrich's own sampler panics on close points; its joint covariance is sound.
        let rows = ArdMatern52::query_rows(points);
        let means = self.process().predict(&rows);
        let covariance = self.process().predict_covariance(&rows);
        let triangle: Vec<f64> =
            (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|place| covariance[place]).collect();
        let (factor, _) = Factor::with_jitter(&triangle, self.hyper.amplitude).ok_or_else(|| {
            Error::Surrogate("the joint covariance of the points to sample cannot be factored".to_owned())
        })?;
        let draw = |normal: &Vec<f64>| (0..n).map(|i| means[i] + dot(factor.row(i), &normal[..=i])).collect();
        Ok(normals.iter().map(draw).collect())
    }

    fn condition(&self, point: Vec<f64>, value: f64, noise: Noise) -> Result<Self, Error> {
        let mut data = self.data.clone();
        let known = data.points.iter().position(|known| *known == point);
        match known {
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
        // friedrich's `add_samples` panics on near duplicates.
        self.with_data(data, known.unwrap_or(self.data.points.len()))
    }

    fn hyper_parameters(&self) -> &HyperParameters {
        &self.hyper
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    use super::*;

    const ONCE: Noise = Noise { shared: 1.0, known: 0.0 };

    fn data(points: &[f64], values: &[f64]) -> Dataset {
        Dataset {
            points: points.iter().map(|&x| vec![x]).collect(),
            values: values.to_vec(),
            noise: vec![ONCE; points.len()],
            categorical: vec![false],
        }
    }

    fn hyper() -> HyperParameters {
        HyperParameters { length_scales: vec![0.3], amplitude: 1.5, noise: 0.04 }
    }

    fn wave(n: usize) -> Dataset {
        let points: Vec<f64> = (0..n).map(|i| i as f64 / n as f64).collect();
        let values: Vec<f64> = points.iter().map(|x| (6.0 * x).sin()).collect();
        data(&points, &values)
    }

    #[test]
    fn trap_noise_is_per_point_and_predictions_are_of_the_latent_function() {
        let mut data = wave(9);
        data.noise[3] = Noise { shared: 0.25, known: 0.5 };
        let kernel = ArdMatern52::new(&hyper(), &data.categorical);
        let covariance = DMatrix::from_fn(9, 9, |i, j| {
            kernel.covariance(&data.points[i], &data.points[j])
                + if i == j { data.noise_variance(i, 0.04) } else { 0.0 }
        });
        let at = vec![0.37];
        let k = DVector::from_fn(9, |i, _| kernel.covariance(&data.points[i], &at));
        let solved = covariance.cholesky().unwrap().solve(&k);
        let mean = solved.dot(&DVector::from_column_slice(&data.values));
        let variance = 1.5 - solved.dot(&k);
        let got = FriedrichSurrogate::with_hyper_parameters(data, hyper()).unwrap().posterior(&[at])[0];
        assert!((got.mean - mean).abs() < 1e-10 && (got.variance - variance).abs() < 1e-10, "{got:?}");
    }

    #[test]
    fn trap_what_panics_in_friedrich_is_handled() {
        // Constant outputs, one point, and points so close that the covariance is singular to working precision.
        for data in
            [data(&[0.1, 0.5, 0.9], &[0.0; 3]), data(&[0.4], &[0.0]), data(&[0.5, 0.5 + 1e-16], &[0.0, 0.0])]
        {
            if data.points.len() == 2 && data.points[0] == data.points[1] {
                assert!(FriedrichSurrogate::fit(data, None, 0..0).is_err());
                continue;
            }
            let model = FriedrichSurrogate::fit(data, None, 0..0).unwrap();
            let posterior = model.posterior(&[vec![0.2]])[0];
            assert!(posterior.mean.abs() < 1e-9 && posterior.variance >= 0.0, "{posterior:?}");
        }
        // Numbers that are not finite, duplicates that were not merged, nothing at all.
        for data in [data(&[0.1, 0.2], &[0.0, f64::NAN]), data(&[0.1, 0.1], &[0.0, 1.0]), data(&[], &[])] {
            assert!(matches!(FriedrichSurrogate::fit(data, None, 0..0), Err(Error::Surrogate(_))));
        }
        // A noise-free fit to steps of 1e-9: jitter, not a panic.
        let close: Vec<f64> = (0..40).map(|i| 0.5 + 1e-9 * f64::from(i)).collect();
        let exact = HyperParameters { noise: 1e-12, ..hyper() };
        let model = FriedrichSurrogate::with_hyper_parameters(data(&close, &[1.0; 40]), exact).unwrap();
        assert!(model.posterior(&[vec![0.5]])[0].variance >= 0.0);
    }

    #[test]
    fn trap_sampling_and_conditioning_at_close_points() {
        let model = FriedrichSurrogate::with_hyper_parameters(wave(12), hyper()).unwrap();
        let close: Vec<Vec<f64>> = (0..200).map(|i| vec![0.3 + 1e-7 * f64::from(i)]).collect();
        let normals = [vec![1.0; 200], vec![-1.0; 200]];
        let draws = model.sample(&close, &normals).unwrap();
        let mean = model.posterior(&close[..1])[0].mean;
        assert!((0.5 * (draws[0][0] + draws[1][0]) - mean).abs() < 1e-9);
        // Near and exact duplicates, which make friedrich's `add_samples` panic.
        let again = model.condition(vec![1.0 / 12.0 + 1e-13], 0.4, ONCE).unwrap();
        let again = again.condition(vec![1.0 / 12.0], 0.4, ONCE).unwrap();
        assert_eq!(again.data().points.len(), 13);
        let narrower = again.posterior(&[vec![1.0 / 12.0]])[0].variance;
        assert!(narrower < model.posterior(&[vec![1.0 / 12.0]])[0].variance);
    }

    #[test]
    fn trap_the_fit_is_ours_and_no_clock_stops_it() {
        let fitted = || FriedrichSurrogate::fit(wave(30), None, 0..0).unwrap();
        assert_eq!(fitted().hyper_parameters(), fitted().hyper_parameters());
        let at: Vec<Vec<f64>> = (0..50).map(|i| vec![f64::from(i) / 50.0]).collect();
        assert_eq!(fitted().posterior(&at), fitted().posterior(&at));
    }

    #[test]
    fn scanning_many_candidates_believes_what_friedrich_does() {
        let mut data = wave(23);
        data.noise[3] = Noise { shared: 0.25, known: 0.5 };
        let model = FriedrichSurrogate::with_hyper_parameters(data, hyper()).unwrap();
        let at: Vec<Vec<f64>> = (0..29).map(|i| vec![f64::from(i) / 28.0]).collect();
        let (scanned, posterior) = (model.scan(&at), model.posterior(&at));
        assert_eq!(scanned.len(), at.len());
        for (a, b) in scanned.iter().zip(posterior) {
            assert!(
                (a.mean - b.mean).abs() < 1e-10 && (a.variance - b.variance).abs() < 1e-10,
                "{a:?} {b:?}"
            );
        }
        assert!(model.scan(&[]).is_empty());
        // Covariances with some of the data, against friedrich's joint covariance.
        let some: Vec<usize> = (0..23).filter(|i| i % 2 == 1).collect();
        let mut index = 0;
        model.scan_with_covariances(&at, &model.covariances_with(&some), |posterior, covariances| {
            assert_eq!(posterior, scanned[index]);
            let mut rows = vec![at[index].clone()];
            rows.extend(some.iter().map(|i| model.data().points[*i].clone()));
            let joint = model.process().predict_covariance(&ArdMatern52::query_rows(&rows));
            assert_eq!(covariances.len(), some.len());
            for (i, covariance) in covariances.iter().enumerate() {
                assert!((covariance - joint[(0, i + 1)]).abs() < 1e-10, "{index} {i}");
            }
            index += 1;
        });
        assert_eq!(index, at.len());
    }

    /// Data that surrogates have trouble with: near and exact duplicates, no noise, equal values, choices.
    fn difficult() -> impl Strategy<Value = (Dataset, HyperParameters)> {
        let coordinate = prop_oneof![0.0..1.0f64, Just(0.5), Just(0.5 + 1e-9), Just(0.5 + 1e-15)];
        let point = (coordinate, prop_oneof![Just(0.25), Just(0.75)]).prop_map(|(x, kind)| vec![x, kind]);
        let value = prop_oneof![-3.0..3.0f64, Just(1.0)];
        let noise = prop_oneof![
            Just(ONCE),
            Just(Noise { shared: 0.0, known: 0.0 }),
            Just(Noise { shared: 0.25, known: 0.1 })
        ];
        let data = prop::collection::vec((point, value, noise), 1..40).prop_map(|all| {
            let mut data =
                Dataset { points: vec![], values: vec![], noise: vec![], categorical: vec![false, true] };
            for (point, value, noise) in all {
                if !data.points.contains(&point) {
                    data.points.push(point);
                    data.values.push(value);
                    data.noise.push(noise);
                }
            }
            data
        });
        let hyper = (0.005..100.0f64, 0.005..100.0f64, 1e-3..1e3f64, prop_oneof![Just(1e-6), 1e-6..1.0f64]);
        let hyper = hyper.prop_map(|(one, other, amplitude, noise)| HyperParameters {
            length_scales: vec![one, other],
            amplitude,
            noise,
        });
        (data, hyper)
    }

    proptest! {
        #[test]
        fn a_conditioned_surrogate_believes_what_a_new_one_does((data, hyper) in difficult()) {
            let first = Dataset {
                points: data.points[..1].to_vec(),
                values: data.values[..1].to_vec(),
                noise: data.noise[..1].to_vec(),
                categorical: data.categorical.clone(),
            };
            let Ok(mut grown) = FriedrichSurrogate::with_hyper_parameters(first, hyper.clone()) else {
                return Ok(());
            };
            for i in 1..data.points.len() {
                let point = data.points[i].clone();
                match grown.condition(point, data.values[i], data.noise[i]) {
                    Ok(next) => grown = next,
                    Err(_) => {
                        prop_assert!(FriedrichSurrogate::with_hyper_parameters(data, hyper).is_err());
                        return Ok(());
                    }
                }
            }
            let anew = FriedrichSurrogate::with_hyper_parameters(data.clone(), hyper).unwrap();
            let at = vec![vec![0.3, 0.25], vec![0.5, 0.75], vec![0.5 + 2e-9, 0.25]];
            prop_assert_eq!(grown.jitter(), anew.jitter());
            prop_assert_eq!(grown.scan(&at), anew.scan(&at));
            // A place seen again: its row and those after it are new.
            let again = data.points.len() / 2;
            let seen = |model: FriedrichSurrogate| model.condition(data.points[again].clone(), 0.5, ONCE);
            if let (Ok(grown), Ok(anew)) = (seen(grown), seen(anew)) {
                let data = grown.data().clone();
                prop_assert_eq!(grown.scan(&at), anew.scan(&at));
                let anew = FriedrichSurrogate::with_hyper_parameters(data, grown.hyper.clone()).unwrap();
                prop_assert_eq!(grown.scan(&at), anew.scan(&at));
            }
        }

        #[test]
        fn candidates_at_once_are_believed_as_one_by_one(
            (data, hyper) in difficult(),
            candidates in prop::collection::vec((0.0..=1.0f64, prop_oneof![Just(0.25), Just(0.75)]), 1..20),
        ) {
            let Ok(model) = FriedrichSurrogate::with_hyper_parameters(data.clone(), hyper) else { return Ok(()) };
            let candidates: Vec<Vec<f64>> = candidates.into_iter().map(|(x, kind)| vec![x, kind]).collect();
            let one_by_one: Vec<Posterior> =
                candidates.iter().flat_map(|one| model.scan(std::slice::from_ref(one))).collect();
            prop_assert_eq!(&model.scan(&candidates), &one_by_one);
            let mut lanes = vec![[0.0; LANES]; data.points.len()];
            let first = &candidates[..candidates.len().min(LANES)];
            model.kernel.covariances(&data.points, &ArdMatern52::side_by_side(first), &mut lanes);
            for (known, lanes) in data.points.iter().zip(&lanes) {
                for (candidate, covariance) in first.iter().zip(lanes) {
                    prop_assert_eq!(model.kernel.covariance(known, candidate), *covariance);
                }
            }
            // Covariances with some of the data do not depend on which others are asked for.
            let all: Vec<usize> = (0..data.points.len()).collect();
            let some: Vec<usize> = all.iter().copied().filter(|i| i % 3 != 1).collect();
            let covariances = |with: &[usize]| {
                let mut found = Vec::new();
                model.scan_with_covariances(&candidates, &model.covariances_with(with), |_, one| found.push(one.to_vec()));
                found
            };
            for (all, some_of_them) in covariances(&all).iter().zip(covariances(&some)) {
                for (place, i) in some.iter().enumerate() {
                    prop_assert!((all[*i] - some_of_them[place]).abs() <= 1e-9 * model.hyper.amplitude);
                }
            }
        }
    }
}
