//! Weights over candidates that match targets within their errors and differ as little as can be from equal ones.
//!
//! Of n candidates with features f(i, j) and targets t(j) of error s(j), the weights are w(i) ∝ exp(Σ λ(j) g(i, j)) with
//! g = (f − t) / s, where λ minimises ln mean exp(λ·g) + (strength / 2) |λ|²: the dual of the least relative entropy to equal weights
//! plus (1 / 2 strength) Σ mismatch², a mismatch being Σ w g (Jaynes 1957; Dudík, Phillips and Schapire, JMLR 8, 2007, §4). The dual is
//! strictly convex, so Newton's method with halved steps finds its one minimum, at which every mismatch is −strength · λ.
//!
//! Other means are bounded: they are to lie within so much of a value, and cost nothing there. Of those bounds some hold at the minimum,
//! as equations at an edge, and the others change nothing (Karush, Kuhn and Tucker); which, is found one by one.

/// What a weighted mean is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightTarget {
    /// The mean wanted.
    pub value: f64,
    /// Its standard error, above 0.
    pub error: f64,
}

/// Where a weighted mean has to lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightBound {
    /// In the middle.
    pub value: f64,
    /// How far from it at most, above 0.
    pub within: f64,
}

/// Weights, and how well they match.
#[derive(Debug, Clone, PartialEq)]
pub struct EntropyWeights {
    /// One per candidate, not negative, of sum 1.
    pub weights: Vec<f64>,
    /// By how many errors the weighted mean of each feature is above its target; behind them, by how many of their widths bounded means
    /// are above the middle.
    pub mismatches: Vec<f64>,
}

impl EntropyWeights {
    /// Sum of squared mismatches.
    pub fn chi_squared(&self) -> f64 {
        self.mismatches.iter().map(|one| one * one).sum()
    }

    /// How many candidates of equal weight vary a mean as much.
    pub fn effective_size(&self) -> f64 {
        effective_size(&self.weights)
    }
}

