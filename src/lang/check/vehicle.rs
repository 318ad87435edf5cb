//! `vehicle NAME { … }`

use super::block::{Layer, Said, exclude, last, missing, reject_repeats};
use super::book::Book;
use super::model::{self, Named, named};
use super::places::TextPlaces;
use super::same_as::{SameAs, same_as};
use super::stream::{self, Repeated, write_arrivals};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings::{self, not_whole};
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{self, NameScope, Typed, ValueKind};
use crate::write::{BlockText, constant, model_text, settings_text};
use scenario::{
    CommandKind, ControllerModel, DeclaredFollowing, DeclaredOtherRoad, DeclaredVehicleStart, Dimension,
    DynamicsModel, Model, Reference, Road, Vehicle, limits,
};

/// The vehicle that `layers` describe together, the last having the last word.
pub fn vehicle(
    (name, layers): (ast::Name, &[Layer<ast::VehicleBlock>]),
    roads: (Option<&Road>, &[DeclaredOtherRoad]),
    repeated: &Repeated,
    places: &TextPlaces,
    written: &mut Book,
    alike: &mut Vec<SameAs>,
    report: &mut Vec<Diagnostic>,
) -> Option<Vehicle> {
    if let Some(layer) = layers.last() {
        reject_repeats(*layer.block, report);
        exclude(layer.block.obeys().map(|said| *said), layer.block.ignores().map(|said| *said), report);
    }
    let is_stream = layers.last().is_some_and(|layer| layer.block.is_of_stream());
    let what = format!("{} `{}`", if is_stream { "stream" } else { "vehicle" }, name.text());
    let controller = match last(layers, |block| block.controller().map(ast::Named::Controller)) {
        Some(said) => named(said, &controllers(places), places, report)
            .filter(|found| is_visible(found, places, report)),
        None => {
            missing::<ast::Controller>(layers, name.span(), &what, report);
            None
        }
    };
    let controller = match places.files.tested().find(|(node, _)| node.vehicle().name().text() == name.text())
    {
        Some((node, scope)) => controller.and_then(|own| instead(own, name, node, scope, places, report)),
        None => controller,
    };
    let dynamics = last(layers, |block| block.dynamics().map(ast::Named::Dynamics))
        .map(|said| named(said, &all_dynamics(places), places, report));
    if let (Some(controller), Some(Some(dynamics))) = (&controller, &dynamics) {
        check_fit(controller, dynamics, places, report);
    }
    let size = last(layers, ast::VehicleBlock::size).map(|said| size(said, "a vehicle", report));
    let speed_within = |node, what: &str, scope, report: &mut Vec<Diagnostic>| {
        value::quantity_within(node, limits::VEHICLE_SPEED, what, scope, report)
    };
    let said_speed = last(layers, ast::VehicleBlock::speed);
    let initial_speed = said_speed.and_then(|Said { node, scope }| {
        let value = node.initial()?.value();
        Some(speed_within(value, "the speed of a vehicle at the start", scope, report))
    });
    let speed = match said_speed {
        Some(Said { node, scope }) => speed_within(node.value(), "the speed of a vehicle", scope, report),
        None => {
            missing::<ast::Speed>(layers, name.span(), &what, report);
            None
        }
    };
    let driven = driven_on(layers, roads);
    let lane = match last(layers, ast::VehicleBlock::lane) {
        Some(said) => lane(said, driven.as_ref().map(|(road, _)| *road), report),
        None => Some(0),
    };
    let start = match last(layers, ast::VehicleBlock::start) {
        _ if is_stream => stream::arrivals(name, layers, repeated, places, written, report)
            .map(|stream| (DeclaredVehicleStart::Stream(stream), None)),
        Some(said) => start(said, (name, driven.as_ref().map(|(_, name)| name.as_deref())), report),
        None => Some((DeclaredVehicleStart::Automatic, None)),
    };
    let follows = match last(layers, ast::VehicleBlock::follows) {
        Some(said) => follows(said, name.text(), places, written, report),
        None => Some(DeclaredFollowing::Centre),
    };
    let obeys = last(layers, ast::VehicleBlock::signals).map(|said| {
        written.said(name.text(), "signals", said.node.span(), places);
        said.node.is_obeyed()
    });
    let sees = last(layers, ast::VehicleBlock::sees).map(|Said { node, scope }| {
        let perception = places.files.registry.perception();
        let given = settings::check(Some(node.settings()), &perception.declaration, scope, report);
        written.settings(name.text(), "sees", &given, places);
        Model {
            first: Reference::from(perception),
            varied_by: None,
            varied: Vec::new(),
            others: Vec::new(),
            settings: given.into_iter().map(|(name, typed)| (name, typed.expression)).collect(),
            origin: places.origin(node.span()),
        }
    });
    alike.extend(controller.iter().flat_map(same_as));
    for (part, given) in [
        ("controller", controller.as_ref().map(|named| &named.given)),
        ("dynamics", dynamics.iter().flatten().map(|named| &named.given).next()),
    ] {
        written.settings(name.text(), part, given.map_or(&[], Vec::as_slice), places);
    }
    let initial = initial_speed.as_ref().and_then(Option::as_ref);
    written.statement(name.text(), "initial_speed", initial, places);
    let said = [("speed", speed.as_ref()), ("start", start.as_ref().and_then(|(_, typed)| typed.as_ref()))];
    for (statement, typed) in said {
        written.statement(name.text(), statement, typed, places);
    }
    if let Some(Some((length, width))) = &size {
        written.statement(name.text(), "length", Some(length), places);
        written.statement(name.text(), "width", Some(width), places);
    }
    Some(Vehicle {
        name: name.text().to_string(),
        controller: controller?.model,
        dynamics: match dynamics {
            Some(dynamics) => Some(dynamics?.model),
            None => None,
        },
        size: match size {
            Some(size) => {
                let (length, width) = size?;
                Some((length.expression, width.expression))
            }
            None => None,
        },
        speed: speed?.expression,
        initial_speed: match initial_speed {
            Some(initial) => Some(initial?.expression),
            None => None,
        },
        start: start?.0,
        road: driven.and_then(|(_, name)| name),
        lane: lane?,
        follows: follows?,
        sees,
        obeys_signals: obeys,
        ignores_vehicles: last(layers, ast::VehicleBlock::ignores_vehicles).is_some(),
        origin: places.origin(name.span()),
    })
}

