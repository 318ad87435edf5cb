//! Every place of some files where a name of theirs stands, and what it is of.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use super::classes::{Classes, DefinitionIndex, SymbolKind};
use super::families::{ScenarioFamilies, ScenarioIndex};
use crate::declared::declared;
use crate::source::Span;
use crate::suite::included;
use crate::syntax::Node;
use crate::syntax::ast::{self, View};
use crate::texts::{FileId, Texts};
use scenario::{MetricKind, ParameterKind};

/// A place where a name stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Occurrence {
    /// Of the name.
    pub span: Span,
    /// The same number wherever the same thing is named.
    pub symbol: usize,
    /// Of what it is the name.
    pub kind: SymbolKind,
    /// Whether it is given here.
    pub defines: bool,
}

/// The names of some files.
#[derive(Debug)]
pub struct Symbols {
    /// By file and place.
    pub occurrences: Vec<Occurrence>,
}

impl Symbols {
    /// Those of every file that was read, and of those that suites among them are made of.
    pub fn of(files: &mut Texts) -> Self {
        let suites: Vec<FileId> = files.ids().collect();
        let mut parts: HashMap<FileId, Vec<FileId>> = HashMap::new();
        for file in suites {
            let path = files.sources.get(files.tree(file).source).name.clone();
            parts.insert(file, included(files, file, Path::new(&path)));
        }
        let mut classes = Classes::default();
        let families = ScenarioFamilies::of(files, &mut classes);
        let mut resolver = Resolver { files, parts, families, classes, found: Vec::new() };
        for file in files.ids() {
            let place = Place { file, scenario: None, about: Vec::new(), evaluate: None };
            resolver.define_file(file);
            resolver.walk(files.tree(file).root(), Around::default(), &place);
        }
        let Resolver { classes, found, .. } = resolver;
        let mut occurrences: Vec<Occurrence> = found
            .into_iter()
            .map(|(span, definition, defines)| Occurrence {
                span,
                symbol: classes.root(definition),
                kind: classes.kind(definition),
                defines,
            })
            .collect();
        occurrences.sort_by_key(|one| (one.span, !one.defines));
        occurrences.dedup_by_key(|one| one.span);
        Self { occurrences }
    }

    /// The name at a byte of a text, the end of the name included.
    pub fn at(&self, at: Span) -> Option<Occurrence> {
        let here = |one: &&Occurrence| {
            one.span.source == at.source && one.span.start <= at.start && at.start <= one.span.end
        };
        self.occurrences.iter().find(here).copied()
    }
}

struct Resolver<'t> {
    files: &'t Texts<'t>,
    /// The files that each suite is made of.
    parts: HashMap<FileId, Vec<FileId>>,
    families: ScenarioFamilies,
    classes: Classes,
    found: Vec<(Span, DefinitionIndex, bool)>,
}

/// Where a node stands.
#[derive(Clone)]
struct Place<'t> {
    file: FileId,
    scenario: Option<ScenarioIndex>,
    /// Outside of scenarios: those that are spoken of.
    about: Vec<ScenarioIndex>,
    evaluate: Option<ast::Evaluate<'t>>,
}

/// What a node stands in.
#[derive(Clone, Copy, Default)]
struct Around<'t> {
    parent: Option<Node<'t>>,
    /// What settings are of.
    owner: Option<Node<'t>>,
    setting: Option<ast::Setting<'t>>,
    condition: Option<ast::Condition<'t>>,
}

impl Place<'_> {
    fn scenarios(&self) -> Vec<ScenarioIndex> {
        self.scenario.map_or_else(|| self.about.clone(), |one| vec![one])
    }
}

impl<'t> Resolver<'t> {
    /// What a file defines itself, so that other files find it.
    fn define_file(&mut self, file: FileId) {
        for node in self.files.tree(file).nodes() {
            if let Some((name, kind)) = defined(node) {
                self.classes.define(name.span(), kind);
            }
        }
    }

    fn walk(&mut self, node: Node<'t>, around: Around<'t>, place: &Place<'t>) {
        let inner = self.inner(node, place);
        let place = inner.as_ref().unwrap_or(place);
        match ast::Word::cast(node) {
            Some(ast::Word::Name(name)) => {
                if let Some(parent) = around.parent {
                    self.name(name, parent, place);
                }
            }
            Some(ast::Word::Reference(reference)) => self.reference(reference, around, place),
            _ => {}
        }
        let has_settings = ast::HasSettings::cast(node).is_some() || ast::Metric::cast(node).is_some();
        let around = Around {
            parent: Some(node),
            owner: if has_settings { Some(node) } else { around.owner },
            setting: ast::Setting::cast(node).or(around.setting),
            condition: ast::Condition::cast(node).or(around.condition),
        };
        for child in node.children() {
            self.walk(child, around, place);
        }
    }