/// How many equal weights vary a mean as much (Kish 1965): (Σ w)² / Σ w². 0 of no weights.
pub fn effective_size(weights: &[f64]) -> f64 {
    let sum: f64 = weights.iter().sum();
    let squares: f64 = weights.iter().map(|one| one * one).sum();
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// Of the published form: the errors of the targets are the tolerance.
pub(super) const STRENGTH: f64 = 1.0;
/// At which weights are held to equal ones by next to nothing.
pub(super) const FREE: f64 = 1e-4;

/// The smallest change from equal weights that matches within the errors of the targets. A row of `features` is a candidate's, one
/// number for each target.
///
/// # Panics
/// Without candidates or targets, for rows of another length, and for errors that are not positive.
pub fn maximum_entropy(features: &[Vec<f64>], targets: &[WeightTarget]) -> EntropyWeights {
    entropy_weights(features, targets, &[], STRENGTH)
}

/// As [`maximum_entropy`], with so many of their errors as the tolerance of the targets: a part of one matches better, and by weights
/// that are less equal. Behind the features of targets a row has those whose means are bounded. Where no weights keep all bounds,
/// mismatches beyond 1 say so.
///
/// # Panics
/// As [`maximum_entropy`], where bounds are targets too, and for a number that is not positive.
pub fn maximum_entropy_within(
    errors: f64,
    features: &[Vec<f64>],
    targets: &[WeightTarget],
    bounds: &[WeightBound],
) -> EntropyWeights {
    assert!(errors > 0.0, "a tolerance is positive");
    entropy_weights(features, targets, bounds, STRENGTH * errors * errors)
}

/// The mixture that comes nearest to the targets, however few candidates it is of, and keeps the bounds as far as that can be.
///
/// # Panics
/// As [`maximum_entropy_within`].
pub fn nearest_mixture(
    features: &[Vec<f64>],
    targets: &[WeightTarget],
    bounds: &[WeightBound],
) -> EntropyWeights {
    entropy_weights(features, targets, bounds, FREE)
}

/// A bounded mean may be beyond its edge by this part of its width, which is rounding.
const BEYOND: f64 = 1e-4;
/// Of bounds that are held or let go; there are few, and each usually changes once.
const MOST_CHANGES: usize = 200;

pub(super) fn entropy_weights(
    features: &[Vec<f64>],
    targets: &[WeightTarget],
    bounds: &[WeightBound],
    strength: f64,
) -> EntropyWeights {
    // On which edge a bounded mean is held, if on one: 1 or -1.
    let mut edges: Vec<Option<f64>> = vec![None; bounds.len()];
    let mut changes = 0;
    loop {
        let (mut found, dual) = Standardised::new(features, targets, bounds, &edges).solve(strength);
        // What held them is behind the targets.
        let mut held = dual[targets.len()..].iter();
        let mut outwards = None;
        for (index, edge) in edges.iter().enumerate() {
            if let Some(side) = edge
                && held.next().is_some_and(|pull| pull * side > 0.0)
            {
                outwards = Some(index);
            }
        }
        let apart = |(index, bound): (usize, &WeightBound)| {
            let column = targets.len() + index;
            let mean: f64 =
                features.iter().zip(&found.weights).map(|(row, weight)| weight * row[column]).sum();
            (mean - bound.value) / bound.within
        };
        let apart: Vec<f64> = bounds.iter().enumerate().map(apart).collect();
        let beyond = (0..bounds.len())
            .filter(|index| edges[*index].is_none() && apart[*index].abs() > 1.0 + BEYOND)
            .max_by(|one, other| apart[*one].abs().total_cmp(&apart[*other].abs()));
        changes += 1;
        match (outwards, beyond) {
            (Some(index), _) if changes < MOST_CHANGES => edges[index] = None,
            (None, Some(index)) if changes < MOST_CHANGES => edges[index] = Some(apart[index].signum()),
            _ => {
                found.mismatches.truncate(targets.len());
                found.mismatches.extend(apart);
                return found;
            }
        }
    }
}

/// Features as errors from their targets, a candidate after the other, and behind them those that are held at an edge, in widths from it.
struct Standardised {
    rows: Vec<f64>,
    count: usize,
    /// How many of them are targets.
    targets: usize,
    candidates: usize,
}

/// A point of the dual with all that a step needs.
struct Point {
    value: f64,
    weights: Vec<f64>,
}

const MOST_STEPS: usize = 500;
/// Of the gradient, in errors.
const CONVERGED: f64 = 1e-10;
/// Of the dual's value.
const ROUNDING: f64 = 1e-12;
/// Below this strength a minimum is looked for from the one of a greater strength: from equal weights the first steps of Newton's method
/// could lead to where a single candidate has all weight, and end there.
const APPROACHED: f64 = 1e-2;
/// The strength of what is held at an edge: next to none, so that it is there to rounding, and that it stays finite where it cannot be.
const EDGE: f64 = 1e-6;

impl Standardised {
    fn new(
        features: &[Vec<f64>],
        targets: &[WeightTarget],
        bounds: &[WeightBound],
        edges: &[Option<f64>],
    ) -> Self {
        assert!(
            !features.is_empty() && targets.len() + bounds.len() > 0,
            "there is somebody to weigh, and something to match"
        );
        assert!(targets.iter().all(|target| target.error > 0.0), "errors are positive");
        assert!(bounds.iter().all(|bound| bound.within > 0.0), "widths are positive");
        let held: Vec<(usize, WeightBound, f64)> = (targets.len()..)
            .zip(bounds.iter().zip(edges))
            .filter_map(|(column, (bound, edge))| Some((column, *bound, (*edge)?)))
            .collect();
        let count = targets.len() + held.len();
        let mut rows = Vec::with_capacity(features.len() * count);
        for row in features {
            assert_eq!(row.len(), targets.len() + bounds.len(), "a feature for each target and bound");
            rows.extend(row.iter().zip(targets).map(|(value, target)| (value - target.value) / target.error));
            rows.extend(
                held.iter().map(|(column, WeightBound { value, within }, side)| {
                    (row[*column] - value) / within - side
                }),
            );
        }
        Self { rows, count, targets: targets.len(), candidates: features.len() }
    }

    /// What a column's multiplier costs.
    fn strength(&self, column: usize, strength: f64) -> f64 {
        if column < self.targets { strength } else { EDGE }
    }

    fn each(&self) -> std::slice::ChunksExact<'_, f64> {
        self.rows.chunks_exact(self.count)
    }

    fn at(&self, dual: &[f64], strength: f64) -> Point {
        let mut weights: Vec<f64> = self.each().map(|row| dot(row, dual)).collect();
        let highest = weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        weights.iter_mut().for_each(|one| *one = libm::exp(*one - highest));
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|one| *one /= sum);
        let (matched, held) = dual.split_at(self.targets);
        let cost = 0.5 * strength * dot(matched, matched) + 0.5 * EDGE * dot(held, held);
        let value = highest + libm::log(sum / weights.len() as f64) + cost;
        Point { value, weights }
    }

    fn means(&self, weights: &[f64]) -> Vec<f64> {
        let mut means = vec![0.0; self.count];
        for (row, weight) in self.each().zip(weights) {
            means.iter_mut().zip(row).for_each(|(mean, value)| *mean += weight * value);
        }
        means
    }

    fn gradient(&self, point: &Point, dual: &[f64], strength: f64) -> Vec<f64> {
        let means = self.means(&point.weights);
        let columns = means.iter().zip(dual).enumerate();
        columns.map(|(column, (mean, at))| mean + self.strength(column, strength) * at).collect()
    }

    fn curvature(&self, weights: &[f64], means: &[f64], strength: f64) -> Vec<Vec<f64>> {
        let mut curvature = vec![vec![0.0; self.count]; self.count];
        for (row, weight) in self.each().zip(weights) {
            for (one, line) in curvature.iter_mut().enumerate() {
                let by = weight * (row[one] - means[one]);
                for other in 0..=one {
                    line[other] += by * (row[other] - means[other]);
                }
            }
        }
        curvature.iter_mut().enumerate().for_each(|(one, line)| line[one] += self.strength(one, strength));
        curvature
    }

    /// The weights, and the multipliers that they come of.
    fn solve(&self, strength: f64) -> (EntropyWeights, Vec<f64>) {
        if self.count == 0 {
            let weights = vec![1.0 / self.candidates as f64; self.candidates];
            return (EntropyWeights { weights, mismatches: Vec::new() }, Vec::new());
        }
        let mut dual = vec![0.0; self.count];
        if strength < APPROACHED {
            let greater = std::iter::successors(Some(STRENGTH), |one| Some(one / 10.0));
            for one in greater.take_while(|one| *one > strength) {
                dual = self.minimum(one, dual).1;
            }
        }
        let (point, dual) = self.minimum(strength, dual);
        let mismatches = self.means(&point.weights);
        (EntropyWeights { weights: point.weights, mismatches }, dual)
    }

    /// The minimum of the dual, from `dual` on.
    fn minimum(&self, strength: f64, mut dual: Vec<f64>) -> (Point, Vec<f64>) {
        let mut point = self.at(&dual, strength);
        for _ in 0..MOST_STEPS {
            let gradient = self.gradient(&point, &dual, strength);
            let means = self.means(&point.weights);
            if gradient.iter().all(|one| one.abs() <= CONVERGED) {
                break;
            }
            let step = descend(self.curvature(&point.weights, &means, strength), &gradient);
            let slope = dot(&gradient, &step);
            let at = |share: f64| {
                let next: Vec<f64> = dual.iter().zip(&step).map(|(at, by)| at + share * by).collect();
                let found = self.at(&next, strength);
                (next, found)
            };
            let next = if -slope < ROUNDING * (1.0 + point.value.abs()) {
                // So near to the minimum rounding swallows how far a step goes down, but its slope still tells.
                let (next, found) = at(1.0);
                let left = norm(&self.gradient(&found, &next, strength));
                (left < 0.5 * norm(&gradient)).then_some((next, found))
            } else {
                let halves = std::iter::successors(Some(1.0), |share| Some(share * 0.5))
                    .take_while(|share| *share >= 1e-12);
                halves
                    .map(|share| (share, at(share)))
                    .find(|(share, (_, found))| found.value <= point.value + 1e-4 * share * slope)
                    .map(|(_, next)| next)
            };
            let Some(next) = next else { break };
            (dual, point) = next;
        }
        (point, dual)
    }
}

