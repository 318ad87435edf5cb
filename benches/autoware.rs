//! What one control step of the reduced Autoware costs, planning ticks included.

use models::standard;
use models::vehicle::ControllerContext;
use nalgebra::Vector2;
use scenario::{Direction, ModelSetup, Road, Settings, Shape, VehicleSetup, VehicleStart, World};
use sim::{Controller, EgoState, Observation, RoadView, SeenPedestrian};

const CRUISE: f64 = 30.0 / 3.6;
const PERIOD: f64 = 0.03;

fn main() {
    divan::main();
}

/// A run of 10 s of control steps towards a crossing where `pedestrians` stand; divide by 333 for one step.
#[divan::bench(args = [0, 1, 4])]
fn approach_of_333_control_steps(bencher: divan::Bencher, pedestrians: usize) {
    bencher.with_inputs(|| (controller(), observation(pedestrians))).bench_local_values(
        |(mut controller, mut observation)| {
            for k in 0..333 {
                observation.time = f64::from(k) * PERIOD;
                observation.ego.distance_to_crossing = 60.0 - 0.15 * f64::from(k);
                observation.ego.speed = CRUISE - 0.02 * f64::from(k);
                divan::black_box(controller.act(&observation)).expect("it can always decide");
            }
        },
    );
}

fn controller() -> Box<dyn Controller> {
    let model = standard().controllers().get("autoware").unwrap().clone();
    let settings = model.declaration.resolve(&Settings::default()).unwrap();
    let setup = VehicleSetup {
        name: "av".to_string(),
        controller: ModelSetup::resolved(&model, &settings).unwrap(),
        dynamics: ModelSetup::resolved(standard().dynamics().get("delay_lag").unwrap(), &Settings::default())
            .unwrap(),
        length: 4.89,
        width: 1.896,
        road: 0,
        lane: 0,
        speed: CRUISE,
        initial_speed: None,
        start: VehicleStart::Distance(60.0),
        behind: 0.0,
        sees: None,
        obeys_signals: false,
    };
    let world = World {
        road: Road::zebra(&[Direction::Forward], CRUISE),
        other_roads: Vec::new(),
        vehicles: vec![setup],
        pedestrians: Vec::new(),
        streams: Vec::new(),
        step: 0.025,
        horizon: 60.0,
        finish: 20.0,
        end_on_collision: true,
    };
    let context =
        ControllerContext { settings: &settings, setup: &world.vehicles[0], world: &world, rank: 0, seed: 1 };
    (model.build)(&context).unwrap()
}

fn observation(pedestrians: usize) -> Observation {
    Observation {
        time: 0.0,
        ego: EgoState {
            distance_to_crossing: 60.0,
            speed: CRUISE,
            acceleration: 0.0,
            length: 4.89,
            width: 1.896,
            travelled: -60.0,
            curvature: 0.0,
            lateral_offset: 0.0,
            heading_error: 0.0,
        },
        cruise_speed: CRUISE,
        road: RoadView {
            lane_width: 4.0,
            speed_limit: CRUISE,
            crossing_width: 4.0,
            pedestrian_priority: true,
            signal: None,
            right_kerb: -2.0,
            left_kerb: 2.0,
            gradient: None,
            curvature_ahead: Vec::new(),
            crossings: Vec::new(),
        },
        pedestrians: (0..pedestrians)
            .map(|id| SeenPedestrian {
                kind: Default::default(),
                id,
                position: Vector2::new(50.0, -4.0 - 0.5 * id as f64),
                velocity: Vector2::zeros(),
                acceleration: Vector2::zeros(),
                shape: Shape::Disc { radius: 0.25 },
            })
            .collect(),
        vehicles: Vec::new(),
    }
}
