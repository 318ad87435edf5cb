//! `pet(av, walker)`: a metric with the road users it is for.

use std::sync::Arc;

use super::pedestrian::unknown_vehicle;
use super::road::constants;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::syntax::ast;
use crate::value::{NameScope, ValueKind};
use scenario::registry::Table;
use scenario::{AggregateWord, Metric, MetricKind, MetricReference, Scope as Measured, Stake, TrafficStream};

/// Who is in the scenario that a criterion is about.
pub struct Cast<'a> {
    /// Every one by name, members of streams too.
    pub vehicles: Vec<&'a str>,
    /// By name; their vehicles are among the others.
    pub streams: Vec<&'a str>,
    /// Every one by name, members of groups too.
    pub pedestrians: Vec<&'a str>,
    /// By name, with their members.
    pub groups: Vec<(&'a str, Vec<&'a str>)>,
    /// Of the road.
    pub boxes: Vec<&'a str>,
    /// Whether people are taken from a population, and if so whether there are several.
    pub individuals: Option<bool>,
    /// Whether every run is of somebody else.
    pub are_drawn: bool,
    /// What can be measured.
    pub metrics: &'a Table<Metric>,
}

pub fn kind_name(metric: &Metric) -> String {
    match &metric.kind {
        MetricKind::Quantity(dimension) => ValueKind::Number(*dimension).name(),
        MetricKind::Flag => "true or false".to_string(),
        MetricKind::Category(words) => {
            format!("one of {}", words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", "))
        }
    }
}

pub fn example(metric: &Metric) -> String {
    let name = &metric.declaration.name;
    match &metric.kind {
        MetricKind::Quantity(dimension) => {
            let bound = format!("{name} >= 1.5 {}", dimension.si_unit());
            format!("such as `{}`", bound.trim_end())
        }
        MetricKind::Flag => format!("such as `no {name}`"),
        MetricKind::Category(words) => {
            format!("such as `{name} = {}`", words.first().map_or("…", |word| &**word))
        }
    }
}

