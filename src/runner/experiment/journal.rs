//! The journal of what is optimised, if there is a folder for it.

use serde::Serialize;

use super::context::Context;
use super::journal_file::journal_file;
use optimise::{Definition, Error, Journal};

/// A journal from which a run that was cut off goes on, or one with a larger budget.
pub struct Record {
    journal: Option<Journal>,
}

impl Record {
    /// The journal for `name`. `inputs` is everything besides the definition that decides the evaluations; it and the
    /// program become part of the file's name, and the budget does not.
    pub fn open(
        context: &Context,
        name: &str,
        inputs: &impl Serialize,
        definition: &Definition,
        batch: usize,
    ) -> Result<Self, Error> {
        let Some(folder) = &context.journals else { return Ok(Self { journal: None }) };
        let program = match context.program() {
            Ok(program) => program,
            Err(error) => {
                context
                    .tell(Some(&format!("no journal is kept, since this program cannot be read: {error}")));
                return Ok(Self { journal: None });
            }
        };
        let decisive = (inputs, definition.without_budget(), program);
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
