//! P-values of many comparisons of the same pairs, adjusted for each other by exchanging base and candidate within pairs, the same pairs
//! in all comparisons: what changes together counts as little more than one.
//!
//! Source: P. H. Westfall & S. S. Young, Resampling-Based Multiple Testing, 1993, section 2.8 (step-down maxT).

use std::collections::BTreeSet;

use crate::random::Stream;

/// Up to so many pairs that differ, every way to exchange them is looked at.
const ALL_WAYS: usize = 12;

/// Ways that are drawn at most.
const MOST_WAYS: usize = 200_000;

/// No more are drawn once each that got worse was so often reached: its share is then known well enough (J. Besag & P. Clifford, Biometrika 78,
/// 1991).
const OFTEN_REACHED: usize = 200;

/// Ways between which that is looked at.
const AT_ONCE: usize = 250;

/// Sums of the same numbers in other orders differ in their last digits.
const ROUNDING: f64 = 1e-9;

/// Differences of one comparison, positive for worse: each with the number of the independent pair that it is of. The same number stands
/// for the same pair in all comparisons.
pub type PairDifferences = Vec<(usize, f64)>;

/// For each comparison: the share of all ways to exchange base and candidate within pairs in which any comparison that got worse by no
/// more, in units of what chance can do to it, gets as much worse as this one; at least what that is of any that got worse by more.
///
/// The chance that the smallest of them is at most α is at most α, whatever the distributions and however the comparisons depend
/// on each other, if for every pair all its differences together might as well have had the other sign. Of comparisons of which some
/// are true, the same holds for the others as far as theirs depend on no true one. `smallest` is the smallest share that matters; what is
/// random is drawn from `seed`.
pub fn max_t(comparisons: &[PairDifferences], smallest: f64, seed: u64) -> Vec<f64> {
    let scaled: Vec<PairDifferences> = comparisons.iter().map(|own| in_units_of_chance(own)).collect();
    let differing: BTreeSet<usize> = scaled.iter().flatten().map(|(pair, _)| *pair).collect();
    let differing: Vec<usize> = differing.into_iter().collect();
    let seen: Vec<f64> = scaled.iter().map(|own| own.iter().map(|(_, one)| one).sum()).collect();
    let mut order: Vec<usize> = (0..scaled.len()).collect();
    order.sort_by(|left, right| seen[*right].total_cmp(&seen[*left]));
    let mut signs = vec![1.0; differing.last().map_or(0, |last| last + 1)];
    let mut as_far = vec![0_usize; scaled.len()];
    let count = |signs: &[f64], as_far: &mut [usize]| {
        let mut largest = f64::NEG_INFINITY;
        for index in order.iter().rev() {
            let sum: f64 = scaled[*index].iter().map(|(pair, one)| signs[*pair] * one).sum();
            largest = largest.max(sum);
            as_far[*index] += usize::from(largest >= seen[*index] - ROUNDING);
        }
    };
    let share: Box<dyn Fn(usize) -> f64> = if differing.len() <= ALL_WAYS {
        let ways = 1_usize << differing.len();
        for way in 0..ways {
            for (place, pair) in differing.iter().enumerate() {
                signs[*pair] = if (way >> place) & 1 == 1 { -1.0 } else { 1.0 };
            }
            count(&signs, &mut as_far);
        }
        Box::new(move |as_far| as_far as f64 / ways as f64)
    } else {
        let most = ((20.0 / smallest).ceil() as usize).clamp(2000, MOST_WAYS) - 1;
        let mut stream = Stream::seeded(seed);
        let mut drawn = 0;
        while drawn < most {
            for chunk in differing.chunks(64) {
                let mut bits = stream.bits();
                for pair in chunk {
                    signs[*pair] = if bits & 1 == 1 { -1.0 } else { 1.0 };
                    bits >>= 1;
                }
            }
            count(&signs, &mut as_far);
            drawn += 1;
            let is_known = |index: &usize| seen[*index] <= 0.0 || as_far[*index] >= OFTEN_REACHED;
            if drawn % AT_ONCE == 0 && order.iter().all(is_known) {
                break;
            }
        }
        // What was seen is one of the ways.
        Box::new(move |as_far| (as_far + 1) as f64 / (drawn + 1) as f64)
    };
    let mut adjusted = vec![1.0; scaled.len()];
    let mut largest = 0.0_f64;
    for index in order {
        // What did not get worse is as far in at least half of the ways.
        largest = if seen[index] > 0.0 { largest.max(share(as_far[index])) } else { 1.0 };
        adjusted[index] = largest;
    }
    adjusted
}