/// A metric with the road users it is for.
pub fn metric_reference(
    node: ast::Metric,
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(MetricReference, Arc<Metric>)> {
    let name = node.name();
    let Some(found) = cast.metrics.get(name.text()) else {
        let message = format!("there is no metric `{}`", name.text());
        let diagnostic = Diagnostic::new(Code::UnknownMetric, name.span(), message).label("unknown metric");
        report.push(match AggregateWord::find(name.text()).is_some() {
            true => {
                diagnostic.hint("this is about single runs: compare a metric itself, such as `pet < 1.5 s`")
            }
            false => diagnostic.suggest(name.text(), cast.metrics.names()),
        });
        return None;
    };
    let details = node.details();
    let settings = constants(details, &found.declaration, scope, report);
    let of = match details {
        Some(details) => pair(details, found, cast, report)?,
        None => Subjects::default(),
    };
    if let Some(refusal) = order_in_stream(node, found, &of, cast) {
        report.push(refusal);
        return None;
    }
    let Subjects { pair, several, of_stream } = of;
    let metric = found.into();
    Some((MetricReference { metric, settings: settings?, pair, several, of_stream }, found.clone()))
}

/// Whom a metric is said to be about: see [`MetricReference`].
#[derive(Default)]
struct Subjects {
    pair: Option<(String, String)>,
    several: Vec<String>,
    of_stream: bool,
}

impl Subjects {
    fn of(vehicle: String, (called, several): (String, Vec<String>)) -> Self {
        Self { pair: Some((vehicle, called)), several, of_stream: false }
    }

    /// The same, of a vehicle or a stream.
    fn of_traffic(first: Traffic, others: (String, Vec<String>)) -> Self {
        Self { of_stream: first.is_stream, ..Self::of(first.name, others) }
    }
}

/// A vehicle or a stream.
struct Traffic {
    name: String,
    is_stream: bool,
}

/// What is wrong where a metric of the order of one vehicle and one pedestrian is said of a scenario with streams and names no vehicle, or
/// where one that says who goes first names a stream. The smallest time to any vehicle of a stream is one that somebody may mean.
fn order_in_stream(node: ast::Metric, metric: &Metric, of: &Subjects, cast: &Cast) -> Option<Diagnostic> {
    let stream = cast.streams.first().filter(|_| metric.tells_order())?;
    let stream = match &of.pair {
        None => *stream,
        Some((stream, _)) if of.of_stream && metric.stake == Stake::Order => stream.as_str(),
        Some(_) => return None,
    };
    let name = &metric.declaration.name;
    let person = of.pair.as_ref().map(|(_, person)| person.as_str());
    let person = person.or(cast.pedestrians.first().copied()).unwrap_or("walker");
    let one = TrafficStream::member_name(stream, 2);
    let message = match of.pair {
        None => {
            format!("`{name}` is of one vehicle and one pedestrian, and `{stream}` is a stream of vehicles")
        }
        Some(_) => format!("`{name}` says who goes first, and `{stream}` is a stream of vehicles"),
    };
    let mut hint = format!(
        "ask for the gap, `gap_taken({stream}, {person})`, or name a vehicle, `{name}({one}, {person})`"
    );
    if metric.stake != Stake::Order {
        hint += &format!("; the smallest of all vehicles is `{name}({stream}, {person})`");
    }
    Some(Diagnostic::new(Code::NoSingleOrder, node.span(), message).label("of which vehicle?").hint(hint))
}

/// People by their names and those of their groups: what they are called together, and who they are if there may be several.
fn people(names: &[ast::Name], cast: &Cast, report: &mut Vec<Diagnostic>) -> Option<(String, Vec<String>)> {
    let mut several: Vec<String> = Vec::new();
    for name in names {
        let members =
            cast.groups.iter().filter(|(group, _)| *group == name.text()).flat_map(|(_, members)| members);
        let single = cast.pedestrians.iter().filter(|known| **known == name.text());
        let found: Vec<&str> = members.chain(single).copied().collect();
        if found.is_empty() {
            let known = cast.pedestrians.iter().chain(cast.groups.iter().map(|(group, _)| group));
            report.push(
                Diagnostic::new(
                    Code::UnknownPedestrian,
                    name.span(),
                    format!("the scenario has no pedestrian `{}`", name.text()),
                )
                .label("unknown pedestrian")
                .suggest(name.text(), known.copied()),
            );
            return None;
        }
        for one in found {
            if !several.iter().any(|known| known == one) {
                several.push(one.to_string());
            }
        }
    }
    let called = names.iter().map(|name| name.text()).collect::<Vec<_>>().join(", ");
    let is_group = names.iter().any(|name| cast.groups.iter().any(|(group, _)| *group == name.text()));
    Some(if names.len() == 1 && !is_group { (called, Vec::new()) } else { (called, several) })
}

/// Whom it is about. A metric of one road user has a value with the first of the other kind; contacts of one vehicle, with
/// whatever it touches, have no second name.
fn pair(
    details: ast::Settings,
    metric: &Metric,
    cast: &Cast,
    report: &mut Vec<Diagnostic>,
) -> Option<Subjects> {
    let names: Vec<_> = details.names().collect();
    if names.is_empty() {
        return Some(Subjects::default());
    }
    let vehicle = |name: ast::Name, report: &mut Vec<Diagnostic>| {
        if cast.vehicles.contains(&name.text()) {
            return Some(name.text().to_string());
        }
        report.push(unknown_vehicle(name, &cast.vehicles));
        None
    };
    let traffic = |name: ast::Name, report: &mut Vec<Diagnostic>| {
        let is_stream = cast.streams.contains(&name.text());
        if is_stream || cast.vehicles.contains(&name.text()) {
            return Some(Traffic { name: name.text().to_string(), is_stream });
        }
        let known: Vec<&str> = cast.streams.iter().chain(&cast.vehicles).copied().collect();
        report.push(unknown_vehicle(name, &known));
        None
    };
    let first = |names: &[&str]| names.first().map(|name| name.to_string());
    let is_person = |name: &ast::Name| {
        cast.pedestrians.contains(&name.text()) || cast.groups.iter().any(|(group, _)| *group == name.text())
    };
    match (names.as_slice(), metric.scope) {
        ([car], Measured::Contact) => {
            Some(Subjects::of_traffic(traffic(*car, report)?, (String::new(), Vec::new())))
        }
        ([car, others @ ..], Measured::Contact) if others.iter().all(is_person) => {
            Some(Subjects::of_traffic(traffic(*car, report)?, people(others, cast, report)?))
        }
        (two @ [_, _], Measured::Contact | Measured::Vehicles)
            if two.iter().any(|one| cast.streams.contains(&one.text())) =>
        {
            let named = two.iter().find(|one| cast.streams.contains(&one.text()))?;
            report.push(no_stream_here(*named));
            None
        }
        ([car, other], Measured::Contact) => {
            let car = vehicle(*car, report)?;
            let other = solid(*other, &car, cast, report)?;
            Some(Subjects::of(car, (other, Vec::new())))
        }
        ([car, other], Measured::Vehicles) => {
            let car = vehicle(*car, report)?;
            let another = vehicle(*other, report)?;
            if car == another {
                report.push(touches_itself(*other, &car, "name another vehicle"));
                return None;
            }
            Some(Subjects::of(car, (another, Vec::new())))
        }
        ([car, others @ ..], Measured::Pair)
            if others.len() == 1 || (others.len() > 1 && others.iter().all(is_person)) =>
        {
            let (car, people) = (traffic(*car, report), people(others, cast, report));
            Some(Subjects::of_traffic(car?, people?))
        }
        ([stream, others @ ..], Measured::Stream)
            if others.len() == 1 || (others.len() > 1 && others.iter().all(is_person)) =>
        {
            if !cast.streams.contains(&stream.text()) {
                report.push(unknown_stream(*stream, cast));
                return None;
            }
            let stream = Traffic { name: stream.text().to_string(), is_stream: true };
            Some(Subjects::of_traffic(stream, people(others, cast, report)?))
        }
        ([car], Measured::Vehicle) => {
            let person = first(&cast.pedestrians)?;
            Some(Subjects::of_traffic(traffic(*car, report)?, (person, Vec::new())))
        }
        (others, Measured::Pedestrian) if others.len() == 1 || others.iter().all(is_person) => {
            let people = people(others, cast, report)?;
            Some(Subjects::of(first(&cast.vehicles)?, people))
        }
        _ => {
            let name = &metric.declaration.name;
            let (whom, example) = match metric.scope {
                Measured::Pair => ("a vehicle and a pedestrian", format!("{name}(av, walker)")),
                Measured::Stream => ("a stream and a pedestrian", format!("{name}(cars, walker)")),
                Measured::Contact => ("a vehicle and what it touches", format!("{name}(av, walker)")),
                Measured::Vehicles => ("two vehicles", format!("{name}(av, other)")),
                Measured::Vehicle => ("a vehicle", format!("{name}(av)")),
                Measured::Pedestrian => ("a pedestrian", format!("{name}(walker)")),
            };
            report.push(
                Diagnostic::new(Code::BadPair, details.span(), format!("`{name}` is measured for {whom}"))
                    .label(format!("{} named here", names.len()))
                    .hint(format!("write `{example}`")),
            );
            None
        }
    }
}

/// What two vehicles, or a vehicle and a box, have to do with each other is not followed for every vehicle of a stream.
fn no_stream_here(name: ast::Name) -> Diagnostic {
    let one = TrafficStream::member_name(name.text(), 0);
    let message = format!("`{}` is a stream, and this is of single vehicles", name.text());
    Diagnostic::new(Code::BadPair, name.span(), message)
        .label("of which vehicle?")
        .hint(format!("name a vehicle of it, such as `{one}`"))
}

fn unknown_stream(name: ast::Name, cast: &Cast) -> Diagnostic {
    let (message, label) = match cast.vehicles.contains(&name.text()) {
        true => (format!("`{}` is a vehicle, and this is of a stream", name.text()), "not a stream"),
        false => (format!("the scenario has no stream `{}`", name.text()), "unknown stream"),
    };
    Diagnostic::new(Code::BadPair, name.span(), message)
        .label(label)
        .suggest(name.text(), cast.streams.iter().copied())
}

fn touches_itself(name: ast::Name, vehicle: &str, hint: &str) -> Diagnostic {
    Diagnostic::new(Code::TouchesItself, name.span(), format!("`{vehicle}` never touches itself"))
        .label("the same vehicle")
        .hint(hint)
}

/// Anything but `vehicle` that it may touch.
fn solid(name: ast::Name, vehicle: &str, cast: &Cast, report: &mut Vec<Diagnostic>) -> Option<String> {
    let groups = cast.groups.iter().map(|(group, _)| *group);
    let all = groups.chain(cast.pedestrians.iter().chain(&cast.vehicles).chain(&cast.boxes).copied());
    if name.text() == vehicle {
        let hint =
            "name a pedestrian, another vehicle or a box of the road; or nothing, for whatever it touches";
        report.push(touches_itself(name, vehicle, hint));
        return None;
    }
    if all.clone().any(|known| known == name.text()) {
        return Some(name.text().to_string());
    }
    report.push(
        Diagnostic::new(
            Code::UnknownSolid,
            name.span(),
            format!("the scenario has no pedestrian, vehicle or box `{}`", name.text()),
        )
        .label("nothing of this name")
        .suggest(name.text(), all.filter(|known| *known != vehicle)),
    );
    None
}
