//! How a number was written: the unit to show it in again, and what to say of one that is out of range.

use serde::{Deserialize, Serialize};

use super::Symbol;
use super::{Dimension, Origin, significant};

/// A unit that somebody chose: a number `n` of it is `n * numerator / denominator` in SI units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Notation {
    /// As it is written after a number.
    pub symbol: Symbol,
    /// Larger than 0.
    pub numerator: f64,
    /// Larger than 0; the two are kept apart because most units are exact as a fraction and are then rounded once.
    pub denominator: f64,
}

/// Where and in which unit a scenario says a number.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Written {
    /// `None`: in the SI unit, or calculated from other units.
    pub notation: Option<Notation>,
    /// Where it is written.
    pub origin: Origin,
    /// What was added to the number that was written, in SI units: half a lane for a distance from the kerb.
    pub offset: f64,
}

/// More digits than this nobody writes; a number that has them was drawn or calculated.
const MOST_WRITTEN_DIGITS: usize = 7;

impl Notation {
    /// The number of this unit that is `si` in SI units, up to rounding.
    pub fn of_si(self, si: f64) -> f64 {
        si * self.denominator / self.numerator
    }

    fn is_si(self) -> bool {
        self.numerator == self.denominator
    }
}

/// All digits if there are so few that somebody may have written them, else the four that matter.
fn digits(number: f64) -> String {
    let whole = significant(number, 12);
    if is_short(&whole) { whole } else { significant(number, 4) }
}

fn is_short(number: &str) -> bool {
    let mantissa = number.trim_start_matches(['-', '0', '.']);
    mantissa.chars().filter(char::is_ascii_digit).count() <= MOST_WRITTEN_DIGITS
}

fn with_symbol(number: &str, symbol: &str) -> String {
    if symbol.is_empty() { number.to_string() } else { format!("{number} {symbol}") }
}

/// A number in SI units as its author would write it: `-6.26 km/h`, `4 s`.
pub fn show(si: f64, notation: Option<Notation>, dimension: Dimension) -> String {
    match notation {
        Some(unit) => with_symbol(&digits(unit.of_si(si)), unit.symbol.as_str()),
        None => with_symbol(&digits(si), &dimension.si_unit()),
    }
}

/// Two numbers in SI units as [`show`] gives them in the SI unit, with as many more digits as tell them apart: of the two somebody
/// is told that they do not fit each other.
pub fn show_both(one: f64, other: f64, dimension: Dimension) -> (String, String) {
    let mut shown = show_apart(&[(one, dimension, None), (other, dimension, None)]).into_iter();
    (shown.next().unwrap_or_default(), shown.next().unwrap_or_default())
}

/// Numbers in SI units as [`show`] gives them, with as many more digits as tell apart those that differ.
pub fn show_apart(numbers: &[(f64, Dimension, Option<Notation>)]) -> Vec<String> {
    let shown = |digits: &dyn Fn(f64) -> String| -> Vec<String> {
        let one = |(si, dimension, notation): &(f64, Dimension, Option<Notation>)| match notation {
            Some(unit) => with_symbol(&digits(unit.of_si(*si)), unit.symbol.as_str()),
            None => with_symbol(&digits(*si), &dimension.si_unit()),
        };
        numbers.iter().map(one).collect()
    };
    let told_apart = |texts: &Vec<String>| {
        let bits = |index: usize| numbers[index].0.to_bits();
        let same = |left: usize, right: usize| texts[left] == texts[right] && bits(left) != bits(right);
        (0..texts.len()).all(|right| (0..right).all(|left| !same(left, right)))
    };
    let few = shown(&digits);
    let more = (5..=17).map(|count| shown(&|number| significant(number, count)));
    // Of tiny numbers, of those that differ in their last bit, and of 0 and -0 only all digits tell.
    let all = std::iter::once_with(|| shown(&all_digits));
    std::iter::once(few.clone()).chain(more).chain(all).find(told_apart).unwrap_or(few)
}

/// The shortest text that is read as the same number.
fn all_digits(number: f64) -> String {
    let text = format!("{number:?}");
    text.strip_suffix(".0").unwrap_or(&text).to_string()
}

/// A number that lies outside a range, both in one unit, which is not shown, with so many digits that it does not look inside.
pub fn show_outside(found: f64, (low, high): (f64, f64)) -> String {
    let looks_outside = |shown: &str| shown.parse::<f64>().is_ok_and(|shown| shown < low || shown > high);
    let shown = std::iter::once(digits(found)).chain((5..=17).map(|count| significant(found, count)));
    shown.into_iter().find(|shown| looks_outside(shown)).unwrap_or_else(|| found.to_string())
}

