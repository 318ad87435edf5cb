//! A run over time: speeds, accelerations, distances, times to collision and who is in the shared area, each a picture with the same horizontal axis.
//! They are SVG that is made here, so that they can be read and printed without JavaScript; the page's script only moves a line over them.

use serde::Serialize;

use super::asked::{AskedOfRun, RunReading};
use super::margins::{self, MeasuredOverTime};
use super::minds::{self, Picture};
use super::pairs::{DrawnPair, MOST_PAIRS, MOST_USERS, drawn_pairs, goes_straight, user_look};
use super::shared_area;
use super::told::find;
use crate::chart::{AxisQuantity, First, LOOKS, Look, OverTime, Rule, TimeMark, TimeSeries};
use results::{Place, Recording, Requests, SuiteReport};
use scenario::{Dimension, MetricReference, Notation};

// Each line has a look of its own, so that one legend tells them apart.
const _: () = assert!(MOST_USERS + MOST_PAIRS <= LOOKS);

/// So long after the moment that is marked, and after all that metrics took their values of, is drawn, s: what comes later would press
/// together what matters.
pub(super) const AFTER: f64 = 3.0;

/// Times to collision above this are not drawn, unless something is asked of them, s.
pub(super) const LONGEST: f64 = 10.0;

/// Times in s with values; without one there is a gap.
pub(super) type Points = Vec<(f64, Option<f64>)>;

/// What is drawn of a run over time.
#[derive(Debug, Serialize)]
pub struct RunPlots {
    /// First and last time, s.
    from: f64,
    to: f64,
    /// Swatch and words.
    legend: Vec<(String, String)>,
    panels: Vec<Picture>,
    /// Which moment is marked, in words; empty if none is.
    moment: String,
    /// What is not drawn.
    left_out: String,
}

/// A plot in the making.
struct Plot<'p> {
    title: &'p str,
    name: &'p str,
    dimension: Dimension,
    series: Vec<TimeSeries>,
    /// The metric that is about the same, if there is one, and the sign that turns it into what is drawn.
    metric: Option<(&'p str, f64)>,
    /// SI units.
    ceiling: Option<f64>,
}

