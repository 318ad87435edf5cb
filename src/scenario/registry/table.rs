//! Entries of one kind, by the names that they declare, in the order in which they were added.

use std::slice;
use std::sync::Arc;

use super::EntryKind;
use super::check::{self, RegistryError};
use crate::{Declaration, Registered};

/// Entries of one kind. Cheap to clone.
pub struct Table<T> {
    entries: Vec<Arc<T>>,
}

impl<T: Registered> Table<T> {
    /// Adds an entry under the name that it declares; `kind` is what errors call it.
    pub(super) fn add(&mut self, kind: EntryKind, entry: T) -> Result<(), RegistryError> {
        check::declaration(entry.declaration())?;
        let name = &*entry.declaration().name;
        if self.get(name).is_some() {
            return Err(RegistryError::Duplicate { kind, name: name.to_string() });
        }
        self.entries.push(Arc::new(entry));
        Ok(())
    }

    /// The entry of that name.
    pub fn get(&self, name: &str) -> Option<&Arc<T>> {
        self.entries.iter().find(|entry| entry.declaration().name == name)
    }

    /// The entries, in the order in which they were added.
    pub fn iter(&self) -> slice::Iter<'_, Arc<T>> {
        self.entries.iter()
    }

    /// What the entries declare, in the order in which they were added.
    pub fn declarations(&self) -> impl Iterator<Item = &Declaration> + Clone {
        self.entries.iter().map(|entry| entry.declaration())
    }

    /// What scenarios may call them, in the order in which they were added.
    pub fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.declarations().map(|declaration| &*declaration.name)
    }

    /// The name that is most like one that is not there.
    pub fn nearest(&self, name: &str) -> Option<String> {
        let likeness = |known: &&str| strsim::jaro_winkler(known, name);
        let nearest = self.names().max_by(|one, other| likeness(one).total_cmp(&likeness(other)))?;
        (likeness(&nearest) > 0.7).then(|| nearest.to_string())
    }
}

impl<T> Default for Table<T> {
    fn default() -> Self {
        Self { entries: Vec::new() }
    }
}

impl<T> Clone for Table<T> {
    fn clone(&self) -> Self {
        Self { entries: self.entries.clone() }
    }
}

impl<'a, T: Registered> IntoIterator for &'a Table<T> {
    type Item = &'a Arc<T>;
    type IntoIter = slice::Iter<'a, Arc<T>>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}
