//! How much a metric's mean changes over pairs of runs, and whether by more than a margin.
//!
//! Two questions with two answers. *Did anything change?* is answered exactly, whatever the metric's distribution, by
//! exchanging base and candidate within pairs. *By how much?* is answered by resampling, studentised, with Student's
//! interval as the least width. Of differences that are all equal resampling knows no others: how far the mean is from them
//! is then bounded by the limits of the metric or not at all, and that it is beyond a margin shown by exchanging alone.

use super::Interval;
use super::bounded_mean::{IndependentUnit, mean_of_bounded};
use super::strata::{Estimate, Strata};
use crate::distributions::student_above;
use crate::random::Stream;

/// A probability below this, from the first resamples, is looked at again with more of them.
const WORTH_A_CLOSER_LOOK: f64 = 0.02;
const MOST_DRAWS: usize = 2_000_000;

/// The mean difference over independent pairs.
#[derive(Debug, Clone)]
pub struct MeanChange {
    differences: Strata,
    estimate: Estimate,
    /// Studentised deviations of the first resamples, sorted; empty where all differences are equal.
    deviations: Vec<f64>,
    /// How far two values can be apart at most, if anything limits that.
    widest: Option<f64>,
    seed: u64,
}

impl MeanChange {
    /// Of `differences`, one per pair; `None` of none. What is random is drawn from `seed`.
    pub fn new(differences: Vec<f64>, seed: u64) -> Option<Self> {
        Self::of(Strata::one(differences), seed)
    }

    /// Of differences of several kinds of pairs, of which it is no matter of chance how many there are: a mean over all of them, whose
    /// error is that within each kind.
    pub fn stratified(differences: Vec<Vec<f64>>, seed: u64) -> Option<Self> {
        Self::of(Strata::new(differences), seed)
    }

    fn of(differences: Strata, seed: u64) -> Option<Self> {
        let estimate = match differences.values() {
            [] => return None,
            [only] => Estimate { value: *only, error: f64::INFINITY },
            _ => differences.estimate(),
        };
        let varies = estimate.error > 0.0 && estimate.error.is_finite();
        let deviations = if varies { differences.resampled(seed) } else { Vec::new() };
        Some(Self { differences, estimate, deviations, widest: None, seed })
    }

    /// Where no difference can be larger than `widest`, if there is such a limit.
    pub fn limited(self, widest: Option<f64>) -> Self {
        Self { widest, ..self }
    }

    /// Pairs that were told.
    pub fn pairs(&self) -> usize {
        self.differences.values().len()
    }

    /// The mean difference.
    pub fn change(&self) -> f64 {
        self.estimate.value
    }

    /// Its standard error; infinite of one pair.
    pub fn error(&self) -> f64 {
        self.estimate.error
    }

