//! Where everybody begins, and what is wrong with a world before anything moves: bodies inside each other, lanes that a box
//! blocks.

use nalgebra::Vector2;

use super::contact::pairs;
use super::geometry::{Footprint, apart};
use super::solid::Solid;
use super::turning::contact_ahead;
use super::way::Way;
use scenario::agent::{Longitudinal, PedestrianState, Snapshot, VehicleState};
use scenario::{
    Appearance, Body, MayGo, PathConflict, PedestrianSetup, VehicleReference, VehicleSetup, VehicleStart,
    World,
};

/// Bodies that only touch are beside each other, m.
const TOUCHING: f64 = 1e-6;

/// On a bend a vehicle is looked at every so many metres for what stands in its way.
const LOOKS: f64 = 0.1;

/// Every two bodies that are inside each other where they begin: vehicles at the speed that they are given, pedestrians as
/// they appear. Those who appear at different times, or when a vehicle is somewhere, are left to the run.
pub fn overlaps(world: &World) -> Vec<(Solid, Solid)> {
    let state = beginning(world);
    let together = |first, second| match (first, second) {
        (Solid::Pedestrian(one), Solid::Pedestrian(other)) => {
            let appearance =
                |index: usize| (world.pedestrians[index].appears, world.pedestrians[index].start.x);
            let at_once = |index: usize| matches!(appearance(index).0, Appearance::At(time) if time <= 0.0);
            appearance(one) == appearance(other) || (at_once(one) && at_once(other))
        }
        (Solid::Vehicle(_), Solid::Pedestrian(index)) => {
            matches!(world.pedestrians[index].appears, Appearance::At(time) if time <= 0.0)
        }
        _ => true,
    };
    let overlap = |(first, second): &(Solid, Solid)| are_inside_each_other(world, &state, (*first, *second));
    pairs(world).filter(|(first, second)| together(*first, *second)).filter(overlap).collect()
}

/// Whether two bodies that are there are inside each other.
fn are_inside_each_other(world: &World, state: &Snapshot, (first, second): (Solid, Solid)) -> bool {
    let outline = |solid: Solid| Some(solid.footprint(state, &world.road.boxes)?.shrunk(TOUCHING / 2.0));
    let both = outline(first).zip(outline(second));
    both.is_some_and(|(one, other)| one.first_contact(&other, Vector2::zeros()).is_some())
}

/// The first body that a pedestrian is inside of that appears now.
pub(super) fn occupied_by(world: &World, state: &Snapshot, pedestrian: usize) -> Option<Solid> {
    let own = Solid::Pedestrian(pedestrian);
    let vehicles = (0..state.vehicles.len()).map(Solid::Vehicle);
    let others = (0..state.pedestrians.len()).filter(|other| *other != pedestrian).map(Solid::Pedestrian);
    let boxes = (0..world.road.boxes.len()).map(Solid::Box);
    vehicles.chain(others).chain(boxes).find(|other| are_inside_each_other(world, state, (own, *other)))
}

/// A pedestrian that waits for a time to arrival that is past when it begins to wait.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PastArrival {
    /// Index into [`World::pedestrians`].
    pub pedestrian: usize,
    /// Index into [`World::vehicles`].
    pub vehicle: usize,
    /// The time to arrival that the pedestrian waits for, s.
    pub wanted: f64,
    /// The time to arrival when it begins to wait, s; negative where the vehicle has passed the place.
    pub left: f64,
    /// Whether it waits for this to go; else to appear, from the start of the run on.
    pub to_go: bool,
}

/// The first pedestrian that waits for a time to arrival that is past by more than `tolerance` (s) where the run begins like this.
pub fn past_arrival(world: &World, start: &Snapshot, tolerance: f64) -> Option<PastArrival> {
    let left = |setup: &PedestrianSetup, vehicle: usize, reference: VehicleReference| {
        start.vehicles[vehicle].time_to_arrival(met_by_vehicle(world, setup, vehicle), reference)
    };
    world.pedestrians.iter().enumerate().find_map(|(pedestrian, setup)| {
        if let Appearance::TimeToArrival { vehicle, reference, time: wanted } = setup.appears {
            let left = left(setup, vehicle, reference);
            if left < wanted - tolerance {
                return Some(PastArrival { pedestrian, vehicle, wanted, left, to_go: false });
            }
        }
        let MayGo::TimeToArrival { vehicle, reference, time: wanted, .. } = setup.may_go else { return None };
        let left = match setup.appears {
            Appearance::At(time) if time <= 0.0 => left(setup, vehicle, reference),
            Appearance::TimeToArrival { vehicle: other, reference: part, time }
                if (other, part) == (vehicle, reference) =>
            {
                time
            }
            _ => return None,
        };
        (left < wanted - tolerance).then_some(PastArrival { pedestrian, vehicle, wanted, left, to_go: true })
    })
}

