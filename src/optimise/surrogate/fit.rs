//! Hyper-parameters by maximising the exact posterior density from several starts, with bounded iterations: no clock, no chance.

use std::ops::Range;

use super::kernel::HyperParameters;
use super::likelihood::{Evaluation, Likelihood};

/// Length scales to start from, times √d. One start alone loses the best basin of the Gramacy function in most runs.
const LENGTH_SCALE_STARTS: [f64; 3] = [0.05, 0.2, 0.8];
/// Iterations from each start.
const ITERATIONS: usize = 30;
/// Largest change of a logarithm in one iteration.
const LARGEST_STEP: f64 = 1.5;
/// A gradient this small (nats per unit of a logarithm) counts as converged.
const GRADIENT_TOLERANCE: f64 = 1e-2;

/// An ascent that comes so near another one's end in all logarithms, and is no higher, will end there, too.
const NEAR: f64 = 0.1;

/// The turn of every start.
pub(crate) const ALL_STARTS: Range<usize> = 0..LENGTH_SCALE_STARTS.len();

/// A quasi-Newton ascent (BFGS with backtracking inside box bounds), one iteration at a time.
struct Ascent<'a> {
    likelihood: &'a Likelihood<'a>,
    bounds: &'a [(f64, f64)],
    place: Vec<f64>,
    value: f64,
    gradient: Vec<f64>,
    /// Approximate inverse of the negative Hessian, row-major.
    curvature: Vec<f64>,
    fresh: bool,
    converged: bool,
}

impl<'a> Ascent<'a> {
    fn new(likelihood: &'a Likelihood<'a>, bounds: &'a [(f64, f64)], start: &[f64]) -> Option<Self> {
        let place = clamped(start, bounds);
        let evaluation = likelihood.evaluate(&place)?;
        let gradient = likelihood.gradient(&evaluation, &place);
        let curvature = identity(place.len());
        let value = evaluation.value;
        Some(Ascent { likelihood, bounds, place, value, gradient, curvature, fresh: true, converged: false })
    }

    /// Coordinates at a bound that the gradient pushes against.
    fn is_held(&self, i: usize) -> bool {
        let (low, high) = self.bounds[i];
        (self.place[i] <= low && self.gradient[i] < 0.0) || (self.place[i] >= high && self.gradient[i] > 0.0)
    }

    fn direction(&self) -> Vec<f64> {
        let n = self.place.len();
        let free: Vec<f64> = (0..n).map(|i| if self.is_held(i) { 0.0 } else { self.gradient[i] }).collect();
        let mut direction: Vec<f64> = (0..n)
            .map(|i| {
                let row = &self.curvature[i * n..(i + 1) * n];
                if self.is_held(i) { 0.0 } else { row.iter().zip(&free).map(|(h, g)| h * g).sum() }
            })
            .collect();
        let longest = direction.iter().fold(0.0f64, |longest, step| longest.max(step.abs()));
        if longest > LARGEST_STEP {
            direction.iter_mut().for_each(|step| *step *= LARGEST_STEP / longest);
        }
        direction
    }

    fn step(&mut self) {
        let n = self.place.len();
        if (0..n).all(|i| self.is_held(i) || self.gradient[i].abs() < GRADIENT_TOLERANCE) {
            self.converged = true;
            return;
        }
        let direction = self.direction();
        match self.backtrack(&direction) {
            Some((place, evaluation)) => {
                let gradient = self.likelihood.gradient(&evaluation, &place);
                self.update_curvature(&place, &gradient);
                self.converged = evaluation.value - self.value < 1e-6;
                (self.place, self.value, self.gradient) = (place, evaluation.value, gradient);
            }
            // The quadratic model was bad: start it anew once, then give up.
            None if !self.fresh => {
                self.curvature = identity(n);
                self.fresh = true;
            }
            None => self.converged = true,
        }
    }

