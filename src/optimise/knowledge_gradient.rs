//! The knowledge gradient: by how much one more evaluation is expected to better the answer.
//!
//! The answer is the evaluated place of lowest posterior mean that is feasible with the probability asked for. Expected
//! improvement asks for a better *value*, which luck can bring; this asks for a better *answer*, so it also repeats an evaluation
//! where doubt about the best few is what costs most.

use super::acquisition::SMALLEST_DEVIATION;
use super::models::{Models, Scaled};
use super::surrogate::Surrogate;
use numbers::distributions::normal_tail::log_improvement;

/// A posterior mean as a function of a standard normal number, the surprise of one more evaluation.
#[derive(Debug, Clone, Copy)]
struct Line {
    slope: f64,
    intercept: f64,
}

/// A line of the lower envelope and the surprise from which on it is the lowest.
struct Edge {
    line: Line,
    from: f64,
}

/// Prepared once per proposal, evaluated at many points (Scott, Frazier and Powell 2011, "The correlated knowledge gradient for
/// simulation optimization of continuous parameters using Gaussian process regression", eq. 4.2).
pub(super) struct KnowledgeGradient<'a> {
    objective: &'a Scaled,
    /// Mean above the lowest at each datum that the answer may be; `None` at the others.
    heights: Vec<Option<f64>>,
    lowest: f64,
    /// Noise variance of one more evaluation.
    noise: f64,
}

impl<'a> KnowledgeGradient<'a> {
    /// The answer is among the data that are feasible with probability `feasibility`, or else among the likeliest.
    pub fn new(objective: &'a Scaled, models: &Models, feasibility: f64) -> Self {
        let data = objective.surrogate.data();
        let logs = models.log_feasibility(&data.points);
        let least = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(libm::log(feasibility));
        let posteriors = objective.surrogate.scan(&data.points);
        let means = posteriors.iter().zip(logs).map(|(p, log)| (log >= least).then_some(p.mean));
        let means: Vec<Option<f64>> = means.collect();
        let lowest = means.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let heights = means.into_iter().map(|mean| mean.map(|mean| mean - lowest)).collect();
        let noise = data.noise_of_another(objective.surrogate.hyper_parameters().noise);
        KnowledgeGradient { objective, heights, lowest, noise }
    }

    /// Its logarithm at each point, as if the point could be the answer once evaluated.
    pub fn log(&self, points: &[Vec<f64>]) -> Vec<f64> {
        let mut logs = Vec::with_capacity(points.len());
        let (mut lines, mut envelope) = (Vec::new(), Vec::new());
        self.objective.surrogate.scan_with_covariances(points, |posterior, covariances| {
            let spread = (posterior.variance + self.noise).sqrt().max(SMALLEST_DEVIATION);
            lines.clear();
            for (height, covariance) in self.heights.iter().zip(covariances) {
                lines.extend(height.map(|intercept| Line { slope: covariance / spread, intercept }));
            }
            lines.push(Line { slope: posterior.variance / spread, intercept: posterior.mean - self.lowest });
            logs.push(log_expected_fall(&mut lines, &mut envelope));
        });
        logs
    }
}

/// ln(−E[min over lines of (intercept + slope Z)]) for a standard normal Z, where the lowest intercept of all but perhaps one line
/// is zero. Exact: the expectation is a sum over the corners of the lower envelope (Frazier, Powell and Dayanik 2009, eq. 14).
fn log_expected_fall(lines: &mut [Line], envelope: &mut Vec<Edge>) -> f64 {
    // From the line that is lowest for very negative Z to the one for very positive Z.
    lines.sort_unstable_by(|a, b| b.slope.total_cmp(&a.slope).then(a.intercept.total_cmp(&b.intercept)));
    envelope.clear();
    for &line in lines.iter() {
        // Of parallel lines the first is the lowest.
        if envelope.last().is_some_and(|last: &Edge| last.line.slope == line.slope) {
            continue;
        }
        let mut from = f64::NEG_INFINITY;
        while let Some(Edge { line: last, from: last_from }) = envelope.last() {
            from = (line.intercept - last.intercept) / (last.slope - line.slope);
            if from > *last_from {
                break;
            }
            envelope.pop();
            from = f64::NEG_INFINITY;
        }
        envelope.push(Edge { line, from });
    }
    // What the envelope is at Z = 0, and at each corner how much its bend brings on average.
    let at_zero = envelope.iter().rev().find(|edge| edge.from <= 0.0).map_or(0.0, |edge| edge.line.intercept);
    let certain = if at_zero < 0.0 { libm::log(-at_zero) } else { f64::NEG_INFINITY };
    envelope.windows(2).fold(certain, |total, pair| {
        let bend = pair[0].line.slope - pair[1].line.slope;
        log_sum(total, libm::log(bend) + log_improvement(-pair[1].from.abs()))
    })
}

/// ln(eᵃ + eᵇ).
fn log_sum(a: f64, b: f64) -> f64 {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    if low == f64::NEG_INFINITY { high } else { high + libm::log1p(libm::exp(low - high)) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use numbers::distributions::normal::density;

    fn lines(numbers: &[(f64, f64)]) -> Vec<Line> {
        numbers.iter().map(|&(slope, intercept)| Line { slope, intercept }).collect()
    }

    /// −E[min] by the midpoint rule.
    fn by_quadrature(lines: &[Line]) -> f64 {
        let (steps, end) = (20_000, 9.0);
        let width = 2.0 * end / f64::from(steps);
        let at = |step: i32| -end + width * (f64::from(step) + 0.5);
        let lowest = |z: f64| lines.iter().map(|l| l.intercept + l.slope * z).fold(f64::INFINITY, f64::min);
        -(0..steps).map(at).map(|z| lowest(z) * density(z) * width).sum::<f64>()
    }

    #[test]
    fn lines_that_never_cross_bring_nothing_and_far_ones_stay_finite() {
        let fall = |numbers: &[(f64, f64)]| log_expected_fall(&mut lines(numbers), &mut Vec::new());
        assert_eq!(fall(&[(0.0, 0.0), (0.0, 1.0)]), f64::NEG_INFINITY);
        assert_eq!(fall(&[(0.3, 0.0)]), f64::NEG_INFINITY);
        let far = fall(&[(0.0, 0.0), (1e-3, 1.0)]);
        assert!(far.is_finite() && far < -1e5, "{far}");
    }

    proptest! {
        #[test]
        fn the_expected_fall_agrees_with_quadrature(
            numbers in prop::collection::vec((-1.0..1.0f64, 0.0..2.0f64), 1..12),
            newest in (0.0..1.0f64, -1.0..1.0f64),
        ) {
            let mut all = numbers.clone();
            all[0].1 = 0.0;
            all.push(newest);
            let mut all = lines(&all);
            let expected = by_quadrature(&all);
            let got = libm::exp(log_expected_fall(&mut all, &mut Vec::new()));
            prop_assert!((got - expected).abs() < 1e-6, "{} {}", got, expected);
        }
    }
}
