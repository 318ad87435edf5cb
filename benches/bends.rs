//! What a bend costs: one run with every metric on a straight road, on the same road made of a line, and in a turn of Euro NCAP; with
//! somebody who walks by a script, which costs next to nothing, and with one who looks and decides.

use std::sync::Arc;

use divan::Bencher;
use models::standard;
use scenario::geometry::{Piece, Pose, ReferenceLine};
use scenario::{
    Bend, ControllerContext, MetricReference, ModelSetup, PedestrianContext, Position, Settings,
    VehicleStart, World,
};
use sim::measure::{FreeFlow, Measurement};
use sim::{Driven, RoadUsers, fixture, simulate};

fn main() {
    divan::main();
}

/// Who drives and who walks.
const WHO: [(&str, &str); 3] =
    [("constant_speed", "scripted"), ("yielding", "scripted"), ("yielding", "commotions")];

#[divan::bench(args = WHO)]
fn straight(bencher: Bencher, who: (&str, &str)) {
    run(bencher, world(who));
}

#[divan::bench(args = WHO)]
fn made_of_a_line(bencher: Bencher, who: (&str, &str)) {
    let line = ReferenceLine::new(Pose::origin(), &[Piece::line(100.0)]).unwrap();
    run(bencher, on(world(who), line, 60.0));
}

#[divan::bench(args = WHO)]
fn turning(bencher: Bencher, who: (&str, &str)) {
    let [one, arc, other] = Piece::turn(1500.0, 9.0, 0.36, 0.85);
    let pieces = [Piece::line(30.0), one, arc, other, Piece::line(40.0)];
    let line = ReferenceLine::new(Pose::origin(), &pieces).unwrap();
    let crossing = 30.0 + one.length + arc.length / 2.0;
    run(bencher, on(world(who), line, crossing));
}

/// A car that comes at 5 m/s from 30 m away, and somebody who crosses before it.
fn world((controller, walker): (&str, &str)) -> World {
    let registry = standard();
    let mut world = fixture::world();
    let entry = registry.controllers().get(controller).unwrap();
    let car = &mut world.vehicles[0];
    car.controller = ModelSetup::resolved(entry, &Settings::default()).unwrap();
    let dynamics = &entry.default_dynamics.known().unwrap().declaration.name;
    let dynamics = registry.dynamics().get(dynamics).unwrap();
    car.dynamics = ModelSetup::resolved(dynamics, &Settings::default()).unwrap();
    (car.start, car.speed) = (VehicleStart::Distance(30.0), 5.0);
    let walker = registry.pedestrians().get(walker).unwrap();
    world.pedestrians[0].model = ModelSetup::resolved(walker, &Settings::default()).unwrap();
    world
}

/// The same on a road along this line, its crossing at this station, m.
fn on(mut world: World, line: ReferenceLine, crossing: f64) -> World {
    let pose = line.pose(crossing);
    for person in &mut world.pedestrians {
        for place in [&mut person.start, &mut person.goal] {
            let at = pose.point + pose.normal() * place.y;
            *place = Position { x: at.x, y: at.y };
        }
    }
    world.road.bend = Some(Bend { line: Arc::new(line), crossing });
    world
}

fn run(bencher: Bencher, world: World) {
    let world = Arc::new(world);
    let requests: Vec<_> = standard().metrics().iter().map(MetricReference::plain).collect();
    let free_flow = FreeFlow { finish_time: Some(10.0), finish_speed: 5.0 };
    bencher
        .with_inputs(|| (Measurement::new(&world, &requests, &[free_flow], &[1.4]), road_users(&world)))
        .bench_local_values(|(mut measurement, users)| {
            simulate(&world, users, &mut measurement).unwrap();
            measurement.values()
        });
}

fn road_users(world: &World) -> RoadUsers {
    let (car, person) = (&world.vehicles[0], &world.pedestrians[0]);
    let context =
        ControllerContext { settings: &car.controller.settings, setup: car, world, rank: 0, seed: 1 };
    let controller = (car.controller.model.known().unwrap().build)(&context).unwrap();
    let dynamics = (car.dynamics.model.known().unwrap().build)(&car.dynamics.settings).unwrap();
    let context =
        PedestrianContext { settings: &person.model.settings, setup: person, world, rank: 0, seed: 1 };
    let pedestrian = (person.model.model.known().unwrap().build)(&context).unwrap();
    RoadUsers { vehicles: vec![Driven::new(controller, dynamics)], pedestrians: vec![pedestrian] }
}
