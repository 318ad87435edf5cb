//! Findings that only follow from others: names that are not known because what defines them could not be read.

use std::collections::HashSet;

use super::codes::Code;
use super::diagnostic::Diagnostic;
use super::files::Files;
use super::source::Span;
use super::tree::{Node, Rule};

/// Codes about names that are not there.
const UNKNOWN: [Code; 9] = [
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

/// The words that begin a statement that gives a name.
const NAMING: [&str; 11] = [
    "let",
    "vary",
    "road",
    "scenario",
    "define",
    "vehicle",
    "pedestrian",
    "search",
    "tune",
    "evaluate",
    "statement",
];

/// Removes findings about names that statements or files would define if they could be read.
pub fn remove(files: &Files, report: &mut Vec<Diagnostic>) {
    if !report.iter().any(|found| UNKNOWN.contains(&found.code)) {
        return;
    }
    let uses: Vec<Span> = files
        .ids()
        .flat_map(|file| files.tree(file).root().all(Rule::use_file))
        .filter_map(|node| node.child(Rule::string).map(Node::span))
        .collect();
    if report.iter().any(|found| UNREAD.contains(&found.code) || uses.contains(&found.span())) {
        report.retain(|found| !UNKNOWN.contains(&found.code));
        return;
    }
    let mut names: HashSet<&str> = HashSet::new();
    for file in files.ids() {
        for block in files.tree(file).nodes() {
            names.extend(block.all(Rule::bad).filter_map(|bad| named(block.rule(), bad)));
        }
    }
    if !names.is_empty() {
        report.retain(|found| {
            !UNKNOWN.contains(&found.code) || !names.contains(files.sources.text(found.span()))
        });
    }
}

/// The name that a statement would give if it could be read.
fn named<'t>(block: Rule, bad: Node<'t>) -> Option<&'t str> {
    let mut words = bad.text().split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    let first = words.next()?;
    if block == Rule::together_block {
        return Some(first);
    }
    words.find(|word| !word.is_empty()).filter(|_| NAMING.contains(&first))
}