impl RunPlots {
    /// `moment` is marked, s.
    pub fn new(
        reports: &[SuiteReport],
        requests: &Requests,
        recording: &Recording,
        moment: Option<f64>,
    ) -> Self {
        let times = &recording.times;
        let (from, to) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(1.0));
        let end = if to > from { to } else { from + 1.0 };
        let cars = recording.case.world.vehicles.len();
        let shown = recording.users.len().min(MOST_USERS);
        let look_of = |who: usize| user_look(recording, who).unwrap_or_else(|| First::Neither.look());
        let users = || (0..shown).map(|who| (who, look_of(who), recording.name(who)));
        let asked = AskedOfRun::new(reports, requests, recording);
        let to = moment.map_or(end, |moment| {
            let last = ((asked.last(moment) + AFTER) * 10.0).round() / 10.0;
            if last - from < 0.75 * (end - from) { last } else { end }
        });
        let (pairs, pairs_left_out) = drawn_pairs(&asked, recording, shown);
        let of = |each: &dyn Fn(usize) -> Points| -> Vec<TimeSeries> {
            let series = |(who, look, name): (usize, Look, &str)| TimeSeries {
                look,
                name: name.into(),
                points: each(who),
            };
            users().map(series).collect()
        };
        let of_pairs = |each: &dyn Fn(&DrawnPair) -> Points| -> Vec<TimeSeries> {
            let series = |pair: &DrawnPair| TimeSeries {
                look: pair.look,
                name: pair.name.clone(),
                points: each(pair),
            };
            pairs.iter().map(series).filter(|one| one.points.iter().any(|point| point.1.is_some())).collect()
        };
        // Whose look a reading has, and what it is called besides if that is in no legend.
        let look = |reading: &RunReading| {
            let pair = pairs.iter().find(|pair| {
                reading.pedestrian == Some(pair.pedestrian) && reading.vehicle == Some(pair.vehicle)
            });
            match (pair, reading.vehicle, reading.pedestrian) {
                (Some(pair), ..) => (pair.look, String::new()),
                (None, Some(car), None) if car < shown => (look_of(car), String::new()),
                (None, Some(car), Some(person)) => {
                    let (car, person) = (recording.name(car), recording.name(cars + person));
                    (First::Neither.look(), format!(", {car} and {person}"))
                }
                (None, Some(car), None) => (First::Neither.look(), format!(", {}", recording.name(car))),
                (None, None, _) => (First::Neither.look(), String::new()),
            }
        };
        let marked = std::cell::Cell::new(None);
        // In the unit of the criteria, as tables and charts are.
        let over = |plot: Plot, is_drawn: &dyn Fn(&MetricReference) -> bool| {
            let Plot { title, name, dimension, mut series, metric, ceiling } = plot;
            let (metric, sign) = metric.unwrap_or(("", 1.0));
            let unit = asked.unit(metric, dimension);
            let in_unit = |value: f64| unit.map_or(value, |unit| unit.of_si(value));
            let points = series.iter_mut().flat_map(|one| &mut one.points);
            points.filter_map(|point| point.1.as_mut()).for_each(|value| *value = in_unit(*value));
            let y = AxisQuantity::new(name, said(unit, dimension));
            let rules = asked.rules(metric, sign, unit, is_drawn);
            let marks = asked.of(metric).filter(|reading| is_drawn(reading.metric)).filter_map(|reading| {
                let (look, whose) = look(reading);
                Some(TimeMark {
                    look,
                    time: reading.time?,
                    value: sign * in_unit(reading.value?),
                    label: format!("{}{whose}", reading.words(unit)),
                })
            });
            let marks: Vec<TimeMark> = marks.collect();
            marked.set(marked.get().or(marks.first().map(|mark| mark.look)));
            let is_empty = series.is_empty() && marks.is_empty();
            let ceiling = ceiling.map(|ceiling| above(in_unit(ceiling), &series, &rules));
            let plot = OverTime { title: title.into(), y, from, to, series, rules, moment, marks, ceiling };
            (!is_empty).then(|| plot.to_svg())
        };
        let speeds = of(&|who| of_places(recording, who, |place| place.speed));
        // People stop and set off at once, which says nothing and would hide the vehicles'.
        let mut accelerations = of(&|who| slopes(&of_places(recording, who, |place| place.speed)));
        accelerations.truncate(cars);
        let all = |_: &MetricReference| true;
        let plain = |title, name, dimension, series, metric| Plot {
            title,
            name,
            dimension,
            series,
            metric,
            ceiling: None,
        };
        let mut panels = vec![
            over(plain("Speeds", "speed", Dimension::SPEED, speeds, None), &all),
            over(
                plain(
                    "Accelerations of vehicles",
                    "slope of the speed over 0.1 s",
                    Dimension::ACCELERATION,
                    accelerations,
                    Some(("max_deceleration", -1.0)),
                ),
                &all,
            ),
        ];
        let distances = of_pairs(&|pair| pair.distances.clone());
        let metric = Some(("min_distance", 1.0));
        let title = "Distances between bodies";
        panels.push(over(plain(title, "distance every 0.1 s", Dimension::LENGTH, distances, metric), &all));
        let ahead = |title, straight| Plot {
            title,
            name: "every 0.1 s; a gap: on no collision course",
            dimension: Dimension::TIME,
            series: of_pairs(&|pair| pair.times_to_collision(recording, straight)),
            metric: Some(("min_ttc", 1.0)),
            ceiling: Some(LONGEST),
        };
        // Of a vehicle that never bends both predictions are the same.
        let bends = recording.meetings.iter().any(|pair| !pair.straight_on.is_empty());
        let along = |metric: &MetricReference| !bends || !goes_straight(metric);
        panels.push(over(ahead("Time to collision", false), &along));
        if asked.of("min_ttc").any(|reading| !along(reading.metric)) {
            panels.push(over(ahead("Time to collision, straight on", true), &goes_straight));
        }
        let outcome = find(reports, &recording.case.key).map(|(_, outcome)| outcome);
        let shown_above = ["max_deceleration", "min_distance", "min_ttc"];
        let measured = margins::measured(asked.criteria, outcome, requests, recording, &shown_above);
        for MeasuredOverTime { metric, title, dimension, points } in measured {
            let is_it = |other: &MetricReference| other.is_same(metric);
            let series = TimeSeries { look: First::Neither.look(), name: title.clone(), points };
            panels.push(over(
                Plot {
                    title: &title,
                    name: "worst since the time before; a gap: none",
                    dimension,
                    series: vec![series],
                    metric: Some((metric.name(), 1.0)),
                    ceiling: (dimension == Dimension::TIME).then_some(LONGEST),
                },
                &is_it,
            ));
        }
        let rows = pairs.iter().filter_map(|pair| {
            let looks = (look_of(pair.vehicle), look_of(cars + pair.pedestrian));
            Some(shared_area::rows(&asked, recording, pair.details(recording)?, looks))
        });
        panels.push(shared_area::picture(rows.flatten().collect(), (from, to), moment));
        let margins = margins::pictures(reports, requests, recording, (from, to), moment);
        let first: Vec<usize> = pairs.iter().map(|pair| pair.pedestrian).collect();
        let (minds, minds_left_out) = minds::pictures(recording, &first, (from, to), moment);
        let users_left_out = recording.users.len() - shown;
        let left_out = match (users_left_out, pairs_left_out) {
            (0, 0) => String::new(),
            (0, pairs) => format!(
                "Of {pairs} more pairs nothing is drawn: those that metrics took their values of come first, then those that come nearest."
            ),
            (users, 0) => format!("{users} more road users are not drawn."),
            (users, pairs) => {
                format!("{users} more road users and what is between {pairs} more pairs are not drawn.")
            }
        };
        let left_out = match minds_left_out {
            0 => left_out,
            people => {
                format!("{left_out} What {people} more people make of it is not drawn.").trim_start().into()
            }
        };
        let left_out = match to < end {
            true => format!("{left_out} Nothing is drawn after {to:.1} s; the run went on to {end:.1} s.")
                .trim_start()
                .into(),
            false => left_out,
        };
        let line = |look: Look, name: &str| (look.swatch(true, false), name.to_string());
        let mut legend: Vec<_> = users().map(|(_, look, name)| line(look, name)).collect();
        legend.extend(pairs.iter().map(|pair| line(pair.look, &pair.name)));
        if let Some(look) = marked.get() {
            let words = "single marks, each in the shape of whose it is: what a metric came to, from every step of the run";
            legend.push((look.swatch(false, true), words.into()));
        }
        let moment = moment.map_or_else(String::new, |time| format!("upright line: {time:.2} s"));
        let panels = panels.into_iter().flatten().map(Picture::plain).chain(margins).chain(minds);
        Self { from, to, legend, panels: panels.collect(), moment, left_out }
    }

    /// How much of a page it takes, in bytes.
    pub fn size(&self) -> usize {
        let legend = self.legend.iter().map(|(swatch, words)| swatch.len() + words.len());
        legend.chain(self.panels.iter().map(Picture::size)).sum()
    }
}

