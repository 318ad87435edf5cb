//! What was going on when the horizon ended a run: who had not arrived, who was about to touch, what was not decided.

use std::sync::Arc;

use super::name::shared;
use super::outcome::{CutOff, OnCourse};
use crate::metrics::{Measurement, Reading};
use crate::scenario::World;
use crate::sim::{Snapshot, Solid, collision_course, has_arrived};

/// Of a run that the horizon ended in the state `last`.
pub fn cut_off(world: &World, last: &Snapshot, measurement: &Measurement, readings: &[Reading]) -> CutOff {
    CutOff {
        open: readings.iter().map(|reading| reading.open).collect(),
        stranded: stranded(world, last, measurement),
        on_course: on_course(world, last, measurement),
    }
}

fn stranded(world: &World, last: &Snapshot, measurement: &Measurement) -> Vec<Arc<str>> {
    let cars = world.vehicles.len();
    let was_hit = |who: Solid| (0..cars).any(|car| measurement.touched(car, who));
    let touches = |car: usize| solids(world, car).any(|with| measurement.touched(car, with));
    // A vehicle that was parked from the beginning has nowhere to go.
    let drivers = (0..cars).filter(|car| world.vehicles[*car].speed > 0.0 && !touches(*car));
    let people = (0..world.pedestrians.len()).filter(|index| last.pedestrians[*index].present);
    let people = people.map(Solid::Pedestrian).filter(|person| !was_hit(*person));
    let missing = drivers.map(Solid::Vehicle).chain(people).filter(|who| !has_arrived(world, last, *who));
    missing.map(|who| shared(who.name(world))).collect()
}

/// Those who would touch next, of all who have not touched yet.
fn on_course(world: &World, last: &Snapshot, measurement: &Measurement) -> Option<OnCourse> {
    let cars = 0..world.vehicles.len();
    let pairs = cars.flat_map(|car| solids(world, car).map(move |with| (car, with)));
    let courses = pairs.filter(|(car, with)| !measurement.touched(*car, *with)).filter_map(|(car, with)| {
        let time = collision_course(Solid::Vehicle(car), with, last, world)?;
        Some((time, car, with))
    });
    let (time, car, with) = courses.min_by(|one, other| one.0.total_cmp(&other.0))?;
    Some(OnCourse { vehicle: shared(Solid::Vehicle(car).name(world)), with: shared(with.name(world)), time })
}

/// Everything that a vehicle may touch.
fn solids(world: &World, car: usize) -> impl Iterator<Item = Solid> {
    let people = (0..world.pedestrians.len()).map(Solid::Pedestrian);
    let cars = (0..world.vehicles.len()).filter(move |other| *other != car).map(Solid::Vehicle);
    people.chain(cars).chain((0..world.road.boxes.len()).map(Solid::Box))
}
