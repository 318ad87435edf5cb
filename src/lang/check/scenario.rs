//! `scenario NAME { … }`

use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::Path;

use super::block::{Layer, Said, last, missing, reject_repeats};
use super::book::Book;
use super::criterion::{From, criterion};
use super::defaults::Defaults;
use super::junction::{defined_road, lies_over_another, other_roads, write_other_road};
use super::literal;
use super::metric::Cast;
use super::pedestrian::{Described, pedestrian, write_pedestrian};
use super::places::TextPlaces;
use super::road::{DeclaredRoad, road, write_road};
use super::same_as::check_same_as;
use super::vehicle::{check_starts, vehicle, write_vehicle};
use super::{draw, group, runs, stream, variation};
use crate::codes::Code;
use crate::diagnostic::{Diagnostic, Remedy, nearest};
use crate::source::Span;
use crate::syntax::ast;
use crate::texts::{NameDefinition, Names};
use crate::value::{self, Binding, NameScope, Typed, ValueKind};
use crate::write::{BlockText, quantity, quoted};
use scenario::limits::Limit;
use scenario::{
    Criterion, DeclaredBend, DeclaredGround, DeclaredOtherRoad, DeclaredPedestrian, DeclaredSignal,
    Dimension, Expression, Individuals, Membership, PopulationShare, Scenario, Variation, Vehicle, limits,
};

/// Criteria that a suite adds to its scenarios, with the names that its file can see.
#[derive(Clone, Copy)]
pub struct SuiteCriteria<'a> {
    pub nodes: &'a [ast::Criterion<'a>],
    pub scope: &'a NameScope<'a>,
}

