//! Medians, refuges and several crossings, from their text to what happens: who waits on a refuge walks leg by leg and minds on each only
//! whom it meets there, a crossing is the same wherever along the road it lies, and one that is left behind changes nothing.

use nalgebra::Vector2;
use proptest::prelude::*;
use runner::run::road_users;
use sim::{Observer, Snapshot, Step, simulate};

use crate::support::text::{case, measured, of, planned};

/// Two lanes with so much of a road between them, and who is on it.
fn street(median: &str, users: &str) -> String {
    format!(
        "scenario a {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra; {median} }}
  horizon 40 s; finish 60 m
  {users}
}}"
    )
}

const REFUGE: &str = "median 2 m after lane 0 with refuge";

/// Where the pedestrian and the vehicles are, at the beginning and after each step.
#[derive(Default)]
struct Places {
    walker: Vec<Vector2<f64>>,
    cars: Vec<Vec<f64>>,
    modes: Vec<String>,
}

impl Observer for Places {
    fn begin(&mut self, start: &Snapshot) {
        self.walker.push(start.pedestrians[0].position);
        self.cars.push(start.vehicles.iter().map(|car| car.motion.travelled).collect());
    }

    fn observe(&mut self, step: &Step) {
        self.walker.push(step.after.pedestrians[0].position);
        self.cars.push(step.after.vehicles.iter().map(|car| car.motion.travelled).collect());
        self.modes.push(step.pedestrian_modes[0].as_str().to_string());
    }
}

fn places(text: &str) -> Places {
    let case = case(text);
    let (world, mut places) = (case.world.clone(), Places::default());
    simulate(&world, road_users(&world, case.seed).unwrap(), &mut places).unwrap();
    places
}

const CAR: &str = "vehicle av { controller constant_speed; speed 10 m/s; start 300 m before crossing }";

#[test]
fn lanes_and_kerbs_lie_beyond_a_median() {
    let walker = "pedestrian walker { model scripted; start 2 m from kerb }";
    let road = case(&street(REFUGE, &format!("{CAR}\n{walker}"))).world.road.clone();
    assert_eq!(road.path(1).point(0.0).y, 5.5);
    assert_eq!((road.kerb(scenario::Side::Near), road.kerb(scenario::Side::Far)), (-1.75, 7.25));
    assert_eq!(road.edges_of(&road.medians[0]), (1.75, 3.75));
    assert_eq!(road.path(0).kerbs(&road), (-1.75, 1.75));
    assert_eq!(road.path(1).kerbs(&road), (-1.75, 1.75));
    assert_eq!(road.path(0).waiting_places(&road), (-1.75, 1.75));
    let grass = case(&street("median 2 m after lane 0", &format!("{CAR}\n{walker}"))).world.road.clone();
    assert_eq!(grass.path(0).kerbs(&grass), (-1.75, 1.75));
    assert_eq!(grass.path(0).waiting_places(&grass), (-1.75, 7.25));
    assert_eq!(grass.path(1).waiting_places(&grass), (-1.75, 7.25));
    // Who starts from the far side starts from the far lane, and their goal is beyond the near kerb.
    let far =
        "pedestrian walker { model scripted; from far side; start 2 m from kerb; goal 3 m beyond kerb }";
    let setup = case(&street(REFUGE, &format!("{CAR}\n{far}"))).world.pedestrians[0].clone();
    assert_eq!((setup.start.y, setup.goal.y), (9.25, -4.75));
    assert!(setup.stops.is_empty());
}

#[test]
fn who_waits_on_a_refuge_stands_in_its_middle_for_as_long() {
    for (side, middle, way) in [("", 2.75, 6.5), ("from far side;", 2.75, 6.5)] {
        let walker = format!(
            "pedestrian walker {{ model scripted {{ speed: 1 m/s, wait_on_refuge: 2 s }}; {side} start 2 m from kerb; waits on refuge }}"
        );
        let found = places(&street(REFUGE, &format!("{CAR}\n{walker}")));
        let stands: Vec<usize> =
            (1..found.walker.len()).filter(|step| (found.walker[*step].y - middle).abs() < 1e-12).collect();
        // From the step in which it comes there to the one in which it sets off again.
        let (first, last) = (stands[0] as f64 * 0.025, *stands.last().unwrap() as f64 * 0.025);
        assert!((first - way).abs() < 0.026 && (last - first - 2.0).abs() < 0.026, "{first} s to {last} s");
        assert_eq!(stands.len(), stands[stands.len() - 1] - stands[0] + 1, "it stands once");
        assert!(found.modes.iter().any(|mode| mode == "on_refuge"), "{:?}", found.modes);
        // It gets to its goal all the same.
        assert!((found.walker.last().unwrap().y - if side.is_empty() { 9.25 } else { -3.75 }).abs() < 1e-9);
    }
}

