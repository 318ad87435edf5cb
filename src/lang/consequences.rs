//! Findings that only follow from others: names that are not known because what defines them could not be read, and what a
//! block lacks because nobody knows where it ends.

use std::collections::HashSet;

use super::codes::Code;
use super::diagnostic::Diagnostic;
use super::source::Span;
use super::syntax::ast::{self, View};
use super::syntax::{Node, words as table};
use super::texts::Texts;

/// Codes about names that are not there.
const UNKNOWN: [Code; 10] = [
    Code::UnknownController,
    Code::UnknownName,
    Code::UnknownRoad,
    Code::UnknownVehicle,
    Code::UnknownPedestrian,
    Code::UnknownVariation,
    Code::UnknownTemplate,
    Code::UnknownScenario,
    Code::UnknownBlock,
    Code::UnknownCondition,
];

/// Codes of files of which nothing is known, besides those that are found where a file is used.
const UNREAD: [Code; 8] = [
    Code::UnclosedBracket,
    Code::MismatchedBracket,
    Code::UnopenedBracket,
    Code::UnclosedString,
    Code::NestedTooDeeply,
    Code::BadYaml,
    Code::WrongShape,
    Code::UnknownKey,
];

/// Codes about what a block lacks.
const LACKING: [Code; 3] = [Code::MissingStatement, Code::NoStart, Code::NobodyThere];

/// Removes findings about names that statements or files would define if they could be read, and about what blocks lack that
/// are not closed.
pub fn remove(files: &Texts, report: &mut Vec<Diagnostic>) {
    let unclosed: Vec<Span> = report
        .iter()
        .filter(|found| found.code == Code::UnclosedBracket)
        .flat_map(|found| heads(files, found.span()))
        .collect();
    report.retain(|found| {
        let (span, lacks) = (found.span(), LACKING.contains(&found.code));
        let is_in =
            |head: &Span| head.source == span.source && head.start <= span.start && span.end <= head.end;
        !(lacks && unclosed.iter().any(is_in))
    });
    if !report.iter().any(|found| UNKNOWN.contains(&found.code)) {
        return;
    }
    let uses: Vec<Span> =
        files.ids().flat_map(|file| files.tree(file).file().uses()).map(|used| used.path().span()).collect();
    if report.iter().any(|found| UNREAD.contains(&found.code) || uses.contains(&found.span())) {
        report.retain(|found| !UNKNOWN.contains(&found.code));
        return;
    }
    let mut names: HashSet<&str> = HashSet::new();
    for file in files.ids() {
        for block in files.tree(file).nodes() {
            names.extend(block.children().filter(|child| child.is_bad()).filter_map(|bad| named(block, bad)));
        }
    }
    // Controllers that are declared wrongly.
    names.extend(
        files.ids().flat_map(|file| files.tree(file).file().controllers()).map(|own| own.name().text()),
    );
    if !names.is_empty() {
        report.retain(|found| {
            !UNKNOWN.contains(&found.code) || !names.contains(files.sources.text(found.span()))
        });
    }
}

/// What stands before the braces of the blocks that a brace opens or is in.
fn heads(files: &Texts, brace: Span) -> Vec<Span> {
    let Some(file) = files.ids().find(|file| files.tree(*file).source == brace.source) else {
        return Vec::new();
    };
    let around = files
        .tree(file)
        .nodes()
        .skip(1)
        .filter(|node| node.span().start <= brace.start && brace.start < node.span().end);
    let head = |node: Node| {
        let (span, before) = (node.span(), node.text().find('{')?);
        Some(Span::new(span.source, span.start, span.start + before))
    };
    around.filter_map(head).collect()
}

/// The name that a statement would give if it could be read.
fn named<'t>(block: Node<'t>, bad: Node<'t>) -> Option<&'t str> {
    let mut words = bad.text().split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    let first = words.next()?;
    if ast::TogetherBlock::cast(block).is_some() {
        return Some(first);
    }
    let names = table::all().any(|statement| statement.names && statement.word() == first);
    words.find(|word| !word.is_empty()).filter(|_| names)
}
