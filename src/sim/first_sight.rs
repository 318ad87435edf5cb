//! People who decide at first sight: they appear before the eyes of a vehicle that moves, and may go at once.

use super::sight::sees_vehicle;
use super::start::{beginning, meeting_place};
use scenario::agent::{Longitudinal, Scene, Snapshot};
use scenario::{Appearance, LookEffect, MayGo, PedestrianSetup, VehicleReference, World};

/// Whether a pedestrian, whose model believes what it has seen, may go as soon as it appears, with a moving vehicle in sight that it can meet.
/// Vehicles are taken to have kept the speed that they start with until then.
pub fn decides_at_first_sight(world: &World, pedestrian: usize) -> bool {
    let setup = &world.pedestrians[pedestrian];
    let believes = setup.model.model.known().is_some_and(|model| model.look == LookEffect::Counts);
    if !believes || setup.may_go != MayGo::AtOnce || !setup.crosses(&world.road) {
        return false;
    }
    let state = at_appearance(world, setup);
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
    let place = |vehicle: usize| setup.met_by(&state.vehicles[vehicle].path);
    let comes = |vehicle: &usize| {
        let car = &state.vehicles[*vehicle];
        car.motion.speed > 0.0 && car.motion.travelled - car.length / 2.0 < place(*vehicle)
    };
    (0..state.vehicles.len()).filter(comes).any(|vehicle| sees_vehicle(&scene, vehicle))
}

/// Where everybody is when a pedestrian appears.
fn at_appearance(world: &World, setup: &PedestrianSetup) -> Snapshot {
    let mut state = beginning(world);
    let left = |vehicle: usize, reference: VehicleReference, wanted: f64| {
        let left = state.vehicles[vehicle].time_to_arrival(meeting_place(world, setup), reference) - wanted;
        if left.is_finite() { left.max(0.0) } else { 0.0 }
    };
    let time = match setup.appears {
        Appearance::At(time) => time.max(0.0),
        Appearance::TimeToArrival { vehicle, reference, time } => left(vehicle, reference, time),
        Appearance::Meeting { vehicle, time, .. } => left(vehicle, VehicleReference::Front, time),
    };
    for car in &mut state.vehicles {
        let motion = car.motion;
        *car = car.in_motion(Longitudinal { travelled: motion.travelled + time * motion.speed, ..motion });
    }
    state
}
