//! What blocks are about: scenarios, what a search found in one, sets of cases.

use std::collections::HashMap;

use super::literal;
use super::metric::Cast;
use super::places::TextPlaces;
use super::scenario::surroundings;
use super::stream::members;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::ast;
use crate::texts::NameDefinition;
use crate::value::Binding;
use scenario::registry::Registry;
use scenario::{
    CaseSet, Declaration, DeclaredPedestrian, DeclaredVehicleStart, Evaluate, Membership, Part, RangeValues,
    Reference, Registered, SampleSize, Scenario, Search, SearchRange, Target, Tune, Value, VariedValue,
};

/// What the blocks of a suite can be about: its scenarios, and the blocks that are checked so far.
pub struct Subjects<'a> {
    pub definitions: &'a [NameDefinition],
    /// Those of the suite and the supporting ones.
    pub scenarios: [&'a [Scenario]; 2],
    pub searches: Checked<Search>,
    pub tunes: Checked<Tune>,
    pub evaluates: Checked<Evaluate>,
}

/// Blocks of one kind in the order they were checked; of one that is wrong, only the name is known.
pub struct Checked<T> {
    blocks: Vec<Option<T>>,
    by_name: HashMap<String, usize>,
}

impl<T> Default for Checked<T> {
    fn default() -> Self {
        Self { blocks: Vec::new(), by_name: HashMap::new() }
    }
}

impl<T> Checked<T> {
    pub fn add(&mut self, name: &str, block: Option<T>) {
        self.by_name.insert(name.to_string(), self.blocks.len());
        self.blocks.push(block);
    }

    pub fn has(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    /// The block of that name; `None` also if it is wrong, which has been reported.
    pub fn find(&self, name: &str) -> Option<&T> {
        self.blocks[*self.by_name.get(name)?].as_ref()
    }

    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.by_name.keys().map(String::as_str)
    }

    /// The blocks without mistakes.
    pub fn all(self) -> Vec<T> {
        self.blocks.into_iter().flatten().collect()
    }
}

/// A scenario with what its file says about names, as the runs in question vary it.
pub struct StatementSubject<'a> {
    pub scenario: &'a Scenario,
    pub varied: HashMap<String, Binding>,
    /// The variations that a search found values for, with the numbers between which it looked.
    pub searched: HashMap<String, (f64, f64)>,
    /// What its road users may be, and what is measured of them.
    pub registry: Registry,
    /// What its vehicles are called, those of streams too.
    drivers: Vec<String>,
}

impl<'a> Subjects<'a> {
    /// The scenario called `text`, which must have no errors of its own; `also` may be named in its place.
    pub fn scenario(
        &self,
        place: Span,
        text: &str,
        also: &[&str],
        places: &TextPlaces,
        report: &mut Vec<Diagnostic>,
    ) -> Option<StatementSubject<'a>> {
        if !self.scenario_names(places).any(|known| known == text) {
            let what = if also.is_empty() { "scenario" } else { "scenario or search" };
            let known: Vec<&str> = self.scenario_names(places).chain(also.iter().copied()).collect();
            report.push(
                Diagnostic::new(Code::UnknownScenario, place, format!("there is no {what} `{text}` here"))
                    .label("not in this suite")
                    .suggest(text, known),
            );
            return None;
        }
        self.known(text, places)
    }

    pub fn scenario_names<'p>(&'p self, places: &'p TextPlaces) -> impl Iterator<Item = &'p str> {
        self.definitions.iter().map(|definition| places.files.scenario(*definition).name().text())
    }

    /// The scenario of that name, if there is one without mistakes.
    fn known(&self, name: &str, places: &TextPlaces) -> Option<StatementSubject<'a>> {
        let scenario = self.scenarios.into_iter().flatten().find(|scenario| scenario.name == name)?;
        let definition = self
            .definitions
            .iter()
            .find(|definition| places.files.scenario(**definition).name().text() == name)?;
        let registry = places.files.registry.clone();
        let varied = surroundings(*definition, places)?;
        let drivers = drivers(scenario);
        Some(StatementSubject { scenario, varied, searched: HashMap::new(), registry, drivers })
    }

    /// The scenario of a search, varied as it was searched.
    pub fn found_by(&self, search: &Search, places: &TextPlaces) -> Option<StatementSubject<'a>> {
        let mut subject = self.known(&search.scenario, places)?;
        search.over.iter().for_each(|range| subject.searched_over(range));
        Some(subject)
    }

    /// What the cases of a set are of.
    pub fn of(&self, set: &CaseSet, places: &TextPlaces) -> Option<StatementSubject<'a>> {
        match set {
            CaseSet::Search(name) | CaseSet::Bests(name) => self.found_by(self.searches.find(name)?, places),
            CaseSet::Scenario(name) | CaseSet::Sample { scenario: name, .. } => self.known(name, places),
            CaseSet::Saved(path) => {
                let mut subject = self.known(&saved_scenario(path, places)?, places)?;
                // Which values were saved is not looked into.
                subject.varied.values_mut().for_each(|binding| binding.varied = None);
                Some(subject)
            }
        }
    }
}

