//! What does not matter changes nothing: road users among several others, over all models of pedestrians and all controllers.
//!
//! A vehicle that is far, past or parked, somebody far down the road, twins, the order of declaration; and what a
//! COMMOTIONS road user makes of several others at once.

use crate::support::counting::allocations;
use crate::support::street::{self, Course, car, controller, model, person, run, street};
use models::standard;
use proptest::prelude::*;
use rayon::prelude::*;
use runner::run::road_users;
use scenario::{Appearance, CrossingKind, ModelSetup, Settings, Value, VehicleSetup, VehicleStart, World};
use sim::{Observer, Step, simulate};
use std::sync::Arc;

/// 30 km/h
const SPEED: f64 = 30.0 / 3.6;

/// A name that outlives the registry it is from.
fn leaked(name: &str) -> &'static str {
    name.to_string().leak()
}

/// Every pedestrian model, with what it needs to decide on vehicles.
fn pedestrians() -> Vec<(&'static str, Settings)> {
    let registry = standard();
    let all = registry.pedestrians().names().chain(["jaywalker dash", "jaywalker yang", "jaywalker brewer"]);
    all.map(|name| (leaked(name.split(' ').next().unwrap()), settings_of(name))).collect()
}

fn settings_of(name: &str) -> Settings {
    let word = |word: &str| Value::Word(word.into());
    match name {
        "timeline" => Settings::from([
            ("steps", word("when time_to_arrival < t1 stop; after t2 resume")),
            ("t1", Value::Number(5.0)),
            ("t2", Value::Number(3.0)),
        ]),
        "jaywalker dash" => Settings::from([("tactic", word("dash"))]),
        "jaywalker yang" => Settings::from([("oncoming", word("yang"))]),
        "jaywalker brewer" => Settings::from([("gap_model", word("brewer")), ("risk", word("normal"))]),
        "commotions" => person(500),
        _ => Settings::default(),
    }
}

/// Every controller, with what it needs.
fn controllers() -> Vec<(&'static str, Settings)> {
    let registry = standard();
    let all = registry.controllers().names().map(leaked);
    let settings = |name: &str| match name {
        "timeline" => Settings::from([
            ("steps", Value::Word("at t1 speed v1".into())),
            ("t1", Value::Number(2.0)),
            ("v1", Value::Number(6.0)),
        ]),
        // Otherwise, as CARLA does, it looks at the first of its list alone.
        "carla_behavior" => Settings::from([("obstacle_distance", Value::Word("clean".into()))]),
        "constant_deceleration" => Settings::from([("distance", Value::Number(20.0))]),
        _ => Settings::default(),
    };
    all.map(|name| (name, settings(name))).collect()
}

/// Where along the road somebody walks (m), how fast (m/s), after how long (s), and whether from the near side.
type Stroll = (f64, f64, f64, bool);

/// A walker of this model and one vehicle at constant speed, with others besides.
fn walk(name: &str, settings: &Settings, tta: f64, others: Vec<VehicleSetup>) -> World {
    let mut cars = vec![car("av", 0, SPEED, at(tta * SPEED))];
    cars.extend(others);
    street(SPEED, cars, vec![street::walker("walker", model(name, settings), -4.0, 8.0)])
}

fn at(distance: f64) -> VehicleStart {
    VehicleStart::Distance(distance)
}

/// Whether `who` went the same way, bit for bit, as long as both runs lasted.
fn same_bits(one: &Course, other: &Course, who: &str) -> bool {
    one.points(who)
        .zip(other.points(who))
        .all(|(one, other)| one.map(f64::to_bits) == other.map(f64::to_bits))
}

