//! The covariance: a Matérn 5/2 kernel with one length scale per dimension, as friedrich's kernel trait wants it.
//!
//! friedrich's own kernels are isotropic and its Matérn 5/2 has a wrong length-scale gradient, hence ours. friedrich also has a
//! single noise for all points; ours differs by point (repetitions, merged duplicates), so each row given to friedrich carries
//! two more numbers after its coordinates: the variance of its noise and an identifier. The kernel adds the noise where a row
//! meets itself. Rows to predict at carry zeros, and the prediction is of the latent function.

use friedrich::kernel::Kernel;
use friedrich::{SRowVector, SVector};
use nalgebra::storage::Storage;
use nalgebra::{DMatrix, Dyn, U1};
use numbers::lanes::exp;
use serde::{Deserialize, Serialize};

use super::dense::{LANES, Lanes};
use super::widest::widest;

/// Hyper-parameters of the surrogate for standardised outputs and unit inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HyperParameters {
    /// Length scale of each dimension, in units of its range (of a categorical one: of the distance 1 between two choices).
    pub length_scales: Vec<f64>,
    /// Prior variance of the latent function.
    pub amplitude: f64,
    /// Variance of the noise of one evaluation.
    pub noise: f64,
}

impl HyperParameters {
    /// Their natural logarithms: length scales, amplitude, noise.
    pub(super) fn to_logarithms(&self) -> Vec<f64> {
        let all = self.length_scales.iter().chain([&self.amplitude, &self.noise]);
        all.map(|&parameter| libm::log(parameter)).collect()
    }

    /// From natural logarithms in the order of [`HyperParameters::to_logarithms`].
    pub(super) fn from_logarithms(logarithms: &[f64]) -> Self {
        let (length_scales, rest) = logarithms.split_at(logarithms.len() - 2);
        HyperParameters {
            length_scales: length_scales.iter().map(|&l| libm::exp(l)).collect(),
            amplitude: libm::exp(rest[0]),
            noise: libm::exp(rest[1]),
        }
    }
}

/// k(r) = a (1 + √5 r + 5r²/3) exp(−√5 r), r² = Σ δ²/l² (Rasmussen and Williams 2006, eq. 4.17).
///
/// δ is the difference of two coordinates; of a categorical dimension 0 for equal choices and 1 for different ones, which is
/// the distance of one-hot encodings.
#[derive(Debug, Clone, Default)]
pub(super) struct ArdMatern52 {
    length_scales: Vec<f64>,
    inverse_squares: Vec<f64>,
    categorical: Vec<bool>,
    amplitude: f64,
}

/// The kernel's value and −∂k/∂(r²)·2 for amplitude 1, from r².
///
/// The second is (5/3)(1 + √5 r) exp(−√5 r): multiplied by δ²/l² it is the derivative by the logarithm of a length scale.
#[inline(always)]
fn matern52(squared: f64) -> (f64, f64) {
    let s = (5.0 * squared).sqrt();
    // What is farther away has no covariance: 1e-304 of the amplitude.
    let decay = exp((-s).max(-700.0));
    ((1.0 + s + s * s * (1.0 / 3.0)) * decay, 5.0 / 3.0 * (1.0 + s) * decay)
}

widest! {
    /// Puts the kernel of each r² in its place, and its slope in `slopes`: see [`matern52`].
    pub(super) fn matern52_in_place(squares: &mut [f64], slopes: &mut [f64]) {
        let (mut squares, mut slopes) = (squares.chunks_exact_mut(LANES), slopes.chunks_exact_mut(LANES));
        for (squares, slopes) in (&mut squares).zip(&mut slopes) {
            for lane in 0..LANES {
                (squares[lane], slopes[lane]) = matern52(squares[lane]);
            }
        }
        for (square, slope) in squares.into_remainder().iter_mut().zip(slopes.into_remainder()) {
            (*square, *slope) = matern52(*square);
        }
    }
}

widest! {
    fn covariances(kernel: &ArdMatern52, points: &[Vec<f64>], places: &[Lanes], into: &mut [Lanes]) {
        let amplitude = kernel.amplitude.abs();
        for (point, into) in points.iter().zip(into) {
            let mut squares = [0.0; LANES];
            for (i, places) in places.iter().enumerate() {
                let (own, inverse_square) = (point[i], kernel.inverse_squares[i]);
                if kernel.categorical[i] {
                    for lane in 0..LANES {
                        squares[lane] += inverse_square * squared_difference(own, places[lane], true);
                    }
                } else {
                    for lane in 0..LANES {
                        squares[lane] += inverse_square * squared_difference(own, places[lane], false);
                    }
                }
            }
            for lane in 0..LANES {
                into[lane] = amplitude * matern52(squares[lane]).0;
            }
        }
    }
}

