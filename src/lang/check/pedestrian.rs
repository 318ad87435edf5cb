//! `pedestrian NAME { … }`

use std::sync::Arc;

use super::block::{Layer, Said, last, last_of, missing, reject_repeats};
use super::model::{Kind, named};
use super::vehicle::size;
use super::{Book, Places};
use crate::lang::codes::Code;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::settings::repeated;
use crate::lang::source::Span;
use crate::lang::tree::{Node, Rule};
use crate::lang::value::{self, Typed, unquote};
use crate::scenario::{
    BinaryOperator, DeclaredAppearance, DeclaredShape, Dimension, Expression, Individuals, Pedestrian,
    PedestrianModel, Population, Road, Side, Value, VehicleReference, limits, show,
};

/// How far beyond the opposite kerb a pedestrian walks unless something else is said, m.
pub const DEFAULT_GOAL: f64 = 2.0;

/// The pedestrian that `layers` describe together, the last having the last word.
pub fn pedestrian(
    name: Node,
    layers: &[Layer],
    road: Option<&Road>,
    vehicles: &[&str],
    places: &Places,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<Pedestrian> {
    if let Some(layer) = layers.last() {
        reject_repeats(layer.block, &[], report);
        exclude(layer.block, Rule::size, Rule::radius, report);
        exclude(layer.block, Rule::individuals, Rule::individual, report);
    }
    let what = format!("pedestrian `{}`", name.text());
    let model = match last(layers, Rule::model) {
        Some(said) => named(said, &models(places), places, report),
        None => {
            missing(layers, name.span(), &what, "model", "model carla_walker", report);
            None
        }
    };
    let found = model.as_ref().map_or(&[] as &[_], |model| &model.found);
    let individuals = last_of(layers, [Rule::individuals, Rule::individual])
        .map(|said| individuals(said, found, places, report));
    let shape = last_of(layers, [Rule::size, Rule::radius])
        .map(|said| shape(said, name.text(), places, written, report));
    let side = match last(layers, Rule::side) {
        Some(said) if said.node.has(Rule::kw_far) => Side::Far,
        _ => Side::Near,
    };
    let start = match last(layers, Rule::pedestrian_start) {
        Some(said) => road.and_then(|road| {
            let (start, typed, offset) = start(said, road, report)?;
            written.shifted(name.text(), "start", &typed, offset, places);
            Some(start)
        }),
        None => {
            missing(layers, name.span(), &what, "start", "start 2 m from kerb", report);
            None
        }
    };
    let mut length = |rule, default: f64, limit, key: &str, word: &str| match last(layers, rule) {
        Some(Said { node, scope }) => {
            let node = node.child(Rule::expression)?;
            let value = value::quantity_within(node, limit, word, scope, report)?;
            written.statement(name.text(), key, Some(&value), places);
            Some(value.expression)
        }
        None => Some(Expression::number(default)),
    };
    let what = "the place of a pedestrian along the road";
    let along = length(Rule::along, 0.0, limits::ALONG, "along", what);
    let goal = length(Rule::goal, DEFAULT_GOAL, limits::GOAL, "goal", "the goal of a pedestrian");
    let appears = match last(layers, Rule::appears) {
        Some(said) => appears(said, vehicles, report).map(|(appears, typed)| {
            written.statement(name.text(), "appears", Some(&typed), places);
            appears
        }),
        None => Some(DeclaredAppearance::At(Expression::number(0.0))),
    };
    written.settings(name.text(), "model", model.as_ref().map_or(&[], |named| &named.given), places);
    if let (Some(road), Some(start), Some(goal)) = (road, &start, &goal) {
        check_way(start, goal, last(layers, Rule::pedestrian_start), road, report)?;
    }
    Some(Pedestrian {
        name: name.text().to_string(),
        model: model?.model,
        shape: match shape {
            Some(shape) => Some(shape?),
            None => None,
        },
        side,
        start_from_lane_centre: start?,
        along: along?,
        goal_beyond_kerb: goal?,
        appears: appears?,
        individuals: match individuals {
            Some(individuals) => Some(individuals?),
            None => None,
        },
        origin: places.origin(name.span()),
    })
}

/// The way from start to goal must lead across the road, as far as both are known already.
fn check_way(
    start: &Expression,
    goal: &Expression,
    said: Option<Said>,
    road: &Road,
    report: &mut Vec<Diagnostic>,
) -> Option<()> {
    let (Expression::Constant(Value::Number(start)), Expression::Constant(Value::Number(goal)), Some(said)) =
        (start, goal, said)
    else {
        return Some(());
    };
    let way = start - road.lane_width / 2.0 + road.lanes.len() as f64 * road.lane_width + goal;
    if way > 0.0 {
        return Some(());
    }
    report.push(
        Diagnostic::new(Code::StartBeyondGoal, said.node.span(), "the pedestrian starts beyond its goal")
            .label(format!("{} beyond it", show(-way, None, Dimension::LENGTH)))
            .hint("a positive distance from the kerb is away from the road"),
    );
    None
}

/// Two statements that say the same thing in different ways cannot stand together.
fn exclude(block: Node, first: Rule, second: Rule, report: &mut Vec<Diagnostic>) {
    if let (Some(first), Some(second)) = (block.child(first), block.child(second)) {
        let word = |node: Node| node.text().split_whitespace().next().unwrap_or_default().to_string();
        let mut diagnostic = repeated(&word(second), second.span(), first.span());
        diagnostic.message = format!("`{}` and `{}` say the same thing", word(first), word(second));
        report.push(diagnostic);
    }
}

fn models<'a>(places: &'a Places) -> Kind<'a, PedestrianModel> {
    Kind {
        code: Code::UnknownModel,
        what: "model",
        there_is_no: "there is no pedestrian model",
        all: places.files.registry.pedestrians(),
    }
}