/// The largest difference of where `who` was (m), as long as both runs lasted.
fn apart(one: &Course, other: &Course, who: &str) -> f64 {
    let distance =
        |(one, other): ([f64; 2], [f64; 2])| (one[0] - other[0]).abs().max((one[1] - other[1]).abs());
    one.points(who).zip(other.points(who)).map(distance).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_vehicle_that_is_past_and_drives_off_changes_not_one_bit(
        tta in 2.0..16.0, seed: u64, lane in 0usize..2, behind in 20.0..200.0f64, first: bool,
    ) {
        for (name, settings) in pedestrians() {
            let alone = run(&walk(name, &settings, tta, vec![]), seed);
            let mut world = walk(name, &settings, tta, vec![car("past", lane, SPEED, at(-behind))]);
            if first {
                world.vehicles.reverse();
            }
            let among = run(&world, seed);
            if name == "social_force" {
                // Its force reaches everywhere, by exp(-distance / 1 m).
                prop_assert!(apart(&alone, &among, "walker") < 1e-5, "{}", apart(&alone, &among, "walker"));
            } else {
                prop_assert!(same_bits(&alone, &among, "walker"), "{name} {settings:?}");
            }
        }
    }

    /// Until the vehicle is past or its lane is left behind; then the jaywalker, who looks for one to meet, looks at the next.
    #[test]
    fn a_vehicle_that_is_far_changes_nothing(tta in 2.0..16.0, seed: u64, lane in 0usize..2) {
        for (name, settings) in pedestrians().into_iter().filter(|(name, _)| *name != "commotions") {
            let mut world = walk(name, &settings, tta, vec![]);
            world.horizon = tta - 0.05;
            let alone = run(&world, seed);
            world.vehicles.push(car("far", lane, SPEED, at(1200.0)));
            let among = run(&world, seed);
            let behind = |course: &Course| course.points("walker").take_while(|place| name != "jaywalker" || place[1] < 2.0).count();
            let before = behind(&alone);
            prop_assert_eq!(before, behind(&among), "{} {:?}", name, settings);
            let both = alone.points("walker").zip(among.points("walker")).take(before);
            prop_assert!(both.into_iter().all(|(one, other)| one.map(f64::to_bits) == other.map(f64::to_bits)), "{name} {settings:?}");
        }
    }

    #[test]
    fn a_vehicle_parked_down_the_road_changes_nothing(
        tta in 2.0..16.0, seed: u64, lane in 0usize..2, place in 40.0..100.0,
    ) {
        for (name, settings) in pedestrians() {
            let mut world = walk(name, &settings, tta, vec![]);
            world.horizon = tta - 0.05;
            let alone = run(&world, seed);
            world.vehicles.push(car("parked", lane, 0.0, at(place)));
            let among = run(&world, seed);
            let same = same_bits(&alone, &among, "walker");
            prop_assert!(same || name == "social_force" && apart(&alone, &among, "walker") < 1e-5, "{name} {settings:?}");
        }
    }

    #[test]
    fn the_order_in_which_vehicles_are_declared_changes_no_bit(
        seed: u64,
        cars in prop::collection::vec(
            (0usize..2, prop_oneof![Just(0.0), 4.0..14.0], prop_oneof![Just(45.0), Just(60.0), -20.0..120.0]), 2..5,
        ).prop_flat_map(|cars| {
            let named: Vec<_> = cars.into_iter().enumerate().collect();
            (Just(named.clone()), Just(named).prop_shuffle())
        }),
    ) {
        for (name, settings) in pedestrians() {
            let among = |cars: &[(usize, (usize, f64, f64))]| {
                let cars = cars.iter().map(|&(k, (lane, speed, place))| car(&format!("car{k}"), lane, speed, at(place)));
                let walkers = vec![street::walker("walker", model(name, &settings), -4.0, 8.0)];
                run(&street(SPEED, cars.collect(), walkers), seed)
            };
            prop_assert!(same_bits(&among(&cars.0), &among(&cars.1), "walker"), "{name} {settings:?}");
        }
    }

    #[test]
    fn two_equal_vehicles_are_as_one(tta in 2.0..16.0, seed: u64) {
        // The social force adds up, as forces do.
        for (name, settings) in pedestrians().into_iter().filter(|(name, s)| {
            *name != "social_force" && !s.0.contains_key("oncoming")
        }) {
            let alone = run(&walk(name, &settings, tta, vec![]), seed);
            let twin = vec![car("twin", 0, SPEED, at(tta * SPEED))];
            prop_assert!(same_bits(&alone, &run(&walk(name, &settings, tta, twin), seed), "walker"), "{name}");
        }
    }

    #[test]
    fn somebody_far_down_the_road_changes_nothing(
        tta in 3.0..10.0, seed: u64, place in prop_oneof![Just(1200.0), -1200.0..-150.0], first: bool,
    ) {
        for (name, settings) in controllers() {
            let world = |someone: bool| {
                let mut people = vec![street::walker("walker", model("scripted", &Settings::default()), -4.0, 8.0)];
                if someone {
                    let mut far = street::walker("far", model("scripted", &Settings::default()), -4.0, 8.0);
                    (far.start.x, far.goal.x) = (place, place);
                    people.push(far);
                }
                if first {
                    people.reverse();
                }
                let mut av = car("av", 0, SPEED, at(tta * SPEED));
                av.controller = controller(name, &settings);
                av.dynamics = street::dynamics_of(name);
                let mut world = street(SPEED, vec![av], people);
                world.horizon = 15.0;
                world
            };
            let (alone, among) = (run(&world(false), seed), run(&world(true), seed));
            // People far ahead are people to a COMMOTIONS driver, who is asked about them below.
            if name != "commotions" || place < 0.0 {
                prop_assert!(same_bits(&alone, &among, "av"), "{name} {:.3}", apart(&alone, &among, "av"));
            }
        }
    }

    #[test]
    fn the_order_in_which_pedestrians_are_declared_changes_no_bit(
        tta in 3.0..10.0,
        seed: u64,
        people in prop::collection::vec((-3.0..3.0f64, 0.5..2.0f64, 0.0..6.0f64, any::<bool>()), 2..5)
            .prop_flat_map(|people| {
                let named: Vec<_> = people.into_iter().enumerate().collect();
                (Just(named.clone()), Just(named).prop_shuffle())
            }),
    ) {
        for (name, settings) in controllers() {
            let among = |people: &[(usize, Stroll)]| {
                let walkers = people.iter().map(|&(k, (x, speed, delay, near))| {
                    let settings = Settings::from([("speed", Value::Number(speed)), ("delay", Value::Number(delay))]);
                    let (from, to) = if near { (-4.0, 8.0) } else { (8.0, -4.0) };
                    let mut walker = street::walker(&format!("walker{k}"), model("scripted", &settings), from, to);
                    let x = 1.7 * k as f64 - 2.5 + x / 8.0;
                    (walker.start.x, walker.goal.x) = (x, x);
                    walker
                });
                let mut av = car("av", 0, SPEED, at(tta * SPEED));
                av.controller = controller(name, &settings);
                av.dynamics = street::dynamics_of(name);
                let mut world = street(SPEED, vec![av], walkers.collect());
                world.horizon = 20.0;
                run(&world, seed)
            };
            prop_assert!(same_bits(&among(&people.0), &among(&people.1), "av"), "{name}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Of drivers and pedestrians who draw, in the same run.
    #[test]
    fn the_order_in_which_road_users_are_declared_changes_no_bit_of_a_whole_run(
        seed: u64,
        cars in Just(["av", "bus", "cab", "dray"]).prop_shuffle(),
        people in Just(["ann", "ben", "cat", "dan", "eve"]).prop_shuffle(),
        headway in 1.0..4.0f64,
    ) {
        let world = |cars: [&str; 4], people: [&str; 5]| {
            let vehicle = |name: &str| {
                let place = cars_by_name(name) as f64;
                let mut vehicle = car(name, name.len() % 2, SPEED, at(SPEED * (4.0 + headway * place)));
                let model = if name == "dray" { "autoware" } else { "commotions" };
                let settings = if name == "dray" { Settings::default() } else { person(100 + 200 * cars_by_name(name)) };
                vehicle.controller = controller(model, &settings);
                vehicle.dynamics = street::dynamics_of(model);
                vehicle
            };
            let walker = |name: &str| {
                let (model_name, settings, x) = match name {
                    "ann" => ("commotions", person(300), 0.0),
                    "ben" => ("commotions", person(600), 1.0),
                    "cat" => ("commotions", person(900), -1.0),
                    "dan" => ("carla_walker", Settings::default(), 2.0),
                    _ => ("social_force", Settings::default(), -2.0),
                };
                let (from, to) = if name == "ben" { (8.0, -4.0) } else { (-4.0, 8.0) };
                let mut walker = street::walker(name, model(model_name, &settings), from, to);
                (walker.start.x, walker.goal.x) = (x, x);
                walker
            };
            street(SPEED, cars.map(vehicle).to_vec(), people.map(walker).to_vec())
        };
        let names = (["av", "bus", "cab", "dray"], ["ann", "ben", "cat", "dan", "eve"]);
        let (one, other) = (run(&world(names.0, names.1), seed), run(&world(cars, people), seed));
        for who in names.0.iter().chain(&names.1) {
            prop_assert!(same_bits(&one, &other, who), "{who} by {:.3} m", apart(&one, &other, who));
        }
    }
}

fn cars_by_name(name: &str) -> usize {
    ["av", "bus", "cab", "dray"].iter().position(|one| *one == name).unwrap()
}

/// Mean and standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt())
}

/// Whether paired values differ by nothing beyond three standard errors.
fn assert_no_difference(what: &str, of: impl Fn(&Course) -> f64, alone: &[Course], among: &[Course]) {
    let differences: Vec<f64> = alone.iter().zip(among).map(|(one, other)| of(other) - of(one)).collect();
    let (mean, error) = mean(&differences);
    println!("{what}: {mean:+.4} ± {error:.4}");
    assert!(mean.abs() <= 3.0 * error, "{what}: {mean} ± {error}");
}

/// Runs of so many individuals of `standard`, one each.
fn runs(count: usize, world: impl Fn(Settings) -> World + Sync) -> Vec<Course> {
    some_runs(count, 1, world)
}

/// One of every `every` of these runs.
fn some_runs(count: usize, every: usize, world: impl Fn(Settings) -> World + Sync) -> Vec<Course> {
    let one = |k: usize| run(&world(person(1 + k * 1000 / count)), 1000 + k as u64);
    (0..count).into_par_iter().step_by(every).map(one).collect()
}

#[test]
fn for_a_commotions_pedestrian_what_does_not_matter_changes_no_share() {
    let among = |others: &[VehicleSetup]| {
        runs(1000, |person| {
            let mut world = walk("commotions", &person, 8.0, others.to_vec());
            world.horizon = 20.0;
            world
        })
    };
    let alone = among(&[]);
    let first = |course: &Course| f64::from(u8::from(course.first));
    let (share, _) = mean(&alone.iter().map(first).collect::<Vec<_>>());
    // Something is at stake: some go first and some do not.
    assert!((0.5..0.95).contains(&share), "{share}");
    for (what, other) in [
        ("far", car("far", 1, SPEED, at(1200.0))),
        ("parked beside the crossing", car("parked", 1, 0.0, at(7.0))),
        ("leaving", car("leaving", 1, SPEED, at(3.0))),
    ] {
        let among = among(&[other]);
        assert_no_difference(&format!("{what}: share first"), first, &alone, &among);
        assert_no_difference(&format!("{what}: across"), |c| c.across.unwrap_or(20.0), &alone, &among);
        assert_no_difference(&format!("{what}: contacts"), |c| f64::from(u8::from(c.hit())), &alone, &among);
    }
}

/// Cars that do not react, so that contacts show what people overlook. The control is the first of them alone, which is
/// the published model: at 4 s some of the 600 walk into it.
#[test]
#[ignore = "it takes as long as many other tests of this program together"]
fn few_people_overlook_a_car_in_a_queue_and_whom_one_car_does_not_stop_gets_across() {
    assert_few_overlook_a_queue(&[4.0]);
}

#[test]
#[ignore = "it takes as long as most other tests of this program together"]
fn few_people_overlook_a_car_in_a_queue_that_comes_earlier_or_later() {
    assert_few_overlook_a_queue(&[3.0, 4.8, 6.0]);
}

/// Of queues whose first car is there after so many seconds.
fn assert_few_overlook_a_queue(firsts: &[f64]) {
    let before = |first: f64, cars: i32, headway: f64| {
        runs(600, move |person| {
            let time = |k: i32| first + headway * f64::from(k);
            let car = |k: i32| car(&format!("car{k}"), 0, SPEED, at(SPEED * time(k)));
            let walker = street::walker("walker", model("commotions", &person), -4.0, 4.0);
            let mut world = street(SPEED, (0..cars).map(car).collect(), vec![walker]);
            world.horizon = time(cars) + 14.0;
            world
        })
    };
    let stays = |course: &Course| course.across.is_none();
    for &first in firsts {
        let alone = before(first, 1, 0.0);
        let hit_alone = alone.iter().filter(|course| course.hit()).count();
        for (headway, most) in [(2.5, 6), (6.0, 0)] {
            let queue = before(first, 10, headway);
            let hit = queue.iter().filter(|course| course.hit()).count();
            let more = queue.iter().zip(&alone).filter(|(queue, alone)| queue.hit() && !alone.hit()).count();
            let aside = |hit: &street::Hit| hit.time > first + headway * hit.vehicle as f64;
            let sides = queue.iter().filter(|course| course.hits.first().is_some_and(aside)).count();
            let waited = queue.iter().filter(|course| !course.first).count();
            let stay = queue.iter().filter(|course| stays(course)).count();
            println!(
                "first after {first} s, then every {headway} s: {hit} contacts, {more} of them of people whom the first alone \
                 does not touch ({hit_alone}), {sides} after its middle was past; {waited} of 600 did not go first, {stay} stay"
            );
            assert!(more <= most && waited > 100, "{more} contacts more at {first} and {headway} s");
            assert!(alone.iter().zip(&queue).all(|(alone, queue)| stays(alone) || !stays(queue)));
        }
    }
}

#[test]
fn nobody_freezes_before_a_queue_that_gives_way() {
    let before = |cars: i32| {
        (0..200).into_par_iter().map(move |k| {
            let car = |n: i32| car(&format!("car{n}"), 0, SPEED, at(SPEED * (5.0 + 3.0 * f64::from(n))));
            let walker = street::walker("walker", model("commotions", &person(1 + 5 * k)), -4.0, 4.0);
            let mut world = street(SPEED, (0..cars).map(car).collect(), vec![walker]);
            world.horizon = 120.0;
            street::run_before_giving_way(&world, k as u64)
        })
    };
    let one: Vec<_> = before(1).collect();
    let queue: Vec<_> = before(10).collect();
    assert!(queue.iter().all(|course| course.across.is_some() && !course.hit()));
    let (mean, error) = mean(&queue.iter().filter_map(|course| course.across).collect::<Vec<_>>());
    println!("across before a queue that gives way after {mean:.2} ± {error:.2} s");
    assert!((10.0..12.0).contains(&mean), "{mean}");
    // Who stops behind the first changes nothing at all.
    assert!(one.iter().zip(&queue).all(|(one, queue)| one.across == queue.across));
}

#[test]
fn a_commotions_driver_minds_those_who_matter_and_nobody_else() {
    let scripted = |speed: f64, delay: f64| {
        model("scripted", &Settings::from([("speed", Value::Number(speed)), ("delay", Value::Number(delay))]))
    };
    let drive = |every: usize, others: &[(f64, f64, f64, f64)]| {
        some_runs(400, every, |driver| {
            let person = |(k, &(delay, x, from, to)): (usize, &(f64, f64, f64, f64))| {
                let mut walker = street::walker(&format!("walker{k}"), scripted(1.3, delay), from, to);
                (walker.start.x, walker.goal.x) = (x, x);
                walker
            };
            let mut people = vec![street::walker("walker", scripted(1.3, 0.5), -4.0, 8.0)];
            people.extend(others.iter().enumerate().map(person));
            let mut av = car("av", 0, SPEED, at(6.0 * SPEED));
            av.controller = controller("commotions", &driver);
            let mut world = street(SPEED, vec![av], people);
            world.road.crossing.kind = CrossingKind::Unmarked;
            world.horizon = 30.0;
            world
        })
    };
    let alone = drive(1, &[]);
    let passed = |course: &Course| course.passed.unwrap_or(30.0);
    let (mean, error) = mean(&alone.iter().map(passed).collect::<Vec<_>>());
    println!("alone, passed after {mean:.3} ± {error:.3} s");
    // A pedestrian behind it: not one bit.
    let among = drive(8, &[(0.5, -120.0, -4.0, 8.0)]);
    assert!(alone.iter().step_by(8).zip(&among).all(|(one, other)| same_bits(one, other, "av")));
    for (what, other) in [("far ahead", (0.5, 1200.0, -4.0, 8.0)), ("walking away", (0.0, 0.0, 6.0, 30.0))] {
        let among = drive(1, &[other]);
        assert_no_difference(&format!("{what}: passed"), passed, &alone, &among);
        assert_no_difference(&format!("{what}: contacts"), |c| f64::from(u8::from(c.hit())), &alone, &among);
    }
}

/// Somebody who walks by a script before a COMMOTIONS driver: how fast (m/s), after how long (s) and from where (m).
type Crosser = (f64, f64, f64);

/// When somebody at 1.3 m/s sets off, s; one after the other.
fn one_after_the_other(headway: f64) -> Vec<Crosser> {
    (0..8).map(|k| (1.3, 0.5 + headway * f64::from(k), -4.0)).collect()
}

/// A COMMOTIONS driver so many seconds before people who walk by a script: they neither look nor give way.
fn before_people(driver: &Settings, first: f64, kind: CrossingKind, people: &[Crosser]) -> World {
    let walker = |(k, &(speed, delay, from)): (usize, &Crosser)| {
        let given = [("speed", Value::Number(speed)), ("delay", Value::Number(delay))];
        let mut walker =
            street::walker(&format!("walker{k}"), model("scripted", &Settings::from(given)), from, 8.0);
        // Side by side while they wait.
        let x = 0.85 * (k as f64 - (people.len() - 1) as f64 / 2.0);
        (walker.start.x, walker.goal.x) = (x, x);
        walker
    };
    let mut av = car("av", 0, SPEED, at(first * SPEED));
    av.controller = controller("commotions", driver);
    let mut world = street(SPEED, vec![av], people.iter().enumerate().map(walker).collect());
    world.road.crossing.kind = kind;
    world.horizon = 40.0;
    world
}

#[test]
fn a_commotions_driver_touches_nobody_of_a_stream_of_people_who_have_priority() {
    assert_touch_nobody(&[(4.0, 2.0), (6.0, 3.0)]);
}

#[test]
#[ignore = "it takes as long as many other tests of this program together"]
fn a_commotions_driver_touches_nobody_of_denser_and_later_streams_either() {
    assert_touch_nobody(&[(6.0, 2.0), (8.0, 5.0)]);
}

/// Of streams that a car reaches after so many seconds, of people so many seconds apart.
fn assert_touch_nobody(streams: &[(f64, f64)]) {
    for &(first, headway) in streams {
        let people = one_after_the_other(headway);
        let stream = runs(200, |driver| before_people(&driver, first, CrossingKind::Zebra, &people));
        assert!(stream.iter().all(|course| !course.hit()), "{first} and {headway} s");
    }
}

/// On an unmarked road the model expects people to give way, and these do not: the measure is what it makes of one of them.
/// A driver who has given way to one is late for the next, so that this is one who comes at any time.
#[test]
#[ignore = "it takes longer than any other test of this program"]
fn before_a_commotions_driver_a_stream_of_people_is_no_more_dangerous_than_the_worst_of_them_alone() {
    assert_a_stream_is_no_more_dangerous(4.0);
}

#[test]
#[ignore = "it takes as long as many other tests of this program together"]
fn before_a_commotions_driver_a_stream_that_comes_later_is_no_more_dangerous() {
    assert_a_stream_is_no_more_dangerous(6.0);
}

/// Of people whom a car reaches after so many seconds.
fn assert_a_stream_is_no_more_dangerous(first: f64) {
    let hits = |first: f64, people: &[Crosser]| -> Vec<f64> {
        let courses = runs(200, |driver| before_people(&driver, first, CrossingKind::Unmarked, people));
        courses.iter().map(|course| f64::from(u8::from(course.hit()))).collect()
    };
    let count = |hits: &[f64]| hits.iter().sum::<f64>();
    // The same drivers in both, so that differences are those of pairs.
    let assert_no_more = |what: &str, stream: &[f64], alone: &[f64]| {
        let more: Vec<f64> = stream.iter().zip(alone).map(|(stream, alone)| stream - alone).collect();
        let (more, error) = mean(&more);
        println!("{what}: {} contacts of 200 in a stream, {} alone", count(stream), count(alone));
        assert!(more <= 3.0 * error, "{what}: {more} ± {error}");
    };
    let timings = (0..10).map(|half| hits(first, &[(1.3, first - 4.0 + 0.5 * f64::from(half), -4.0)]));
    let worst = timings.max_by(|one, other| count(one).total_cmp(&count(other))).unwrap();
    assert!(count(&worst) > 100.0, "at the worst moment few brake for somebody who does not");
    for headway in [1.5, 2.0, 3.0, 4.0, 5.0] {
        let stream = hits(first, &one_after_the_other(headway));
        assert_no_more(&format!("{first} s, every {headway} s"), &stream, &worst);
    }
    // At 2 s each steps into the way as the one before leaves it: as one who takes 16 s for it, from the same moment on.
    let slow = 2.6 / 16.0;
    let enters = 0.5 + 2.7 / 1.3;
    let alone = hits(first, &[(slow, 0.0, -1.3 - slow * enters)]);
    let stream = hits(first, &one_after_the_other(2.0));
    assert_no_more(&format!("{first} s, somebody in the way for 16 s"), &stream, &alone);
}

#[test]
fn who_has_crossed_and_is_out_of_sight_holds_nobody_up() {
    let drive = |sees: bool| {
        runs(200, |driver| {
            let script = Settings::from([("speed", Value::Number(1.3)), ("delay", Value::Number(0.5))]);
            let mut av = car("av", 0, SPEED, at(4.0 * SPEED));
            av.controller = controller("commotions", &driver);
            let given = Settings::from([("field_of_view", Value::Number(0.7))]);
            let perceived = ModelSetup::resolved(standard().perception(), &given).expect("good settings");
            av.sees = sees.then_some(perceived);
            let mut world = street(
                SPEED,
                vec![av],
                vec![street::walker("walker", model("scripted", &script), -4.0, 20.0)],
            );
            world.horizon = 60.0;
            world
        })
    };
    let passed = |courses: &[Course]| courses.iter().filter(|course| course.passed.is_some()).count();
    let (all_around, ahead) = (passed(&drive(false)), passed(&drive(true)));
    println!("{all_around} of 200 pass who see all around, {ahead} who see 40 degrees");
    assert!(ahead + 5 >= all_around, "{ahead} instead of {all_around}");
}

/// Counts the allocations after the first step of a run.
#[derive(Default)]
struct Watch {
    steps: usize,
    after_the_first: usize,
    last: usize,
}

impl Observer for Watch {
    fn observe(&mut self, _: &Step) {
        self.steps += 1;
        self.last = allocations();
        if self.steps == 1 {
            self.after_the_first = self.last;
        }
    }
}

#[test]
fn minds_allocate_nothing_after_the_first_step() {
    // Everything that a variant may assume, and the one that is the default.
    for variant in ["oVAoBEvoAIoEAoSNvoPF", "oVAaoVAloBEooBEvoAIoDAoSNvoPF", "oVAoBEooBEvoAIoEAoAN"] {
        let settings = Settings::from([("variant", Value::Word(variant.into()))]);
        for (cars, people, driven) in [(1, 1, false), (10, 1, false), (1, 1, true), (3, 5, true)] {
            let vehicle = |k: i32| {
                let mut vehicle =
                    car(&format!("car{k}"), k as usize % 2, SPEED, at(SPEED * (4.0 + 2.0 * f64::from(k))));
                if driven {
                    vehicle.controller = controller("commotions", &settings);
                }
                vehicle
            };
            let walker = |k: i32| {
                let mut walker =
                    street::walker(&format!("walker{k}"), model("commotions", &settings), -4.0, 8.0);
                (walker.start.x, walker.goal.x) = (f64::from(k), f64::from(k));
                walker.appears = Appearance::At(f64::from(k));
                walker
            };
            let world =
                Arc::new(street(SPEED, (0..cars).map(vehicle).collect(), (0..people).map(walker).collect()));
            let mut watch = Watch::default();
            simulate(&world, road_users(&world, 1).expect("road users"), &mut watch)
                .expect("they can decide");
            assert!(watch.steps > 100);
            assert_eq!(
                watch.last, watch.after_the_first,
                "{variant}: {cars} vehicles, {people} people, driven: {driven}"
            );
        }
    }
}
