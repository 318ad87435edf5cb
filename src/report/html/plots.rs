//! A run over time: speeds, accelerations and distances, each a picture with the same horizontal axis. They are SVG that is made here, so that they
//! can be read and printed without JavaScript; the page's script only moves a line over them.

use nalgebra::Vector2;
use serde::Serialize;

use super::told::find;
use crate::chart::{AxisQuantity, LOOKS, LegendEntry, Look, OverTime, Rule, TimeSeries};
use crate::digest::unit_for;
use crate::wording::comparison_rule;
use results::{Place, Recording, SuiteReport};
use scenario::{Aggregate, Claim, Criterion, Dimension, Expression, Notation, Shape, Value};
use sim::geometry::{Footprint, apart};

/// More pairs than this are not drawn: those that come nearest are.
const MOST_PAIRS: usize = 2;
/// More road users than this are not drawn: the first are, vehicles before people.
const MOST_USERS: usize = 4;
// Each line has a look of its own, so that one legend tells them apart.
const _: () = assert!(MOST_USERS + MOST_PAIRS <= LOOKS);

/// What is drawn of a run over time.
#[derive(Debug, Serialize)]
pub struct RunPlots {
    /// First and last time, s.
    from: f64,
    to: f64,
    /// Swatch and words.
    legend: Vec<(String, String)>,
    /// SVG elements.
    panels: Vec<String>,
    /// Which moment is marked, in words; empty if none is.
    moment: String,
    /// What is not drawn.
    left_out: String,
}

impl RunPlots {
    /// `moment` is marked, s.
    pub fn new(reports: &[SuiteReport], recording: &Recording, moment: Option<f64>) -> Self {
        let times = &recording.times;
        let (from, to) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(1.0));
        let to = if to > from { to } else { from + 1.0 };
        let shown = recording.users.len().min(MOST_USERS);
        let users = || (0..shown).map(|who| (who, Look::series(who), recording.name(who)));
        let of = |each: &dyn Fn(usize) -> Vec<(f64, f64)>| -> Vec<TimeSeries> {
            let series = |(who, look, name): (usize, Look, &str)| TimeSeries {
                look,
                name: name.into(),
                points: each(who),
            };
            users().map(series).collect()
        };
        let speeds = of(&|who| of_places(recording, who, |place| place.speed));
        let criteria = find(reports, &recording.case.key).map_or(&[][..], |(trial, _)| &trial.trial.criteria);
        // People stop and set off at once, which says nothing and would hide the vehicles'.
        let mut accelerations = of(&|who| slopes(&of_places(recording, who, |place| place.speed)));
        accelerations.truncate(recording.case.world.vehicles.len());
        let (distances, pairs_left_out) = distances(recording);
        // In the unit of the criteria, as tables and charts are.
        let over = |title: &str,
                    name: &str,
                    dimension: Dimension,
                    mut series: Vec<TimeSeries>,
                    bound: Option<(&str, f64)>| {
            let unit = unit_for(criteria, dimension);
            if let Some(unit) = unit {
                let points = series.iter_mut().flat_map(|one| &mut one.points);
                points.for_each(|point| point.1 = unit.of_si(point.1));
            }
            let said = unit.map_or_else(|| dimension.si_unit(), |unit| unit.symbol.as_str().to_string());
            let y = AxisQuantity::new(name, &said);
            let rules = bound.map_or_else(Vec::new, |(metric, sign)| bounds(criteria, metric, sign, unit));
            OverTime { title: title.into(), y, from, to, series, rules, moment }.to_svg()
        };
        let pairs = distances
            .iter()
            .map(|one| LegendEntry { swatch: one.look.swatch(true, false), label: one.name.clone() });
        let pairs: Vec<LegendEntry> = pairs.collect();
        let mut panels = vec![
            over("Speeds", "speed", Dimension::SPEED, speeds, None),
            over(
                "Accelerations of vehicles",
                "slope of the speed over 0.1 s",
                Dimension::ACCELERATION,
                accelerations,
                Some(("max_deceleration", -1.0)),
            ),
        ];
        if !distances.is_empty() {
            let bound = Some(("min_distance", 1.0));
            panels.push(over("Distances between bodies", "distance", Dimension::LENGTH, distances, bound));
        }
        let entries = users()
            .map(|(_, look, name)| LegendEntry { swatch: look.swatch(true, false), label: name.into() });
        let legend = entries.chain(pairs).map(|entry| (entry.swatch, entry.label)).collect();
        let users_left_out = recording.users.len() - shown;
        let left_out = match (users_left_out, pairs_left_out) {
            (0, 0) => String::new(),
            (0, pairs) => format!("Of {pairs} more pairs, which come less near, no distance is drawn."),
            (users, 0) => format!("{users} more road users are not drawn."),
            (users, pairs) => {
                format!("{users} more road users and the distances of {pairs} more pairs are not drawn.")
            }
        };
        let moment = moment.map_or_else(String::new, |time| format!("upright line: {time:.2} s"));
        Self { from, to, legend, panels, moment, left_out }
    }
}

