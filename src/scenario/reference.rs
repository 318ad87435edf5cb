//! What data refer to: an entry of a registry, which is its name wherever data are written down.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::Declaration;

/// What stands in a registry under the name that it declares.
pub trait Registered {
    /// What it declares; registries hold it under the declared name.
    fn declaration(&self) -> &Declaration;

    /// What runs, of something that a file declares: its name alone does not say what it is.
    fn runs(&self) -> Option<String> {
        None
    }
}

/// An entry of a registry. References to entries of one name are equal, and serialise as that name.
///
/// One that was read from a file is a name alone: it stands for nothing before a registry has resolved it.
pub struct Reference<T> {
    name: Arc<str>,
    entry: Option<Arc<T>>,
}

impl<T> Reference<T> {
    /// A name that no registry was asked for.
    pub fn unresolved(name: impl Into<Arc<str>>) -> Self {
        Self { name: name.into(), entry: None }
    }

    /// As scenarios say it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it stands for; `None` for a name that was not resolved.
    pub fn entry(&self) -> Option<&Arc<T>> {
        self.entry.as_ref()
    }
}

impl<T> Reference<T> {
    /// As [`Self::entry`], to be looked at.
    pub fn known(&self) -> Option<&T> {
        self.entry.as_deref()
    }
}

impl<T: Registered> Reference<T> {
    /// What its entry declares; `None` for a name that was not resolved.
    pub fn declaration(&self) -> Option<&Declaration> {
        self.entry.as_ref().map(|entry| entry.declaration())
    }
}

impl<T: Registered> From<Arc<T>> for Reference<T> {
    fn from(entry: Arc<T>) -> Self {
        Self { name: entry.declaration().name.as_ref().into(), entry: Some(entry) }
    }
}

impl<T: Registered> From<&Arc<T>> for Reference<T> {
    fn from(entry: &Arc<T>) -> Self {
        entry.clone().into()
    }
}

impl<T> Clone for Reference<T> {
    fn clone(&self) -> Self {
        Self { name: self.name.clone(), entry: self.entry.clone() }
    }
}

impl<T> PartialEq for Reference<T> {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl<T> Eq for Reference<T> {}

impl<T> fmt::Debug for Reference<T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.name.fmt(out)
    }
}

impl<T> fmt::Display for Reference<T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.name.fmt(out)
    }
}

impl<T> Serialize for Reference<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name)
    }
}

impl<'de, T> Deserialize<'de> for Reference<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(Self::unresolved)
    }
}
