//! What a road user is up to: one word of its model.

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// What a road user is up to, such as `waiting`; empty where its model does not say.
///
/// Compared, shown and serialised as its text. Neither making one of a word in the source nor a copy of any allocates.
#[derive(Clone)]
pub struct Mode(Word);

#[derive(Clone)]
enum Word {
    OfSource(&'static str),
    Given(Arc<str>),
}

impl Mode {
    /// Of a model that says nothing of itself: the empty word.
    pub const NONE: Self = Self::new("");

    /// A word that stands in the source.
    pub const fn new(word: &'static str) -> Self {
        Self(Word::OfSource(word))
    }

    /// The word, such as `emergency_stop`.
    pub fn as_str(&self) -> &str {
        match &self.0 {
            Word::OfSource(word) => word,
            Word::Given(word) => word,
        }
    }
}

impl Default for Mode {
    fn default() -> Self {
        Self::NONE
    }
}

impl From<&'static str> for Mode {
    fn from(word: &'static str) -> Self {
        Self::new(word)
    }
}

impl From<Arc<str>> for Mode {
    fn from(word: Arc<str>) -> Self {
        Self(Word::Given(word))
    }
}

impl From<String> for Mode {
    fn from(word: String) -> Self {
        Self(Word::Given(word.into()))
    }
}

impl Deref for Mode {
    type Target = str;

    fn deref(&self) -> &str {
        self.as_str()
    }
}

impl PartialEq for Mode {
    fn eq(&self, other: &Self) -> bool {
        self.as_str() == other.as_str()
    }
}

impl Eq for Mode {}

impl PartialEq<str> for Mode {
    fn eq(&self, other: &str) -> bool {
        self.as_str() == other
    }
}

impl PartialEq<&str> for Mode {
    fn eq(&self, other: &&str) -> bool {
        self.as_str() == *other
    }
}

impl fmt::Debug for Mode {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), out)
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self.as_str(), out)
    }
}

impl Serialize for Mode {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self)
    }
}

impl<'de> Deserialize<'de> for Mode {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        String::deserialize(from).map(Self::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_its_text_wherever_that_is_from() {
        let (own, given) = (Mode::new("cruise"), Mode::from("cruise".to_string()));
        assert_eq!(own, given);
        assert_ne!(own, Mode::NONE);
        assert!(given == "cruise" && *"cruise" == *given);
        assert_eq!((format!("{given}"), format!("{given:?}")), ("cruise".into(), "\"cruise\"".into()));
        let json = serde_json::to_string(&[&own, &given]).unwrap();
        assert_eq!(json, r#"["cruise","cruise"]"#);
        assert_eq!(serde_json::from_str::<[Mode; 2]>(&json).unwrap(), [own, given]);
    }
}
