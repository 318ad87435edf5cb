//! What reading every metric off a run costs: one vehicle and one pedestrian, per simulation step.

use divan::Bencher;
use divan::counter::ItemsCount;
use models::standard;
use nalgebra::Vector2;
use scenario::{
    Appearance, Direction, MayGo, MetricReference, ModelSetup, Path, PedestrianSetup, Position, Reference,
    Road, Settings, Shape, Side, VehicleSetup, VehicleStart, World,
};
use sim::measure::{FreeFlow, Measurement};
use sim::{Abreast, Longitudinal, Minds, Mode, Observer, PedestrianState, Snapshot, Step, VehicleState};

fn main() {
    divan::main();
}

const STEP: f64 = 0.025;
const STEPS: usize = 600;

/// Every metric together; the item count is in steps, so items per second are steps per second.
#[divan::bench]
fn all_metrics(bencher: Bencher) {
    let registry = standard();
    let names: Vec<_> = registry.metrics().names().collect();
    measure(bencher, &names);
}

fn names() -> Vec<String> {
    standard().metrics().names().map(str::to_string).collect()
}

/// Each metric by itself, on top of what all of a pair share.
#[divan::bench(args = names())]
fn one_metric(bencher: Bencher, name: &str) {
    measure(bencher, &[name]);
}

fn measure(bencher: Bencher, names: &[&str]) {
    let world = world();
    let states: Vec<_> = (0..=STEPS).map(state).collect();
    let requests: Vec<_> =
        names.iter().map(|name| MetricReference::plain(standard().metrics().get(name).unwrap())).collect();
    let free_flow = FreeFlow { finish_time: Some(12.0), finish_speed: 10.0 };
    bencher
        .counter(ItemsCount::new(STEPS))
        .with_inputs(|| Measurement::new(&world, &requests, &[free_flow], &[1.4]))
        .bench_local_refs(|measurement| {
            for (k, pair) in states.windows(2).enumerate() {
                measurement.observe(&Step {
                    time: k as f64 * STEP,
                    duration: STEP,
                    before: &pair[0],
                    after: &pair[1],
                    whole: &pair[1],
                    pedestrian_modes: &[Mode::NONE],
                    vehicle_modes: &[Mode::NONE],
                    motions: &[],
                    contacts: &[],
                    sightings: &[],
                    abreast: &Abreast::default(),
                    views: Default::default(),
                    may_go: None,
                    minds: Minds::default(),
                });
            }
        });
}

/// The vehicle slows down and the pedestrian walks across in front of it.
fn state(k: usize) -> Snapshot {
    let time = k as f64 * STEP;
    let braking = time.min(4.0);
    let travelled = -80.0 + 10.0 * time - 0.5 * braking * braking - 4.0 * (time - braking);
    Snapshot {
        vehicles: vec![VehicleState::new(
            Path::straight(0.0, Direction::Forward),
            Longitudinal { travelled, speed: 10.0 - braking, acceleration: 0.0 },
            (4.5, 2.0),
        )],
        pedestrians: vec![PedestrianState {
            position: Vector2::new(0.0, -4.0 + 1.4 * (time - 3.0).max(0.0)),
            velocity: Vector2::new(0.0, if time > 3.0 { 1.4 } else { 0.0 }),
            acceleration: Vector2::zeros(),
            heading: Vector2::y(),
            shape: Shape::Disc { radius: 0.25 },
            present: true,
        }],
    }
}

fn world() -> World {
    fn nobody<T>() -> ModelSetup<T> {
        ModelSetup { model: Reference::unresolved(""), settings: Settings::default() }
    }
    World {
        road: Road::zebra(&[Direction::Forward], 10.0),
        other_roads: Vec::new(),
        vehicles: vec![VehicleSetup {
            name: "av".into(),
            controller: nobody(),
            dynamics: nobody(),
            length: 4.5,
            width: 2.0,
            road: 0,
            lane: 0,
            speed: 10.0,
            initial_speed: None,
            start: VehicleStart::Distance(80.0),
            behind: 0.0,
            sees: None,
            obeys_signals: false,
        }],
        pedestrians: vec![PedestrianSetup {
            kind: Default::default(),
            name: "walker".into(),
            model: nobody(),
            shape: Shape::Disc { radius: 0.25 },
            side: Side::Near,
            start: Position { x: 0.0, y: -4.0 },
            goal: Position { x: 0.0, y: 4.0 },
            follows: None,
            stops: Vec::new(),
            crossing: 0,
            appears: Appearance::At(0.0),
            may_go: MayGo::AtOnce,
            reference: 0.0,
            obeys_signals: false,
        }],
        streams: Vec::new(),
        step: STEP,
        horizon: 60.0,
        finish: 20.0,
        end_on_collision: true,
    }
}
