//! The searches, tunes, evaluates and statements of a suite: which there are, and in which order they are checked.

use std::collections::{HashMap, HashSet};

use super::check::{self, Checked, Subjects, TextPlaces};
use super::codes::Code;
use super::diagnostic::Diagnostic;
use super::source::Span;
use super::syntax::NodeIndex;
use super::syntax::ast::{self, View};
use super::texts::{FileId, NameDefinition, Texts};
use scenario::{Calibrate, Estimate, Evaluate, Scenario, Search, Statement, Tune};

/// Every block of a suite without mistakes.
#[derive(Default)]
pub struct Blocks {
    pub searches: Vec<Search>,
    pub tunes: Vec<Tune>,
    pub evaluates: Vec<Evaluate>,
    pub calibrates: Vec<Calibrate>,
    pub estimates: Vec<Estimate>,
    pub statements: Vec<Statement>,
}

/// The blocks that belong to a suite, with the scenarios that they bring along from used files.
#[derive(Default)]
pub struct Gathered<'t> {
    nodes: Vec<(FileId, ast::Block<'t>)>,
    /// Everything that they refer to.
    names: HashSet<&'t str>,
    /// Scenarios whose runs a statement measures, so that they belong to the suite.
    pub measured: Vec<NameDefinition>,
    /// Scenarios that are only searched, sampled or compared with.
    pub supporting: Vec<NameDefinition>,
}

/// What a block refers to by name.
struct Reference<'t> {
    name: &'t str,
    /// Every run of it is wanted, should it be a scenario.
    measures: bool,
}

/// The blocks of some files whose scenarios are `definitions`, and everything in used files that those build on.
pub fn gather<'t>(files: &'t Texts, of: &[FileId], definitions: &[NameDefinition]) -> Gathered<'t> {
    let mut gathered = Gathered::default();
    for file in of {
        let root = files.tree(*file).file();
        let inner = root.suites().flat_map(|suite| suite.block().blocks());
        let blocks = root.blocks().chain(inner);
        gathered.nodes.extend(blocks.map(|node| (*file, node)));
    }
    let mut seen: HashSet<(FileId, NodeIndex)> =
        gathered.nodes.iter().map(|(file, node)| (*file, node.index())).collect();
    let mut at = 0;
    while let Some((file, node)) = gathered.nodes.get(at).copied() {
        at += 1;
        let names = files.names(file);
        for Reference { name, measures } in references(node) {
            gathered.names.insert(name);
            if let Some(block) = names.blocks.get(name) {
                if seen.insert((block.file, block.node)) {
                    gathered
                        .nodes
                        .extend(ast::Block::cast(files.node(*block)).map(|node| (block.file, node)));
                }
            } else if let Some(scenario) = names.scenarios.get(name)
                && !files.scenario(*scenario).is_template()
                && !definitions.contains(scenario)
            {
                let into = if measures { &mut gathered.measured } else { &mut gathered.supporting };
                if !into.contains(scenario) {
                    into.push(*scenario);
                }
            }
        }
    }
    let measured = &gathered.measured;
    gathered.supporting.retain(|scenario| !measured.contains(scenario));
    gathered
}

fn references(block: ast::Block) -> impl Iterator<Item = Reference> {
    block.every::<ast::Referring>().flat_map(|node| {
        let alone = matches!(node, ast::Referring::Outcomes(_));
        let names = node.parts::<ast::Name>().take(if alone { 1 } else { usize::MAX });
        names.map(move |name| Reference { name: name.text(), measures: alone })
    })
}

impl Gathered<'_> {
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Whether any of them refers to a scenario or block of that name.
    pub fn are_about(&self, name: &str) -> bool {
        self.names.contains(name)
    }

    /// What they are called, and where.
    pub fn names(&self) -> impl Iterator<Item = (&str, Span)> {
        self.nodes.iter().map(|(_, node)| (node.name().text(), node.name().span()))
    }

    /// Checks every block. The scenarios are those of the suite and the supporting ones; `definitions` are of both.
    pub fn check(
        self,
        files: &Texts,
        definitions: &[NameDefinition],
        scenarios: [&[Scenario]; 2],
        report: &mut Vec<Diagnostic>,
    ) -> Blocks {
        reject_shared_names(files, &self.nodes, definitions, report);
        let places = TextPlaces { files };
        let mut subjects = Subjects {
            definitions,
            scenarios,
            searches: Checked::default(),
            tunes: Checked::default(),
            evaluates: Checked::default(),
        };
        let (mut calibrates, mut estimates, mut statements) = (Vec::new(), Vec::new(), Vec::new());
        // Each kind is about the ones before it, so no circle can arise.
        let mut nodes = self.nodes;
        nodes.sort_by_key(|(_, node)| match node {
            ast::Block::Search(_) => 0,
            ast::Block::Tune(_) => 1,
            ast::Block::Evaluate(_) => 2,
            ast::Block::Calibrate(_) => 3,
            ast::Block::Estimate(_) => 4,
            ast::Block::Statement(_) => 5,
        });
        for (file, node) in nodes {
            let (scope, name) = (files.scope(file), node.name().text());
            match node {
                ast::Block::Search(node) => {
                    let search = check::search(node, &subjects, scope, &places, report);
                    subjects.searches.add(name, search);
                }
                ast::Block::Tune(node) => {
                    let tune = check::tune(node, &subjects, scope, &places, report);
                    subjects.tunes.add(name, tune);
                }
                ast::Block::Evaluate(node) => {
                    let evaluate = check::evaluate(node, &subjects, scope, &places, report);
                    subjects.evaluates.add(name, evaluate);
                }
                ast::Block::Calibrate(node) => {
                    calibrates.extend(check::calibrate(node, &subjects, scope, &places, report));
                }
                ast::Block::Estimate(node) => {
                    estimates.extend(check::estimate(node, &subjects, scope, &places, report));
                }
                ast::Block::Statement(node) => {
                    statements.extend(check::statement(node, &subjects, scope, &places, report));
                }
            }
        }
        Blocks {
            searches: subjects.searches.all(),
            tunes: subjects.tunes.all(),
            evaluates: subjects.evaluates.all(),
            calibrates,
            estimates,
            statements,
        }
    }
}

/// Reports blocks that are called like a scenario or like a block of another file. Within a file and what it uses that
/// has been done.
fn reject_shared_names(
    files: &Texts,
    nodes: &[(FileId, ast::Block)],
    definitions: &[NameDefinition],
    report: &mut Vec<Diagnostic>,
) {
    let scenario =
        |definition: &NameDefinition| (files.scenario(*definition).name().text(), (definition.span, true));
    let mut names: HashMap<&str, (Span, bool)> = definitions.iter().map(scenario).collect();
    let known: HashSet<Span> =
        report.iter().filter(|finding| finding.code == Code::DuplicateName).map(Diagnostic::span).collect();
    let named = nodes.iter().map(|(_, node)| node.name());
    for name in named.filter(|name| !known.contains(&name.span())) {
        match names.get(name.text()) {
            Some((first, is_scenario)) if *is_scenario || first.source != name.span().source => {
                report.push(
                    Diagnostic::new(
                        Code::DuplicateName,
                        name.span(),
                        format!("`{}` is defined twice", name.text()),
                    )
                    .label("defined again")
                    .context(*first, if *is_scenario { "a scenario" } else { "defined first here" })
                    .hint("give one of them another name: scenarios and blocks share theirs"),
                );
            }
            Some(_) => {}
            None => _ = names.insert(name.text(), (name.span(), false)),
        }
    }
}
