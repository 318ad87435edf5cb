//! Names, as the protocol has them: references, renames, and all there are.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use lsp_types::{Location, Range, TextEdit};
use serde_json::{Value, json};

use super::document::{Positions, range_of, uri_of};
use super::workspace::Workspace;
use files::Files;
use lang::{Sources, Span, SymbolKind};
use scenario::registry::Registry;

/// More are not listed.
const MOST_SYMBOLS: usize = 1000;

/// A place in a file, and where its name may stand besides.
pub struct AskedName<'a> {
    pub path: &'a Path,
    pub offset: usize,
    pub others: &'a [PathBuf],
    pub registry: &'a Registry,
    pub files: &'a dyn Files,
}

/// What is not done, for a reason that its user is told.
#[derive(Debug)]
pub struct Refused(pub String);

impl fmt::Display for Refused {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

fn location(sources: &Sources, span: Span) -> Option<Location> {
    let source = sources.get(span.source);
    Some(Location { uri: uri_of(&source.name)?, range: range_of(&source.text, span) })
}

pub fn references(asked: &AskedName, with_definitions: bool) -> Result<Vec<Location>, Refused> {
    let AskedName { path, offset, others, registry, files } = asked;
    let (found, sources) = lang::references(path, *offset, others, registry, *files).map_err(Refused)?;
    let wanted = found.iter().filter(|one| with_definitions || !one.defines);
    Ok(wanted.filter_map(|one| location(&sources, one.span)).collect())
}

/// The name that would be changed, or why it cannot be.
pub fn rename_place(asked: &AskedName, text: &str) -> Result<Value, Refused> {
    let AskedName { path, offset, registry, files, .. } = asked;
    let (range, name) = lang::rename_place(path, *offset, registry, *files).map_err(Refused)?;
    Ok(json!({ "range": range_in(text, &range), "placeholder": name }))
}

pub fn range_in(text: &str, range: &std::ops::Range<usize>) -> Range {
    let mut positions = Positions::new(text);
    Range { start: positions.at(range.start), end: positions.at(range.end) }
}

/// The edits by file. Files outside of what the editor has open are not changed.
pub fn rename(asked: &AskedName, new: &str, workspace: &Workspace) -> Result<Value, Refused> {
    let AskedName { path, offset, others, registry, files } = asked;
    let rename = lang::rename(path, *offset, new, others, registry, *files).map_err(Refused)?;
    let mut changes: BTreeMap<String, Vec<TextEdit>> = BTreeMap::new();
    for edit in &rename.edits {
        let is_open = others.iter().any(|one| files.identity(one) == files.identity(Path::new(&edit.file)));
        if Path::new(&edit.file) != *path && !is_open && workspace.place(Path::new(&edit.file)).is_none() {
            let why = format!("{} names it and lies outside of the folders that are open", edit.file);
            return Err(Refused(why));
        }
        let source = rename.sources.iter().find(|(_, source)| source.name == edit.file);
        let (Some((_, source)), Some(uri)) = (source, uri_of(&edit.file)) else {
            return Err(Refused(format!("{} cannot be changed", edit.file)));
        };
        let range = range_in(&source.text, &edit.range);
        changes
            .entry(uri.as_str().to_string())
            .or_default()
            .push(TextEdit { range, new_text: edit.text.clone() });
    }
    Ok(json!({ "changes": changes }))
}

/// Everything that files give a name to others, where the name contains what is asked for, in letters of any case.
pub fn symbols(query: &str, paths: &[PathBuf], registry: &Registry, files: &dyn Files) -> Vec<Value> {
    let (found, sources) = lang::workspace_symbols(paths, registry, files);
    let query = query.to_lowercase();
    let wanted = found.iter().filter(|one| one.name.to_lowercase().contains(&query));
    let shown = wanted.filter_map(|one| {
        let location = location(&sources, one.span)?;
        Some(json!({ "name": one.name, "kind": kind_number(one.kind), "location": location }))
    });
    shown.take(MOST_SYMBOLS).collect()
}

/// `SymbolKind` of the protocol: what is nearest there.
fn kind_number(kind: SymbolKind) -> u32 {
    match kind {
        SymbolKind::Suite => 3,
        SymbolKind::Controller => 5,
        SymbolKind::Road => 23,
        SymbolKind::Scenario => 12,
        _ => 19,
    }
}
