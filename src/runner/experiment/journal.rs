//! The journal of what is optimised, if there is a folder for it.

use std::path::Path;

use serde::Serialize;

use super::journal_file::journal_file;
use optimise::{Definition, Error, Journal};

/// A journal that is removed once its run has come to its end.
pub struct Record {
    journal: Option<Journal>,
}

impl Record {
    /// The journal for `name`. `inputs` is everything besides the definition that decides the evaluations; it and the
    /// version of the program become part of the file's name.
    pub fn open(
        folder: Option<&Path>,
        name: &str,
        inputs: &impl Serialize,
        definition: &Definition,
        batch: usize,
    ) -> Result<Self, Error> {
        let Some(folder) = folder else { return Ok(Self { journal: None }) };
        let decisive = (inputs, definition, env!("CARGO_PKG_VERSION"));
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

    /// The run is over and its result is in the caller's hands.
    pub fn remove(self) {
        if let Some(journal) = self.journal {
            // Left behind, it costs only space: it is complete and resumes to the same result.
            let _ = journal.remove();
        }
    }
}