/// The people that a statement takes, who must be of every one of these models.
pub fn individuals(
    said: Said,
    models: &[Arc<PedestrianModel>],
    places: &Places,
    report: &mut Vec<Diagnostic>,
) -> Option<Individuals> {
    let node = said.node;
    if let Some(model) = models.iter().find(|model| !model.takes_individuals) {
        let able = places
            .files
            .registry
            .pedestrians()
            .iter()
            .filter(|known| known.takes_individuals)
            .map(|known| format!("`{}`", known.declaration.name))
            .collect::<Vec<_>>();
        report.push(
            Diagnostic::new(
                Code::NoIndividuals,
                node.span(),
                format!("model `{}` knows no individuals", model.declaration.name),
            )
            .label("cannot be given")
            .hint(format!("models with individuals are {}", able.join(", "))),
        );
        return None;
    }
    let number = |report: &mut Vec<Diagnostic>| {
        super::count(node.child(Rule::integer)?, 1, 1_000_000, "the number of an individual", report)
    };
    let selection = match node.rule() {
        Rule::individual => Population::Number(number(report)?),
        _ if node.has(Rule::kw_all) => Population::All,
        _ => Population::Count(number(report)?),
    };
    let population = node.child(Rule::population)?;
    let named = unquote(population.text());
    let is_file = population.has(Rule::string);
    let population = if is_file { places.beside(population.span(), &named) } else { named };
    let text = is_file.then(|| places.files.text_of(&population, &["csv", "json"]));
    Some(Individuals { selection, population, text, origin: places.origin(node.span()) })
}

