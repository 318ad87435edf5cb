//! What people can have seen before they may go: nothing, where they appear before a vehicle that moves and may go at once; and too much,
//! where all vehicles are past by then.

use super::sight::sees_vehicle;
use super::start::{beginning, meeting_place};
use scenario::agent::{Longitudinal, Scene, Snapshot};
use scenario::{Appearance, LookEffect, MayGo, PedestrianSetup, VehicleReference, World};

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
    comes(world, setup, &state).any(|vehicle| sees_vehicle(&scene, vehicle))
}

/// Whether a pedestrian looks for so long that every vehicle that it could have looked at is past before it may go, if none of them brakes.
pub fn looks_until_all_are_past(world: &World, pedestrian: usize) -> bool {
    let setup = &world.pedestrians[pedestrian];
    let MayGo::After(look) = setup.may_go else { return false };
    if !setup.crosses(&world.road) {
        return false;
    }
    let any = |after: f64| comes(world, setup, &after_appearance(world, setup, after)).next().is_some();
    any(0.0) && !any(look)
}

/// The vehicles that move and have yet to come by where a pedestrian meets their paths.
fn comes<'a>(
    world: &'a World,
    setup: &'a PedestrianSetup,
    state: &'a Snapshot,
) -> impl Iterator<Item = usize> + 'a {
    (0..state.vehicles.len()).filter(|vehicle| {
        let car = &state.vehicles[*vehicle];
        let moves = world.vehicles[*vehicle].placing_speed() > 0.0;
        moves && car.motion.travelled - car.length / 2.0 < setup.met_by(&car.path)
    })
}

/// Where everybody is so long (s) after a pedestrian has appeared.
fn after_appearance(world: &World, setup: &PedestrianSetup, after: f64) -> Snapshot {
    let mut state = beginning(world);
    let left = |vehicle: usize, reference: VehicleReference, wanted: f64| {
        let left = state.vehicles[vehicle].time_to_arrival(meeting_place(world, setup), reference) - wanted;
        if left.is_finite() { left.max(0.0) } else { 0.0 }
    };
    let appears = match setup.appears {
        Appearance::At(time) => time.max(0.0),
        Appearance::TimeToArrival { vehicle, reference, time } => left(vehicle, reference, time),
        Appearance::Meeting { vehicle, time, .. } => left(vehicle, VehicleReference::Front, time),
    };
    for (car, driven) in state.vehicles.iter_mut().zip(&world.vehicles) {
        let speed = driven.speed.min(driven.speed_at_start());
        let travelled = car.motion.travelled + (appears + after) * speed;
        *car = car.in_motion(Longitudinal { travelled, ..car.motion });
    }
    state
}