#[test]
fn two_refuges_are_two_stops() {
    let road = "lanes 3; lane_width 3 m; speed_limit 50 km/h; crossing zebra
    median 2 m after lane 1 with refuge; median 1 m after lane 0 with refuge";
    let text = format!(
        "scenario a {{ road {{ {road} }}\n horizon 60 s; finish 10 m\n {CAR}\n pedestrian walker {{ model scripted {{ wait_on_refuge: 1 s }}
    start 1 m from kerb; waits on refuge }} }}"
    );
    let stops: Vec<f64> = case(&text).world.pedestrians[0].stops.iter().map(|stop| stop.y).collect();
    assert_eq!(stops, [2.0, 6.5]);
    let found = places(&text);
    for stop in stops {
        let stands = found.walker.iter().filter(|place| (place.y - stop).abs() < 1e-9).count();
        assert!((39..=42).contains(&stands), "{stands} steps at {stop} m");
    }
}

/// A person of each model that walks leg by leg; those that draw are made not to.
const WALKERS: [&str; 4] = [
    "scripted { speed: 1.3 m/s, wait_on_refuge: 1 s }",
    "commotions { variant: \"oVA\" }",
    "jaywalker",
    "social_force { desired_speed: 1.3 m/s }",
];

fn walker(model: &str, rest: &str) -> String {
    format!("pedestrian walker {{ model {model}; start 2 m from kerb; appears at 1 s; {rest} }}")
}

#[test]
fn on_a_leg_only_those_matter_whom_it_meets_there() {
    for model in &WALKERS[..3] {
        let walker = walker(model, "waits on refuge");
        let car = |name: &str, lane: usize, start: f64| {
            format!(
                "vehicle {name} {{ controller constant_speed; speed 9 m/s; lane {lane}; start {start} m before crossing }}"
            )
        };
        let near = car("near", 0, 35.0);
        let alone = places(&street(REFUGE, &format!("{near}\n{walker}")));
        let both = places(&street(REFUGE, &format!("{near}\n{}\n{walker}", car("far", 1, 85.0))));
        let on_refuge = |places: &Places| {
            places
                .walker
                .iter()
                .position(|place| (place.y - 2.75).abs() < 1e-9)
                .expect("it comes to the refuge")
        };
        assert_eq!(on_refuge(&alone), on_refuge(&both), "{model}");
        for step in 0..=on_refuge(&alone) {
            assert_eq!(alone.walker[step], both.walker[step], "{model} at step {step}");
        }
        // Without the refuge the car on the far lane matters to who weighs it.
        let one_go = self::walker(model, "").replace(", wait_on_refuge: 1 s", "");
        let alone = places(&street(REFUGE, &format!("{near}\n{one_go}")));
        let both = places(&street(REFUGE, &format!("{near}\n{}\n{one_go}", car("far", 1, 85.0))));
        let differ = alone.walker.iter().zip(&both.walker).any(|(one, other)| one != other);
        assert_eq!(differ, !model.starts_with("scripted"), "{model}");
    }
}

/// What goes on from the refuge on is a fresh encounter, standing: with a car that comes then as with one that comes to somebody who
/// starts there.
#[test]
fn a_leg_is_a_fresh_encounter() {
    let model = WALKERS[1];
    let far = |start: f64| {
        format!(
            "vehicle av {{ controller constant_speed; speed 8 m/s; lane 1; start {start} m before crossing }}"
        )
    };
    for start in [60.0, 75.0, 85.0, 95.0, 120.0] {
        let legs = places(&street(REFUGE, &format!("{}\n{}", far(start), walker(model, "waits on refuge"))));
        let from = legs.walker.iter().position(|place| (place.y - 2.75).abs() < 1e-9).unwrap();
        let left = start - 8.0 * 0.025 * from as f64;
        let fresh = format!(
            "pedestrian walker {{ model {model}; start 2.75 m from lane centre, -4.5 m from kerb; appears at 0 s }}"
        );
        let fresh = fresh.replace("2.75 m from lane centre, -4.5 m from kerb", "-2.75 m from lane centre");
        let fresh = places(&street(REFUGE, &format!("{}\n{fresh}", far(left))));
        assert_eq!(fresh.walker[0].y, 2.75);
        for (after, (one, other)) in legs.walker[from..].iter().zip(&fresh.walker).enumerate() {
            assert!((one - other).norm() < 1e-6, "{start} m: {one} and {other} m, {after} steps on");
        }
        assert!(fresh.walker.last().unwrap().y > 6.0);
    }
}