/// How long after the start a pedestrian appears if vehicles, which start as `cars`, keep their speeds, s; `None` if it then never appears.
pub fn appears_after(world: &World, setup: &PedestrianSetup, cars: &[VehicleState]) -> Option<f64> {
    let arrives = |vehicle: usize, reference: VehicleReference, wanted: f64| {
        let left = cars[vehicle].time_to_arrival(meeting_place(world, setup), reference) - wanted;
        left.is_finite().then_some(left.max(0.0))
    };
    match setup.appears {
        Appearance::At(time) => Some(time.max(0.0)),
        Appearance::TimeToArrival { vehicle, reference, time } => arrives(vehicle, reference, time),
        Appearance::Meeting { vehicle, time, .. } => arrives(vehicle, VehicleReference::Front, time),
    }
}

/// Whether a vehicle moves and has yet to come by where a pedestrian meets its path.
pub(super) fn is_to_come(driven: &VehicleSetup, car: &VehicleState, setup: &PedestrianSetup) -> bool {
    let rear = car.motion.travelled - car.length / 2.0;
    driven.placing_speed() > 0.0 && rear < setup.met_by(&car.path)
}

/// The place at which a pedestrian meets the path of a vehicle, m.
pub(super) fn met_by_vehicle(world: &World, setup: &PedestrianSetup, vehicle: usize) -> f64 {
    setup.met_by(&world.path_of(&world.vehicles[vehicle]))
}

/// The place at which a pedestrian meets the path of the vehicle whose arrival it waits for, m; 0 if it waits for none.
pub fn meeting_place(world: &World, setup: &PedestrianSetup) -> f64 {
    match setup.appears {
        Appearance::At(_) => 0.0,
        Appearance::Meeting { place, .. } => place,
        Appearance::TimeToArrival { vehicle, .. } => met_by_vehicle(world, setup, vehicle),
    }
}

/// Every vehicle with every box that stands in its way to the finish line, and the way to it from the vehicle's centre, m.
pub fn blocked_lanes(world: &World) -> Vec<(usize, usize, f64)> {
    let state = beginning(world);
    let mut blocked = Vec::new();
    for (vehicle, car) in state.vehicles.iter().enumerate() {
        for (index, body) in world.road.boxes.iter().enumerate() {
            if car.path.course().is_some() {
                blocked.extend(met_on_the_way(world, car, body).map(|way| (vehicle, index, way)));
                continue;
            }
            let place = Vector2::new(body.x, body.y);
            let apart = car.path.beside(place).abs() - (body.width + car.width) / 2.0;
            let centre = car.path.along(place);
            let (from, to) = (centre - body.length / 2.0, centre + body.length / 2.0);
            let ahead = to > car.motion.travelled && from < world.finish + car.length / 2.0;
            if apart < -TOUCHING && ahead {
                blocked.push((vehicle, index, from - car.motion.travelled));
            }
        }
    }
    blocked
}

/// The vehicles that are ahead of one in its lane where all begin.
pub fn vehicles_ahead(world: &World, vehicle: usize) -> Vec<usize> {
    let (state, own) = (beginning(world), &world.vehicles[vehicle]);
    let place = |index: usize| state.vehicles[index].motion.travelled;
    let is_ahead = |other: &usize| {
        let setup = &world.vehicles[*other];
        (setup.road, setup.lane) == (own.road, own.lane) && place(*other) > place(vehicle)
    };
    (0..world.vehicles.len()).filter(is_ahead).collect()
}

/// The way (m) that a vehicle drives until it stands in a box, if it does so before the finish line.
fn met_on_the_way(world: &World, car: &VehicleState, body: &Body) -> Option<f64> {
    let (mut car, start, body) = (car.clone(), car.motion.travelled, Footprint::from(body).shrunk(TOUCHING));
    let steps = ((world.finish - start) / LOOKS).ceil().max(0.0) as usize;
    (0..=steps).map(|step| step as f64 * LOOKS).find(|way| {
        car.motion.travelled = start + way;
        apart(&Footprint::from(&car), &body) == 0.0
    })
}

pub(super) fn waiting_outside((setup, way): (&PedestrianSetup, &Way)) -> PedestrianState {
    PedestrianState {
        position: Vector2::new(setup.start.x, setup.start.y),
        velocity: Vector2::zeros(),
        acceleration: Vector2::zeros(),
        heading: way.ahead(setup.start.into()),
        shape: setup.shape,
        present: false,
    }
}

/// Puts a settled vehicle where its setup wants it at time 0.
pub(super) fn placed(world: &World, setup: &VehicleSetup, settled: Longitudinal) -> VehicleState {
    let path = world.path_of(setup);
    let travelled = match setup.start {
        VehicleStart::Distance(distance) => -distance,
        VehicleStart::TimeToArrival { time, reference, x } => {
            let ahead = reference.ahead_of_centre(setup.length);
            let speed = if setup.initial_speed.is_some() { setup.placing_speed() } else { settled.speed };
            path.at_line(x) - time * speed - ahead
        }
    };
    VehicleState::new(path, Longitudinal { travelled, ..settled }, (setup.length, setup.width))
}

