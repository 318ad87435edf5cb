//! Numbers that JSON does not carry by itself: infinite ones, and whole ones beyond what other languages hold exactly.
//!
//! Each module is for `#[serde(with = "…")]`.

/// Whole numbers as numbers up to 2^53 and as decimal text above; both are read.
pub mod whole {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// Every program that keeps numbers as doubles is exact up to here.
    const EXACT: u64 = 1 << 53;

    /// # Errors
    /// Those of the serializer.
    // The signature is serde's.
    #[allow(clippy::trivially_copy_pass_by_ref)]
    pub fn serialize<S: Serializer>(number: &u64, serializer: S) -> Result<S::Ok, S::Error> {
        if *number <= EXACT { number.serialize(serializer) } else { serializer.collect_str(number) }
    }

    /// # Errors
    /// If it is neither a whole number nor the text of one.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Number(u64),
            Text(String),
        }
        match Written::deserialize(deserializer)? {
            Written::Number(number) => Ok(number),
            Written::Text(text) => text.parse().map_err(serde::de::Error::custom),
        }
    }
}

/// Fingerprints as 16 hexadecimal digits.
pub mod hexadecimal {
    use serde::{Deserialize, Deserializer, Serializer};

    /// # Errors
    /// Those of the serializer.
    // The signature is serde's.
    #[allow(clippy::trivially_copy_pass_by_ref)]
    pub fn serialize<S: Serializer>(number: &u64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{number:016x}"))
    }

    /// # Errors
    /// If it is no text of hexadecimal digits.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
        let text = String::deserialize(deserializer)?;
        u64::from_str_radix(&text, 16).map_err(serde::de::Error::custom)
    }
}

/// Numbers that may be missing (`null`) or infinite (`"inf"`, `"-inf"`).
pub mod extended {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// # Errors
    /// Those of the serializer.
    // The signature is serde's.
    #[allow(clippy::trivially_copy_pass_by_ref)]
    pub fn serialize<S: Serializer>(number: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
        match number {
            Some(number) if number.is_infinite() => serializer.collect_str(number),
            number => number.serialize(serializer),
        }
    }

    /// # Errors
    /// If it is neither `null`, a number nor one of the two words.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Number(Option<f64>),
            Text(String),
        }
        match Written::deserialize(deserializer)? {
            Written::Number(number) => Ok(number),
            Written::Text(text) if text == "inf" => Ok(Some(f64::INFINITY)),
            Written::Text(text) if text == "-inf" => Ok(Some(f64::NEG_INFINITY)),
            Written::Text(text) => Err(serde::de::Error::custom(format!("`{text}` is no number"))),
        }
    }
}

/// The lower end of a range: `null` where there is none.
pub mod low {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// # Errors
    /// Those of the serializer.
    // The signature is serde's.
    #[allow(clippy::trivially_copy_pass_by_ref)]
    pub fn serialize<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        Some(*number).filter(|number| number.is_finite()).serialize(serializer)
    }

    /// # Errors
    /// If it is neither `null` nor a number.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NEG_INFINITY))
    }
}

/// The upper end of a range: `null` where there is none.
pub mod high {
    use serde::{Deserialize, Deserializer};

    pub use super::low::serialize;

    /// # Errors
    /// If it is neither `null` nor a number.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
    }
}

/// Two ends of an interval, if there is one: `null` for an end that there is none of.
pub mod interval {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// # Errors
    /// Those of the serializer.
    // The signature is serde's.
    #[allow(clippy::trivially_copy_pass_by_ref)]
    pub fn serialize<S: Serializer>(ends: &Option<(f64, f64)>, serializer: S) -> Result<S::Ok, S::Error> {
        let end = |end: f64| Some(end).filter(|end| end.is_finite());
        ends.map(|(low, high)| (end(low), end(high))).serialize(serializer)
    }

    /// # Errors
    /// If it is neither `null` nor a pair of numbers or `null`s.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<(f64, f64)>, D::Error> {
        let ends: Option<(Option<f64>, Option<f64>)> = Option::deserialize(deserializer)?;
        Ok(ends.map(|(low, high)| (low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY))))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde::{Deserialize, Serialize};

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct All {
        #[serde(with = "super::whole")]
        whole: u64,
        #[serde(with = "super::hexadecimal")]
        hexadecimal: u64,
        #[serde(with = "super::extended")]
        extended: Option<f64>,
        #[serde(with = "super::low")]
        low: f64,
        #[serde(with = "super::high")]
        high: f64,
        #[serde(with = "super::interval")]
        interval: Option<(f64, f64)>,
    }

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![any::<f64>().prop_filter("a number", |number| number.is_finite()), Just(f64::INFINITY)]
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(
            whole: u64, hexadecimal: u64, extended in prop::option::of(number()), negative: bool, low in number(),
            high in number(), interval in prop::option::of((number(), number()))
        ) {
            let all = All {
                whole,
                hexadecimal,
                extended: extended.map(|one| if negative { -one } else { one }),
                low: -low,
                high,
                interval: interval.map(|(low, high)| (-low, high)),
            };
            let text = serde_json::to_string(&all).unwrap();
            prop_assert_eq!(serde_json::from_str::<All>(&text).unwrap(), all);
        }
    }

    #[test]
    fn what_other_languages_would_round_is_text() {
        let all = |whole| All {
            whole,
            hexadecimal: 255,
            extended: Some(f64::NEG_INFINITY),
            low: f64::NEG_INFINITY,
            high: 1.5,
            interval: Some((0.0, f64::INFINITY)),
        };
        let text = |whole| serde_json::to_string(&all(whole)).unwrap();
        assert!(text(1 << 53).contains("\"whole\":9007199254740992,"));
        let beyond = r#"{"whole":"9007199254740993","hexadecimal":"00000000000000ff","extended":"-inf","low":null,"high":1.5,"interval":[0.0,null]}"#;
        assert_eq!(text((1 << 53) + 1), beyond);
    }
}
