//! What was going on when time was up or a contact ended a run: who had not arrived, who was about to touch, whose encounter
//! was not over, what was not decided.

use std::sync::Arc;

use super::name::shared;
use results::{CutOff, OnCourse, Unfinished};
use scenario::{PathConflict, World};
use sim::measure::{Measurement, Reading, half_extent};
use sim::{Snapshot, Solid, collision_course, has_arrived, has_crossed, path_conflicts};

/// Of a run that the horizon or a contact ended in the state `last`.
pub fn cut_off(world: &World, last: &Snapshot, measurement: &Measurement, readings: &[Reading]) -> CutOff {
    CutOff {
        open: readings.iter().map(|reading| reading.open).collect(),
        stranded: stranded(world, last, measurement),
        on_course: on_course(world, last, measurement),
        unfinished: unfinished(world, last, measurement),
    }
}

fn stranded(world: &World, last: &Snapshot, measurement: &Measurement) -> Vec<Arc<str>> {
    let cars = world.vehicles.len();
    let was_hit = |who: Solid| (0..cars).any(|car| measurement.touched(car, who));
    let touches = |car: usize| solids(world, car).any(|with| measurement.touched(car, with));
    // A vehicle that was waiting from the beginning has nowhere to go.
    let drivers = (0..cars).filter(|car| world.vehicles[*car].placing_speed() > 0.0 && !touches(*car));
    // At any moment some vehicles of a stream are still on their way.
    let in_stream = |car: &usize| world.streams.iter().any(|stream| stream.vehicles.contains(car));
    let drivers = drivers.filter(|car| !in_stream(car) || last.vehicles[*car].motion.speed == 0.0);
    let people = (0..world.pedestrians.len()).filter(|index| last.pedestrians[*index].present);
    let people = people.map(Solid::Pedestrian).filter(|person| !was_hit(*person));
    let missing = drivers.map(Solid::Vehicle).chain(people).filter(|who| !has_arrived(world, last, *who));
    missing.map(|who| shared(who.name(world))).collect()
}

/// What takes so long is what rounding leaves of a stop, s: no run is that long.
const NEVER: f64 = 1e6;

/// Those who would touch, of all who have not touched yet, by when they would.
fn on_course(world: &World, last: &Snapshot, measurement: &Measurement) -> Vec<OnCourse> {
    let cars = 0..world.vehicles.len();
    let pairs = cars.flat_map(|car| solids(world, car).map(move |with| (car, with)));
    // Two vehicles are one pair, whoever of them is named first.
    let once = |(car, with): &(usize, Solid)| !matches!(with, Solid::Vehicle(other) if other < car);
    let apart = pairs.filter(once).filter(|(car, with)| !measurement.touched(*car, *with));
    let courses = apart.filter_map(|(car, with)| {
        let time = collision_course(Solid::Vehicle(car), with, last, world).filter(|time| *time < NEVER)?;
        Some(OnCourse {
            vehicle: shared(Solid::Vehicle(car).name(world)),
            with: shared(with.name(world)),
            time,
        })
    });
    let mut courses: Vec<_> = courses.collect();
    courses.sort_by(|one, other| one.time.total_cmp(&other.time));
    courses
}

/// The vehicles and pedestrians that had not touched while the vehicle had not left the pedestrian behind, nor the pedestrian
/// the vehicle's lane, and one of them moved or the pedestrian had yet to appear.
fn unfinished(world: &World, last: &Snapshot, measurement: &Measurement) -> Vec<Unfinished> {
    // A vehicle that was waiting from the beginning has nowhere to go.
    let drivers = (0..world.vehicles.len()).filter(|car| world.vehicles[*car].placing_speed() > 0.0);
    let pairs = drivers.flat_map(|car| (0..world.pedestrians.len()).map(move |person| (car, person)));
    let not_over = pairs.filter(|(car, index)| {
        let (vehicle, person) = (&last.vehicles[*car], &last.pedestrians[*index]);
        let crossed = person.present && has_crossed(world, last, *index, (vehicle, &world.vehicles[*car]));
        let rear = vehicle.motion.travelled - world.vehicles[*car].length / 2.0;
        let place = vehicle.path.locate(person.position);
        let passed = rear >= place.along + half_extent(person, &place).x;
        let stands = person.present && person.velocity.norm() == 0.0 && vehicle.motion.speed == 0.0;
        !(crossed || passed || stands || measurement.touched(*car, Solid::Pedestrian(*index)))
    });
    let named = not_over.map(|(car, person)| Unfinished {
        vehicle: shared(Solid::Vehicle(car).name(world)),
        pedestrian: shared(Solid::Pedestrian(person).name(world)),
    });
    named.chain(crossing_vehicles(world, last, measurement)).collect()
}

/// Every two vehicles on different roads whose ways cross, that have not touched, and of which neither has left where they do while
/// one of them moves.
fn crossing_vehicles(
    world: &World,
    last: &Snapshot,
    measurement: &Measurement,
) -> impl Iterator<Item = Unfinished> {
    let cars = &world.vehicles;
    let pairs = (0..cars.len()).flat_map(|one| (one + 1..cars.len()).map(move |other| (one, other)));
    let pairs = pairs.filter(|(one, other)| cars[*one].road != cars[*other].road);
    let not_over = pairs.filter(|(one, other)| {
        let (first, second) = (&last.vehicles[*one].motion, &last.vehicles[*other].motion);
        let is_left = |met: &PathConflict| first.travelled > met.first.to && second.travelled > met.second.to;
        let stand = first.speed == 0.0 && second.speed == 0.0;
        let touched = measurement.touched(*one, Solid::Vehicle(*other));
        !stand && !touched && !path_conflicts(world, *one, *other).iter().all(is_left)
    });
    let named = not_over.map(|(one, other)| Unfinished {
        vehicle: shared(Solid::Vehicle(one).name(world)),
        pedestrian: shared(Solid::Vehicle(other).name(world)),
    });
    named.collect::<Vec<_>>().into_iter()
}

/// Everything that a vehicle may touch.
fn solids(world: &World, car: usize) -> impl Iterator<Item = Solid> {
    let people = (0..world.pedestrians.len()).map(Solid::Pedestrian);
    let cars = (0..world.vehicles.len()).filter(move |other| *other != car).map(Solid::Vehicle);
    people.chain(cars).chain((0..world.road.boxes.len()).map(Solid::Box))
}
