//! A vehicle that was steered and somebody who crossed its way: passings and visits by the way that it really took, worked out at the end,
//! since only then it is known.
//!
//! What it sweeps is what its outline was over; behind the last place that it came to, what it would be over if it went on beside its path
//! as far from it as it was. Times and places are found between the steps to 1e-9 s and 1e-9 m, everybody moving evenly from each to the
//! next.

use nalgebra::Vector2;

use super::events::{Passing, Visit, half_extent, lerp, rising};
use crate::geometry::Footprint;
use crate::{PedestrianState, Step, VehicleState};
use scenario::Side;

/// Times and places that are nearer than this are the same, s and m.
const CLOSE: f64 = 1e-9;

/// Where a vehicle was, one knot after every step in which it moved.
#[derive(Debug, Clone, Default)]
pub(super) struct SteeredWay {
    /// Ascending in what was travelled, however it was steered.
    knots: Vec<(f64, VehicleState)>,
}

impl SteeredWay {
    /// Notes where it is.
    pub fn observe(&mut self, car: &VehicleState) {
        let farthest = self.knots.last().map_or(f64::NEG_INFINITY, |(travelled, _)| *travelled);
        if car.motion.travelled > farthest {
            self.knots.push((car.motion.travelled, car.clone()));
        }
    }

    /// Whether it was steered at all.
    pub fn was_steered(&self) -> bool {
        self.knots.last().is_some_and(|(_, car)| car.steered.is_some())
    }

    /// How far its centre was to the left of its path where it had come so far (m), m.
    fn offset(&self, travelled: f64) -> f64 {
        let of = |car: &VehicleState| match car.steered {
            Some(steered) => car.path.locate(steered.centre).left(),
            None => 0.0,
        };
        let next = self.knots.partition_point(|knot| knot.0 < travelled);
        match (next.checked_sub(1), self.knots.get(next)) {
            // Nobody steered before it set out.
            (None, _) => 0.0,
            (Some(last), None) => of(&self.knots[last].1),
            (Some(last), Some((to, car))) => {
                let (from, before) = &self.knots[last];
                lerp(of(before), of(car), (travelled - from) / (to - from))
            }
        }
    }

    /// Whether what it sweeps reaches a body, and between which places (m) of its centre it touches it there, if it came so far.
    fn touches(&self, person: &PedestrianState) -> (bool, Option<(f64, f64)>) {
        let Some((end, last)) = self.knots.last() else { return (false, None) };
        let outline = Footprint::from(person);
        let place = last.path.locate(person.position);
        let reach = libm::hypot(last.length, last.width) / 2.0 + outline.radius() + last.length / 2.0;
        let from = self.knots.partition_point(|knot| knot.0 < place.along - reach);
        let to = self.knots.partition_point(|knot| knot.0 <= place.along + reach);
        let touch =
            |car: &VehicleState| Footprint::from(car).first_contact(&outline, Vector2::zeros()).is_some();
        let near = &self.knots[from..to];
        let found =
            near.iter().position(|knot| touch(&knot.1)).zip(near.iter().rposition(|knot| touch(&knot.1)));
        let at = found.map(|(first, last)| {
            let edge = |outside: Option<&(f64, VehicleState)>, inside: &(f64, VehicleState)| {
                let Some(outside) = outside else { return inside.0 };
                let (mut apart, mut touching) = (0.0, 1.0);
                while (touching - apart) * (inside.0 - outside.0).abs() > CLOSE {
                    let middle = (apart + touching) / 2.0;
                    match touch(&outside.1.between(&inside.1, middle)) {
                        true => touching = middle,
                        false => apart = middle,
                    }
                }
                lerp(outside.0, inside.0, touching)
            };
            let before = (from + first).checked_sub(1).map(|index| &self.knots[index]);
            (edge(before, &near[first]), edge(self.knots.get(from + last + 1), &near[last]))
        });
        let ahead = || {
            let (half, beside) = (half_extent(person, &place), place.left() - self.offset(*end));
            place.along + half.x > end + last.length / 2.0 && beside.abs() < last.width / 2.0 + half.y
        };
        // Where the outline was not yet, but would come to, it is under way.
        (at.is_some() || ahead(), at)
    }
}

/// Where a pedestrian was, one knot after every step since it appeared.
#[derive(Debug, Clone, Default)]
pub(super) struct WalkedWay {
    /// With the times, s.
    knots: Vec<(f64, PedestrianState)>,
}

impl WalkedWay {
    /// Notes where the pedestrian of this index is after a step, and at its beginning if it is the first.
    pub fn observe(&mut self, step: &Step, index: usize) {
        if self.knots.is_empty() {
            self.knots.push((step.time, step.before.pedestrians[index]));
        }
        self.knots.push((step.time + step.duration, step.after.pedestrians[index]));
    }

    /// Every passing of the way that the centre of a vehicle took.
    pub fn passings(&self, way: &SteeredWay, side: Side) -> Vec<Passing> {
        let Some((_, car)) = way.knots.last() else { return Vec::new() };
        let mut passings = Vec::new();
        let mut last = None;
        for (time, person) in &self.knots {
            let place = car.path.locate(person.position);
            let across = side.walking_sign() * place.far() * (place.left() - way.offset(place.along));
            let now = (*time, place.along, across, place.ambiguous);
            if let Some((before, along, was, ambiguous)) = last.replace(now)
                && !ambiguous
                && !place.ambiguous
            {
                let up = rising(was, across, 0.0);
                let down = (was >= 0.0 && across < 0.0).then(|| was / (was - across));
                passings.extend(up.or(down).map(|part| Passing {
                    time: lerp(before, *time, part),
                    place: lerp(along, place.along, part),
                    towards_goal: up.is_some(),
                }));
            }
        }
        passings
    }

    /// Every stay in what the outline of a vehicle sweeps.
    pub fn visits(&self, way: &SteeredWay) -> Vec<Visit> {
        let Some((_, car)) = way.knots.last() else { return Vec::new() };
        let half = car.length / 2.0;
        let mut visits: Vec<Visit> = Vec::new();
        let mut last: Option<(bool, &(f64, PedestrianState))> = None;
        for knot in &self.knots {
            let (time, person) = knot;
            let (inside, at) = way.touches(person);
            let edge = |was: bool, from: &(f64, PedestrianState)| {
                let (mut low, mut high) = (0.0, 1.0);
                while (high - low) * (time - from.0) > CLOSE {
                    let middle = (low + high) / 2.0;
                    let position = from.1.position.lerp(&person.position, middle);
                    match way.touches(&PedestrianState { position, ..*person }).0 == was {
                        true => low = middle,
                        false => high = middle,
                    }
                }
                lerp(from.0, *time, high)
            };
            match last.replace((inside, knot)) {
                Some((was, from)) if was != inside => {
                    let moment = edge(was, from);
                    match inside {
                        true => visits.push(begun(moment)),
                        false => visits.iter_mut().last().into_iter().for_each(|visit| visit.to = moment),
                    }
                }
                None if inside => visits.push(begun(*time)),
                _ => {}
            }
            if let (Some(visit), true) = (visits.last_mut(), inside) {
                let place = car.path.locate(person.position);
                let reach = half_extent(person, &place).x;
                let (low, high) = match at {
                    Some((first, last)) => (first + half, last - half),
                    None => (place.along - reach, place.along + reach),
                };
                (visit.low, visit.high) = (visit.low.min(low), visit.high.max(high));
            }
        }
        visits
    }
}

fn begun(from: f64) -> Visit {
    Visit { from, to: f64::INFINITY, low: f64::INFINITY, high: f64::NEG_INFINITY }
}
