//! Where a name is given and used, and which names there are.

use std::path::{Path, PathBuf};

use super::classes::SymbolKind;
use super::resolve::Symbols;
use crate::codes::Code;
use crate::source::{Sources, Span};
use crate::texts::{FileId, Texts};
use files::Files;
use scenario::registry::Registry;

/// A place where the name that was asked for stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NamedPlace {
    /// Of the name.
    pub span: Span,
    /// Whether it is given here.
    pub defines: bool,
}

/// A name that a file gives to something that others find by it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorkspaceSymbol {
    /// As it is written.
    pub name: String,
    /// What it is of.
    pub kind: SymbolKind,
    /// Of the name.
    pub span: Span,
}

/// Every place where the name at byte `offset` of the file at `path` stands, in that file, in what it uses, and in `others`
/// and what these use; by file and place. Empty where no name stands that a file gives.
///
/// # Errors
/// If these files are too large together to be gone through, so that places would be missing.
pub fn references(
    path: &Path,
    offset: usize,
    others: &[PathBuf],
    registry: &Registry,
    texts: &dyn Files,
) -> Result<(Vec<NamedPlace>, Sources), String> {
    let mut files = Texts::new(registry, texts).while_edited();
    let Some(file) = open_all(&mut files, path, others)? else { return Ok((Vec::new(), files.sources)) };
    let symbols = Symbols::of(&mut files);
    let source = files.tree(file).source;
    let Some(at) = symbols.at(Span::new(source, offset, offset)) else {
        return Ok((Vec::new(), files.sources));
    };
    let same = symbols.occurrences.iter().filter(|one| one.symbol == at.symbol);
    let places = same.map(|one| NamedPlace { span: files.sources.resolve(one.span), defines: one.defines });
    Ok((places.collect(), files.sources))
}

/// Reads a file and others; what cannot be read is left out.
///
/// # Errors
/// If not all of them are read, because they are too large.
pub fn open_all(files: &mut Texts, path: &Path, others: &[PathBuf]) -> Result<Option<FileId>, String> {
    let mut report = Vec::new();
    let file = files.open(path, None, &mut report);
    for other in others {
        files.open(other, None, &mut report);
    }
    match report.iter().find(|one| one.code == Code::FileTooLarge) {
        Some(large) => Err(format!("not every file that may name it was read: {}", large.message)),
        None => Ok(file),
    }
}

/// The scenarios, roads, controllers, blocks, suites, gates and ratings of some files, by file and place.
pub fn workspace_symbols(
    paths: &[PathBuf],
    registry: &Registry,
    texts: &dyn Files,
) -> (Vec<WorkspaceSymbol>, Sources) {
    let mut files = Texts::new(registry, texts).while_edited();
    for path in paths {
        files.open(path, None, &mut Vec::new());
    }
    let symbols = Symbols::of(&mut files);
    let found = symbols.occurrences.iter().filter(|one| one.defines && is_of_a_file(one.kind));
    let named = found.map(|one| WorkspaceSymbol {
        name: files.sources.text(one.span).to_string(),
        kind: one.kind,
        span: files.sources.resolve(one.span),
    });
    (named.collect(), files.sources)
}

fn is_of_a_file(kind: SymbolKind) -> bool {
    use SymbolKind::{Block, Controller, Gate, Rating, Road, Scenario, Suite};
    matches!(kind, Scenario | Road | Controller | Block | Suite | Gate | Rating)
}
