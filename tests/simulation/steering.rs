//! Vehicles that are steered: what does not matter changes nothing, what is measured is measured where they really are, and parked cars are
//! solid.

use std::sync::{Arc, Mutex};

use files::Memory;
use models::standard;
use results::Requests;
use runner::plan::plan;
use runner::run::{FreeFlows, Unwatched, road_users, run_case};
use scenario::registry::Registry;
use scenario::{Case, Chance, CommandKind, ControllerModel, Declaration, World};
use sim::geometry::{Footprint, distance};
use sim::{
    Command, Controller, ControllerError, Observation, Observer, PedestrianState, Schedule, Step, StopReason,
    VehicleState, simulate,
};

/// An acceleration (m/s²) and a curvature (1/m) for what is seen.
type Decides = fn(&Observation) -> (f64, Option<f64>);

struct Steers {
    decides: Decides,
    curvature: Option<f64>,
    seen: Arc<Mutex<Vec<Observation>>>,
}

impl Controller for Steers {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.05)
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        let (acceleration, curvature) = (self.decides)(seen);
        self.curvature = curvature;
        self.seen.lock().unwrap().push(seen.clone());
        Ok(Command::Acceleration(acceleration))
    }

    fn curvature(&self) -> Option<f64> {
        self.curvature
    }
}

/// What ships, and `steers`, which may where `may` says so; with what it was shown.
fn registry(decides: Decides, may: bool) -> (Registry, Arc<Mutex<Vec<Observation>>>) {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let shown = seen.clone();
    let steers = ControllerModel::new(
        Declaration::new("steers", "Steers.").source("test"),
        CommandKind::Acceleration,
        move |_| Ok(Box::new(Steers { decides, curvature: None, seen: shown.clone() })),
    );
    let steers = if may { steers.steering() } else { steers };
    (standard().with_controller(steers.chance(Chance::Never)).unwrap(), seen)
}

fn case(text: &str, registry: &Registry) -> Case {
    let files = Memory::default().with("a.scn", text);
    let loaded = lang::load("a.scn".as_ref(), registry, &files);
    let suite = loaded.unwrap_or_else(|failure| panic!("{text}\n{:?}", failure.diagnostics)).suite;
    let plan = plan(&suite).unwrap_or_else(|errors| panic!("{text}\n{}", errors[0]));
    plan.trial(0).cases.first()
}

struct Measured {
    values: Vec<(String, Option<f64>)>,
    reason: StopReason,
    time: f64,
}

impl Measured {
    fn of(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(known, _)| known == name).expect("it is a metric").1
    }
}

fn measured(text: &str, decides: Decides) -> Measured {
    let (registry, _) = registry(decides, true);
    let (case, requests) = (case(text, &registry), Requests::defaults(&registry));
    let outcome = run_case(&case, &requests, &FreeFlows::default(), &mut Unwatched)
        .unwrap_or_else(|error| panic!("{text}\n{error}"));
    let names = requests.iter().map(|request| request.metric.name().to_string());
    let values = names.zip(outcome.metrics.iter().copied()).collect();
    Measured { values, reason: outcome.ending.reason, time: outcome.ending.time }
}

/// Everybody after every step, with the time.
#[derive(Default)]
struct States(Vec<(f64, VehicleState, PedestrianState)>);

impl Observer for States {
    fn observe(&mut self, step: &Step) {
        let at = |state: &sim::Snapshot| (state.vehicles[0].clone(), state.pedestrians[0]);
        let (before, after) = (at(step.before), at(step.after));
        if self.0.is_empty() {
            self.0.push((step.time, before.0, before.1));
        }
        self.0.push((step.time + step.duration, after.0, after.1));
    }
}

fn states(text: &str, decides: Decides) -> (World, States, Vec<Observation>) {
    let (registry, seen) = registry(decides, true);
    let case = case(text, &registry);
    let users = road_users(&case.world, case.seed).unwrap();
    let mut states = States::default();
    simulate(&case.world, users, &mut states).unwrap();
    let seen = seen.lock().unwrap().clone();
    ((*case.world).clone(), states, seen)
}

fn street(road: &str, car: &str, person: &str) -> String {
    format!(
        "scenario a {{
  road {{ {road}; lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h }}
  vehicle av {{ controller steers; {car} }}
  pedestrian walker {{ {person} }}
  horizon 20 s
}}"
    )
}

