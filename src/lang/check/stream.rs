//! `stream NAME { … }`: vehicles of one lane that come one after the other.

use std::collections::HashMap;

use super::block::{Layer, Said, last, missing};
use super::book::Book;
use super::draw::read_column;
use super::places::TextPlaces;
use super::variation::{DrawnFrom, drawn_from};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{self, NameScope, Typed, ValueKind};
use crate::write::{BlockText, constant};
use scenario::{
    BinaryOperator, DeclaredDraw, DeclaredStream, DeclaredVehicleStart, Dimension, Distribution, DrawSource,
    Expression, FurtherGaps, TrafficStream, Value, VariedValue, Vehicle, limits,
};

/// The column of a file that has gaps.
const GAP: &str = "gap";

/// A vehicle or a stream by its name, with what every layer says about it.
type Group<'a> = (ast::Name<'a>, Vec<Layer<'a, ast::VehicleBlock<'a>>>);

/// The streams that repeat another: by name the other's name, and how many of the layers are those of the other.
pub type Repeated<'a> = HashMap<&'a str, (&'a str, usize)>;

/// Puts the layers of the stream that another repeats before the other's own.
pub fn repeat<'a>(groups: &mut [Group<'a>], report: &mut Vec<Diagnostic>) -> Repeated<'a> {
    reject_mixed(groups, report);
    let own = |groups: &[Group<'a>], name: &str| {
        groups.iter().find(|(known, _)| known.text() == name).map(|(_, layers)| layers.clone())
    };
    let mut repeated = Repeated::new();
    let said: Vec<Group<'a>> = groups.to_vec();
    for (name, layers) in groups {
        let Some(Said { node, .. }) = last(layers, ast::VehicleBlock::repeats) else { continue };
        let other = node.name();
        let Some(others) = own(&said, other.text()).filter(|_| other.text() != name.text()) else {
            report.push(unknown(other, *name, &said));
            continue;
        };
        if let Some(Said { node, .. }) = last(&others, ast::VehicleBlock::repeats) {
            let first = node.name().text();
            report.push(
                Diagnostic::new(
                    Code::BadStream,
                    other.span(),
                    format!("stream `{}` repeats `{first}` itself", other.text()),
                )
                .label("repeats another stream")
                .context(node.span(), "said here")
                .hint(format!("repeat `{first}`")),
            );
            continue;
        }
        if !others.iter().all(|layer| layer.block.is_of_stream()) {
            report.push(unknown(other, *name, &said));
            continue;
        }
        repeated.insert(name.text(), (other.text(), others.len()));
        layers.splice(0..0, others);
    }
    repeated
}

/// Whether a stream repeats another that there is not, so that nothing is known of it.
pub fn lacks_repeated((name, layers): &Group, repeated: &Repeated) -> bool {
    last(layers, ast::VehicleBlock::repeats).is_some() && !repeated.contains_key(name.text())
}

/// One name is that of a vehicle or that of a stream.
fn reject_mixed(groups: &[Group], report: &mut Vec<Diagnostic>) {
    for (name, layers) in groups {
        let mut kinds = layers.iter().map(|layer| layer.block.is_of_stream());
        let first = kinds.next();
        if kinds.any(|kind| Some(kind) != first) {
            let span = layers.last().map_or(name.span(), |layer| layer.block.span());
            report.push(
                Diagnostic::new(
                    Code::BadStream,
                    span,
                    format!("`{}` is a stream here and a vehicle elsewhere", name.text()),
                )
                .label("does not go together")
                .context(name.span(), "said there")
                .hint("give one of them another name"),
            );
        }
    }
}

fn unknown(other: ast::Name, own: ast::Name, groups: &[Group]) -> Diagnostic {
    let is_stream =
        |layers: &[Layer<ast::VehicleBlock>]| layers.last().is_some_and(|layer| layer.block.is_of_stream());
    let streams = groups.iter().filter(|(name, layers)| name.text() != own.text() && is_stream(layers));
    Diagnostic::new(Code::BadStream, other.span(), format!("there is no other stream `{}`", other.text()))
        .label("cannot be repeated")
        .suggest(other.text(), streams.map(|(name, _)| name.text()))
}

