//! Runs among vehicles that come one after the other: when they end, and that whoever comes after that changes nothing.

use std::sync::Arc;

use models::standard;
use proptest::prelude::*;
use results::{Outcome, Requests};
use runner::run::{FreeFlows, Unwatched, run_case};
use scenario::{
    Case, MetricReference, Settings, TrafficStream, VehicleReference, VehicleSetup, VehicleStart, World,
};
use sim::StopReason;
use sim::measure::Closeness;

use crate::support::street::{car, controller, dynamics_of, model, person, street, walker};

/// 30 km/h
const SPEED: f64 = 30.0 / 3.6;

/// A stream of a scenario: its name, its lane, and when its vehicles are due, s.
type Declared<'a> = (&'a str, usize, &'a [f64]);

fn member(name: &str, index: usize, lane: usize, due: f64) -> VehicleSetup {
    let start = VehicleStart::TimeToArrival { time: due, reference: VehicleReference::Centre, x: 0.0 };
    car(&TrafficStream::member_name(name, index), lane, SPEED, start)
}

/// A person at the kerb, and streams of vehicles with this controller.
fn world(streams: &[Declared], people: (&str, &Settings), drives: &str) -> World {
    let mut cars = Vec::new();
    let mut known = Vec::new();
    for (name, lane, due) in streams {
        let first = cars.len();
        cars.extend(due.iter().enumerate().map(|(index, due)| member(name, index, *lane, *due)));
        let vehicles = (first..cars.len()).collect();
        known.push(TrafficStream { name: (*name).to_string(), vehicles, arrivals: due.to_vec() });
    }
    for setup in &mut cars {
        setup.controller = controller(drives, &Settings::default());
        setup.dynamics = dynamics_of(drives);
    }
    let (name, settings) = people;
    let walker = walker("walker", model(name, settings), -4.0, 8.0);
    World { streams: known, horizon: 90.0, ..street(SPEED, cars, vec![walker]) }
}

fn outcome_of(world: &World, seed: u64, requests: &Requests) -> Outcome {
    let case = Case {
        key: "a/b".into(),
        scenario: "b".into(),
        variation: Vec::new(),
        individuals: Vec::new(),
        drawn: Vec::new(),
        impossible: None,
        repetition: 1,
        seed,
        world: Arc::new(world.clone()),
    };
    run_case(&case, requests, &FreeFlows::default(), &mut Unwatched).expect("a run")
}

fn outcome(world: &World, seed: u64) -> Outcome {
    outcome_of(world, seed, &Requests::defaults(&standard()))
}

/// Times of arrival with these gaps between them, s.
fn arrivals(first: f64, gaps: &[f64]) -> Vec<f64> {
    let mut due = vec![first];
    due.extend(gaps.iter().scan(first, |last, gap| {
        *last += gap;
        Some(*last)
    }));
    due
}

/// The people of the property tests, with settings.
fn people() -> Vec<(&'static str, Settings)> {
    let people = [1, 250, 500, 750].map(|number| ("commotions", person(number)));
    people
        .into_iter()
        .chain([("carla_walker", Settings::default()), ("jaywalker", Settings::default())])
        .collect()
}

