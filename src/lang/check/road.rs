//! `road { … }`

use std::collections::BTreeSet;

use super::block::{Layer, missing, reject_repeats};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{self, NameScope, Typed, ValueKind};
use crate::write::{BlockText, quantity};
use scenario::{
    Body, Crossing, CrossingKind, Declaration, Dimension, Direction, Expression, Lane, Parameter, Road,
    Settings, Value, limits,
};

const LANGUAGE: &str = "the scenario language";

fn width() -> Parameter {
    Parameter::number(
        "width",
        Dimension::LENGTH,
        4.0,
        (0.5, 50.0),
        "Extent of the crossing along the road.",
        LANGUAGE,
    )
}

fn zebra() -> Declaration {
    Declaration::new("crossing zebra", "A crossing at which pedestrians have priority.")
        .source(LANGUAGE)
        .parameters([width()])
}

fn unmarked() -> Declaration {
    Declaration::new("crossing unmarked", "A place to cross at which vehicles have priority.")
        .source(LANGUAGE)
        .parameters([width()])
}

fn signalised() -> Declaration {
    Declaration::new("crossing signalised", "A crossing with a two-phase signal.")
        .source(LANGUAGE)
        .parameters([
            width(),
            Parameter::number(
                "cycle",
                Dimension::TIME,
                60.0,
                (1.0, 600.0),
                "Time after which the signal repeats.",
                LANGUAGE,
            ),
            Parameter::number(
                "pedestrian_green",
                Dimension::TIME,
                20.0,
                (0.0, 600.0),
                "How long pedestrians have green in each cycle.",
                LANGUAGE,
            ),
            Parameter::number(
                "pedestrian_green_from",
                Dimension::TIME,
                0.0,
                (0.0, 600.0),
                "When in the cycle pedestrians get green.",
                LANGUAGE,
            ),
        ])
}

