//! What a file is by its name.

use std::path::Path;

/// What a file is by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    Scenarios,
    Suite,
    /// Either of them, as its content says.
    Yaml,
}

/// What names of files end in, without the dot.
pub const ENDINGS: [&str; 4] = ["scn", "suite", "yaml", "yml"];

/// What the name of a file says about it.
pub fn file_kind(path: &Path) -> Option<FileKind> {
    match path.extension()?.to_str()? {
        "scn" => Some(FileKind::Scenarios),
        "suite" => Some(FileKind::Suite),
        "yaml" | "yml" => Some(FileKind::Yaml),
        _ => None,
    }
}
