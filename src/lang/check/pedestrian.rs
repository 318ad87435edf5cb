//! `pedestrian NAME { … }`

use std::sync::Arc;

use super::block::{Layer, Said, exclude, last, missing, reject_repeats};
use super::book::Book;
use super::defaults::Defaults;
use super::literal;
use super::model::{ModelKind, named};
use super::places::TextPlaces;
use super::vehicle::{size, write_signals};
use super::way::Way;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings::repeated;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{self, Typed};
use crate::write::{BlockText, constant, is_name, model_text, number_of, quantity, quoted};
use scenario::{
    BinaryOperator, DeclaredAppearance, DeclaredMayGo, DeclaredPedestrian, DeclaredShape, Dimension,
    Expression, Individuals, Membership, PedestrianModel, PopulationShare, Road, RoadUserKind, Side, Value,
    VehicleReference, WalksAlong, limits, show,
};

/// Whom a block describes.
#[derive(Debug)]
pub struct Described {
    pub name: String,
    /// Whether they walk or ride.
    pub kind: RoadUserKind,
    /// Where they are named.
    pub span: Span,
    pub group: Option<Membership>,
}

/// The pedestrian that `layers` describe together, the last having the last word.
pub fn pedestrian(
    who: &Described,
    layers: &[Layer<ast::PedestrianBlock>],
    road: Option<&Road>,
    vehicles: &[&str],
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<DeclaredPedestrian> {
    if let Some(layer) = layers.last() {
        let block = layer.block;
        reject_repeats(*block, report);
        exclude(block.size().map(|size| *size), block.radius().map(|radius| *radius), report);
        let mut people = [false, true].map(|one| block.people().find(|people| people.is_one() == one));
        let [several, one] = people.each_mut().map(|people| people.take().map(|people| *people));
        exclude(several, one, report);
        exclude(block.appears().map(|said| *said), block.meets().map(|said| *said), report);
        exclude(block.looks().map(|said| *said), block.may_go().map(|said| *said), report);
        exclude(block.obeys().map(|said| *said), block.ignores().map(|said| *said), report);
    }
    let what = format!(
        "{} `{}`",
        who.kind.word(),
        who.group.as_ref().map_or(&who.name, |membership| &membership.group)
    );
    let model = match last(layers, |block| block.model().map(ast::Named::Model)) {
        Some(said) => named(said, &models(places), places, report),
        None => {
            missing::<ast::Model>(layers, who.span, &what, report);
            None
        }
    };
    let found = model.as_ref().map_or(&[] as &[_], |model| &model.found);
    let individuals =
        last(layers, |block| block.people().next()).map(|said| individuals(said, found, places, report));
    let shape =
        last(layers, ast::PedestrianBlock::shape).map(|said| shape(said, &who.name, places, written, report));
    let side = match last(layers, ast::PedestrianBlock::side) {
        Some(said) if said.node.is_far() => Side::Far,
        _ => Side::Near,
    };
    let crosses = match last(layers, ast::PedestrianBlock::crosses) {
        Some(said) => road.and_then(|road| crosses(said, road, report)).map(Some),
        None => Some(None),
    };
    let waits = last(layers, ast::PedestrianBlock::waits);
    if let Some(waits) = waits {
        waits_on_refuges(waits, found, road, places, report)?;
    }
    let way = Way::of(layers);
    let fits = way.check(report);
    let start = match last(layers, ast::PedestrianBlock::start) {
        _ if !way.needs_start() => Some(Expression::number(0.0)),
        Some(said) => road.and_then(|road| {
            let (start, typed, offset) = start(said, road, report)?;
            written.shifted(&who.name, "start", &typed, offset, places);
            Some(start)
        }),
        None => {
            missing::<ast::PedestrianStart>(layers, who.span, &what, report);
            None
        }
    };
    let mut length = |said, default: f64, limit, key: &str, word: &str| match said {
        Some(Said { node, scope }) => {
            let value = value::quantity_within(node, limit, word, scope, report)?;
            written.statement(&who.name, key, Some(&value), places);
            Some(value.expression)
        }
        None => Some(Expression::number(default)),
    };
    let what = "the place of a pedestrian along the road";
    let said = last(layers, |block| block.along().map(ast::Along::value));
    let along = length(said, 0.0, limits::ALONG, "along", what);
    let said = way.goal.map(|Said { node, scope }| Said { node: node.value(), scope });
    let (limit, default) = match way.walks {
        None => (limits::GOAL, Defaults::GOAL),
        Some(_) => (limits::FURTHER, 0.0),
    };
    let goal = length(said, default, limit, "goal", "the goal of a pedestrian");
    let appears = match last(layers, ast::PedestrianBlock::appearance) {
        Some(Said { node: ast::Appearance::Appears(node), scope }) => {
            appears(Said { node, scope }, vehicles, report).map(|(appears, typed)| {
                written.statement(&who.name, "appears", Some(&typed), places);
                appears
            })
        }
        Some(Said { node: ast::Appearance::Meets(node), scope }) => {
            meets(Said { node, scope }, vehicles, report).map(|(meets, share, after)| {
                written.statement(&who.name, "meets", Some(&share), places);
                written.statement(&who.name, "after", after.as_ref(), places);
                meets
            })
        }
        None => Some(DeclaredAppearance::At(Expression::number(0.0))),
    };
    let permission = last(layers, ast::PedestrianBlock::permission);
    if let Some(Said { node: ast::Appearance::Meets(meets), .. }) =
        last(layers, ast::PedestrianBlock::appearance)
    {
        refuse_waiting_to_meet(permission, meets.span(), report);
    }
    let may_go = match permission {
        Some(Said { node: ast::Permission::Looks(node), scope }) => {
            let what = "the time for which a pedestrian looks";
            value::quantity_within(node.time(), limits::LOOKS, what, scope, report).map(|time| {
                written.statement(&who.name, "looks", Some(&time), places);
                DeclaredMayGo::After(time.expression)
            })
        }
        Some(Said { node: ast::Permission::MayGo(node), scope }) => {
            may_go(Said { node, scope }, vehicles, report).map(|(may_go, time, or_after)| {
                written.statement(&who.name, "may_go", Some(&time), places);
                written.statement(&who.name, "or_after", Some(&or_after), places);
                may_go
            })
        }
        None => Some(DeclaredMayGo::AtOnce),
    };
    let turned = match last(layers, ast::PedestrianBlock::turned) {
        Some(said) => turned(said, report).map(|(turned, typed)| {
            written.statement(&who.name, "turned", Some(&typed), places);
            turned
        }),
        None => Some(Expression::number(0.0)),
    };
    let reference = match last(layers, ast::PedestrianBlock::reference) {
        Some(said) => reference(said, report).map(|(reference, typed)| {
            written.statement(&who.name, "reference", Some(&typed), places);
            reference
        }),
        None => Some(Expression::number(unsaid_reference(who.kind, shape.is_some()))),
    };
    let obeys = last(layers, ast::PedestrianBlock::signals).map(|said| {
        written.said(&who.name, "signals", said.node.span(), places);
        said.node.is_obeyed()
    });
    written.settings(&who.name, "model", model.as_ref().map_or(&[], |named| &named.given), places);
    if let (Some(road), Some(start), Some(goal), None) = (road, &start, &goal, way.walks) {
        check_way(start, goal, last(layers, ast::PedestrianBlock::start), road, report)?;
    }
    if !fits {
        return None;
    }
    Some(DeclaredPedestrian {
        name: who.name.clone(),
        kind: who.kind,
        model: model?.model,
        shape: match shape {
            Some(shape) => Some(shape?),
            None => None,
        },
        side,
        start_from_lane_centre: start?,
        crosses: crosses?,
        waits_on_refuges: waits.is_some(),
        along: along?,
        goal_beyond_kerb: if way.walks.is_some() {
            Expression::number(Defaults::GOAL)
        } else {
            goal.clone()?
        },
        turned: turned?,
        walks: match (way.walks, goal) {
            (Some(said), further) => {
                Some(WalksAlong { with_traffic: !said.node.is_against(), further: further? })
            }
            (None, _) => None,
        },
        appears: appears?,
        may_go: may_go?,
        may_start_inside: last(layers, ast::PedestrianBlock::may_start_inside).is_some(),
        reference: reference?,
        individuals: match individuals {
            Some(individuals) => Some(individuals?),
            None => None,
        },
        obeys_signals: obeys,
        group: who.group.clone(),
        origin: places.origin(who.span),
    })
}

/// A pedestrian that is to be hit at a place has to set off when it appears.
fn refuse_waiting_to_meet(
    permission: Option<Said<ast::Permission>>,
    meets: Span,
    report: &mut Vec<Diagnostic>,
) {
    let Some(Said { node, .. }) = permission else { return };
    report.push(
        Diagnostic::new(
            Code::WrongWay,
            node.span(),
            "a pedestrian that meets a vehicle cannot wait before it goes",
        )
        .label("would be too late")
        .context(meets, "says when it has to be there")
        .hint("leave it out, or say `start` and `appears` instead of `meets`"),
    );
}

/// The reference point of whom nothing is said: what is known of the body of a kind is known of no other.
fn unsaid_reference(kind: RoadUserKind, has_shape: bool) -> f64 {
    if has_shape { 0.0 } else { kind.reference() }
}

/// The way from start to goal must lead across the road, as far as both are known already.
fn check_way(
    start: &Expression,
    goal: &Expression,
    said: Option<Said<ast::PedestrianStart>>,
    road: &Road,
    report: &mut Vec<Diagnostic>,
) -> Option<()> {
    let (Expression::Constant(Value::Number(start)), Expression::Constant(Value::Number(goal)), Some(said)) =
        (start, goal, said)
    else {
        return Some(());
    };
    let way = start - road.lane_width / 2.0 + (road.kerb(Side::Far) - road.kerb(Side::Near)) + goal;
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

/// The name of the crossing that a statement names.
fn crosses(said: Said<ast::Crosses>, road: &Road, report: &mut Vec<Diagnostic>) -> Option<String> {
    let name = said.node.name();
    let names = || road.other_crossings.iter().map(|other| other.name.as_str());
    if names().any(|known| known == name.text()) {
        return Some(name.text().to_string());
    }
    let message = format!("the road has no crossing called `{}`", name.text());
    let diagnostic = Diagnostic::new(Code::UnknownCrossing, name.span(), message);
    report.push(match names().next() {
        Some(_) => diagnostic.label("not on this road").suggest(name.text(), names()),
        None => diagnostic
            .label("not on this road")
            .hint("say in the road where it is: `crossing school zebra { at: 40 m }`; the first has no name"),
    });
    None
}

/// Whoever waits on refuges is of a model that can, on a road that has one.
fn waits_on_refuges(
    said: Said<ast::Waits>,
    models: &[Arc<PedestrianModel>],
    road: Option<&Road>,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<()> {
    let mut wrong = |message: String, label: &str, hint: String| {
        report.push(Diagnostic::new(Code::NoRefuge, said.node.span(), message).label(label).hint(hint));
        None
    };
    if let Some(model) = models.iter().find(|model| !model.walks_in_legs) {
        let all = places.files.registry.pedestrians().iter().filter(|known| known.walks_in_legs);
        let able = all.map(|known| format!("`{}`", known.declaration.name)).collect::<Vec<_>>();
        return wrong(
            format!("model `{}` waits on no refuge", model.declaration.name),
            "it walks in one go",
            format!("models that do are {}", able.join(", ")),
        );
    }
    if road.is_some_and(|road| !road.medians.iter().any(|median| median.refuge)) {
        return wrong(
            "the road has no refuge".to_string(),
            "where?",
            "give it one between two lanes: `median 2 m after lane 0 with refuge`".to_string(),
        );
    }
    Some(())
}

fn models<'a>(places: &'a TextPlaces) -> ModelKind<'a, PedestrianModel> {
    ModelKind {
        code: Code::UnknownModel,
        what: "model",
        there_is_no: "there is no pedestrian model",
        all: places.files.registry.pedestrians(),
    }
}

/// The people that a statement takes, who must be of every one of these models.
pub fn individuals(
    said: Said<ast::Individuals>,
    models: &[Arc<PedestrianModel>],
    places: &TextPlaces,
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
        literal::count(node.number()?, 1, 1_000_000, "the number of an individual", report)
    };
    let selection = match node.is_one() {
        true => PopulationShare::Number(number(report)?),
        false if node.are_drawn() => PopulationShare::Drawn,
        false if node.are_all() => PopulationShare::All,
        false => PopulationShare::Count(number(report)?),
    };
    let (population, text) = individuals_of(node.population(), places);
    Some(Individuals { selection, population, text, origin: places.origin(node.span()) })
}

