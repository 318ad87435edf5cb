//! In place of modules, where the program is built without them.

use std::convert::Infallible;

use super::start::{StartError, StartProblem};
use scenario::DeclaredProgram;
use scenario::ProgramFault;

/// There is none.
pub struct NoGuest(Infallible);

impl NoGuest {
    /// # Errors
    /// Always.
    pub fn start(program: &DeclaredProgram, file: &str) -> Result<Self, StartError> {
        let message = format!("`{file}`: this scenario-runner is built without WebAssembly");
        Err(StartError::new(StartProblem::CannotStart, program, message, "build it with the feature `wasm`"))
    }

    pub fn exchange(&mut self, _: &[u8], _: usize, _: &mut Vec<u8>) -> Result<(), ProgramFault> {
        match self.0 {}
    }

    pub fn tell(&mut self, _: &[u8], _: usize) -> Result<(), ProgramFault> {
        match self.0 {}
    }
}
