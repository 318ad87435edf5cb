//! Another name for something, in all files that name it.
//!
//! What is given back was tried: the files with the new name name the same things at the same places, and nothing is wrong with
//! them that was not wrong before.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::classes::SymbolKind;
use super::references::open_all;
use super::resolve::{Occurrence, Symbols};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::{Sources, Span};
use crate::syntax::{TokenKind, Tree};
use crate::texts::Texts;
use files::{Files, Overlay};
use scenario::registry::Registry;

/// What is written in the place of something in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileEdit {
    /// The file, as it was named.
    pub file: String,
    /// Bytes of its text.
    pub range: Range<usize>,
    /// In their place.
    pub text: String,
}

/// The edits of a rename.
#[derive(Debug, Clone)]
pub struct Rename {
    /// By file and place.
    pub edits: Vec<FileEdit>,
    /// The texts that they are of.
    pub sources: Sources,
}

/// The name at byte `offset` of the file at `path`, if that is one that can be changed.
///
/// # Errors
/// Why it cannot be changed.
pub fn rename_place(
    path: &Path,
    offset: usize,
    registry: &Registry,
    texts: &dyn Files,
) -> Result<(Range<usize>, String), String> {
    let mut files = Texts::new(registry, texts).while_edited();
    let file = open_all(&mut files, path, &[])?.ok_or("the file cannot be read")?;
    let source = files.tree(file).source;
    let symbols = Symbols::of(&mut files);
    let at = renamable(&symbols, Span::new(source, offset, offset))?;
    Ok((at.span.start..at.span.end, files.sources.text(at.span).to_string()))
}

/// The edits that call what is named at byte `offset` of the file at `path` by a `new` name, in that file, in what it uses, and in
/// `others` and what these use.
///
/// # Errors
/// Why that is not possible: nothing there has a name that could be changed, the new one is no name or taken, or something cannot
/// be read that may name it.
pub fn rename(
    path: &Path,
    offset: usize,
    new: &str,
    others: &[PathBuf],
    registry: &Registry,
    texts: &dyn Files,
) -> Result<Rename, String> {
    let (files, before, at) = read(path, offset, others, registry, texts)?;
    let old = files.sources.text(at.span).to_string();
    if !is_free_word(new) {
        return Err(format!(
            "`{new}` is no name: letters, digits and `_`, no digit first, and no word of the language such as `in`"
        ));
    }
    if new == old {
        return Ok(Rename { edits: Vec::new(), sources: files.sources });
    }
    reject_unreadable(&files, &old)?;
    let mut edits = Vec::new();
    for one in before.occurrences.iter().filter(|one| one.symbol == at.symbol) {
        let span = files.sources.resolve(one.span);
        let source = files.sources.get(span.source);
        if source.text.get(span.start..span.end) != Some(old.as_str()) {
            let line = files.sources.location(one.span).line;
            return Err(format!("{}:{line} names it in a way that cannot be changed here", source.name));
        }
        edits.push(FileEdit {
            file: source.name.clone(),
            range: span.start..span.end,
            text: new.to_string(),
        });
    }
    let changed = texts_with(&edits, &files.sources);
    let mut with = Overlay::of(texts);
    for (file, text) in &changed {
        with = with.with(Path::new(file), text);
    }
    let again = read(path, moved(offset, path, &edits), others, registry, &with);
    let is_same =
        again.is_ok_and(|(now, after, _)| are_the_same((&files, &before), at.symbol, (&now, &after), new));
    if !is_same {
        return Err(taken(new, &files, &before, registry));
    }
    for root in files.ids().map(|file| files.sources.get(files.tree(file).source).name.clone()) {
        if let Some(found) = new_finding(Path::new(&root), &changed, registry, texts, &with) {
            return Err(match found.code {
                Code::DuplicateName | Code::DuplicateScenario => taken(new, &files, &before, registry),
                _ => format!("with this name {root} would be wrong: {}", found.message),
            });
        }
    }
    Ok(Rename { edits, sources: files.sources })
}

type Read<'f> = (Texts<'f>, Symbols, Occurrence);

fn read<'f>(
    path: &Path,
    offset: usize,
    others: &[PathBuf],
    registry: &Registry,
    texts: &'f dyn Files,
) -> Result<Read<'f>, String> {
    let mut files = Texts::new(registry, texts).while_edited();
    let file = open_all(&mut files, path, others)?.ok_or("the file cannot be read")?;
    let source = files.tree(file).source;
    let symbols = Symbols::of(&mut files);
    let at = renamable(&symbols, Span::new(source, offset, offset))?;
    Ok((files, symbols, at))
}

fn renamable(symbols: &Symbols, at: Span) -> Result<Occurrence, String> {
    let found = symbols.at(at).ok_or("only names that files give can be changed, and here stands none")?;
    if found.kind == SymbolKind::ProgramParameter {
        return Err("a program knows its parameters by these names".to_string());
    }
    Ok(found)
}

