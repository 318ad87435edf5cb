//! `pet(av, walker)`: a metric with the road users it is for.

use std::sync::Arc;

use super::pedestrian::unknown_vehicle;
use super::road::constants;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::syntax::ast;
use crate::value::{NameScope, ValueKind};
use scenario::registry::Table;
use scenario::{AggregateWord, Metric, MetricKind, MetricReference, Scope as Measured};

/// Who is in the scenario that a criterion is about.
pub struct Cast<'a> {
    pub vehicles: Vec<&'a str>,
    pub pedestrians: Vec<&'a str>,
    /// Of the road.
    pub boxes: Vec<&'a str>,
    /// Whether people are taken from a population, and if so whether there are several.
    pub individuals: Option<bool>,
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
    let pair = match details {
        Some(details) => pair(details, found, cast, report)?,
        None => None,
    };
    Some((MetricReference { metric: found.into(), settings: settings?, pair }, found.clone()))
}

/// The pair that is meant. A metric of one road user has a value with the first of the other kind; contacts of one
/// vehicle, with whatever it touches, have no second name.
fn pair(
    details: ast::Settings,
    metric: &Metric,
    cast: &Cast,
    report: &mut Vec<Diagnostic>,
) -> Option<Option<(String, String)>> {
    let names: Vec<_> = details.names().collect();
    if names.is_empty() {
        return Some(None);
    }
    let mut known = |name: ast::Name, is_vehicle: bool| {
        let known = if is_vehicle { &cast.vehicles } else { &cast.pedestrians };
        if known.contains(&name.text()) {
            return Some(name.text().to_string());
        }
        report.push(if is_vehicle {
            unknown_vehicle(name, known)
        } else {
            Diagnostic::new(
                Code::UnknownPedestrian,
                name.span(),
                format!("the scenario has no pedestrian `{}`", name.text()),
            )
            .label("unknown pedestrian")
            .suggest(name.text(), known.iter().copied())
        });
        None
    };
    if let ([vehicle, others @ ..], Measured::Contact) = (names.as_slice(), metric.scope)
        && others.len() <= 1
    {
        let vehicle = known(*vehicle, true)?;
        let Some(other) = others.first() else { return Some(Some((vehicle, String::new()))) };
        return Some(Some((vehicle.clone(), solid(*other, &vehicle, cast, report)?)));
    }
    let first = |names: &[&str]| names.first().map(|name| name.to_string());
    let pair = match (names.as_slice(), metric.scope) {
        ([vehicle, pedestrian], Measured::Pair) => {
            let (vehicle, pedestrian) = (known(*vehicle, true), known(*pedestrian, false));
            (vehicle?, pedestrian?)
        }
        ([vehicle], Measured::Vehicle) => (known(*vehicle, true)?, first(&cast.pedestrians)?),
        ([pedestrian], Measured::Pedestrian) => {
            let pedestrian = known(*pedestrian, false)?;
            (first(&cast.vehicles)?, pedestrian)
        }
        _ => {
            let name = &metric.declaration.name;
            let (whom, example) = match metric.scope {
                Measured::Pair => ("a vehicle and a pedestrian", format!("{name}(av, walker)")),
                Measured::Contact => ("a vehicle and what it touches", format!("{name}(av, walker)")),
                Measured::Vehicle => ("a vehicle", format!("{name}(av)")),
                Measured::Pedestrian => ("a pedestrian", format!("{name}(walker)")),
            };
            report.push(
                Diagnostic::new(Code::BadPair, details.span(), format!("`{name}` is measured for {whom}"))
                    .label(format!("{} named here", names.len()))
                    .hint(format!("write `{example}`")),
            );
            return None;
        }
    };
    Some(Some(pair))
}

/// Anything but `vehicle` that it may touch.
fn solid(name: ast::Name, vehicle: &str, cast: &Cast, report: &mut Vec<Diagnostic>) -> Option<String> {
    let all = cast.pedestrians.iter().chain(&cast.vehicles).chain(&cast.boxes).copied();
    if name.text() == vehicle {
        report.push(
            Diagnostic::new(Code::TouchesItself, name.span(), format!("`{vehicle}` never touches itself"))
                .label("the same vehicle")
                .hint("name a pedestrian, another vehicle or a box of the road; or nothing, for whatever it touches"),
        );
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
