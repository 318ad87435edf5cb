//! The last check of an answer, which trusts no surrogate: candidates that were evaluated again on the same runs, compared in pairs.

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
    /// By how much `one` is worse than `other`, known to `error`.
    pub fn of(one: Reevaluated, other: Reevaluated, error: f64) -> Self {
        let size = one.seen.abs().max(other.seen.abs()).max(1.0);
        WorseBy {
            seen: one.seen - other.seen,
            fresh: one.fresh - other.fresh,
            error: error.max(ROUNDING * size),
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
        let worse_by = |one, other| Ok::<_, Infallible>(WorseBy::of(of(one), of(other), error));
        choose(predicted, best, declared, worse_by).unwrap()
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
        // Luck on the runs that it was chosen on is no improvement.
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