/// The road that it drives on, where that is known, and the road's name if it lies over another.
fn driven_on<'a>(
    layers: &[Layer<ast::VehicleBlock>],
    (main, others): (Option<&'a Road>, &'a [DeclaredOtherRoad]),
) -> Option<(&'a Road, Option<String>)> {
    let Some(said) = last(layers, ast::VehicleBlock::on) else { return main.map(|main| (main, None)) };
    let name = said.node.name().text();
    match others.iter().find(|other| other.road.name == name) {
        Some(other) => Some((&other.road, Some(name.to_string()))),
        None => main.filter(|main| main.name == name).map(|main| (main, None)),
    }
}

/// Which point of it follows the lane.
fn follows(
    said: Said<ast::Follows>,
    name: &str,
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<DeclaredFollowing> {
    let Some(behind) = said.node.behind() else { return Some(DeclaredFollowing::RearAxle) };
    let what = "what follows the lane, as a distance behind the centre of a vehicle,";
    let behind = value::quantity_within(behind, limits::BEHIND, what, said.scope, report)?;
    written.statement(name, "follows", Some(&behind), places);
    Some(DeclaredFollowing::Behind(behind.expression))
}

fn controllers<'a>(places: &'a TextPlaces) -> model::ModelKind<'a, ControllerModel> {
    model::ModelKind {
        code: Code::UnknownController,
        what: "controller",
        there_is_no: "there is no controller",
        all: places.files.registry.controllers(),
    }
}

/// What `test … as` puts in the place of the vehicle's own controller, which has to be right all the same.
fn instead<'a>(
    own: Named<ControllerModel>,
    vehicle: ast::Name,
    node: ast::Tested<'a>,
    scope: &'a NameScope<'a>,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Named<ControllerModel>> {
    if let Some(variation) = &own.model.varied_by {
        // Every name of a trial would say which controller drove it, and none of them did.
        report.push(
            Diagnostic::new(
                Code::NotTested,
                node.span(),
                format!("the variation `{variation}` chooses the controller of `{}`", vehicle.text()),
            )
            .label("would drive under the names of others")
            .context(own.span, "chosen here")
            .hint(format!("set the variation instead: `--set {variation}={}`", node.name().text())),
        );
        return None;
    }
    let names = own.found.iter().map(|found| found.declaration.name.to_string());
    places.files.tests.replaced().entry(vehicle.text().to_string()).or_default().extend(names);
    named(Said { node: ast::Named::Tested(node), scope }, &controllers(places), places, report)
        .filter(|found| is_visible(found, places, report))
}