/// Where the ways of two vehicles cross, the first's places first: from where they begin to the finish line.
pub fn path_conflicts(world: &World, one: usize, other: usize) -> Vec<PathConflict> {
    let start = beginning(world);
    let (first, second) = (&start.vehicles[one], &start.vehicles[other]);
    let (from, to) = (first.motion.travelled, second.motion.travelled);
    let sizes = ((first.length, first.width), (second.length, second.width));
    let reach = (world.finish - from.min(to)).max(0.0);
    first.path.conflicts_with((from, sizes.0), (&second.path, to, sizes.1), reach)
}

/// Everybody where they begin: vehicles at the speed that they are given, and pedestrians though they may appear later.
pub fn beginning(world: &World) -> Snapshot {
    let cars = world.vehicles.iter().map(|setup| {
        let speed = setup.speed_at_start();
        placed(world, setup, Longitudinal { travelled: 0.0, speed, acceleration: 0.0 })
    });
    let ways: Vec<_> = world.pedestrians.iter().map(Way::new).collect();
    let mut people: Vec<_> = world.pedestrians.iter().zip(&ways).map(waiting_outside).collect();
    people.iter_mut().for_each(|person| person.present = true);
    Snapshot { vehicles: cars.collect(), pedestrians: people }
}

/// Whether two who both move on as they do now will touch, and after which time, s. Vehicles move on along their paths.
pub fn collision_course(first: Solid, second: Solid, state: &Snapshot, world: &World) -> Option<f64> {
    let boxes = &world.road.boxes;
    let bends = |solid| match solid {
        Solid::Vehicle(index) => !state.vehicles[index].keeps_straight(),
        _ => false,
    };
    if bends(first) || bends(second) {
        return contact_ahead((first, second), state, boxes);
    }
    let (one, other) = (first.footprint(state, boxes)?, second.footprint(state, boxes)?);
    let velocity = |solid| match solid {
        Solid::Vehicle(index) => state.vehicles[index].velocity(),
        Solid::Pedestrian(index) => state.pedestrians[index].velocity,
        Solid::Box(_) => Vector2::zeros(),
    };
    Footprint::first_contact(&one, &other, velocity(second) - velocity(first))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use scenario::VehicleStart;

    fn van(x: f64, y: f64) -> Body {
        Body { name: "van".into(), x, y, length: 5.0, width: 2.0, heading: 0.0 }
    }

    fn found(change: impl FnOnce(&mut World)) -> Vec<(Solid, Solid)> {
        let mut world = fixture::world();
        change(&mut world);
        overlaps(&world)
    }

    #[test]
    fn whoever_starts_inside_something_is_found() {
        let (car, walker) = (Solid::Vehicle(0), Solid::Pedestrian(0));
        assert_eq!(found(|_| {}), []);
        assert_eq!(found(|world| world.road.boxes = vec![van(0.0, -4.0)]), [(walker, Solid::Box(0))]);
        assert_eq!(found(|world| world.road.boxes = vec![van(-98.0, 1.9)]), [(car, Solid::Box(0))]);
        let in_the_car = |world: &mut World| world.pedestrians[0].start.y = 0.0;
        let near = |world: &mut World| world.vehicles[0].start = VehicleStart::Distance(1.0);
        assert_eq!(found(|world| (in_the_car(world), near(world)).1), [(car, walker)]);
        // Where the vehicle will be when somebody appears is not known before.
        assert_eq!(
            found(|world| {
                in_the_car(world);
                near(world);
                world.pedestrians[0].appears = Appearance::At(1.0);
            }),
            []
        );
        let twins = |world: &mut World, later: f64| {
            let mut other = world.pedestrians[0].clone();
            (other.name, other.appears) = ("other".into(), Appearance::At(later));
            world.pedestrians.push(other);
        };
        assert_eq!(found(|world| twins(world, 0.0)), [(walker, Solid::Pedestrian(1))]);
        assert_eq!(found(|world| twins(world, 1.0)), []);
        let second = |place: f64| {
            move |world: &mut World| {
                let mut other = world.vehicles[0].clone();
                (other.name, other.start) = ("other".into(), VehicleStart::Distance(place));
                world.vehicles.push(other);
            }
        };
        assert_eq!(found(second(97.0)), [(car, Solid::Vehicle(1))]);
        // Bumper to bumper is no overlap.
        assert_eq!(found(second(96.0)), []);
    }

    #[test]
    fn a_box_in_the_lane_blocks_it_from_the_start_to_the_finish() {
        let blocked = |x: f64, y: f64| {
            let mut world = fixture::world();
            world.road.boxes = vec![van(x, y)];
            blocked_lanes(&world)
        };
        assert_eq!(blocked(0.0, 0.0), [(0, 0, 97.5)]);
        assert_eq!(blocked(0.0, 1.99).len(), 1);
        assert_eq!(blocked(0.0, 2.0), []);
        assert_eq!(blocked(0.0, -2.9), []);
        assert_eq!(blocked(-110.0, 0.0), []);
        assert_eq!(blocked(30.0, 0.0), []);
    }
}
