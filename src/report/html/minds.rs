//! What pedestrians' models made of a run, over time and for the page's script: such as what each action is worth to a person.

use serde::Serialize;
use serde_json::{Value, json};

use crate::chart::{AxisQuantity, Look, OverTime, TimeSeries};
use results::Recording;
use sim::StateQuantity;
use sim::measure::PersonDetails;

/// Of more people than this nothing is drawn.
const MOST_PEOPLE: usize = 2;

/// A picture with lines of its own.
#[derive(Debug, Default, Serialize)]
pub struct Picture {
    /// An SVG element.
    pub svg: String,
    /// Swatch and words.
    pub legend: Vec<(String, String)>,
    /// What else there is to say of it.
    pub words: String,
}

impl Picture {
    /// One that the legend of all is about.
    pub fn plain(svg: String) -> Self {
        Self { svg, ..Self::default() }
    }

    /// How much of a page it takes, in bytes.
    pub fn size(&self) -> usize {
        let legend = self.legend.iter().map(|(swatch, words)| swatch.len() + words.len());
        legend.sum::<usize>() + self.svg.len() + self.words.len()
    }
}

/// The quantities of one group, and where their values begin.
fn groups(quantities: &[StateQuantity]) -> impl Iterator<Item = (usize, &[StateQuantity])> {
    let groups = quantities.chunk_by(|one, other| one.group == other.group);
    groups.scan(0, |next, group| {
        let first = *next;
        *next += group.len();
        Some((first, group))
    })
}

/// The models that say something, with the places of their people in the world: those that are `first`, and then all others.
fn told<'r>(recording: &'r Recording, first: &[usize]) -> Vec<(usize, &'r PersonDetails)> {
    let says = |(_, person): &(usize, &PersonDetails)| person.states.iter().any(Option::is_some);
    let mut all: Vec<_> = recording.states.iter().enumerate().filter(says).collect();
    all.sort_by_key(|(index, _)| first.iter().position(|one| one == index).unwrap_or(usize::MAX));
    all
}

/// The quantities of people over time, a picture for each group, of those that are `first` before all others; and of how many people there
/// would be more.
pub fn pictures(
    recording: &Recording,
    first: &[usize],
    (from, to): (f64, f64),
    moment: Option<f64>,
) -> (Vec<Picture>, usize) {
    let all = told(recording, first);
    let left_out = all.len().saturating_sub(MOST_PEOPLE);
    let cars = recording.case.world.vehicles.len();
    let mut pictures = Vec::new();
    for (index, person) in all.into_iter().take(MOST_PEOPLE) {
        let words = whom(recording, person);
        for (first, group) in groups(&person.quantities) {
            let series = group.iter().enumerate().map(|(offset, quantity)| TimeSeries {
                look: Look::series(offset),
                name: quantity.name.clone(),
                points: points(recording, person, first + offset),
            });
            let series: Vec<TimeSeries> = series.collect();
            let line = |one: &TimeSeries| (one.look.swatch(true, false), one.name.clone());
            let legend = series.iter().map(line).collect();
            let plot = OverTime {
                title: format!("{}: {}", recording.name(cars + index), group[0].group),
                y: AxisQuantity::new("as of the last decision, every 0.1 s", ""),
                from,
                to,
                series,
                rules: Vec::new(),
                moment,
                marks: Vec::new(),
                ceiling: None,
            };
            pictures.push(Picture { svg: plot.to_svg(), legend, words: words.clone() });
        }
    }
    (pictures, left_out)
}

/// The values of a quantity over time. Between two that are about different vehicles there is a gap.
fn points(recording: &Recording, person: &PersonDetails, quantity: usize) -> Vec<(f64, Option<f64>)> {
    let mut points = Vec::with_capacity(recording.times.len());
    let mut about = None;
    for (time, state) in recording.times.iter().zip(&person.states) {
        let now = state.as_ref().map(|state| state.about);
        if about.is_some() && now.is_some() && about != now {
            points.push((*time, None));
        }
        points.push((*time, state.as_ref().and_then(|state| state.values.get(quantity).copied())));
        about = now;
    }
    points
}

/// Which vehicles it is about, in the order of time.
fn whom(recording: &Recording, person: &PersonDetails) -> String {
    let about = person.states.iter().zip(&recording.times);
    let cars = recording.case.world.vehicles.len();
    let about = about.filter_map(|(state, time)| Some((state.as_ref()?.about?, *time)));
    let about = about.filter(|(vehicle, _)| *vehicle < cars);
    let mut changes: Vec<(usize, f64)> = about.collect();
    changes.dedup_by_key(|(vehicle, _)| *vehicle);
    let Some(((vehicle, _), later)) = changes.split_first() else { return String::new() };
    let mut words = format!("about {}", recording.name(*vehicle));
    for (vehicle, time) in later.iter().take(4) {
        words += &format!(", from {time:.1} s on about {}", recording.name(*vehicle));
    }
    if later.len() > 4 {
        words += ", and so on";
    }
    if !later.is_empty() {
        words += "; lines end where that changes";
    }
    words
}

/// The same of one person as the page's script reads it: groups of names with their range, and per time the vehicle (its place in the world)
/// with the values; `None` of a model that says nothing.
pub fn embedded(recording: &Recording, pedestrian: usize) -> Option<Value> {
    let person = recording.states.get(pedestrian)?;
    person.states.iter().any(Option::is_some).then(|| {
        let groups = groups(&person.quantities).map(|(_, group)| {
            let names: Vec<&str> = group.iter().map(|one| one.name.as_str()).collect();
            let (low, high) = group[0].range;
            json!([group[0].group, names, low, high])
        });
        let states = person.states.iter().map(|state| {
            let Some(state) = state else { return Value::Null };
            let values = state.values.iter().map(|value| thousandths(*value));
            let about = state.about.filter(|vehicle| *vehicle < recording.case.world.vehicles.len());
            let about = about.map_or(Value::Null, |vehicle| json!(vehicle));
            Value::Array([about].into_iter().chain(values).collect())
        });
        json!({ "groups": groups.collect::<Vec<_>>(), "at": states.collect::<Vec<_>>() })
    })
}

fn thousandths(value: f64) -> Value {
    let thousandths = (value * 1000.0).round();
    match thousandths % 1000.0 == 0.0 {
        true => json!((thousandths / 1000.0) as i64),
        false => json!(thousandths / 1000.0),
    }
}
