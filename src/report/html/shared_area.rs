//! When a vehicle and a person were in the area that they share, and what time was between them: what `pet` and `pet_area` measure. The times are
//! those of the run itself, to the fraction of a step, as metrics have them.

use super::asked::{AskedOfRun, RunReading};
use crate::chart::{Gap, Look, SpanRow, Spans, TimeSpan};
use results::Recording;
use scenario::Dimension;
use sim::measure::{PairDetails, Reached};

/// The rows of a pair; none where neither came into the way of the other.
pub fn rows(
    asked: &AskedOfRun,
    recording: &Recording,
    pair: &PairDetails,
    looks: (Look, Look),
) -> Vec<SpanRow> {
    if pair.visits.is_empty() && pair.passings.is_empty() {
        return Vec::new();
    }
    let cars = recording.case.world.vehicles.len();
    let (car, person) = (recording.name(pair.vehicle), recording.name(cars + pair.pedestrian));
    let row = |name: String, look: Look, spans: Vec<TimeSpan>, ticks: Vec<f64>| SpanRow {
        name,
        look,
        spans,
        ticks,
        gap: None,
    };
    let stays = pair.visits.iter().map(|visit| TimeSpan { from: Some(visit.from), to: visit.to }).collect();
    let passes = pair.passings.iter().map(|passing| passing.pedestrian).collect();
    let drives: Vec<TimeSpan> =
        pair.visits.iter().filter_map(|visit| driven(visit.enters, visit.leaves)).collect();
    let passed: Vec<f64> = pair.passings.iter().filter_map(|passing| passing.vehicle.time()).collect();
    let misses = if drives.is_empty() && passed.is_empty() { ": not there in this run" } else { "" };
    let mut rows = vec![
        row(format!("{person} in the way of {car}"), looks.1, stays, passes),
        row(format!("{car} where {person} crosses{misses}"), looks.0, drives, passed),
    ];
    for reading in asked.of("pet").chain(asked.of("pet_area")) {
        let is_its = (reading.vehicle, reading.pedestrian) == (Some(pair.vehicle), Some(pair.pedestrian));
        if is_its {
            rows.push(gap_row(asked, pair, reading));
        }
    }
    rows
}

/// When a vehicle was in an area; `None` if it never was.
fn driven(enters: Reached, leaves: Reached) -> Option<TimeSpan> {
    (enters != Reached::NotYet && leaves != Reached::BeforeStart)
        .then(|| TimeSpan { from: enters.time(), to: leaves.time() })
}

/// The time between the two, as the metric has it.
fn gap_row(asked: &AskedOfRun, pair: &PairDetails, reading: &RunReading) -> SpanRow {
    let unit = asked.unit(reading.metric.name(), Dimension::TIME);
    let between = match pair.contact {
        Some(contact) => Some((contact, contact)),
        None if reading.metric.name() == "pet" => nearest_passing(pair),
        None => nearest_stay(pair),
    };
    let least = reading.least(asked, unit);
    let mut name = reading.words(unit);
    if pair.contact.is_some() && reading.value == Some(0.0) {
        name += ", since they touch";
    }
    let gap = between.filter(|_| reading.value.is_some()).map(|(from, to)| Gap {
        from,
        to,
        needed: least.as_ref().map(|(bound, _)| *bound),
        fails: reading.fails,
    });
    if let Some((_, label)) = &least {
        name += &format!(" ({}: {label})", if gap.is_some() { "dashed" } else { "asked for" });
    }
    SpanRow { name, look: Look::series(0), spans: Vec::new(), ticks: Vec::new(), gap }
}

/// When the two centres passed a conflict point one after the other, where that was nearest in time.
fn nearest_passing(pair: &PairDetails) -> Option<(f64, f64)> {
    let times = pair.passings.iter().filter_map(|one| Some((one.pedestrian, one.vehicle.time()?)));
    shortest(times.map(|(one, other)| (one.min(other), one.max(other))))
}

/// From when the first had left to when the second came, where that was nearest in time; of an overlap its beginning.
fn nearest_stay(pair: &PairDetails) -> Option<(f64, f64)> {
    let times = pair.visits.iter().filter_map(|visit| {
        driven(visit.enters, visit.leaves)?;
        let (enters, leaves) = (visit.enters.moment(), visit.leaves.moment());
        let to = visit.to.unwrap_or(f64::INFINITY);
        Some(match (enters > to, visit.from > leaves) {
            (true, _) => (to, enters),
            (_, true) => (leaves, visit.from),
            _ => (enters.max(visit.from), enters.max(visit.from)),
        })
    });
    shortest(times)
}

/// The first of the shortest.
fn shortest(spans: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    spans.reduce(|one, other| if other.1 - other.0 < one.1 - one.0 { other } else { one })
}

/// A picture of such rows, if there are any.
pub fn picture(rows: Vec<SpanRow>, (from, to): (f64, f64), moment: Option<f64>) -> Option<String> {
    let title = "Who is in the shared area".to_string();
    (!rows.is_empty()).then(|| Spans { title, from, to, rows, moment }.to_svg())
}
