//! CARLA's agent meets CARLA's walker at Town01's zebra: what follows from both codes taken together.

use models::standard;
use results::{Outcome, Requests};
use runner::run::{FreeFlows, Unwatched, run_case};
use scenario::{
    Appearance, Case, Direction, MayGo, MetricReference, ModelSetup, PedestrianSetup, Position, Road,
    Settings, Shape, Side, Value, VehicleReference, VehicleSetup, VehicleStart, World,
};

fn settings(pairs: &[(&str, Value)]) -> Settings {
    Settings::from(pairs)
}

fn number(value: f64) -> Value {
    Value::Number(value)
}

fn word(word: &str) -> Value {
    Value::Word(word.into())
}

/// The encounter at a time to arrival (s) after the pedestrian's appearance.
fn encounter(tta: f64, car: &str, agent: &[(&str, Value)], walker: &[(&str, Value)]) -> Outcome {
    let controller = standard().controllers().get("carla_behavior").unwrap().clone();
    let dynamics = standard().dynamics().get(car).unwrap().clone();
    let model = standard().pedestrians().get("carla_walker").unwrap().clone();
    let (length, width) = dynamics.size;
    let world = World {
        road: Road::zebra(&[Direction::Forward, Direction::Backward], 30.0 / 3.6),
        other_roads: Vec::new(),
        vehicles: vec![VehicleSetup {
            name: "av".into(),
            controller: ModelSetup::resolved(&controller, &settings(agent)).unwrap(),
            dynamics: ModelSetup::resolved(&dynamics, &Settings::default()).unwrap(),
            length,
            width,
            road: 0,
            lane: 0,
            speed: 30.0 / 3.6,
            initial_speed: None,
            start: VehicleStart::TimeToArrival { time: tta, reference: VehicleReference::Centre, x: 0.0 },
            behind: 0.0,
            sees: None,
            obeys_signals: false,
        }],
        pedestrians: vec![PedestrianSetup {
            kind: Default::default(),
            name: "walker".into(),
            model: ModelSetup::resolved(&model, &settings(walker)).unwrap(),
            shape: Shape::Rectangle { length: 0.375, width: 0.375 },
            side: Side::Near,
            start: Position { x: 0.0, y: -4.0 },
            goal: Position { x: 0.0, y: 7.0 },
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
        horizon: 60.0,
        finish: 60.0,
        end_on_collision: true,
    };
    let case = Case {
        key: format!("carla/{car}/tta={tta}"),
        scenario: "carla".into(),
        variation: Vec::new(),
        individuals: Vec::new(),
        drawn: Vec::new(),
        impossible: None,
        repetition: 1,
        seed: 1,
        world: world.into(),
    };
    run_case(&case, &Requests::defaults(&standard()), &FreeFlows::default(), &mut Unwatched).unwrap()
}

fn metric(outcome: &Outcome, name: &str) -> Option<f64> {
    let reference = MetricReference::plain(standard().metrics().get(name).unwrap());
    outcome.metrics[Requests::defaults(&standard()).index(&reference).unwrap()]
}

fn collides(outcome: &Outcome) -> bool {
    metric(outcome, "collision") == Some(1.0)
}

/// At 1.4 m/s the walker is at the conflict point after 2.86 s, so without waiting it is first at any TTA >= 6 s.
#[test]
fn without_waiting_the_walker_is_first_and_nobody_collides() {
    for tta in [6.0, 10.0, 14.0, 18.0] {
        let outcome = encounter(tta, "prius", &[], &[("kerb_wait", number(0.0))]);
        assert!(!collides(&outcome), "{tta}");
        let pet = metric(&outcome, "pet").unwrap();
        assert!((pet - (tta - 4.0 / 1.4)).abs() < 0.01, "{tta}: {pet}");
    }
}

/// Collisions need a wait of several seconds before the kerb; up to 13 s they can happen at a TTA of 6, 10 and 14 s but
/// not at 18 s.
#[test]
fn collisions_need_waits() {
    let waits = |tta: f64| {
        (0..=52).map(|k| f64::from(k) * 0.25).filter(move |wait| {
            let walker = [("kerb_wait", number(*wait)), ("vehicles_nearby", word("static"))];
            collides(&encounter(tta, "prius", &[], &walker))
        })
    };
    for tta in [6.0, 10.0, 14.0] {
        let colliding: Vec<f64> = waits(tta).collect();
        // The walker enters the lane 1.43 s after it started and the car passes around the TTA.
        assert!(!colliding.is_empty(), "{tta}");
        assert!(colliding.iter().all(|wait| (tta - 4.5..tta - 0.5).contains(wait)), "{tta}: {colliding:?}");
    }
    assert_eq!(waits(18.0).count(), 0);
}

/// Nothing beyond about 5.3 m has an effect in the unmodified agent; in the extended one everything has.
#[test]
fn only_the_extended_agent_feels_a_larger_braking_distance() {
    let run = |mode: &str, distance: f64, wait: f64| {
        let agent = [("obstacle_distance", word(mode)), ("braking_distance", number(distance))];
        encounter(10.0, "model3", &agent, &[("kerb_wait", number(wait))]).fingerprint
    };
    for wait in [5.0, 6.0, 7.0] {
        assert_eq!(run("stock", 5.3, wait), run("stock", 25.0, wait), "{wait}");
        assert_ne!(run("extended", 5.3, wait), run("extended", 25.0, wait), "{wait}");
    }
}

/// Half brake is a sudden change with the Model 3 and the MKZ, but never with the Prius.
#[test]
fn sudden_changes_depend_on_the_car() {
    let hardest = |car: &str| {
        let waits = (0..=20).map(|k| 5.0 + f64::from(k) * 0.2);
        let runs = waits.map(|wait| encounter(10.0, car, &[], &[("kerb_wait", number(wait))]));
        runs.filter_map(|outcome| metric(&outcome, "max_deceleration")).fold(0.0, f64::max)
    };
    assert!(hardest("prius") < 2.5, "{}", hardest("prius"));
    assert!(hardest("model3") > 2.5 && hardest("mkz2020") > 2.5);
}
