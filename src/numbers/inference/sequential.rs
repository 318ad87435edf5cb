//! Deciding while runs come in, without the errors of peeking.
//!
//! Both tests rest on likelihood ratios that are nonnegative martingales under the hypothesis they reject. By Ville's
//! inequality such a ratio ever reaches 1/α with probability at most α, however often one looks (J. Ville 1939).
//! Outcomes are taken in seed order, so the decision does not depend on which thread finished first.

use serde::{Deserialize, Serialize};

use super::{Interval, largest_true};
use crate::distributions::{ln_beta, regularised_beta};

/// What is known of a claim that at least some share of runs holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShareDecision {
    /// The share is at least as large as claimed, at the stated confidence.
    Holds,
    /// The share is smaller than claimed, at the stated confidence.
    Fails,
    /// More runs are needed.
    Open,
}

/// A decision and what it took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sequential {
    /// What is known after these runs.
    pub decision: ShareDecision,
    /// Runs looked at; later ones are overshoot and do not count.
    pub runs: usize,
    /// Of those, the ones that held.
    pub holding: usize,
}

/// Looks at outcomes in order from the `least`-th on until `decide(holding, runs)` decides or there are no more.
fn in_order(
    outcomes: impl IntoIterator<Item = bool>,
    least: usize,
    decide: impl Fn(u64, u64) -> ShareDecision,
) -> Sequential {
    let (mut runs, mut holding) = (0, 0);
    for held in outcomes {
        runs += 1;
        holding += usize::from(held);
        let decision = if runs < least { ShareDecision::Open } else { decide(holding as u64, runs as u64) };
        if decision != ShareDecision::Open {
            return Sequential { decision, runs, holding };
        }
    }
    Sequential { decision: ShareDecision::Open, runs, holding }
}

/// The sequential probability ratio test between two shares of holding runs, with indifference between them.
///
/// Source: A. Wald, Sequential Analysis, 1947, with bounds ln(1/α) and ln β in place of his ln((1-β)/α) and
/// ln(β/(1-α)): those keep α + β together, these keep each.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sprt {
    /// A share of holding runs at which the claim should fail.
    pub bad: f64,
    /// A larger share at which it should hold.
    pub good: f64,
    /// Probability of `Holds` at the bad share, at most.
    pub alpha: f64,
    /// Probability of `Fails` at the good share, at most.
    pub beta: f64,
}

impl Sprt {
    /// `holding` of `runs` so far.
    pub fn decide(&self, holding: u64, runs: u64) -> ShareDecision {
        let gain = libm::log(self.good / self.bad);
        let loss = libm::log1p(-self.good) - libm::log1p(-self.bad);
        let failing = (runs - holding) as f64;
        // A good share of 1 is refuted by one failing run; without one, infinity times zero is nothing.
        let ratio = holding as f64 * gain + if failing == 0.0 { 0.0 } else { failing * loss };
        if ratio >= -libm::log(self.alpha) {
            ShareDecision::Holds
        } else if ratio <= libm::log(self.beta) {
            ShareDecision::Fails
        } else {
            ShareDecision::Open
        }
    }

    /// Takes outcomes in seed order until it decides, at the earliest after `least` of them.
    pub fn run(&self, outcomes: impl IntoIterator<Item = bool>, least: usize) -> Sequential {
        in_order(outcomes, least, |holding, runs| self.decide(holding, runs))
    }
}

/// Bounds on a share that hold all at once, each side with the stated confidence, however many runs and however often one
/// looks: for every share, the mean likelihood of all larger (or all smaller) shares over its own.
///
/// Runs need not be alike: where a fixed group takes turns, each with a share of its own, the bounds are on the mean of
/// those shares as long as one looks only after whole turns. (The factor that a turn adds to the ratio has a mean of at
/// most 1, since a product of numbers is at most the power of their mean.)
///
/// Source: H. Robbins, Ann. Math. Stat. 41, 1970; beta-binomial mixture as in S. R. Howard, A. Ramdas, J. McAuliffe &
/// J. Sekhon, Ann. Stat. 49, 2021, with the prior on one side of the share that is tested.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ConfidenceSequence {
    /// 0..1
    pub confidence: f64,
}