const ROADS: [&str; 3] = [
    "crossing zebra { width: 4 m }",
    "path { straight 500 m }; crossing zebra { width: 4 m, at: 250.5 m }",
    "path { arc 37 deg radius 60 m left; straight 700 m }; crossing zebra { width: 4 m, at: 400 m }",
];

const PEOPLE: [&str; 4] = [
    "model scripted { speed: 1.577 m/s }; start 2.113 m from kerb; appears when time_to_arrival(av.front) = 3.0137 s",
    "model scripted { speed: 1.577 m/s }; start 2.113 m from kerb; appears when time_to_arrival(av.front) = 3.8137 s",
    "model scripted { speed: 1.577 m/s }; start 4.113 m from lane centre; from far side; along 1.17 m; appears when time_to_arrival(av) = 2.0137 s",
    "model scripted { speed: 1.577 m/s }; start 5.113 m from lane centre; turned 21.3 deg left; appears when time_to_arrival(av.front) = 2.0137 s",
];

#[test]
fn who_steers_straight_on_is_measured_as_who_does_not_steer() {
    let mut compared = 0;
    for road in ROADS {
        for lane in [0, 1] {
            for person in PEOPLE {
                let text = street(
                    road,
                    &format!("lane {lane}; speed 31.7 km/h; start 51.13 m before crossing"),
                    person,
                );
                let not = measured(&text, |_| (-0.7, None));
                let steered = measured(&text, |_| (-0.7, Some(0.0)));
                assert_eq!(steered.reason, not.reason, "{text}");
                assert!((steered.time - not.time).abs() < 1e-6, "{text}");
                for ((name, found), (_, expected)) in steered.values.iter().zip(&not.values) {
                    match (found, expected) {
                        (Some(found), Some(expected)) => {
                            let apart = (found - expected).abs();
                            assert!(
                                apart <= 1e-6 * (1.0 + expected.abs()),
                                "{name}: {found}, not {expected}\n{text}"
                            );
                            compared += 1;
                        }
                        (found, expected) => assert_eq!(found, expected, "{name}\n{text}"),
                    }
                }
            }
        }
    }
    assert!(compared > 300, "{compared} values were compared");
}

/// Out of the lane to the left, and back.
fn swerves(seen: &Observation) -> (f64, Option<f64>) {
    let curvature = match seen.ego.travelled {
        place if place < -30.0 => return (0.0, None),
        place if place < -22.0 => 0.02,
        place if place < -8.0 => -0.02,
        place if place < 0.0 => 0.02,
        place if place < 8.0 => -0.01,
        _ => 0.0,
    };
    (-0.5, Some(curvature))
}

/// Somebody at a time, evenly between two states.
fn at(states: &[(f64, VehicleState, PedestrianState)], time: f64) -> (VehicleState, PedestrianState) {
    let next = states.partition_point(|state| state.0 < time).clamp(1, states.len() - 1);
    let ((from, car, person), (to, later, walked)) = (&states[next - 1], &states[next]);
    let part = ((time - from) / (to - from)).clamp(0.0, 1.0);
    let position = person.position.lerp(&walked.position, part);
    (car.between(later, part), PedestrianState { position, ..*walked })
}

