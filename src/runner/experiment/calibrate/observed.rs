//! What people did as targets: shares and spreads, with errors by drawing persons anew.

use numbers::distributions::beta_quantile;
use numbers::inference::WeightTarget;
use numbers::random::Stream;
use scenario::{ObservedErrors, ObservedRow};

/// Half of what lies within a standard error of a normal distribution, and a half.
const ONE_ERROR: f64 = 0.841_344_746_068_542_9;

/// What people did in a condition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observed {
    /// The share of trials.
    pub share: WeightTarget,
    /// The share of pairs of a person's trials in which both hold; `None` where that is not known.
    pub spread: Option<WeightTarget>,
}

impl Observed {
    pub fn of(row: &ObservedRow) -> Self {
        if let Some(ObservedErrors { error, pairs }) = row.errors {
            let spread = pairs.map(|(value, error)| WeightTarget { value, error });
            return Self { share: WeightTarget { value: row.share, error }, spread };
        }
        let most = row.by_count.len() - 1;
        let share = |count: usize| count as f64 / most as f64;
        let pairs = |count: usize| (count * count.saturating_sub(1)) as f64 / (most * (most - 1)) as f64;
        let spread = Some(target(&row.by_count, pairs));
        // Of all trials, where some person has one less.
        let WeightTarget { error, .. } = target(&row.by_count, share);
        Self { share: WeightTarget { value: row.share, error }, spread }
    }

    /// Of as many persons, drawn from these with replacement. The error stays that of what was observed. Where counts of persons are not
    /// known, share and pairs are drawn from normal distributions with their errors, by the same draw: who does it more often does it
    /// more often twice.
    pub fn resampled(row: &ObservedRow, stream: &mut Stream) -> Self {
        if row.errors.is_some() {
            let own = Self::of(row);
            let apart = stream.normal();
            let drawn = |WeightTarget { value, error }: WeightTarget| WeightTarget {
                value: (value + apart * error).clamp(0.0, 1.0),
                error,
            };
            return Self { share: drawn(own.share), spread: own.spread.map(drawn) };
        }
        let mut persons = Vec::new();
        for (count, number) in row.by_count.iter().enumerate() {
            persons.extend(std::iter::repeat_n(count, *number as usize));
        }
        let mut by_count = vec![0; row.by_count.len()];
        for _ in 0..persons.len() {
            by_count[persons[stream.index(persons.len())]] += 1;
        }
        let most = by_count.len() - 1;
        let held: u32 = by_count.iter().zip(0..).map(|(persons, count)| persons * count).sum();
        let share = f64::from(held) / (row.persons as usize * most) as f64;
        let own = Self::of(row);
        let drawn = Self::of(&ObservedRow { by_count, share, ..row.clone() });
        Self {
            share: WeightTarget { value: share, ..own.share },
            spread: drawn
                .spread
                .zip(own.spread)
                .map(|(drawn, own)| WeightTarget { value: drawn.value, ..own }),
        }
    }
}

/// The mean over persons, with the error that drawing as many persons anew has. Where all are alike at 0 or 1, which says nothing of how
/// much people differ, the error is how far Jeffreys' bound of one standard error is.
fn target(by_count: &[u32], of: impl Fn(usize) -> f64) -> WeightTarget {
    let persons: u32 = by_count.iter().sum();
    let number = f64::from(persons);
    let mean = |of: &dyn Fn(usize) -> f64| {
        by_count.iter().enumerate().map(|(count, persons)| f64::from(*persons) * of(count)).sum::<f64>()
            / number
    };
    let value = mean(&of);
    let squares = mean(&|count| (of(count) - value) * (of(count) - value));
    if squares > 1e-12 {
        let error = libm::sqrt(squares / (number - 1.0).max(1.0));
        return WeightTarget { value, error };
    }
    let (held, not) = (value * number, (1.0 - value) * number);
    let high = beta_quantile(ONE_ERROR, held + 0.5, not + 0.5);
    let low = beta_quantile(1.0 - ONE_ERROR, held + 0.5, not + 0.5);
    let error = if value > 0.5 { value - low } else { high - value };
    WeightTarget { value, error: error.max((high - low) / 2.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(share: f64, by_count: [u32; 5]) -> ObservedRow {
        ObservedRow {
            row: 1,
            scenario: String::new(),
            values: Vec::new(),
            share,
            trials: 128,
            persons: 32,
            by_count: by_count.to_vec(),
            errors: None,
        }
    }

    #[test]
    fn errors_are_those_of_persons_drawn_anew() {
        let row = row(0.4297, [13, 4, 2, 5, 8]);
        let observed = Observed::of(&row);
        let mut stream = Stream::seeded(1);
        let many: Vec<Observed> = (0..20_000).map(|_| Observed::resampled(&row, &mut stream)).collect();
        for (error, values) in [
            (observed.share.error, many.iter().map(|one| one.share.value).collect::<Vec<_>>()),
            (observed.spread.unwrap().error, many.iter().map(|one| one.spread.unwrap().value).collect()),
        ] {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let variance =
                values.iter().map(|one| (one - mean) * (one - mean)).sum::<f64>() / values.len() as f64;
            assert!((variance.sqrt() / error - 1.0).abs() < 0.03, "{} and {error}", variance.sqrt());
        }
        // By hand: (4·0 + 2·2 + 5·6 + 8·12) / 12 / 32.
        assert!((observed.spread.unwrap().value - 130.0 / 12.0 / 32.0).abs() < 1e-12);
    }

    #[test]
    fn at_nobody_and_everybody_the_error_is_jeffreys() {
        for (share, counts) in [(1.0, [0, 0, 0, 0, 32]), (0.0, [32, 0, 0, 0, 0])] {
            let observed = Observed::of(&row(share, counts));
            for target in [observed.share, observed.spread.unwrap()] {
                assert_eq!(target.value, share);
                // Beta(32.5, 0.5): 0.15866 of it is below 0.9692.
                assert!((target.error - 0.031).abs() < 0.002, "{}", target.error);
            }
        }
    }
    #[test]
    fn what_was_worked_out_of_persons_is_taken_as_it_is_and_drawn_with_its_errors() {
        let errors = ObservedErrors { error: 0.05, pairs: Some((0.3, 0.04)) };
        let row = ObservedRow { errors: Some(errors), ..row(0.45, [0; 5]) };
        let row = ObservedRow { by_count: Vec::new(), ..row };
        let observed = Observed::of(&row);
        assert_eq!(observed.share, WeightTarget { value: 0.45, error: 0.05 });
        assert_eq!(observed.spread, Some(WeightTarget { value: 0.3, error: 0.04 }));
        let mut stream = Stream::seeded(2);
        let many: Vec<Observed> = (0..20_000).map(|_| Observed::resampled(&row, &mut stream)).collect();
        for (wanted, values) in [
            (observed.share, many.iter().map(|one| one.share.value).collect::<Vec<_>>()),
            (observed.spread.unwrap(), many.iter().map(|one| one.spread.unwrap().value).collect()),
        ] {
            let mean = values.iter().sum::<f64>() / 20_000.0;
            let square = values.iter().map(|one| (one - mean) * (one - mean)).sum::<f64>() / 20_000.0;
            assert!((mean - wanted.value).abs() < 0.002, "{mean}");
            assert!((square.sqrt() / wanted.error - 1.0).abs() < 0.03, "{square}");
        }
        let unknown = ObservedErrors { pairs: None, ..errors };
        assert_eq!(Observed::of(&ObservedRow { errors: Some(unknown), ..row }).spread, None);
    }
}
