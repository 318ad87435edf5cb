//! Streams and pedestrians worked out by hand, for the metrics of gaps, and what must hold for any.

use proptest::prelude::*;

use super::fixture::{Profile, Walk, measure_traffic, observe, request, world};
use scenario::{Appearance, Direction, Lane, MetricReference, TrafficStream, Value, World};
use sim::measure::{Open, Reading};

const STEPS: [f64; 2] = [0.005, 0.025];
const HORIZON: f64 = 30.0;
const METRICS: [&str; 5] =
    ["gap_taken", "gaps_missed", "entry_after_previous", "time_left_on_leaving", "step_back"];

/// A car of 4 m at 10 m/s whose centre arrives then, s: its front is there 0.2 s earlier.
fn arriving(time: f64) -> Profile {
    Profile::new(-10.0 * time, 10.0, &[])
}

fn traffic(arrivals: &[f64]) -> Vec<Profile> {
    arrivals.iter().map(|time| arriving(*time)).collect()
}

/// A world whose vehicles are one stream, `cars`, on its only lane.
fn street(step: f64, arrivals: &[f64]) -> World {
    let mut world = world(step, HORIZON);
    let car = world.vehicles[0].clone();
    let member =
        |index| scenario::VehicleSetup { name: TrafficStream::member_name("cars", index), ..car.clone() };
    world.vehicles = (0..arrivals.len()).map(member).collect();
    let vehicles = (0..arrivals.len()).collect();
    world.streams = vec![TrafficStream { name: "cars".into(), vehicles, arrivals: arrivals.to_vec() }];
    world
}

/// Stands 2 m beside the lane until then (s) and walks across at 1 m/s: it enters the lane 2 s later and leaves it 4 s after that.
fn crossing_from(start: f64) -> Walk {
    let mut walk = vec![(0.0, 0.0, -4.0)];
    if start > 0.0 {
        walk.push((start, 0.0, -4.0));
    }
    walk.push((start + 8.0, 0.0, 4.0));
    Walk(walk)
}

/// Never leaves its place beside the lane.
fn standing() -> Walk {
    Walk(vec![(0.0, 0.0, -4.0)])
}

fn readings(world: &World, cars: &[Profile], walk: &Walk) -> [Reading; 5] {
    let requests = METRICS.map(|name| request(name, []));
    measure_traffic(world, &requests, cars, walk).try_into().expect("one for each")
}

/// The values of [`METRICS`].
fn values(world: &World, cars: &[Profile], walk: &Walk) -> [Option<f64>; 5] {
    readings(world, cars, walk).map(|reading| reading.worst.and_then(|worst| worst.value))
}

fn opens(world: &World, cars: &[Profile], walk: &Walk) -> [Option<Open>; 5] {
    readings(world, cars, walk).map(|reading| reading.open)
}

#[track_caller]
fn assert_values(found: [Option<f64>; 5], expected: [Option<f64>; 5]) {
    let near = |(found, expected): (&Option<f64>, &Option<f64>)| match (found, expected) {
        (Some(found), Some(expected)) => (found - expected).abs() <= 1e-9,
        (found, expected) => found == expected,
    };
    assert!(found.iter().zip(&expected).all(near), "{METRICS:?}: {found:?} instead of {expected:?}");
}

fn outlasts(world: &World, cars: &[Profile], walk: &Walk) -> bool {
    observe(world, &[], cars, walk).outlasted().count() > 0
}

#[test]
fn a_gap_that_is_taken_in_time() {
    let arrivals = [5.0, 8.0, 14.0, 17.0];
    for step in STEPS {
        let world = street(step, &arrivals);
        // In at 8.5 s, out at 12.5 s; the fronts pass at 4.8 s, 7.8 s and 13.8 s.
        let walk = crossing_from(6.5);
        let found = values(&world, &traffic(&arrivals), &walk);
        assert_values(found, [Some(6.0), Some(1.0), Some(0.7), Some(1.3), Some(0.0)]);
        assert!(!outlasts(&world, &traffic(&arrivals), &walk));
        let [gap, _, _, left, _] = readings(&world, &traffic(&arrivals), &walk).map(|one| one.worst.unwrap());
        assert_eq!((gap.vehicle, gap.stream, gap.pedestrian), (None, Some(0), Some(0)));
        assert!((gap.instant.unwrap() - 8.5).abs() < 1e-9 && (left.instant.unwrap() - 12.5).abs() < 1e-9);
        // Only what goes by while the pedestrian is there is missed.
        let mut late = world.clone();
        late.pedestrians[0].appears = Appearance::At(5.0);
        let found = values(&late, &traffic(&arrivals), &walk);
        assert_values(found, [Some(6.0), Some(0.0), Some(0.7), Some(1.3), Some(0.0)]);
    }
}