impl ConfidenceSequence {
    /// The logarithm of the mean likelihood of larger shares over that of `share`, less what it takes to exclude `share`
    /// and all below it.
    fn excess(&self, holding: u64, runs: u64, share: f64) -> f64 {
        let (held, failed) = (holding as f64, (runs - holding) as f64);
        if held <= share * runs as f64 {
            // No larger share is likelier.
            return f64::NEG_INFINITY;
        }
        let term = |count: f64, logarithm: f64| if count == 0.0 { 0.0 } else { count * logarithm };
        let mean = ln_beta(1.0 + held, 1.0 + failed)
            + libm::log(regularised_beta(1.0 - share, 1.0 + failed, 1.0 + held))
            - libm::log1p(-share);
        mean - term(held, libm::log(share)) - term(failed, libm::log1p(-share))
            + libm::log1p(-self.confidence)
    }

    /// The share is at least this, whenever one looks.
    pub fn lower_bound(&self, holding: u64, runs: u64) -> f64 {
        if holding == 0 {
            return 0.0;
        }
        // The excess falls up to the observed share, where nothing is excluded any more.
        let (mut excluded, mut possible) = (0.0, holding as f64 / runs as f64);
        while possible - excluded > 1e-15 {
            let middle = 0.5 * (excluded + possible);
            if middle <= excluded || middle >= possible {
                break;
            }
            if self.excess(holding, runs, middle) >= 0.0 { excluded = middle } else { possible = middle }
        }
        excluded
    }

    /// The share is at most this, whenever one looks.
    pub fn upper_bound(&self, holding: u64, runs: u64) -> f64 {
        1.0 - self.lower_bound(runs - holding, runs)
    }

    /// Both bounds, each with the stated confidence.
    pub fn interval(&self, holding: u64, runs: u64) -> Interval {
        Interval { low: self.lower_bound(holding, runs), high: self.upper_bound(holding, runs) }
    }

    /// On the claim that at least `share` of all runs hold.
    pub fn decide(&self, holding: u64, runs: u64, share: f64) -> ShareDecision {
        if self.excess(holding, runs, share) >= 0.0 {
            ShareDecision::Holds
        } else if self.excess(runs - holding, runs, 1.0 - share) >= 0.0 {
            ShareDecision::Fails
        } else {
            ShareDecision::Open
        }
    }

    /// Bounds on the quantile at `level` of the distribution behind sorted values, as
    /// [`quantile_interval`](super::quantile_interval) gives them for a fixed number of runs: two of the values, or `None`
    /// where there are too few for a bound.
    pub fn quantile_interval(&self, sorted: &[f64], level: f64) -> (Option<f64>, Option<f64>) {
        let n = sorted.len() as u64;
        let shown = |below: u64, decision| self.decide(below, n, level) == decision;
        // As there: too few values below for it to be the quantile, and too few above.
        let low = largest_true(n, |k| shown(k - 1, ShareDecision::Fails));
        let high = largest_true(n, |k| shown(n - k + 1, ShareDecision::Holds));
        (low.map(|k| sorted[k as usize - 1]), high.map(|k| sorted[(n - k) as usize]))
    }

    /// Takes outcomes in seed order until it decides on the claim that at least `share` of all runs hold, at the
    /// earliest after `least` of them.
    pub fn run(&self, outcomes: impl IntoIterator<Item = bool>, least: usize, share: f64) -> Sequential {
        in_order(outcomes, least, |holding, runs| self.decide(holding, runs, share))
    }