    fn backtrack(&self, direction: &[f64]) -> Option<(Vec<f64>, Evaluation)> {
        let mut length = 1.0;
        for _ in 0..8 {
            let moved: Vec<f64> =
                self.place.iter().zip(direction).map(|(x, step)| x + length * step).collect();
            let moved = clamped(&moved, self.bounds);
            let expected: f64 =
                moved.iter().zip(&self.place).zip(&self.gradient).map(|((a, b), g)| (a - b) * g).sum();
            if expected > 0.0
                && let Some(evaluation) = self.likelihood.evaluate(&moved)
                && evaluation.value >= self.value + 1e-4 * expected
            {
                return Some((moved, evaluation));
            }
            length *= 0.4;
        }
        None
    }

    /// The BFGS update of the inverse Hessian of the negative log density.
    fn update_curvature(&mut self, place: &[f64], gradient: &[f64]) {
        let n = place.len();
        let s: Vec<f64> = place.iter().zip(&self.place).map(|(a, b)| a - b).collect();
        let y: Vec<f64> = self.gradient.iter().zip(gradient).map(|(a, b)| a - b).collect();
        let sy: f64 = s.iter().zip(&y).map(|(s, y)| s * y).sum();
        if sy <= 1e-10 {
            return;
        }
        if self.fresh {
            // First scaling of the identity, Nocedal and Wright (2006), eq. 6.20.
            let yy: f64 = y.iter().map(|y| y * y).sum();
            (0..n).for_each(|i| self.curvature[i * n + i] = sy / yy);
            self.fresh = false;
        }
        let hy: Vec<f64> = (0..n).map(|i| (0..n).map(|j| self.curvature[i * n + j] * y[j]).sum()).collect();
        let yhy: f64 = y.iter().zip(&hy).map(|(y, hy)| y * hy).sum();
        for i in 0..n {
            for j in 0..n {
                self.curvature[i * n + j] +=
                    (1.0 + yhy / sy) * s[i] * s[j] / sy - (hy[i] * s[j] + s[i] * hy[j]) / sy;
            }
        }
    }

    /// Climbs to the top, or until it comes near one of `found` that is as high.
    fn climb(&mut self, found: &[Ascent<'_>]) {
        for _ in 0..ITERATIONS {
            if self.converged || found.iter().any(|other| self.is_below(other)) {
                break;
            }
            self.step();
        }
    }

    fn is_below(&self, other: &Ascent<'_>) -> bool {
        let is_near = self.place.iter().zip(&other.place).all(|(a, b)| (a - b).abs() < NEAR);
        is_near && self.value <= other.value
    }
}

fn identity(n: usize) -> Vec<f64> {
    // A first step of at most about one e-fold, whatever the size of the gradient: `direction` limits it.
    let mut matrix = vec![0.0; n * n];
    (0..n).for_each(|i| matrix[i * n + i] = 0.1);
    matrix
}

fn clamped(place: &[f64], bounds: &[(f64, f64)]) -> Vec<f64> {
    place.iter().zip(bounds).map(|(x, (low, high))| x.clamp(*low, *high)).collect()
}

/// The hyper-parameters of highest posterior density found from the previous ones and the starts whose turn it is, or else from all;
/// `None` when no start gives a positive definite covariance.
pub(crate) fn fit(
    likelihood: &Likelihood<'_>,
    previous: Option<&HyperParameters>,
    turns: Range<usize>,
) -> Option<HyperParameters> {
    let bounds = likelihood.bounds();
    let d = likelihood.parameters() - 2;
    let previous = previous.filter(|previous| previous.length_scales.len() == d);
    let mut starts: Vec<Vec<f64>> = previous.map(HyperParameters::to_logarithms).into_iter().collect();
    let turns = if previous.is_none() { ALL_STARTS } else { turns };
    let count = LENGTH_SCALE_STARTS.len();
    let is_turn = |start: usize| turns.len() >= count || turns.clone().any(|turn| turn % count == start);
    for (_, scale) in LENGTH_SCALE_STARTS.iter().enumerate().filter(|(start, _)| is_turn(*start)) {
        let mut start = vec![libm::log(scale * (d as f64).sqrt()); d];
        start.extend([0.0, libm::log(0.05)]);
        starts.push(start);
    }
    let mut found: Vec<Ascent<'_>> = Vec::new();
    for start in &starts {
        let Some(mut ascent) = Ascent::new(likelihood, &bounds, start) else { continue };
        ascent.climb(&found);
        found.push(ascent);
    }
    // Of equally high ones the first.
    let best = found.into_iter().reduce(|best, other| if other.value > best.value { other } else { best });
    Some(HyperParameters::from_logarithms(&best?.place))
}

#[cfg(test)]
mod tests {
    use super::super::likelihood::Prior;
    use super::super::{Dataset, Noise};
    use super::*;

