//! Why a suite cannot be planned.

use thiserror::Error;

use scenario::Origin;

/// Why a suite cannot be planned; found only once variations have their values.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{message}{}", case.as_ref().map(|case| format!(", in {case}")).unwrap_or_default())]
pub struct PlanError {
    /// What is wrong, in a sentence without a full stop.
    pub message: String,
    /// What to do about it, if that is known.
    pub hint: Option<String>,
    /// The run or trial whose values are at fault, where it is one's alone.
    pub case: Option<String>,
    /// Where what is wrong is declared.
    pub origin: Box<Origin>,
}

impl PlanError {
    /// An error at a place, of no run in particular.
    pub fn new(origin: &Origin, message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None, case: None, origin: Box::new(origin.clone()) }
    }

    /// What was found wrong is so in this run or trial.
    pub fn in_case(self, key: &str) -> Self {
        Self { case: self.case.or_else(|| Some(key.to_string())), ..self }
    }

    /// With what to do about it.
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}
