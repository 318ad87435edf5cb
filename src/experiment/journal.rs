//! Where an experiment's journal lies: in a file of its own for every definition, so that no stale one is ever resumed.

use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::optimise::{Definition, Error, Journal};

/// A journal that is removed once its run has come to its end.
pub struct Record {
    journal: Option<Journal>,
    path: Option<PathBuf>,
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
        let Some(folder) = folder else { return Ok(Self { journal: None, path: None }) };
        let file_error = |source| Error::JournalFile { path: folder.display().to_string(), source };
        std::fs::create_dir_all(folder).map_err(file_error)?;
        let text = serde_json::to_vec(&(inputs, definition, env!("CARGO_PKG_VERSION")))
            .expect("plain data serialises");
        let hash: String = Sha256::digest(text).iter().take(8).map(|byte| format!("{byte:02x}")).collect();
        let path = folder.join(format!("{}-{hash}.jsonl", name.replace('/', "-")));
        let journal = Journal::open(&path, definition, batch)?;
        Ok(Self { journal: Some(journal), path: Some(path) })
    }

    pub fn journal(&mut self) -> Option<&mut Journal> {
        self.journal.as_mut()
    }

    /// The run is over and its result is in the caller's hands.
    pub fn remove(self) {
        drop(self.journal);
        if let Some(path) = self.path {
            // Left behind, it costs only space: it is complete and resumes to the same result.
            let _ = std::fs::remove_file(path);
        }
    }
}
