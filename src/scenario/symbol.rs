//! A unit's symbol, such as `km/h`: short text that is as cheap to copy as a number.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// At most [`Symbol::LONGEST`] bytes of text.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Symbol {
    bytes: [u8; Self::LONGEST],
    length: usize,
}

impl Symbol {
    /// In bytes; a longer one is refused.
    pub const LONGEST: usize = 16;

    /// # Panics
    /// If `text` is too long; see [`Symbol::of`].
    pub const fn new(text: &str) -> Self {
        match Self::of(text) {
            Some(symbol) => symbol,
            None => panic!("a unit's symbol has at most 16 bytes"),
        }
    }

    /// `None` for text that is too long.
    pub const fn of(text: &str) -> Option<Self> {
        let text = text.as_bytes();
        if text.len() > Self::LONGEST {
            return None;
        }
        let mut bytes = [0; Self::LONGEST];
        let mut index = 0;
        while index < text.len() {
            bytes[index] = text[index];
            index += 1;
        }
        Some(Self { bytes, length: text.len() })
    }

    /// The symbol as it is written: `km/h`.
    pub fn as_str(&self) -> &str {
        std::str::from_utf8(&self.bytes[..self.length]).unwrap_or_default()
    }
}

impl fmt::Debug for Symbol {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), out)
    }
}

impl fmt::Display for Symbol {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self.as_str(), out)
    }
}

impl Serialize for Symbol {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.as_str().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Symbol {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::of(&text).ok_or_else(|| serde::de::Error::custom(format!("`{text}` is too long for a unit")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_text_is_kept_and_long_text_refused() {
        for text in ["", "%", "°", "m/s^2", "sixteen bytes ok"] {
            assert_eq!(Symbol::new(text).as_str(), text);
            let written = serde_json::to_string(&Symbol::new(text)).unwrap();
            assert_eq!(serde_json::from_str::<Symbol>(&written).unwrap(), Symbol::new(text));
        }
        assert_eq!(Symbol::of("seventeen bytes x"), None);
        assert!(serde_json::from_str::<Symbol>("\"seventeen bytes x\"").is_err());
    }
}