/// That `what` is `found` but must lie in a range, and in which: two texts, all numbers in the unit of `notation`. Where the range has
/// no round numbers in that unit, it is given in SI units as well.
pub fn out_of_range(
    what: &str,
    found: f64,
    (low, high): (f64, f64),
    dimension: Dimension,
    notation: Option<Notation>,
) -> (String, String) {
    let (in_unit, symbol): (Box<dyn Fn(f64) -> f64>, String) = match notation {
        Some(unit) => (Box::new(move |si| unit.of_si(si)), unit.symbol.to_string()),
        None => (Box::new(|si| si), dimension.si_unit()),
    };
    let bounds = |low: &str, high: &str, symbol: &str| match (low, high) {
        ("", high) => format!("at most {}", with_symbol(high, symbol)),
        (low, "") => format!("at least {}", with_symbol(low, symbol)),
        (low, high) => with_symbol(&format!("between {low} and {high}"), symbol),
    };
    let is_bound = |bound: f64| bound.is_finite() && bound.abs() < 1e300;
    let text = |bound: f64, number: f64| if is_bound(bound) { digits(number) } else { String::new() };
    let (shown_low, shown_high) = (text(low, in_unit(low)), text(high, in_unit(high)));
    let mut range = bounds(&shown_low, &shown_high, &symbol);
    let is_round = |bound: f64| !is_bound(bound) || is_short(&significant(in_unit(bound), 12));
    if notation.is_some_and(|unit| !unit.is_si()) && !(is_round(low) && is_round(high)) {
        range += &format!(" ({})", bounds(&text(low, low), &text(high, high), &dimension.si_unit()));
    }
    // Rounding must not put a number onto the bound that it misses by little.
    let number = in_unit(found);
    let shown = show_outside(number, (in_unit(low), in_unit(high)));
    (format!("{what} is {}, but must be {range}", with_symbol(&shown, &symbol)), range)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KMH: Notation = Notation { symbol: Symbol::new("km/h"), numerator: 5.0, denominator: 18.0 };
    const MPH: Notation = Notation { symbol: Symbol::new("mph"), numerator: 0.447_04, denominator: 1.0 };

    #[test]
    fn numbers_read_as_they_are_written() {
        let speed = |si, unit| show(si, unit, Dimension::SPEED);
        assert_eq!(speed(30.0 / 3.6, Some(KMH)), "30 km/h");
        assert_eq!(speed(-1.739_636_827_058_043_3, Some(KMH)), "-6.263 km/h");
        assert_eq!(speed(-1.739_636_827_058_043_3, None), "-1.74 m/s");
        assert_eq!(show(123_456.0, None, Dimension::LENGTH), "123456 m");
        assert_eq!(show(1.234_56, None, Dimension::NUMBER), "1.23456");
    }

    #[test]
    fn ranges_are_in_the_unit_of_what_misses_them() {
        let say = |found, unit| out_of_range("it", found, (0.0, 100.0), Dimension::SPEED, unit).0;
        assert_eq!(say(400.0 / 3.6, Some(KMH)), "it is 400 km/h, but must be between 0 and 360 km/h");
        assert_eq!(
            say(300.0 * 0.447_04, Some(MPH)),
            "it is 300 mph, but must be between 0 and 223.7 mph (between 0 and 100 m/s)"
        );
        assert_eq!(say(f64::INFINITY, None), "it is inf m/s, but must be between 0 and 100 m/s");
        assert_eq!(say(f64::NAN, None), "it is NaN m/s, but must be between 0 and 100 m/s");
    }

    #[test]
    fn numbers_that_do_not_fit_each_other_are_told_apart() {
        let say = |one, other| show_both(one, other, Dimension::TIME);
        assert_eq!(say(0.03, 0.005), ("0.03 s".to_string(), "0.005 s".to_string()));
        assert_eq!(say(1.0 / 3.0, 2.0 / 3.0), ("0.3333 s".to_string(), "0.6667 s".to_string()));
        assert_eq!(say(0.100_000_000_04, 0.1), ("0.10000000004 s".to_string(), "0.1 s".to_string()));
        assert_eq!(say(2.0 / 3.0, 2.0 / 3.0), ("0.6667 s".to_string(), "0.6667 s".to_string()));
    }

    #[test]
    fn what_misses_a_bound_by_little_is_not_rounded_onto_it() {
        let say = |found| out_of_range("it", found, (0.0, 100.0), Dimension::SPEED, None).0;
        assert!(say(100.000_000_4).starts_with("it is 100.0000004 m/s"), "{}", say(100.000_000_4));
        assert!(say(-1e-16).starts_with("it is -0.0000000000000001"), "{}", say(-1e-16));
    }
}
