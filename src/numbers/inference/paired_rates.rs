//! How much an event's rate changes over pairs of runs, exactly, and whether by more than a margin.
//!
//! Outcomes are ordered by the score statistic, whose variance is the one at the maximum of the likelihood under the
//! margin. (With the variance that was seen, every outcome in which all pairs changed the same way is infinitely far
//! from every margin, and which margins are rejected has no end.) The probability of what speaks as much against a
//! margin still goes up and down with it by a factor of about 2, because the order changes; so a margin is rejected only
//! if all smaller ones are.
//!
//! Sources: T. Tango, Stat. Med. 17, 1998 (the statistic); R. L. Berger & D. D. Boos, J. Am. Stat. Assoc. 89, 1994 (the
//! restriction of the unknown share); C. J. Lloyd & M. V. Moldovan, Stat. Med. 27, 2008 (exact p-values from both).

use super::Interval;
use super::comparison::mcnemar;
use super::share::{lower_bound, upper_bound};
use super::trinomial::{first, log_factorials, probability};

/// Shares of disagreeing pairs less likely than this, given what was seen, are left out of account; every p-value
/// pays for it.
const LEFT_OUT: f64 = 1e-7;
/// Places at which the share of disagreeing pairs is tried, before those around the best one.
const PLACES: u32 = 40;
/// No p-value is exceeded by one of a smaller margin by as large a factor (2.3 at most for up to 40 pairs).
const BEYOND_REACH: f64 = 8.0;

/// The p-value of "the rate rises by at most `margin`" from base to candidate, where `only_base` and `only_candidate`
/// of `pairs` had the event in that one only. Exact for independent pairs, however rare the event; it rises with the
/// margin, which is rounded up to a tenth of a point (a hundredth for more than 1000 pairs).
///
/// The largest probability, over the shares of disagreeing pairs that are compatible with what was seen and over all
/// smaller margins, of counts that speak as much against it; at margins of 0 and more no smaller than McNemar's.
pub fn rate_rise(only_base: u64, only_candidate: u64, pairs: u64, margin: f64) -> f64 {
    Counts::new(only_base, only_candidate, pairs).rise_by_at_most(margin)
}

/// Change of an event's rate from base to candidate over `pairs` of runs at two-sided `confidence`: the margins that
/// [`rate_rise`] does not reject, in both directions.
pub fn rate_change(only_base: u64, only_candidate: u64, pairs: u64, confidence: f64) -> Interval {
    let each = (1.0 - confidence) / 2.0;
    Interval {
        low: Counts::new(only_base, only_candidate, pairs).least_rise(each),
        high: -Counts::new(only_candidate, only_base, pairs).least_rise(each),
    }
}

/// What was seen, and what it takes to ask how likely it was.
struct Counts {
    only_base: u64,
    only_candidate: u64,
    pairs: u64,
    /// Logarithms of the factorials up to the pairs.
    factorials: Vec<f64>,
    /// Margins are looked at in steps of one over this.
    steps: i32,
}

impl Counts {
    fn new(only_base: u64, only_candidate: u64, pairs: u64) -> Self {
        let factorials = log_factorials(pairs);
        let steps = if pairs <= 1000 { 1_000 } else { 10_000 };
        Self { only_base, only_candidate, pairs, factorials, steps }
    }

    fn margin(&self, step: i32) -> f64 {
        f64::from(step) / f64::from(self.steps)
    }

    /// See [`rate_rise`].
    fn rise_by_at_most(&self, margin: f64) -> f64 {
        let last = ((margin * f64::from(self.steps) - 1e-6).ceil() as i32).clamp(-self.steps, self.steps);
        let mut largest: f64 = 0.0;
        for step in (-self.steps..=last).rev() {
            let p = self.p_value(self.margin(step));
            largest = largest.max(p);
            if largest >= 1.0 || p * BEYOND_REACH < largest {
                break;
            }
        }
        let exchanged = mcnemar(self.only_base, self.only_candidate).more_in_candidate;
        if last >= 0 { largest.max(exchanged) } else { largest }
    }

    /// The largest margin that is still rejected at `level`, with all smaller ones.
    fn least_rise(&self, level: f64) -> f64 {
        let p_value = |step: i32| self.p_value(self.margin(step));
        // From where on nothing smaller can be kept; at what was seen everything is.
        let seen = (self.only_candidate as f64 - self.only_base as f64) / self.pairs as f64;
        let (mut far, mut kept) = (-self.steps, (seen * f64::from(self.steps)).ceil() as i32);
        while kept - far > 1 {
            let middle = far + (kept - far) / 2;
            if p_value(middle) * BEYOND_REACH <= level { far = middle } else { kept = middle }
        }
        let kept = (kept..=self.steps).find(|step| p_value(*step) > level).unwrap_or(self.steps);
        let exchanged = mcnemar(self.only_base, self.only_candidate).more_in_candidate;
        let kept = if exchanged > level { kept.min(0) } else { kept };
        self.margin(kept - 1).max(-1.0)
    }