#[test]
fn who_swerves_is_measured_where_it_is() {
    let (mut passed, mut shared, mut hit) = (0, 0, 0);
    for road in &ROADS[..2] {
        for (lane, speed) in [(0, 30), (0, 45), (1, 36)] {
            for person in PEOPLE {
                let car = format!("lane {lane}; speed {speed} km/h; start 51.13 m before crossing");
                let text = street(road, &car, person);
                let (found, (_, States(states), _)) = (measured(&text, swerves), states(&text, swerves));
                let there: Vec<_> = states.iter().filter(|state| state.2.present).cloned().collect();
                let (begin, end) = (there[0].0, there.last().unwrap().0);
                let looks: Vec<f64> = (0..)
                    .map(|look| begin + 0.002 * f64::from(look))
                    .take_while(|time| *time < end)
                    .collect();
                let apart = looks.iter().map(|time| {
                    let (car, person) = at(&states, *time);
                    distance(&car, &person)
                });
                let apart = apart.fold(f64::INFINITY, f64::min);
                let least = found.of("min_distance").unwrap();
                assert!((apart - least).abs() < 0.02, "{least} m, not {apart} m\n{text}");
                let lateral = states.iter().filter_map(|(_, car, _)| {
                    Some(car.steered?.curvature.abs() * car.motion.speed * car.motion.speed)
                });
                let lateral = lateral.fold(0.0, f64::max);
                assert!((found.of("lateral_acceleration").unwrap() / lateral - 1.0).abs() < 0.02, "{text}");
                assert!(lateral > 0.6, "{lateral} m/s²");
                if found.of("collision") == Some(1.0) {
                    hit += 1;
                    assert!(apart < 0.02);
                    continue;
                }
                // Where the two ways cross, and when each was there.
                let mut between = f64::INFINITY;
                for one in states.windows(2) {
                    let (from, way) = (one[0].1.position(), one[1].1.position() - one[0].1.position());
                    for other in there.windows(2) {
                        let (start, walk) = (other[0].2.position, other[1].2.position - other[0].2.position);
                        let across = way.perp(&walk);
                        let (share, walked) =
                            ((start - from).perp(&walk) / across, (start - from).perp(&way) / across);
                        if across != 0.0 && (0.0..1.0).contains(&share) && (0.0..1.0).contains(&walked) {
                            let when = |steps: &[(f64, VehicleState, PedestrianState)], part: f64| {
                                steps[0].0 + part * (steps[1].0 - steps[0].0)
                            };
                            between = between.min((when(one, share) - when(other, walked)).abs());
                        }
                    }
                }
                match found.of("pet") {
                    Some(pet) => {
                        assert!((pet - between).abs() < 1e-3, "pet {pet} s, not {between} s\n{text}");
                        passed += 1;
                    }
                    None => assert_eq!(between, f64::INFINITY, "{text}"),
                }
                // Every two moments at which both are over one place.
                let (mut cars, mut people) = (Vec::new(), Vec::new());
                for time in looks.iter().step_by(5) {
                    people.push((*time, Footprint::from(&at(&states, *time).1)));
                }
                for look in 0..((states.last().unwrap().0 / 0.01) as usize) {
                    let time = look as f64 * 0.01;
                    cars.push((time, Footprint::from(&at(&states, time).0)));
                }
                let still = nalgebra::Vector2::zeros();
                let touch = |one: &Footprint, other: &Footprint| {
                    (one.centre - other.centre).norm() < 4.0 && one.first_contact(other, still).is_some()
                };
                let of = |person: &Footprint| {
                    cars.iter()
                        .filter(|(_, car)| touch(car, person))
                        .map(|(time, _)| *time)
                        .collect::<Vec<f64>>()
                };
                let visited: Vec<(f64, Vec<f64>)> = people
                    .iter()
                    .map(|(time, person)| (*time, of(person)))
                    .filter(|(_, cars)| !cars.is_empty())
                    .collect();
                let (Some(first), Some(last)) = (visited.first(), visited.last()) else { continue };
                if found.of("pet_area").is_none() || last.0 > end - 0.05 {
                    continue;
                }
                let times: Vec<f64> = visited.iter().flat_map(|(_, cars)| cars.iter().copied()).collect();
                let (enters, leaves) = times
                    .iter()
                    .fold((f64::INFINITY, 0.0_f64), |all, time| (all.0.min(*time), all.1.max(*time)));
                let area = (enters - last.0).max(first.0 - leaves).max(0.0);
                let value = found.of("pet_area").unwrap();
                assert!((value - area).abs() < 0.03, "pet_area {value} s, not {area} s\n{text}");
                shared += 1;
            }
        }
    }
    assert!(passed >= 12 && shared >= 10 && hit >= 1, "{passed}, {shared}, {hit}");
}

#[test]
fn a_controller_sees_how_far_beside_its_lane_it_is() {
    let text = street(ROADS[0], "lane 1; speed 36 km/h; start 51.13 m before crossing", PEOPLE[1]);
    let (_, States(states), seen) = states(&text, swerves);
    let mut beside = 0;
    for seen in seen.iter().filter(|seen| seen.time >= 0.0 && seen.time < states.last().unwrap().0) {
        let (car, person) = at(&states, seen.time);
        let place = car.path.from_world(car.position());
        assert!(
            (seen.ego.lateral_offset - place.y).abs() < 1e-9 && (seen.ego.travelled - place.x).abs() < 1e-9
        );
        let along = car.path.turned(0.0, car.heading());
        assert!((seen.ego.heading_error - libm::atan2(along.y, along.x)).abs() < 1e-3);
        beside += usize::from(seen.ego.lateral_offset > 1.0);
        // Others are seen from the lane, as ever.
        if let Some(other) = seen.pedestrians.first() {
            let there = car.path.from_world(person.position);
            assert!((other.position.y - there.y).abs() < 1e-9);
            assert!((other.position.x - (there.x - seen.ego.travelled)).abs() < 1e-9);
        }
    }
    assert!(beside > 5, "{beside}");
}

