//! How a unit stands, whatever its kind.

use serde::{Deserialize, Serialize};

use super::cut::CutBy;
use crate::Verdict;

/// How a unit stands, whatever its kind. The order is from good to bad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// Nobody tried to run it.
    Skipped,
    /// It was run, but no criterion applied to it: it is no evidence of anything.
    NotJudged,
    /// A search that found something, and expects nothing of it.
    Found,
    /// Its criteria came to this.
    Judged(Verdict),
    /// It was begun, and cut off.
    NotFinished(CutBy),
    /// It could not be run to its end.
    Errored,
}

impl Standing {
    /// Whether it counts for `--max-fail`: an open question is no failure, nor is what somebody interrupted.
    pub fn is_failure(self) -> bool {
        matches!(self, Self::Judged(Verdict::Failed) | Self::NotFinished(CutBy::TimeLimit) | Self::Errored)
    }

    /// Of something that was run and has this verdict, if any.
    pub fn of(skipped: bool, verdict: Option<Verdict>) -> Self {
        match verdict {
            _ if skipped => Self::Skipped,
            Some(verdict) => Self::Judged(verdict),
            None => Self::Errored,
        }
    }
}
