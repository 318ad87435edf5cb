//! Two runs over time, in the same pictures: A and B are told apart by colour and dash, everybody has pictures of their own.

use serde::Serialize;

use super::asked::{AskedOfRun, RunReading};
use super::pairs::{DrawnPair, MOST_PAIRS, MOST_USERS, drawn_pairs};
use super::plots::{AFTER, LONGEST, Points, above, of_places, said, slopes};
use crate::chart::{AxisQuantity, Look, OverTime, Rule, TimeMark, TimeSeries};
use crate::diff::LETTERS;
use results::Recording;
use scenario::Dimension;

/// One of the two.
pub struct DrawnSide<'r> {
    pub recording: &'r Recording,
    pub asked: AskedOfRun<'r>,
}

/// What is drawn of both over time.
#[derive(Debug, Serialize)]
pub struct DiffPlots {
    /// First and last time, s.
    from: f64,
    to: f64,
    /// SVG elements.
    panels: Vec<String>,
    /// What is not drawn; empty if everything is.
    left_out: String,
}

/// The looks of A and of B.
pub fn looks() -> [Look; 2] {
    [Look::series(0), Look::series(1)]
}

/// A plot in the making.
struct Plot<'p> {
    title: String,
    name: &'p str,
    dimension: Dimension,
    /// Of A and of B.
    points: [Points; 2],
    /// The metric that is about the same, if there is one, and the sign that turns it into what is drawn.
    metric: Option<(&'p str, f64)>,
    /// SI units.
    ceiling: Option<f64>,
}

struct Drawing<'s, 'r> {
    sides: &'s [DrawnSide<'r>; 2],
    span: (f64, f64),
    moment: Option<f64>,
}

impl DiffPlots {
    /// `moment` is marked, s.
    pub fn new(sides: &[DrawnSide; 2], moment: Option<f64>) -> Self {
        let ends = sides.each_ref().map(|side| side.recording.times.last().copied().unwrap_or(0.0));
        let end = ends[0].max(ends[1]).max(0.1);
        let last = moment.map_or(end, |moment| {
            let last = sides.iter().map(|side| side.asked.last(moment)).fold(moment, f64::max);
            ((last + AFTER) * 10.0).round() / 10.0
        });
        let to = if last < 0.75 * end { last } else { end };
        let drawing = Drawing { sides, span: (0.0, to), moment };
        let users = drawing.users();
        let mut panels: Vec<Option<String>> = Vec::new();
        for name in users.iter().take(MOST_USERS) {
            panels.push(drawing.speed(name));
        }
        let is_car =
            |name: &&String| sides[0].recording.case.world.vehicles.iter().any(|car| car.name == **name);
        for name in users.iter().take(MOST_USERS).filter(is_car) {
            panels.push(drawing.acceleration(name));
        }
        let (pairs, pairs_left_out) = drawing.pairs();
        for pair in &pairs {
            panels.extend([drawing.distance(pair), drawing.time_to_collision(pair)]);
        }
        let users_left_out = users.len().saturating_sub(MOST_USERS);
        let mut left_out: Vec<String> = Vec::new();
        if users_left_out > 0 {
            left_out.push(format!("Road users that are not drawn: {users_left_out}."));
        }
        if pairs_left_out > 0 {
            left_out.push(format!("Pairs of which nothing is drawn: {pairs_left_out}."));
        }
        if to < end {
            left_out
                .push(format!("Nothing is drawn after {to:.1} s; the runs went on to {end:.1} s at most."));
        }
        Self { from: 0.0, to, panels: panels.into_iter().flatten().collect(), left_out: left_out.join(" ") }
    }
}

impl Drawing<'_, '_> {
    /// Everybody of both, vehicles first.
    fn users(&self) -> Vec<String> {
        let [a, b] = self.sides.each_ref().map(|side| names(side.recording));
        let only_b = b.iter().filter(|name| !a.contains(name)).cloned();
        let mut all: Vec<String> = a.iter().cloned().chain(only_b).collect();
        let is_person = |name: &String| {
            let mut cars = self.sides.iter().flat_map(|side| &side.recording.case.world.vehicles);
            !cars.any(|car| car.name == *name)
        };
        all.sort_by_key(is_person);
        all
    }

    /// What is drawn of somebody in both; nothing of who is not there.
    fn of(&self, name: &str, each: impl Fn(&Recording, usize) -> Points) -> [Points; 2] {
        self.sides.each_ref().map(|side| {
            let who = names(side.recording).iter().position(|one| one == name);
            who.map_or_else(Vec::new, |who| each(side.recording, who))
        })
    }

    fn speed(&self, name: &str) -> Option<String> {
        let points = self.of(name, |recording, who| of_places(recording, who, |place| place.speed));
        let title = format!("Speed of {name}");
        let plot =
            Plot { title, name: "speed", dimension: Dimension::SPEED, points, metric: None, ceiling: None };
        self.draw(plot, |_, _| false)
    }

    fn acceleration(&self, name: &str) -> Option<String> {
        let points = self.of(name, |recording, who| slopes(&of_places(recording, who, |place| place.speed)));
        let plot = Plot {
            title: format!("Acceleration of {name}"),
            name: "slope of the speed over 0.1 s",
            dimension: Dimension::ACCELERATION,
            points,
            metric: Some(("max_deceleration", -1.0)),
            ceiling: None,
        };
        self.draw(plot, |recording, reading| {
            reading.vehicle.is_some_and(|vehicle| recording.name(vehicle) == name)
        })
    }