#[test]
fn a_parked_car_is_hit_by_who_swerves_into_it() {
    let road = "crossing zebra { width: 4 m }; parked_row cars { to: -6 m, cars: 4, gap: 1 m, across: -2.75 m, length: 4.5 m, width: 1.8 m }";
    let text = street(road, "speed 36 km/h; start 51.13 m before crossing", PEOPLE[1])
        .replace("lanes forward, backward", "lanes forward");
    let past = measured(&text, |_| (0.0, None));
    assert_eq!((past.of("collision"), past.reason), (Some(0.0), StopReason::Completed));
    let into = measured(&text, |seen| (0.0, Some(if seen.ego.travelled < -28.0 { 0.0 } else { -0.02 })));
    assert_eq!(into.of("collision"), Some(1.0));
    assert!(into.of("impact_speed").unwrap() > 9.0);
}

#[test]
fn who_is_declared_not_to_steer_does_not() {
    let (registry, _) = registry(|_| (0.0, Some(0.01)), false);
    let text = street(ROADS[0], "speed 36 km/h", PEOPLE[0]);
    let (case, requests) = (case(&text, &registry), Requests::defaults(&registry));
    let error = run_case(&case, &requests, &FreeFlows::default(), &mut Unwatched).unwrap_err().to_string();
    assert!(error.contains("declared not to steer"), "{error}");
}

/// A child that runs out before a car at a speed (km/h), at a time to arrival (s): what became of it, and the fingerprint of the run.
fn child(controller: &str, (pace, late): (f64, f64), more: &str) -> (Vec<(String, Option<f64>)>, u64) {
    let text = format!(
        "scenario a {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked
    parked_row before {{ to: -1 m, cars: 3, gap: 1 m, across: -2.8 m, length: 4.4 m, width: 1.8 m }} {} }}
  vehicle av {{ controller {controller}; speed {pace} km/h; start 60 m before crossing }}
  {}
  pedestrian child {{ model scripted {{ speed: 1.4 m/s }}; size 0.5 m x 0.4 m; start 3.2 m from lane centre
    appears when time_to_arrival(av.front) = {late} s }}
  end on collision
  horizon 30 s
}}",
        if more.starts_with('f') { format!("; {more}") } else { String::new() },
        if more.starts_with("vehicle") { more } else { "" },
    );
    let case = case(&text, &standard());
    let requests = Requests::defaults(&standard());
    let outcome = run_case(&case, &requests, &FreeFlows::default(), &mut Unwatched).unwrap();
    let names = requests.iter().map(|request| request.metric.name().to_string());
    (names.zip(outcome.metrics.iter().copied()).collect(), outcome.fingerprint)
}

fn value(found: &[(String, Option<f64>)], name: &str) -> Option<f64> {
    found.iter().find(|(known, _)| known == name).expect("it is a metric").1
}

const ONCOMING: &str =
    "vehicle oncoming { controller constant_speed; lane 1; speed 40 km/h; start 70 m before crossing }";

#[test]
fn a_car_that_steers_in_an_emergency_evades_whom_braking_alone_hits() {
    let (mut evaded, mut alike, mut hit, mut stays) = (0, 0, 0, 0);
    for pace in [30.0, 40.0, 50.0] {
        for late in (8..24).map(|tenth| f64::from(tenth) * 0.1) {
            let when = (pace, late);
            let ((brakes, print), (steers, other)) = (child("idm_aeb", when, ""), child("idm_aes", when, ""));
            let collides = |found: &[(String, Option<f64>)]| value(found, "collision") == Some(1.0);
            assert_eq!(value(&steers, "kerb_contact"), Some(0.0), "{when:?}");
            if value(&steers, "lateral_acceleration") == Some(0.0) {
                // Who has not steered is the car that only brakes.
                assert_eq!((print, &brakes), (other, &steers), "{when:?}");
                alike += 1;
            } else {
                assert!(!collides(&steers), "{when:?}: it begins no swerve that it cannot carry through");
                evaded += usize::from(collides(&brakes));
            }
            // With somebody coming on the other lane it stays on its own, and where that is in the way of nobody it is as before.
            let (beside, _) = child("idm_aes", when, ONCOMING);
            assert_eq!(value(&beside, "kerb_contact"), Some(0.0));
            hit += usize::from(collides(&beside));
            let (lane, _) = child("idm_aes { room: lane }", when, "");
            let steers = |found: &[(String, Option<f64>)]| value(found, "lateral_acceleration") > Some(0.0);
            assert_eq!(value(&lane, "kerb_contact"), Some(0.0));
            stays += usize::from(collides(&lane) && !steers(&lane));
        }
    }
    println!("{evaded}, {alike}, {hit}, {stays}");
    assert!(evaded >= 4 && alike >= 10 && hit >= 1 && stays >= 1, "{evaded}, {alike}, {hit}, {stays}");
}

