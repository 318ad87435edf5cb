//! Why a trial or block was not run, and why no more begin.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::standing::Standing;

/// The reason in every report.
#[derive(Debug, Clone, PartialEq, Eq, Error, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Skip {
    /// A filter, a share of several machines or a key left it out.
    #[error("not selected")]
    NotSelected,
    /// It had not begun when that happened.
    #[error("{0}")]
    Stopped(Stopping),
    /// A recorded run that the files have nothing for any more; in words.
    #[error("{0}")]
    Stale(String),
    /// It builds on another unit that came to nothing.
    #[error("needs {key}, which {happened}")]
    Needs {
        /// The key of that unit.
        key: String,
        /// What became of it, in words such as `failed`.
        happened: String,
    },
}

impl Skip {
    /// Of a unit that needs the one called `key`, which stands so.
    pub fn needs(key: &str, standing: Standing) -> Self {
        let happened = match standing {
            Standing::Judged(_) => "failed",
            Standing::Errored => "could not be run",
            Standing::NotFinished(_) => "was not finished",
            Standing::NotJudged | Standing::Found => "was not judged",
            Standing::Skipped => "was not run",
        };
        Self::Needs { key: key.to_string(), happened: happened.to_string() }
    }
}

/// Why no more units begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stopping {
    /// So many failed that the rest does not matter.
    #[error("stopped after {_0} {} (--max-fail {_0})", if *_0 == 1 { "failure" } else { "failures" })]
    MaxFail(usize),
    /// A sequential gate of its suite has failed, whatever would come of it.
    #[error("a gate failed before all runs were made")]
    GateFailed,
    /// Somebody pressed Ctrl-C.
    #[error("interrupted")]
    Interrupted,
}
