//! The searches, tunes, evaluates and statements of a suite: which there are, and in which order they are checked.

use std::collections::HashMap;

use super::check::{self, Checked, Places, Subjects};
use super::codes::Code;
use super::diagnostic::Diagnostic;
use super::files::{Definition, FileId, Files};
use super::source::Span;
use super::tree::{Node, Rule};
use crate::scenario::{Evaluate, Scenario, Search, Statement, Tune};

/// Every block of a suite without mistakes.
#[derive(Default)]
pub struct Blocks {
    pub searches: Vec<Search>,
    pub tunes: Vec<Tune>,
    pub evaluates: Vec<Evaluate>,
    pub statements: Vec<Statement>,
}

const KINDS: [Rule; 4] = [Rule::search, Rule::tune, Rule::evaluate, Rule::statement];

/// The blocks of some files, about scenarios and blocks of any of them.
pub fn blocks(
    files: &Files,
    of: &[FileId],
    definitions: &[Definition],
    scenarios: &[Scenario],
    report: &mut Vec<Diagnostic>,
) -> Blocks {
    let nodes: Vec<(FileId, Node)> = of
        .iter()
        .flat_map(|file| {
            let root = files.tree(*file).root();
            let inner =
                root.all(Rule::suite).flat_map(|suite| suite.all(Rule::suite_block)).flat_map(Node::children);
            root.children().chain(inner).map(|node| (*file, node))
        })
        .filter(|(_, node)| KINDS.contains(&node.rule()))
        .collect();
    let mut names: HashMap<&str, Span> = definitions
        .iter()
        .filter_map(|definition| Some((files.node(*definition).child(Rule::name)?.text(), definition.span)))
        .collect();
    for (_, node) in &nodes {
        reject_duplicate(*node, &mut names, report);
    }
    let places = Places { files };
    let mut subjects = Subjects {
        definitions,
        scenarios,
        searches: Checked::default(),
        tunes: Checked::default(),
        evaluates: Checked::default(),
    };
    let mut statements = Vec::new();
    // Each kind is about the ones before it, so no circle can arise.
    for kind in KINDS {
        for (file, node) in nodes.iter().filter(|(_, node)| node.rule() == kind) {
            let scope = files.scope(*file);
            let name = node.child(Rule::name).map_or("", Node::text);
            match kind {
                Rule::search => {
                    let search = check::search(*node, &subjects, scope, &places, report);
                    subjects.searches.add(name, search);
                }
                Rule::tune => {
                    let tune = check::tune(*node, &subjects, scope, &places, report);
                    subjects.tunes.add(name, tune);
                }
                Rule::evaluate => {
                    let evaluate = check::evaluate(*node, &subjects, scope, &places, report);
                    subjects.evaluates.add(name, evaluate);
                }
                _ => statements.extend(check::statement(*node, &subjects, scope, &places, report)),
            }
        }
    }
    Blocks {
        searches: subjects.searches.all(),
        tunes: subjects.tunes.all(),
        evaluates: subjects.evaluates.all(),
        statements,
    }
}

/// Reports a block whose name is taken.
pub fn reject_duplicate<'a>(
    node: Node<'a>,
    names: &mut HashMap<&'a str, Span>,
    report: &mut Vec<Diagnostic>,
) {
    let Some(name) = node.child(Rule::name) else { return };
    if let Some(first) = names.insert(name.text(), name.span()) {
        report.push(
            Diagnostic::new(Code::DuplicateName, name.span(), format!("`{}` is defined twice", name.text()))
                .label("defined again")
                .context(first, "defined first here")
                .hint("give one of them another name"),
        );
    }
}
