//! The units of the language.

use scenario::{Dimension, Notation, Symbol};

/// A unit: a quantity `n` of it is `n * numerator / denominator` in SI units. Two numbers, because most conversions
/// are exact as a fraction and then round only once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitEntry {
    /// As it is written after a number.
    pub symbol: &'static str,
    /// What kind of quantity it is of.
    pub dimension: Dimension,
    numerator: f64,
    denominator: f64,
    /// One line.
    pub doc: &'static str,
    /// Whether people expect numbers in it that they have not written in it.
    pub is_usual: bool,
    /// The other spelling that the unit is known by, if this is not its own.
    pub spells: Option<&'static str>,
    /// What people write who mean it, in small letters.
    tried: &'static [&'static str],
}

impl UnitEntry {
    /// The quantity in SI units.
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
) -> UnitEntry {
    UnitEntry { symbol, dimension, numerator, denominator, doc, is_usual: true, spells: None, tried: &[] }
}

impl UnitEntry {
    const fn unusual(self) -> Self {
        Self { is_usual: false, ..self }
    }

    /// Another way to write the unit of that symbol.
    const fn spells(self, symbol: &'static str) -> Self {
        Self { spells: Some(symbol), is_usual: false, ..self }
    }

    const fn tried(self, tried: &'static [&'static str]) -> Self {
        Self { tried, ..self }
    }
}

/// Every unit there is.
pub static UNITS: &[UnitEntry] = &[
    unit("m", Dimension::LENGTH, (1.0, 1.0), "metre").tried(&["meter", "meters", "metre", "metres"]),
    unit("km", Dimension::LENGTH, (1000.0, 1.0), "kilometre").unusual(),
    unit("cm", Dimension::LENGTH, (1.0, 100.0), "centimetre"),
    unit("ft", Dimension::LENGTH, (0.3048, 1.0), "foot").unusual().tried(&["feet", "foot"]),
    unit("s", Dimension::TIME, (1.0, 1.0), "second").tried(&["sec", "secs", "second", "seconds"]),
    unit("ms", Dimension::TIME, (1.0, 1000.0), "millisecond").tried(&["msec", "millisecond", "milliseconds"]),
    unit("min", Dimension::TIME, (60.0, 1.0), "minute").unusual().tried(&["minute", "minutes"]),
    unit("m/s", Dimension::SPEED, (1.0, 1.0), "metre per second").tried(&["mps"]),
    unit("km/h", Dimension::SPEED, (5.0, 18.0), "kilometre per hour").tried(&["kmh", "kph", "kmph", "km/hr"]),
    unit("mph", Dimension::SPEED, (0.447_04, 1.0), "mile per hour").unusual(),
    unit("m/s^2", Dimension::ACCELERATION, (1.0, 1.0), "metre per second squared")
        .tried(&["ms^2", "mss", "m/ss", "m/s2", "mps2"]),
    unit("m/s²", Dimension::ACCELERATION, (1.0, 1.0), "metre per second squared").spells("m/s^2"),
    unit("g", Dimension::ACCELERATION, (9.806_65, 1.0), "standard gravity").unusual(),
    unit("m/s^3", Dimension::JERK, (1.0, 1.0), "metre per second cubed"),
    unit("m/s³", Dimension::JERK, (1.0, 1.0), "metre per second cubed").spells("m/s^3"),
    unit("rad", Dimension::ANGLE, (1.0, 1.0), "radian"),
    unit("deg", Dimension::ANGLE, (std::f64::consts::PI, 180.0), "degree").tried(&["degree", "degrees"]),
    unit("°", Dimension::ANGLE, (std::f64::consts::PI, 180.0), "degree").spells("deg"),
    unit("rad/s", Dimension::ANGULAR_SPEED, (1.0, 1.0), "radian per second"),
    unit("deg/s", Dimension::ANGULAR_SPEED, (std::f64::consts::PI, 180.0), "degree per second"),
    unit("%", Dimension::NUMBER, (1.0, 100.0), "hundredth").tried(&["percent"]),
    unit("Hz", Dimension::FREQUENCY, (1.0, 1.0), "per second").tried(&["hertz"]),
];

/// The unit of that symbol.
pub fn unit_of(symbol: &str) -> Option<UnitEntry> {
    UNITS.iter().copied().find(|unit| unit.symbol == symbol)
}

/// The unit that somebody means who writes `symbol`, which is none.
pub fn meant(symbol: &str) -> Option<&'static str> {
    let symbol = symbol.to_lowercase();
    UNITS.iter().find(|unit| unit.tried.contains(&symbol.as_str())).map(|unit| unit.symbol)
}

/// All of them: "m, km; s, ms; m/s^2 (also m/s²)".
pub fn listed() -> String {
    let own = UNITS.iter().filter(|unit| unit.spells.is_none()).collect::<Vec<_>>();
    let kinds = own.chunk_by(|one, next| one.dimension == next.dimension).map(|units| {
        let shown = units.iter().map(|unit| {
            let also = UNITS.iter().find(|other| other.spells == Some(unit.symbol));
            unit.symbol.to_string() + &also.map(|also| format!(" (also {})", also.symbol)).unwrap_or_default()
        });
        shown.collect::<Vec<_>>().join(", ")
    });
    kinds.collect::<Vec<_>>().join("; ")
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
    fn the_page_of_reference_names_every_unit() {
        let page =
            std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/language.md")).unwrap();
        for unit in UNITS {
            assert!(page.contains(&format!("`{}`", unit.symbol)), "{}", unit.symbol);
        }
    }

    #[test]
    fn other_spellings_are_of_the_same_unit() {
        for unit in UNITS {
            let own = unit.spells.map_or(*unit, |symbol| unit_of(symbol).unwrap());
            assert_eq!((unit.to_si(1.0), unit.dimension), (own.to_si(1.0), own.dimension), "{}", unit.symbol);
            for tried in unit.tried {
                assert!(unit_of(tried).is_none() && meant(tried) == Some(unit.symbol), "{tried}");
            }
        }
        assert!(listed().contains("m/s^2 (also m/s²), g; "), "{}", listed());
    }

    #[test]
    fn symbols_are_unique() {
        for (index, unit) in UNITS.iter().enumerate() {
            assert_eq!(UNITS.iter().position(|other| other.symbol == unit.symbol), Some(index));
        }
    }
}
