//! A step of a script, as reports name it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// A step of a scripted timeline.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScriptStep {
    /// Its place in the script, from 1.
    pub number: usize,
    /// As it is written, such as `when distance < d1 stop`.
    pub text: Arc<str>,
}
