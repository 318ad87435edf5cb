//! Values that parameters and variations take, in SI units.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

/// A number in SI units, a truth value or a word (a choice's option, a file name, a variant).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// True or false.
    Flag(bool),
    /// In SI units.
    Number(f64),
    /// A choice's option, a file's name, a variant.
    Word(String),
}

impl Value {
    /// The number; `None` of what is none.
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// The word; `None` of what is none.
    pub fn as_word(&self) -> Option<&str> {
        match self {
            Self::Word(word) => Some(word),
            _ => None,
        }
    }
}

impl From<&str> for Value {
    fn from(word: &str) -> Self {
        Self::Word(word.to_string())
    }
}

impl fmt::Display for Value {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flag(flag) => flag.fmt(out),
            Self::Number(number) => number.fmt(out),
            Self::Word(word) => word.fmt(out),
        }
    }
}

/// Values by parameter name, sorted so that keys and hashes built from them are stable.
///
/// [`crate::Declaration::resolve`] fills in every declared parameter that has a value. The typed getters
/// below are for models reading their own declared parameters: asking for one that was never declared, or with
/// another type, is a bug and panics with the name.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Settings(pub BTreeMap<String, Value>);

impl Settings {
    /// What a parameter is set to; `None` if it is not.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.get(name)
    }

    /// Sets a parameter, in place of what it was set to.
    pub fn set(&mut self, name: impl Into<String>, value: Value) {
        self.0.insert(name.into(), value);
    }

    /// The number of a parameter that may be absent (declared without a default).
    pub fn optional_number(&self, name: &str) -> Option<f64> {
        self.0.get(name).map(|value| match value {
            Value::Number(number) => *number,
            other => panic!("parameter `{name}` is not a number: {other:?}"),
        })
    }

    /// The number of a parameter. Panics without one: settings are resolved against a declaration, whose defaults they have.
    pub fn number(&self, name: &str) -> f64 {
        self.optional_number(name).unwrap_or_else(|| panic!("parameter `{name}` has no value"))
    }

    /// The truth value of a parameter. Panics without one, as [`Self::number`] does.
    pub fn flag(&self, name: &str) -> bool {
        match self.0.get(name) {
            Some(Value::Flag(flag)) => *flag,
            other => panic!("parameter `{name}` is not a flag: {other:?}"),
        }
    }

    /// The word of a parameter. Panics without one, as [`Self::number`] does.
    pub fn word(&self, name: &str) -> &str {
        match self.0.get(name) {
            Some(Value::Word(word)) => word,
            other => panic!("parameter `{name}` is not a word: {other:?}"),
        }
    }
}

impl<const N: usize> From<[(&str, Value); N]> for Settings {
    fn from(pairs: [(&str, Value); N]) -> Self {
        Self::from(pairs.as_slice())
    }
}

impl From<&[(&str, Value)]> for Settings {
    fn from(pairs: &[(&str, Value)]) -> Self {
        Self(pairs.iter().map(|(name, value)| (name.to_string(), value.clone())).collect())
    }
}

/// With `digits` significant digits and no trailing zeros.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}").replace("-0", "0");
    }
    if value.abs() >= 1e15 {
        return format!("{value:e}");
    }
    let decimals = (digits - 1 - libm::log10(value.abs()).floor() as i32).clamp(0, 12) as usize;
    in_few_digits(value, decimals).unwrap_or_else(|| in_full(value, decimals))
}

/// With at most so many decimals and no trailing zeros, rounded by the standard library with all that it has.
fn in_full(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let trimmed = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if trimmed == "-0" { "0".to_string() } else { trimmed.to_string() }
}

/// As [`in_full`] of a finite number, if it has few digits and is not about halfway between two such numbers. Names of trials hold many
/// numbers, and this takes a fraction of the time.
fn in_few_digits(value: f64, decimals: usize) -> Option<String> {
    let scale = 10_u64.pow(decimals as u32);
    let scaled = value.abs() * scale as f64;
    // Below this, the product is off by less than a millionth.
    if scaled >= 1e9 {
        return None;
    }
    let rest = scaled.fract();
    if (rest - 0.5).abs() < 1e-6 {
        return None;
    }
    let rounded = scaled.trunc() as u64 + u64::from(rest > 0.5);
    let (whole, mut decimal, mut places) = (rounded / scale, rounded % scale, decimals);
    let sign = if value < 0.0 && rounded > 0 { "-" } else { "" };
    if decimal == 0 {
        return Some(format!("{sign}{whole}"));
    }
    while decimal % 10 == 0 {
        (decimal, places) = (decimal / 10, places - 1);
    }
    Some(format!("{sign}{whole}.{decimal:0places$}"))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn few_digits_are_those_of_the_standard_library(
            (whole, halves, off) in (-100_000_i64..100_000, 0_u32..2, -3_i64..4),
            decimals in 0_usize..=12,
            any in -1e6..1e6_f64,
        ) {
            // Halves between two numbers, and what is next to them.
            let half = (whole as f64 + 0.5 * f64::from(halves)) / 10_f64.powi(decimals as i32);
            let near = if half == 0.0 { 0.0 } else { f64::from_bits(half.to_bits().wrapping_add_signed(off)) };
            for value in [any, any * 1e-9, near] {
                if let Some(text) = in_few_digits(value, decimals) {
                    prop_assert_eq!(text, in_full(value, decimals), "{} with {} decimals", value, decimals);
                }
            }
        }
    }

    #[test]
    fn few_digits_are_of_numbers_that_have_few_and_are_not_halfway() {
        assert_eq!(in_few_digits(6.154737571618751, 4).as_deref(), Some("6.1547"));
        assert_eq!(in_few_digits(-0.25, 2).as_deref(), Some("-0.25"));
        assert_eq!(in_few_digits(-0.0001, 2).as_deref(), Some("0"));
        assert_eq!([in_few_digits(2.5, 0), in_few_digits(1e9, 0)], [None, None]);
    }

    #[test]
    fn digits_that_count() {
        for (value, digits, text) in [
            (0.0, 3, "0"),
            (-0.0, 3, "0"),
            (1.0, 3, "1"),
            (100.0, 2, "100"),
            (6.154737571618751, 5, "6.1547"),
            (-0.000123456, 3, "-0.000123"),
            (1e-15, 3, "0"),
            (-1e-15, 3, "0"),
            (0.5, 1, "0.5"),
            (2.5, 1, "2"),
            (99.96, 3, "100"),
            (1e12, 3, "1000000000000"),
            (1e15, 3, "1e15"),
            (f64::INFINITY, 3, "inf"),
        ] {
            assert_eq!(significant(value, digits), text, "{value} with {digits}");
        }
    }
}