fn bits(values: &[Option<f64>]) -> Vec<Option<u64>> {
    values.iter().map(|value| value.map(f64::to_bits)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_longer_stream_changes_nothing_of_a_run_that_ended_before_it_could_matter(
        first in 0.5..4.0_f64, gaps in proptest::collection::vec(2.0..7.0_f64, 9..12), more in 1_usize..6,
        late in 1.5..3.0_f64, who in 0_usize..6, drives in 0_usize..3, seed: u64,
    ) {
        let near = arrivals(first, &gaps);
        let far: Vec<f64> = near.iter().map(|due| due + late).collect();
        let last = near[near.len() - 1];
        let longer: Vec<f64> = near.iter().copied().chain((1..=more).map(|one| last + 2.5 * one as f64)).collect();
        let (name, settings) = &people()[who];
        let drives = ["constant_speed", "idm_aeb", "commotions"][drives];
        let of = |near: &[f64]| outcome(&world(&[("cars", 0, near), ("far", 1, &far)], (name, settings), drives), seed);
        let (short, long) = (of(&near), of(&longer));
        // Whoever closes the last gap is not the last of the stream.
        if short.ending.reason == StopReason::Completed && short.ending.time < last {
            prop_assert_eq!(short.ending, long.ending);
            prop_assert_eq!(short.fingerprint, long.fingerprint);
            prop_assert_eq!(bits(&short.metrics), bits(&long.metrics));
            prop_assert_eq!(&short.critical, &long.critical);
            prop_assert!(long.cut_off.is_none() && short.cut_off.is_none());
            let known = |vehicle: &str| short.presences.iter().any(|pair| &*pair.vehicle == vehicle);
            let (same, others): (Vec<_>, Vec<_>) =
                long.presences.iter().cloned().partition(|pair| known(&pair.vehicle));
            prop_assert_eq!(&short.presences, &same);
            prop_assert!(others.iter().all(|pair| pair.presence.closest <= Closeness::Apart && !pair.presence.moved));
        }
    }

    #[test]
    fn the_order_in_which_streams_are_declared_changes_nothing_but_indices(
        first in 0.5..4.0_f64, gaps in proptest::collection::vec(2.0..7.0_f64, 6..10), late in 1.5..3.0_f64,
        who in 0_usize..6, drives in 0_usize..2, seed: u64,
    ) {
        let near = arrivals(first, &gaps);
        let far: Vec<f64> = near.iter().map(|due| due + late).collect();
        let (name, settings) = &people()[who];
        let drives = ["constant_speed", "idm_aeb"][drives];
        let (cars, others) = (("cars", 0, &near[..]), ("far", 1, &far[..]));
        let of = |streams: &[Declared]| outcome(&world(streams, (name, settings), drives), seed);
        let (one, other) = (of(&[cars, others]), of(&[others, cars]));
        prop_assert_eq!(one.ending, other.ending);
        prop_assert_eq!(one.fingerprint, other.fingerprint);
        let sorted = |outcome: &Outcome| {
            let mut pairs = outcome.presences.clone();
            pairs.sort_by(|one, other| one.vehicle.cmp(&other.vehicle));
            pairs
        };
        prop_assert_eq!(sorted(&one), sorted(&other));
        let requests = Requests::defaults(&standard());
        for ((request, one), other) in requests.iter().zip(&one.metrics).zip(&other.metrics) {
            let scope = request.known().expect("a metric").scope;
            // Those of pedestrians alone are of the lane of the first vehicle.
            if scope != scenario::Scope::Pedestrian {
                prop_assert_eq!(one.map(f64::to_bits), other.map(f64::to_bits), "{}", request.label());
            }
        }
    }
}

/// A metric of one vehicle, and of it and the walker if it is of pairs.
fn metric_of(name: &str, vehicle: &str, with: &str) -> MetricReference {
    let requests = Requests::defaults(&standard());
    let found = requests.iter().find(|one| one.name() == name).expect("a metric").clone();
    MetricReference { pair: Some((vehicle.into(), with.into())), ..found }
}

/// Someone who walks on at 1 m/s, whatever comes, and is across both lanes at 10 s.
fn scripted() -> (&'static str, Settings) {
    ("scripted", Settings::from([("speed", scenario::Value::Number(1.0))]))
}

#[test]
fn nothing_of_a_vehicle_that_was_not_waited_for_is_a_number_a_failure_or_a_success() {
    let (name, settings) = scripted();
    // In lane 0 from 2 s to 6 s, in lane 1 from 6 s to 10 s.
    let due = [1.0, 12.0, 15.0, 18.0, 40.0];
    let street = world(&[("cars", 0, &due)], (name, &settings), "constant_speed");
    let mut requests = Requests::defaults(&standard());
    let names = [
        "collision",
        "min_distance",
        "min_ttc",
        "time_lost",
        "travel_time",
        "max_deceleration",
        "passed_first",
    ];
    let of_last = |name: &str| {
        let of_pair = !matches!(name, "time_lost" | "travel_time" | "max_deceleration");
        metric_of(name, "cars_3", if of_pair { "walker" } else { "" })
    };
    names.iter().for_each(|name| requests.add(&of_last(name)));
    let run = outcome_of(&street, 1, &requests);
    assert_eq!(run.ending.reason, StopReason::Completed);
    // The second closes the gap, and is at the finish line 20 m behind the crossing.
    assert!((run.ending.time - (12.0 + 20.0 / SPEED)).abs() < 0.03, "{:?}", run.ending);
    assert_eq!(run.cut_off, None);
    let value =
        |reference: &MetricReference| run.metrics[requests.index(reference).expect("it was asked for")];
    for name in names {
        assert_eq!(value(&of_last(name)), None, "{name}");
        assert!(
            (0..run.metrics.len())
                .filter_map(|index| run.critical.get(index))
                .all(|one| one.vehicle.as_deref() != Some("cars_3"))
        );
    }
    let all = |name: &str| run.metrics[requests.iter().position(|one| one.name() == name).expect("a metric")];
    assert_eq!((all("time_lost"), all("collision")), (Some(0.0), Some(0.0)));
    assert!(all("travel_time").is_some_and(|time| (time - 12.0 - 20.0 / SPEED).abs() < 1e-6));
    let presence = |vehicle: &str| run.presence(vehicle, "walker").expect("both were there");
    assert!(presence("cars_2").closest >= Closeness::Together && presence("cars_2").moved);
    assert_eq!((presence("cars_3").closest, presence("cars_3").moved), (Closeness::Apart, false));
}

#[test]
fn vehicles_that_touch_count_also_where_nobody_waits_for_them() {
    let (name, settings) = scripted();
    let mut street = world(&[("cars", 0, &[1.0, 12.0, 20.0, 21.0])], (name, &settings), "constant_speed");
    let free = outcome(&street, 1);
    // The last one is faster and runs into the one before it while the run lasts.
    street.vehicles[3].speed = 20.0;
    street.vehicles[3].start = VehicleStart::Distance(20.0 * SPEED + 40.0);
    let crash = outcome(&street, 1);
    let all = |run: &Outcome, name: &str| {
        run.metrics
            [Requests::defaults(&standard()).iter().position(|one| one.name() == name).expect("a metric")]
    };
    assert_eq!((all(&free, "collision"), all(&crash, "collision")), (Some(0.0), Some(1.0)));
    assert_eq!((free.ending.reason, free.ending), (StopReason::Completed, crash.ending));
    assert_ne!(free.fingerprint, crash.fingerprint);
    // Who has crashed never arrives.
    assert_eq!((all(&free, "travel_time").is_some(), all(&crash, "travel_time")), (true, None));
}

#[test]
fn every_vehicle_is_waited_for_where_nobody_walks_or_somebody_never_arrives() {
    let (name, settings) = scripted();
    let due = [1.0, 12.0, 15.0];
    let mut street = world(&[("cars", 0, &due)], (name, &settings), "constant_speed");
    // In the lane.
    street.pedestrians[0].goal.y = 1.0;
    street.pedestrians[0].start.y = -6.0;
    street.pedestrians[0].model = model("scripted", &Settings::default());
    let stays = outcome(&street, 1);
    assert_eq!((stays.ending.reason, stays.ending.time), (StopReason::Horizon, street.horizon));
    street.pedestrians.clear();
    let empty = outcome(&street, 1);
    assert_eq!(empty.ending.reason, StopReason::Completed);
    assert!((empty.ending.time - (15.0 + 20.0 / SPEED)).abs() < 0.03, "{:?}", empty.ending);
}

#[test]
fn of_a_stream_only_vehicles_that_stand_have_not_arrived_when_time_is_up() {
    let due = [1.0, 4.0, 7.0, 10.0];
    let not_arrived = |drives: &str| {
        let mut street = world(&[("cars", 0, &due)], ("scripted", &Settings::default()), drives);
        street.horizon = 8.0;
        // In the lane.
        street.pedestrians[0].start.y = -6.0;
        street.pedestrians[0].goal.y = 1.0;
        let run = outcome(&street, 1);
        assert_eq!(run.ending.reason, StopReason::Horizon);
        run.cut_off.expect("time was up").stranded.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let people = not_arrived("constant_speed");
    assert!(people.iter().all(|who| who == "walker"), "{people:?}");
    let all = not_arrived("yielding");
    assert!(all.iter().any(|who| who.starts_with("cars_")), "{all:?}");
}