/// The checked scenario at `definition`, with the suite's criteria added to its own.
pub fn scenario(
    definition: NameDefinition,
    places: &TextPlaces,
    added: Option<SuiteCriteria>,
    report: &mut Vec<Diagnostic>,
) -> Option<Scenario> {
    let name = places.files.scenario(definition).name();
    let before = report.len();
    let chain = chain(definition, places, report)?;
    let parameters = parameter_scopes(&chain, places, report)?;
    let blocks = layers(&chain, &parameters, places);
    if let Some(own) = blocks.last() {
        reject_repeats(*own.block, report);
        runs::reject_both(own.block, report);
    }
    let (mut variations, mut varied) = variation::variations(&blocks, report);
    let mut draws = draw::draws(&blocks, &mut variations, &mut varied, places, report);
    let scopes: Vec<NameScope> = blocks.iter().map(|layer| layer_scope(*layer, &varied, report)).collect();
    let layers: Vec<Layer<_>> =
        blocks.iter().zip(&scopes).map(|(layer, scope)| Layer { block: layer.block, scope }).collect();

    let mut written = Book::default();
    let road = scenario_road(&chain, &layers, name, places, &mut written, report);
    let (road, bend, ground, other_crossings, signal) = match road {
        Some(DeclaredRoad { road, bend, ground, other_crossings, signal, over: _ }) => {
            (Some(road), bend, ground, other_crossings, signal)
        }
        None => (None, None, None, Vec::new(), None),
    };
    let mut vehicle_groups =
        grouped(&layers, |block| block.vehicles().map(|one| (one.name(), one.block())).collect(), report);
    let repeated = stream::repeat(&mut vehicle_groups, report);
    let elsewhere = other_roads(&vehicle_groups, road.as_ref(), places, &mut written, report);
    let pedestrian_groups =
        grouped(&layers, |block| block.pedestrians().map(|one| (one.name(), one)).collect(), report);
    reject_shared_names(&vehicle_groups, &pedestrian_groups, report);
    let everybody: Vec<(&[Layer<ast::Pedestrian>], Vec<Described>)> = pedestrian_groups
        .iter()
        .map(|(name, layers)| (layers.as_slice(), group::described(*name, layers, report)))
        .collect();
    for (name, binding) in &varied {
        binding.value.iter().for_each(|typed| written.variation(name, typed, places));
    }
    let number =
        |said: Option<Said<ast::Expression>>, limit: Limit, what: &str, default: f64, report: &mut _| {
            let Some(Said { node, scope }) = said else { return Some(default) };
            value::constant_in(node, limit.dimension, limit.range, what, scope, report)
        };
    let mut vehicles: Vec<(Span, Vehicle)> = Vec::new();
    let mut alike = Vec::new();
    let are_whole = vehicle_groups.iter().filter(|group| !stream::lacks_repeated(group, &repeated));
    for (name, layers) in are_whole {
        let roads = (road.as_ref(), elsewhere.as_slice());
        let found = vehicle((*name, layers), roads, &repeated, places, &mut written, &mut alike, report);
        vehicles.extend(found.map(|vehicle| (name.span(), vehicle)));
    }
    let horizon = last(&layers, |block| block.horizon().map(ast::Horizon::value));
    let horizon = number(horizon, limits::HORIZON, "the horizon", Defaults::HORIZON, report);
    let drivers = drivers(&vehicle_groups, &vehicles, horizon);
    let mut cast = Cast {
        vehicles: drivers.iter().map(String::as_str).collect(),
        pedestrians: everybody.iter().flat_map(|(_, who)| who).map(|one| one.name.as_str()).collect(),
        groups: Membership::groups(
            everybody.iter().flat_map(|(_, who)| who).map(|one| (one.name.as_str(), one.group.as_ref())),
        ),
        streams: vehicle_groups
            .iter()
            .filter(|(_, layers)| is_stream(layers))
            .map(|(name, _)| name.text())
            .collect(),
        boxes: road.iter().flat_map(|road| &road.boxes).map(|body| body.name.as_str()).collect(),
        individuals: None,
        are_drawn: false,
        metrics: places.files.registry.metrics(),
    };
    let mut pedestrians: Vec<DeclaredPedestrian> = Vec::new();
    for (index, (layers, members)) in everybody.iter().enumerate() {
        let others = everybody.iter().enumerate().filter(|(other, _)| *other != index);
        let others = others.flat_map(|(_, (_, who))| who).map(|one| one.name.as_str());
        let others: Vec<&str> = others.chain(cast.vehicles.iter().chain(&cast.boxes).copied()).collect();
        group::reject_taken_names(members, &others, report);
        for who in members {
            let scopes = group::scopes(who, layers);
            let layers: Vec<Layer<_>> =
                scopes.iter().map(|(block, scope)| Layer { block: *block, scope }).collect();
            let (cars, mut found) = (&cast.vehicles, Vec::new());
            let person = pedestrian(who, &layers, road.as_ref(), cars, places, &mut written, &mut found);
            pedestrians.extend(person);
            group::once(found, report);
        }
    }
    let others = vehicle_groups.iter().map(|(name, _)| (name.text(), name.span()));
    let people = everybody.iter().flat_map(|(_, who)| who).map(|one| (one.name.as_str(), one.span));
    let boxes = cast.boxes.iter().map(|body| (*body, name.span()));
    let others: Vec<(&str, Span)> = others.chain(people).chain(boxes).collect();
    for group in vehicle_groups.iter().filter(|(_, layers)| is_stream(layers)) {
        let declared = declared(&vehicles, group.0);
        stream::check(group, declared, horizon, &others, report);
    }
    let unread = layers.iter().any(|layer| layer.block.is_broken()) || road.is_none();
    let broken = report.len() > before || unread;
    if !broken {
        let awaited =
            |vehicle: &str| pedestrians.iter().any(|pedestrian| pedestrian.appears.awaits() == Some(vehicle));
        check_starts(&vehicles, awaited, report);
        nobody(name, &cast, !elsewhere.is_empty(), report);
        check_same_as(&alike, &pedestrians, report);
    }
    let vehicles: Vec<Vehicle> = vehicles.into_iter().map(|(_, vehicle)| vehicle).collect();

    let taken = || pedestrians.iter().filter_map(|pedestrian| pedestrian.individuals.as_ref());
    let several = |people: &Individuals| {
        !matches!(people.selection, PopulationShare::Number(_) | PopulationShare::Count(1))
    };
    // Of a scenario that could not be read nobody knows.
    cast.individuals = if broken { Some(true) } else { taken().next().map(|_| taken().any(several)) };
    cast.are_drawn = pedestrians.iter().any(draws_person);
    let mut criteria: Vec<(Span, Criterion)> = Vec::new();
    for layer in &layers {
        for node in layer.block.expects().flat_map(|expect| expect.block().criteria()) {
            let found = criterion(node, From::Scenario, &cast, layer.scope, places, report);
            criteria.extend(found.into_iter().flatten().map(|criterion| (node.span(), criterion)));
        }
    }
    if let Some(added) = added {
        let scope = NameScope { outer: Some(added.scope), names: varied.clone(), member: None };
        for node in added.nodes {
            let found = criterion(*node, From::Suite, &cast, &scope, places, report);
            criteria.extend(found.into_iter().flatten().map(|criterion| (node.span(), criterion)));
        }
    }

    draw::refuse_in_criteria(&draws, &criteria, report);
    let draws_people = pedestrians.iter().any(draws_person);
    criteria.iter_mut().for_each(|(_, criterion)| criterion.reach.drawn_people = draws_people);

    let step = last(&layers, |block| block.step().map(ast::Step::value));
    if let Some(Said { node, scope }) = step
        && let Some(typed) = value::evaluate(node, scope, &mut Vec::new())
    {
        written.variation("step", &typed, places);
    }
    let finish = last(&layers, |block| block.finish().map(ast::Finish::value));
    let step = number(step, limits::STEP, "the simulation step", Defaults::STEP, report);
    let finish = number(finish, limits::FINISH, "the finish line", Defaults::FINISH, report);
    let runs = runs::runs(&layers, &criteria, places, report);
    let criteria: Vec<Criterion> = criteria.into_iter().map(|(_, criterion)| criterion).collect();
    let doc = layers.iter().rev().find_map(|layer| literal::doc(layer.block.doc()));
    let mut tags = Vec::new();
    for tag in layers.iter().flat_map(|layer| literal::tags(layer.block.tags())) {
        if !tags.contains(&tag) {
            tags.push(tag);
        }
    }
    draw::leave_out_unknown(before, report);
    if report.len() == before && !broken {
        let mut users = used_variables(
            (bend.as_ref(), ground.as_ref(), signal.as_ref()),
            &vehicles,
            &pedestrians,
            &criteria,
        );
        users.extend(variations.iter().flat_map(Variation::depends_on));
        users.extend(other_crossings.iter().flat_map(|place| place.at.variables()));
        let of_others = elsewhere.iter().flat_map(DeclaredOtherRoad::expressions);
        users.extend(of_others.flat_map(|(expression, _)| expression.variables()));
        draw::leave_out_unused(&mut draws, &blocks, &varied, &users, report);
        unused(&layers, &varied, &variations, &users, report);
    }
    draws.extend(stream::draws(&vehicles));
    Some(Scenario {
        name: name.text().to_string(),
        doc,
        tags,
        road: road?,
        bend,
        ground,
        other_crossings,
        signal,
        other_roads: elsewhere,
        vehicles,
        pedestrians,
        variations,
        draws,
        repeat: runs.as_ref()?.repeat,
        seed: runs.as_ref()?.seed,
        runs: runs?.budget,
        criteria,
        step: step?,
        horizon: horizon?,
        finish: finish?,
        end_on_collision: last(&layers, ast::ScenarioBlock::end_on_collision).is_some(),
        written: written.0,
        origin: places.origin(name.span()),
    })
    .filter(|_| {
        !report[before..].iter().any(|diagnostic| diagnostic.code.severity() == crate::Severity::Error)
    })
}

