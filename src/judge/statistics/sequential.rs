//! Deciding while runs come in, without the errors of peeking.
//!
//! Both tests rest on likelihood ratios that are nonnegative martingales under the hypothesis they reject. By Ville's
//! inequality such a ratio ever reaches 1/α with probability at most α, however often one looks (J. Ville 1939).
//! Outcomes are taken in seed order, so the decision does not depend on which thread finished first.

use serde::{Deserialize, Serialize};

use super::Interval;
use super::distributions::ln_beta;

/// What is known of a claim that at least some share of runs holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Decision {
    Holds,
    Fails,
    /// More runs are needed.
    Open,
}

/// A decision and what it took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sequential {
    pub decision: Decision,
    /// Runs looked at; later ones are overshoot and do not count.
    pub runs: usize,
    /// Of those, the ones that held.
    pub holding: usize,
}

/// Looks at outcomes in order from the `least`-th on until `decide(holding, runs)` decides or there are no more.
fn in_order(
    outcomes: impl IntoIterator<Item = bool>,
    least: usize,
    decide: impl Fn(u64, u64) -> Decision,
) -> Sequential {
    let (mut runs, mut holding) = (0, 0);
    for held in outcomes {
        runs += 1;
        holding += usize::from(held);
        let decision = if runs < least { Decision::Open } else { decide(holding as u64, runs as u64) };
        if decision != Decision::Open {
            return Sequential { decision, runs, holding };
        }
    }
    Sequential { decision: Decision::Open, runs, holding }
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
    pub fn decide(&self, holding: u64, runs: u64) -> Decision {
        let gain = libm::log(self.good / self.bad);
        let loss = libm::log1p(-self.good) - libm::log1p(-self.bad);
        let failing = (runs - holding) as f64;
        // A good share of 1 is refuted by one failing run; without one, infinity times zero is nothing.
        let ratio = holding as f64 * gain + if failing == 0.0 { 0.0 } else { failing * loss };
        if ratio >= -libm::log(self.alpha) {
            Decision::Holds
        } else if ratio <= libm::log(self.beta) {
            Decision::Fails
        } else {
            Decision::Open
        }
    }

    /// Takes outcomes in seed order until it decides, at the earliest after `least` of them.
    pub fn run(&self, outcomes: impl IntoIterator<Item = bool>, least: usize) -> Sequential {
        in_order(outcomes, least, |holding, runs| self.decide(holding, runs))
    }
}

/// Intervals for a share that all cover at once with the stated confidence, however many runs: a mixture of likelihood
/// ratios over a uniform prior.
///
/// Source: H. Robbins, Ann. Math. Stat. 41, 1970; beta-binomial mixture as in S. R. Howard, A. Ramdas, J. McAuliffe &
/// J. Sekhon, Ann. Stat. 49, 2021.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ConfidenceSequence {
    /// 0..1
    pub confidence: f64,
}

impl ConfidenceSequence {
    /// The logarithm of the mixture's likelihood over that of `share`, less what it takes to exclude it.
    fn excess(&self, holding: u64, runs: u64, share: f64) -> f64 {
        let (held, failed) = (holding as f64, (runs - holding) as f64);
        let term = |count: f64, logarithm: f64| if count == 0.0 { 0.0 } else { count * logarithm };
        ln_beta(1.0 + held, 1.0 + failed) - term(held, libm::log(share)) - term(failed, libm::log1p(-share))
            + libm::log1p(-self.confidence)
    }

    /// The shares not excluded by `holding` of `runs`.
    pub fn interval(&self, holding: u64, runs: u64) -> Interval {
        if runs == 0 {
            return Interval { low: 0.0, high: 1.0 };
        }
        let observed = holding as f64 / runs as f64;
        // The excess rises away from the observed share, where it is below 0.
        let border = |mut outside: f64| {
            let mut inside = observed;
            while (outside - inside).abs() > 1e-15 {
                let middle = 0.5 * (outside + inside);
                if middle == inside || middle == outside {
                    break;
                }
                if self.excess(holding, runs, middle) >= 0.0 { outside = middle } else { inside = middle }
            }
            outside
        };
        Interval {
            low: if holding == 0 { 0.0 } else { border(0.0) },
            high: if holding == runs { 1.0 } else { border(1.0) },
        }
    }

