//! What the controllers of vehicles that do not see everything were told of others and was not so.

use std::fmt;
use std::ops::RangeInclusive;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::control::Control;
use super::road_users::Driven;
use scenario::Path;
use scenario::agent::Observation;

/// What a controller was told of others at a decision, as far as it was not so.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PerceivedView {
    /// The index of its vehicle.
    pub vehicle: usize,
    /// Of the decision, s.
    pub time: f64,
    /// How old it was what was told, s; `None` where the perception does not say.
    pub age: Option<f64>,
    /// Those who were not where they were said to be, or moved otherwise. Who is not told of at all is not among them.
    pub others: Vec<PerceivedOther>,
}

/// Somebody as a controller was told of them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PerceivedOther {
    /// Index of the road user: vehicles first, then pedestrians.
    pub who: usize,
    /// Where they were said to be, in the world frame, m.
    pub position: Vector2<f64>,
    /// How far that was from where they were, m.
    pub off: f64,
    /// How fast they were said to be, m/s.
    pub speed: f64,
}

impl PerceivedView {
    /// What the controller of a vehicle was told at its last decision until `time` (s) and was not so, if there is any; `views` are in the order of time.
    pub fn last(views: &[Self], vehicle: usize, time: f64) -> Option<&Self> {
        /// Absorbs the rounding of times, s.
        const TOLERANCE: f64 = 1e-9;
        let until = views.iter().rev().filter(|view| view.time <= time + TOLERANCE);
        let last = until.into_iter().find(|view| view.vehicle == vehicle);
        last.filter(|view| !view.others.is_empty())
    }
}

/// Nearer than this is the same but for rounding, m and m/s.
const SAME: f64 = 1e-6;

/// What the controllers of vehicles are told, to whoever looks on.
#[derive(Clone, Copy, Default)]
pub struct Views<'a> {
    controls: &'a [Control],
    driven: &'a [Driven],
}

impl<'a> Views<'a> {
    /// Of these vehicles, in the order of the world.
    pub(super) fn new(controls: &'a [Control], driven: &'a [Driven]) -> Self {
        Self { controls, driven }
    }

    /// What the controller of a vehicle that does not see everything was told and was not so, at its last decision, if that was `within` (s); the vehicle
    /// is one of so many `cars` and drives on this `path`. `None` where it sees everything or decided nothing.
    pub(super) fn view(
        &self,
        (vehicle, cars): (usize, usize),
        path: &Path,
        within: RangeInclusive<f64>,
    ) -> Option<PerceivedView> {
        let (seen, told) = self.controls.get(vehicle)?.seen_and_told()?;
        let time = told.time;
        if !within.contains(&time) {
            return None;
        }
        let age = self.driven[vehicle].perception.as_ref().and_then(|one| one.age(time));
        Some(PerceivedView { vehicle, time, age, others: others((seen, told), path, cars) })
    }
}

impl fmt::Debug for Views<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "Views({})", self.controls.len())
    }
}

/// Those of whom another place or motion is told than there was to be seen.
fn others((seen, told): (&Observation, &Observation), path: &Path, cars: usize) -> Vec<PerceivedOther> {
    // Somebody's place and velocity, as seen from the vehicle.
    type Moving = (Vector2<f64>, Vector2<f64>);
    let here = Vector2::new(told.ego.travelled, 0.0);
    let other = |who: usize, (was, moved): Moving, (place, velocity): Moving| {
        let differs = (place - was).norm() > SAME || (velocity - moved).norm() > SAME;
        differs.then(|| {
            let (was, position) = (path.to_world(was + here), path.to_world(place + here));
            PerceivedOther { who, position, off: (position - was).norm(), speed: velocity.norm() }
        })
    };
    let vehicles = told.vehicles.iter().filter_map(|one| {
        let so = seen.vehicles.iter().find(|so| so.id == one.id)?;
        other(one.id, (so.position, so.velocity), (one.position, one.velocity))
    });
    let people = told.pedestrians.iter().filter_map(|one| {
        let so = seen.pedestrians.iter().find(|so| so.id == one.id)?;
        other(cars + one.id, (so.position, so.velocity), (one.position, one.velocity))
    });
    vehicles.chain(people).collect()
}