/// Whether a controller that some file declares is one that the file sees which names it; those that a variation lists may come
/// from wherever that stands.
fn is_visible(named: &Named<ControllerModel>, places: &TextPlaces, report: &mut Vec<Diagnostic>) -> bool {
    let own = named.found.first().and_then(|found| found.program.as_ref());
    let Some(program) = own.filter(|_| named.model.varied_by.is_none()) else { return true };
    let files = places.files;
    let file = files.ids().find(|file| files.tree(*file).source == named.span.source);
    if file.is_none_or(|file| files.names(file).controllers.contains_key(&program.name)) {
        return true;
    }
    report.push(
        Diagnostic::new(
            Code::UnknownController,
            named.span,
            format!("this file knows no controller `{}`", program.name),
        )
        .label("declared in a file that this one does not use")
        .hint(format!("add `use` with the path to {}", program.file)),
    );
    false
}

fn all_dynamics<'a>(places: &'a TextPlaces) -> model::ModelKind<'a, DynamicsModel> {
    model::ModelKind {
        code: Code::UnknownDynamics,
        what: "dynamics",
        there_is_no: "there are no vehicle dynamics",
        all: places.files.registry.dynamics(),
    }
}

/// Of what varies, every combination must fit; where both vary they may go together, which the plan sees.
fn check_fit(
    controllers: &Named<ControllerModel>,
    dynamics: &Named<DynamicsModel>,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) {
    if controllers.model.varied_by.is_some() && dynamics.model.varied_by.is_some() {
        return;
    }
    let pairs = controllers.found.iter().flat_map(|one| dynamics.found.iter().map(move |other| (one, other)));
    let Some((controller, unfit)) = pairs.into_iter().find(|(one, other)| !other.takes.contains(&one.gives))
    else {
        return;
    };
    let words = |kind: CommandKind| match kind {
        CommandKind::Pedals => "pedals",
        CommandKind::Acceleration => "an acceleration",
    };
    let fitting = places
        .files
        .registry
        .dynamics()
        .iter()
        .filter(|known| known.takes.contains(&controller.gives))
        .map(|known| format!("`{}`", known.declaration.name))
        .collect::<Vec<_>>();
    report.push(
        Diagnostic::new(
            Code::DoesNotFit,
            dynamics.span,
            format!(
                "dynamics `{}` do not take {}, which is what controller `{}` gives",
                unfit.declaration.name,
                words(controller.gives),
                controller.declaration.name
            ),
        )
        .label("do not fit the controller")
        .hint(format!("fitting are {}", fitting.join(", "))),
    );
}

/// `size LENGTH x WIDTH`
pub fn size(said: Said<ast::Size>, whose: &str, report: &mut Vec<Diagnostic>) -> Option<(Typed, Typed)> {
    let mut extents = said.node.extents();
    let mut extent = |word: &str| {
        let node = extents.next()?;
        let what = format!("the {word} of {whose}");
        value::quantity_within(node, limits::SIZE, &what, said.scope, report)
    };
    let (length, width) = (extent("length"), extent("width"));
    Some((length?, width?))
}

fn lane(said: Said<ast::Lane>, road: Option<&Road>, report: &mut Vec<Diagnostic>) -> Option<usize> {
    let node = said.node.value();
    let value = value::quantity_of(node, Dimension::NUMBER, "the lane of a vehicle", said.scope, report)?;
    let Some(number) = value.as_constant_number() else {
        return value::not_constant(value.span, &value.expression, "the lane of a vehicle", report);
    };
    if number.fract() != 0.0 {
        report.push(not_whole(node.span(), "the lane of a vehicle", number));
        return None;
    }
    let lanes = road?.lanes.len();
    if !(0.0..lanes as f64).contains(&number) {
        let count =
            if lanes == 1 { "one lane, lane 0".to_string() } else { format!("lanes 0 .. {}", lanes - 1) };
        report.push(
            Diagnostic::new(Code::NoSuchLane, node.span(), format!("the road has no lane {number}"))
                .label("no such lane")
                .hint(format!("the road has {count}")),
        );
        return None;
    }
    Some(number as usize)
}

