//! From data to pixels, with ticks at round numbers.

use scenario::significant;

/// A linear or logarithmic map from data to pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
    logarithmic: bool,
}

impl Scale {
    /// Maps `low` to `from` and `high` to `to`.
    pub fn new((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
        Self { low, high, from, to, logarithmic: false }
    }

    /// The same with equal factors at equal distances; both ends of the interval are positive.
    pub fn logarithmic((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
        Self { low: libm::log(low), high: libm::log(high), from, to, logarithmic: true }
    }

    pub fn at(&self, value: f64) -> f64 {
        let value = if self.logarithmic { libm::log(value) } else { value };
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }
}

/// An interval that holds all of `values` with a little air, ends at round numbers and is never empty.
pub fn nice_range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.into_iter().filter(|value| value.is_finite()) {
        (low, high) = (low.min(value), high.max(value));
    }
    if low > high {
        return (0.0, 1.0);
    }
    if low == high {
        let room = if low == 0.0 { 1.0 } else { low.abs() / 2.0 };
        (low, high) = (low - room, high + room);
    }
    // Quantities that begin near zero are read against zero.
    if low > 0.0 && low < 0.4 * high {
        low = 0.0;
    }
    let step = step(low, high, 5);
    ((low / step).floor() * step, (high / step).ceil() * step)
}

/// The interval of the values with a little room at both ends, so that no mark sits on the frame.
pub fn with_room(values: &[f64]) -> (f64, f64) {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    match high - low {
        span if span > 0.0 => (low - span * 0.08, high + span * 0.08),
        // One value, or none at all.
        _ if low.is_finite() => (low - 1.0, high + 1.0),
        _ => (0.0, 1.0),
    }
}

/// Round numbers within the interval, about `about` of them.
pub fn ticks(low: f64, high: f64, about: usize) -> Vec<f64> {
    let step = step(low, high, about);
    let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
    (first..=last).map(|index| index as f64 * step).collect()
}

/// More powers of ten than this have no room below a chart.
const MOST_DECADES: usize = 8;

/// Round numbers within an interval of positive numbers that is seen on a logarithmic scale.
pub fn logarithmic_ticks(low: f64, high: f64) -> Vec<f64> {
    let decades = libm::floor(libm::log10(low)) as i32..=libm::ceil(libm::log10(high)) as i32;
    let within = |factors: &[f64]| -> Vec<f64> {
        let all = decades
            .clone()
            .flat_map(|power| factors.iter().map(move |factor| factor * libm::pow(10.0, f64::from(power))));
        all.filter(|tick| (low * 0.9999..=high * 1.0001).contains(tick)).collect()
    };
    match (within(&[1.0, 2.0, 5.0]), within(&[1.0])) {
        (fine, _) if fine.len() < 3 => ticks(low, high, 5),
        (fine, coarse) if fine.len() > 8 && coarse.len() > 1 => {
            let every = coarse.len().div_ceil(MOST_DECADES);
            coarse.into_iter().step_by(every).collect()
        }
        (fine, _) => fine,
    }
}

/// A tick's number without rounding noise.
pub fn tick_label(value: f64) -> String {
    significant(value, 6)
}

/// The number of a tick of a logarithmic scale: powers of ten that are long as numbers are written as powers.
pub fn logarithmic_label(value: f64) -> String {
    let power = libm::round(libm::log10(value));
    let exact = (value / libm::pow(10.0, power) - 1.0).abs() < 1e-9;
    if !exact || (-3.0..5.0).contains(&power) {
        return tick_label(value);
    }
    let number = format!("{power}");
    let digits = number.chars().map(|digit| match digit.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    });
    format!("10{}", digits.collect::<String>())
}

/// 1, 2 or 5 times a power of ten, so that the interval has about `about` steps.
fn step(low: f64, high: f64, about: usize) -> f64 {
    let rough = (high - low) / about.max(1) as f64;
    let power = libm::pow(10.0, libm::log10(rough).floor());
    let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|factor| factor * power >= rough * 0.999);
    factor.unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn ticks_are_round() {
        assert_eq!(ticks(0.0, 1.0, 5), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
        assert_eq!(ticks(6.0, 18.0, 5), [10.0, 15.0]);
        assert_eq!(tick_label(0.6000000000000001), "0.6");
        assert_eq!(nice_range([1.2, 4.7]), (0.0, 5.0));
        assert_eq!(nice_range([]), (0.0, 1.0));
        assert_eq!(nice_range([0.0]), (-1.0, 1.0));
        assert_eq!(nice_range([f64::NAN, 98.0, 99.0]), (98.0, 99.0));
    }

    #[test]
    fn equal_factors_lie_at_equal_distances() {
        let scale = Scale::logarithmic((1.0, 100.0), (0.0, 80.0));
        assert_eq!([1.0, 10.0, 100.0].map(|value| scale.at(value).round()), [0.0, 40.0, 80.0]);
        let near = |ticks: Vec<f64>| ticks.into_iter().map(tick_label).collect::<Vec<_>>().join(" ");
        assert_eq!(near(logarithmic_ticks(0.5, 20.0)), "0.5 1 2 5 10 20");
        assert_eq!(near(logarithmic_ticks(0.001, 1000.0)), "0.001 0.01 0.1 1 10 100 1000");
        assert_eq!(near(logarithmic_ticks(3.0, 4.0)), "3 3.2 3.4 3.6 3.8 4");
        // Powers that are long as numbers, and no more of them than there is room for.
        let labels = |low, high| -> Vec<String> {
            logarithmic_ticks(low, high).into_iter().map(logarithmic_label).collect()
        };
        assert_eq!(labels(0.9, 2e7).join(" "), "1 10 100 1000 10000 10⁵ 10⁶ 10⁷");
        assert_eq!(labels(0.9, 2e12).join(" "), "1 100 10000 10⁶ 10⁸ 10¹⁰ 10¹²");
        assert_eq!(logarithmic_label(2e5), "200000");
        assert_eq!(logarithmic_label(1e-6), "10⁻⁶");
    }

    proptest! {
        #[test]
        fn a_nice_range_holds_the_values(values in prop::collection::vec(-1e6..1e6f64, 1..20)) {
            let (low, high) = nice_range(values.iter().copied());
            prop_assert!(low < high);
            prop_assert!(values.iter().all(|value| low <= *value && *value <= high));
            let count = ticks(low, high, 5).len();
            prop_assert!((2..=12).contains(&count), "{count} ticks in {low} .. {high}");
        }
    }
}
