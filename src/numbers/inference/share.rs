//! What a number of runs says about a share: intervals, bounds, and how many runs a claim needs.

use super::Interval;
use crate::distributions::{beta_quantile, binomial_at_least, normal};

/// The score interval for `successes` of `runs` (> 0): narrow and centred well, for showing; it may cover a little less
/// than stated.
///
/// Source: E. B. Wilson, J. Am. Stat. Assoc. 22, 1927.
pub fn wilson(successes: u64, runs: u64, confidence: f64) -> Interval {
    let (n, share) = (runs as f64, successes as f64 / runs as f64);
    let z = normal::quantile(0.5 + confidence / 2.0);
    let spread = z * z / n;
    let centre = (share + spread / 2.0) / (1.0 + spread);
    let half = z * (share * (1.0 - share) / n + spread / (4.0 * n)).sqrt() / (1.0 + spread);
    // At the ends the exact values are 0 and 1, which rounding misses.
    Interval {
        low: if successes == 0 { 0.0 } else { (centre - half).max(0.0) },
        high: if successes == runs { 1.0 } else { (centre + half).min(1.0) },
    }
}

/// The exact interval for `successes` of `runs`: it covers at least as often as stated, for any share.
///
/// Source: C. J. Clopper & E. S. Pearson, Biometrika 26, 1934.
pub fn clopper_pearson(successes: u64, runs: u64, confidence: f64) -> Interval {
    let each = 0.5 + confidence / 2.0;
    Interval { low: lower_bound(successes, runs, each), high: upper_bound(successes, runs, each) }
}

/// The share is at least this, at one-sided `confidence` (0..1): the verdict on claims of "at least".
pub fn lower_bound(successes: u64, runs: u64, confidence: f64) -> f64 {
    if successes == 0 {
        return 0.0;
    }
    beta_quantile(1.0 - confidence, successes as f64, (runs - successes) as f64 + 1.0)
}

/// The share is at most this, at one-sided `confidence` (0..1).
pub fn upper_bound(successes: u64, runs: u64, confidence: f64) -> f64 {
    // Counting failures instead keeps the precision near 1.
    1.0 - lower_bound(runs - successes, runs, confidence)
}

/// The fewest runs that can show a share of at least `share` at one-sided `confidence`: all of them must hold. `None`
/// if no number of runs can, as for a share of 1.
pub fn runs_needed(share: f64, confidence: f64) -> Option<u64> {
    if !(0.0..1.0).contains(&share) || !(0.0..1.0).contains(&confidence) {
        return None;
    }
    if share == 0.0 {
        return Some(1);
    }
    let runs = libm::log1p(-confidence) / libm::log(share);
    // Rounding of the logarithms must not ask for one run more.
    let whole = runs.round();
    let runs = if (runs - whole).abs() <= 1e-9 * whole { whole } else { runs.ceil() };
    Some(runs.max(1.0) as u64)
}

/// The most failing runs among `runs` with which a share of at least `share` is still shown at one-sided
/// `confidence`; `None` if even none would be too many.
pub fn failures_allowed(runs: u64, share: f64, confidence: f64) -> Option<u64> {
    // A share is shown if so many successes would be rare at exactly that share.
    let shown =
        |failures: u64| binomial_at_least(runs - failures, runs, share) <= (1.0 - confidence) * (1.0 + 1e-12);
    if !shown(0) {
        return None;
    }
    let (mut shown_with, mut too_many) = (0, runs + 1);
    while too_many - shown_with > 1 {
        let middle = shown_with + (too_many - shown_with) / 2;
        if shown(middle) { shown_with = middle } else { too_many = middle }
    }
    Some(shown_with)
}

/// How sure one may be that a share of at least `share` of all runs is no worse than the worst of `runs` seen.
///
/// Source: S. S. Wilks, Ann. Math. Stat. 12, 1941 (one-sided tolerance limit without assumptions).
pub fn confidence_of_worst(runs: u64, share: f64) -> f64 {
    1.0 - libm::pow(share, runs as f64)
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{Binomial, Discrete};

    use super::*;

    #[test]
    fn known_intervals() {
        let near = |found: Interval, low: f64, high: f64| {
            assert!((found.low - low).abs() < 5e-5 && (found.high - high).abs() < 5e-5, "{found:?}");
        };
        // Textbook values (Brown, Cai & DasGupta 2001 give formulas; 10 of 20 and 1 of 10 worked out by hand).
        near(wilson(10, 20, 0.95), 0.2993, 0.7007);
        near(clopper_pearson(10, 20, 0.95), 0.2720, 0.7280);
        near(wilson(1, 10, 0.95), 0.0179, 0.4042);
        near(clopper_pearson(1, 10, 0.95), 0.0025, 0.4450);
        near(clopper_pearson(0, 10, 0.95), 0.0, 0.3085);
        near(clopper_pearson(10, 10, 0.95), 0.6915, 1.0);
        assert_eq!(wilson(0, 10, 0.95).low, 0.0);
    }

    #[test]
    fn runs_that_a_claim_needs() {
        assert_eq!(runs_needed(0.95, 0.95), Some(59));
        assert_eq!(runs_needed(0.99, 0.95), Some(299));
        assert_eq!(runs_needed(0.999, 0.95), Some(2995));
        assert_eq!(runs_needed(0.5, 0.75), Some(2));
        assert_eq!(runs_needed(1.0, 0.95), None);
        for (share, confidence) in [(0.8, 0.9), (0.95, 0.95), (0.99, 0.99), (0.1, 0.5)] {
            let runs = runs_needed(share, confidence).unwrap();
            assert_eq!(failures_allowed(runs, share, confidence), Some(0));
            assert_eq!(failures_allowed(runs - 1, share, confidence).filter(|_| runs > 1), None);
            assert!(lower_bound(runs, runs, confidence) >= share - 1e-12);
        }
        assert!((confidence_of_worst(59, 0.95) - 0.9515).abs() < 1e-4);
    }

    #[test]
    fn failures_allowed_agree_with_the_bound() {
        for runs in [59_u64, 100, 500, 2000] {
            let failures = failures_allowed(runs, 0.95, 0.95).unwrap();
            assert!(lower_bound(runs - failures, runs, 0.95) >= 0.95);
            assert!(lower_bound(runs - failures - 1, runs, 0.95) < 0.95);
        }
    }

    /// Coverage by summing over every number of successes: no chance in it.
    fn coverage(interval: impl Fn(u64) -> Interval, runs: u64, share: f64) -> f64 {
        let distribution = Binomial::new(share, runs).unwrap();
        (0..=runs).filter(|k| interval(*k).contains(share)).map(|k| distribution.pmf(k)).sum()
    }

    #[test]
    fn clopper_pearson_covers_always_and_wilson_on_average() {
        for runs in [5, 20, 100] {
            let exact: Vec<_> = (0..=runs).map(|k| clopper_pearson(k, runs, 0.95)).collect();
            let score: Vec<_> = (0..=runs).map(|k| wilson(k, runs, 0.95)).collect();
            let shares: Vec<_> = (1..100).map(|k| f64::from(k) / 100.0).collect();
            let mut total = 0.0;
            for share in &shares {
                let covered = coverage(|k| exact[k as usize], runs, *share);
                assert!(covered >= 0.95 - 1e-9, "{covered} at {share} of {runs}");
                total += coverage(|k| score[k as usize], runs, *share);
            }
            assert!(total / shares.len() as f64 > 0.945, "{}", total / shares.len() as f64);
        }
    }
}
