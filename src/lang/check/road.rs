//! `road { … }`

use std::collections::BTreeSet;

use super::bend;
use super::block::{Layer, missing, reject_repeats};
use super::book::Book;
use super::over::{SaidOver, over};
use super::places::TextPlaces;
use super::road_settings::{OF_SIGNAL, bus, obstacle, parked_row, signalised, unmarked, zebra};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{self, NameScope, Typed};
use crate::write::{BlockText, constant, number_of, quantity};
use scenario::{
    Body, Crossing, CrossingKind, Declaration, DeclaredBend, DeclaredGround, DeclaredPlace, DeclaredSignal,
    Dimension, Direction, Expression, Ground, Lane, Median, OtherCrossing, Road, Settings, TrafficSignal,
    limits, show,
};

/// A road with what of it may depend on variations.
pub struct DeclaredRoad {
    pub road: Road,
    pub bend: Option<DeclaredBend>,
    pub ground: Option<DeclaredGround>,
    /// Of its other crossings, in their order.
    pub other_crossings: Vec<DeclaredPlace>,
    pub signal: Option<DeclaredSignal>,
    /// What it lies over.
    pub over: Option<SaidOver>,
}

/// The road that a `road_block` describes; `name` is empty for one inside a scenario.
pub fn road(
    name: &str,
    span: Span,
    block: ast::RoadBlock,
    scope: &NameScope,
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<DeclaredRoad> {
    reject_repeats(*block, report);
    let layers = [Layer { block, scope }];
    let known_as = match block.over() {
        Some(_) => format!("road {name}"),
        None => "road".to_string(),
    };
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
        Some(node) => crossing(ast::AnyCrossing::Crossing(node), scope, report).map(|found| (node, found)),
        // People cross the road below.
        None if block.over().is_some() => None,
        None => {
            missing::<ast::Crossing>(&layers, span, &what, report);
            None
        }
    };
    let ground = ground((block, &known_as), scope, places, written, report);
    let boxes: Vec<_> = block.obstacles().map(|node| bodies(node, scope, report)).collect();
    let others: Vec<_> =
        block.other_crossings().map(|node| other_crossing(node, scope, places, written, report)).collect();
    let others = crossings_named_once(others.into_iter().collect::<Option<Vec<_>>>(), block, report);
    let medians = medians(block, scope, lanes.as_deref().zip(lane_width), report);
    let pieces = block.path().map(|path| bend::pieces((path, &known_as), scope, places, written, report));
    if let Some(node) = block.over() {
        let over = over(node, (block, &known_as), pieces, scope, places, written, report)?;
        let road = Road {
            name: name.to_string(),
            medians: medians?,
            lane_width: lane_width?,
            lanes: lanes?,
            kerbs: block.no_kerbs().is_none(),
            crossing: Crossing { kind: CrossingKind::Unmarked, width: 0.0 },
            ..Road::zebra(&[], speed_limit?)
        };
        let (bend, other_crossings, signal) = (None, Vec::new(), None);
        return Some(DeclaredRoad { road, bend, ground: ground?, other_crossings, signal, over: Some(over) });
    }
    let (node, SaidCrossing { crossing, at, signal }) = crossing?;
    for (name, typed) in &signal {
        written.statement("road", name, Some(typed), places);
    }
    let signal = signal.first().map(|(_, first)| first.span).map(|span| DeclaredSignal {
        varied: signal.into_iter().map(|(name, typed)| (name, typed.expression)).collect(),
        origin: places.origin(span),
    });
    let bend = match (pieces, at) {
        (None, None) => None,
        (Some(pieces), Some(at)) => {
            written.statement("road", "at", Some(&at), places);
            let origin = places.origin(at.span);
            Some(DeclaredBend { pieces: pieces?, crossing: at.expression, origin })
        }
        (Some(_), None) => {
            report.push(bend::no_place(node));
            return None;
        }
        (None, Some(at)) => {
            report.push(bend::no_path(at.span));
            return None;
        }
    };
    let (other_crossings, places_of_others) = others?.into_iter().unzip();
    let road = Road {
        name: name.to_string(),
        medians: medians?,
        other_crossings,
        lane_width: lane_width?,
        lanes: lanes?,
        speed_limit: speed_limit?,
        kerbs: block.no_kerbs().is_none(),
        crossing,
        boxes: named_once(boxes.into_iter().collect::<Option<Vec<_>>>()?.concat(), span, report)?,
        bend: None,
        ground: Ground::default(),
    };
    Some(DeclaredRoad { road, bend, ground: ground?, other_crossings: places_of_others, signal, over: None })
}

