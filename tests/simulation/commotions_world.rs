//! COMMOTIONS in the world: the zebra of the founding paper, two agents meeting, and the same bits in any order.

use models::calibrate::{
    Calibration, Candidates, Design, Request, calibrate, published_criteria, published_grid,
};
use models::pedestrian::commotions::Variant;
use models::standard;
use numbers::random::derive_seed;
use runner::run::road_users;
use scenario::population::Population;
use scenario::{
    Appearance, Direction, MayGo, ModelSetup, PedestrianSetup, Position, Road, Settings, Shape, Side, Value,
    VehicleReference, VehicleSetup, VehicleStart, World,
};
use sim::{Ending, Observer, Step, StopReason, simulate};
use std::sync::Arc;

use proptest::prelude::*;
use rayon::prelude::*;

const SPEED: f64 = 30.0 / 3.6;

/// The paper's zebra: 30 km/h, one pedestrian 4 m from the centre line of the lane and 2 m from the kerb, who appears
/// at a time to arrival.
fn zebra(controller: &str, tta: f64, person: Settings) -> World {
    let controller_model = standard().controllers().get(controller).unwrap().clone();
    let ideal = standard().dynamics().get("ideal").unwrap().clone();
    let walker = standard().pedestrians().get("commotions").unwrap().clone();
    World {
        road: Road::zebra(&[Direction::Forward, Direction::Backward], SPEED),
        other_roads: Vec::new(),
        vehicles: vec![VehicleSetup {
            name: "av".into(),
            controller: ModelSetup::resolved(&controller_model, &Settings::default()).unwrap(),
            dynamics: ModelSetup::resolved(&ideal, &Settings::default()).unwrap(),
            length: 4.2,
            width: 1.8,
            road: 0,
            lane: 0,
            speed: SPEED,
            initial_speed: None,
            start: VehicleStart::TimeToArrival { time: tta, reference: VehicleReference::Centre, x: 0.0 },
            behind: 0.0,
            sees: None,
            obeys_signals: false,
        }],
        pedestrians: vec![PedestrianSetup {
            kind: Default::default(),
            name: "walker".into(),
            model: ModelSetup::resolved(&walker, &person).unwrap(),
            shape: Shape::Rectangle { length: 0.8, width: 0.8 },
            side: Side::Near,
            start: Position { x: 0.0, y: -4.0 },
            goal: Position { x: 0.0, y: 8.0 },
            follows: None,
            stops: Vec::new(),
            crossing: 0,
            appears: Appearance::At(0.0),
            may_go: MayGo::AtOnce,
            reference: 0.0,
            obeys_signals: false,
        }],
        streams: Vec::new(),
        step: 0.025,
        horizon: 40.0,
        finish: 20.0,
        end_on_collision: false,
    }
}

/// When each of the two passes the conflict point, and every bit of where they were.
#[derive(Default, PartialEq, Debug, Clone)]
struct Passing {
    pedestrian: Option<f64>,
    vehicle: Option<f64>,
    path: Vec<(u64, u64)>,
}

impl Observer for Passing {
    fn observe(&mut self, step: &Step) {
        let (walker, car) = (&step.after.pedestrians[0], &step.after.vehicles[0]);
        let time = step.time + step.duration;
        if walker.position.y >= 0.0 {
            self.pedestrian.get_or_insert(time);
        }
        if car.motion.travelled >= 0.0 {
            self.vehicle.get_or_insert(time);
        }
        self.path.push((walker.position.y.to_bits(), car.motion.travelled.to_bits()));
    }
}

fn run(world: &World, seed: u64) -> (Ending, Passing) {
    let users = road_users(world, seed).unwrap();
    let mut passing = Passing::default();
    let ending = simulate(&Arc::new(world.clone()), users, &mut passing).unwrap();
    (ending, passing)
}

fn people() -> Population {
    Population::parse(
        "standard",
        None,
        &standard().pedestrians().get("commotions").unwrap().declaration,
        None,
    )
    .unwrap()
}

