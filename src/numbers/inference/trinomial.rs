//! How likely it is that pairs disagree so often, and so often in favour of one side.

use crate::distributions::{binomial_at_least, binomial_at_most};

/// Numbers of disagreeing pairs less likely than this on either side are left out of sums.
const NEGLIGIBLE: f64 = 1e-13;

/// The first of 0..=`most` for which something holds that holds from there on; one more if it never does.
pub(super) fn first(most: u64, holds: impl Fn(u64) -> bool) -> u64 {
    let (mut from, mut to) = (0, most + 1);
    while from < to {
        let middle = from + (to - from) / 2;
        if holds(middle) { to = middle } else { from = middle + 1 }
    }
    from
}

/// The probability that, among `pairs` of which each has the event in the base only with probability `base`, in the
/// candidate only with probability `candidate`, and in both or neither else, at least `least(k)` of the k disagreeing
/// ones are the candidate's. `factorials` are the logarithms of those up to the pairs.
pub(super) fn probability(
    pairs: u64,
    mut least: impl FnMut(u64) -> u64,
    factorials: &[f64],
    base: f64,
    candidate: f64,
) -> f64 {
    let candidate = candidate.max(0.0);
    let differing = (base + candidate).min(1.0);
    if differing <= 0.0 {
        return if least(0) == 0 { 1.0 } else { 0.0 };
    }
    let of_all = Binomial::new(factorials, differing);
    let share = candidate / (base + candidate);
    let of_differing = Binomial::new(factorials, share);
    let start = first(pairs, |count| binomial_at_most(count, pairs, differing) > NEGLIGIBLE);
    let beyond = first(pairs, |count| binomial_at_least(count, pairs, differing) <= NEGLIGIBLE);
    // P(at least `from` of `count`), kept up to date while both go on.
    let mut from = least(start);
    let mut above = binomial_at_least(from, start, share);
    let mut total = 0.0;
    for count in start..beyond {
        if count > start && from > 0 {
            above += of_differing.share * of_differing.exactly(from - 1, count - 1);
        }
        let least = least(count);
        while from < least {
            above -= of_differing.exactly(from, count);
            from += 1;
        }
        while from > least {
            from -= 1;
            above += of_differing.exactly(from, count);
        }
        total += of_all.exactly(count, pairs) * above.clamp(0.0, 1.0);
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
    fn exactly(&self, k: u64, n: u64) -> f64 {
        if k > n {
            return 0.0;
        }
        // 0 times an infinite logarithm is nothing.
        let times = |count: u64, logarithm: f64| if count == 0 { 0.0 } else { count as f64 * logarithm };
        let of = |count: u64| self.factorials[count as usize];
        let ways = of(n) - of(k) - of(n - k);
        libm::exp(ways + times(k, self.log_share) + times(n - k, self.log_rest))
    }
}

/// Logarithms of the factorials of 0..=`most`.
pub(super) fn log_factorials(most: u64) -> Vec<f64> {
    (0..=most).map(|k| libm::lgamma(k as f64 + 1.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [`probability`] where the least number is given for each number of disagreeing pairs.
    fn at_least(least: &[u64], base: f64, candidate: f64) -> f64 {
        let pairs = least.len() as u64 - 1;
        probability(pairs, |count| least[count as usize], &log_factorials(pairs), base, candidate)
    }

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
            let found = at_least(&least, base, candidate);
            assert!((found - sum).abs() < 1e-11, "{least:?}: {found} {sum}");
        }
        assert_eq!(at_least(&[1, 1, 1], 0.0, 0.0), 0.0);
        assert!((at_least(&[1, 1, 2], 0.0, 1.0) - 1.0).abs() < 1e-12);
    }
}
