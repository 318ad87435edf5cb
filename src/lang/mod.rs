//! The scenario language: from `.scn` and `.suite` files to a checked suite, or to everything that is wrong with them.
//!
//! A text becomes a lossless [`Tree`]; `check` turns trees into plain [`crate::scenario`] data; what is wrong is a
//! list of [`Diagnostic`]s, which [`render`] shows.

mod check;
mod codes;
mod diagnostic;
mod files;
mod format;
mod lexer;
mod print;
mod render;
mod settings;
mod source;
pub mod statements;
mod suite;
mod syntax_error;
#[cfg(test)]
mod tests;
mod tree;
mod units;
mod value;

use std::path::Path;

pub use check::{DEFAULT_GOAL, Defaults};
pub use codes::Code;
pub use diagnostic::{Diagnostic, Label, Severity};
pub use files::LARGEST_FILE;
pub use format::format;
pub use lexer::{DEEPEST_NESTING, Token, TokenKind};
pub use render::{Style, count, render, render_all};
pub use source::{Location, Source, SourceId, Sources, Span};
pub use suite::DEFAULT_SEED;
pub use tree::{Node, NodeIndex, Rule, Tree};
pub use units::{UNITS, Unit};

use crate::scenario::Suite;
use files::Files;

/// A suite without errors.
#[derive(Debug, Clone)]
pub struct Loaded {
    pub suite: Suite,
    pub warnings: Vec<Diagnostic>,
    /// Every text that it was read from, for showing places.
    pub sources: Sources,
}

/// Everything that is wrong, errors and warnings, by file and place.
#[derive(Debug, Clone)]
pub struct Failure {
    pub diagnostics: Vec<Diagnostic>,
    pub sources: Sources,
}

/// Reads and checks a `.suite` file, or a `.scn` file as a suite named after it with seed [`DEFAULT_SEED`].
pub fn load(path: &Path) -> Result<Loaded, Failure> {
    load_with(path, Files::default())
}

/// As [`load`], for a text that stands for the file at `path`; files it uses are read from disk.
pub fn check(path: &Path, text: &str) -> Result<Loaded, Failure> {
    let mut files = Files::default();
    files.overlay(path, text);
    load_with(path, files)
}

fn load_with(path: &Path, mut files: Files) -> Result<Loaded, Failure> {
    let mut report = Vec::new();
    let Some(kind) = suite::file_kind(path) else {
        let source = files.sources.add(path.display().to_string(), "");
        report.push(
            Diagnostic::new(
                Code::UnknownFileKind,
                Span::beginning(source),
                format!("`{}` is neither a scenario file nor a suite", path.display()),
            )
            .label("unknown kind of file")
            .hint("scenario files end in `.scn`, suites in `.suite`"),
        );
        return Err(Failure { diagnostics: report, sources: files.sources });
    };
    let file = files.open(path, None, &mut report);
    let suite = file.and_then(|file| suite::suite(&mut files, file, path, kind, &mut report));
    if let Some(file) = file {
        let root = files.tree(file).source;
        files.trace(root, &mut report);
    }
    report.sort_by_key(|diagnostic| (diagnostic.span().source, diagnostic.span().start));
    let sources = files.sources;
    match suite {
        Some(suite) if !files::has_errors(&report) => Ok(Loaded { suite, warnings: report, sources }),
        _ => Err(Failure { diagnostics: report, sources }),
    }
}

impl Failure {
    /// All diagnostics as text.
    pub fn render(&self, style: Style) -> String {
        render_all(&self.diagnostics, &self.sources, style)
    }
}