/// The variations of a scenario that was checked before, by name.
pub fn surroundings(definition: NameDefinition, places: &TextPlaces) -> Option<HashMap<String, Binding>> {
    let mut known = Vec::new();
    let chain = chain(definition, places, &mut known)?;
    let scopes = parameter_scopes(&chain, places, &mut known)?;
    let layers = layers(&chain, &scopes, places);
    let (mut variations, mut names) = variation::variations(&layers, &mut known);
    draw::draws(&layers, &mut variations, &mut names, places, &mut known);
    Some(names)
}

/// What every definition of a chain says, with the names that it knows.
fn layers<'a>(
    chain: &[NameDefinition],
    scopes: &'a [NameScope<'a>],
    places: &TextPlaces<'a>,
) -> Vec<Layer<'a, ast::ScenarioBlock<'a>>> {
    let block = |definition: &NameDefinition| places.files.scenario(*definition).block();
    chain.iter().zip(scopes).map(|(definition, scope)| Layer { block: block(definition), scope }).collect()
}

/// What a scenario builds on, the base first and itself last.
fn chain(
    definition: NameDefinition,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<NameDefinition>> {
    let mut chain = vec![definition];
    let mut at = definition;
    while let Some(base) = places.files.scenario(at).base() {
        let name = base.name();
        let names = places.files.names(at.file);
        let Some(found) = names.scenarios.get(name.text()) else {
            report.push(
                Diagnostic::new(
                    Code::UnknownTemplate,
                    name.span(),
                    format!("there is no scenario or template `{}`", name.text()),
                )
                .label("not defined in this file or one it uses")
                .suggest(name.text(), names.scenarios.keys().map(String::as_str)),
            );
            return None;
        };
        if chain.contains(found) {
            report.push(
                Diagnostic::new(
                    Code::CircularTemplate,
                    name.span(),
                    format!("`{}` builds on itself", name.text()),
                )
                .label("leads back here")
                .hint("let one of them build on nothing"),
            );
            return None;
        }
        chain.push(*found);
        at = *found;
    }
    chain.reverse();
    Some(chain)
}

/// The names of each layer before variations: those of its file and its parameters.
fn parameter_scopes<'a>(
    chain: &[NameDefinition],
    places: &TextPlaces<'a>,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<NameScope<'a>>> {
    // Arguments are said by the layer after, so the last layer comes first.
    let mut scopes: Vec<NameScope<'a>> = Vec::new();
    for (index, definition) in chain.iter().enumerate().rev() {
        let node = places.files.scenario(*definition);
        let mut scope = NameScope::inside(places.files.scope(definition.file));
        let base = chain.get(index + 1).and_then(|caller| places.files.scenario(*caller).base());
        let arguments: Vec<ast::Argument> =
            base.and_then(ast::Base::arguments).into_iter().flat_map(ast::Arguments::each).collect();
        let parameters: Vec<ast::Parameter> =
            node.parameters().into_iter().flat_map(ast::Parameters::each).collect();
        for argument in &arguments {
            let name = argument.name();
            let known = parameters.iter().map(|parameter| parameter.name().text());
            if !known.clone().any(|known| known == name.text()) {
                report.push(
                    Diagnostic::new(
                        Code::BadArgument,
                        name.span(),
                        format!("there is no parameter `{}`", name.text()),
                    )
                    .label("unknown parameter")
                    .suggest(name.text(), known),
                );
            }
        }
        for parameter in parameters {
            let name = parameter.name();
            let mut given = arguments.iter().filter(|argument| argument.name().text() == name.text());
            let value = match (given.next(), parameter.default()) {
                (Some(argument), default) => {
                    if let Some(again) = given.next() {
                        report.push(crate::settings::repeated(name.text(), again.span(), argument.span()));
                    }
                    // The caller's own names: its scope was pushed just before.
                    let caller_scope = scopes.last()?;
                    let default = default.and_then(|node| argument_value(node, &scope, None, report));
                    let kind = default.as_ref().map(|default| default.kind);
                    let value = argument_value(argument.value(), caller_scope, kind, report);
                    value.filter(|value| {
                        default.is_none_or(|default| {
                            let what = format!("parameter `{}`", name.text());
                            value::expect_kind(value, default.kind, &what, report)
                        })
                    })
                }
                (None, Some(default)) => argument_value(default, &scope, None, report),
                (None, None) => {
                    if let Some(base) = base {
                        report.push(
                            Diagnostic::new(
                                Code::BadArgument,
                                base.span(),
                                format!("parameter `{}` has no value", name.text()),
                            )
                            .label("no argument and no default")
                            .context(name.span(), "declared here")
                            .hint(format!("give it one: `({}: …)`", name.text())),
                        );
                    }
                    None
                }
            };
            if let Some(first) = scope.names.get(name.text()) {
                report.push(crate::settings::repeated(name.text(), name.span(), first.span));
            }
            scope.names.insert(name.text().to_string(), Binding::new(value, name.span()));
        }
        scopes.push(scope);
    }
    scopes.reverse();
    Some(scopes)
}

/// The value of a parameter. A name that is not defined is a word where the default is one, or where no defined name is
/// near enough to be meant.
fn argument_value(
    expression: ast::Expression,
    scope: &NameScope,
    default: Option<ValueKind>,
    report: &mut Vec<Diagnostic>,
) -> Option<Typed> {
    let Some(word) = expression.lone_word().filter(|word| scope.find(word).is_none()) else {
        return value::evaluate(expression, scope, report);
    };
    match default {
        Some(ValueKind::Word) => Some(Typed::word(word, expression.span())),
        None if nearest(word, scope.all_names()).is_none() => Some(Typed::word(word, expression.span())),
        _ => value::evaluate(expression, scope, report),
    }
}

/// A layer's names: its file's and parameters, the scenario's variations and its own `let`.
fn layer_scope<'a>(
    layer: Layer<'a, ast::ScenarioBlock>,
    varied: &HashMap<String, Binding>,
    report: &mut Vec<Diagnostic>,
) -> NameScope<'a> {
    let mut scope = NameScope { outer: Some(layer.scope), names: varied.clone(), member: None };
    for binding in layer.block.bindings() {
        crate::texts::bind(binding, &mut scope, report);
    }
    scope
}

