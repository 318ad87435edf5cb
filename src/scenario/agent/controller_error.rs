//! Why a controller cannot decide in a run that has begun.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::ProgramFault;

/// Why a controller cannot decide. Unlike a [`ModelError`](super::ModelError), which refuses a case before anything moves
/// and states numbers of the scenario, it happens to one run at one moment and is in the controller's own words.
#[derive(Debug, Clone, PartialEq, Eq, Error, Serialize, Deserialize)]
#[error("{message}")]
#[non_exhaustive]
pub struct ControllerError {
    /// What keeps it from deciding, in a sentence without a full stop.
    pub message: String,
    /// What to do about it, if it knows.
    pub hint: Option<String>,
    /// Where a program decides: what it did that it must not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<Box<ProgramFault>>,
}

impl ControllerError {
    /// An error with nothing to advise.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None, fault: None }
    }

    /// An error with what to do about it.
    pub fn with_hint(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { message: message.into(), hint: Some(hint.into()), fault: None }
    }
}

impl ProgramFault {
    /// As what keeps a controller from deciding.
    pub fn into_error(self) -> ControllerError {
        ControllerError { fault: Some(Box::new(self.clone())), ..ControllerError::new(self.to_string()) }
    }
}
