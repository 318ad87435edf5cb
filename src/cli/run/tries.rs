//! What was tried before since a try of it did not pass, so that trying until one passes shows.

use std::collections::BTreeMap;
use std::io;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::cli::store;

/// What is remembered of one name at most; the oldest that passed are forgotten first.
const MOST: usize = 1000;

/// Something that was tried, and whether it passed when it was tried last.
pub trait Try: Copy + Serialize + DeserializeOwned {
    /// Whether it is the same that is tried, whatever came of it.
    fn is_like(&self, other: &Self) -> bool;

    /// Whether it passed.
    fn passed(&self) -> bool;
}

/// By name: nothing of one of which every try passed that is known.
#[derive(Debug, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Tries<T>(BTreeMap<String, Vec<T>>);

impl<T> Default for Tries<T> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<T: Try> Tries<T> {
    /// What one of the program's own files remembers, or a sentence on why that cannot be read.
    pub fn read(file: &str) -> Result<Self, String> {
        let text = match store::read(file) {
            Ok(text) => text,
            Err(error) if error.is_missing() => return Ok(Self::default()),
            Err(error) => return Err(error.to_string()),
        };
        serde_json::from_str(&text).map_err(|error| error.to_string())
    }

    /// Those of a name, but for what is tried now.
    pub fn earlier(&self, name: &str, now: &T) -> Vec<T> {
        self.0.get(name).into_iter().flatten().filter(|one| !one.is_like(now)).copied().collect()
    }

    /// Takes over what a try came to.
    pub fn learn(&mut self, name: String, now: T) {
        let tried = self.0.entry(name.clone()).or_default();
        match tried.iter_mut().find(|one| one.is_like(&now)) {
            Some(known) => *known = now,
            None => tried.push(now),
        }
        if tried.len() > MOST {
            let place = tried.iter().position(T::passed).unwrap_or(0);
            tried.remove(place);
        }
        if tried.iter().all(T::passed) {
            self.0.remove(&name);
        }
    }

    /// Writes them, if there is or was anything to remember.
    pub fn write(&self, file: &str) -> io::Result<()> {
        if self.0.is_empty() {
            return store::remove(file);
        }
        store::write(file, &(serde_json::to_string_pretty(self).expect("plain data serialises") + "\n"))
    }
}
