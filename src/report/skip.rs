//! Why a trial or block was not run.

use thiserror::Error;

use super::event::Stopping;

/// The reason in every report.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Skip {
    #[error("not selected")]
    NotSelected,
    /// It had not begun when that happened.
    #[error("{0}")]
    Stopped(Stopping),
    /// Interrupted while it was under way; in words, with what is left of it.
    #[error("{0}")]
    CutOff(String),
    /// It builds on another unit that came to nothing.
    #[error("needs {key}, which {happened}")]
    Needs { key: String, happened: &'static str },
}