/// What a population is called, with the text of its file.
pub fn individuals_of(
    node: ast::Population,
    places: &TextPlaces,
) -> (String, Option<Result<Arc<str>, String>>) {
    let path = node.path();
    let population = match path {
        Some(path) => places.beside(path.span(), &path.path()),
        None => node.text().to_string(),
    };
    let text = path.map(|_| places.files.text_of(&population, &["csv", "json"]));
    (population, text)
}

fn shape(
    said: Said<ast::Shape>,
    name: &str,
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<DeclaredShape> {
    let scope = said.scope;
    match said.node {
        ast::Shape::Size(node) => {
            let (length, width) = size(Said { node, scope }, "a pedestrian", report)?;
            written.statement(name, "length", Some(&length), places);
            written.statement(name, "width", Some(&width), places);
            Some(DeclaredShape::Rectangle { length: length.expression, width: width.expression })
        }
        ast::Shape::Radius(node) => {
            let what = "the radius of a pedestrian";
            let radius = value::quantity_within(node.value(), limits::RADIUS, what, scope, report)?;
            written.statement(name, "radius", Some(&radius), places);
            Some(DeclaredShape::Disc { radius: radius.expression })
        }
    }
}

/// The distance from the lane's centre, and the one that was written with how much less it is. A second statement of the
/// same place must agree with the first.
fn start(
    said: Said<ast::PedestrianStart>,
    road: &Road,
    report: &mut Vec<Diagnostic>,
) -> Option<(Expression, Typed, f64)> {
    let half = road.lane_width / 2.0;
    let mut distances = Vec::new();
    for distance in said.node.distances() {
        let from_kerb = distance.is_from_kerb();
        let what = "the start of a pedestrian";
        let value =
            value::quantity_within(distance.value(), limits::PEDESTRIAN_START, what, said.scope, report)?;
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
fn agree(
    first: &Expression,
    second: &Expression,
    said: Said<ast::PedestrianStart>,
    report: &mut Vec<Diagnostic>,
) -> Option<bool> {
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
    said: Said<ast::Appears>,
    vehicles: &[&str],
    report: &mut Vec<Diagnostic>,
) -> Option<(DeclaredAppearance, Typed)> {
    let time = |node, limit, what: &str, report: &mut Vec<Diagnostic>| {
        value::quantity_within(node, limit, what, said.scope, report)
    };
    if let Some(at) = said.node.at() {
        let time = time(at.time(), limits::APPEARS_AT, "the time at which a pedestrian appears", report)?;
        return Some((DeclaredAppearance::At(time.expression.clone()), time));
    }
    let when = said.node.when()?;
    let what = "the time to arrival at which a pedestrian appears";
    let time = time(when.time(), limits::APPEARS_WHEN, what, report);
    let (vehicle, reference) = arriving(when, vehicles, report)?;
    let time = time?;
    Some((DeclaredAppearance::TimeToArrival { vehicle, reference, time: time.expression.clone() }, time))
}

/// The vehicle whose arrival is waited for, and its part that arrives.
fn arriving(
    when: ast::AppearsWhen,
    vehicles: &[&str],
    report: &mut Vec<Diagnostic>,
) -> Option<(String, VehicleReference)> {
    let name = when.vehicle();
    if !vehicles.contains(&name.text()) {
        report.push(unknown_vehicle(name, vehicles));
        return None;
    }
    let reference = match when.part() {
        Some(part) if part.is_front() => VehicleReference::Front,
        _ => VehicleReference::Centre,
    };
    Some((name.text().to_string(), reference))
}

/// When a pedestrian that waits for a time to arrival may go.
fn may_go(
    said: Said<ast::MayGo>,
    vehicles: &[&str],
    report: &mut Vec<Diagnostic>,
) -> Option<(DeclaredMayGo, Typed, Typed)> {
    let (when, scope) = (said.node.when(), said.scope);
    let what = "the time to arrival at which a pedestrian may go";
    let time = value::quantity_within(when.time(), limits::MAY_GO_WHEN, what, scope, report);
    let what = "the time after which a pedestrian may go";
    let or_after = value::quantity_within(said.node.or_after().time(), limits::LOOKS, what, scope, report);
    let (vehicle, reference) = arriving(when, vehicles, report)?;
    let (time, or_after) = (time?, or_after?);
    let may_go = DeclaredMayGo::TimeToArrival {
        vehicle,
        reference,
        time: time.expression.clone(),
        or_after: or_after.expression.clone(),
    };
    Some((may_go, time, or_after))
}

/// Where on the vehicle's front it is to be hit.
fn meets(
    said: Said<ast::Meets>,
    vehicles: &[&str],
    report: &mut Vec<Diagnostic>,
) -> Option<(DeclaredAppearance, Typed, Option<Typed>)> {
    let name = said.node.vehicle();
    let what = "the share of the vehicle's width at which a pedestrian meets it";
    let share = value::quantity_within(said.node.share(), limits::MEETS, what, said.scope, report);
    let what = "the way after which a pedestrian is met";
    let after = said
        .node
        .after()
        .map(|after| value::quantity_within(after.way(), limits::FURTHER, what, said.scope, report));
    if !vehicles.contains(&name.text()) {
        report.push(unknown_vehicle(name, vehicles));
        return None;
    }
    let share = share?;
    let after = match after {
        Some(after) => Some(after?),
        None => None,
    };
    let vehicle = name.text().to_string();
    let way = after.as_ref().map(|after| after.expression.clone());
    Some((DeclaredAppearance::Meets { vehicle, share: share.expression.clone(), after: way }, share, after))
}

/// How far ahead of the centre the reference point is.
fn reference(said: Said<ast::ReferencePoint>, report: &mut Vec<Diagnostic>) -> Option<(Expression, Typed)> {
    let what = "the reference point of a pedestrian";
    let value = value::quantity_within(said.node.value(), limits::REFERENCE, what, said.scope, report)?;
    let ahead = if said.node.is_behind() { negated(&value.expression) } else { value.expression.clone() };
    Some((ahead, value))
}

/// How far its way is turned to its left.
fn turned(said: Said<ast::Turned>, report: &mut Vec<Diagnostic>) -> Option<(Expression, Typed)> {
    let what = "the turn of a pedestrian's way";
    let value = value::quantity_within(said.node.value(), limits::TURNED, what, said.scope, report)?;
    let left = if said.node.is_left() { value.expression.clone() } else { negated(&value.expression) };
    Some((left, value))
}

fn negated(expression: &Expression) -> Expression {
    match expression {
        Expression::Constant(Value::Number(number)) => Expression::number(-number),
        expression => Expression::Binary {
            operator: BinaryOperator::Subtract,
            left: Box::new(Expression::number(0.0)),
            right: Box::new(expression.clone()),
        },
    }
}

pub fn unknown_vehicle(name: ast::Name, vehicles: &[&str]) -> Diagnostic {
    Diagnostic::new(
        Code::UnknownVehicle,
        name.span(),
        format!("the scenario has no vehicle `{}`", name.text()),
    )
    .label("unknown vehicle")
    .suggest(name.text(), vehicles.iter().copied())
}

/// The block that says it, whose values are all constants.
pub fn write_pedestrian(person: &DeclaredPedestrian, out: &mut BlockText) {
    let length = |expression| constant(expression, Dimension::LENGTH);
    out.open(&format!("{} {}", person.kind.word(), person.name));
    out.line(&format!("model {}", model_text(&person.model)));
    if let Some(Individuals { selection, population, .. }) = &person.individuals {
        let population = if is_name(population) { population.clone() } else { quoted(population) };
        out.line(&match selection {
            PopulationShare::All => format!("individuals all of {population}"),
            PopulationShare::Drawn => format!("individuals drawn from {population}"),
            PopulationShare::Count(count) => format!("individuals {count} of {population}"),
            PopulationShare::Number(number) => format!("individual {number} of {population}"),
        });
    }
    match &person.shape {
        None => {}
        Some(DeclaredShape::Disc { radius }) => out.line(&format!("radius {}", length(radius))),
        Some(DeclaredShape::Rectangle { length: long, width }) => {
            out.line(&format!("size {} x {}", length(long), length(width)));
        }
    }
    if person.side == Side::Far {
        out.line("from far side");
    }
    let is_met_along = person.walks.is_some() && matches!(person.appears, DeclaredAppearance::Meets { .. });
    if !is_met_along {
        out.line(&format!("start {} from lane centre", length(&person.start_from_lane_centre)));
    }
    if let Some(crossing) = &person.crosses {
        out.line(&format!("crosses {crossing}"));
    }
    if person.waits_on_refuges {
        out.line("waits on refuge");
    }
    if number_of(&person.along) != 0.0 {
        out.line(&format!("along {}", length(&person.along)));
    }
    if let Some(WalksAlong { with_traffic, further }) = &person.walks {
        out.line(&format!("goal {} further", length(further)));
        out.line(&format!("walks {} traffic", if *with_traffic { "with" } else { "against" }));
    } else if number_of(&person.goal_beyond_kerb) != Defaults::GOAL {
        out.line(&format!("goal {} beyond kerb", length(&person.goal_beyond_kerb)));
    }
    match number_of(&person.turned) {
        0.0 => {}
        left => {
            let (angle, side) = (left.abs(), if left > 0.0 { "left" } else { "right" });
            out.line(&format!("turned {} {side}", quantity(angle, Dimension::ANGLE)));
        }
    }
    match &person.appears {
        DeclaredAppearance::At(time) if number_of(time) == 0.0 => {}
        DeclaredAppearance::At(time) => {
            out.line(&format!("appears at {}", constant(time, Dimension::TIME)));
        }
        DeclaredAppearance::TimeToArrival { vehicle, reference, time } => {
            out.line(&format!("appears {}", arrival(vehicle, *reference, time)));
        }
        DeclaredAppearance::Meets { vehicle, share, after } => {
            let after = after.as_ref().map_or_else(String::new, |way| format!(" after {}", length(way)));
            out.line(&format!("meets {vehicle} at {}{after}", constant(share, Dimension::NUMBER)));
        }
    }
    match &person.may_go {
        DeclaredMayGo::AtOnce => {}
        DeclaredMayGo::After(time) => {
            out.line(&format!("looks for {}", constant(time, Dimension::TIME)));
        }
        DeclaredMayGo::TimeToArrival { vehicle, reference, time, or_after } => {
            let or_after = constant(or_after, Dimension::TIME);
            out.line(&format!("may go {}, or after {or_after}", arrival(vehicle, *reference, time)));
        }
    }
    if person.may_start_inside {
        out.line("may start inside");
    }
    match number_of(&person.reference) {
        unsaid if unsaid == unsaid_reference(person.kind, person.shape.is_some()) => {}
        ahead if ahead < 0.0 => {
            let behind = length(&Expression::number(-ahead));
            out.line(&format!("reference {behind} behind centre"));
        }
        _ => out.line(&format!("reference {} ahead of centre", length(&person.reference))),
    }
    write_signals(person.obeys_signals, out);
    out.close();
}

/// `when time_to_arrival(av.front) = 3 s`
fn arrival(vehicle: &str, reference: VehicleReference, time: &Expression) -> String {
    let part = match reference {
        VehicleReference::Centre => "",
        VehicleReference::Front => ".front",
    };
    format!("when time_to_arrival({vehicle}{part}) = {}", constant(time, Dimension::TIME))
}
