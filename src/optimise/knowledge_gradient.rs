//! The knowledge gradient: by how much one more evaluation is expected to better the answer.
//!
//! The answer is the evaluated place of lowest posterior mean that is feasible with the probability asked for. Expected
//! improvement asks for a better *value*, which luck can bring; this asks for a better *answer*, so it also repeats an evaluation
//! where doubt about the best few is what costs most.

use super::acquisition::SMALLEST_DEVIATION;
use super::models::{Models, Scaled};
use super::surrogate::{CovariancesWith, Surrogate};
use numbers::distributions::normal_tail::{improvement, log_improvement};

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

/// An answer that lies further above the best one than so many deviations of what may happen to their difference is out of reach:
/// it brings less than 1.3e-20 of such a deviation.
const REACH: f64 = 9.0;
/// From this gain on, all answers that are out of reach do not make a millionth, be they a hundred thousand deviations.
const LEAST_GAIN: f64 = 1e-9;
/// Rounding alone makes variances of differences about 1e-16 of the amplitude.
const LEAST_DIFFERENCE: f64 = 1e-7;

/// Down to here a sum of improvements has all its digits but four; what is less is summed in logarithms.
const LEAST_SUM: f64 = 1e-40;

/// Prepared once per proposal, evaluated at many points (Scott, Frazier and Powell 2011, "The correlated knowledge gradient for
/// simulation optimization of continuous parameters using Gaussian process regression", eq. 4.2).
pub(super) struct KnowledgeGradient<'a> {
    objective: &'a Scaled,
    /// Data that the answer may be, in ascending order, how far their means lie above the lowest, and which of them that is.
    answers: Vec<usize>,
    heights: Vec<f64>,
    best: usize,
    lowest: f64,
    /// Of the latent function with that at the answers.
    covariances: CovariancesWith,
    /// In deviations.
    reach: f64,
    /// Noise variance of one more evaluation.
    noise: f64,
}

impl<'a> KnowledgeGradient<'a> {
    /// The answer is among the data that are feasible with probability `feasibility`, or else among the likeliest.
    pub fn new(objective: &'a Scaled, models: &Models, feasibility: f64) -> Option<Self> {
        let data = objective.surrogate.data();
        let logs = models.log_feasibility(&data.points);
        let least = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(libm::log(feasibility));
        let means = objective.surrogate.scan(&data.points).into_iter().map(|posterior| posterior.mean);
        let likely = means.zip(logs).enumerate().filter(|(_, (_, log))| *log >= least);
        let (answers, means): (Vec<usize>, Vec<f64>) = likely.map(|(i, (mean, _))| (i, mean)).unzip();
        let best = (0..means.len()).min_by(|&a, &b| means[a].total_cmp(&means[b]))?;
        let lowest = means[best];
        Some(KnowledgeGradient {
            objective,
            heights: means.iter().map(|mean| mean - lowest).collect(),
            best,
            lowest,
            covariances: objective.surrogate.covariances_with(&answers),
            answers,
            reach: f64::MAX,
            noise: data.noise_of_another(objective.surrogate.hyper_parameters().noise),
        })
    }

    /// Without answers that are out of reach of what one more evaluation may bring, which are most in the end. Where
    /// [`KnowledgeGradient::is_exact`] for the largest gain, that is the same to a millionth.
    pub fn within_reach(&self) -> Self {
        let surrogate = &self.objective.surrogate;
        let place = std::slice::from_ref(&surrogate.data().points[self.answers[self.best]]);
        let mut with_best = Vec::new();
        surrogate.scan_with_covariances(place, &self.covariances, |_, all| with_best = all.to_vec());
        let places: Vec<Vec<f64>> =
            self.answers.iter().map(|i| surrogate.data().points[*i].clone()).collect();
        let posteriors = surrogate.scan(&places);
        let is_in_reach = |&answer: &usize| {
            // No evaluation moves the difference of two means by more than the deviation of that of the latent function.
            let variances = posteriors[self.best].variance + posteriors[answer].variance;
            let variance = (variances - 2.0 * with_best[answer]).max(LEAST_DIFFERENCE * LEAST_DIFFERENCE);
            self.heights[answer] <= REACH * variance.sqrt()
        };
        let kept: Vec<usize> = (0..self.answers.len()).filter(is_in_reach).collect();
        let answers: Vec<usize> = kept.iter().map(|&answer| self.answers[answer]).collect();
        KnowledgeGradient {
            heights: kept.iter().map(|&answer| self.heights[answer]).collect(),
            best: kept.iter().position(|&answer| answer == self.best).unwrap_or(0),
            covariances: surrogate.covariances_with(&answers),
            answers,
            reach: REACH,
            ..*self
        }
    }