fn scenario_road(
    chain: &[NameDefinition],
    layers: &[Layer<ast::ScenarioBlock>],
    name: ast::Name,
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<DeclaredRoad> {
    let chosen = chain
        .iter()
        .zip(layers)
        .rev()
        .find_map(|(definition, layer)| Some((definition.file, layer.scope, layer.block.road()?)));
    let Some((file, scope, choice)) = chosen else {
        let what = format!("scenario `{}`", name.text());
        missing::<ast::RoadChoice>(layers, name.span(), &what, report);
        return None;
    };
    if let Some(block) = choice.block() {
        let found = road("", choice.span(), block, scope, places, written, report);
        return refuse_upper(found, choice.span(), report);
    }
    let wanted = choice.name()?;
    let names: &Names = places.files.names(file);
    let Some(found) = names.roads.get(wanted.text()) else {
        report.push(
            Diagnostic::new(
                Code::UnknownRoad,
                wanted.span(),
                format!("there is no road `{}`", wanted.text()),
            )
            .label("not defined in this file or one it uses")
            .suggest(wanted.text(), names.roads.keys().map(String::as_str)),
        );
        return None;
    };
    let found = defined_road(*found, places, written, report);
    refuse_upper(found, wanted.span(), report)
}

/// A scenario's own road lies on the ground.
fn refuse_upper(
    found: Option<DeclaredRoad>,
    chosen: Span,
    report: &mut Vec<Diagnostic>,
) -> Option<DeclaredRoad> {
    let found = found?;
    if let Some(over) = &found.over {
        report.push(lies_over_another(&found.road.name, &over.under, chosen));
        return None;
    }
    Some(found)
}

fn is_stream(layers: &[Layer<ast::VehicleBlock>]) -> bool {
    layers.last().is_some_and(|layer| layer.block.is_of_stream())
}

fn declared<'v>(vehicles: &'v [(Span, Vehicle)], name: ast::Name) -> Option<&'v Vehicle> {
    vehicles.iter().map(|(_, vehicle)| vehicle).find(|vehicle| vehicle.name == name.text())
}

