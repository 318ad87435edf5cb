//! Numbers for people: few digits, with units.

use scenario::{Dimension, Metric, MetricKind, Notation, significant};

/// A metric's value with its unit, such as `1.23 s`, `yes` or `pedestrian`; `–` where it does not exist.
pub fn quantity(metric: &Metric, value: Option<f64>) -> String {
    let Some(value) = value else { return "–".to_string() };
    match &metric.kind {
        MetricKind::Flag => if value != 0.0 { "yes" } else { "no" }.to_string(),
        MetricKind::Category(words) => words.get(value as usize).map_or("?", |word| word).to_string(),
        MetricKind::Quantity(dimension) => with_unit(value, *dimension),
    }
}

/// A number in a coherent SI unit with four significant digits, such as `8.333 m/s`.
///
/// Infinite where runs decide that never came to a value: `∞`.
pub fn with_unit(value: f64, dimension: Dimension) -> String {
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "-∞" }.to_string();
    }
    let unit = dimension.si_unit();
    let number = significant(value, 4);
    if unit.is_empty() { number } else { format!("{number} {unit}") }
}

/// A number in SI units in the unit that somebody wrote, such as `30 km/h`.
pub fn in_notation(value: f64, unit: Notation) -> String {
    let number = match value.is_infinite() {
        true if value > 0.0 => "∞".to_string(),
        true => "-∞".to_string(),
        false => significant(unit.of_si(value), 4),
    };
    format!("{number} {}", unit.symbol).trim_end().to_string()
}

/// A share such as `85 %`.
pub fn share(value: f64) -> String {
    format!("{} %", significant(value * 100.0, 3))
}

/// A number in a unit given in words, `%` for shares in 0..1.
pub fn in_unit(value: f64, unit: &str) -> String {
    match unit {
        "%" => share(value),
        "" => significant(value, 4),
        unit => format!("{} {unit}", significant(value, 4)),
    }
}

/// A number in SI units, in the unit that somebody wrote or else as [`in_unit`].
pub fn in_written_unit(value: f64, written: Option<Notation>, unit: &str) -> String {
    written.map_or_else(|| in_unit(value, unit), |written| in_notation(value, written))
}

/// `1 trial`, `2 trials`.
pub fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

/// With a capital letter at the beginning.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_digits_and_no_trailing_zeros() {
        let cases =
            [(1.5, "1.5"), (0.0, "0"), (8.33333, "8.333"), (123456.7, "123457"), (-0.00001, "-0.00001")];
        for (value, text) in cases {
            assert_eq!(significant(value, 4), text);
        }
        assert_eq!(with_unit(2.5, Dimension::ACCELERATION), "2.5 m/s^2");
        assert_eq!(share(0.85), "85 %");
        assert_eq!(share(2.0 / 3.0), "66.7 %");
    }
}
