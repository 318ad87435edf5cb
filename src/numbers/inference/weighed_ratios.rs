//! Weights by which a mixture does something in a share of the runs in which that can be said.
//!
//! Candidate i has a chance d(i, j) that it can be said in condition j whether something held, such as that it is still there, and
//! h(i, j) that it is and held. The mixture's share is r(j) = Σ w h / Σ w d, so that r = t is the linear equation Σ w (h − t d) = 0,
//! to which a candidate adds nothing who is never there. Within errors, the weights make the relative entropy to equal weights
//! plus (1 / 2 strength) Σ ((r − t) / s)² least, as [`super::maximum_entropy`] does where d is 1. A ratio is no mean, but about weights at
//! which it is r it changes as the mean of r + (h − r d) / Σ w d does, a candidate's influence on it (the delta method). So weights for
//! influences are found again and again, from those about r = t on, at which the equation is exact, until none changes; a step that
//! would not lower what is least is halved (Gauss and Newton).

use super::maximum_entropy::{
    EntropyWeights, FREE, STRENGTH, WeightBound, WeightTarget, entropy_weights, mean,
};

/// What candidates do: a row per candidate, a number for each target.
#[derive(Debug, Clone, Copy)]
pub struct RatioFeatures<'a> {
    /// The share of runs in which it can be said and held; behind them what is bounded.
    pub held: &'a [Vec<f64>],
    /// The share of runs in which it can be said, for each target.
    pub defined: &'a [Vec<f64>],
}

/// The share of a mixture; `None` where it cannot be said of anybody. Where it can of everybody, it is the mean.
pub fn weighed_ratio(features: RatioFeatures, weights: &[f64], column: usize) -> Option<f64> {
    let held = mean(features.held, weights, column);
    if features.is_whole(column) {
        return Some(held);
    }
    let defined = mean(features.defined, weights, column);
    (defined > NOBODY).then(|| held / defined)
}

/// As [`super::maximum_entropy_within`], of ratios; mismatches are those of the ratios. `None` where a target can be said of nobody, or where no
/// weights were found.
///
/// # Panics
/// As [`super::maximum_entropy_within`].
pub fn ratio_weights(
    errors: f64,
    features: RatioFeatures,
    targets: &[WeightTarget],
    bounds: &[WeightBound],
) -> Option<EntropyWeights> {
    assert!(errors > 0.0, "a tolerance is positive");
    let (found, is_least) = features.solve(targets, bounds, STRENGTH * errors * errors)?;
    is_least.then_some(found)
}

/// As [`super::nearest_mixture`], of ratios. Where some target is out of reach, there may be nothing nearest: ratios that are of fewer and
/// fewer come nearer and nearer, and what is found is one of them.
///
/// # Panics
/// As [`super::maximum_entropy_within`].
pub fn nearest_ratios(
    features: RatioFeatures,
    targets: &[WeightTarget],
    bounds: &[WeightBound],
) -> Option<EntropyWeights> {
    let is_whole = (0..targets.len()).all(|column| features.is_whole(column));
    Some(features.solve(targets, bounds, if is_whole { FREE } else { NEARLY_FREE })?.0)
}

/// At which weights are held to equal ones by little: freer ones would let ratios be of next to nobody.
const NEARLY_FREE: f64 = 1e-2;
/// A share of runs that is none.
const NOBODY: f64 = 1e-12;
const MOST_STEPS: usize = 200;
/// Of ratios, in their errors.
const CONVERGED: f64 = 1e-9;
/// Of what is least.
const ROUNDING: f64 = 1e-12;
/// The smallest part of a step.
const LEAST_PART: f64 = 1e-9;

