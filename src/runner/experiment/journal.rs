//! The journal of what is optimised, if there is a folder for it.

use std::path::Path;
use std::sync::LazyLock;

use serde::Serialize;

use super::journal_file::journal_file;
use crate::run::Build;
use optimise::{Definition, Error, Journal};

/// Which program evaluates: its own bytes decide, or its version where they cannot be read.
static PROGRAM: LazyLock<String> = LazyLock::new(|| match Build::here() {
    Ok(build) => build.identity(),
    Err(_) => env!("CARGO_PKG_VERSION").to_string(),
});

/// A journal from which a run that was cut off goes on, or one with a larger budget.
pub struct Record {
    journal: Option<Journal>,
}

impl Record {
    /// The journal for `name`. `inputs` is everything besides the definition that decides the evaluations; it and the
    /// program become part of the file's name, and the budget does not.
    pub fn open(
        folder: Option<&Path>,
        name: &str,
        inputs: &impl Serialize,
        definition: &Definition,
        batch: usize,
    ) -> Result<Self, Error> {
        let Some(folder) = folder else { return Ok(Self { journal: None }) };
        let decisive = (inputs, definition.without_budget(), &*PROGRAM);
        let (path, _) = journal_file(folder, name, &decisive)?;
        Ok(Self { journal: Some(Journal::open(&path, definition, batch)?) })
    }

    pub fn journal(&mut self) -> Option<&mut Journal> {
        self.journal.as_mut()
    }

    /// What to tell whoever runs it.
    pub fn notice(&self) -> Option<&str> {
        self.journal.as_ref()?.notice()
    }

    /// The run is over and its result is in the caller's hands; a larger budget may go on from it.
    pub fn keep(self) {}

    /// The run is over and its result is in the caller's hands.
    pub fn remove(self) {
        if let Some(journal) = self.journal {
            // Left behind, it costs only space: it is complete and resumes to the same result.
            let _ = journal.remove();
        }
    }
}