    /// Where the parts of a node stand, if it is a place of its own.
    fn inner(&self, node: Node<'t>, place: &Place<'t>) -> Option<Place<'t>> {
        if let Some(scenario) = ast::Scenario::cast(node) {
            let scenario = self.families.at(place.file, scenario.index());
            return Some(Place { scenario, ..place.clone() });
        }
        if ast::Suite::cast(node).is_some() {
            return Some(Place { about: self.scenarios_of_suite(place.file), ..place.clone() });
        }
        let block = ast::Block::cast(node)?;
        let about = self.scenarios_of_block(block, place.file, &mut HashSet::new());
        let evaluate = if let ast::Block::Evaluate(evaluate) = block { Some(evaluate) } else { None };
        Some(Place { about, evaluate, ..place.clone() })
    }

    /// Every scenario that a suite's criteria are about.
    fn scenarios_of_suite(&self, file: FileId) -> Vec<ScenarioIndex> {
        let of = self.parts.get(&file).into_iter().flatten().chain([&file]);
        let mut all = Vec::new();
        for file in of {
            let scenarios = self.files.tree(*file).root().every::<ast::Scenario>();
            all.extend(scenarios.filter_map(|one| self.families.at(*file, one.index())));
            let blocks = self.files.tree(*file).root().every::<ast::Block>();
            let mut seen = HashSet::new();
            all.extend(blocks.flat_map(|block| self.scenarios_of_block(block, *file, &mut seen)));
        }
        all
    }

    /// The scenarios that a block is about, also by other blocks.
    fn scenarios_of_block(
        &self,
        block: ast::Block,
        file: FileId,
        seen: &mut HashSet<Span>,
    ) -> Vec<ScenarioIndex> {
        let mut found = Vec::new();
        if !seen.insert(block.span()) {
            return found;
        }
        for node in block.every::<ast::Referring>() {
            if let ast::Referring::OnCases(cases) = node
                && cases.path().is_some()
            {
                // Which scenario saved cases are of stands in their file.
                let all = self.files.names(file).scenarios.values();
                found.extend(all.filter_map(|one| self.families.index(one)));
            }
            for name in node.parts::<ast::Name>() {
                let names = self.named_in_suite(file, name.text());
                for (file, node) in names {
                    if let Some(scenario) = self.families.at(file, node.index()) {
                        found.push(scenario);
                    } else if let Some(block) = ast::Block::cast(node) {
                        found.extend(self.scenarios_of_block(block, file, seen));
                    }
                }
            }
        }
        found
    }

    /// The scenarios and blocks that a block of a file means by a name: those that the file sees or, in a suite, those of its files.
    fn named_in_suite(&self, file: FileId, name: &str) -> Vec<(FileId, Node<'t>)> {
        let see = |file: FileId| {
            let names = self.files.names(file);
            names.blocks.get(name).or_else(|| names.scenarios.get(name))
        };
        if let Some(found) = see(file) {
            return vec![(found.file, self.files.node(*found))];
        }
        // What is named by files that belong to one suite: a block of one may be about a scenario of another.
        let together = self.parts.iter().filter(|(suite, parts)| **suite == file || parts.contains(&file));
        let mut files: Vec<FileId> =
            together.flat_map(|(suite, parts)| parts.iter().chain([suite])).copied().collect();
        files.sort_by_key(|one| self.files.tree(*one).source);
        files.dedup();
        let own = |of: &FileId| see(*of).filter(|found| found.file == *of);
        files.iter().filter_map(own).map(|found| (found.file, self.files.node(*found))).collect()
    }

    fn add(&mut self, span: Span, definitions: &[DefinitionIndex]) {
        if let Some(definition) = self.classes.unite(definitions) {
            self.found.push((span, definition, false));
        }
    }

    fn add_at(&mut self, span: Span, defined: Option<Span>) {
        let definition = defined.and_then(|defined| self.classes.at(defined));
        self.add(span, definition.as_slice());
    }

    fn user(&mut self, name: Node, place: &Place) {
        let (found, length) = self.families.users(&place.scenarios(), name.text());
        let span = name.span();
        self.add(Span { end: span.start + length, ..span }, &found);
    }

    fn name(&mut self, name: ast::Name<'t>, parent: Node<'t>, place: &Place<'t>) {
        let (text, span) = (name.text(), name.span());
        if let Some((own, kind)) = defined(parent)
            && own.span() == span
        {
            let definition = self.classes.define(span, kind);
            self.found.push((span, definition, true));
            return;
        }
        let names = self.files.names(place.file);
        if ast::Base::cast(parent).is_some() {
            let found = names.scenarios.get(text).map(|found| found.span);
            self.add_at(span, found);
        } else if ast::Argument::cast(parent).is_some() {
            let base = place.scenario.and_then(|one| self.families.base(one));
            let found = base.map_or_else(Vec::new, |base| self.families.parameter(base, text));
            self.add(span, &found);
        } else if ast::LiesOver::cast(parent).is_some()
            || ast::OnRoad::cast(parent).is_some()
            || ast::RoadChoice::cast(parent).is_some()
        {
            let found = names.roads.get(text).map(|found| found.span);
            self.add_at(span, found);
        } else if ast::Named::cast(parent).is_some() {
            if !self.value(name.span(), text, place, false) {
                let found = names.controllers.get(text).map(|found| found.span);
                self.add_at(span, found);
            }
        } else if ast::TestedVehicle::cast(parent).is_some()
            || ast::AppearsWhen::cast(parent).is_some()
            || ast::Meets::cast(parent).is_some()
            || ast::Repeats::cast(parent).is_some()
            || ast::Settings::cast(parent).is_some()
        {
            self.user(*name, place);
        } else if ast::Crosses::cast(parent).is_some() {
            let found = self.families.crossings(&place.scenarios(), text);
            self.add(span, &found);
        } else if ast::WhenCondition::cast(parent).is_some() || ast::Trend::cast(parent).is_some() {
            let found = self.families.variations(&place.scenarios(), text);
            self.add(span, &found);
        } else if let Some(target) = ast::Target::cast(parent) {
            if target.parameter().is_some() {
                self.user(*name, place);
            } else {
                let found = self.families.variations(&place.scenarios(), text);
                self.add(span, &found);
            }
        } else if ast::ReportedRow::cast(parent).is_some() {
            if let Some(evaluate) = place.evaluate {
                self.condition(name, evaluate, place.file);
            }
        } else if let Some(outcomes) = ast::Outcomes::cast(parent) {
            self.outcome(name, outcomes, place);
        } else if ast::Referring::cast(parent).is_some() || ast::Population::cast(parent).is_some() {
            self.block_or_scenario(name, place.file);
        }
    }

    fn block_or_scenario(&mut self, name: ast::Name<'t>, file: FileId) {
        let found: Vec<DefinitionIndex> = self
            .named_in_suite(file, name.text())
            .into_iter()
            .filter_map(|(_, node)| self.classes.at(defined(node)?.0.span()))
            .collect();
        self.add(name.span(), &found);
    }

    /// `NAME` of a measured claim, or `EVALUATE.CONDITION`.
    fn outcome(&mut self, name: ast::Name<'t>, outcomes: ast::Outcomes<'t>, place: &Place<'t>) {
        let Some(first) = outcomes.names().next() else { return };
        if first.span() == name.span() {
            return self.block_or_scenario(name, place.file);
        }
        for (file, node) in self.named_in_suite(place.file, first.text()) {
            if let Some(evaluate) = ast::Evaluate::cast(node) {
                self.condition(name, evaluate, file);
            }
        }
    }

    /// A condition of an evaluate by its name, or by that of the tune that it is.
    fn condition(&mut self, name: ast::Name<'t>, evaluate: ast::Evaluate<'t>, file: FileId) {
        let aliases = evaluate.every::<ast::Alias>().map(|alias| alias.name());
        let aliased = aliases.into_iter().find(|alias| alias.text() == name.text());
        match aliased {
            Some(alias) => self.add_at(name.span(), Some(alias.span())),
            None => self.block_or_scenario(name, file),
        }
    }

    /// A name in a value; whether it stands for one.
    fn value(&mut self, span: Span, text: &str, place: &Place, controllers: bool) -> bool {
        let (mut found, whole) = match place.scenario {
            Some(scenario) => self.families.values(scenario, text),
            None => (self.families.variations(&place.about, text), false),
        };
        if !whole && let Some(binding) = self.files.scope(place.file).names.get(text) {
            found.extend(self.classes.at(binding.span));
        }
        if found.is_empty() && controllers {
            let controller = self.files.names(place.file).controllers.get(text);
            found.extend(controller.and_then(|one| self.classes.at(one.span)));
        }
        self.add(span, &found);
        !found.is_empty()
    }

    fn reference(&mut self, reference: ast::Reference<'t>, around: Around<'t>, place: &Place<'t>) {
        let (text, registry) = (reference.text(), &self.files.registry);
        let kind = around.setting.zip(around.owner).and_then(|(setting, owner)| {
            let declaration = declared(owner, registry)?;
            let name = setting.name().text();
            let family = declaration.presets.as_ref().filter(|family| family.word == name);
            let is_preset = family.is_some_and(|family| family.presets.iter().any(|one| *one.name == *text));
            Some(match declaration.parameter(name).map(|known| &known.kind) {
                // An option's own name always means the option.
                Some(ParameterKind::Choice { options, .. })
                    if options.iter().any(|one| *one.name == *text) =>
                {
                    Means::Option
                }
                _ if is_preset => Means::Option,
                Some(ParameterKind::Pedestrian) => Means::Pedestrian,
                _ => Means::Value,
            })
        });
        // The words of a metric are its own.
        let is_word = around.setting.is_none()
            && around.condition.is_some_and(|condition| {
                let metric = registry.metrics().get(condition.metric().name().text());
                metric.is_some_and(|known| matches!(known.kind, MetricKind::Category(_)))
            });
        match kind {
            Some(Means::Option) => {}
            _ if is_word => {}
            Some(Means::Pedestrian) => {
                if !self.value(reference.span(), text, place, false) {
                    self.user(*reference, place);
                }
            }
            Some(Means::Value) | None => _ = self.value(reference.span(), text, place, true),
        }
    }
}