/// Every kind of crossing by its word.
pub fn crossings() -> [(&'static str, Declaration); 3] {
    [("zebra", zebra()), ("unmarked", unmarked()), ("signalised", signalised())]
}

const PLACE: (f64, f64) = (-1000.0, 1000.0);
const EXTENT: (f64, f64) = (0.01, 100.0);

pub fn obstacle() -> Declaration {
    let [along, across, length, width] = rectangle();
    Declaration::new("box", "A parked vehicle or another box that blocks the view and the way.")
        .source(LANGUAGE)
        .parameters([along, across, length, width])
}

/// `bus NAME { … }`
pub fn bus() -> Declaration {
    let [along, across, ..] = rectangle();
    let extent = |name, default, doc| {
        let source = "a common length of city buses, and their largest width by Directive 96/53/EC";
        Parameter::number(name, Dimension::LENGTH, default, EXTENT, doc, source)
    };
    Declaration::new("bus", "A bus that stands, which blocks the view and the way.")
        .source(LANGUAGE)
        .parameters([
            along,
            across,
            extent("length", 12.0, "Its extent along the road."),
            extent("width", 2.55, "Its extent across the road."),
        ])
}

/// `parked_row NAME { … }`
pub fn parked_row() -> Declaration {
    let [_, across, length, width] = rectangle();
    let to = "Where the first of them ends along the road, 0 being the middle of the crossing; the others stand before it.";
    Declaration::new("parked_row", "Parked vehicles one behind the other, which block the view and the way.")
        .source(LANGUAGE)
        .parameters([
            Parameter::optional("to", Dimension::LENGTH, PLACE, to, LANGUAGE),
            Parameter::whole("cars", 2, (1, 100), "How many there are.", LANGUAGE),
            Parameter::number("gap", Dimension::LENGTH, 1.0, (0.0, 100.0), "Between two of them.", LANGUAGE),
            across,
            length,
            width,
        ])
}

fn rectangle() -> [Parameter; 4] {
    [
        Parameter::optional(
            "along",
            Dimension::LENGTH,
            PLACE,
            "Its centre along the road; 0 is the middle of the crossing.",
            LANGUAGE,
        ),
        Parameter::optional(
            "across",
            Dimension::LENGTH,
            PLACE,
            "Its centre across the road; 0 is the centre of lane 0, positive towards the far side.",
            LANGUAGE,
        ),
        Parameter::optional("length", Dimension::LENGTH, EXTENT, "Its extent along the road.", LANGUAGE),
        Parameter::optional("width", Dimension::LENGTH, EXTENT, "Its extent across the road.", LANGUAGE),
    ]
}

/// The road that a `road_block` describes; `name` is empty for one inside a scenario.
pub fn road(
    name: &str,
    span: Span,
    block: ast::RoadBlock,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Road> {
    reject_repeats(*block, report);
    let layers = [Layer { block, scope }];
    let what = if name.is_empty() { "this road".to_string() } else { format!("road `{name}`") };
    let lanes = match block.lanes() {
        Some(node) => lanes(node, scope, report),
        None => Some(vec![Lane { direction: Direction::Forward }]),
    };
    let number = |node, limits::Limit { dimension, range }, word: &str, report: &mut Vec<Diagnostic>| {
        value::constant_in(node, dimension, range, word, scope, report)
    };
    let lane_width = match block.lane_width() {
        Some(said) => number(said.value(), limits::LANE_WIDTH, "the lane width", report),
        None => {
            missing::<ast::LaneWidth>(&layers, span, &what, report);
            None
        }
    };
    let speed_limit = match block.speed_limit() {
        Some(said) => number(said.value(), limits::SPEED_LIMIT, "the speed limit", report),
        None => {
            missing::<ast::SpeedLimit>(&layers, span, &what, report);
            None
        }
    };
    let crossing = match block.crossing() {
        Some(node) => crossing(node, scope, report),
        None => {
            missing::<ast::Crossing>(&layers, span, &what, report);
            None
        }
    };
    let boxes: Vec<_> = block.obstacles().map(|node| bodies(node, scope, report)).collect();
    Some(Road {
        name: name.to_string(),
        lane_width: lane_width?,
        lanes: lanes?,
        speed_limit: speed_limit?,
        kerbs: block.no_kerbs().is_none(),
        crossing: crossing?,
        boxes: named_once(boxes.into_iter().collect::<Option<Vec<_>>>()?.concat(), span, report)?,
        bend: None,
    })
}

fn lanes(node: ast::Lanes, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<Vec<Lane>> {
    let Some(count) = node.number() else {
        return Some(
            node.directions()
                .map(|direction| Lane {
                    direction: if direction.is_backward() { Direction::Backward } else { Direction::Forward },
                })
                .collect(),
        );
    };
    let what = "the number of lanes";
    let number = value::constant_in(count, Dimension::NUMBER, (1.0, 16.0), what, scope, report)?;
    if number.fract() != 0.0 {
        report.push(settings::not_whole(count.span(), what, number));
        return None;
    }
    Some(vec![Lane { direction: Direction::Forward }; number as usize])
}

fn crossing(node: ast::Crossing, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<Crossing> {
    let (declaration, kind) = if node.is_zebra() {
        (zebra(), CrossingKind::Zebra)
    } else if node.is_unmarked() {
        (unmarked(), CrossingKind::Unmarked)
    } else {
        (
            signalised(),
            CrossingKind::Signalised { cycle: 0.0, pedestrian_green_from: 0.0, pedestrian_green: 0.0 },
        )
    };
    let given = constants(node.settings(), &declaration, scope, report)?;
    let resolved = declaration.resolve(&given).ok()?;
    let kind = match kind {
        CrossingKind::Signalised { .. } => {
            let cycle = resolved.number("cycle");
            for name in ["pedestrian_green", "pedestrian_green_from"] {
                let found = resolved.number(name);
                if found > cycle {
                    let what = format!("`{name}` of the signal");
                    let kind = ValueKind::Number(Dimension::TIME);
                    let typed = Typed::constant(Value::Number(found), kind, node.span());
                    let range = (0.0, cycle);
                    report.push(value::out_of_range(&typed, &what, found, range, Dimension::TIME, None));
                    return None;
                }
            }
            CrossingKind::Signalised {
                cycle,
                pedestrian_green_from: resolved.number("pedestrian_green_from"),
                pedestrian_green: resolved.number("pedestrian_green"),
            }
        }
        other => other,
    };
    Some(Crossing { kind, width: resolved.number("width") })
}

/// What a statement puts on the road.
fn bodies(node: ast::Obstacle, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<Vec<Body>> {
    let block = node.settings();
    let (what, declaration, example) = match (node.is_row(), node.is_bus()) {
        (true, _) => {
            let example = "parked_row vans { to: -6 m, cars: 5, gap: 1 m, across: -2.8 m, length: 4.5 m, width: 1.8 m }";
            ("row", parked_row(), example)
        }
        (_, true) => ("bus", bus(), "bus stopped { along: -8 m, across: -3 m }"),
        _ => ("box", obstacle(), "box van { along: -12 m, across: -2.5 m, length: 5 m, width: 2 m }"),
    };
    let given = constants(Some(block), &declaration, scope, report)?;
    let given = declaration.resolve(&given).ok()?;
    let mut number = |name: &str| {
        given.optional_number(name).or_else(|| {
            if !block.has_bad() {
                report.push(
                    Diagnostic::new(
                        Code::MissingStatement,
                        node.name().span(),
                        format!("this {what} has no `{name}`"),
                    )
                    .label(format!("has no `{name}`"))
                    .hint(format!("a {what} reads `{example}`")),
                );
            }
            None
        })
    };
    let place = if node.is_row() { "to" } else { "along" };
    let (x, y, length, width) = (number(place), number("across"), number("length"), number("width"));
    let (x, y, length, width) = (x?, y?, length?, width?);
    let name = node.name().text();
    if !node.is_row() {
        return Some(vec![Body { name: name.to_string(), x, y, length, width }]);
    }
    let (cars, gap) = (given.number("cars") as usize, given.number("gap"));
    let car = |index: usize| Body {
        name: format!("{name}_{}", index + 1),
        x: x - length / 2.0 - index as f64 * (length + gap),
        y,
        length,
        width,
    };
    Some((0..cars).map(car).collect())
}

/// Bodies that are called alike could not be told apart: a row names its own.
fn named_once(bodies: Vec<Body>, road: Span, report: &mut Vec<Diagnostic>) -> Option<Vec<Body>> {
    let mut names = BTreeSet::new();
    let twice = bodies.iter().find(|body| !names.insert(body.name.clone()));
    if let Some(body) = twice {
        report.push(
            Diagnostic::new(
                Code::DuplicateName,
                road,
                format!("two things on this road are called `{}`", body.name),
            )
            .label("on this road")
            .hint("a `parked_row vans` calls its cars `vans_1`, `vans_2`, …: call it otherwise"),
        );
        return None;
    }
    Some(bodies)
}

/// Settings that are the same in all runs.
pub fn constants(
    node: Option<ast::Settings>,
    declaration: &Declaration,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Settings> {
    let mut constants = Settings::default();
    let Some(node) = node else { return Some(constants) };
    let before = report.len();
    for (name, typed) in settings::check(Some(node), declaration, scope, report) {
        match typed.expression {
            Expression::Constant(value) => constants.set(name, value),
            varying => {
                report.push(
                    Diagnostic::new(
                        Code::NotConstant,
                        node.span(),
                        format!("`{name}` may not vary between runs"),
                    )
                    .label(format!("depends on `{}`", varying.variables().join("`, `")))
                    .hint("write a scenario for each value"),
                );
            }
        }
    }
    (report.len() == before).then_some(constants)
}

/// The block that says it.
pub fn write_road(road: &Road, out: &mut BlockText) {
    out.open("road");
    let directions: Vec<_> = road
        .lanes
        .iter()
        .map(|lane| match lane.direction {
            Direction::Forward => "forward",
            Direction::Backward => "backward",
        })
        .collect();
    if directions != ["forward"] {
        out.line(&format!("lanes {}", directions.join(", ")));
    }
    out.line(&format!("lane_width {}", quantity(road.lane_width, Dimension::LENGTH)));
    out.line(&format!("speed_limit {}", quantity(road.speed_limit, Dimension::SPEED)));
    if !road.kerbs {
        out.line("no kerbs");
    }
    let width = quantity(road.crossing.width, Dimension::LENGTH);
    out.line(&match road.crossing.kind {
        CrossingKind::Zebra => format!("crossing zebra {{ width: {width} }}"),
        CrossingKind::Unmarked => format!("crossing unmarked {{ width: {width} }}"),
        CrossingKind::Signalised { cycle, pedestrian_green_from, pedestrian_green } => format!(
            "crossing signalised {{ width: {width}, cycle: {}, pedestrian_green: {}, pedestrian_green_from: {} }}",
            quantity(cycle, Dimension::TIME),
            quantity(pedestrian_green, Dimension::TIME),
            quantity(pedestrian_green_from, Dimension::TIME),
        ),
    });
    for (index, body) in road.boxes.iter().enumerate() {
        let metres = |value| quantity(value, Dimension::LENGTH);
        let name = if body.name.is_empty() { format!("box_{}", index + 1) } else { body.name.clone() };
        out.line(&format!(
            "box {name} {{ along: {}, across: {}, length: {}, width: {} }}",
            metres(body.x),
            metres(body.y),
            metres(body.length),
            metres(body.width),
        ));
    }
    out.close();
}
