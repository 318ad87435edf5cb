//! The last check of an answer, which trusts no surrogate: candidates that were evaluated again on the same runs, compared in pairs.

use numbers::distributions::student_quantile;
use numbers::random::Stream;
use numbers::summary::std;

/// Confidence that one candidate is worse than another.
const CONFIDENCE: f64 = 0.95;
/// How often runs are drawn again to find the error of a difference.
const RESAMPLES: usize = 200;
/// Differences up to this, absolute and relative, are rounding: objectives are in SI units.
const ROUNDING: f64 = 1e-9;

/// An objective to minimise, evaluated again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reevaluated {
    /// On the runs on which the candidates were chosen.
    pub seen: f64,
    /// On runs of the same cases that no candidate was chosen on; infinite where it has no value there.
    pub fresh: f64,
}

/// By how much one candidate is worse than another on the same runs; negative where it is better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorseBy {
    /// On the runs on which the candidates were chosen.
    pub seen: f64,
    /// On runs that no candidate was chosen on.
    pub fresh: f64,
    /// By how much chance alone may well make it worse or better on the runs that were seen.
    pub error: f64,
}

impl WorseBy {
    /// By how much `one` is worse than `other`. Where chance leaves either without a value, nothing shows that the one is better.
    pub fn of(one: Reevaluated, other: Reevaluated, chance: SamplingError) -> Self {
        let size = one.seen.abs().max(other.seen.abs()).max(1.0);
        WorseBy {
            seen: one.seen - other.seen,
            fresh: if chance.always_has_value { one.fresh - other.fresh } else { f64::INFINITY },
            error: chance.error.max(ROUNDING * size),
        }
    }

    /// Worse on the runs that were seen, beyond its uncertainty.
    pub fn is_worse(&self) -> bool {
        self.seen > self.error
    }

    /// Better beyond its uncertainty, on the runs that were seen, which favour what was chosen on them, and on as many that nothing was
    /// chosen on.
    pub fn is_better(&self) -> bool {
        self.seen < -self.error && self.fresh < -self.error
    }
}

/// How much of a difference between two candidates chance explains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SamplingError {
    /// By so much chance alone makes the one worse than the other, one-sided at 95 %.
    pub error: f64,
    /// Both have a value however the runs are drawn again.
    pub always_has_value: bool,
}

impl SamplingError {
    /// Draws runs again and looks how far the difference moves (bootstrap within the cases, Student's t).
    ///
    /// `pools` has for each run of the cases those of the same case, by number, at least two. The cases themselves are what they are. `is_same`
    /// is whether two runs are alike for both candidates: a case whose runs are all alike says nothing of how well the deviation is known.
    /// `difference` is that of the candidates over drawn runs, not finite where either has no value.
    pub fn of(
        pools: &[Vec<usize>],
        seed: u64,
        is_same: impl Fn(usize, usize) -> bool,
        difference: impl Fn(&[usize]) -> f64,
    ) -> Self {
        let mut stream = Stream::seeded(seed);
        let mut known = Vec::with_capacity(RESAMPLES);
        for _ in 0..RESAMPLES {
            let drawn: Vec<usize> = pools.iter().map(|pool| pool[stream.index(pool.len())]).collect();
            known.extend(Some(difference(&drawn)).filter(|difference| difference.is_finite()));
        }
        let smallest = pools.iter().map(Vec::len).min().unwrap_or(2).max(2) as f64;
        // A draw from n runs varies by (n − 1)/n of what a new run does.
        let deviation = std(&known).unwrap_or(0.0) * (smallest / (smallest - 1.0)).sqrt();
        let mut cases: Vec<&Vec<usize>> = pools.iter().collect();
        cases.sort_unstable();
        cases.dedup();
        let varies = |case: &&&Vec<usize>| case.iter().any(|run| !is_same(case[0], *run));
        let freedom: usize = cases.iter().filter(varies).map(|case| case.len() - 1).sum();
        Self {
            error: student_quantile(CONFIDENCE, freedom.max(1) as f64) * deviation,
            always_has_value: known.len() == RESAMPLES,
        }
    }
}