impl RatioFeatures<'_> {
    fn is_whole(self, column: usize) -> bool {
        self.defined.iter().all(|row| row[column] == 1.0)
    }

    /// The weights, and whether none about them are better; `None` where a target can be said of nobody.
    fn solve(
        self,
        targets: &[WeightTarget],
        bounds: &[WeightBound],
        strength: f64,
    ) -> Option<(EntropyWeights, bool)> {
        let partly: Vec<usize> = (0..targets.len()).filter(|column| !self.is_whole(*column)).collect();
        if partly.is_empty() {
            return Some((entropy_weights(self.held, targets, bounds, strength), true));
        }
        let about = |column: usize, ratio: f64, weights: &[f64]| {
            let defined = mean(self.defined, weights, column);
            (defined > NOBODY).then_some(Centre { column, ratio, defined })
        };
        let at = |weights: &[f64]| -> Option<Vec<Centre>> {
            let centre = |column: &usize| {
                let ratio = weighed_ratio(self, weights, *column)?;
                about(*column, ratio, weights)
            };
            partly.iter().map(centre).collect()
        };
        let equal = vec![1.0 / self.held.len() as f64; self.held.len()];
        let of_targets: Option<Vec<Centre>> =
            partly.iter().map(|column| about(*column, targets[*column].value, &equal)).collect();
        let mut found = entropy_weights(&self.influences(&of_targets?), targets, bounds, strength);
        let mut is_least = false;
        for _ in 0..MOST_STEPS {
            let centres = at(&found.weights)?;
            let full = entropy_weights(&self.influences(&centres), targets, bounds, strength);
            if at(&full.weights).is_some_and(|moved| Centre::are_near(&moved, &centres, targets)) {
                (found, is_least) = (full, true);
                break;
            }
            let most = self.cost(&found.weights, targets, strength)?;
            let most = most + ROUNDING * (1.0 + most);
            let step = |part: f64| -> Vec<f64> {
                let way = found.weights.iter().zip(&full.weights);
                way.map(|(from, to)| from + part * (to - from)).collect()
            };
            let parts = std::iter::successors(Some(1.0), |part| Some(part * 0.5));
            let next = parts
                .take_while(|part| *part >= LEAST_PART)
                .map(step)
                .find(|next| self.cost(next, targets, strength).is_some_and(|cost| cost <= most));
            let Some(next) = next else { break };
            found = EntropyWeights { weights: next, ..full };
        }
        for (column, target) in targets.iter().enumerate() {
            let ratio = weighed_ratio(self, &found.weights, column)?;
            found.mismatches[column] = (ratio - target.value) / target.error;
        }
        Some((found, is_least))
    }

    /// The features about these centres.
    fn influences(self, centres: &[Centre]) -> Vec<Vec<f64>> {
        let mut rows = self.held.to_vec();
        for (row, defined) in rows.iter_mut().zip(self.defined) {
            for Centre { column, ratio, defined: all } in centres {
                row[*column] = ratio + (row[*column] - ratio * defined[*column]) / all;
            }
        }
        rows
    }

    /// What is least at the weights: `None` where a ratio is of nobody.
    fn cost(self, weights: &[f64], targets: &[WeightTarget], strength: f64) -> Option<f64> {
        let number = weights.len() as f64;
        let entropy = |weight: &f64| if *weight > 0.0 { weight * libm::log(weight * number) } else { 0.0 };
        let mut cost: f64 = weights.iter().map(entropy).sum();
        for (column, target) in targets.iter().enumerate() {
            let missed = (weighed_ratio(self, weights, column)? - target.value) / target.error;
            cost += missed * missed / (2.0 * strength);
        }
        Some(cost)
    }
}

/// About what a ratio is made linear.
#[derive(Debug, Clone, Copy)]
struct Centre {
    column: usize,
    ratio: f64,
    /// In which share of all runs it can be said.
    defined: f64,
}

