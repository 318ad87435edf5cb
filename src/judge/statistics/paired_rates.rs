//! How much an event's rate changes over pairs of runs, exactly, and whether by more than a margin.

use super::Interval;
use super::comparison::mcnemar;
use super::proportion::{lower_bound, upper_bound};

/// Shares of disagreeing pairs less likely than this, given what was seen, are left out of account; every p-value
/// pays for it.
const LEFT_OUT: f64 = 1e-7;
/// Places at which the share of disagreeing pairs is tried.
const PLACES: u32 = 24;

/// The p-value of "the rate rises by at most `margin`" from base to candidate, where `only_base` and `only_candidate`
/// of `pairs` had the event in that one only. Exact for independent pairs, however rare the event.
///
/// The largest probability, over the shares of disagreeing pairs that are compatible with what was seen, of counts that
/// speak as much against it; at a margin of 0 no smaller than McNemar's.
///
/// Source: R. L. Berger & D. D. Boos, J. Am. Stat. Assoc. 89, 1994, for the restriction of the unknown share.
pub fn rate_rise(only_base: u64, only_candidate: u64, pairs: u64, margin: f64) -> f64 {
    let seen = standing(only_base, only_candidate, pairs, margin);
    if seen <= 0.0 {
        return 1.0;
    }
    let low = lower_bound(only_base, pairs, 1.0 - LEFT_OUT / 2.0).max(-margin).max(0.0);
    let high = upper_bound(only_base, pairs, 1.0 - LEFT_OUT / 2.0).min((1.0 - margin) / 2.0);
    if low > high {
        return LEFT_OUT;
    }
    // Of so many disagreeing pairs, how many must be the candidate's to speak as much against it; more than there are
    // where none would.
    let speaks = |differing: u64, candidate: u64| {
        standing(differing - candidate, candidate, pairs, margin) >= seen * (1.0 - 1e-12)
    };
    let least: Vec<u64> =
        (0..=pairs).map(|differing| first(differing, |count| speaks(differing, count))).collect();
    let place = |index: u32| low + (high - low) * f64::from(index) / f64::from(PLACES);
    let factorials = log_factorials(pairs);
    let tail = |base: f64| probability(&least, &factorials, base, base + margin);
    let exact = (0..=PLACES).map(|index| tail(place(index))).fold(0.0, f64::max) + LEFT_OUT;
    if margin == 0.0 { exact.max(mcnemar(only_base, only_candidate).more_in_candidate) } else { exact }
        .min(1.0)
}

/// By how many standard errors the rise is beyond the margin: orders what may be seen by how much it says.
fn standing(only_base: u64, only_candidate: u64, pairs: u64, margin: f64) -> f64 {
    let (base, candidate, n) = (only_base as f64, only_candidate as f64, pairs as f64);
    let beyond = candidate - base - margin * n;
    if beyond == 0.0 {
        return 0.0;
    }
    let variance = candidate + base - (candidate - base) * (candidate - base) / n;
    beyond / variance.max(0.0).sqrt()
}

/// The first of 0..=`most` for which something holds that holds from there on; one more if it never does.
fn first(most: u64, holds: impl Fn(u64) -> bool) -> u64 {
    let (mut from, mut to) = (0, most + 1);
    while from < to {
        let middle = from + (to - from) / 2;
        if holds(middle) { to = middle } else { from = middle + 1 }
    }
    from
}

/// Change of an event's rate from base to candidate over `pairs` of runs at two-sided `confidence`: the margins that
/// [`rate_rise`] does not reject, in both directions.
pub fn rate_change(only_base: u64, only_candidate: u64, pairs: u64, confidence: f64) -> Interval {
    let each = (1.0 - confidence) / 2.0;
    Interval {
        low: least_rise(only_base, only_candidate, pairs, each),
        high: -least_rise(only_candidate, only_base, pairs, each),
    }
}

/// The largest margin that is still rejected at `level`.
fn least_rise(only_base: u64, only_candidate: u64, pairs: u64, level: f64) -> f64 {
    let seen = (only_candidate as f64 - only_base as f64) / pairs as f64;
    let (mut rejected, mut kept) = (-1.0, seen);
    // Finer than any number of runs can tell.
    while kept - rejected > 1e-4 {
        let middle = 0.5 * (rejected + kept);
        if rate_rise(only_base, only_candidate, pairs, middle) <= level {
            rejected = middle
        } else {
            kept = middle
        }
    }
    rejected
}

/// The probability that, among pairs of which each has the event in the base only with probability `base`, in the
/// candidate only with probability `candidate`, and in both or neither else, at least `least[k]` of the k disagreeing
/// ones are the candidate's. There are as many pairs as `least` has entries beyond the first; `factorials` are the
/// logarithms of those up to there.
fn probability(least: &[u64], factorials: &[f64], base: f64, candidate: f64) -> f64 {
    let pairs = least.len() - 1;
    let differing = (base + candidate).min(1.0);
    if differing <= 0.0 {
        return if least[0] == 0 { 1.0 } else { 0.0 };
    }
    let of_all = Binomial::new(factorials, differing);
    let of_differing = Binomial::new(factorials, candidate / (base + candidate));
    // P(at least `from` of `count`), kept up to date while both go on.
    let (mut from, mut above) = (0, 1.0);
    let mut total = 0.0;
    for (count, least) in least.iter().enumerate() {
        if count > 0 && from > 0 {
            above += of_differing.share * of_differing.exactly(from - 1, count - 1);
        }
        while from < *least as usize {
            above -= of_differing.exactly(from, count);
            from += 1;
        }
        while from > *least as usize {
            from -= 1;
            above += of_differing.exactly(from, count);
        }
        total += of_all.exactly(count, pairs) * above.max(0.0);
    }
    total.min(1.0)
}