    /// Where the mean difference of all pairs there could be lies, at two-sided `confidence`: at each end the farther
    /// of bootstrap-t's and Student's. Of differences that are all equal, and not 0, what follows from how far two values
    /// can be apart. Ends are infinite where nothing bounds them.
    pub fn interval(&self, confidence: f64) -> Interval {
        let Estimate { value, error } = self.estimate;
        let anything = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };
        if error == 0.0 && value == 0.0 {
            return Interval { low: value, high: value };
        }
        if error == 0.0 {
            let units: Vec<IndependentUnit> =
                self.differences.values().iter().map(|one| IndependentUnit::of_run(Some(*one))).collect();
            let each = 0.5 * (1.0 + confidence);
            let bounded = self.widest.and_then(|widest| mean_of_bounded(&units, (-widest, widest), each));
            return bounded.unwrap_or(anything);
        }
        if self.deviations.is_empty() {
            return anything;
        }
        self.estimate.interval(&self.deviations, self.freedom(), confidence)
    }

    /// The p-value of "the mean difference is at most `bound`". `smallest` is the smallest one that matters.
    ///
    /// From resampling, so approximate. Where all differences are equal and above the bound it is that of exchanging base and
    /// candidate around the bound, which is exact if no side of it is the likelier one.
    pub fn above(&self, bound: f64, smallest: f64) -> f64 {
        let Estimate { value, error } = self.estimate;
        if value <= bound {
            return 1.0;
        }
        if error == 0.0 {
            return libm::pow(0.5, self.pairs() as f64);
        }
        if self.deviations.is_empty() {
            return 1.0;
        }
        let seen = (value - bound) / error;
        let as_far = self.deviations.iter().filter(|deviation| **deviation >= seen).count();
        let mut p = (as_far + 1) as f64 / (self.deviations.len() + 1) as f64;
        if p < WORTH_A_CLOSER_LOOK {
            let seed = self.seed.wrapping_add(1);
            let mut again = self.differences.deviations(seed);
            p = probability(smallest, || again.next().is_some_and(|deviation| deviation >= seen));
        }
        p.max(student_above(seen, self.freedom()))
    }

    /// The p-value of "base and candidate differ by chance only", against a larger mean in the candidate: the share of
    /// all ways to exchange base and candidate within pairs that give so large a difference. Exact for any
    /// distribution; `smallest` is the smallest p-value that matters.
    pub fn exchange(&self, smallest: f64) -> f64 {
        let differing: Vec<f64> =
            self.differences.values().iter().copied().filter(|one| *one != 0.0).collect();
        let sum: f64 = differing.iter().sum();
        if sum <= 0.0 {
            return 1.0;
        }
        // Sums of the same numbers in other orders differ in their last digits.
        let sum = sum - 1e-9 * differing.iter().map(|one| one.abs()).sum::<f64>();
        if differing.len() <= 12 {
            let ways = 1_u64 << differing.len();
            let as_large = (0..ways).filter(|way| signed_sum(&differing, *way) >= sum).count();
            return as_large as f64 / ways as f64;
        }
        let mut stream = Stream::seeded(self.seed.wrapping_add(2));
        probability(smallest, || {
            let exchanged: f64 = differing.chunks(64).map(|chunk| signed_sum(chunk, stream.bits())).sum();
            exchanged >= sum
        })
    }

    /// Degrees of freedom of its standard error.
    pub fn freedom(&self) -> f64 {
        self.differences.freedom()
    }
}

/// The sum with the sign of every number turned whose bit is set.
fn signed_sum(numbers: &[f64], bits: u64) -> f64 {
    let signed = |(place, number): (usize, &f64)| if (bits >> place) & 1 == 1 { -number } else { *number };
    numbers.iter().enumerate().map(signed).sum()
}