/// The unit says whether a start is a place or an arrival time.
fn start(
    said: Said<ast::VehicleStart>,
    (vehicle, driven): (ast::Name, Option<Option<&str>>),
    report: &mut Vec<Diagnostic>,
) -> Option<(DeclaredVehicleStart, Option<Typed>)> {
    let node = said.node.value();
    // Of a road that was not found nobody knows.
    if let Some(elsewhere) = driven.filter(|found| said.node.is_before_junction() != found.is_some()) {
        let (message, label, hint) = match elsewhere {
            Some(road) => (
                format!("`{}` drives on `{road}`, where there is no crossing", vehicle.text()),
                "no crossing on this road",
                "say `start 40 m before junction`, which is where the two roads meet",
            ),
            None => (
                format!(
                    "`{}` drives on the road of the scenario, where places are counted from its crossing",
                    vehicle.text()
                ),
                "not on a road that lies over another",
                "say `start 40 m before crossing`, or let it drive `on` the other road",
            ),
        };
        report.push(Diagnostic::new(Code::WrongRoad, said.node.span(), message).label(label).hint(hint));
        return None;
    }
    let value = value::evaluate(node, said.scope, report)?;
    let what = "the start of a vehicle";
    match value.kind {
        ValueKind::Number(Dimension::LENGTH) => {
            let value = value::quantity_within(node, limits::VEHICLE_START, what, said.scope, report)?;
            Some((DeclaredVehicleStart::Distance(value.expression.clone()), Some(value)))
        }
        ValueKind::Number(Dimension::TIME) => {
            let value = value::quantity_within(node, limits::VEHICLE_ARRIVAL, what, said.scope, report)?;
            Some((DeclaredVehicleStart::TimeToArrival(value.expression.clone()), Some(value)))
        }
        _ => {
            let code = match value.kind {
                ValueKind::Number(Dimension::NUMBER) => Code::MissingUnit,
                ValueKind::Number(_) => Code::WrongDimension,
                _ => Code::WrongType,
            };
            report.push(
                Diagnostic::new(
                    code,
                    value.span,
                    format!("the start of a vehicle is a length or a time, not {}", value.kind.name()),
                )
                .label(format!("this is {}", value.kind.name()))
                .hint("write `start 80 m before crossing` or `start 6 s before crossing`"),
            );
            None
        }
    }
}

/// Reports vehicles that nothing gives a place.
pub fn check_starts(
    vehicles: &[(Span, Vehicle)],
    awaited: impl Fn(&str) -> bool,
    report: &mut Vec<Diagnostic>,
) {
    for (span, vehicle) in vehicles {
        if vehicle.start == DeclaredVehicleStart::Automatic && !awaited(&vehicle.name) {
            report.push(
                Diagnostic::new(
                    Code::NoStart,
                    *span,
                    format!("nothing says where vehicle `{}` starts", vehicle.name),
                )
                .label("has no start")
                .hint("give it `start 80 m before crossing` or `start 6 s before crossing`")
                .hint(format!(
                    "or let a pedestrian say `appears when time_to_arrival({}) = 6 s`",
                    vehicle.name
                )),
            );
        }
    }
}

/// What is said of somebody and signals.
pub fn write_signals(obeys: Option<bool>, out: &mut BlockText) {
    match obeys {
        None => {}
        Some(true) => out.line("obeys signals"),
        Some(false) => out.line("ignores signals"),
    }
}

/// The block that says it, whose values are all constants.
pub fn write_vehicle(car: &Vehicle, out: &mut BlockText) {
    let length = |expression| constant(expression, Dimension::LENGTH);
    let kind = if matches!(car.start, DeclaredVehicleStart::Stream(_)) { "stream" } else { "vehicle" };
    out.open(&format!("{kind} {}", car.name));
    out.line(&format!("controller {}", model_text(&car.controller)));
    if let Some(chosen) = &car.dynamics {
        out.line(&format!("dynamics {}", model_text(chosen)));
    }
    if let Some((long, wide)) = &car.size {
        out.line(&format!("size {} x {}", length(long), length(wide)));
    }
    let speed = |expression| constant(expression, Dimension::SPEED);
    let initial =
        car.initial_speed.as_ref().map_or_else(String::new, |from| format!(" from {}", speed(from)));
    out.line(&format!("speed {}{initial}", speed(&car.speed)));
    if let Some(road) = &car.road {
        out.line(&format!("on {road}"));
    }
    let origin = if car.road.is_some() { "junction" } else { "crossing" };
    if car.lane != 0 {
        out.line(&format!("lane {}", car.lane));
    }
    match &car.start {
        DeclaredVehicleStart::Automatic => {}
        DeclaredVehicleStart::Distance(distance) => {
            out.line(&format!("start {} before {origin}", length(distance)));
        }
        DeclaredVehicleStart::TimeToArrival(time) => {
            out.line(&format!("start {} before {origin}", constant(time, Dimension::TIME)));
        }
        DeclaredVehicleStart::Stream(stream) => write_arrivals(stream, out),
    }
    match &car.follows {
        DeclaredFollowing::Centre => {}
        DeclaredFollowing::RearAxle => out.line("follows by rear axle"),
        DeclaredFollowing::Behind(behind) => {
            out.line(&format!("follows by rear axle {} behind centre", length(behind)));
        }
    }
    write_signals(car.obeys_signals, out);
    if car.ignores_vehicles {
        out.line("ignores vehicles");
    }
    if let Some(sees) = &car.sees {
        out.line(&format!("sees {{ {} }}", settings_text(sees)));
    }
    out.close();
}
