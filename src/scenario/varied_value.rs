//! Values that are listed, with their words.

use serde::{Deserialize, Serialize};

use super::Value;

/// A value with the words it was written in, which name the trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VariedValue {
    /// SI units.
    pub value: Value,
    /// Without spaces, such as `6s` or `30km/h`.
    pub label: String,
}