/// The candidate to answer with.
///
/// It is the `predicted` one; the best that was observed, where that is worse beyond its uncertainty than one of the `best`; and the
/// `declared` one, unless the other is better beyond its uncertainty. `best` has the best first. `worse_by` compares two candidates,
/// the first with the second.
///
/// # Errors
/// Those of `worse_by`.
pub fn choose<C: Copy + PartialEq, E>(
    predicted: C,
    best: &[C],
    declared: Option<C>,
    mut worse_by: impl FnMut(C, C) -> Result<WorseBy, E>,
) -> Result<C, E> {
    let mut choice = predicted;
    for &observed in best.iter().filter(|&&observed| observed != predicted) {
        if worse_by(predicted, observed)?.is_worse() {
            choice = best[0];
            break;
        }
    }
    match declared {
        Some(declared) if declared != choice && !worse_by(choice, declared)?.is_better() => Ok(declared),
        _ => Ok(choice),
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use numbers::random::derive_seed;

    use super::*;

    /// Chooses among candidates with these values on both kinds of runs.
    fn chosen(
        values: &[(f64, f64)],
        predicted: usize,
        best: &[usize],
        declared: Option<usize>,
        error: f64,
    ) -> usize {
        let of = |index: usize| Reevaluated { seen: values[index].0, fresh: values[index].1 };
        let chance = SamplingError { error, always_has_value: true };
        let worse_by = |one, other| Ok::<_, Infallible>(WorseBy::of(of(one), of(other), chance));
        choose(predicted, best, declared, worse_by).unwrap()
    }

    /// Two candidates that are the same but for chance, each with runs `values` on both kinds of seeds: how often the one is called worse.
    fn called_worse(pools: &[Vec<usize>], runs: usize, trials: u64) -> f64 {
        let called = |trial: &u64| {
            let mut stream = Stream::seeded(derive_seed(*trial, "coverage"));
            let mut candidate = || (0..2 * runs).map(|_| stream.normal()).collect::<Vec<f64>>();
            let (one, other) = (candidate(), candidate());
            let mean = |values: &[f64], runs: &[usize]| {
                runs.iter().map(|run| values[*run]).sum::<f64>() / runs.len() as f64
            };
            let difference = |drawn: &[usize]| mean(&one, drawn) - mean(&other, drawn);
            let chance = SamplingError::of(pools, *trial, |left, right| one[left] == one[right], difference);
            let seen: Vec<usize> = (0..runs).collect();
            difference(&seen) > chance.error
        };
        (0..trials).filter(called).count() as f64 / trials as f64
    }

    /// 5 % are called worse by chance; of 2000 trials 2 % to 8 % are within six standard errors.
    #[test]
    fn chance_alone_makes_one_worse_in_a_twentieth() {
        // Twelve cases with a run on each kind of seeds, and two cases with ten runs each.
        let twins: Vec<Vec<usize>> = (0..12).map(|run| vec![run, 12 + run]).collect();
        let tenfold: Vec<Vec<usize>> =
            (0..20).map(|run| (0..10).map(|one| run / 10 * 10 + one).collect()).collect();
        for (pools, runs) in [(twins, 12), (tenfold, 20)] {
            let share = called_worse(&pools, runs, 2000);
            assert!((0.02..0.08).contains(&share), "{share} of {runs} runs");
        }
    }

    /// Cases in which nothing is drawn say nothing of how well the deviation is known.
    #[test]
    fn what_does_not_vary_makes_nothing_surer() {
        let pools = |certain: usize| -> Vec<Vec<usize>> {
            let all = 2 + certain;
            (0..all).map(|run| vec![run, all + run]).collect()
        };
        let error = |certain: usize| {
            let all = 2 + certain;
            let value = |run: usize| {
                if run % all < 2 { [0.0, 1.0, 2.0, 4.0][run % all + run / all * 2] } else { 0.0 }
            };
            let sum = |drawn: &[usize]| drawn.iter().map(|run| value(*run)).sum::<f64>();
            SamplingError::of(&pools(certain), 3, |left, right| value(left) == value(right), sum).error
        };
        // The draws are others; the quantile of 2 degrees of freedom is 2.9, and of 42 it would be 1.7.
        assert!((0.8..1.25).contains(&(error(40) / error(0))), "{} and {}", error(40), error(0));
    }

    #[test]
    fn without_a_value_nothing_is_better() {
        let pools = [vec![0, 1]];
        let chance =
            SamplingError::of(&pools, 1, |left, right| left == right, |drawn| [1.0, f64::NAN][drawn[0]]);
        assert!(!chance.always_has_value);
        let [one, other] = [-5.0, 0.0].map(|value| Reevaluated { seen: value, fresh: value });
        assert!(!WorseBy::of(one, other, chance).is_better());
    }

    #[test]
    fn a_prediction_that_is_worse_than_what_was_seen_is_dropped() {
        let values = [(2.4, 2.4), (0.01, 0.01), (0.02, 0.02)];
        assert_eq!(chosen(&values, 0, &[1, 2], None, 0.1), 1);
        // Within the noise the model knows better.
        assert_eq!(chosen(&[(0.06, 0.0), (0.01, 0.1)], 0, &[1], None, 0.1), 0);
        // Without noise a billionth is rounding, and a millionth is not.
        assert_eq!(chosen(&[(0.5 + 1e-10, 0.5), (0.5, 0.5)], 0, &[1], None, 0.0), 0);
        assert_eq!(chosen(&[(0.5 + 1e-6, 0.5), (0.5, 0.5)], 0, &[1], None, 0.0), 1);
        // Whichever of the best it is worse than, the answer is the best of them.
        assert_eq!(chosen(&[(1.0, 1.0), (0.0, 0.0), (0.3, 0.3)], 0, &[1, 2], None, 0.2), 1);
    }

    #[test]
    fn what_is_declared_stays_unless_something_is_better() {
        let flat = [(0.5, 0.5), (0.45, 0.45)];
        assert_eq!(chosen(&flat, 1, &[1, 0], Some(0), 0.1), 0);
        // Luck on the runs that it was chosen on does not count as an improvement.
        assert_eq!(chosen(&[(0.5, 0.5), (0.1, 0.5)], 1, &[1, 0], Some(0), 0.1), 0);
        assert_eq!(chosen(&[(0.5, 0.5), (0.1, 0.1)], 1, &[1, 0], Some(0), 0.1), 1);
        // Nor is one within the noise, or that only other runs show.
        assert_eq!(chosen(&[(0.5, 0.5), (0.4, 0.1)], 1, &[1, 0], Some(0), 0.2), 0);
        assert_eq!(chosen(&[(0.5, 0.5), (0.6, 0.1)], 1, &[0, 1], Some(0), 0.2), 0);
        assert_eq!(chosen(&flat, 0, &[1, 0], Some(0), 0.1), 0);
        // Neither has a value with other seeds: nothing speaks for the change.
        let nothing = f64::INFINITY;
        assert_eq!(chosen(&[(0.5, nothing), (0.1, nothing)], 1, &[1], Some(0), 0.1), 0);
        assert_eq!(chosen(&[(0.5, nothing), (0.1, 0.1)], 1, &[1], Some(0), 0.1), 1);
    }
}