#[test]
fn declared_arrivals_are_what_a_gap_is_and_fronts_say_which() {
    let world = street(0.025, &[5.0, 8.0, 14.0]);
    // All come a second late, so that the pedestrian goes before the second has passed.
    let late = traffic(&[6.0, 20.0, 21.0]);
    assert_values(
        values(&world, &late, &crossing_from(6.5)),
        [Some(3.0), Some(0.0), Some(8.5 - 5.8), Some(19.8 - 12.5), Some(0.0)],
    );
    // One drives through another that stands: no gap is as declared, and which one is missed nobody knows.
    let crossed = [arriving(5.0), Profile::new(-200.0, 0.0, &[]), arriving(7.0)];
    assert_values(
        values(&world, &crossed, &crossing_from(6.5)),
        [None, None, Some(8.5 - 6.8), None, Some(0.0)],
    );
}

#[test]
fn before_the_first_and_after_the_last() {
    let early = [20.0, 24.0];
    let world = street(0.025, &early);
    let found = values(&world, &traffic(&early), &crossing_from(0.0));
    assert_values(found, [None, Some(0.0), None, Some(13.8), Some(0.0)]);
    assert!(!outlasts(&world, &traffic(&early), &crossing_from(0.0)));
    // The stream is over, be there one gap in it or none.
    for over in [&[2.0, 3.0][..], &[3.0]] {
        let world = street(0.025, over);
        let found = values(&world, &traffic(over), &crossing_from(4.0));
        assert_values(found, [None, None, Some(3.2), None, Some(0.0)]);
        assert!(outlasts(&world, &traffic(over), &crossing_from(4.0)));
    }
    // Who was under way before the start has passed, and nobody knows when.
    let world = street(0.025, &[1.0, 20.0]);
    let under_way = [Profile::new(5.0, 10.0, &[]), arriving(20.0)];
    let found = values(&world, &under_way, &crossing_from(0.0));
    assert_values(found, [Some(19.0), Some(0.0), None, Some(13.8), Some(0.0)]);
}

#[test]
fn who_never_crosses_has_missed_at_least_what_went_by() {
    let arrivals = [3.0, 5.0, 8.0, 40.0, 44.0];
    let world = street(0.025, &arrivals);
    let cars = traffic(&arrivals);
    assert_values(values(&world, &cars, &standing()), [None, None, None, None, Some(0.0)]);
    let [gap, missed, after, left, back] = opens(&world, &cars, &standing());
    assert_eq!(gap, Some(Open { low: 4.0, high: 32.0 }));
    assert_eq!(
        [missed, after, left],
        [Some(Open::at_least(2.0)), Some(Open::at_least(0.0)), Some(Open::at_least(0.0))]
    );
    assert_eq!(back, Some(Open { low: 0.0, high: 1.0 }));
    assert!(!outlasts(&world, &cars, &standing()));
    // With the stream over, too, nothing says that it would not have missed more.
    let over = [3.0, 5.0, 8.0];
    let world = street(0.025, &over);
    let [gap, missed, after, left, _] = opens(&world, &traffic(&over), &standing());
    assert_eq!((gap, missed, left), (None, Some(Open::at_least(2.0)), None));
    assert!((after.unwrap().low - (HORIZON - 7.8)).abs() < 1e-9);
    assert!(outlasts(&world, &traffic(&over), &standing()));
    // Who is in the lane when time is up may have taken the gap in which it entered.
    let mut short = street(0.025, &arrivals);
    short.horizon = 11.0;
    let [gap, missed, ..] = opens(&short, &cars, &crossing_from(6.5));
    assert_eq!((gap, missed), (Some(Open { low: 4.0, high: 32.0 }), Some(Open::at_least(2.0))));
}

#[test]
fn who_steps_back_takes_the_gap_in_which_it_gets_across() {
    let arrivals = [6.0, 10.0, 18.0];
    let world = street(0.025, &arrivals);
    // In at 2 s, out again at 4 s; in at 11 s, through at 15 s.
    let walk =
        Walk(vec![(0.0, 0.0, -4.0), (3.0, 0.0, -1.0), (6.0, 0.0, -4.0), (9.0, 0.0, -4.0), (17.0, 0.0, 4.0)]);
    let found = values(&world, &traffic(&arrivals), &walk);
    assert_values(found, [Some(8.0), Some(1.0), Some(1.2), Some(2.8), Some(1.0)]);
    let back = readings(&world, &traffic(&arrivals), &walk)[4].worst.unwrap();
    assert!((back.instant.unwrap() - 4.0).abs() < 1e-9, "{back:?}");
}

