//! Who has arrived, and whether a run has to go on for anybody.

use nalgebra::Vector2;

use super::observer::{Ending, StopReason};
use super::solid::Solid;
use super::way::walked;
use scenario::agent::{Snapshot, VehicleState};
use scenario::{Path, PedestrianSetup, VehicleSetup, World};

/// Whether a vehicle has passed the finish line, or a pedestrian every vehicle's lane, or the goal of who walks along one. Boxes are where they
/// are.
pub fn has_arrived(world: &World, state: &Snapshot, who: Solid) -> bool {
    match who {
        Solid::Vehicle(index) => state.vehicles[index].motion.travelled >= world.finish,
        Solid::Pedestrian(index) => {
            let person = &state.pedestrians[index];
            let mut cars = state.vehicles.iter().zip(&world.vehicles);
            person.present && cars.all(|(car, driven)| has_crossed(world, state, index, (car, driven)))
        }
        Solid::Box(_) => true,
    }
}

/// At a goal, but for rounding, m.
const AT_THE_GOAL: f64 = 1e-6;

/// Whether a pedestrian has left the lane of a vehicle behind; of who walks along it, whether they are at their goal.
pub fn has_crossed(
    world: &World,
    state: &Snapshot,
    pedestrian: usize,
    (car, driven): (&VehicleState, &VehicleSetup),
) -> bool {
    let setup = &world.pedestrians[pedestrian];
    let place = state.pedestrians[pedestrian].position;
    if car.path.course().is_none() {
        if !setup.crosses(&world.road) {
            let way = Vector2::from(setup.goal) - Vector2::from(setup.start);
            return walked(setup, place) >= way.norm() - AT_THE_GOAL;
        }
        return car.path.beyond(place, setup.side) >= world.road.lane_width / 2.0;
    }
    walked(setup, place) >= way_across(world, setup, (driven, &car.path))
}

/// The way (m) from somebody's start until a path that bends is left behind: to the edge of its lane that they leave it by, or to
/// their goal if that is never reached. Who does not cross the lane of a vehicle on another road has none of it before them.
fn way_across(world: &World, setup: &PedestrianSetup, (car, path): (&VehicleSetup, &Path)) -> f64 {
    let (start, goal) = (Vector2::from(setup.start), Vector2::from(setup.goal));
    if setup.follows.is_some() {
        return walked(setup, goal) - AT_THE_GOAL;
    }
    let side = if car.road == 0 { Some(setup.side) } else { world.crosses_from(setup, car) };
    let Some(side) = side else { return 0.0 };
    let edge = path.way_to_far_edge((start, goal), side, world.road_of(car).lane_width);
    edge.unwrap_or_else(|| (goal - start).norm())
}

/// Of every pedestrian across the path of every vehicle, m; nothing on a straight road.
fn ways_across(world: &World) -> Vec<f64> {
    if world.road.bend.is_none() && world.other_roads.is_empty() {
        return Vec::new();
    }
    let paths: Vec<(&VehicleSetup, Path)> =
        world.vehicles.iter().map(|setup| (setup, world.path_of(setup))).collect();
    let ways = world
        .pedestrians
        .iter()
        .flat_map(|setup| paths.iter().map(|(car, path)| way_across(world, setup, (car, path))));
    ways.collect()
}

/// The vehicles of streams.
#[derive(Debug, Clone)]
pub(crate) struct StreamVehicles {
    vehicles: Vec<usize>,
    /// How far one comes that arrives, m.
    finish: f64,
}

impl StreamVehicles {
    /// Of a world.
    pub fn new(world: &World) -> Self {
        let vehicles = world.streams.iter().flat_map(|stream| stream.vehicles.iter().copied()).collect();
        Self { vehicles, finish: world.finish }
    }

    /// Those that a completed run did not wait for, so that they were still on their way in its last state: nothing of them was cut off, and
    /// nothing of them was seen to its end. None of a run that ended otherwise.
    pub fn not_awaited<'a>(
        &'a self,
        ending: &Ending,
        last: &'a Snapshot,
    ) -> impl Iterator<Item = usize> + 'a {
        let is_completed = ending.reason == StopReason::Completed;
        let all = self.vehicles.iter().copied().filter(move |_| is_completed);
        all.filter(|vehicle| last.vehicles[*vehicle].motion.travelled < self.finish)
    }
}

