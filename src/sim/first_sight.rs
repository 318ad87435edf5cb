//! What people can have seen before they may go: nothing, where they appear before a vehicle that moves and may go at once; and too much,
//! where all vehicles are past by then.

use super::sight::sees_vehicle;
use super::start::{appears_after, beginning, is_to_come};
use scenario::agent::{Longitudinal, Scene, Snapshot};
use scenario::{LookEffect, MayGo, PedestrianSetup, World};

/// Whether a pedestrian, whose model believes what it has seen, may go within a step of its appearance, with a moving vehicle in sight that it can
/// meet.
/// Vehicles are taken to have kept the lower of their speeds until then.
pub fn decides_at_first_sight(world: &World, pedestrian: usize) -> bool {
    let setup = &world.pedestrians[pedestrian];
    let believes = setup.model.model.known().is_some_and(|model| model.look == LookEffect::Counts);
    if !believes || !setup.crosses(&world.road) {
        return false;
    }
    let state = after_appearance(world, setup, 0.0);
    let wait = setup.may_go.wait(|vehicle, reference| {
        let car = &state.vehicles[vehicle];
        car.time_to_arrival(setup.met_by(&car.path), reference)
    });
    if wait > world.step {
        return false;
    }
    let scene = Scene {
        time: 0.0,
        step: world.step,
        road: &world.road,
        crossing: setup.crossing,
        me: pedestrian,
        goal: setup.goal,
        legs: (0, 0),
        vehicles: &state.vehicles,
        pedestrians: &state.pedestrians,
        held: false,
    };
    to_come(world, setup, &state).any(|vehicle| sees_vehicle(&scene, vehicle))
}

/// Whether a pedestrian looks for so long that every vehicle that it could have looked at is past before it may go, if none of them brakes.
pub fn looks_until_all_are_past(world: &World, pedestrian: usize) -> bool {
    let setup = &world.pedestrians[pedestrian];
    let MayGo::After(look) = setup.may_go else { return false };
    if !setup.crosses(&world.road) {
        return false;
    }
    let any = |after: f64| to_come(world, setup, &after_appearance(world, setup, after)).next().is_some();
    any(0.0) && !any(look)
}

/// The vehicles that are yet to come.
fn to_come<'a>(
    world: &'a World,
    setup: &'a PedestrianSetup,
    state: &'a Snapshot,
) -> impl Iterator<Item = usize> + 'a {
    let both = world.vehicles.iter().zip(&state.vehicles).enumerate();
    both.filter(|(_, (driven, car))| is_to_come(driven, car, setup)).map(|(vehicle, _)| vehicle)
}

/// Where everybody is so long (s) after a pedestrian has appeared.
fn after_appearance(world: &World, setup: &PedestrianSetup, after: f64) -> Snapshot {
    let mut state = beginning(world);
    let time = appears_after(world, setup, &state.vehicles).unwrap_or(0.0) + after;
    for (car, driven) in state.vehicles.iter_mut().zip(&world.vehicles) {
        let speed = driven.speed.min(driven.speed_at_start());
        let travelled = car.motion.travelled + time * speed;
        *car = car.in_motion(Longitudinal { travelled, ..car.motion });
    }
    state
}