/// Probabilities of single numbers of successes.
struct Binomial<'a> {
    factorials: &'a [f64],
    share: f64,
    log_share: f64,
    log_rest: f64,
}

impl<'a> Binomial<'a> {
    fn new(factorials: &'a [f64], share: f64) -> Self {
        Self { factorials, share, log_share: libm::log(share), log_rest: libm::log1p(-share) }
    }

    /// P(X = k) for n tries.
    fn exactly(&self, k: usize, n: usize) -> f64 {
        if k > n {
            return 0.0;
        }
        // 0 times an infinite logarithm is nothing.
        let times = |count: usize, logarithm: f64| if count == 0 { 0.0 } else { count as f64 * logarithm };
        let ways = self.factorials[n] - self.factorials[k] - self.factorials[n - k];
        libm::exp(ways + times(k, self.log_share) + times(n - k, self.log_rest))
    }
}

fn log_factorials(most: u64) -> Vec<f64> {
    (0..=most).map(|k| libm::lgamma(k as f64 + 1.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::statistics::binomial_at_least;

    #[test]
    fn probabilities_are_sums_over_all_outcomes() {
        let (pairs, base, candidate) = (9_u64, 0.1, 0.25);
        let factorial = |n: u64| (1..=n).map(|k| k as f64).product::<f64>();
        for least in [vec![0; 10], vec![9; 10], (0..=9).map(|k| k / 2 + 1).collect::<Vec<u64>>()] {
            let mut sum = 0.0;
            for b in 0..=pairs {
                for c in (0..=pairs - b).filter(|c| *c >= least[(b + c) as usize]) {
                    let ways = factorial(pairs) / factorial(b) / factorial(c) / factorial(pairs - b - c);
                    sum += ways
                        * f64::powi(base, b as i32)
                        * f64::powi(candidate, c as i32)
                        * f64::powi(1.0 - base - candidate, (pairs - b - c) as i32);
                }
            }
            let found = probability(&least, &log_factorials(pairs), base, candidate);
            assert!((found - sum).abs() < 1e-11, "{least:?}: {found} {sum}");
        }
        assert_eq!(probability(&[1, 1, 1], &log_factorials(2), 0.0, 0.0), 0.0);
        assert!((probability(&[1, 1, 2], &log_factorials(2), 0.0, 1.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_rise_from_nothing_is_as_likely_as_the_binomial_says() {
        // No pair with the event in the base only: 20 of 80 against a margin of 5 points.
        let p = rate_rise(0, 20, 80, 0.05);
        let binomial = binomial_at_least(20, 80, 0.05);
        assert!(p >= binomial && p < 1e-4, "{p} {binomial}");
        assert_eq!(rate_rise(0, 4, 80, 0.05), 1.0);
        // At no margin it is McNemar's or a little more.
        assert!(rate_rise(1, 9, 80, 0.0) >= mcnemar(1, 9).more_in_candidate);
        assert!(rate_rise(1, 9, 80, 0.0) < 0.02);
    }

    #[test]
    fn the_interval_and_the_test_agree() {
        for (base, candidate) in [(0, 0), (0, 12), (3, 9), (12, 0), (40, 40)] {
            let interval = rate_change(base, candidate, 80, 0.95);
            let seen = (candidate as f64 - base as f64) / 80.0;
            assert!(interval.contains(seen), "{interval:?}");
            assert!(rate_rise(base, candidate, 80, interval.low - 2e-4) <= 0.025);
            assert!(rate_rise(base, candidate, 80, interval.low + 2e-4) > 0.025);
            let mirrored = rate_change(candidate, base, 80, 0.95);
            assert_eq!((mirrored.low, mirrored.high), (-interval.high, -interval.low));
        }
        let none = rate_change(0, 0, 100, 0.95);
        assert!(none.low < 0.0 && none.high > 0.0 && none.high < 0.05, "{none:?}");
    }

    /// How often "the rate rises by at most `margin`" is rejected at `level` where it rises by exactly that: by summing
    /// over everything that may be seen, so there is no chance in it.
    fn rejected(pairs: u64, margin: f64, base: f64, level: f64) -> f64 {
        let mut sum = 0.0;
        for differing in 0..=pairs {
            let rejects = |count: u64| rate_rise(differing - count, count, pairs, margin) <= level;
            let mut least: Vec<u64> = (1..=pairs + 1).collect();
            least[differing as usize] = first(differing, rejects);
            if least[differing as usize] <= differing {
                sum += probability(&least, &log_factorials(pairs), base, base + margin);
            }
        }
        sum
    }

    #[test]
    fn the_test_keeps_its_level_whatever_the_share_of_disagreeing_pairs() {
        for (margin, shares) in [(0.0, [0.01, 0.1, 0.2, 0.45]), (0.1, [0.0, 0.02, 0.1, 0.4])] {
            for base in shares {
                let rejected = rejected(30, margin, base, 0.05);
                assert!(rejected <= 0.05, "{rejected} at {margin} and {base}");
            }
        }
        assert!(rejected(30, 0.0, 0.2, 0.05) > 0.02);
    }
}
