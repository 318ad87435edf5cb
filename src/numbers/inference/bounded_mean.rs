//! Bounds on means of values with known limits, by betting against every mean that is too low or too high.
//!
//! Somebody who bets that the mean is larger than m stakes the share u of the capital on each unit, which is paid back
//! value/m times. If the mean is at most m, the capital is a nonnegative supermartingale, whoever looks at it and
//! however often: it ever reaches 1/α with probability at most α (Ville 1939), whatever the distribution. The capital is
//! spread over several u beforehand; that keeps it a supermartingale, and independent of the order of the units.
//!
//! Units need not be alike: where a fixed group takes turns, the bounds are on the mean over the group, as long as one
//! looks after whole turns only (a product of numbers is at most the power of their mean).
//!
//! Source: I. Waudby-Smith & A. Ramdas, J. R. Stat. Soc. B 86, 2024, section 5 (diversified betting).

use super::Interval;

/// Shares of the capital that are staked each time; geometric, so that one of them is near the best.
const STAKES: [f64; 20] = [
    1.0, 0.95, 0.85, 0.7, 0.5, 0.36, 0.25, 0.18, 0.125, 0.088, 0.0625, 0.044, 0.031, 0.022, 0.0156, 0.011,
    0.0078, 0.0055, 0.0039, 0.002_76,
];

/// What is independent of the others: a run, or all runs of a person.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IndependentUnit {
    /// The sum of the values that exist.
    pub sum: f64,
    /// How many there are.
    pub values: u32,
    /// Runs, with those without a value.
    pub runs: u32,
}

impl IndependentUnit {
    /// One run.
    pub fn of_run(value: Option<f64>) -> Self {
        Self { sum: value.unwrap_or(0.0), values: u32::from(value.is_some()), runs: 1 }
    }

    /// Several runs together.
    pub fn of_runs(values: impl IntoIterator<Item = Option<f64>>) -> Self {
        let none = Self { sum: 0.0, values: 0, runs: 0 };
        values.into_iter().map(Self::of_run).fold(none, |all, one| Self {
            sum: all.sum + one.sum,
            values: all.values + one.values,
            runs: all.runs + one.runs,
        })
    }

    /// Of the values that exist; `None` of none.
    pub fn mean(&self) -> Option<f64> {
        (self.values > 0).then(|| self.sum / f64::from(self.values))
    }

    /// With values measured down from `high` instead of up from `low`, as shares of what is between them.
    fn down_from_high(self, (low, high): (f64, f64)) -> Self {
        let count = f64::from(self.values);
        Self { sum: count - self.up_from_low((low, high)).sum, ..self }
    }

    fn up_from_low(self, (low, high): (f64, f64)) -> Self {
        let count = f64::from(self.values);
        // Rounding must not leave the limits.
        Self { sum: ((self.sum - count * low) / (high - low)).clamp(0.0, count), ..self }
    }
}

/// The capital of the bet that the mean of values between 0 and 1 is larger than `mean`.
#[derive(Debug, Clone)]
struct Bet {
    mean: f64,
    /// Of each stake: the capital is the product of both, the second one a logarithm.
    capital: [(f64, f64); STAKES.len()],
}

impl Bet {
    fn new(mean: f64) -> Self {
        Self { mean, capital: [(1.0, 0.0); STAKES.len()] }
    }

    fn take(&mut self, unit: IndependentUnit) {
        if unit.values == 0 {
            return;
        }
        let gain = (unit.sum / self.mean - f64::from(unit.values)) / f64::from(unit.runs);
        for ((capital, logarithm), stake) in self.capital.iter_mut().zip(STAKES) {
            *capital *= (1.0 + stake * gain).max(0.0);
            if *capital > 0.0 && !(1e-100..1e100).contains(capital) {
                *logarithm += libm::log(*capital);
                *capital = 1.0;
            }
        }
    }

    /// The logarithm of all of it.
    fn total(&self) -> f64 {
        // Larger stakes come first and get more: it takes few units to win with them if one can win at all.
        let weight = |index: usize| 1.0 / (index + 1) as f64;
        let all: f64 = (0..STAKES.len()).map(weight).sum();
        let logarithm = |(index, (capital, logarithm)): (usize, &(f64, f64))| {
            libm::log(*capital) + logarithm + libm::log(weight(index) / all)
        };
        let each: Vec<f64> = self.capital.iter().enumerate().map(logarithm).collect();
        let most = each.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if most == f64::NEG_INFINITY {
            return most;
        }
        most + libm::log(each.iter().map(|one| libm::exp(one - most)).sum::<f64>())
    }
}

/// Whether units show that the mean of values between 0 and 1 is larger than `mean`.
fn shows_more(units: &[IndependentUnit], mean: f64, confidence: f64) -> bool {
    let mut bet = Bet::new(mean);
    units.iter().for_each(|unit| bet.take(*unit));
    bet.total() >= -libm::log1p(-confidence)
}

