//! How the comparisons of a gate share its error.
//!
//! Where nothing worse is tolerated, base and candidate may be exchanged if nothing changed: such comparisons are adjusted for each
//! other by exchanging the same pairs in all of them. Where something is, differences are not symmetric about it, and Holm's
//! correction holds. Both together: closed testing (R. Marcus, E. Peritz & K. R. Gabriel, Biometrika 63, 1976) with a share of the
//! error for the former as a whole, as large as there are of them, and one for each of the latter; who is rejected leaves its share
//! to the others.

use super::measure::Differences;
use super::questions::Question;
use crate::Check;
use numbers::inference::{PairDifferences, max_t, mcnemar};
use numbers::random::derive_seed;
use scenario::GateRule;
use std::collections::HashMap;

/// What the comparisons are of, one each.
pub struct Comparisons<'a> {
    pub asked: &'a [Question<'a>],
    pub measured: &'a [Differences<'a>],
    /// The p-values of exchanging base and candidate in each alone, where they are known.
    pub exchanged: &'a [Option<f64>],
    pub rules: &'a [GateRule],
}

/// How many comparisons share the error: primary ones have half of it for themselves, the others the other half.
pub struct Families {
    pub primary: usize,
    pub others: usize,
    /// What of the error is left for the end, 0..1.
    pub left: f64,
}

impl Families {
    pub fn of(asked: &[Question], rules: &[GateRule], left: f64) -> Self {
        let count = |primary: bool| {
            let own = asked.iter().filter(|question| rules[question.rule].primary == primary);
            own.filter(|question| question.shares_the_error()).count()
        };
        Self { primary: count(true), others: count(false), left }
    }

    /// Between how many kinds of comparisons the error is divided, as if all of it were left: nobody shares it with a kind of which there
    /// is none.
    fn kinds(&self) -> f64 {
        (f64::from(self.primary > 0) + f64::from(self.others > 0)) / self.left
    }

    /// By how many one comparison of a kind shares the error.
    pub fn shares(&self, primary: bool) -> f64 {
        self.kinds() * if primary { self.primary } else { self.others } as f64
    }

    /// Gives every comparison that shares the error its p-value adjusted for the others.
    pub fn adjust(&self, checks: &mut [Check], comparisons: &Comparisons, seed: u64) {
        let Comparisons { asked, measured, exchanged, rules } = comparisons;
        for primary in [true, false] {
            let own = (0..checks.len()).filter(|index| {
                checks[*index].p_value.is_some() && rules[checks[*index].rule].primary == primary
            });
            let (exchangeable, others): (Vec<usize>, Vec<usize>) =
                own.partition(|index| asked[*index].tolerates_nothing());
            let level = checks.iter().map(Check::level).fold(0.5, f64::min) / self.shares(primary).max(1.0);
            let jointly = joint(&exchangeable, checks, measured, level, seed);
            let p_values: Vec<f64> = others.iter().filter_map(|index| checks[*index].p_value).collect();
            let (of_joint, of_others) = shared(&jointly, &p_values);
            for (index, adjusted) in exchangeable.iter().zip(of_joint) {
                let check = &mut checks[*index];
                let own = check.p_value.unwrap_or(1.0);
                let exchanged = by_itself(&measured[*index], exchanged[*index]).unwrap_or(own);
                // As many comparisons as that adjustment took it for, for a p-value that is more careful than exchanging is: never more than
                // there are. Of what is far smaller than can be told by exchanging, the quotient says nothing.
                let taken_for = (adjusted / exchanged).clamp(1.0, exchangeable.len() as f64);
                let careful = own * taken_for;
                check.adjusted_p_value = Some((adjusted.max(careful) * self.kinds()).min(1.0));
            }
            for (index, adjusted) in others.iter().zip(of_others) {
                checks[*index].adjusted_p_value = Some((adjusted * self.kinds()).min(1.0));
            }
        }
    }
}

/// The p-values of those that nothing worse is tolerated in, adjusted for each other; `level` is the smallest that matters. Where none can
/// be small, since none is by itself, no more than what they are by Bonferroni.
fn joint(own: &[usize], checks: &[Check], measured: &[Differences], level: f64, seed: u64) -> Vec<f64> {
    let p_value = |index: &usize| checks[*index].p_value.unwrap_or(1.0);
    if own.len() < 2 || !own.iter().any(|index| p_value(index) <= checks[*index].level()) {
        return own.iter().map(|index| (p_value(index) * own.len() as f64).min(1.0)).collect();
    }
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    let differences: Vec<PairDifferences> = own
        .iter()
        .map(|index| {
            let Differences { units, worse, .. } = &measured[*index];
            let worse = worse.iter().flatten();
            let numbered = units.iter().zip(worse).map(|(unit, one)| {
                let next = numbers.len();
                (*numbers.entry(unit).or_insert(next), *one)
            });
            numbered.collect()
        })
        .collect();
    max_t(&differences, level, derive_seed(seed, "the same pairs exchanged in all comparisons"))
}

/// Adjusted p-values of a group whose own are adjusted for each other already, and of single ones.
fn shared(group: &[f64], single: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let sorted = |values: &[f64]| {
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|left, right| values[*left].total_cmp(&values[*right]));
        order
    };
    let (group_order, single_order) = (sorted(group), sorted(single));
    let (mut of_group, mut of_single) = (vec![1.0; group.len()], vec![1.0; single.len()]);
    let (mut next_of_group, mut next_single) = (0, 0);
    let mut largest = 0.0_f64;
    while next_of_group < group.len() || next_single < single.len() {
        let whole = if next_of_group < group.len() { group.len() } else { 0 };
        let shares = (whole + single.len() - next_single) as f64;
        let first = group_order.get(next_of_group).map(|index| group[*index] * shares / group.len() as f64);
        let other = single_order.get(next_single).map(|index| single[*index] * shares);
        match (first, other) {
            (Some(first), other) if other.is_none_or(|other| first <= other) => {
                largest = largest.max(first);
                of_group[group_order[next_of_group]] = largest.min(1.0);
                next_of_group += 1;
            }
            (_, other) => {
                largest = largest.max(other.unwrap_or(1.0));
                of_single[single_order[next_single]] = largest.min(1.0);
                next_single += 1;
            }
        }
    }
    (of_group, of_single)
}

/// The p-value of exchanging base and candidate in this comparison alone.
fn by_itself(measured: &Differences, exchanged: Option<f64>) -> Option<f64> {
    let of_flag = |(base, candidate)| mcnemar(base, candidate).more_in_candidate;
    measured.one_sided.map(of_flag).or(exchanged)
}

#[cfg(test)]
mod tests {
    use super::*;
    use numbers::inference::holm;

    #[test]
    fn single_comparisons_are_adjusted_as_holm_does() {
        let p_values = [0.01, 0.3, 0.004, 0.02];
        let (group, single) = shared(&[], &p_values);
        assert!(group.is_empty());
        for (one, other) in single.iter().zip(holm(&p_values)) {
            assert!((one - other).abs() < 1e-12);
        }
        // A group alone has all of the error.
        assert_eq!(shared(&[0.2, 0.01], &[]).0, [0.2, 0.01]);
    }

    /// By hand: two of a group and two single ones, four shares.
    #[test]
    fn who_is_rejected_leaves_the_share() {
        let (group, single) = shared(&[0.005, 0.02], &[0.004, 0.04]);
        // 0.005 * 4/2 comes first, then 0.004 * 4, then 0.02 * 3/2, then 0.04 alone.
        assert_eq!(group, [0.01, 0.03]);
        assert_eq!(single, [0.016, 0.04]);
    }
}