/// Those that differ, divided by the standard deviation of their sum over all ways to exchange.
fn in_units_of_chance(differences: &[(usize, f64)]) -> PairDifferences {
    let spread = differences.iter().map(|(_, one)| one * one).sum::<f64>().sqrt();
    let kept = differences.iter().filter(|(_, one)| *one != 0.0);
    kept.map(|(pair, one)| (*pair, one / spread)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::holm;

    fn of(differences: &[f64]) -> PairDifferences {
        differences.iter().copied().enumerate().collect()
    }

    #[test]
    fn alone_it_is_the_exact_test_of_signs() {
        assert_eq!(max_t(&[of(&[0.5; 8])], 0.01, 1), [1.0 / 256.0]);
        // Sum 4 of {1, 2, 3}: only 6 and 4 are as large.
        assert_eq!(max_t(&[of(&[-1.0, 2.0, 3.0])], 0.01, 1), [2.0 / 8.0]);
        assert_eq!(max_t(&[of(&[-1.0, 0.0]), of(&[])], 0.01, 1), [1.0, 1.0]);
        assert!(max_t(&[], 0.01, 1).is_empty());
    }

    /// What is the same comparison under several names counts once, where Holm takes each for another.
    #[test]
    fn what_changes_together_counts_once() {
        let one = of(&[1.0, 2.0, 0.5, 1.0, 3.0, 1.0]);
        let all =
            vec![one.clone(), one.iter().map(|(pair, size)| (*pair, 100.0 * size)).collect(), one.clone()];
        assert_eq!(max_t(&all, 0.01, 1), [1.0 / 64.0; 3]);
        assert_eq!(holm(&[1.0 / 64.0; 3]), [3.0 / 64.0; 3]);
    }

    /// Of two comparisons of other pairs, by hand: both sums are as large as 2 in 1/4 of the ways each, so that one of them is in
    /// 1 - (3/4)^2 = 7/16. Where one got less worse in its own units, it is adjusted for itself alone.
    #[test]
    fn independent_comparisons_by_hand() {
        let first: PairDifferences = vec![(0, 1.0), (1, 1.0)];
        let second: PairDifferences = vec![(2, 1.0), (3, 1.0)];
        assert_eq!(max_t(&[first.clone(), second], 0.01, 1), [7.0 / 16.0; 2]);
        // (1, 1, 1) sums to 3/sqrt(3) = 1.73, once in 8 ways; two of one sign to 1.41, once in 4.
        let three: PairDifferences = vec![(2, 1.0), (3, 1.0), (4, 1.0)];
        let found = max_t(&[first, three], 0.01, 1);
        assert_eq!(found[1], 1.0 / 8.0);
        // 1.41 or more: 1/4 of the first; of the three only 1/8; at least one of both.
        assert_eq!(found[0], f64::max(1.0 / 8.0, 1.0 / 4.0));
    }

    #[test]
    fn many_pairs_are_drawn_and_agree_with_all_ways() {
        let mut stream = Stream::seeded(4);
        let differences = |count: usize, stream: &mut Stream| -> Vec<PairDifferences> {
            (0..4).map(|_| of(&(0..count).map(|_| 0.7 + stream.normal()).collect::<Vec<_>>())).collect()
        };
        let twelve = differences(12, &mut stream);
        let exact = max_t(&twelve, 0.001, 1);
        // A thirteenth pair that differs by next to nothing: ways are drawn.
        let mut thirteen = twelve.clone();
        thirteen[0].push((12, 1e-6));
        for (exact, drawn) in exact.iter().zip(max_t(&thirteen, 0.001, 1)) {
            assert!((exact - drawn).abs() < 4.0 * (exact * (1.0 - exact) / 20_000.0).sqrt() + 1e-4);
        }
        assert_eq!(max_t(&thirteen, 0.001, 1), max_t(&thirteen, 0.001, 1));
    }

    /// Twenty comparisons that depend on each other, nothing changed: any false alarm in at most 5 % of 1,000 experiments.
    #[test]
    fn false_alarms_are_as_stated() {
        let mut alarms = 0;
        for seed in 0..1000 {
            let mut stream = Stream::seeded(seed);
            let mut all = vec![PairDifferences::new(); 20];
            for pair in 0..15 {
                let shared = stream.normal();
                for own in &mut all {
                    // Heavy tails, symmetric.
                    let one = shared + 0.3 * stream.normal();
                    own.push((pair, one * one * one));
                }
            }
            let least = max_t(&all, 0.05, seed).into_iter().fold(1.0, f64::min);
            alarms += usize::from(least <= 0.05);
        }
        // 50 are expected; one standard error is 7.
        assert!((25..=71).contains(&alarms), "{alarms}");
    }

    /// Shares that are large are known after few ways: within their error what all ways would give.
    #[test]
    fn large_shares_need_few_ways() {
        let mut stream = Stream::seeded(8);
        let comparisons: Vec<PairDifferences> =
            (0..5).map(|_| of(&(0..11).map(|_| 0.2 + stream.normal()).collect::<Vec<_>>())).collect();
        let exact = max_t(&comparisons, 0.001, 1);
        // The same with a thirteenth pair that hardly matters, so that ways are drawn.
        let drawn: Vec<PairDifferences> = comparisons
            .iter()
            .map(|one| one.iter().copied().chain([(11, 1e-9), (12, 1e-9)]).collect())
            .collect();
        for (exact, drawn) in exact.iter().zip(max_t(&drawn, 0.001, 1)) {
            assert!((exact - drawn).abs() < 0.25 * exact, "{exact} {drawn}");
        }
    }
}
