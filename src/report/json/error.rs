//! Why a file is not taken for results.

use std::time::Duration;

use thiserror::Error;

use files::ReadError;
use results::UnknownMetric;

/// Version of the layout; raised when a reader would have to change.
///
/// 2: whole numbers beyond 2^53 are text, infinite observations and margins are `"inf"` and `"-inf"`; `record` has what
/// reports need besides.
pub(super) const LAYOUT: u32 = 2;

/// Why a file is not taken for results.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ResultsError {
    /// The file cannot be read, or is too large.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Cut off, of another program, or changed by hand.
    #[error("it is not what `--json` writes: {0}")]
    Format(#[from] serde_json::Error),
    /// A later version of scenario-runner wrote it.
    #[error("its layout is {0}, and this version reads 1 to {LAYOUT}; use the version that wrote it")]
    Layout(u64),
    /// Of a program that somebody has extended.
    #[error("{0}: it was written by another program")]
    Metric(#[from] UnknownMetric),
    /// What it says of itself is not what its parts say.
    #[error("{key}: {what}")]
    Contradiction {
        /// Of the trial, block or gate.
        key: String,
        /// What does not fit, in words.
        what: String,
    },
    /// Something that version 0.1 did not write down.
    #[error("{key}: {what}; it was written by 0.1, so run the suite again with this version")]
    Lacking {
        /// Of the trial, block or gate.
        key: String,
        /// What is missing, in words.
        what: String,
    },
}

pub(super) fn contradiction(key: &str, what: impl Into<String>) -> ResultsError {
    ResultsError::Contradiction { key: key.to_string(), what: what.into() }
}

pub(super) fn seconds(key: &str, seconds: f64) -> Result<Duration, ResultsError> {
    let wrong = |error: std::time::TryFromFloatSecsError| contradiction(key, error.to_string());
    Duration::try_from_secs_f64(seconds).map_err(wrong)
}