impl ArdMatern52 {
    /// The kernel with these hyper-parameters; `categorical` says which dimensions hold choices.
    pub fn new(hyper: &HyperParameters, categorical: &[bool]) -> Self {
        let mut kernel = ArdMatern52 { categorical: categorical.to_vec(), ..Default::default() };
        kernel.set(hyper.length_scales.clone(), hyper.amplitude);
        kernel
    }

    fn set(&mut self, length_scales: Vec<f64>, amplitude: f64) {
        self.inverse_squares = length_scales.iter().map(|l| 1.0 / (l * l)).collect();
        self.length_scales = length_scales;
        self.amplitude = amplitude;
    }

    /// Prior covariance of the latent function at two points.
    pub fn covariance(&self, a: &[f64], b: &[f64]) -> f64 {
        let squared: f64 = (0..self.inverse_squares.len())
            .map(|i| self.inverse_squares[i] * squared_difference(a[i], b[i], self.categorical[i]))
            .sum();
        self.amplitude.abs() * matern52(squared).0
    }

    /// The prior covariances of each of `points` with [`LANES`] places, whose coordinates lie side by side: the same bits as one by one.
    pub fn covariances(&self, points: &[Vec<f64>], places: &[Lanes], into: &mut [Lanes]) {
        covariances(self, points, places, into);
    }

    /// Coordinates of up to [`LANES`] points, side by side; the first one's take the places that are left.
    pub fn side_by_side(points: &[Vec<f64>]) -> Vec<Lanes> {
        let lane_of = |lane: usize| if lane < points.len() { lane } else { 0 };
        (0..points[0].len()).map(|i| std::array::from_fn(|lane| points[lane_of(lane)][i])).collect()
    }

    /// Rows for friedrich: coordinates, noise variance, identifier (from 1).
    pub fn training_rows(points: &[Vec<f64>], noise: impl Fn(usize) -> f64) -> DMatrix<f64> {
        let d = points.first().map_or(0, Vec::len);
        DMatrix::from_fn(points.len(), d + 2, |row, column| match column {
            c if c < d => points[row][c],
            c if c == d => noise(row),
            _ => row as f64 + 1.0,
        })
    }

    /// Rows for friedrich to predict at: coordinates and two zeros.
    pub fn query_rows(points: &[Vec<f64>]) -> DMatrix<f64> {
        let d = points.first().map_or(0, Vec::len);
        DMatrix::from_fn(
            points.len(),
            d + 2,
            |row, column| if column < d { points[row][column] } else { 0.0 },
        )
    }
}

/// Squared difference of two coordinates: 0 or 1 between choices.
#[inline(always)]
pub(super) fn squared_difference(a: f64, b: f64, categorical: bool) -> f64 {
    if categorical { f64::from(a != b) } else { (a - b) * (a - b) }
}

impl Kernel for ArdMatern52 {
    fn nb_parameters(&self) -> usize {
        self.length_scales.len() + 1
    }

    // With `false`, friedrich would step the logarithm of a noise below 1 in the wrong direction.
    fn is_scalable(&self) -> bool {
        true
    }

    fn rescale(&mut self, scale: f64) {
        self.amplitude *= scale;
    }

    fn kernel<S1: Storage<f64, U1, Dyn>, S2: Storage<f64, U1, Dyn>>(
        &self,
        x1: &SRowVector<S1>,
        x2: &SRowVector<S2>,
    ) -> f64 {
        let d = self.inverse_squares.len();
        let mut squared = 0.0;
        for i in 0..d {
            squared += self.inverse_squares[i] * squared_difference(x1[i], x2[i], self.categorical[i]);
        }
        let same_row = x1[d + 1] > 0.0 && x1[d + 1] == x2[d + 1];
        let noise = if same_row { x1[d] } else { 0.0 };
        self.amplitude.abs() * matern52(squared).0 + noise
    }

