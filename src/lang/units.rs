//! The units of the language.

use crate::scenario::{Dimension, Notation, Symbol};

/// A unit: a quantity `n` of it is `n * numerator / denominator` in SI units. Two numbers, because most conversions
/// are exact as a fraction and then round only once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    pub symbol: &'static str,
    pub dimension: Dimension,
    numerator: f64,
    denominator: f64,
    pub doc: &'static str,
}

impl Unit {
    pub fn to_si(self, number: f64) -> f64 {
        number * self.numerator / self.denominator
    }

    /// For showing numbers in it where units are not known.
    pub fn notation(self) -> Notation {
        Notation {
            symbol: Symbol::new(self.symbol),
            numerator: self.numerator,
            denominator: self.denominator,
        }
    }

    /// The number of this unit that is `number` in SI units, up to rounding.
    pub fn of_si(self, number: f64) -> f64 {
        number * self.denominator / self.numerator
    }
}

const fn unit(
    symbol: &'static str,
    dimension: Dimension,
    (numerator, denominator): (f64, f64),
    doc: &'static str,
) -> Unit {
    Unit { symbol, dimension, numerator, denominator, doc }
}

/// Every unit there is.
pub static UNITS: &[Unit] = &[
    unit("m", Dimension::LENGTH, (1.0, 1.0), "metre"),
    unit("km", Dimension::LENGTH, (1000.0, 1.0), "kilometre"),
    unit("cm", Dimension::LENGTH, (1.0, 100.0), "centimetre"),
    unit("ft", Dimension::LENGTH, (0.3048, 1.0), "foot"),
    unit("s", Dimension::TIME, (1.0, 1.0), "second"),
    unit("ms", Dimension::TIME, (1.0, 1000.0), "millisecond"),
    unit("min", Dimension::TIME, (60.0, 1.0), "minute"),
    unit("m/s", Dimension::SPEED, (1.0, 1.0), "metre per second"),
    unit("km/h", Dimension::SPEED, (5.0, 18.0), "kilometre per hour"),
    unit("mph", Dimension::SPEED, (0.447_04, 1.0), "mile per hour"),
    unit("m/s^2", Dimension::ACCELERATION, (1.0, 1.0), "metre per second squared"),
    unit("m/s²", Dimension::ACCELERATION, (1.0, 1.0), "metre per second squared"),
    unit("g", Dimension::ACCELERATION, (9.806_65, 1.0), "standard gravity"),
    unit("m/s^3", Dimension::JERK, (1.0, 1.0), "metre per second cubed"),
    unit("m/s³", Dimension::JERK, (1.0, 1.0), "metre per second cubed"),
    unit("rad", Dimension::ANGLE, (1.0, 1.0), "radian"),
    unit("deg", Dimension::ANGLE, (std::f64::consts::PI, 180.0), "degree"),
    unit("°", Dimension::ANGLE, (std::f64::consts::PI, 180.0), "degree"),
    unit("rad/s", Dimension::ANGULAR_SPEED, (1.0, 1.0), "radian per second"),
    unit("deg/s", Dimension::ANGULAR_SPEED, (std::f64::consts::PI, 180.0), "degree per second"),
    unit("%", Dimension::NUMBER, (1.0, 100.0), "hundredth"),
    unit("Hz", Dimension::FREQUENCY, (1.0, 1.0), "per second"),
];

/// The unit of that symbol.
pub fn unit_of(symbol: &str) -> Option<Unit> {
    UNITS.iter().copied().find(|unit| unit.symbol == symbol)
}

/// The units of a dimension, for hints: "`m`, `km` or `ft`".
pub fn units_for(dimension: Dimension) -> Option<String> {
    let symbols: Vec<_> =
        UNITS.iter().filter(|unit| unit.dimension == dimension).map(|u| format!("`{}`", u.symbol)).collect();
    match symbols.as_slice() {
        [] => None,
        [only] => Some(only.clone()),
        [first @ .., last] => Some(format!("{} or {last}", first.join(", "))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_convert_with_one_rounding() {
        let si = |number, symbol| unit_of(symbol).unwrap().to_si(number);
        assert_eq!(si(30.0, "km/h"), 30.0 / 3.6);
        assert_eq!(si(36.0, "km/h"), 10.0);
        assert_eq!(si(25.0, "ms"), 0.025);
        assert_eq!(si(95.0, "%"), 0.95);
        assert_eq!(si(180.0, "deg"), std::f64::consts::PI);
        assert_eq!(si(1.0, "mph"), 0.44704);
    }

    #[test]
    fn symbols_are_unique() {
        for (index, unit) in UNITS.iter().enumerate() {
            assert_eq!(UNITS.iter().position(|other| other.symbol == unit.symbol), Some(index));
        }
    }
}