/// What the vehicles of a scenario are called, those of streams too.
pub fn drivers(scenario: &Scenario) -> Vec<String> {
    let names = scenario.vehicles.iter().map(|car| match &car.start {
        DeclaredVehicleStart::Stream(_) => members(&car.name, Some(car), Some(scenario.horizon)),
        _ => vec![car.name.clone()],
    });
    names.flatten().collect()
}

/// The groups of people, each with the names of its members in any scenario.
pub fn groups<'a>(people: impl IntoIterator<Item = &'a DeclaredPedestrian>) -> Vec<(&'a str, Vec<&'a str>)> {
    Membership::groups(people.into_iter().map(|person| (person.name.as_str(), person.group.as_ref())))
}

impl StatementSubject<'_> {
    pub fn cast(&self) -> Cast<'_> {
        Cast {
            vehicles: self.drivers.iter().map(String::as_str).collect(),
            pedestrians: self.scenario.pedestrians.iter().map(|person| person.name.as_str()).collect(),
            groups: groups(&self.scenario.pedestrians),
            streams: self.scenario.streams().map(|stream| stream.name.as_str()).collect(),
            boxes: self.scenario.road.boxes.iter().map(|body| body.name.as_str()).collect(),
            individuals: None,
            are_drawn: false,
            metrics: self.registry.metrics(),
        }
    }

    fn searched_over(&mut self, range: &SearchRange) {
        let Target::Variation(name) = &range.target else { return };
        let Some(binding) = self.varied.get_mut(name) else { return };
        binding.varied = None;
        match &range.values {
            RangeValues::Real { low, high } | RangeValues::Logarithmic { low, high } => {
                self.searched.insert(name.clone(), (*low, *high));
            }
            RangeValues::Whole { low, high } => {
                self.searched.insert(name.clone(), (*low as f64, *high as f64));
            }
            RangeValues::Words(words) => {
                let value =
                    |word: &String| VariedValue { value: Value::Word(word.clone()), label: word.clone() };
                binding.varied = Some(words.iter().map(value).collect());
            }
        }
    }

    /// Whether the scenario has the parameter that a target names.
    pub fn takes(&self, target: &Target) -> bool {
        match target {
            Target::Variation(name) => self.varied.contains_key(name),
            Target::Setting { road_user, part, parameter } => {
                let declared = declarations(self.scenario, road_user, *part, &self.registry);
                let has = |one: &Declaration| {
                    let preset = one.presets.as_ref().is_some_and(|family| family.word == parameter.as_str());
                    preset || one.parameter(parameter).is_some()
                };
                !declared.is_empty() && declared.iter().all(has)
            }
        }
    }
}

/// The cases of an `on` statement, with what they are of.
pub fn case_set<'a>(
    node: ast::OnCases,
    subjects: &Subjects<'a>,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<(CaseSet, StatementSubject<'a>)> {
    let set = said_set(node, subjects, places, report)?;
    let subject = match &set {
        CaseSet::Saved(path) => {
            let scenario = saved_scenario(path, places)?;
            subjects.scenario(node.span(), &scenario, &[], places, report)?;
            subjects.of(&set, places)?
        }
        _ => subjects.of(&set, places)?,
    };
    Some((set, subject))
}

