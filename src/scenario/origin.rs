//! Where in a file something was said.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// Where in a file something was said; enough to show it again without reading the file.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Origin {
    /// Its path as reports show it; empty for what was not read from a file.
    pub file: Arc<str>,
    /// Counted from 1.
    pub line: usize,
    /// Counted from 1, in characters.
    pub column: usize,
    /// The whole source line, without its line end.
    pub source_line: Arc<str>,
    /// Length of the marked part in characters.
    pub length: usize,
}
