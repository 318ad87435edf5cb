//! `vehicle NAME { … }`

use super::Places;
use super::block::{Layer, Said, last, missing, reject_repeats};
use super::model::{Named, Registry, named};
use crate::lang::codes::Code;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::settings::{self, not_whole};
use crate::lang::source::Span;
use crate::lang::tree::{Node, Rule};
use crate::lang::value::{self, Kind};
use crate::scenario::{DeclaredVehicleStart, Dimension, Expression, Model, Road, Vehicle};
use crate::vehicle::{self as registry, CommandKind};

/// m
const SIZE: (f64, f64) = (0.1, 30.0);

/// The vehicle that `layers` describe together, the last having the last word.
pub fn vehicle(
    name: Node,
    layers: &[Layer],
    road: Option<&Road>,
    places: &Places,
    report: &mut Vec<Diagnostic>,
) -> Option<Vehicle> {
    if let Some(layer) = layers.last() {
        reject_repeats(layer.block, &[], report);
    }
    let what = format!("vehicle `{}`", name.text());
    let controller = match last(layers, Rule::controller) {
        Some(said) => named(said, &CONTROLLERS, places, report),
        None => {
            missing(layers, name.span(), &what, "controller", "controller carla_behavior", report);
            None
        }
    };
    let dynamics = last(layers, Rule::dynamics).map(|said| named(said, &DYNAMICS, places, report));
    if let (Some(controller), Some(Some(dynamics))) = (&controller, &dynamics) {
        check_fit(controller, dynamics, report);
    }
    let size = last(layers, Rule::size).map(|said| size(said, "a vehicle", report));
    let speed = match last(layers, Rule::speed) {
        Some(Said { node, scope }) => node.child(Rule::expression).and_then(|node| {
            value::quantity_in(node, Dimension::SPEED, (0.0, 100.0), "the speed of a vehicle", scope, report)
        }),
        None => {
            missing(layers, name.span(), &what, "speed", "speed 30 km/h", report);
            None
        }
    };
    let lane = match last(layers, Rule::lane) {
        Some(said) => lane(said, road, report),
        None => Some(0),
    };
    let start = match last(layers, Rule::vehicle_start) {
        Some(said) => start(said, report),
        None => Some(DeclaredVehicleStart::Automatic),
    };
    let sees = last(layers, Rule::sees).map(|Said { node, scope }| Model {
        name: "sees".to_string(),
        varied_by: None,
        settings: settings::check(node.child(Rule::settings), &registry::PERCEPTION, scope, report),
        origin: places.origin(node.span()),
    });
    Some(Vehicle {
        name: name.text().to_string(),
        controller: controller?.model,
        dynamics: match dynamics {
            Some(dynamics) => Some(dynamics?.model),
            None => None,
        },
        size: match size {
            Some(size) => Some(size?),
            None => None,
        },
        speed: speed?.expression,
        start: start?,
        lane: lane?,
        sees,
        origin: places.origin(name.span()),
    })
}

const CONTROLLERS: Registry<registry::ControllerModel> = Registry {
    code: Code::UnknownController,
    what: "controller",
    there_is_no: "there is no controller",
    all: registry::CONTROLLERS,
    declaration: |controller| &controller.declaration,
};

const DYNAMICS: Registry<registry::DynamicsModel> = Registry {
    code: Code::UnknownDynamics,
    what: "dynamics",
    there_is_no: "there are no vehicle dynamics",
    all: registry::DYNAMICS,
    declaration: |dynamics| &dynamics.declaration,
};

/// Of what varies, every combination must fit; where both vary they may go together, which the plan sees.
fn check_fit(
    controllers: &Named<registry::ControllerModel>,
    dynamics: &Named<registry::DynamicsModel>,
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
    let fitting = registry::DYNAMICS
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
pub fn size(said: Said, whose: &str, report: &mut Vec<Diagnostic>) -> Option<(Expression, Expression)> {
    let mut extents = said.node.all(Rule::expression);
    let mut extent = |word: &str| {
        let node = extents.next()?;
        let what = format!("the {word} of {whose}");
        value::quantity_in(node, Dimension::LENGTH, SIZE, &what, said.scope, report)
    };
    let (length, width) = (extent("length"), extent("width"));
    Some((length?.expression, width?.expression))
}

fn lane(said: Said, road: Option<&Road>, report: &mut Vec<Diagnostic>) -> Option<usize> {
    let node = said.node.child(Rule::expression)?;
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
fn start(said: Said, report: &mut Vec<Diagnostic>) -> Option<DeclaredVehicleStart> {
    let node = said.node.child(Rule::expression)?;
    let value = value::evaluate(node, said.scope, report)?;
    match value.kind {
        Kind::Number(Dimension::LENGTH) => value::quantity_in(
            node,
            Dimension::LENGTH,
            (0.0, 10_000.0),
            "the start of a vehicle",
            said.scope,
            report,
        )
        .map(|value| DeclaredVehicleStart::Distance(value.expression)),
        Kind::Number(Dimension::TIME) => value::quantity_in(
            node,
            Dimension::TIME,
            (0.0, 600.0),
            "the start of a vehicle",
            said.scope,
            report,
        )
        .map(|value| DeclaredVehicleStart::TimeToArrival(value.expression)),
        _ => {
            let code = match value.kind {
                Kind::Number(Dimension::NUMBER) => Code::MissingUnit,
                Kind::Number(_) => Code::WrongDimension,
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