#[test]
fn who_obeys_a_signal_waits_for_green_on_the_refuge_too() {
    // A `jaywalker` lets a car pass that is 3 km away.
    for model in WALKERS.iter().filter(|model| **model != "jaywalker") {
        let street = |conduct: &str| {
            format!(
                "scenario a {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; {REFUGE}
    crossing signalised {{ cycle: 60 s, pedestrian_green: 4 s, pedestrian_green_from: 1 s }} }}
  horizon 200 s; finish 60 m
  vehicle av {{ controller constant_speed; speed 10 m/s; start 3 km before crossing }}
  {}
}}",
                walker(model, &format!("waits on refuge; {conduct} signals"))
            )
        };
        // When they leave the refuge, s.
        let sets_off = |conduct: &str| {
            let found = places(&street(conduct));
            let last = found.walker.iter().rposition(|place| (place.y - 2.75).abs() < 1e-9);
            last.unwrap_or_else(|| panic!("{model} comes to the refuge")) as f64 * 0.025
        };
        // Whichever green they set off in, it ends on the first leg.
        let (obeys, ignores) = (sets_off("obeys"), sets_off("ignores"));
        assert!(obeys > 60.0 && (0.97..5.0).contains(&(obeys % 60.0)), "{model} sets off after {obeys} s");
        assert!((5.0..30.0).contains(&ignores), "{model} sets off after {ignores} s");
    }
}

#[test]
fn a_crossing_is_the_same_wherever_it_lies() {
    let crossing_at = |at: f64, controller: &str, kind: &str, walker: &str| {
        let (other, uses, start) = match at {
            0.0 => (String::new(), "", 91.37),
            _ => (format!("crossing other {kind} {{ width: 3 m, at: {at} m }}"), "crosses other", 91.37 - at),
        };
        let first =
            if at == 0.0 { format!("crossing {kind} {{ width: 3 m }}") } else { "crossing zebra".into() };
        format!(
            "scenario a {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; {first}; {other} }}
  horizon 40 s; finish {} m
  vehicle av {{ controller {controller}; speed 30 km/h; start {start} m before crossing }}
  pedestrian walker {{ model {walker}; start 2 m from kerb; {uses}; appears when time_to_arrival(av) = 4.99 s }}
}}",
            30.0 + at
        )
    };
    // Not `commotions`: of actions that are worth the same to the driver rounding chooses now and then (in 1 of 16 runs).
    for controller in ["yielding", "careful_human", "idm_aeb", "carla_behavior", "constant_speed"] {
        for (kind, person) in [("zebra", "scripted"), ("unmarked", "commotions { variant: \"oVA\" }")] {
            let here = measured(&crossing_at(0.0, controller, kind, person)).values;
            // Behind one at which nobody is, 40 m before it.
            let there = measured(&crossing_at(40.0, controller, kind, person)).values;
            for ((name, one), (_, other)) in here.iter().zip(&there) {
                let same = match (one, other) {
                    (Some(one), Some(other)) => (one - other).abs() <= 1e-6 * one.abs().max(1.0),
                    (one, other) => one == other,
                };
                assert!(same, "{controller}, {kind}: {name} is {one:?} here and {other:?} there");
            }
        }
    }
}

#[test]
fn yielding_looks_at_every_crossing_ahead() {
    // The second crossing is too near behind the first to be noticed only from there.
    let text = |controller: &str| {
        format!(
            "scenario a {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra; crossing next zebra {{ at: 8 m }} }}
  horizon 40 s; finish 60 m
  vehicle av {{ controller {controller}; speed 40 km/h; start 90 m before crossing }}
  pedestrian walker {{ model scripted {{ speed: 0.9 m/s }}; start 1 m from kerb; crosses next; appears when time_to_arrival(av) = 4 s }}
}}"
        )
    };
    assert_eq!(of(&text("constant_speed"), "collision"), Some(1.0));
    assert_eq!(of(&text("yielding"), "collision"), Some(0.0));
    assert!(of(&text("yielding"), "max_deceleration").unwrap() < 3.0);
}