/// What all vehicles are called, those of streams too.
fn drivers(
    groups: &[Group<ast::VehicleBlock>],
    vehicles: &[(Span, Vehicle)],
    horizon: Option<f64>,
) -> Vec<String> {
    let names = groups.iter().map(|(name, layers)| match is_stream(layers) {
        true => stream::members(name.text(), declared(vehicles, *name), horizon),
        false => vec![name.text().to_string()],
    });
    names.flatten().collect()
}

type Group<'a, B> = (ast::Name<'a>, Vec<Layer<'a, B>>);

/// Road users by name, in order of first mention, each with what every layer says about it.
fn grouped<'a, B>(
    layers: &[Layer<'a, ast::ScenarioBlock<'a>>],
    users: impl Fn(ast::ScenarioBlock<'a>) -> Vec<(ast::Name<'a>, B)>,
    report: &mut Vec<Diagnostic>,
) -> Vec<Group<'a, B>> {
    let mut groups: Vec<Group<'a, B>> = Vec::new();
    for layer in layers {
        let mut said: HashMap<&str, Span> = HashMap::new();
        for (name, block) in users(layer.block) {
            if let Some(first) = said.insert(name.text(), name.span()) {
                report.push(duplicate(name, first));
                continue;
            }
            let statement = Layer { block, scope: layer.scope };
            match groups.iter_mut().find(|(known, _)| known.text() == name.text()) {
                Some((_, layers)) => layers.push(statement),
                None => groups.push((name, vec![statement])),
            }
        }
    }
    groups
}