/// What a word in a setting may be.
enum Means {
    Option,
    Pedestrian,
    Value,
}

/// The name that a node gives, and of what.
fn defined(node: Node) -> Option<(ast::Name, SymbolKind)> {
    if let Some(node) = ast::Defining::cast(node) {
        return Some(match node {
            ast::Defining::Binding(one) => (one.name(), SymbolKind::Constant),
            ast::Defining::RoadDefinition(one) => (one.name(), SymbolKind::Road),
            ast::Defining::ControllerDefinition(one) => (one.name(), SymbolKind::Controller),
            ast::Defining::Scenario(one) => (one.name(), SymbolKind::Scenario),
            ast::Defining::Search(one) => (one.name(), SymbolKind::Block),
            ast::Defining::Tune(one) => (one.name(), SymbolKind::Block),
            ast::Defining::Evaluate(one) => (one.name(), SymbolKind::Block),
            ast::Defining::Calibrate(one) => (one.name(), SymbolKind::Block),
            ast::Defining::Estimate(one) => (one.name(), SymbolKind::Block),
            ast::Defining::Statement(one) => (one.name(), SymbolKind::Block),
        });
    }
    if let Some(node) = ast::Local::cast(node) {
        return Some(match node {
            ast::Local::Binding(one) => (one.name(), SymbolKind::Constant),
            ast::Local::Draw(one) => (one.name(), SymbolKind::Variation),
            ast::Local::Varied(one) => (one.name(), SymbolKind::Variation),
            ast::Local::Parameter(one) => (one.name(), SymbolKind::Parameter),
            ast::Local::Pedestrian(one) => (one.name(), SymbolKind::Pedestrian),
            ast::Local::Vehicle(one) => (one.name(), SymbolKind::Vehicle),
        });
    }
    let suite = ast::Suite::cast(node).map(|one| (one.name(), SymbolKind::Suite));
    let gate = || ast::Gate::cast(node).map(|one| (one.name(), SymbolKind::Gate));
    let rating = || ast::Rating::cast(node).map(|one| (one.name(), SymbolKind::Rating));
    let obstacle = || ast::Obstacle::cast(node).map(|one| (one.name(), SymbolKind::Obstacle));
    let crossing = || ast::OtherCrossing::cast(node).map(|one| (one.name(), SymbolKind::Crossing));
    let alias = || ast::Alias::cast(node).map(|one| (one.name(), SymbolKind::Condition));
    let own = || ast::OwnParameter::cast(node).map(|one| (one.name(), SymbolKind::ProgramParameter));
    suite.or_else(gate).or_else(rating).or_else(obstacle).or_else(crossing).or_else(alias).or_else(own)
}