fn said_set(
    node: ast::OnCases,
    subjects: &Subjects,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<CaseSet> {
    if let Some(path) = node.path() {
        let saved = places.beside(path.span(), &path.path());
        if saved_scenario(&saved, places).is_none() {
            report.push(
                Diagnostic::new(
                    Code::UnreadableFile,
                    path.span(),
                    format!("`{saved}` is no readable set of cases"),
                )
                .label("named here")
                .hint("a search writes such a file; paths are relative to the file they stand in"),
            );
            return None;
        }
        return Some(CaseSet::Saved(saved));
    }
    if let Some(as_many) = node.as_many() {
        let mut names = as_many.names();
        let (scenario, search) = (names.next()?, names.next()?);
        let drawn = drawn(scenario, subjects, places, report);
        if !subjects.searches.has(search.text()) {
            report.push(unknown_search(search, subjects));
            return None;
        }
        let count = SampleSize::AsManyAs(search.text().to_string());
        return Some(CaseSet::Sample { scenario: drawn?, count });
    }
    let name = node.name()?;
    if let Some(count) = node.count() {
        let count = literal::count(count, 1, 1_000_000, "the number of cases", report);
        let scenario = drawn(name, subjects, places, report)?;
        return Some(CaseSet::Sample { scenario, count: SampleSize::Number(count?) });
    }
    let text = name.text().to_string();
    if subjects.searches.has(name.text()) {
        return Some(if node.is_of_all() { CaseSet::Bests(text) } else { CaseSet::Search(text) });
    }
    let searches: Vec<&str> = subjects.searches.names().collect();
    subjects.scenario(name.span(), name.text(), &searches, places, report)?;
    Some(CaseSet::Scenario(text))
}

/// The scenario that some cases are drawn of.
fn drawn(
    name: ast::Name,
    subjects: &Subjects,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<String> {
    if subjects.searches.has(name.text()) {
        report.push(
            Diagnostic::new(
                Code::UnknownScenario,
                name.span(),
                format!("`{}` is a search, and some cases are drawn from a scenario", name.text()),
            )
            .label("not a scenario")
            .hint(format!("take what it kept, `on {0}`, or its best cases, `on all of {0}`", name.text())),
        );
        return None;
    }
    subjects.scenario(name.span(), name.text(), &[], places, report)?;
    Some(name.text().to_string())
}

pub fn unknown_search(name: ast::Name, subjects: &Subjects) -> Diagnostic {
    Diagnostic::new(Code::UnknownBlock, name.span(), format!("there is no search `{}` here", name.text()))
        .label("not in this suite")
        .suggest(name.text(), subjects.searches.names())
}

/// The scenario that the first case of a saved set is of.
fn saved_scenario(path: &str, places: &TextPlaces) -> Option<String> {
    let text = places.files.text_of(path, &["json"]).ok()?;
    let set: serde_json::Value = serde_json::from_str(&text).ok()?;
    Some(set["cases"][0]["scenario"].as_str()?.to_string())
}

/// What the part of a road user declares, in every run of the scenario; empty if there is no such part.
pub fn declarations(scenario: &Scenario, user: &str, part: Part, registry: &Registry) -> Vec<Declaration> {
    let car = scenario.vehicles.iter().find(|vehicle| vehicle.name == user);
    let person = scenario.pedestrians.iter().find(|person| person.is(user));
    match (part, car) {
        (Part::Controller, Some(car)) => declared(car.controller.all()),
        (Part::Dynamics, Some(car)) => match &car.dynamics {
            Some(dynamics) => declared(dynamics.all()),
            None => {
                let controllers = car.controller.all().iter().filter_map(Reference::entry);
                declared(controllers.map(|controller| &controller.default_dynamics))
            }
        },
        (Part::Sees, Some(_)) => vec![registry.perception().declaration.clone()],
        (Part::Model, _) => person.map_or(Vec::new(), |person| declared(person.model.all())),
        (_, None) => Vec::new(),
    }
}

fn declared<'a, T: Registered + 'a>(all: impl IntoIterator<Item = &'a Reference<T>>) -> Vec<Declaration> {
    all.into_iter().filter_map(|one| one.declaration().cloned()).collect()
}
