//! The pairs of a vehicle and a person that a run is drawn of over time: how far apart they are, and their time to collision.

use nalgebra::Vector2;

use super::asked::AskedOfRun;
use crate::chart::Look;
use results::Recording;
use scenario::{MetricReference, Shape, Value};
use sim::geometry::{Footprint, apart};
use sim::measure::PairDetails;

/// More pairs than this are not drawn: those that metrics took their values of are, what fails first, and then those that come nearest.
pub const MOST_PAIRS: usize = 2;

/// More road users than this are not drawn over time: the first are, vehicles before people.
pub const MOST_USERS: usize = 4;

/// The look of a road user that is drawn over time, the same in every picture of it: those of "pedestrian first" and "vehicle first" for the first
/// person and the first vehicle.
pub fn user_look(recording: &Recording, who: usize) -> Option<Look> {
    let shown = recording.users.len().min(MOST_USERS);
    let cars = recording.case.world.vehicles.len();
    let mut order: Vec<usize> = (0..shown).collect();
    match cars < shown {
        true => order[..=cars].rotate_right(1),
        false => order.swap(0, 1.min(shown.saturating_sub(1))),
    }
    order.iter().position(|one| *one == who).map(Look::series)
}

/// A pair that is drawn.
pub struct DrawnPair {
    /// Their places in the world.
    pub vehicle: usize,
    pub pedestrian: usize,
    pub look: Look,
    pub name: String,
    /// Time in s and m between their outlines.
    pub distances: Vec<(f64, Option<f64>)>,
}

/// Those that are drawn, with looks from the `first` on, and how many there would be more.
pub fn drawn_pairs(asked: &AskedOfRun, recording: &Recording, first: usize) -> (Vec<DrawnPair>, usize) {
    let cars = recording.case.world.vehicles.len();
    let critical = asked.pairs();
    let mut pairs: Vec<(usize, f64, DrawnPair)> = Vec::new();
    for vehicle in 0..cars {
        for who in cars..recording.users.len() {
            let pedestrian = who - cars;
            let pair = DrawnPair::of(recording, vehicle, pedestrian, Look::series(0));
            let nearest = pair.distances.iter().filter_map(|point| point.1).fold(f64::INFINITY, f64::min);
            let rank = critical.iter().position(|pair| *pair == (vehicle, pedestrian));
            if nearest.is_finite() {
                pairs.push((rank.unwrap_or(usize::MAX), nearest, pair));
            }
        }
    }
    pairs.sort_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)));
    let left_out = pairs.len().saturating_sub(MOST_PAIRS);
    let shown = pairs.into_iter().take(MOST_PAIRS).enumerate();
    let drawn = shown.map(|(index, (.., pair))| DrawnPair { look: Look::series(first + index), ..pair });
    (drawn.collect(), left_out)
}

impl DrawnPair {
    /// That of a vehicle and a pedestrian, by their places in the world.
    pub fn of(recording: &Recording, vehicle: usize, pedestrian: usize, look: Look) -> Self {
        let who = recording.case.world.vehicles.len() + pedestrian;
        let at = |index: usize| {
            let (one, other) = (outline(recording, vehicle, index)?, outline(recording, who, index)?);
            Some(apart(&one, &other))
        };
        let times = recording.times.iter().enumerate();
        let distances = times.map(|(index, time)| (*time, at(index))).collect();
        let name = format!("{} and {}", recording.name(vehicle), recording.name(who));
        Self { vehicle, pedestrian, look, name, distances }
    }

    /// What was recorded of it besides where the two are.
    pub fn details<'r>(&self, recording: &'r Recording) -> Option<&'r PairDetails> {
        let is_it = |pair: &&PairDetails| (pair.vehicle, pair.pedestrian) == (self.vehicle, self.pedestrian);
        recording.meetings.iter().find(is_it)
    }

    /// Times to collision, s, at the recorded times; if the vehicle went `straight` on, or else along its lane.
    pub fn times_to_collision(&self, recording: &Recording, straight: bool) -> Vec<(f64, Option<f64>)> {
        let Some(details) = self.details(recording) else { return Vec::new() };
        let values = match straight && !details.straight_on.is_empty() {
            true => &details.straight_on,
            false => &details.time_to_collision,
        };
        recording.times.iter().copied().zip(values.iter().copied()).collect()
    }
}

/// Whether a metric takes vehicles to go straight on from where they are.
pub fn goes_straight(metric: &MetricReference) -> bool {
    matches!(metric.settings.get("prediction"), Some(Value::Word(word)) if word.as_str() == "straight")
}

/// A road user's outline at a recorded time, if it is there.
pub fn outline(recording: &Recording, who: usize, index: usize) -> Option<Footprint> {
    let place = recording.users[who][index].as_ref()?;
    let (length, width, round) = recording.footprint(who);
    let shape = if round { Shape::Disc { radius: length / 2.0 } } else { Shape::Rectangle { length, width } };
    let heading = Vector2::new(libm::cos(place.heading), libm::sin(place.heading));
    Some(Footprint { centre: Vector2::new(place.x, place.y), heading, shape })
}