/// The weighted mean of a column.
pub(super) fn mean(rows: &[Vec<f64>], weights: &[f64], column: usize) -> f64 {
    rows.iter().zip(weights).map(|(row, weight)| weight * row[column]).sum()
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

/// Solves for the step of Newton's method.
fn descend(matrix: Vec<Vec<f64>>, gradient: &[f64]) -> Vec<f64> {
    let down: Vec<f64> = gradient.iter().map(|one| -one).collect();
    solved(&factor(matrix), &down)
}

/// Cholesky's decomposition of a positive definite matrix, of which the lower half is given, in the lower half.
pub(super) fn factor(mut matrix: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    for row in 0..matrix.len() {
        for column in 0..=row {
            let known: f64 = (0..column).map(|at| matrix[row][at] * matrix[column][at]).sum();
            let rest = matrix[row][column] - known;
            matrix[row][column] = if row == column {
                libm::sqrt(rest.max(f64::MIN_POSITIVE))
            } else {
                rest / matrix[column][column]
            };
        }
    }
    matrix
}

/// The solution of the equations whose matrix has these [`factor`]s.
pub(super) fn solved(factors: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let count = right.len();
    let mut found = vec![0.0; count];
    for row in 0..count {
        let known: f64 = (0..row).map(|at| factors[row][at] * found[at]).sum();
        found[row] = (right[row] - known) / factors[row][row];
    }
    for row in (0..count).rev() {
        let known: f64 = (row + 1..count).map(|at| factors[at][row] * found[at]).sum();
        found[row] = (found[row] - known) / factors[row][row];
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;
    use proptest::prelude::*;

    fn problem(seed: u64, candidates: usize, targets: usize) -> (Vec<Vec<f64>>, Vec<WeightTarget>) {
        let mut stream = Stream::seeded(seed);
        let row = |stream: &mut Stream| (0..targets).map(|_| stream.uniform()).collect();
        let features: Vec<Vec<f64>> = (0..candidates).map(|_| row(&mut stream)).collect();
        let target = |stream: &mut Stream| WeightTarget {
            value: 0.3 + 0.4 * stream.uniform(),
            error: 0.02 + 0.05 * stream.uniform(),
        };
        let targets = (0..targets).map(|_| target(&mut stream)).collect();
        (features, targets)
    }

    /// Candidates that do something from some gap on, and do it always or never but for noise: shares and pairs of them, as calibrations
    /// match them.
    fn cliffs(seed: u64) -> (Vec<Vec<f64>>, Vec<WeightTarget>) {
        let mut stream = Stream::seeded(seed);
        let row = |stream: &mut Stream| {
            let (asked, sharp) = (1.0 + 9.0 * stream.uniform(), 0.05 + 2.0 * stream.uniform());
            let share = |gap: f64, noise: f64| 1.0 / (1.0 + libm::exp((asked - gap) / sharp)) + noise;
            let shares: Vec<f64> = (3..=7)
                .flat_map(|gap| {
                    [
                        share(f64::from(gap), 0.1 * stream.normal()),
                        share(f64::from(gap) + 2.0, 0.1 * stream.normal()),
                    ]
                })
                .collect();
            let pairs = shares.iter().map(|one| one * one + 0.05 * stream.normal());
            shares.iter().copied().chain(pairs).collect()
        };
        let features: Vec<Vec<f64>> = (0..2000).map(|_| row(&mut stream)).collect();
        let shares: Vec<f64> = (0..10).map(|_| stream.uniform()).collect();
        let target = |value: f64| WeightTarget { value, error: 0.03 };
        let pairs = shares.iter().map(|one| target(one * (0.7 + 0.3 * one)));
        (features, shares.iter().map(|one| target(*one)).chain(pairs).collect())
    }

    #[test]
    fn the_nearest_mixture_is_no_farther_than_a_more_equal_one() {
        for seed in 0..20 {
            let (features, targets) = cliffs(seed);
            let nearest = nearest_mixture(&features, &targets, &[]).chi_squared();
            let usual = maximum_entropy(&features, &targets).chi_squared();
            assert!(nearest <= usual * (1.0 + 1e-9), "seed {seed}: {nearest} and {usual}");
            // At the minimum every mismatch is held by its multiplier.
            for strength in [FREE, 0.25, STRENGTH] {
                let (found, dual) = Standardised::new(&features, &targets, &[], &[]).solve(strength);
                let left = found.mismatches.iter().zip(&dual).map(|(one, by)| one + strength * by);
                assert!(left.map(f64::abs).fold(0.0, f64::max) < 1e-6, "seed {seed}, strength {strength}");
            }
        }
    }

    /// Relative entropy to equal weights, plus the penalty: what the weights minimise.
    fn primal(features: &[Vec<f64>], targets: &[WeightTarget], weights: &[f64], strength: f64) -> f64 {
        let equal = 1.0 / weights.len() as f64;
        let entropy: f64 =
            weights.iter().filter(|one| **one > 0.0).map(|one| one * libm::log(one / equal)).sum();
        let mismatch = |(index, target): (usize, &WeightTarget)| {
            let mean: f64 = features.iter().zip(weights).map(|(row, weight)| weight * row[index]).sum();
            (mean - target.value) / target.error
        };
        let penalty: f64 = targets.iter().enumerate().map(mismatch).map(|one| one * one).sum();
        entropy + penalty / (2.0 * strength)
    }

    /// A second derivation: exponentiated gradient on the primal, which knows no dual.
    fn by_exponentiated_gradient(features: &[Vec<f64>], targets: &[WeightTarget], strength: f64) -> Vec<f64> {
        let equal = 1.0 / features.len() as f64;
        let mut weights = vec![equal; features.len()];
        let mut rate = 0.01;
        let mut value = primal(features, targets, &weights, strength);
        for _ in 0..200_000 {
            let mismatches: Vec<f64> = (0..targets.len())
                .map(|index| {
                    let mean: f64 =
                        features.iter().zip(&weights).map(|(row, weight)| weight * row[index]).sum();
                    (mean - targets[index].value) / (targets[index].error * targets[index].error)
                })
                .collect();
            let slope = |row: &Vec<f64>, weight: f64| {
                let pull: f64 = row.iter().zip(&mismatches).map(|(one, by)| one * by).sum();
                libm::log(weight / equal) + pull / strength
            };
            let next: Vec<f64> = features
                .iter()
                .zip(&weights)
                .map(|(row, weight)| weight * libm::exp(-rate * slope(row, *weight)))
                .collect();
            let sum: f64 = next.iter().sum();
            let next: Vec<f64> = next.into_iter().map(|one| one / sum).collect();
            let found = primal(features, targets, &next, strength);
            if found <= value {
                let step =
                    weights.iter().zip(&next).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
                (weights, value) = (next, found);
                rate *= 1.05;
                if step < 1e-14 {
                    break;
                }
            } else {
                rate *= 0.5;
            }
        }
        weights
    }

    #[test]
    fn a_second_derivation_finds_the_same_weights() {
        for seed in 0..3 {
            let (features, targets) = problem(seed, 25, 3);
            for strength in [0.3, 3.0] {
                let found = entropy_weights(&features, &targets, &[], strength);
                let other = by_exponentiated_gradient(&features, &targets, strength);
                let apart = found.weights.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(apart < 1e-6, "{apart} at {strength}, seed {seed}");
            }
        }
    }

    #[test]
    fn two_candidates_are_weighed_as_a_fine_grid_of_weights_says() {
        let features = vec![vec![0.0], vec![1.0]];
        let targets = [WeightTarget { value: 0.8, error: 0.1 }];
        let found = entropy_weights(&features, &targets, &[], 0.5);
        let best = (1..100_000u32)
            .map(|step| f64::from(step) / 100_000.0)
            .min_by(|one, other| {
                let value = |share: f64| primal(&features, &targets, &[1.0 - share, share], 0.5);
                value(*one).total_cmp(&value(*other))
            })
            .unwrap();
        assert!((found.weights[1] - best).abs() < 2e-5, "{} and {best}", found.weights[1]);
    }

    #[test]
    fn what_matches_already_stays_equal() {
        let features = vec![vec![0.0], vec![1.0]];
        let found = maximum_entropy(&features, &[WeightTarget { value: 0.5, error: 0.1 }]);
        assert_eq!(found.weights, [0.5, 0.5]);
    }

    #[test]
    fn what_no_mixture_reaches_has_a_nearest() {
        let features = vec![vec![0.0], vec![0.2], vec![0.4]];
        let nearest = nearest_mixture(&features, &[WeightTarget { value: 0.9, error: 0.05 }], &[]);
        assert!((nearest.mismatches[0] + 10.0).abs() < 0.01, "{nearest:?}");
        assert!(nearest.weights[2] > 0.99);
        assert!(nearest.effective_size() < 1.05);
    }

    #[test]
    fn small_errors_are_met_exactly_and_large_ones_change_nothing() {
        let (features, mut targets) = problem(7, 400, 5);
        targets.iter_mut().for_each(|target| target.error = 1e-6);
        let exact = maximum_entropy(&features, &targets);
        for (index, target) in targets.iter().enumerate() {
            let mean: f64 =
                features.iter().zip(&exact.weights).map(|(row, weight)| weight * row[index]).sum();
            assert!((mean - target.value).abs() < 1e-7, "{mean} for {}", target.value);
        }
        targets.iter_mut().for_each(|target| target.error = 1e6);
        let equal = maximum_entropy(&features, &targets);
        assert!((equal.effective_size() - 400.0).abs() < 1e-6);
        assert!((exact.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    /// The means of bounded features, behind so many targets.
    fn bounded_means(features: &[Vec<f64>], weights: &[f64], targets: usize) -> Vec<f64> {
        let mean = |column| features.iter().zip(weights).map(|(row, weight)| weight * row[column]).sum();
        (targets..features[0].len()).map(mean).collect()
    }

    #[test]
    fn bounded_means_lie_within_and_nothing_else_is_paid_for_it() {
        let mut held = [0; 3];
        for seed in 0..200 {
            let (mut features, all) = problem(seed, 60, 5);
            let bounds: Vec<WeightBound> =
                all[3..].iter().map(|one| WeightBound { value: one.value, within: one.error }).collect();
            let targets = &all[..3];
            let strength = 0.7;
            let found = entropy_weights(&features, targets, &bounds, strength);
            let means = bounded_means(&features, &found.weights, 3);
            let mut on_edge = 0;
            for (mean, bound) in means.iter().zip(&bounds) {
                let apart = (mean - bound.value).abs() / bound.within;
                assert!(apart <= 1.0 + 1e-3, "{apart} widths with seed {seed}");
                on_edge += usize::from(apart > 0.999);
            }
            held[on_edge] += 1;
            // Of all weights that keep the bounds none are better: from pairs of candidates to pairs, along what changes no bounded mean.
            let part = |rows: &[Vec<f64>]| rows.iter().map(|row| row[..3].to_vec()).collect::<Vec<_>>();
            let soft = part(&features);
            let best = primal(&soft, targets, &found.weights, strength);
            let mut stream = Stream::seeded(seed);
            for _ in 0..50 {
                let four: Vec<usize> = (0..4).map(|_| stream.index(60)).collect();
                let to = kept(&features, &four);
                let size: f64 = to.iter().map(|one| one.abs()).fold(0.0, f64::max);
                let least = four.iter().map(|one| found.weights[*one]).fold(1.0, f64::min);
                for by in [1e-2, -1e-2] {
                    let mut other = found.weights.clone();
                    for (at, step) in four.iter().zip(&to) {
                        other[*at] += by * least * step / size.max(1e-9);
                    }
                    if other.iter().all(|one| *one >= 0.0) {
                        assert!(primal(&soft, targets, &other, strength) >= best - 1e-9, "seed {seed}");
                    }
                }
            }
            // Bounds that are nowhere near change nothing, to the last bit.
            let wide: Vec<_> = bounds.iter().map(|one| WeightBound { within: 10.0, ..*one }).collect();
            let free = entropy_weights(&features, targets, &wide, strength);
            features.iter_mut().for_each(|row| row.truncate(3));
            assert_eq!(free.weights, entropy_weights(&features, targets, &[], strength).weights);
        }
        assert!(held.iter().all(|one| *one >= 5), "bounds that hold and that do not: {held:?}");
    }

    /// Changes of the weights of four candidates that keep their sum and both bounded means: a null vector of three equations.
    fn kept(features: &[Vec<f64>], four: &[usize]) -> Vec<f64> {
        let rows: [Vec<f64>; 3] = [
            vec![1.0; 4],
            four.iter().map(|one| features[*one][3]).collect(),
            four.iter().map(|one| features[*one][4]).collect(),
        ];
        let minor = |left: usize| {
            let kept: Vec<usize> = (0..4).filter(|one| *one != left).collect();
            let [a, b, c] =
                [&rows[0], &rows[1], &rows[2]].map(|row| [row[kept[0]], row[kept[1]], row[kept[2]]]);
            let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
            dot(&a, &cross) * if left.is_multiple_of(2) { 1.0 } else { -1.0 }
        };
        (0..4).map(minor).collect()
    }

    #[test]
    fn a_bounded_problem_is_solved_as_one_with_the_edge_for_a_target() {
        // 0 and 1 and 2, whose mean is to be at most 0.6: the weights of maximum entropy are geometric in it.
        let features = vec![vec![0.0], vec![1.0], vec![2.0]];
        let found = maximum_entropy_within(1.0, &features, &[], &[WeightBound { value: 0.5, within: 0.1 }]);
        let ratio = |weights: &[f64]| (weights[1] / weights[0], weights[2] / weights[1]);
        let (one, other) = ratio(&found.weights);
        assert!((one - other).abs() < 1e-9 && (found.mismatches[0] - 1.0).abs() < 1e-4, "{found:?}");
        // By hand: x + 2x² = 0.6 (1 + x + x²).
        assert!((1.4 * one * one + 0.4 * one - 0.6).abs() < 1e-4, "{one}");
        let inside = maximum_entropy_within(1.0, &features, &[], &[WeightBound { value: 0.95, within: 0.1 }]);
        assert_eq!(inside.weights, [1.0 / 3.0; 3]);
    }

    #[test]
    fn bounds_that_nobody_keeps_are_told_by_mismatches() {
        let features = vec![vec![0.0, 0.1], vec![0.2, 0.4], vec![0.4, 0.2]];
        let (target, bound) =
            (WeightTarget { value: 0.3, error: 0.05 }, WeightBound { value: 0.9, within: 0.1 });
        let found = maximum_entropy_within(1.0, &features, &[target], &[bound]);
        assert!((found.mismatches[1] + 5.0).abs() < 0.01, "{found:?}");
        assert!(found.weights[1] > 0.99 && found.weights.iter().all(|one| one.is_finite()));
        // Two that exclude each other.
        let both = vec![vec![0.0, 1.0], vec![1.0, 0.0]];
        let bounds = [WeightBound { value: 0.9, within: 0.01 }; 2];
        let found = nearest_mixture(&both, &[], &bounds);
        assert!(found.mismatches.iter().any(|one| one.abs() > 2.0), "{found:?}");
    }

    /// Rounding of the dual's value once ended the search at 1e-8 of the minimum in one of some hundred problems.
    #[test]
    fn the_minimum_is_found_to_rounding() {
        for seed in 0..1000 {
            let (features, targets) = problem(seed, 40, 4);
            let found = entropy_weights(&features, &targets, &[], 1.0);
            // At the minimum weights are the exponentials of what the mismatches say.
            let rows = Standardised::new(&features, &targets, &[], &[]);
            let dual: Vec<f64> = found.mismatches.iter().map(|one| -one).collect();
            let said = rows.at(&dual, 1.0).weights;
            let apart = found.weights.iter().zip(&said).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let steepest = rows.each().map(|row| row.iter().map(|one| one.abs()).sum()).fold(0.0, f64::max);
            assert!(apart < 2.0 * CONVERGED * steepest, "{apart} with seed {seed}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20))]
        #[test]
        fn the_order_of_candidates_and_of_targets_changes_nothing(seed in 0u64..1000, turn in 1usize..40) {
            let (features, targets) = problem(seed, 40, 4);
            let found = entropy_weights(&features, &targets, &[], 1.0);
            let mut turned: Vec<Vec<f64>> = features.clone();
            turned.rotate_left(turn);
            turned.iter_mut().for_each(|row| row.reverse());
            let mut backwards = targets.clone();
            backwards.reverse();
            let mut other = entropy_weights(&turned, &backwards, &[], 1.0).weights;
            other.rotate_right(turn);
            for (one, other) in found.weights.iter().zip(&other) {
                prop_assert!((one - other).abs() < 1e-9);
            }
        }

        #[test]
        fn mismatches_are_those_of_the_minimum(seed in 0u64..1000, strength in 0.01f64..100.0) {
            let (features, targets) = problem(seed, 60, 4);
            let found = entropy_weights(&features, &targets, &[], strength);
            let of = |weights: &[f64]| primal(&features, &targets, weights, strength);
            let best = of(&found.weights);
            // Nobody near is better.
            for pair in 0..59 {
                let by = (0.01 * found.weights[pair]).min(0.01 * found.weights[pair + 1]);
                let mut other = found.weights.clone();
                other[pair] += by;
                other[pair + 1] -= by;
                prop_assert!(of(&other) >= best - 1e-12);
            }
        }
    }
}