/// The mean is at least this, of values between 0 and 1.
fn least(units: &[IndependentUnit], confidence: f64) -> f64 {
    let (sum, count) =
        units.iter().fold((0.0, 0.0), |(sum, count), unit| (sum + unit.sum, count + f64::from(unit.values)));
    if sum <= 0.0 {
        return 0.0;
    }
    // What is shown to be more falls with the mean, and at what was seen nothing is.
    let (mut shown, mut open) = (0.0, (sum / count).min(1.0));
    while open - shown > 1e-12 {
        let middle = 0.5 * (shown + open);
        if shows_more(units, middle, confidence) { shown = middle } else { open = middle }
    }
    shown
}

/// Where the mean of values between `limits` lies: each end by itself at `confidence` (0..1), however often one looks.
/// Over units in which values are missing it is the mean of those there are. `None` if a value is beyond the limits.
pub fn mean_of_bounded(units: &[IndependentUnit], limits: (f64, f64), confidence: f64) -> Option<Interval> {
    let (low, high) = limits;
    let slack = 1e-9 * (high - low);
    let fits = |unit: &IndependentUnit| {
        let count = f64::from(unit.values);
        unit.sum >= count * (low - slack) && unit.sum <= count * (high + slack)
    };
    if !(low < high && units.iter().all(fits)) {
        return None;
    }
    let below: Vec<IndependentUnit> = units.iter().map(|unit| unit.up_from_low(limits)).collect();
    let above: Vec<IndependentUnit> = units.iter().map(|unit| unit.down_from_high(limits)).collect();
    Some(Interval {
        low: low + (high - low) * least(&below, confidence),
        high: high - (high - low) * least(&above, confidence),
    })
}

/// The same bets while units come in, on one mean only: whether it is larger or smaller than that.
#[derive(Debug, Clone)]
pub struct MeanWatch {
    limits: (f64, f64),
    confidence: f64,
    more: Bet,
    less: Bet,
}

impl MeanWatch {
    /// On a `mean`; one that is not between the limits is never decided on.
    pub fn new(mean: f64, limits: (f64, f64), confidence: f64) -> Self {
        let share = (mean - limits.0) / (limits.1 - limits.0);
        Self { limits, confidence, more: Bet::new(share), less: Bet::new(1.0 - share) }
    }

    /// Counts in values that came together, such as those of the runs of one trial.
    pub fn take(&mut self, unit: IndependentUnit) {
        self.more.take(unit.up_from_low(self.limits));
        self.less.take(unit.down_from_high(self.limits));
    }

    /// Whether it is shown to be on one side.
    pub fn decided(&self) -> bool {
        let enough = -libm::log1p(-self.confidence);
        let between = self.more.mean > 0.0 && self.more.mean < 1.0;
        between && (self.more.total() >= enough || self.less.total() >= enough)
    }
}

/// The fewest runs that can show that a mean is farther than `distance` from one end of its limits, `distance` as a share
/// of what is between them: with all values at the other end.
pub fn runs_for_mean(distance: f64, confidence: f64) -> Option<u64> {
    if distance >= 1.0 {
        return None;
    }
    if distance <= 0.0 {
        return Some(1);
    }
    let unit = IndependentUnit { sum: 1.0, values: 1, runs: 1 };
    let enough = |runs: u64| {
        // All alike: the capital of each stake is a power.
        let mut bet = Bet::new(distance);
        bet.take(unit);
        for (capital, logarithm) in &mut bet.capital {
            *logarithm = runs as f64 * (*logarithm + libm::log(*capital));
            *capital = 1.0;
        }
        bet.total() >= -libm::log1p(-confidence)
    };
    let mut most = 1_u64;
    while !enough(most) {
        most = most.checked_mul(2)?;
    }
    let mut few = most / 2;
    while most - few > 1 {
        let middle = few + (most - few) / 2;
        if enough(middle) { most = middle } else { few = middle }
    }
    Some(most)
}

#[cfg(test)]
mod tests {
    use super::super::clopper_pearson;
    use super::*;
    use crate::random::Stream;

    fn runs(values: &[f64]) -> Vec<IndependentUnit> {
        values.iter().map(|value| IndependentUnit::of_run(Some(*value))).collect()
    }

    #[test]
    fn equal_values_are_no_certainty() {
        // Twenty times nothing of up to 60 s: one run in twenty could still take long.
        let none = mean_of_bounded(&runs(&[0.0; 20]), (0.0, 60.0), 0.95).unwrap();
        assert_eq!(none.low, 0.0);
        // No bound may be below what holds where nothing but 0 and 60 s happens.
        let least = 60.0 * clopper_pearson(0, 20, 0.9).high;
        assert!(none.high >= least && none.high < 1.5 * least, "{none:?}");
        let two = mean_of_bounded(&runs(&[3.0, 3.0]), (0.0, 60.0), 0.95).unwrap();
        assert!(two.low < 1.0 && two.high > 50.0, "{two:?}");
    }