fn duplicate(name: ast::Name, first: Span) -> Diagnostic {
    Diagnostic::new(Code::DuplicateName, name.span(), format!("`{}` is defined twice", name.text()))
        .label("defined again")
        .context(first, "defined first here")
        .hint("give one of them another name")
}

fn reject_shared_names<V, P>(vehicles: &[Group<V>], pedestrians: &[Group<P>], report: &mut Vec<Diagnostic>) {
    for (name, _) in pedestrians {
        if let Some((first, _)) = vehicles.iter().find(|(vehicle, _)| vehicle.text() == name.text()) {
            report.push(duplicate(*name, first.span()));
        }
    }
}

/// Whether they are somebody else in every run.
fn draws_person(person: &DeclaredPedestrian) -> bool {
    person.individuals.as_ref().is_some_and(|individuals| individuals.selection == PopulationShare::Drawn)
}

fn nobody(name: ast::Name, cast: &Cast, roads_cross: bool, report: &mut Vec<Diagnostic>) {
    let lacks = match (cast.vehicles.is_empty(), cast.pedestrians.is_empty()) {
        (false, false) => return,
        // Where roads cross vehicles meet each other.
        (false, true) if roads_cross && cast.vehicles.len() > 1 => return,
        (true, true) => "neither vehicle nor pedestrian",
        (true, false) => "no vehicle",
        (false, true) => "no pedestrian",
    };
    report.push(
        Diagnostic::new(Code::NobodyThere, name.span(), format!("scenario `{}` has {lacks}", name.text()))
            .label(format!("has {lacks}"))
            .hint("add `vehicle NAME { … }` and `pedestrian NAME { … }`"),
    );
}

/// Warns of names without effect in the scenario's own block.
fn unused(
    layers: &[Layer<ast::ScenarioBlock>],
    varied: &HashMap<String, Binding>,
    variations: &[Variation],
    used: &HashSet<&str>,
    report: &mut Vec<Diagnostic>,
) {
    let Some(own) = layers.last() else { return };
    for name in own.block.bindings().map(ast::Binding::name) {
        if own.scope.names.get(name.text()).is_some_and(|found| !found.used.get()) {
            report.push(
                Diagnostic::new(Code::UnusedName, name.span(), format!("`{}` is never used", name.text()))
                    .label("not used in this scenario")
                    .hint("remove it, or use it")
                    .remedy(Remedy::Remove),
            );
        }
    }
    for variation in variations {
        let (Variation::Grid { names, .. } | Variation::Sampled { names, .. }) = variation;
        for name in names {
            let Some(binding) = varied.get(name).filter(|_| !used.contains(name.as_str())) else { continue };
            if binding.span.source == own.block.span().source {
                report.push(
                    Diagnostic::new(
                        Code::UnusedName,
                        binding.span,
                        format!("varying `{name}` changes nothing"),
                    )
                    .label("no road user and no bound depends on it")
                    .hint("use it in a value, or use `repeat` for more runs"),
                );
            }
        }
    }
}