#[test]
fn what_cannot_be_is_refused_with_its_place() {
    let other = |at: &str| {
        planned(&format!(
            "scenario a {{ vary at in [{at}]
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra; crossing next zebra {{ at: at }} }}
  {CAR}\n pedestrian walker {{ model scripted; start 2 m from kerb; crosses next }} }}"
        ))
    };
    assert!(other("20 m").is_ok() && other("-20 m").is_ok());
    let error = other("3 m").unwrap_err();
    assert!(error.contains("crossing `next` lies on the first crossing"), "{error}");
    let error = other("150 m").unwrap_err();
    assert!(error.contains("behind the finish line of vehicle `av`"), "{error}");
    let error = other("2 km").unwrap_err();
    assert!(error.contains("the place of crossing `next`"), "{error}");
    // A refuge that is not on the way.
    let text = street(
        REFUGE,
        &format!(
            "{CAR}\npedestrian walker {{ model scripted {{ wait_on_refuge: 1 s }}; start -1 m from kerb; from far side; goal -6 m beyond kerb; waits on refuge }}"
        ),
    );
    let error = planned(&text).unwrap_err();
    assert!(error.contains("there is none on its way"), "{error}");
    let text = street(
        REFUGE,
        &format!("{CAR}\npedestrian walker {{ model scripted; start 2 m from kerb; waits on refuge }}"),
    );
    let suite = case(&text);
    let error = road_users(&suite.world, 1).err().expect("it says no wait").to_string();
    assert!(error.contains("nothing says how long"), "{error}");
}

#[test]
fn a_line_is_a_straight_road_with_its_medians_and_crossings() {
    let users = "vehicle av { controller yielding; speed 30 km/h; lane 1; start 80 m before crossing }
  pedestrian walker { model scripted { wait_on_refuge: 1 s }; start 2 m from kerb; crosses next; waits on refuge; appears at 1.013 s }";
    let text = |road: &str| {
        format!(
            "scenario a {{ road {{ {road}; lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; {REFUGE} }}\n horizon 60 s\n {users} }}"
        )
    };
    let straight = text("crossing zebra; crossing next zebra { at: -31 m }");
    let line =
        text("path { straight 200 m }; crossing zebra { at: 120 m }; crossing next zebra { at: 89 m }");
    let stop = |text: &str| case(text).world.pedestrians[0].stops[0];
    assert_eq!((stop(&straight).x, stop(&straight).y), (-31.0, 2.75));
    // On the line it begins 120 m before the first crossing.
    assert!((stop(&line).x - 89.0).abs() < 1e-9 && (stop(&line).y - 2.75).abs() < 1e-9);
    for ((name, one), (_, other)) in measured(&straight).values.iter().zip(&measured(&line).values) {
        let same = match (one, other) {
            (Some(one), Some(other)) => (one - other).abs() <= 1e-6 * one.abs().max(1.0),
            (one, other) => one == other,
        };
        assert!(same, "{name} is {one:?} on a straight road and {other:?} on a line");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// A crossing that every vehicle has left behind, and the order in which others are named, change no bit.
    #[test]
    fn a_crossing_left_behind_changes_nothing(
        controller in prop::sample::select(vec!["yielding", "careful_human", "idm_aeb", "carla_behavior"]),
        back in 120.0..300.0_f64,
        on in 40.0..90.0_f64,
        arrival in 3.0..7.0_f64,
    ) {
        let text = |others: &[String]| {
            format!(
                "scenario a {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra; {} }}
  horizon 30 s; finish 40 m
  vehicle av {{ controller {controller}; speed 30 km/h; start 90 m before crossing }}
  pedestrian walker {{ model carla_walker; start 2 m from kerb; appears when time_to_arrival(av) = {arrival} s }}
}}",
                others.join("; ")
            )
        };
        let behind = format!("crossing behind zebra {{ at: -{back} m }}");
        let ahead = format!("crossing ahead unmarked {{ at: {on} m }}");
        let one = measured(&text(&[]));
        prop_assert_eq!(one.fingerprint, measured(&text(std::slice::from_ref(&behind))).fingerprint);
        let two = measured(&text(&[behind.clone(), ahead.clone()]));
        prop_assert_eq!(two, measured(&text(&[ahead, behind])));
    }
}