/// The strips between lanes of a road whose lanes and their width (m) are known.
fn medians(
    block: ast::RoadBlock,
    scope: &NameScope,
    lanes: Option<(&[Lane], f64)>,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<Median>> {
    let mut found: Vec<Median> = Vec::new();
    for node in block.medians() {
        let mut numbers = node.numbers();
        let (width, after) = (numbers.next()?, numbers.next()?);
        let limits::Limit { dimension, range } = limits::MEDIAN;
        let metres = value::constant_in(width, dimension, range, "the width of a median", scope, report)?;
        let what = "the lane that a median follows";
        let lane = value::constant_in(after, Dimension::NUMBER, (0.0, 15.0), what, scope, report)?;
        if lane.fract() != 0.0 {
            report.push(settings::not_whole(after.span(), what, lane));
            return None;
        }
        let lane = lane as usize;
        let (lanes, lane_width) = lanes?;
        let mut wrong = |span: Span, message: String, label: &str, hint: String| {
            report.push(Diagnostic::new(Code::BadMedian, span, message).label(label).hint(hint));
            None
        };
        if lane + 1 >= lanes.len() {
            let (message, count) = (format!("there is no lane behind lane {lane}"), lanes.len());
            let hint = match count {
                1 => {
                    "a median lies between two lanes, and the road has one: `lanes forward, backward`".into()
                }
                _ => format!("the road has {count} lanes, counted from 0: say `after lane {}`", count - 2),
            };
            return wrong(after.span(), message, "nothing to divide", hint);
        }
        let carriageway = lanes.len() as f64 * lane_width;
        if metres > carriageway {
            let show = |value| show(value, None, Dimension::LENGTH);
            let message = format!("the median is {} wide, more than all lanes together", show(metres));
            let hint = format!("the lanes are {} wide together: let it be at most that", show(carriageway));
            return wrong(width.span(), message, "wider than the road", hint);
        }
        if found.iter().any(|other| other.after == lane) {
            let hint = "say one of them, as wide as both".to_string();
            return wrong(node.span(), format!("lane {lane} is followed by two medians"), "the second", hint);
        }
        found.push(Median { after: lane, width: metres, refuge: node.is_refuge() });
    }
    found.sort_by_key(|median| median.after);
    Some(found)
}

/// A crossing that is not the origin of all places, and where it is.
fn other_crossing(
    node: ast::OtherCrossing,
    scope: &NameScope,
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<(OtherCrossing, DeclaredPlace)> {
    let SaidCrossing { crossing, at, signal } =
        crossing(ast::AnyCrossing::OtherCrossing(node), scope, report)?;
    let name = node.name().text().to_string();
    if let Some((varied, typed)) = signal.first() {
        report.push(
            Diagnostic::new(Code::NotConstant, typed.span, format!("`{varied}` may not vary between runs"))
                .label(format!("depends on `{}`", typed.expression.variables().join("`, `")))
                .hint("let the signal of the first crossing vary, or write a scenario for each value"),
        );
        return None;
    }
    let Some(at) = at else {
        report.push(
            Diagnostic::new(
                Code::MissingStatement,
                node.span(),
                format!("nobody says where crossing `{name}` is"),
            )
            .label("has no `at`")
            .hint("say how far along the road from the middle of the first crossing, on a `path` from its beginning: `at: 40 m`"),
        );
        return None;
    };
    written.statement(&format!("road.{name}"), "at", Some(&at), places);
    let place = DeclaredPlace { origin: places.origin(at.span), at: at.expression };
    Some((OtherCrossing { name, along: 0.0, crossing }, place))
}

type Others = Vec<(OtherCrossing, DeclaredPlace)>;

/// Crossings that are called alike could not be told apart.
fn crossings_named_once(
    others: Option<Others>,
    block: ast::RoadBlock,
    report: &mut Vec<Diagnostic>,
) -> Option<Others> {
    let mut names = BTreeSet::new();
    let twice = block.other_crossings().find(|node| !names.insert(node.name().text()));
    if let Some(twice) = twice {
        let name = twice.name();
        report.push(
            Diagnostic::new(
                Code::DuplicateName,
                name.span(),
                format!("two crossings of this road are called `{}`", name.text()),
            )
            .label("the second")
            .hint("call it otherwise"),
        );
        return None;
    }
    others
}

/// How steep it is and how well tyres hold on it, where that is said; the outer `None`: said wrongly.
fn ground(
    (block, road): (ast::RoadBlock, &str),
    scope: &NameScope,
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<Option<DeclaredGround>> {
    let mut number = |name: &str, node: ast::Expression, limit: limits::Limit| {
        let what = format!("the {name} of the road");
        let typed = value::quantity_within(node, limit, &what, scope, report)?;
        written.statement(road, name, Some(&typed), places);
        Some(typed)
    };
    let gradient = block.gradient().map(|said| number("gradient", said.value(), limits::GRADIENT));
    let friction = block.friction().map(|said| number("friction", said.value(), limits::FRICTION));
    let (gradient, friction) = (unless_wrong(gradient)?, unless_wrong(friction)?);
    let first = [&gradient, &friction].into_iter().flatten().map(|typed| typed.span).next();
    Some(first.map(|span| DeclaredGround {
        gradient: gradient.map(|typed| typed.expression),
        friction: friction.map(|typed| typed.expression),
        origin: places.origin(span),
    }))
}

/// What was said, if anything; `None` if it is wrong.
fn unless_wrong<T>(said: Option<Option<T>>) -> Option<Option<T>> {
    match said {
        None => Some(None),
        Some(found) => found.map(Some),
    }
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

/// A crossing as it is said.
struct SaidCrossing {
    crossing: Crossing,
    /// On a path, how far behind its beginning it is.
    at: Option<Typed>,
    /// What of its signal depends on variations, by name.
    signal: Vec<(String, Typed)>,
}

fn crossing(node: ast::AnyCrossing, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<SaidCrossing> {
    let declaration = if node.is_zebra() {
        zebra()
    } else if node.is_unmarked() {
        unmarked()
    } else {
        signalised()
    };
    let may_vary: Vec<&str> = ["at"].into_iter().chain(OF_SIGNAL).collect();
    let (mut given, varying) = settings_but(&may_vary, node.settings(), &declaration, scope, report)?;
    let (at, signal): (Vec<_>, Vec<_>) = varying.into_iter().partition(|(name, _)| name == "at");
    let at = at.into_iter().map(|(_, typed)| typed).next_back();
    let (fixed, signal): (Vec<_>, Vec<_>) =
        signal.into_iter().partition(|(_, typed)| matches!(typed.expression, Expression::Constant(_)));
    for (name, typed) in fixed {
        if let Expression::Constant(value) = typed.expression {
            given.set(name, value);
        }
    }
    let resolved = declaration.resolve(&given).ok()?;
    let kind = if node.is_zebra() {
        CrossingKind::Zebra
    } else if node.is_unmarked() {
        CrossingKind::Unmarked
    } else {
        let mut of_signal = TrafficSignal::new(0.0, 0.0, 0.0);
        for name in OF_SIGNAL {
            if let Some(number) = of_signal.number_mut(name) {
                *number = resolved.number(name);
            }
        }
        // What varies is looked at in each of its worlds.
        if let (true, Err(error)) = (signal.is_empty(), of_signal.check()) {
            report.push(
                Diagnostic::new(Code::OutOfRange, node.span(), error.message)
                    .label("does not fit into its cycle")
                    .hint(error.hint),
            );
            return None;
        }
        CrossingKind::Signalised(of_signal)
    };
    Some(SaidCrossing { crossing: Crossing { kind, width: resolved.number("width") }, at, signal })
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
        return Some(vec![Body { name: name.to_string(), x, y, length, width, heading: 0.0 }]);
    }
    let (cars, gap) = (given.number("cars") as usize, given.number("gap"));
    let car = |index: usize| Body {
        name: format!("{name}_{}", index + 1),
        x: x - length / 2.0 - index as f64 * (length + gap),
        y,
        length,
        width,
        heading: 0.0,
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
    settings_but(&[], node, declaration, scope, report).map(|(constants, _)| constants)
}

/// As [`constants`], but for those of these names, which may vary and are given apart.
fn settings_but(
    may_vary: &[&str],
    node: Option<ast::Settings>,
    declaration: &Declaration,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(Settings, Vec<(String, Typed)>)> {
    let (mut constants, mut varying) = (Settings::default(), Vec::new());
    let Some(node) = node else { return Some((constants, varying)) };
    let before = report.len();
    for (name, typed) in settings::check(Some(node), declaration, scope, report) {
        if may_vary.contains(&name.as_str()) {
            varying.push((name, typed));
            continue;
        }
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
    (report.len() == before).then_some((constants, varying))
}

/// The settings of a signal; what varied and has its value now stands in the place of what the road says.
fn signal_text(mut signal: TrafficSignal, varied: Option<&DeclaredSignal>) -> String {
    for (name, value) in varied.iter().flat_map(|declared| &declared.varied) {
        if let Some(number) = signal.number_mut(name) {
            *number = number_of(value);
        }
    }
    let mut text = format!(
        ", cycle: {}, pedestrian_green: {}, pedestrian_green_from: {}",
        quantity(signal.cycle, Dimension::TIME),
        quantity(signal.pedestrian_green, Dimension::TIME),
        quantity(signal.pedestrian_green_from, Dimension::TIME),
    );
    let usual = TrafficSignal::new(0.0, 0.0, 0.0);
    let others = [
        ("amber", signal.amber, usual.amber, Dimension::TIME),
        ("clearance", signal.clearance, usual.clearance, Dimension::TIME),
        ("stop_line", signal.stop_line, usual.stop_line, Dimension::LENGTH),
    ];
    for (name, found, usual, dimension) in others {
        if found != usual {
            text.push_str(&format!(", {name}: {}", quantity(found, dimension)));
        }
    }
    text
}

/// The block that says it, inside a scenario or, `named`, as a definition.
pub fn write_road(
    (road, named): (&Road, bool),
    (bend, ground, signal): (Option<&DeclaredBend>, Option<&DeclaredGround>, Option<&DeclaredSignal>),
    other_crossings: &[DeclaredPlace],
    out: &mut BlockText,
) {
    match road.name.as_str() {
        name if named => out.open(&format!("road {name}")),
        _ => out.open("road"),
    }
    bend.into_iter().for_each(|bend| bend::write_path(&bend.pieces, out));
    write_cross_section(road, ground, out);
    out.line(&crossing_text("", &road.crossing, bend.map(|bend| &bend.crossing), signal));
    for (OtherCrossing { name, crossing, .. }, place) in road.other_crossings.iter().zip(other_crossings) {
        out.line(&crossing_text(name, crossing, Some(&place.at), None));
    }
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

/// What a road is like whatever crosses it and stands there.
pub fn write_cross_section(road: &Road, ground: Option<&DeclaredGround>, out: &mut BlockText) {
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
    let mut number = |name: &str, said: Option<&Expression>| {
        if let Some(said) = said {
            out.line(&format!("{name} {}", constant(said, Dimension::NUMBER)));
        }
    };
    number("gradient", ground.and_then(|ground| ground.gradient.as_ref()));
    number("friction", ground.and_then(|ground| ground.friction.as_ref()));
    if !road.kerbs {
        out.line("no kerbs");
    }
    for Median { after, width, refuge } in &road.medians {
        let refuge = if *refuge { " with refuge" } else { "" };
        out.line(&format!("median {} after lane {after}{refuge}", quantity(*width, Dimension::LENGTH)));
    }
}

fn crossing_text(
    name: &str,
    crossing: &Crossing,
    at: Option<&Expression>,
    signal: Option<&DeclaredSignal>,
) -> String {
    let mut width = quantity(crossing.width, Dimension::LENGTH);
    if let Some(at) = at {
        width.push_str(&format!(", at: {}", constant(at, Dimension::LENGTH)));
    }
    let settings = match crossing.kind {
        CrossingKind::Zebra => format!("zebra {{ width: {width} }}"),
        CrossingKind::Unmarked => format!("unmarked {{ width: {width} }}"),
        CrossingKind::Signalised(of_signal) => {
            format!("signalised {{ width: {width}{} }}", signal_text(of_signal, signal))
        }
    };
    if name.is_empty() { format!("crossing {settings}") } else { format!("crossing {name} {settings}") }
}