    /// The fewest runs after which a share of at least `share` can be shown: all of them must hold. `None` for 1.
    pub fn runs_needed(&self, share: f64) -> Option<u64> {
        if share >= 1.0 {
            return None;
        }
        if share <= 0.0 {
            return Some(1);
        }
        let mut enough = 1;
        while self.decide(enough, enough, share) != ShareDecision::Holds {
            enough *= 2;
        }
        let mut too_few = enough / 2;
        while enough - too_few > 1 {
            let middle = too_few + (enough - too_few) / 2;
            if self.decide(middle, middle, share) == ShareDecision::Holds {
                enough = middle
            } else {
                too_few = middle
            }
        }
        Some(enough)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Probabilities of `Holds` and `Fails` and the expected number of runs, up to `most` of them: exact, by following
    /// the distribution of the number of holding runs among those undecided.
    fn operate(share: f64, most: u64, decide: impl Fn(u64, u64) -> ShareDecision) -> (f64, f64, f64) {
        operate_with(|_| share, most, decide)
    }

    /// As [`operate`], for runs each with a share of its own.
    fn operate_with(
        share: impl Fn(u64) -> f64,
        most: u64,
        decide: impl Fn(u64, u64) -> ShareDecision,
    ) -> (f64, f64, f64) {
        let mut open = vec![1.0];
        let (mut holds, mut fails, mut expected) = (0.0, 0.0, 0.0);
        for runs in 1..=most {
            expected += open.iter().sum::<f64>();
            let mut next = vec![0.0; runs as usize + 1];
            let share = share(runs);
            for (holding, probability) in open.iter().enumerate() {
                next[holding] += probability * (1.0 - share);
                next[holding + 1] += probability * share;
            }
            for (holding, probability) in next.iter_mut().enumerate() {
                match decide(holding as u64, runs) {
                    ShareDecision::Holds => holds += std::mem::take(probability),
                    ShareDecision::Fails => fails += std::mem::take(probability),
                    ShareDecision::Open => {}
                }
            }
            open = next;
        }
        (holds, fails, expected)
    }

    const SPRT: Sprt = Sprt { bad: 0.985, good: 0.995, alpha: 0.05, beta: 0.05 };

    #[test]
    fn the_sprt_keeps_both_errors() {
        let decide = |holding, runs| SPRT.decide(holding, runs);
        let (holds, _, _) = operate(SPRT.bad, 3000, decide);
        let (_, fails, expected) = operate(SPRT.good, 3000, decide);
        assert!(holds <= 0.05 && holds > 0.03, "{holds}");
        assert!(fails <= 0.05 && fails > 0.02, "{fails}");
        // Far fewer than the 1050 that a fixed number of runs takes for the same errors.
        assert!((550.0..700.0).contains(&expected), "{expected}");
        // Without a failing run: ln 20 / ln(0.995/0.985) runs.
        assert_eq!(
            SPRT.run(std::iter::repeat(true), 1),
            Sequential { decision: ShareDecision::Holds, runs: 297, holding: 297 }
        );
    }

    #[test]
    fn the_confidence_sequence_keeps_both_errors_while_looking_at_every_run() {
        let sequence = ConfidenceSequence { confidence: 0.95 };
        for share in [0.2, 0.5, 0.95, 0.99] {
            let (holds, fails, _) =
                operate(share, 1000, |holding, runs| sequence.decide(holding, runs, share));
            assert!(holds <= 0.05 && fails <= 0.05, "{holds} {fails} at {share}");
            // It gives little away.
            assert!(holds > 0.015 && fails > 0.01, "{holds} {fails} at {share}");
        }
        // The same looks with an ordinary 95 % bound, which this is there to prevent.
        let peeking = |holding, runs| match super::super::lower_bound(holding, runs, 0.95) >= 0.95 {
            true => ShareDecision::Holds,
            false => ShareDecision::Open,
        };
        let (holds, _, _) = operate(0.95, 200, peeking);
        assert!(holds > 0.07, "{holds}");
    }

    #[test]
    fn runs_that_take_turns_keep_the_errors_on_their_mean() {
        // Four people with shares of their own, of which the mean is 90 %.
        let shares = [1.0, 0.6, 1.0, 1.0];
        let sequence = ConfidenceSequence { confidence: 0.95 };
        let after_turns = |holding, runs: u64| match runs.is_multiple_of(4) {
            true => sequence.decide(holding, runs, 0.9),
            false => ShareDecision::Open,
        };
        let share = |runs: u64| shares[(runs - 1) as usize % 4];
        let (holds, fails, _) = operate_with(share, 1000, after_turns);
        assert!(holds <= 0.05 && fails <= 0.05, "{holds} {fails}");
    }

    #[test]
    fn it_takes_fewer_runs_the_clearer_the_case() {
        let sequence = ConfidenceSequence { confidence: 0.95 };
        let expected = |share: f64| {
            let (holds, _, expected) =
                operate(share, 1500, |holding, runs| sequence.decide(holding, runs, 0.95));
            (holds, expected)
        };
        let ((sure, few), (likely, more)) = (expected(1.0), expected(0.98));
        assert_eq!((sure, few), (1.0, 88.0));
        assert!(likely > 0.95 && (150.0..400.0).contains(&more), "{likely} {more}");
    }

    #[test]
    fn bounds_agree_with_decisions() {
        let sequence = ConfidenceSequence { confidence: 0.95 };
        for (holding, runs) in [(0, 1), (5, 10), (10, 10), (99, 100), (3, 100), (700, 1000), (9990, 10_000)] {
            let interval = sequence.interval(holding, runs);
            assert!(interval.contains(holding as f64 / runs as f64));
            // Nothing below is left open and nothing between excluded: the bounds are the only borders.
            for part in 1..=40 {
                let decided = |share: f64| sequence.decide(holding, runs, share);
                let part = f64::from(part) / 41.0;
                if interval.low > 0.0 {
                    assert_eq!(decided(interval.low * part), ShareDecision::Holds);
                }
                assert_eq!(
                    decided(interval.low + part * (interval.high - interval.low)),
                    ShareDecision::Open
                );
                if interval.high < 1.0 {
                    assert_eq!(decided(interval.high + part * (1.0 - interval.high)), ShareDecision::Fails);
                }
            }
        }
    }

    #[test]
    fn bounds_of_quantiles_agree_with_decisions_on_their_share() {
        let sequence = ConfidenceSequence { confidence: 0.95 };
        let values: Vec<f64> = (1..=300).map(f64::from).collect();
        for level in [0.1, 0.5, 0.95] {
            let (low, high) = sequence.quantile_interval(&values, level);
            let (low, high) = (low.unwrap() as u64, high.unwrap() as u64);
            let (fixed_low, fixed_high) = super::super::quantile_interval(&values, level, 0.9);
            assert!(low as f64 <= fixed_low.unwrap() && high as f64 >= fixed_high.unwrap());
            // `low - 1` values below are too few, `low` are not; the other way round at the upper end.
            assert_eq!(sequence.decide(low - 1, 300, level), ShareDecision::Fails);
            assert_eq!(sequence.decide(low, 300, level), ShareDecision::Open);
            assert_eq!(sequence.decide(high, 300, level), ShareDecision::Holds);
            assert_eq!(sequence.decide(high - 1, 300, level), ShareDecision::Open);
        }
        assert_eq!(sequence.quantile_interval(&values[..87], 0.95).1, None);
        assert_eq!(sequence.quantile_interval(&values[..88], 0.95).1, Some(88.0));
    }

    #[test]
    fn runs_needed_are_enough() {
        let sequence = ConfidenceSequence { confidence: 0.95 };
        for (share, known) in [(0.5, 7), (0.9, 43), (0.95, 88), (0.99, 449), (0.999, 4512)] {
            let runs = sequence.runs_needed(share).unwrap();
            assert_eq!(runs, known);
            assert_eq!(sequence.decide(runs, runs, share), ShareDecision::Holds);
            assert_eq!(sequence.decide(runs - 1, runs - 1, share), ShareDecision::Open);
            let run = sequence.run(std::iter::repeat(true), 1, share);
            assert_eq!(run.runs as u64, runs);
        }
        assert_eq!(sequence.runs_needed(1.0), None);
        assert_eq!(sequence.runs_needed(0.0), Some(1));
    }

    #[test]
    fn outcomes_after_the_decision_do_not_count() {
        let outcomes = (0..10_000).map(|k| k < 400);
        let run = SPRT.run(outcomes, 50);
        assert_eq!((run.decision, run.runs), (ShareDecision::Holds, 297));
        let few = SPRT.run(std::iter::repeat_n(true, 20), 1);
        assert_eq!(few, Sequential { decision: ShareDecision::Open, runs: 20, holding: 20 });
        assert_eq!(SPRT.run(std::iter::repeat(true), 500).runs, 500);
    }
}