    fn gradient<S1: Storage<f64, U1, Dyn>, S2: Storage<f64, U1, Dyn>>(
        &self,
        x1: &SRowVector<S1>,
        x2: &SRowVector<S2>,
    ) -> Vec<f64> {
        let scaled: Vec<f64> = (0..self.inverse_squares.len())
            .map(|i| self.inverse_squares[i] * squared_difference(x1[i], x2[i], self.categorical[i]))
            .collect();
        let (value, slope) = matern52(scaled.iter().sum());
        let by_length_scale = scaled.iter().zip(&self.length_scales);
        let mut gradient: Vec<f64> =
            by_length_scale.map(|(scaled, l)| self.amplitude.abs() * slope * scaled / l).collect();
        gradient.push(self.amplitude.signum() * value);
        gradient
    }

    fn get_parameters(&self) -> Vec<f64> {
        self.length_scales.iter().copied().chain([self.amplitude]).collect()
    }

    fn set_parameters(&mut self, parameters: &[f64]) {
        let d = self.length_scales.len();
        self.set(parameters[..d].to_vec(), parameters[d]);
    }

    // Hyper-parameters come from our own exact likelihood; friedrich's quick guess is not wanted.
    fn heuristic_fit<SM: Storage<f64, Dyn, Dyn>, SV: Storage<f64, Dyn, U1>>(
        &mut self,
        _inputs: &friedrich::SMatrix<SM>,
        _outputs: &SVector<SV>,
    ) {
    }
}

#[cfg(test)]
mod tests {
    use friedrich::kernel::Matern2;
    use nalgebra::RowDVector;

    use super::*;

    fn kernel() -> ArdMatern52 {
        let hyper = HyperParameters { length_scales: vec![0.3, 2.0, 0.7], amplitude: 1.7, noise: 0.1 };
        ArdMatern52::new(&hyper, &[false, false, true])
    }

    fn rows() -> [RowDVector<f64>; 3] {
        [
            RowDVector::from_vec(vec![0.1, 0.9, 0.25, 0.5, 1.0]),
            RowDVector::from_vec(vec![0.4, 0.2, 0.75, 0.5, 2.0]),
            RowDVector::from_vec(vec![0.1, 0.3, 0.25, 0.5, 3.0]),
        ]
    }

    /// Largest difference between a kernel's gradient and central differences, over pairs of rows.
    fn gradient_error<K: Kernel>(mut kernel: K, rows: &[RowDVector<f64>]) -> f64 {
        let parameters = kernel.get_parameters();
        let mut worst: f64 = 0.0;
        for (a, b) in rows.iter().flat_map(|a| rows.iter().map(move |b| (a, b))) {
            kernel.set_parameters(&parameters);
            let analytic = kernel.gradient(a, b);
            for (i, analytic) in analytic.iter().enumerate() {
                let mut at = |step: f64| {
                    let mut moved = parameters.clone();
                    moved[i] += step;
                    kernel.set_parameters(&moved);
                    kernel.kernel(a, b)
                };
                worst = worst.max((analytic - (at(1e-6) - at(-1e-6)) / 2e-6).abs());
            }
        }
        worst
    }

    #[test]
    fn trap_length_scale_gradient_is_ours_and_right() {
        assert!(gradient_error(kernel(), &rows()) < 1e-7);
        // The trap itself: once friedrich mends it, this line fails and the note in the module can go.
        assert!(gradient_error(Matern2::new(0.3, 1.7), &rows()) > 0.1);
    }

    #[test]
    fn trap_kernel_is_scalable_and_has_one_length_scale_a_dimension() {
        let mut kernel = kernel();
        assert!(kernel.is_scalable());
        assert_eq!(kernel.nb_parameters(), 4);
        let [a, b, _] = rows();
        let before = kernel.kernel(&a, &b);
        kernel.rescale(2.0);
        assert_eq!(kernel.kernel(&a, &b), 2.0 * before);
    }

    #[test]
    fn noise_is_added_where_a_row_meets_itself_only() {
        let kernel = kernel();
        let [a, _, _] = rows();
        let twin = RowDVector::from_vec(vec![0.1, 0.9, 0.25, 0.5, 4.0]);
        let query = RowDVector::from_vec(vec![0.1, 0.9, 0.25, 0.0, 0.0]);
        assert!((kernel.kernel(&a, &a) - 2.2).abs() < 1e-12);
        assert!((kernel.kernel(&a, &twin) - 1.7).abs() < 1e-12);
        assert!((kernel.kernel(&query, &query) - 1.7).abs() < 1e-12);
        assert!((kernel.covariance(&[0.1, 0.9, 0.25], &[0.1, 0.9, 0.25]) - 1.7).abs() < 1e-12);
    }
}