#[test]
fn nothing_is_left_to_who_is_hit() {
    let arrivals = [5.0, 8.0, 14.0];
    for ends in [true, false] {
        let world = World { end_on_collision: ends, ..street(0.025, &arrivals) };
        let found = readings(&world, &traffic(&arrivals), &crossing_from(4.0));
        let hit = found[3].worst.unwrap();
        assert_eq!((hit.value, found[3].open), (Some(0.0), None));
        assert!((hit.instant.unwrap() - 7.775).abs() < 0.05, "{hit:?}");
        if ends {
            // It never gets across, so it took no gap; nothing more can come of it.
            assert!(found[..3].iter().all(|one| one.worst.is_none() && one.open.is_none()), "{found:?}");
        }
    }
}

#[test]
fn what_is_left_where_a_car_passes_or_brakes() {
    let left = |car: Profile| {
        let world = street(0.025, &[5.0, 14.0]);
        // In at 8.5 s, out at 12.5 s.
        values(&world, &[arriving(5.0), car], &crossing_from(6.5))[3]
    };
    #[track_caller]
    fn near(found: Option<f64>, expected: f64) {
        assert!((found.unwrap() - expected).abs() < 1e-9, "{found:?} instead of {expected}");
    }
    near(left(arriving(14.0)), 1.3);
    // Its front passes at 12.3 s, behind the back of somebody who is still in the lane: at 12.5 s it is beside them.
    near(left(arriving(12.5)), 0.0);
    near(left(arriving(12.0)), 0.0);
    // From 10 m/s to 5 m/s in 2 s as the pedestrian enters: 28 m at 5 m/s would be 5.6 s.
    near(left(Profile::new(-140.0, 10.0, &[(8.5, 0.0), (2.0, -2.5)])), 1.3);
    // It would have been there at 10.8 s and rolls on at 2 m/s, 7 m away.
    near(left(Profile::new(-110.0, 10.0, &[(8.5, 0.0), (2.0, -4.0)])), 0.0);
    // It stands, 43 m away.
    near(left(Profile::new(-140.0, 10.0, &[(8.5, 0.0), (2.0, -5.0)])), 0.0);
    // It has braked for who waits, long before they go, and creeps up: 5 m at 0.5 m/s are not 10 s.
    let creeps = Profile::new(-60.0, 10.0, &[(2.8, 0.0), (1.9, -5.0)]);
    let (place, speed) = creeps.at(12.5);
    near(left(creeps), (-place - 2.0) / 10.0);
    assert!((speed - 0.5).abs() < 1e-9);
    // Who never moves is not to come.
    assert_eq!(left(Profile::new(-60.0, 0.0, &[])), None);
}

/// Two lanes of 4 m, `near` on the first, around y = 0 m, and `far` on the second; the walk is from y = -4 m to 8 m.
fn two_lanes(near: &[f64], far: &[f64]) -> (World, Vec<Profile>) {
    let mut world = street(0.025, &[near, far].concat());
    world.road.lanes = vec![Lane { direction: Direction::Forward }, Lane { direction: Direction::Backward }];
    let split = near.len();
    world.vehicles[split..].iter_mut().for_each(|car| car.lane = 1);
    let stream = |name: &str, from: usize, arrivals: &[f64]| TrafficStream {
        name: name.into(),
        vehicles: (from..from + arrivals.len()).collect(),
        arrivals: arrivals.to_vec(),
    };
    world.streams = vec![stream("near", 0, near), stream("far", split, far)];
    (world.pedestrians[0].start.y, world.pedestrians[0].goal.y) = (-4.0, 8.0);
    let cars = traffic(&[near, far].concat());
    (world, cars)
}

fn of_stream(name: &str, stream: &str) -> MetricReference {
    MetricReference { pair: Some((stream.into(), "walker".into())), of_stream: true, ..request(name, []) }
}

fn of_lane(lane: f64) -> MetricReference {
    request("time_left_on_leaving", [("lane", Value::Number(lane))])
}

#[test]
fn each_lane_has_its_own_stream() {
    let (world, cars) = two_lanes(&[3.0, 6.0, 16.0], &[4.0, 9.0, 22.0]);
    // In the near lane from 7 s, in the far one from 11 s, out at 15 s.
    let walk = Walk(vec![(0.0, 0.0, -4.0), (5.0, 0.0, -4.0), (17.0, 0.0, 8.0)]);
    let requests = [
        of_stream("gap_taken", "near"),
        of_stream("gap_taken", "far"),
        of_stream("gaps_missed", "far"),
        of_stream("entry_after_previous", "near"),
        of_stream("entry_after_previous", "far"),
        of_lane(0.0),
        of_lane(1.0),
        of_lane(2.0),
        request("gap_taken", []),
    ];
    let found = measure_traffic(&world, &requests, &cars, &walk);
    let expected =
        [Some(10.0), Some(13.0), Some(1.0), Some(1.2), Some(2.2), Some(4.8), Some(6.8), None, Some(10.0)];
    for ((found, expected), request) in found.iter().zip(expected).zip(&requests) {
        let value = found.worst.and_then(|worst| worst.value);
        let near = value.zip(expected).is_some_and(|(one, other)| (one - other).abs() < 1e-9);
        assert!(near || value == expected, "{}: {value:?} instead of {expected:?}", request.label());
    }
    // The worst of both streams says which.
    assert_eq!(found[8].worst.unwrap().stream, Some(0));
    assert_eq!(found[1].worst.unwrap().stream, Some(1));
    // A step back out of the far lane into the near one.
    let walk =
        Walk(vec![(0.0, 0.0, -4.0), (7.0, 0.0, 3.0), (8.0, 0.0, 1.5), (9.0, 0.0, 1.5), (16.0, 0.0, 8.5)]);
    let (world, _) = two_lanes(&[25.0], &[26.0]);
    let back = measure_traffic(&world, &[request("step_back", [])], &traffic(&[25.0, 26.0]), &walk);
    assert_eq!(back[0].worst.unwrap().value, Some(1.0));
}