/// When the vehicles of a stream arrive, as its layers say.
pub fn arrivals(
    name: ast::Name,
    layers: &[Layer<ast::VehicleBlock>],
    repeated: &Repeated,
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<DeclaredStream> {
    let what = format!("stream `{}`", name.text());
    let first = match last(layers, ast::VehicleBlock::first) {
        Some(Said { node, scope }) => {
            let what = "the first arrival of a stream";
            value::quantity_within(node.time(), limits::VEHICLE_ARRIVAL, what, scope, report)
        }
        None => {
            missing::<ast::FirstArrival>(layers, name.span(), &what, report);
            None
        }
    };
    let (other, inherited) = repeated.get(name.text()).copied().unwrap_or((name.text(), 0));
    let (of_other, own) = layers.split_at(inherited);
    let gaps = match (last(own, ast::VehicleBlock::gaps), last(of_other, ast::VehicleBlock::gaps)) {
        (Some(said), _) => gaps(said, name.text(), places, report),
        // Drawn gaps are those of the other, too.
        (None, Some(said)) => gaps(said, other, places, report),
        (None, None) => {
            missing::<ast::Gaps>(layers, name.span(), &what, report);
            None
        }
    };
    let later = last(own, ast::VehicleBlock::repeats)
        .and_then(|Said { node, scope }| Some((node.later()?, scope)))
        .map(|(node, scope)| {
            let what = "how much later a stream comes";
            value::quantity_within(node.time(), limits::LATER, what, scope, report)
        });
    written.statement(name.text(), "first", first.as_ref(), places);
    let first = first?.expression;
    let first = match later {
        // Said anew, it is that of the stream itself.
        Some(later) if last(own, ast::VehicleBlock::first).is_none() => plus(first, later?.expression),
        Some(_) | None => first,
    };
    let (gaps, then) = gaps?;
    Some(DeclaredStream { first, gaps, then })
}

fn plus(left: Expression, right: Expression) -> Expression {
    if let (Expression::Constant(Value::Number(left)), Expression::Constant(Value::Number(right))) =
        (&left, &right)
    {
        return Expression::number(left + right);
    }
    Expression::Binary { operator: BinaryOperator::Add, left: Box::new(left), right: Box::new(right) }
}

/// The gaps of a stream, and what comes after them; those that are drawn are called after the stream `of`.
fn gaps(
    Said { node, scope }: Said<ast::Gaps>,
    of: &str,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<(Vec<Expression>, FurtherGaps)> {
    if let Some(file) = node.file() {
        let (values, _) = recorded(file, places, report)?;
        let numbers = values.iter().filter_map(|one| one.value.as_number());
        return Some((numbers.map(Expression::number).collect(), FurtherGaps::None));
    }
    if let Some(drawn) = node.drawn() {
        return Some((Vec::new(), drawn_gaps(drawn, of, scope, places, report)?));
    }
    let gap = |node, report: &mut Vec<Diagnostic>| {
        let found: Option<Typed> =
            value::quantity_within(node, limits::GAP, "a gap of a stream", scope, report);
        found.map(|typed| typed.expression)
    };
    let listed: Vec<Option<Expression>> = node.listed().map(|one| gap(one.time(), report)).collect();
    let then = match node.then() {
        None => Some(FurtherGaps::None),
        Some(then) => match (then.drawn(), then.time()) {
            (Some(drawn), _) => drawn_gaps(drawn, of, scope, places, report),
            (None, time) => time.and_then(|time| gap(time, report)).map(FurtherGaps::Alike),
        },
    };
    Some((listed.into_iter().collect::<Option<_>>()?, then?))
}

/// The gaps of a file, with a weight for each if the file has some.
fn recorded(
    file: ast::Text,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<(Vec<VariedValue>, Option<Vec<f64>>)> {
    let (kind, values, weights) = read_column(file, GAP, places, report)?;
    if kind != ValueKind::Number(Dimension::TIME) {
        let message = format!("the column `{GAP}` has {}, and gaps are times", kind.name());
        report.push(
            Diagnostic::new(Code::BadStream, file.span(), message)
                .label("no times")
                .hint(format!("head it with the unit: `{GAP} [s]`")),
        );
        return None;
    }
    let (low, high) = limits::GAP.range;
    let outside = |one: &VariedValue| one.value.as_number().is_none_or(|gap| !(low..=high).contains(&gap));
    if let Some(row) = values.iter().position(outside) {
        let message = format!("gap {} of the file is {}", row + 1, values[row].label);
        report.push(
            Diagnostic::new(Code::BadStream, file.span(), message)
                .label(format!("a gap is {low} s to {high} s"))
                .hint("leave rows out in which nobody could have gone"),
        );
        return None;
    }
    Some((values, weights))
}

fn drawn_gaps(
    node: ast::GapsDrawn,
    of: &str,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<FurtherGaps> {
    let chance = Expression::Variable(chance_of(of));
    if let Some(file) = node.file() {
        let distribution = match recorded(file, places, report)? {
            (options, Some(weights)) => Distribution::Weighted { options, weights },
            (options, None) => Distribution::Choice(options),
        };
        return Some(FurtherGaps::Drawn { distribution, chance });
    }
    let node = node.distribution()?;
    let DrawnFrom { kind, distribution, .. } = drawn_from(node, scope, &HashMap::new(), report)?;
    if kind != ValueKind::Number(Dimension::TIME) {
        report.push(
            Diagnostic::new(
                Code::WrongDimension,
                node.span(),
                format!("gaps of a stream are times, not {}", kind.name()),
            )
            .label(format!("this is {}", kind.name()))
            .hint("write times: `uniform(2 s, 8 s)`"),
        );
        return None;
    }
    Some(FurtherGaps::Drawn { distribution, chance })
}

/// What a run draws the gaps of a stream by.
fn chance_of(stream: &str) -> String {
    format!("{stream}.gaps")
}

/// What every run draws for the streams whose gaps are drawn.
pub fn draws(vehicles: &[Vehicle]) -> Vec<DeclaredDraw> {
    let mut found: Vec<DeclaredDraw> = Vec::new();
    for car in vehicles {
        let DeclaredVehicleStart::Stream(stream) = &car.start else { continue };
        let FurtherGaps::Drawn { chance: Expression::Variable(name), .. } = &stream.then else { continue };
        if found.iter().any(|draw| draw.names[0] == *name) {
            continue;
        }
        let distribution =
            Distribution::Uniform { low: Expression::number(0.0), high: Expression::number(1.0) };
        let from = DrawSource::Distribution { distribution, unit: String::new() };
        found.push(DeclaredDraw { names: vec![name.clone()], from, origin: car.origin.clone() });
    }
    found
}

/// What the vehicles of a stream are called: those of a run of `horizon` s where that is the same in all runs, else all that there may be.
pub fn members(name: &str, declared: Option<&Vehicle>, horizon: Option<f64>) -> Vec<String> {
    let stream = declared.and_then(|car| match &car.start {
        DeclaredVehicleStart::Stream(stream) => Some(stream),
        _ => None,
    });
    let known = stream.zip(horizon).and_then(|(stream, horizon)| stream.arrivals(&no_values(), horizon).ok());
    let count = known.map_or(TrafficStream::MOST, |arrivals| arrivals.len());
    (0..count).map(|index| TrafficStream::member_name(name, index)).collect()
}

/// Refuses a stream that could be in no run, and names that are those of its vehicles.
pub fn check(
    (name, layers): &(ast::Name, Vec<Layer<ast::VehicleBlock>>),
    declared: Option<&Vehicle>,
    horizon: Option<f64>,
    others: &[(&str, Span)],
    report: &mut Vec<Diagnostic>,
) {
    let is_member =
        |other: &str| TrafficStream::of_member(other).is_some_and(|(stream, _)| stream == name.text());
    for (other, span) in others.iter().filter(|(other, _)| is_member(other)) {
        report.push(
            Diagnostic::new(
                Code::BadStream,
                *span,
                format!("a vehicle of the stream `{}` is called `{other}`", name.text()),
            )
            .label("called alike")
            .context(name.span(), "the stream")
            .hint("give one of them another name"),
        );
    }
    let (Some(Vehicle { start: DeclaredVehicleStart::Stream(stream), .. }), Some(horizon)) =
        (declared, horizon)
    else {
        return;
    };
    let error = match stream.arrivals(&no_values(), horizon) {
        // What depends on variations and draws is found when runs are planned.
        Ok(_) | Err(scenario::StreamError::Evaluation(_) | scenario::StreamError::Distribution(_)) => return,
        Err(error) => error,
    };
    let span = last(layers, ast::VehicleBlock::gaps).map_or(name.span(), |said| said.node.span());
    report.push(
        Diagnostic::new(Code::BadStream, span, format!("of stream `{}` {error}", name.text()))
            .label("cannot be run")
            .hint("give it longer gaps, or the scenario a shorter `horizon`"),
    );
}

fn no_values() -> std::collections::BTreeMap<String, Value> {
    std::collections::BTreeMap::new()
}

/// The statements of a stream about when its vehicles arrive, whose values are all constants.
///
/// # Panics
/// If gaps are drawn.
pub fn write_arrivals(stream: &DeclaredStream, out: &mut BlockText) {
    let time = |expression| constant(expression, Dimension::TIME);
    out.line(&format!("first {} before crossing", time(&stream.first)));
    let mut gaps: Vec<String> = stream.gaps.iter().map(time).collect();
    match &stream.then {
        FurtherGaps::None => {}
        FurtherGaps::Alike(gap) => gaps.push(format!("then {}", time(gap))),
        FurtherGaps::Drawn { .. } => panic!("gaps are drawn before a scenario is written"),
    }
    out.line(&format!("gaps {}", gaps.join(", ")));
}