    /// The pairs that are drawn, those of A first, by the names of a vehicle and a pedestrian; and how many more there are.
    fn pairs(&self) -> (Vec<(String, String)>, usize) {
        let mut all: Vec<(String, String)> = Vec::new();
        let mut left_out = 0;
        for DrawnSide { recording, asked } in self.sides {
            let cars = recording.case.world.vehicles.len();
            let (pairs, more) = drawn_pairs(asked, recording, 0);
            left_out = left_out.max(more);
            let name = |pair: &DrawnPair| {
                let (car, person) = (recording.name(pair.vehicle), recording.name(cars + pair.pedestrian));
                (car.to_string(), person.to_string())
            };
            for pair in pairs.iter().map(name) {
                if !all.contains(&pair) {
                    all.push(pair);
                }
            }
        }
        left_out += all.len().saturating_sub(MOST_PAIRS);
        all.truncate(MOST_PAIRS);
        (all, left_out)
    }

    fn of_pair(
        &self,
        (car, person): &(String, String),
        each: impl Fn(&Recording, DrawnPair) -> Points,
    ) -> [Points; 2] {
        self.sides.each_ref().map(|side| {
            let world = &side.recording.case.world;
            let vehicle = world.vehicles.iter().position(|one| one.name == *car);
            let pedestrian = world.pedestrians.iter().position(|one| one.name == *person);
            vehicle.zip(pedestrian).map_or_else(Vec::new, |(vehicle, pedestrian)| {
                let pair = DrawnPair::of(side.recording, vehicle, pedestrian, Look::series(0));
                each(side.recording, pair)
            })
        })
    }

    fn distance(&self, pair: &(String, String)) -> Option<String> {
        let plot = Plot {
            title: format!("Distance between {} and {}", pair.0, pair.1),
            name: "distance every 0.1 s",
            dimension: Dimension::LENGTH,
            points: self.of_pair(pair, |_, pair| pair.distances),
            metric: Some(("min_distance", 1.0)),
            ceiling: None,
        };
        self.draw(plot, |recording, reading| is_of(recording, reading, pair))
    }

    fn time_to_collision(&self, pair: &(String, String)) -> Option<String> {
        let plot = Plot {
            title: format!("Time to collision of {} and {}", pair.0, pair.1),
            name: "every 0.1 s; a gap: on no collision course",
            dimension: Dimension::TIME,
            points: self.of_pair(pair, |recording, pair| pair.times_to_collision(recording, false)),
            metric: Some(("min_ttc", 1.0)),
            ceiling: Some(LONGEST),
        };
        self.draw(plot, |recording, reading| is_of(recording, reading, pair))
    }

    /// In the unit of the criteria, as other pages draw it; `None` where there is nothing to draw.
    fn draw(&self, plot: Plot, is_its: impl Fn(&Recording, &RunReading) -> bool) -> Option<String> {
        let Plot { title, name, dimension, points, metric, ceiling } = plot;
        if !points.iter().flatten().any(|point| point.1.is_some()) {
            return None;
        }
        let (metric, sign) = metric.unwrap_or(("", 1.0));
        let unit = self.sides.iter().find_map(|side| side.asked.unit(metric, dimension));
        let in_unit = |value: f64| unit.map_or(value, |unit| unit.of_si(value));
        let mut rules: Vec<Rule> = Vec::new();
        let mut marks = Vec::new();
        for ((side, look), letter) in self.sides.iter().zip(looks()).zip(LETTERS) {
            for rule in side.asked.rules(metric, sign, unit, |_| true) {
                if !rules.contains(&rule) {
                    rules.push(rule);
                }
            }
            let its = side.asked.of(metric).filter(|reading| is_its(side.recording, reading));
            marks.extend(its.filter_map(|reading| {
                Some(TimeMark {
                    look,
                    time: reading.time?,
                    value: sign * in_unit(reading.value?),
                    label: format!("{letter}: {}", reading.words(unit)),
                })
            }));
        }
        let series = points.into_iter().zip(looks()).zip(LETTERS).map(|((points, look), name)| {
            let in_unit = |(time, value): (f64, Option<f64>)| (time, value.map(in_unit));
            TimeSeries { look, name: name.into(), points: points.into_iter().map(in_unit).collect() }
        });
        let series: Vec<TimeSeries> = series.filter(|one| !one.points.is_empty()).collect();
        let (from, to) = self.span;
        let ceiling = ceiling.map(|ceiling| above(in_unit(ceiling), &series, &rules));
        let y = AxisQuantity::new(name, said(unit, dimension));
        let plot = OverTime { title, y, from, to, series, rules, moment: self.moment, marks, ceiling };
        Some(plot.to_svg())
    }
}

/// Everybody of a run, vehicles first.
fn names(recording: &Recording) -> Vec<String> {
    (0..recording.users.len()).map(|who| recording.name(who).to_string()).collect()
}

fn is_of(recording: &Recording, reading: &RunReading, (car, person): &(String, String)) -> bool {
    let world = &recording.case.world;
    let vehicle = reading.vehicle.is_some_and(|index| world.vehicles[index].name == *car);
    vehicle && reading.pedestrian.is_some_and(|index| world.pedestrians[index].name == *person)
}