/// Follows who has arrived, from step to step.
pub(super) struct Arrivals {
    /// The way (m) of each pedestrian across the path of each vehicle, one after the other, where paths bend.
    across: Vec<f64>,
    streams: Vec<StreamArrivals>,
    /// The vehicles that belong to no stream; all of them where nothing is known of streams.
    alone: Vec<usize>,
}

/// A stream of which a run does not wait for every vehicle.
struct StreamArrivals {
    /// In the order in which they arrive.
    vehicles: Vec<usize>,
    /// When each would be at the middle of the crossing if it kept its cruise, s.
    due: Vec<f64>,
    /// Since when no pedestrian has its lane before them any more, s.
    left: Option<f64>,
}

impl StreamArrivals {
    /// Those whom a run waits for: who were due before the last pedestrian left the lane, and the next, who closes the gap. `None` while
    /// somebody has not left it.
    fn awaited(&self) -> Option<&[usize]> {
        let left = self.left?;
        let due = self.due.partition_point(|due| *due < left);
        Some(&self.vehicles[..(due + 1).min(self.vehicles.len())])
    }
}

impl Arrivals {
    /// Of a run that has not begun.
    pub fn new(world: &World) -> Self {
        let streams = world.streams.iter().map(|stream| StreamArrivals {
            vehicles: stream.vehicles.clone(),
            due: stream.arrivals.clone(),
            left: None,
        });
        let is_alone = |index: &usize| world.streams.iter().all(|stream| !stream.vehicles.contains(index));
        Self {
            across: ways_across(world),
            streams: streams.collect(),
            alone: (0..world.vehicles.len()).filter(is_alone).collect(),
        }
    }

    /// Whether every pedestrian that `comes` has left every vehicle's lane at `time` (s) and everybody whom they could have met has passed
    /// the finish line: every vehicle that is in no stream, and of a stream those up to the one that closes the gap that the last pedestrian
    /// took. Where nobody comes, every vehicle. To be asked after every step.
    pub fn are_complete(
        &mut self,
        world: &World,
        now: &Snapshot,
        time: f64,
        comes: impl Fn(usize) -> bool,
    ) -> bool {
        let Self { across, streams, alone } = self;
        let cars = now.vehicles.len();
        let people = || (0..now.pedestrians.len()).filter(|index| comes(*index));
        let has_left = |person: usize, car: usize| {
            let both = (&now.vehicles[car], &world.vehicles[car]);
            match now.vehicles[car].path.course() {
                Some(_) if !across.is_empty() => {
                    let come = walked(&world.pedestrians[person], now.pedestrians[person].position);
                    come >= across[person * cars + car]
                }
                // Those of a straight road as if there were no other.
                _ => has_crossed(world, now, person, both),
            }
        };
        for stream in streams.iter_mut() {
            let leaves = |person: usize| {
                let lane_of = stream.vehicles.first();
                now.pedestrians[person].present && lane_of.is_none_or(|car| has_left(person, *car))
            };
            stream.left = if people().all(leaves) { stream.left.or(Some(time)) } else { None };
        }
        let has_arrived = |vehicle: &usize| has_arrived(world, now, Solid::Vehicle(*vehicle));
        let is_waited_for = |stream: &StreamArrivals| match stream.awaited() {
            Some(awaited) => !awaited.iter().all(has_arrived),
            None => true,
        };
        let vehicles_arrived = if streams.is_empty() || people().next().is_none() {
            (0..cars).all(|vehicle| has_arrived(&vehicle))
        } else {
            alone.iter().all(has_arrived) && !streams.iter().any(is_waited_for)
        };
        let across_all =
            |person: usize| now.pedestrians[person].present && (0..cars).all(|car| has_left(person, car));
        vehicles_arrived && people().all(across_all)
    }
}
