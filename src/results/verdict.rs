//! The three verdicts.

use serde::{Deserialize, Serialize};

/// What a criterion, a trial or a suite comes to. The order is from good to bad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It is fulfilled.
    Passed,
    /// The runs do not suffice to say, at the confidence that was asked for.
    Inconclusive,
    /// It is not fulfilled.
    Failed,
}