fn shape(
    said: Said,
    name: &str,
    places: &Places,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<DeclaredShape> {
    if said.node.rule() == Rule::size {
        let (length, width) = size(said, "a pedestrian", report)?;
        written.statement(name, "length", Some(&length), places);
        written.statement(name, "width", Some(&width), places);
        return Some(DeclaredShape::Rectangle { length: length.expression, width: width.expression });
    }
    let node = said.node.child(Rule::expression)?;
    let what = "the radius of a pedestrian";
    let radius = value::quantity_within(node, limits::RADIUS, what, said.scope, report)?;
    written.statement(name, "radius", Some(&radius), places);
    Some(DeclaredShape::Disc { radius: radius.expression })
}

/// The distance from the lane's centre, and the one that was written with how much less it is. A second statement of the
/// same place must agree with the first.
fn start(said: Said, road: &Road, report: &mut Vec<Diagnostic>) -> Option<(Expression, Typed, f64)> {
    let half = road.lane_width / 2.0;
    let mut distances = Vec::new();
    for distance in said.node.all(Rule::start_distance) {
        let from_kerb = distance.has(Rule::kw_kerb);
        let what = "the start of a pedestrian";
        let node = distance.child(Rule::expression)?;
        let value = value::quantity_within(node, limits::PEDESTRIAN_START, what, said.scope, report)?;
        distances.push((from_kerb, value, distance.span()));
    }
    let centred = |(from_kerb, value, _): &(bool, Typed, Span)| match (&value.expression, *from_kerb) {
        (expression, false) => expression.clone(),
        (Expression::Constant(Value::Number(number)), true) => Expression::number(number + half),
        (expression, true) => Expression::Binary {
            operator: BinaryOperator::Add,
            left: Box::new(expression.clone()),
            right: Box::new(Expression::number(half)),
        },
    };
    if let [first, second] = distances.as_slice() {
        if first.0 == second.0 {
            report.push(repeated(if first.0 { "from kerb" } else { "from lane centre" }, second.2, first.2));
            return None;
        }
        if !agree(&centred(first), &centred(second), said, report)? {
            report.push(
                Diagnostic::new(
                    Code::StartContradiction,
                    second.2,
                    "the two distances do not describe the same place",
                )
                .label("contradicts the other")
                .context(first.2, "said here")
                .note(format!(
                    "the lane is {} wide, so its centre is {} from the kerb",
                    show(road.lane_width, None, Dimension::LENGTH),
                    show(half, None, Dimension::LENGTH)
                ))
                .hint("give only one of the two"),
            );
            return None;
        }
    }
    // The distance from the lane's centre needs no calculation, so it is the one that counts.
    distances.sort_by_key(|(from_kerb, ..)| *from_kerb);
    let first = distances.first()?;
    Some((centred(first), first.1.clone(), if first.0 { half } else { 0.0 }))
}

/// Whether two ways to say a place agree to a millimetre for every value they can take.
fn agree(first: &Expression, second: &Expression, said: Said, report: &mut Vec<Diagnostic>) -> Option<bool> {
    let difference = Expression::Binary {
        operator: BinaryOperator::Subtract,
        left: Box::new(first.clone()),
        right: Box::new(second.clone()),
    };
    let differences = if difference.variables().is_empty() {
        vec![difference.evaluate(&Default::default()).ok()?]
    } else {
        value::possible(&difference, said.scope).into_iter().map(|(value, _)| value).collect()
    };
    if differences.is_empty() {
        report.push(
            Diagnostic::new(
                Code::NotConstant,
                said.node.span(),
                "whether the two distances describe the same place cannot be checked",
            )
            .label("depends on several or sampled variations")
            .hint("give only one of the two"),
        );
        return None;
    }
    Some(differences.iter().all(|value| value.as_number().is_some_and(|metres| metres.abs() <= 1e-3)))
}

fn appears(
    said: Said,
    vehicles: &[&str],
    report: &mut Vec<Diagnostic>,
) -> Option<(DeclaredAppearance, Typed)> {
    let time = |node: Node, limit, what: &str, report: &mut Vec<Diagnostic>| {
        value::quantity_within(node.child(Rule::expression)?, limit, what, said.scope, report)
    };
    if let Some(at) = said.node.child(Rule::appears_at) {
        let time = time(at, limits::APPEARS_AT, "the time at which a pedestrian appears", report)?;
        return Some((DeclaredAppearance::At(time.expression.clone()), time));
    }
    let when = said.node.child(Rule::appears_when)?;
    let name = when.child(Rule::name)?;
    let what = "the time to arrival at which a pedestrian appears";
    let time = time(when, limits::APPEARS_WHEN, what, report);
    if !vehicles.contains(&name.text()) {
        report.push(unknown_vehicle(name, vehicles));
        return None;
    }
    let reference = match when.child(Rule::vehicle_part) {
        Some(part) if part.text() == "front" => VehicleReference::Front,
        _ => VehicleReference::Centre,
    };
    let time = time?;
    let vehicle = name.text().to_string();
    Some((DeclaredAppearance::TimeToArrival { vehicle, reference, time: time.expression.clone() }, time))
}

pub fn unknown_vehicle(name: Node, vehicles: &[&str]) -> Diagnostic {
    Diagnostic::new(
        Code::UnknownVehicle,
        name.span(),
        format!("the scenario has no vehicle `{}`", name.text()),
    )
    .label("unknown vehicle")
    .suggest(name.text(), vehicles.iter().copied())
}