/// Whether a text is a name that anything can have.
fn is_free_word(text: &str) -> bool {
    let (tree, wrong) = Tree::parse(Sources::default().add("", ""), format!("let {text} = 1\n").into());
    let mut bindings = tree.file().bindings();
    wrong.is_empty() && bindings.next().is_some_and(|one| one.name().text() == text)
}

/// Refuses where a text that cannot be read has the word: it may be the name.
fn reject_unreadable(files: &Texts, name: &str) -> Result<(), String> {
    for file in files.ids() {
        let tree = files.tree(file);
        let words = || tree.tokens().iter().filter(|token| token.kind == TokenKind::Word);
        let is_unread = tree.nodes().any(|node| node.is_bad()) || tree.root().children().next().is_none();
        if is_unread && words().any(|token| tree.text()[token.start..token.end] == *name) {
            let source = &files.sources.get(tree.source).name;
            return Err(format!("`{source}` has the word `{name}` and cannot be read: mend that first"));
        }
    }
    Ok(())
}

/// The texts of edited files with their edits.
fn texts_with(edits: &[FileEdit], sources: &Sources) -> BTreeMap<String, String> {
    let mut by_file: BTreeMap<&str, Vec<&FileEdit>> = BTreeMap::new();
    edits.iter().for_each(|edit| by_file.entry(&edit.file).or_default().push(edit));
    let mut texts = BTreeMap::new();
    for (file, mut edits) in by_file {
        let Some((_, source)) = sources.iter().find(|(_, source)| source.name == file) else { continue };
        let mut text = source.text.to_string();
        edits.sort_by_key(|edit| edit.range.start);
        edits.iter().rev().for_each(|edit| text.replace_range(edit.range.clone(), &edit.text));
        texts.insert(file.to_string(), text);
    }
    texts
}

/// Where the name that stood at `offset` of a file begins after the edits.
fn moved(offset: usize, path: &Path, edits: &[FileEdit]) -> usize {
    let own = path.display().to_string();
    let own: Vec<&FileEdit> = edits.iter().filter(|edit| edit.file == own).collect();
    let start = own.iter().find(|edit| edit.range.start <= offset && offset <= edit.range.end);
    let start = start.map_or(offset, |edit| edit.range.start);
    let before = own.iter().filter(|edit| edit.range.end <= start);
    let shift: isize = before.map(|edit| edit.text.len() as isize - edit.range.len() as isize).sum();
    start.saturating_add_signed(shift)
}

/// Whether all names are of the same things as before, file by file and place by place.
fn are_the_same(
    (files, before): (&Texts, &Symbols),
    renamed: usize,
    (now, after): (&Texts, &Symbols),
    new: &str,
) -> bool {
    let place = |files: &Texts, one: &Occurrence| {
        (files.sources.get(one.span.source).name.clone(), one.kind, one.defines)
    };
    if before.occurrences.len() != after.occurrences.len() {
        return false;
    }
    let (mut there, mut back) = (HashMap::new(), HashMap::new());
    before.occurrences.iter().zip(&after.occurrences).all(|(one, other)| {
        let text = if one.symbol == renamed { new } else { files.sources.text(one.span) };
        place(files, one) == place(now, other)
            && now.sources.text(other.span) == text
            && *there.entry(one.symbol).or_insert(other.symbol) == other.symbol
            && *back.entry(other.symbol).or_insert(one.symbol) == one.symbol
    })
}

/// What the new name is already, in words.
fn taken(new: &str, files: &Texts, symbols: &Symbols, registry: &Registry) -> String {
    let known = symbols.occurrences.iter().find(|one| one.defines && files.sources.text(one.span) == new);
    if let Some(known) = known {
        let place = files.sources.location(known.span);
        let file = &files.sources.get(known.span.source).name;
        return format!("`{new}` is {} already, in {file}:{}", known.kind.name(), place.line);
    }
    let ships = registry.controllers().get(new).is_some();
    let what = if ships { "a controller that ships" } else { "a word that means something else here" };
    format!("`{new}` is {what}")
}

/// An error or warning that a file has only with the edits.
fn new_finding(
    path: &Path,
    changed: &BTreeMap<String, String>,
    registry: &Registry,
    texts: &dyn Files,
    with: &dyn Files,
) -> Option<Diagnostic> {
    let after = crate::examine(path, registry, with);
    if !after.sources.iter().any(|(_, source)| changed.contains_key(&source.name)) {
        return None;
    }
    let count = |found: &[Diagnostic]| {
        let mut counts: HashMap<Code, usize> = HashMap::new();
        found.iter().for_each(|one| *counts.entry(one.code).or_default() += 1);
        counts
    };
    let before = count(&crate::examine(path, registry, texts).found);
    let now = count(&after.found);
    let more = |one: &&Diagnostic| now[&one.code] > before.get(&one.code).copied().unwrap_or_default();
    after.found.iter().find(more).cloned()
}