    /// On the claim that at least `share` of all runs hold.
    pub fn decide(&self, holding: u64, runs: u64, share: f64) -> Decision {
        if runs == 0 || self.excess(holding, runs, share) < 0.0 {
            Decision::Open
        } else if holding as f64 >= share * runs as f64 {
            Decision::Holds
        } else {
            Decision::Fails
        }
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
        let mut enough = 1;
        while self.decide(enough, enough, share) != Decision::Holds {
            enough *= 2;
        }
        let mut too_few = enough / 2;
        while enough - too_few > 1 {
            let middle = too_few + (enough - too_few) / 2;
            if self.decide(middle, middle, share) == Decision::Holds {
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
    fn operate(share: f64, most: u64, decide: impl Fn(u64, u64) -> Decision) -> (f64, f64, f64) {
        let mut open = vec![1.0];
        let (mut holds, mut fails, mut expected) = (0.0, 0.0, 0.0);
        for runs in 1..=most {
            expected += open.iter().sum::<f64>();
            let mut next = vec![0.0; runs as usize + 1];
            for (holding, probability) in open.iter().enumerate() {
                next[holding] += probability * (1.0 - share);
                next[holding + 1] += probability * share;
            }
            for (holding, probability) in next.iter_mut().enumerate() {
                match decide(holding as u64, runs) {
                    Decision::Holds => holds += std::mem::take(probability),
                    Decision::Fails => fails += std::mem::take(probability),
                    Decision::Open => {}
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
            Sequential { decision: Decision::Holds, runs: 297, holding: 297 }
        );
    }

    #[test]
    fn the_confidence_sequence_keeps_its_error_while_looking_at_every_run() {
        let sequence = ConfidenceSequence { confidence: 0.95 };
        for share in [0.5, 0.95, 0.99] {
            let (holds, fails, _) =
                operate(share, 1000, |holding, runs| sequence.decide(holding, runs, share));
            assert!(holds + fails <= 0.05, "{holds} {fails} at {share}");
        }
        // The same looks with an ordinary 95 % bound, which this is there to prevent.
        let peeking = |holding, runs| match super::super::lower_bound(holding, runs, 0.95) >= 0.95 {
            true => Decision::Holds,
            false => Decision::Open,
        };
        let (holds, _, _) = operate(0.95, 200, peeking);
        assert!(holds > 0.07, "{holds}");
    }

    #[test]
    fn intervals_of_the_sequence_hold_the_observed_share_and_agree_with_its_decisions() {
        let sequence = ConfidenceSequence { confidence: 0.95 };
        assert_eq!(sequence.interval(0, 0), Interval { low: 0.0, high: 1.0 });
        for (holding, runs) in [(0, 1), (5, 10), (10, 10), (99, 100), (700, 1000)] {
            let interval = sequence.interval(holding, runs);
            assert!(interval.contains(holding as f64 / runs as f64));
            if interval.low > 0.0 {
                assert_eq!(sequence.decide(holding, runs, interval.low * (1.0 - 1e-9)), Decision::Holds);
                assert_eq!(sequence.decide(holding, runs, interval.low * (1.0 + 1e-9)), Decision::Open);
            }
            if interval.high < 1.0 {
                assert_eq!(sequence.decide(holding, runs, interval.high * (1.0 + 1e-9)), Decision::Fails);
            }
        }
    }

    #[test]
    fn runs_needed_are_enough() {
        let sequence = ConfidenceSequence { confidence: 0.95 };
        for share in [0.5, 0.95, 0.99] {
            let runs = sequence.runs_needed(share).unwrap();
            assert_eq!(sequence.decide(runs, runs, share), Decision::Holds);
            assert_eq!(sequence.decide(runs - 1, runs - 1, share), Decision::Open);
            let run = sequence.run(std::iter::repeat(true), 1, share);
            assert_eq!(run.runs as u64, runs);
        }
        assert_eq!(sequence.runs_needed(1.0), None);
    }

    #[test]
    fn outcomes_after_the_decision_do_not_count() {
        let outcomes = (0..10_000).map(|k| k < 400);
        let run = SPRT.run(outcomes, 50);
        assert_eq!((run.decision, run.runs), (Decision::Holds, 297));
        let few = SPRT.run(std::iter::repeat_n(true, 20), 1);
        assert_eq!(few, Sequential { decision: Decision::Open, runs: 20, holding: 20 });
        assert_eq!(SPRT.run(std::iter::repeat(true), 500).runs, 500);
    }
}