    #[test]
    fn the_capital_by_hand() {
        // One value of 0.5 against a mean of 0.25: each stake u becomes 1 - u + 2 u.
        let mut bet = Bet::new(0.25);
        bet.take(IndependentUnit::of_run(Some(0.5)));
        let all: f64 = (1..=STAKES.len()).map(|place| 1.0 / place as f64).sum();
        let by_hand: f64 =
            STAKES.iter().enumerate().map(|(index, stake)| (1.0 + stake) / (index + 1) as f64 / all).sum();
        assert!((libm::exp(bet.total()) - by_hand).abs() < 1e-12);
        // What is missing says nothing.
        bet.take(IndependentUnit::of_run(None));
        assert!((libm::exp(bet.total()) - by_hand).abs() < 1e-12);
        // Nothing at all loses the whole of the largest stake.
        bet.take(IndependentUnit::of_run(Some(0.0)));
        assert_eq!(bet.capital[0].0, 0.0);
    }

    #[test]
    fn on_average_nobody_wins_against_the_truth() {
        // Over all outcomes of three runs with values 0, 0.2 and 1 of known probability, in a group of two that take turns.
        let values = [0.0, 0.2, 1.0];
        let chances = [[0.5, 0.3, 0.2], [0.2, 0.7, 0.1]];
        let mean: f64 =
            chances.iter().flatten().zip(values.iter().cycle()).map(|(p, x)| p * x).sum::<f64>() / 2.0;
        let mut expected = 0.0;
        for (i, first) in values.iter().enumerate() {
            for (j, second) in values.iter().enumerate() {
                let mut bet = Bet::new(mean);
                runs(&[*first, *second]).into_iter().for_each(|unit| bet.take(unit));
                expected += chances[0][i] * chances[1][j] * libm::exp(bet.total());
            }
        }
        assert!(expected <= 1.0 + 1e-12 && expected > 0.9, "{expected}");
    }

    #[test]
    fn order_and_scale_do_not_matter() {
        let mut stream = Stream::seeded(3);
        let values: Vec<f64> = (0..50).map(|_| stream.uniform()).collect();
        let found = mean_of_bounded(&runs(&values), (0.0, 1.0), 0.95).unwrap();
        let mut turned = values.clone();
        turned.reverse();
        let again = mean_of_bounded(&runs(&turned), (0.0, 1.0), 0.95).unwrap();
        assert!((again.low - found.low).abs() < 1e-9 && (again.high - found.high).abs() < 1e-9);
        let larger: Vec<f64> = values.iter().map(|value| 5.0 + 60.0 * value).collect();
        let larger = mean_of_bounded(&runs(&larger), (5.0, 65.0), 0.95).unwrap();
        assert!((larger.low - 5.0 - 60.0 * found.low).abs() < 1e-6, "{larger:?} {found:?}");
        assert!((larger.high - 5.0 - 60.0 * found.high).abs() < 1e-6, "{larger:?} {found:?}");
        assert!(found.low > 0.3 && found.low < 0.5 && found.high > 0.5 && found.high < 0.7, "{found:?}");
        assert_eq!(mean_of_bounded(&runs(&[0.5, 1.1]), (0.0, 1.0), 0.95), None);
    }

    #[test]
    fn watching_agrees_with_the_interval() {
        let mut stream = Stream::seeded(8);
        let values: Vec<f64> = (0..80).map(|_| 20.0 * stream.uniform() * stream.uniform()).collect();
        let interval = mean_of_bounded(&runs(&values), (0.0, 60.0), 0.95).unwrap();
        for mean in [1.0, 3.0, interval.low * 0.999, interval.low * 1.001, 5.0, interval.high * 1.001, 30.0] {
            let mut watch = MeanWatch::new(mean, (0.0, 60.0), 0.95);
            runs(&values).into_iter().for_each(|unit| watch.take(unit));
            assert_eq!(watch.decided(), !interval.contains(mean), "{mean} {interval:?}");
        }
    }

    #[test]
    fn runs_that_a_mean_needs() {
        for (distance, confidence) in [(0.9, 0.95), (0.5, 0.95), (0.99, 0.99)] {
            let needed = runs_for_mean(distance, confidence).unwrap();
            let all = |count: u64| vec![IndependentUnit::of_run(Some(1.0)); count as usize];
            assert!(shows_more(&all(needed), distance, confidence));
            assert!(!shows_more(&all(needed - 1), distance, confidence));
        }
        // At most 0.001 s of 60 s at 99.9999 %: not with two runs.
        assert!(runs_for_mean(1.0 - 0.001 / 60.0, 0.999_999).unwrap() > 800_000);
        assert_eq!(runs_for_mean(1.0, 0.95), None);
    }
}