/// How often something random happens, told well enough where that is about `smallest`, and else as well as need be.
fn probability(smallest: f64, mut happens: impl FnMut() -> bool) -> f64 {
    let most = ((20.0 / smallest).ceil() as usize).clamp(2000, MOST_DRAWS);
    let (mut happened, mut drawn) = (0_usize, 0_usize);
    while drawn < most && happened < 200 {
        // Something as likely as the smallest would have happened by now, but for 3 times in 10,000.
        if happened == 0 && drawn as f64 >= 8.0 / smallest {
            break;
        }
        happened += usize::from(happens());
        drawn += 1;
    }
    (happened + 1) as f64 / (drawn + 1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(differences: &[f64]) -> MeanChange {
        MeanChange::new(differences.to_vec(), 7).unwrap()
    }

    fn normal(count: usize, mean: f64, seed: u64) -> Vec<f64> {
        let mut stream = Stream::seeded(seed);
        (0..count).map(|_| mean + stream.normal()).collect()
    }

    #[test]
    fn the_interval_is_no_narrower_than_students() {
        let differences = normal(30, 0.0, 5);
        let found = change(&differences);
        let interval = found.interval(0.95);
        // The 97.5 % point of Student's t with 29 degrees of freedom.
        let half = 2.045 * found.error();
        assert!(
            interval.low <= found.change() - 0.999 * half && interval.high >= found.change() + 0.999 * half
        );
        assert!(interval.high - interval.low < 1.4 * 2.0 * half, "{interval:?}");
    }

    #[test]
    fn p_values_and_intervals_agree() {
        for seed in 0..20 {
            let found = change(&normal(25, 0.5, seed));
            let low = found.interval(0.95).low;
            assert!(found.above(low - 0.02, 0.025) < 0.027, "{seed}");
            assert!(found.above(low + 0.02, 0.025) > 0.023, "{seed}");
        }
    }

    /// Of five kinds of pairs that differ by far more than the pairs of one do: which kinds there are is no chance, and widens nothing.
    #[test]
    fn in_strata_intervals_cover_as_stated_and_are_narrower() {
        let mut stream = Stream::seeded(20_261_124);
        let draws: [fn(&mut Stream) -> f64; 2] =
            [Stream::normal, |stream| -libm::log(stream.uniform()) - 1.0];
        for (count, draw) in [(6, draws[0]), (6, draws[1]), (20, draws[1])] {
            let (mut covered, mut width, mut pooled_width) = (0, 0.0, 0.0);
            const EXPERIMENTS: u64 = 400;
            for seed in 0..EXPERIMENTS {
                // Kinds have means 0, 2, 4, 6 and 8, of which 4 is the mean.
                let kind = |kind: i32, stream: &mut Stream| -> Vec<f64> {
                    (0..count).map(|_| 2.0 * f64::from(kind) + draw(stream)).collect()
                };
                let kinds: Vec<Vec<f64>> = (0..5).map(|number| kind(number, &mut stream)).collect();
                let pooled = MeanChange::new(kinds.concat(), seed).unwrap().interval(0.95);
                let found = MeanChange::stratified(kinds, seed).unwrap().interval(0.95);
                covered += u64::from(found.contains(4.0));
                width += found.high - found.low;
                pooled_width += pooled.high - pooled.low;
            }
            let share = covered as f64 / EXPERIMENTS as f64;
            // Three standard errors of the simulation are 3.3 %.
            assert!(share > 0.917, "{count}: {share}");
            assert!(width < 0.6 * pooled_width, "{count}: {width} {pooled_width}");
        }
    }

    #[test]
    fn exchanging_is_exact() {
        // All eight the same way: 1 of 256.
        assert_eq!(change(&[0.5; 8]).exchange(0.001), 1.0 / 256.0);
        // Pairs that do not differ say nothing.
        let mut with_zeros = vec![0.0; 50];
        with_zeros.extend([1.0, 2.0, 3.0]);
        assert_eq!(change(&with_zeros).exchange(0.001), 1.0 / 8.0);
        assert_eq!(change(&[-1.0, -2.0]).exchange(0.001), 1.0);
        assert_eq!(change(&[0.0, 0.0]).exchange(0.001), 1.0);
        // Sum 4 of {1, 2, 3}: only 6 and 4 are as large.
        assert_eq!(change(&[-1.0, 2.0, 3.0]).exchange(0.001), 2.0 / 8.0);
        // Many pairs, drawn ways: near what the normal distribution says.
        let found = change(&normal(200, 0.2, 3));
        let p = found.exchange(0.001);
        let student = student_above(found.change() / found.error(), 199.0);
        assert!((p - student).abs() < 0.2 * student + 0.001, "{p} {student}");
    }

    #[test]
    fn small_probabilities_are_told_apart() {
        let found = change(&normal(100, 1.0, 9));
        assert!(found.above(0.0, 1e-4) < 2e-5 && found.exchange(1e-4) < 2e-5);
    }

    #[test]
    fn what_resampling_cannot_tell() {
        assert!(MeanChange::new(Vec::new(), 1).is_none());
        let one = change(&[3.0]);
        assert_eq!((one.above(0.0, 0.01), one.exchange(0.01)), (1.0, 0.5));
        assert_eq!(one.interval(0.95), Interval { low: f64::NEG_INFINITY, high: f64::INFINITY });
        let equal = change(&[0.25; 5]);
        assert_eq!(equal.interval(0.95), Interval { low: f64::NEG_INFINITY, high: f64::INFINITY });
        // Exchanged around 0.2, one of 32 ways gives as much.
        assert_eq!((equal.above(0.2, 0.01), equal.above(0.25, 0.01)), (1.0 / 32.0, 1.0));
        // Limits bound what was not seen, the better the more pairs there are.
        let limited = |count| change(&vec![0.25; count]).limited(Some(1.0)).interval(0.95);
        let (few, many) = (limited(5), limited(500));
        assert!(few.low < 0.0 && few.high > 0.5 && few.low >= -1.0 && few.high <= 1.0, "{few:?}");
        assert!(many.low > 0.2 && many.low < 0.25 && many.high > 0.25 && many.high < 0.3, "{many:?}");
        // What never differs is another matter.
        assert_eq!(change(&[0.0; 5]).interval(0.95), Interval { low: 0.0, high: 0.0 });
        // Two of forty differ: no upper end, since resamples may miss both.
        let mut few = vec![0.0; 38];
        few.extend([1.0, 2.0]);
        let interval = change(&few).interval(0.95);
        assert_eq!(interval.high, f64::INFINITY);
        assert!(change(&few).above(0.0, 0.001) > 0.05);
    }
}
