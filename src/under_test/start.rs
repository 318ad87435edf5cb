//! Why a program that may be started is not ready to be asked.

use scenario::{DeclaredProgram, Origin};
use thiserror::Error;

/// Why a program is not ready to be asked.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{message}")]
pub struct StartError {
    /// Which kind of problem it is.
    pub problem: StartProblem,
    /// What is wrong, in a sentence.
    pub message: String,
    /// What to do about it.
    pub hint: String,
    /// The end of its log and what else there is to know.
    pub notes: Vec<String>,
    /// The declaration, or the parameter in it, that is meant.
    pub origin: Box<Origin>,
}

/// What is wrong with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StartProblem {
    /// Its user has not allowed it.
    NotAllowed,
    /// It cannot be started at all.
    CannotStart,
    /// It does not say hello as it must.
    NoHello,
    /// It says something else than the file.
    Disagreement,
    /// A functional mock-up unit has not the variables that the file wires.
    NotWired,
}

impl StartError {
    /// About a program as a whole.
    pub fn new(
        problem: StartProblem,
        program: &DeclaredProgram,
        message: impl Into<String>,
        hint: impl Into<String>,
    ) -> Self {
        let origin = Box::new(program.origin.clone());
        Self { problem, message: message.into(), hint: hint.into(), notes: Vec::new(), origin }
    }

    /// About one of its parameters.
    pub fn of_parameter(self, program: &DeclaredProgram, name: &str) -> Self {
        let found = program.parameters.iter().find(|(known, _)| known == name);
        Self { origin: found.map_or(self.origin, |(_, origin)| Box::new(origin.clone())), ..self }
    }

    /// The same, with what else there is to know.
    pub fn with_notes(self, notes: Vec<String>) -> Self {
        Self { notes, ..self }
    }
}