    /// The largest probability, at a rise by exactly `margin`, of counts that speak as much for a larger one.
    fn p_value(&self, margin: f64) -> f64 {
        let pairs = self.pairs;
        let seen = standing(self.only_base, self.only_candidate, pairs, margin);
        if seen <= 0.0 {
            return 1.0;
        }
        let low = lower_bound(self.only_base, pairs, 1.0 - LEFT_OUT / 2.0).max(-margin).max(0.0);
        let high = upper_bound(self.only_base, pairs, 1.0 - LEFT_OUT / 2.0).min((1.0 - margin) / 2.0);
        if low > high {
            return LEFT_OUT;
        }
        // Rounding must not part what is equal.
        let seen = seen - 1e-9 * (1.0 + seen);
        let speaks = |differing: u64, candidate: u64| {
            standing(differing - candidate, candidate, pairs, margin) >= seen
        };
        // Of so many disagreeing pairs, how many must be the candidate's to speak as much against it; more than there
        // are where none would.
        let mut known: Vec<Option<u64>> = vec![None; pairs as usize + 1];
        let mut least = |differing: u64| {
            *known[differing as usize]
                .get_or_insert_with(|| first(differing, |count| speaks(differing, count)))
        };
        let mut tail = |base: f64| probability(pairs, &mut least, &self.factorials, base, base + margin);
        // Closer to each other where shares are small, since that is where probabilities change fast.
        let place = |index: f64| {
            let part = index / f64::from(PLACES);
            low + (high - low) * part * part
        };
        let (mut best, mut largest) = (0.0, 0.0);
        for index in (0..=PLACES).map(f64::from) {
            let likely = tail(place(index));
            if likely > largest {
                (best, largest) = (index, likely);
            }
        }
        for part in [-0.75, -0.5, -0.25, 0.25, 0.5, 0.75] {
            largest = tail(place((best + part).clamp(0.0, f64::from(PLACES)))).max(largest);
        }
        (largest + LEFT_OUT).min(1.0)
    }
}