impl Centre {
    fn are_near(one: &[Self], other: &[Self], targets: &[WeightTarget]) -> bool {
        one.iter().zip(other).all(|(one, other)| {
            (one.ratio - other.ratio).abs() <= CONVERGED * targets[one.column].error
                && (one.defined - other.defined).abs() <= CONVERGED * one.defined
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::{maximum_entropy_within, nearest_mixture};
    use crate::random::Stream;
    use proptest::prelude::*;

    type Rows = Vec<Vec<f64>>;

    /// What candidates do where they are there, how often they are there, and what is wanted.
    fn problem(seed: u64, candidates: usize, columns: usize) -> (Rows, Rows, Vec<WeightTarget>) {
        let mut stream = Stream::seeded(seed);
        let (mut held, mut defined) = (Vec::new(), Vec::new());
        for _ in 0..candidates {
            // Who is never there is one of them.
            let there: Vec<f64> = (0..columns).map(|_| (1.2 * stream.uniform() - 0.2).max(0.0)).collect();
            held.push(there.iter().map(|there| there * stream.uniform()).collect());
            defined.push(there);
        }
        let target =
            |_| WeightTarget { value: 0.3 + 0.4 * stream.uniform(), error: 0.01 + 0.1 * stream.uniform() };
        (held, defined, (0..columns).map(target).collect())
    }

    fn ratios(held: &Rows, defined: &Rows, weights: &[f64]) -> Vec<f64> {
        let sum = |rows: &Rows, column: usize| -> f64 {
            rows.iter().zip(weights).map(|(row, weight)| weight * row[column]).sum()
        };
        (0..held[0].len()).map(|column| sum(held, column) / sum(defined, column)).collect()
    }

    /// What is least, written down once more.
    fn cost(held: &Rows, defined: &Rows, targets: &[WeightTarget], strength: f64, weights: &[f64]) -> f64 {
        let number = weights.len() as f64;
        let entropy: f64 =
            weights.iter().filter(|one| **one > 0.0).map(|one| one * (one * number).ln()).sum();
        let missed = ratios(held, defined, weights).into_iter().zip(targets);
        entropy
            + missed.map(|(ratio, target)| ((ratio - target.value) / target.error).powi(2)).sum::<f64>()
                / (2.0 * strength)
    }

    #[test]
    fn of_three_candidates_no_other_weights_are_better() {
        let mut held_against = 0;
        for seed in 0..150 {
            let (held, defined, targets) = problem(seed, 3, 2);
            let features = RatioFeatures { held: &held, defined: &defined };
            // All weights on a fine grid.
            let steps = 200;
            let mut least = f64::INFINITY;
            for one in 0..=steps {
                for other in 0..=steps - one {
                    let third = steps - one - other;
                    let weights = [one, other, third].map(|part| f64::from(part) / f64::from(steps));
                    let there = ratios(&held, &defined, &weights).iter().all(|ratio| ratio.is_finite());
                    if there {
                        least = least.min(cost(&held, &defined, &targets, 1.0, &weights));
                    }
                }
            }
            // Where targets are far out of reach there may be several minima, or none; then nobody is weighed.
            match ratio_weights(1.0, features, &targets, &[]) {
                Some(found) if found.mismatches.iter().all(|one| one.abs() < 2.0) => {
                    let own = cost(&held, &defined, &targets, 1.0, &found.weights);
                    assert!(own <= least + 1e-9, "{own} where the grid has {least}, seed {seed}");
                    held_against += 1;
                }
                _ => assert!(least > 2.0, "the grid has {least}, seed {seed}"),
            }
        }
        assert!(held_against > 20, "{held_against} of 150");
    }

    #[test]
    fn whoever_is_always_there_is_weighed_as_before_to_the_last_bit() {
        for seed in 0..50 {
            let (mut held, _, targets) = problem(seed, 60, 4);
            held.iter_mut().for_each(|row| row.push(row[0] + 1.0));
            let defined = vec![vec![1.0; 4]; 60];
            let features = RatioFeatures { held: &held, defined: &defined };
            let bounds = [WeightBound { value: 1.25, within: 0.02 }];
            let usual = maximum_entropy_within(0.7, &held, &targets, &bounds);
            assert_eq!(ratio_weights(0.7, features, &targets, &bounds), Some(usual));
            let usual = nearest_mixture(&held, &targets, &bounds);
            assert_eq!(nearest_ratios(features, &targets, &bounds), Some(usual));
        }
    }

    #[test]
    fn small_errors_are_met_and_the_smallest_change_is_the_linear_one() {
        let (held, defined, mut targets) = problem(7, 300, 4);
        targets.iter_mut().for_each(|target| target.error = 1e-6);
        let features = RatioFeatures { held: &held, defined: &defined };
        let found = ratio_weights(1.0, features, &targets, &[]).unwrap();
        for (ratio, target) in ratios(&held, &defined, &found.weights).iter().zip(&targets) {
            assert!((ratio - target.value).abs() < 1e-7, "{ratio} for {}", target.value);
        }
        // The same from Σ w (h − t d) = 0 alone.
        let linear: Rows = (held.iter().zip(&defined))
            .map(|(held, defined)| {
                let of =
                    |((held, defined), target): ((&f64, &f64), &WeightTarget)| held - target.value * defined;
                held.iter().zip(defined).zip(&targets).map(of).collect()
            })
            .collect();
        let none = vec![WeightTarget { value: 0.0, error: 1e-6 }; 4];
        let other = maximum_entropy_within(1.0, &linear, &none, &[]);
        for (one, other) in found.weights.iter().zip(&other.weights) {
            assert!((one - other).abs() < 1e-7);
        }
    }

    #[test]
    fn whoever_is_never_there_keeps_a_usual_weight() {
        // The first is there and does it always, the second never does, the third is never there.
        let held = vec![vec![1.0], vec![0.0], vec![0.0]];
        let defined = vec![vec![1.0], vec![1.0], vec![0.0]];
        let features = RatioFeatures { held: &held, defined: &defined };
        let target = [WeightTarget { value: 0.8, error: 1e-6 }];
        let found = ratio_weights(1.0, features, &target, &[]).unwrap().weights;
        // By hand: a = 4 b, and −a ln a − b ln b − c ln c is largest where c = a^0.8 b^0.2.
        assert!((found[0] / found[1] - 4.0).abs() < 1e-4, "{found:?}");
        let by_hand = found[0].powf(0.8) * found[1].powf(0.2);
        assert!((found[2] - by_hand).abs() < 1e-6, "{found:?}");
        // As not doing it, it would have next to no weight.
        let fails = maximum_entropy_within(1.0, &held, &target, &[]).weights;
        assert!(fails[2] < 0.11 && found[2] > 0.3, "{fails:?} {found:?}");
        // Of nobody nothing is found.
        let nobody = vec![vec![0.0]; 3];
        let features = RatioFeatures { held: &nobody, defined: &nobody };
        assert_eq!(ratio_weights(1.0, features, &target, &[]), None);
        assert_eq!(weighed_ratio(features, &found, 0), None);
    }

    #[test]
    fn what_is_in_reach_is_reached_and_what_is_not_is_told() {
        for seed in 0..300 {
            let (held, defined, mut targets) = problem(seed, 40, 5);
            let features = RatioFeatures { held: &held, defined: &defined };
            for errors in [0.1, 1.0] {
                assert!(ratio_weights(errors, features, &targets, &[]).is_some(), "seed {seed}, {errors}");
            }
            // What some mixture does, as every ratio of one is.
            let weights: Vec<f64> = (0..40).map(|one| f64::from(one) / 780.0).collect();
            for (target, ratio) in targets.iter_mut().zip(ratios(&held, &defined, &weights)) {
                target.value = ratio;
            }
            let near = nearest_ratios(features, &targets, &[]).unwrap();
            assert!(near.mismatches.iter().all(|one| one.abs() < 0.3), "{near:?}, seed {seed}");
            // Beyond what any candidate does by itself.
            let most = (0..40).filter(|one| defined[*one][0] > 0.0).map(|one| held[one][0] / defined[one][0]);
            targets[0] = WeightTarget { value: most.fold(0.0, f64::max) + 0.03, error: 0.01 };
            let near = nearest_ratios(features, &targets, &[]).unwrap();
            assert!(near.mismatches[0] < -2.9, "{near:?}, seed {seed}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(30))]
        #[test]
        fn nobody_near_is_better(seed in 0u64..1000, errors in 0.2f64..3.0) {
            let (held, defined, targets) = problem(seed, 50, 3);
            let features = RatioFeatures { held: &held, defined: &defined };
            let found = ratio_weights(errors, features, &targets, &[]).unwrap();
            let of = |weights: &[f64]| cost(&held, &defined, &targets, errors * errors, weights);
            let best = of(&found.weights);
            for pair in 0..49 {
                for part in [0.01, -0.01] {
                    let by = part * found.weights[pair].min(found.weights[pair + 1]);
                    let mut other = found.weights.clone();
                    other[pair] += by;
                    other[pair + 1] -= by;
                    prop_assert!(of(&other) >= best - 1e-12);
                }
            }
        }

        #[test]
        fn the_order_of_candidates_and_of_targets_changes_nothing(seed in 0u64..1000, turn in 1usize..40) {
            let (mut held, mut defined, mut targets) = problem(seed, 40, 4);
            let found = ratio_weights(1.0, RatioFeatures { held: &held, defined: &defined }, &targets, &[]);
            for rows in [&mut held, &mut defined] {
                rows.rotate_left(turn);
                rows.iter_mut().for_each(|row| row.reverse());
            }
            targets.reverse();
            let features = RatioFeatures { held: &held, defined: &defined };
            let mut other = ratio_weights(1.0, features, &targets, &[]).unwrap().weights;
            other.rotate_right(turn);
            for (one, other) in found.unwrap().weights.iter().zip(&other) {
                prop_assert!((one - other).abs() < 1e-8);
            }
        }
    }
}