pub(super) fn said(unit: Option<Notation>, dimension: Dimension) -> String {
    unit.map_or_else(|| dimension.si_unit(), |unit| unit.symbol.as_str().to_string())
}

/// Where lines end above: at `ceiling`, or higher where a bound, or all that there is, would be too near to that or beyond.
pub(super) fn above(ceiling: f64, series: &[TimeSeries], rules: &[Rule]) -> f64 {
    let values = series.iter().flat_map(|one| &one.points).filter_map(|point| point.1);
    let lowest = values.reduce(f64::min).unwrap_or(0.0);
    rules.iter().map(|rule| rule.value).chain([lowest]).map(|value| 1.2 * value).fold(ceiling, f64::max)
}

pub(super) fn of_places(recording: &Recording, who: usize, pick: impl Fn(&Place) -> f64) -> Points {
    let places = recording.times.iter().zip(&recording.users[who]);
    places.map(|(time, place)| (*time, place.as_ref().map(&pick))).collect()
}

/// The slope between each two points, at the time between them.
pub(super) fn slopes(points: &[(f64, Option<f64>)]) -> Points {
    let far = points.windows(2).filter(|pair| pair[1].0 - pair[0].0 > 1e-3);
    let slope = |pair: &[(f64, Option<f64>)]| {
        let ((from, before), (to, after)) = (pair[0], pair[1]);
        ((from + to) / 2.0, before.zip(after).map(|(before, after)| (after - before) / (to - from)))
    };
    far.map(slope).collect()
}