fn of_places(recording: &Recording, who: usize, pick: impl Fn(&Place) -> f64) -> Vec<(f64, f64)> {
    let places = recording.times.iter().zip(&recording.users[who]);
    places.filter_map(|(time, place)| Some((*time, pick(place.as_ref()?)))).collect()
}

/// The slope between each two points, at the time between them.
fn slopes(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let far = points.windows(2).filter(|pair| pair[1].0 - pair[0].0 > 1e-3);
    far.map(|pair| ((pair[0].0 + pair[1].0) / 2.0, (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0)))
        .collect()
}

/// Between each vehicle and each person, nearest pairs first, and how many pairs there would be more.
fn distances(recording: &Recording) -> (Vec<TimeSeries>, usize) {
    let cars = recording.case.world.vehicles.len();
    let mut pairs: Vec<(f64, TimeSeries)> = Vec::new();
    for car in 0..cars {
        for person in cars..recording.users.len() {
            let at = |index: usize| {
                let (one, other) = (outline(recording, car, index)?, outline(recording, person, index)?);
                Some((recording.times[index], apart(&one, &other)))
            };
            let points: Vec<(f64, f64)> = (0..recording.times.len()).filter_map(at).collect();
            let nearest = points.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
            let name = format!("{} and {}", recording.name(car), recording.name(person));
            if !points.is_empty() {
                pairs.push((nearest, TimeSeries { look: Look::series(0), name, points }));
            }
        }
    }
    pairs.sort_by(|one, other| one.0.total_cmp(&other.0));
    let left_out = pairs.len().saturating_sub(MOST_PAIRS);
    let first = recording.users.len().min(MOST_USERS);
    let series = pairs.into_iter().take(MOST_PAIRS).enumerate();
    let drawn = series.map(|(index, (_, one))| TimeSeries { look: Look::series(first + index), ..one });
    (drawn.collect(), left_out)
}

/// A road user's outline at a recorded time, if it is there.
pub fn outline(recording: &Recording, who: usize, index: usize) -> Option<Footprint> {
    let place = recording.users[who][index].as_ref()?;
    let (length, width, round) = recording.footprint(who);
    let shape = if round { Shape::Disc { radius: length / 2.0 } } else { Shape::Rectangle { length, width } };
    let heading = Vector2::new(libm::cos(place.heading), libm::sin(place.heading));
    Some(Footprint { centre: Vector2::new(place.x, place.y), heading, shape })
}

/// The bounds on a metric that runs of its trial are held to, as lines; `sign` turns the metric into what is drawn.
fn bounds(criteria: &[Criterion], metric: &str, sign: f64, unit: Option<Notation>) -> Vec<Rule> {
    let rule = |criterion: &Criterion| {
        let (Claim::Runs { comparison, .. }
        | Claim::Aggregate {
            aggregate: Aggregate::Rate(comparison) | Aggregate::Count(comparison), ..
        }) = &criterion.claim
        else {
            return None;
        };
        let Expression::Constant(Value::Number(_)) = &comparison.bound else { return None };
        let Rule { value, label } = comparison_rule(comparison, unit);
        (comparison.metric.name() == metric)
            .then(|| Rule { value: sign * value, label: format!("{metric} {label}") })
    };
    criteria.iter().filter_map(rule).collect()
}