#[test]
fn a_stream_that_is_named_is_any_of_its_vehicles() {
    let (world, cars) = two_lanes(&[3.0, 6.0, 16.0], &[4.0, 9.0, 22.0]);
    let walk = Walk(vec![(0.0, 0.0, -4.0), (5.0, 0.0, -4.0), (17.0, 0.0, 8.0)]);
    let requests = ["near", "far"].map(|stream| of_stream("min_distance", stream));
    let found = measure_traffic(&world, &requests, &cars, &walk);
    assert_eq!(found.iter().map(|one| one.subjects.len()).collect::<Vec<_>>(), [3, 3]);
    assert!(
        found.iter().zip([0..3, 3..6]).all(|(one, cars)| cars.contains(&one.worst.unwrap().vehicle.unwrap()))
    );
    // Of a world without streams there is no such value.
    let alone = super::fixture::world(0.025, HORIZON);
    let found = measure_traffic(&alone, &[request("gap_taken", [])], &[arriving(14.0)], &crossing_from(6.5));
    assert!(found[0].worst.is_none() && found[0].subjects.is_empty());
}

proptest! {
    /// A vehicle that arrives after the end of the run changes no value, be it of the stream or not, and neither does another order of the
    /// vehicles in the world.
    #[test]
    fn far_vehicles_and_the_order_of_vehicles_change_nothing(
        gaps in proptest::collection::vec(0.8..7.0_f64, 1..6), start in 0.0..20.0_f64, pause in 0.0..3.0_f64, shift in 0_usize..6,
    ) {
        let mut arrivals = vec![2.0];
        for gap in gaps {
            arrivals.push(arrivals.last().unwrap() + gap);
        }
        // One that is after the end of the run already, so that there is always a next one.
        arrivals.push(60.0);
        let turned = Walk(vec![
            (0.0, 0.0, -4.0), (1.0 + start, 0.0, -4.0), (3.5 + start, 0.0, -1.5), (3.6 + start + pause, 0.0, -1.5), (10.0 + start, 0.0, 4.0),
        ]);
        let world = street(0.025, &arrivals);
        let cars = traffic(&arrivals);
        let expected = readings(&world, &cars, &turned);
        let numbers = |all: &[Reading; 5]| all.clone().map(|one| (one.worst.and_then(|worst| worst.value), one.open));

        let mut more = arrivals.clone();
        more.push(63.0);
        let found = readings(&street(0.025, &more), &traffic(&more), &turned);
        let values = |all: &[Reading; 5]| all.clone().map(|one| one.worst.and_then(|worst| worst.value));
        prop_assert_eq!(values(&expected), values(&found));

        let (mut beside, mut strangers) = (world.clone(), cars.clone());
        let stranger = beside.vehicles[0].clone();
        beside.vehicles.push(scenario::VehicleSetup { name: "van".into(), ..stranger });
        strangers.push(arriving(64.0));
        prop_assert_eq!(values(&expected), values(&readings(&beside, &strangers, &turned)));

        let count = arrivals.len();
        let mut other = world.clone();
        other.vehicles.rotate_left(shift % count);
        let mut moved = cars.clone();
        moved.rotate_left(shift % count);
        other.streams[0].vehicles = (0..count).map(|index| (index + count - shift % count) % count).collect();
        prop_assert_eq!(numbers(&expected), numbers(&readings(&other, &moved, &turned)));
        // Whoever is asked for lies where it may.
        let [gap, missed, after, left, _] = values(&expected);
        prop_assert!(gap.is_none_or(|gap| gap > 0.0));
        prop_assert!(missed.is_none_or(|missed| missed < count as f64));
        prop_assert!([after, left].into_iter().flatten().all(|time| time >= 0.0));
        if let (Some(gap), Some(after)) = (gap, after) {
            prop_assert!(after <= gap + 1e-9, "{} into a gap of {}", after, gap);
        }
    }
}