/// What road users do with, and what criteria compare to.
fn used_variables<'a>(
    (bend, ground, signal): (
        Option<&'a DeclaredBend>,
        Option<&'a DeclaredGround>,
        Option<&'a DeclaredSignal>,
    ),
    vehicles: &'a [Vehicle],
    pedestrians: &'a [DeclaredPedestrian],
    criteria: &'a [Criterion],
) -> HashSet<&'a str> {
    let mut expressions: Vec<&Expression> = criteria.iter().flat_map(|one| one.claim.bounds()).collect();
    let users = vehicles.iter().flat_map(Vehicle::expressions);
    let users = users.chain(pedestrians.iter().flat_map(DeclaredPedestrian::expressions));
    let users = users.chain(bend.into_iter().flat_map(DeclaredBend::expressions));
    let users = users.chain(ground.into_iter().flat_map(DeclaredGround::expressions));
    let users = users.chain(signal.into_iter().flat_map(DeclaredSignal::expressions));
    expressions.extend(users.map(|(expression, _)| expression));
    let cars = vehicles.iter().flat_map(|vehicle| {
        let dynamics = vehicle.dynamics.as_ref().and_then(|model| model.varied_by.as_deref());
        [vehicle.controller.varied_by.as_deref(), dynamics]
    });
    let people = pedestrians.iter().map(|pedestrian| pedestrian.model.varied_by.as_deref());
    let chosen = cars.chain(people).flatten();
    expressions.into_iter().flat_map(Expression::variables).chain(chosen).collect()
}

/// The text of a scenario without variations, in the one style. `expect` are criteria in the language's words, which
/// stand in place of the scenario's own; `remarks` are comments above it. What it uses is named from `folder`, in which it will lie.
///
/// # Panics
/// If a value depends on a variation.
pub fn write_scenario(scenario: &Scenario, expect: &[String], remarks: &[String], folder: &Path) -> String {
    assert!(scenario.variations.is_empty(), "variations are put in before a scenario is written");
    let mut out = BlockText::default();
    for remark in remarks {
        out.line(format!("# {remark}").trim_end());
    }
    let programs = scenario.vehicles.iter().filter_map(|car| car.controller.first.known()?.program.as_ref());
    let files: BTreeSet<&str> = programs.map(|program| program.file.as_str()).collect();
    for file in files {
        let named = ::files::relative(Path::new(file), folder).display().to_string().replace('\\', "/");
        out.line(&format!("use {}", quoted(&named)));
    }
    let (bend, ground, signal) = (scenario.bend.as_ref(), scenario.ground.as_ref(), scenario.signal.as_ref());
    let parts = (bend, ground, signal);
    if !scenario.other_roads.is_empty() {
        // One lies over the other by its name.
        write_road((&scenario.road, true), parts, &scenario.other_crossings, &mut out);
        let below = &scenario.road.name;
        scenario.other_roads.iter().for_each(|other| write_other_road(other, below, &mut out));
    }
    out.open(&format!("scenario {}", scenario.name));
    if let Some(doc) = &scenario.doc {
        out.line(&quoted(doc));
    }
    if !scenario.tags.is_empty() {
        out.line(&format!("tags {}", scenario.tags.join(", ")));
    }
    match scenario.other_roads.is_empty() {
        true => write_road((&scenario.road, false), parts, &scenario.other_crossings, &mut out),
        false => out.line(&format!("road {}", scenario.road.name)),
    }
    if scenario.step != Defaults::STEP {
        out.line(&format!("step {}", quantity(scenario.step, Dimension::TIME)));
    }
    if scenario.horizon != Defaults::HORIZON {
        out.line(&format!("horizon {}", quantity(scenario.horizon, Dimension::TIME)));
    }
    if scenario.finish != Defaults::FINISH {
        out.line(&format!("finish {}", quantity(scenario.finish, Dimension::LENGTH)));
    }
    if scenario.end_on_collision {
        out.line("end on collision");
    }
    match &scenario.runs {
        Some(runs) => out.line(&format!("runs {} .. {}", runs.least, runs.most)),
        None if scenario.repeat != Defaults::REPEAT => out.line(&format!("repeat {}", scenario.repeat)),
        None => {}
    }
    if let Some(seed) = scenario.seed {
        out.line(&format!("seed {seed}"));
    }
    scenario.vehicles.iter().for_each(|car| write_vehicle(car, &mut out));
    scenario.pedestrians.iter().for_each(|person| write_pedestrian(person, &mut out));
    if !expect.is_empty() {
        out.open("expect");
        expect.iter().for_each(|criterion| out.line(criterion));
        out.close();
    }
    out.close();
    out.text
}