    /// Whether a largest gain with this logarithm is large beside all that is out of reach.
    pub fn is_exact(log: f64) -> bool {
        log >= libm::log(LEAST_GAIN)
    }

    /// Its logarithm at each point, as if the point could be the answer once evaluated.
    pub fn log(&self, points: &[Vec<f64>]) -> Vec<f64> {
        let mut logs = Vec::with_capacity(points.len());
        let (mut lines, mut envelope) = (Vec::new(), Vec::new());
        let surrogate = &self.objective.surrogate;
        surrogate.scan_with_covariances(points, &self.covariances, |posterior, covariances| {
            let spread = (posterior.variance + self.noise).sqrt().max(SMALLEST_DEVIATION);
            lines.clear();
            let best = covariances[self.best];
            for (&intercept, covariance) in self.heights.iter().zip(covariances) {
                if intercept * spread <= self.reach * (covariance - best).abs() {
                    lines.push(Line { slope: covariance / spread, intercept });
                }
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
    let bends =
        envelope.windows(2).map(|pair| (pair[0].line.slope - pair[1].line.slope, -pair[1].from.abs()));
    let fall: f64 =
        bends.clone().map(|(bend, corner)| bend * improvement(corner)).sum::<f64>() - at_zero.min(0.0);
    if fall > LEAST_SUM {
        return libm::log(fall);
    }
    let certain = if at_zero < 0.0 { libm::log(-at_zero) } else { f64::NEG_INFINITY };
    bends.fold(certain, |total, (bend, corner)| log_sum(total, libm::log(bend) + log_improvement(corner)))
}

/// ln(eᵃ + eᵇ).
fn log_sum(a: f64, b: f64) -> f64 {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    if low == f64::NEG_INFINITY { high } else { high + libm::log1p(libm::exp(low - high)) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::definition::Definition;
    use super::super::history::{EvaluatedPoint, Evaluation};
    use super::super::models::Remembered;
    use super::super::space::{SearchDimension, Space};
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
        // Sums and sums of logarithms agree where the one follows the other.
        for height in [13.2, 13.3, 13.4, 13.5] {
            let expected = log_improvement(-height);
            assert!((fall(&[(0.0, 0.0), (1.0, height)]) - expected).abs() < 1e-11, "{height}");
        }
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

    proptest! {
        #[test]
        fn answers_out_of_reach_make_no_difference(
            places in prop::collection::btree_set(0..1000_u32, 2..40),
            seed in 0..1000_u64,
            noise in prop_oneof![Just(0.0), 0.01..0.5f64],
        ) {
            let space = Space::new(vec![SearchDimension::real("x", 0.0, 1.0)]).unwrap();
            let definition = Definition { seed, ..Definition::new(space, seed) };
            let mut error = numbers::random::Stream::numbered(seed, 0);
            let trials: Vec<EvaluatedPoint> = places
                .iter()
                .map(|&place| {
                    let x = f64::from(place) / 1000.0;
                    let value = (9.0 * x).sin() + noise * error.normal();
                    EvaluatedPoint { id: 0, unit: vec![x], point: vec![], evaluation: Evaluation::of(value) }
                })
                .collect();
            let value = |trial: &EvaluatedPoint| Some((trial.evaluation.objectives[0].value?, None));
            let models = Models::fit(&definition, &trials, value, &mut Remembered::default()).unwrap();
            let all = KnowledgeGradient::new(models.objective.as_ref().unwrap(), &models, 0.98).unwrap();
            let within_reach = all.within_reach();
            prop_assert!(within_reach.answers.len() <= all.answers.len());
            prop_assert_eq!(within_reach.heights[within_reach.best], 0.0);
            let candidates: Vec<Vec<f64>> = (0..=100).map(|i| vec![f64::from(i) / 100.0]).collect();
            for (all, quick) in all.log(&candidates).into_iter().zip(within_reach.log(&candidates)) {
                let exact = !KnowledgeGradient::is_exact(all.max(quick)) || (all - quick).abs() < 1e-6;
                prop_assert!(exact, "{} {}", all, quick);
            }
        }
    }
}
