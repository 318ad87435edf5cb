//! Why an engine did not have its tasks done.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Nothing is said of the tasks by it but that they are not all done.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum EngineError {
    /// What is to be installed, or which version is another.
    #[error("{0}")]
    Missing(String),
    /// The tasks, or the options, are none that the engine could be given.
    #[error("{0}")]
    Refused(String),
    /// It did something that it must not, or is not to be reached.
    #[error("the engine failed: {0}")]
    Failed(String),
    /// A file of its own cannot be written or read.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Somebody wished that it stops, and nothing of it goes on.
    #[error("stopped: no task goes on")]
    Stopped,
}

impl EngineError {
    pub(super) fn file(path: &Path, source: io::Error) -> Self {
        Self::File { path: path.to_path_buf(), source }
    }
}
