//! Where an experiment's journal lies: in a file of its own for every definition, so that no stale one is ever resumed.

use std::io;
use std::path::Path;

use serde::Serialize;
use sha2::{Digest, Sha256};

use files::{LogError, hexadecimal};
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
        let text = serde_json::to_vec(&(inputs, definition, env!("CARGO_PKG_VERSION")))
            .expect("plain data serialises");
        let hash = hexadecimal(&Sha256::digest(text)[..8]);
        let path = folder.join(format!("{}-{hash}.jsonl", name.replace('/', "-")));
        // Its name can be foretold, so somebody's project could have it lead anywhere.
        if path.is_symlink() {
            let error = io::Error::other("it is a link, which a journal never is; remove it");
            return Err(LogError::Io { path, error }.into());
        }
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