#[test]
fn a_wet_road_holds_less_than_the_controller_takes_it_for() {
    let most =
        |friction: &str, when| value(&child("idm_aes", when, friction).0, "lateral_acceleration").unwrap();
    let (mut less, mut swerves) = (0, 0);
    for late in (8..24).map(|tenth| f64::from(tenth) * 0.1) {
        let (dry, wet) = (most("", (50.0, late)), most("friction 0.4", (50.0, late)));
        assert!(wet <= 0.4 * 9.80665 + 1e-9, "{wet} m/s²");
        swerves += usize::from(dry > 0.0);
        less += usize::from(wet < dry - 0.3);
    }
    assert!(swerves >= 3 && less >= 3, "{swerves}, {less}");
}

#[test]
fn a_kerb_that_is_hit_is_no_collision() {
    let text = street(ROADS[0], "speed 36 km/h; start 51.13 m before crossing", PEOPLE[1]);
    let at = |decides: Decides| measured(&text, decides);
    let not = at(|_| (0.0, None));
    assert_eq!((not.of("kerb_contact"), not.of("collision")), (Some(0.0), Some(0.0)));
    // To the right it is 0.85 m from the side of the car, to the left 4.35 m.
    let right = at(|seen| (0.0, Some(if seen.ego.travelled < -40.0 { -0.01 } else { 0.0 })));
    assert_eq!((right.of("kerb_contact"), right.of("collision")), (Some(1.0), Some(0.0)));
    assert_eq!((right.reason, not.reason), (StopReason::Completed, StopReason::Completed));
    let back = at(|seen| match seen.ego.travelled {
        place if place < -45.0 => (0.0, Some(0.01)),
        place if place < -38.9 => (0.0, Some(-0.01)),
        _ => (0.0, Some(0.0)),
    });
    assert_eq!(back.of("kerb_contact"), Some(0.0));
    // A median is an edge, too, of the carriageway that it bounds.
    let median = street(
        "crossing zebra { width: 4 m }; median 2 m after lane 0",
        "speed 36 km/h; start 51.13 m before crossing",
        PEOPLE[1],
    );
    let over = measured(&median, |seen| (0.0, Some(if seen.ego.travelled < -30.0 { 0.01 } else { 0.0 })));
    assert_eq!(over.of("kerb_contact"), Some(1.0));
    let without = at(|seen| {
        (
            0.0,
            Some(if seen.ego.travelled < -46.0 {
                0.01
            } else if seen.ego.travelled < -41.0 {
                -0.01
            } else {
                0.0
            }),
        )
    });
    assert_eq!(without.of("kerb_contact"), Some(0.0));
}

#[test]
fn wheels_of_a_long_car_come_to_the_outer_kerb_of_a_tight_turn() {
    // They are 1.65 m before and behind the centre and 1.05 m beside it: 1.184 m outside an arc of 9 m.
    for (width, side, touches) in
        [(2.36, "left", 1.0), (2.36, "right", 1.0), (2.38, "left", 0.0), (2.38, "right", 0.0)]
    {
        let road = format!(
            "path {{ straight 60 m; arc 90 deg radius 9 m {side}; straight 60 m }}; crossing zebra {{ width: 4 m, at: 90 m }}"
        );
        let text = street(&road, "speed 15 km/h; size 5.5 m x 2.1 m; start 60 m before crossing", PEOPLE[0])
            .replace(
                "lanes forward, backward; lane_width 3.5 m",
                &format!("lanes forward; lane_width {width} m"),
            );
        assert_eq!(measured(&text, |_| (0.0, None)).of("kerb_contact"), Some(touches), "{text}");
    }
}