#[test]
fn gap_acceptance_rises_with_the_time_to_arrival() {
    let people = people();
    let rate = |tta: f64| {
        let accepted = (1..=400).into_par_iter().filter(|&run_number| {
            // Individuals spread over the population, one run each.
            let person = people.individual(1 + run_number * people.len() / 401).unwrap();
            let seed = derive_seed(20_261_121, &format!("zebra/{tta}/{run_number}"));
            let (_, passing) = run(&zebra("constant_speed", tta, person), seed);
            match (passing.pedestrian, passing.vehicle) {
                (Some(pedestrian), Some(vehicle)) => pedestrian < vehicle,
                (Some(_), None) => true,
                (None, _) => false,
            }
        });
        accepted.count() as f64 / 400.0
    };
    // The times to arrival of the paper.
    let rates = [6.0, 10.0, 14.0, 18.0].map(|tta| (tta, rate(tta)));
    println!("gap acceptance by time to arrival: {rates:?}");
    // With these individuals and with the published ones about four in ten accept 6 s (docs/populations.md).
    assert!(rates[0].1 <= 0.5, "{rates:?}");
    assert!(rates[3].1 >= 0.95, "{rates:?}");
    assert!(rates.windows(2).all(|pair| pair[0].1 <= pair[1].1), "{rates:?}");
}

#[test]
fn two_agents_meet_without_colliding_and_both_get_across() {
    let people = people();
    let collisions: Vec<usize> = (1..=60)
        .filter(|&number| {
            let mut world = zebra("commotions", 6.0, people.individual(number * 18).unwrap());
            world.end_on_collision = true;
            let (ending, passing) = run(&world, derive_seed(3, &number.to_string()));
            assert!(
                passing.pedestrian.is_some()
                    || ending.reason == StopReason::Horizon
                    || passing.vehicle.is_some()
            );
            ending.reason == StopReason::Collision
        })
        .collect();
    assert!(collisions.is_empty(), "{collisions:?}");
}

/// A calibration small enough to be repeated.
fn small_calibration() -> Request {
    let model = &standard().pedestrians().get("commotions").unwrap().declaration.clone();
    let variant = Variant::STANDARD;
    let candidates = Candidates::design(
        &Candidates::nothing_given(),
        &published_grid(&variant),
        Design::LatinHypercube(12),
        5,
        model,
    );
    let calibration = Calibration { variant, criteria: published_criteria(), repetitions: 2, seed: 9 };
    Request { calibration, candidates: candidates.unwrap(), design: String::new() }
}

#[test]
fn calibration_does_not_depend_on_threads() {
    let request = small_calibration();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| calibrate(&request, None, || ()).unwrap())
    };
    let alone = with(1);
    assert_eq!(alone, with(2));
    assert_eq!(alone, with(5));
    let failed: usize = alone.failed.iter().sum();
    assert_eq!(failed + alone.retained.len(), 12);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// The same case gives the same bits, whatever runs beside and before it.
    #[test]
    fn runs_are_bit_identical_in_any_order_and_on_any_thread(
        seeds in proptest::collection::vec(any::<u64>(), 4),
        number in 1usize..1000,
        tta in 5.0..18.0f64,
        agents in any::<bool>(),
        variant in prop_oneof![
            Just("oVAoBEvoAIoEAoSNvoPF"), Just("oVAaoVAloBEooBEvoAIoDAoSNcoPF"), Just("oVAoBEvoAIoEAoAN"),
        ],
    ) {
        let mut person = people().individual(number).unwrap();
        person.set("variant", Value::Word(variant.into()));
        let world = zebra(if agents { "commotions" } else { "constant_speed" }, tta, person);
        let forwards: Vec<_> = seeds.iter().map(|&seed| run(&world, seed)).collect();
        let mut backwards: Vec<_> = seeds.iter().rev().map(|&seed| run(&world, seed)).collect();
        backwards.reverse();
        prop_assert!(forwards == backwards);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let side_by_side: Vec<_> = pool.install(|| seeds.par_iter().map(|&seed| run(&world, seed)).collect());
        prop_assert!(forwards == side_by_side);
    }
}