    /// Two dimensions of which only the first matters, with alternating errors of ±0.1.
    fn data(n: usize) -> Dataset {
        let points: Vec<Vec<f64>> =
            (0..n).map(|i| vec![i as f64 / n as f64, (i as f64 * 0.618_034).fract()]).collect();
        let values =
            points.iter().enumerate().map(|(i, p)| (12.0 * p[0]).sin() + if i % 2 == 0 { 0.1 } else { -0.1 });
        let values = values.collect();
        let noise = vec![Noise { shared: 1.0, known: 0.0 }; n];
        Dataset { points, values, noise, categorical: vec![false, false] }
    }

    #[test]
    fn finds_the_scales_and_the_noise_and_repeats_to_the_bit() {
        let data = data(60);
        let likelihood = Likelihood::new(&data, Prior::LogNormal);
        let found = fit(&likelihood, None, ALL_STARTS).unwrap();
        assert!(found.length_scales[1] > 4.0 * found.length_scales[0], "{found:?}");
        assert!((0.005..0.02).contains(&found.noise), "{found:?}");
        assert_eq!(Some(&found), fit(&likelihood, None, ALL_STARTS).as_ref());
        // The gradient vanishes there.
        let place = found.to_logarithms();
        let gradient = likelihood.gradient(&likelihood.evaluate(&place).unwrap(), &place);
        assert!(gradient.iter().all(|slope| slope.abs() < 0.05), "{gradient:?}");
    }

    #[test]
    fn trap_a_single_start_can_miss_the_best_optimum() {
        // A fast oscillation, and a start at the optimum where all of it is noise.
        let points: Vec<Vec<f64>> = (0..40).map(|i| vec![i as f64 / 39.0]).collect();
        let values = points.iter().map(|p| (60.0 * p[0]).sin()).collect();
        let data = Dataset {
            points,
            values,
            noise: vec![Noise { shared: 1.0, known: 0.0 }; 40],
            categorical: vec![false],
        };
        let likelihood = Likelihood::new(&data, Prior::LogNormal);
        let long = HyperParameters { length_scales: vec![3.0], amplitude: 0.05, noise: 0.5 };
        let value = |hyper: &HyperParameters| likelihood.evaluate(&hyper.to_logarithms()).unwrap().value;
        let single = value(&fit(&likelihood, Some(&long), 0..0).unwrap());
        let several = value(&fit(&likelihood, Some(&long), ALL_STARTS).unwrap());
        assert!(several > single + 3.0, "{several} {single}");
        // One start at a time: after as many fits as there are starts, nothing is lost.
        let mut hyper = long;
        for turn in 100..100 + LENGTH_SCALE_STARTS.len() {
            let next = fit(&likelihood, Some(&hyper), turn..turn + 1).unwrap();
            assert!(value(&next) >= value(&hyper));
            hyper = next;
        }
        assert!(value(&hyper) > several - 0.01, "{} {several}", value(&hyper));
    }
}