/// By how many standard errors the rise is beyond the margin, if it is the margin: orders what may be seen by how much it
/// says.
fn standing(only_base: u64, only_candidate: u64, pairs: u64, margin: f64) -> f64 {
    let (base, candidate, n) = (only_base as f64, only_candidate as f64, pairs as f64);
    let beyond = candidate - base - margin * n;
    if beyond.abs() <= 1e-12 * n {
        return 0.0;
    }
    // The share of pairs with the event in the base only that is likeliest under the margin: the larger root of
    // 2 n p² - linear p - base margin (1 - margin).
    let linear = base + candidate + margin * (candidate - base - 2.0 * n);
    let under_root = linear * linear + 8.0 * n * base * margin * (1.0 - margin);
    let share = ((linear + under_root.max(0.0).sqrt()) / (4.0 * n)).max(0.0).max(-margin);
    beyond / (n * (2.0 * share + margin * (1.0 - margin))).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;
    use crate::distributions::binomial_at_least;

    /// [`probability`] where the least number is given for each number of disagreeing pairs.
    fn at_least(least: &[u64], base: f64, candidate: f64) -> f64 {
        let pairs = least.len() as u64 - 1;
        probability(pairs, |count| least[count as usize], &log_factorials(pairs), base, candidate)
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

    /// The likeliest share under a margin, by cutting an interval in parts, and the statistic from it.
    fn score(base: f64, candidate: f64, pairs: f64, margin: f64) -> f64 {
        let (mut low, mut high) = (f64::max(0.0, -margin), (1.0 - margin) / 2.0);
        let likelihood = |share: f64| {
            let term = |count: f64, of: f64| if count == 0.0 { 0.0 } else { count * libm::log(of) };
            term(base, share)
                + term(candidate, share + margin)
                + term(pairs - base - candidate, 1.0 - 2.0 * share - margin)
        };
        for _ in 0..100 {
            let (left, right) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
            if likelihood(left) < likelihood(right) { low = left } else { high = right }
        }
        let share = 0.5 * (low + high);
        (candidate - base - margin * pairs)
            / (pairs * (2.0 * share + margin - margin * margin)).max(0.0).sqrt()
    }

    #[test]
    fn the_statistic_has_the_variance_at_the_largest_likelihood() {
        let n = 40_u64;
        for (b, c) in [(0, 3), (0, 12), (12, 0), (7, 9), (20, 20), (1, 38)] {
            for margin in [-0.6, -0.2, -0.01, 0.01, 0.15, 0.6] {
                let (found, expected) =
                    (standing(b, c, n, margin), score(b as f64, c as f64, n as f64, margin));
                assert!((found - expected).abs() < 1e-4 * (1.0 + expected.abs()), "{b} {c} {margin}");
            }
        }
    }

    /// For every outcome of so many pairs, the largest probability of outcomes that speak as much for a rise beyond each
    /// margin, by sorting all of them and adding them up: nothing is left out. Margins rise.
    fn enumerated(pairs: usize, margins: &[f64], places: u32) -> Vec<((u64, u64), Vec<f64>)> {
        let factorials = log_factorials(pairs as u64);
        let outcomes: Vec<(usize, usize)> =
            (0..=pairs).flat_map(|b| (0..=pairs - b).map(move |c| (b, c))).collect();
        let mut found: Vec<Vec<f64>> = vec![vec![0.0; margins.len()]; outcomes.len()];
        for (column, margin) in margins.iter().enumerate() {
            let stand = |(b, c): (usize, usize)| standing(b as u64, c as u64, pairs as u64, *margin);
            let mut order: Vec<(f64, usize)> =
                outcomes.iter().enumerate().map(|(index, outcome)| (stand(*outcome), index)).collect();
            order.sort_by(|left, right| right.0.total_cmp(&left.0));
            let (low, high) = (f64::max(0.0, -margin), (1.0 - margin) / 2.0);
            for place in 0..=places {
                let part = f64::from(place) / f64::from(places);
                let base = low + (high - low) * part * part;
                let shares = [base, base + margin, 1.0 - 2.0 * base - margin];
                let logarithms = shares.map(|share| libm::log(share.max(0.0)));
                let term = |count: usize, of: usize| {
                    if count == 0 { 0.0 } else { count as f64 * logarithms[of] }
                };
                let mut sum = 0.0;
                for (_, index) in order.iter().take_while(|(standing, _)| *standing > 0.0) {
                    let (b, c) = outcomes[*index];
                    let ways = factorials[pairs] - factorials[b] - factorials[c] - factorials[pairs - b - c];
                    sum += libm::exp(ways + term(b, 0) + term(c, 1) + term(pairs - b - c, 2));
                    let cell: &mut f64 = &mut found[*index][column];
                    *cell = cell.max(sum);
                }
            }
            for (standing, index) in &order {
                if *standing <= 0.0 {
                    found[*index][column] = 1.0;
                }
            }
        }
        outcomes.into_iter().map(|(b, c)| (b as u64, c as u64)).zip(found).collect()
    }

    #[test]
    fn p_values_are_those_of_adding_up_all_outcomes() {
        // Margins at which no two outcomes say the same.
        let margins = [-0.7137, -0.3311, -0.0173, 0.0119, 0.1717, 0.5173];
        for pairs in [1_usize, 4, 11, 24] {
            for ((b, c), expected) in enumerated(pairs, &margins, 300) {
                let counts = Counts::new(b, c, pairs as u64);
                for (margin, expected) in margins.iter().zip(expected) {
                    let found = counts.p_value(*margin);
                    // Shares that nobody can believe in any more are only left out of one of them.
                    let bound = 1.0 - LEFT_OUT / 2.0;
                    let all = lower_bound(b, pairs as u64, bound) <= f64::max(0.0, -margin)
                        && upper_bound(b, pairs as u64, bound) >= (1.0 - margin) / 2.0;
                    let least = if all { 0.97 * expected } else { 0.0 };
                    let most = 1.03 * expected + 2.0 * LEFT_OUT;
                    assert!(
                        (least..=most).contains(&found),
                        "{b}/{c} of {pairs} at {margin}: {found} {expected}"
                    );
                }
            }
        }
    }

    /// P-values of single margins do not rise with the margin, since the order of outcomes changes with it. The search for the largest
    /// relies on how little they fall behind those of smaller margins: for every outcome of up to 40 pairs, by less than half of that.
    #[test]
    fn the_search_for_the_largest_reaches_it() {
        let margins: Vec<f64> = (-49..50).map(|step| f64::from(step) / 50.0).collect();
        let falls = |pairs: usize| {
            let falls = |(_, p_values): &(_, Vec<f64>)| {
                let mut largest: f64 = 1e-7;
                p_values.iter().fold(1.0_f64, |falls, p| {
                    largest = largest.max(*p);
                    falls.max(largest / p.max(1e-7))
                })
            };
            enumerated(pairs, &margins, 40).iter().map(falls).fold(1.0, f64::max)
        };
        let worst = (1..=40).into_par_iter().map(falls).reduce(|| 1.0, f64::max);
        assert!(worst < BEYOND_REACH / 2.0, "{worst}");
    }

    #[test]
    fn p_values_rise_with_the_margin() {
        for (pairs, every) in [(6_u64, 1), (17, 4), (40, 13)] {
            for b in (0..=pairs).step_by(every) {
                for c in (0..=pairs - b).step_by(every) {
                    let p_values = [-0.9, -0.5, -0.21, -0.1, -0.013, 0.0, 0.004, 0.06, 0.125, 0.13, 0.4, 0.8]
                        .map(|margin| rate_rise(b, c, pairs, margin));
                    assert!(p_values.is_sorted(), "{b}/{c} of {pairs}: {p_values:?}");
                }
            }
        }
    }

    #[test]
    fn reference_values() {
        // By another program: all 20,301 outcomes of 200 pairs, the likelihood maximised numerically.
        let raw = |b, c, margin| Counts::new(b, c, 200).p_value(margin);
        for (b, c, margin, expected) in [
            (0, 64, 0.2, 4.251_343e-5),
            (0, 62, 0.2, 1.519_008e-4),
            (0, 3, -0.01, 1.194_810e-2),
            (0, 3, 0.0, 4.878_625e-2),
            (2, 9, -0.01, 5.071_673e-3),
            (2, 9, 0.0, 1.998_497e-2),
            (62, 64, -0.01, 3.716_768e-1),
            (62, 64, 0.0, 4.431_573e-1),
        ] {
            let found = raw(b, c, margin);
            assert!((found / expected - 1.0).abs() < 3e-3, "{b}/{c} at {margin}: {found} {expected}");
        }
        assert!(raw(0, 64, -0.01) < 1.1e-7 && raw(0, 64, 0.0) < 1.1e-7 && raw(0, 64, 0.05) < 1.1e-7);
        let interval = |b, c| rate_change(b, c, 200, 0.95);
        assert_eq!(interval(0, 64), Interval { low: 0.255, high: 0.390 });
        // 31 points more, and 31 points less.
        assert_eq!(interval(0, 62), Interval { low: 0.246, high: 0.380 });
        assert_eq!(interval(62, 0), Interval { low: -0.380, high: -0.246 });
        assert_eq!(interval(0, 3), Interval { low: -0.005, high: 0.044 });
        // McNemar's test does not show a rise yet.
        assert_eq!(interval(2, 9), Interval { low: -0.001, high: 0.075 });
    }

    #[test]
    fn the_interval_and_the_test_agree() {
        for (base, candidate) in [(0, 0), (0, 12), (3, 9), (12, 0), (40, 40)] {
            let interval = rate_change(base, candidate, 80, 0.95);
            let seen = (candidate as f64 - base as f64) / 80.0;
            assert!(interval.contains(seen), "{interval:?}");
            assert!(rate_rise(base, candidate, 80, interval.low) <= 0.025);
            assert!(rate_rise(base, candidate, 80, interval.low + 1e-3) > 0.025);
            let mirrored = rate_change(candidate, base, 80, 0.95);
            assert_eq!((mirrored.low, mirrored.high), (-interval.high, -interval.low));
        }
        let none = rate_change(0, 0, 100, 0.95);
        assert!(none.low < 0.0 && none.high > 0.0 && none.high < 0.05, "{none:?}");
        // One pair says next to nothing: were the rate to fall by 95.1 points, none would rise but in 2.45 %.
        assert_eq!(rate_change(0, 1, 1, 0.95), Interval { low: -0.951, high: 1.0 });
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
                sum += at_least(&least, base, base + margin);
            }
        }
        sum
    }

    #[test]
    fn the_test_keeps_its_level_whatever_the_share_of_disagreeing_pairs() {
        for (margin, shares) in [(0.0, [0.01, 0.2, 0.45]), (0.1, [0.0, 0.02, 0.4])] {
            for base in shares {
                let rejected = rejected(14, margin, base, 0.05);
                assert!(rejected <= 0.05, "{rejected} at {margin} and {base}");
            }
        }
        assert!(rejected(20, 0.0, 0.2, 0.05) > 0.02);
    }
}
