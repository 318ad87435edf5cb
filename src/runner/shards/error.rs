//! What is wrong with manifests and results, each with the name of its file.

use std::path::PathBuf;

use thiserror::Error;

use crate::run::Build;

/// Why nothing is made of a manifest or of results.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ShardError {
    /// It runs wherever what ships is there.
    #[error("the canary run cannot be made: {message}")]
    Canary {
        /// Why.
        message: String,
    },
    /// What a file should hold is not there, or something else is.
    #[error("{}: {message}", path.display())]
    File {
        /// The manifest, or a file of results.
        path: PathBuf,
        /// What is wrong with it, in words.
        message: String,
    },
    /// The disk is full, or nothing may be written there.
    #[error("{}: the results cannot be written: {message}", path.display())]
    NotWritten {
        /// A file of results.
        path: PathBuf,
        /// In the words of the system.
        message: String,
    },
    /// A file ends before its last line: whoever wrote it was not done, or it is still on its way.
    #[error("{}: it is cut off: its last line, with the digest of all others, is missing", path.display())]
    CutOff {
        /// The manifest, or a file of results.
        path: PathBuf,
    },
    /// A run is a pure function of its case for one build alone.
    #[error("{}: it is of {found}, and this is {here}", path.display())]
    OtherBuild {
        /// The manifest, or a file of results.
        path: PathBuf,
        /// Who wrote it.
        found: Box<Build>,
        /// Who reads it.
        here: Box<Build>,
    },
    /// The machine computes otherwise, or something is wrong with it.
    #[error(
        "{}: on its machine the canary run came to something else than where the manifest was made, so that its results are of other runs",
        path.display()
    )]
    OtherCanary {
        /// A file of results.
        path: PathBuf,
    },
    /// Results are missing.
    #[error("{message}")]
    Missing {
        /// Which and how many.
        message: String,
    },
    /// What the manifest was made of has changed.
    #[error("{message}")]
    OtherFiles {
        /// What is otherwise.
        message: String,
    },
    /// Somebody wished to stop.
    #[error("interrupted")]
    Stopped,
}
