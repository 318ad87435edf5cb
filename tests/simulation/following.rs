//! Vehicles behind vehicles: controllers that ship and react follow what is ahead in their lane, and nothing else of other vehicles changes a bit.

use models::standard;
use proptest::prelude::*;
use runner::run::road_users;
use sim::geometry::{Footprint, apart};
use sim::{Observer, Snapshot, Solid, Step, simulate};

use crate::support::text::case;

/// Controllers that react, with the dynamics that they drive by default.
const FOLLOWING: [&str; 6] = ["yielding", "careful_human", "commotions", "autoware", "idm_aeb", "idm_aes"];

/// How a vehicle gets on: its place and speed after each step, the gap to the first of the file, and whether it touched it.
#[derive(Default)]
struct Course {
    places: Vec<(f64, f64)>,
    gaps: Vec<f64>,
    touches: bool,
}

impl Course {
    fn note(&mut self, state: &Snapshot) {
        let [first, .., av] = &state.vehicles[..] else { return };
        self.places.push((av.motion.travelled, av.motion.speed));
        self.gaps.push(apart(&Footprint::from(first), &Footprint::from(av)));
    }
}

impl Observer for Course {
    fn begin(&mut self, start: &Snapshot) {
        self.note(start);
    }

    fn observe(&mut self, step: &Step) {
        self.note(step.after);
        self.touches |= step
            .contacts
            .iter()
            .any(|touch| matches!((touch.first, touch.second), (Solid::Vehicle(_), Solid::Vehicle(_))));
    }
}

/// The last vehicle of a street.
fn course(users: &str) -> Course {
    let text = format!(
        "scenario a {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 80 km/h; crossing zebra }}
  horizon 60 s; finish 400 m
  {users}
}}"
    );
    let (case, mut course) = (case(&text), Course::default());
    let users = road_users(&case.world, case.seed).unwrap();
    simulate(&case.world, users, &mut course).unwrap();
    course
}

/// A pedestrian that crosses far behind everything, late.
const NOBODY: &str = "pedestrian p { model scripted; start 2 m from kerb; along -80 m; appears at 59 s }";

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// It stands on the crossing or beyond it, for good.
    #[test]
    fn a_vehicle_that_stands_is_not_driven_into(
        controller in prop::sample::select(FOLLOWING.to_vec()), own in 15.0..60.0_f64, braked in 2.0..5.0_f64, stops in -40.0..40.0_f64,
    ) {
        let users = format!(
            "vehicle first {{ controller constant_deceleration {{ deceleration: {braked} m/s^2, distance: {} m }}; speed 36 km/h; start 90 m before crossing }}
  {NOBODY}
  vehicle av {{ controller {controller}; speed {own} km/h; start 150 m before crossing }}",
            (-stops).max(0.0) + 50.0 / braked
        );
        let course = course(&users);
        prop_assert!(!course.touches, "{controller} {own} km/h");
        let (last, gap) = (course.places.last().unwrap(), *course.gaps.last().unwrap());
        prop_assert!(last.1 < 0.1 && (0.2..8.0).contains(&gap), "{controller}: {last:?}, {gap} m");
    }

    /// It slows down, stops and goes on, as a car in town does; all come as far as it does.
    #[test]
    fn stop_and_go_is_followed(
        controller in prop::sample::select(FOLLOWING.to_vec()), slow in 0.0..25.0_f64, brakes in 1.0..4.0_f64, at in 3.0..9.0_f64, waits in 1.0..8.0_f64,
        behind in 25.0..60.0_f64,
    ) {
        let users = format!(
            "vehicle first {{
    controller timeline {{ steps: \"at t1 speed v1; after t2 speed v2; after t3 stop; after t4 resume\", t1: {at} s, v1: {slow} km/h, t2: {waits} s, v2: 30 km/h, t3: 6 s, t4: 6 s, deceleration: {brakes} m/s^2 }}
    speed 40 km/h
    start 60 m before crossing
  }}
  {NOBODY}
  vehicle av {{ controller {controller}; speed 40 km/h; start {} m before crossing }}",
            60.0 + behind
        );
        let course = course(&users);
        prop_assert!(!course.touches, "{controller}: {:?}", course.gaps.iter().copied().fold(f64::INFINITY, f64::min));
        let (from, to) = (course.places[0].0, course.places.last().unwrap().0);
        prop_assert!(to - from > 150.0, "{controller} comes {} m", to - from);
    }

    /// Behind it, or coming on the other lane, they are nothing to follow.
    #[test]
    fn vehicles_that_are_not_ahead_change_no_bit(
        controller in prop::sample::select(FOLLOWING.to_vec()), speed in 20.0..50.0_f64, appears in 1.0..9.0_f64,
    ) {
        // It looks whether the lane beside is free to swerve onto.
        prop_assume!(controller != "idm_aes");
        let walker = format!("pedestrian p {{ model scripted; start 2 m from kerb; appears at {appears} s }}");
        let own = format!("vehicle av {{ controller {controller}; speed {speed} km/h; start 80 m before crossing }}");
        let alone = course(&format!("vehicle gone {{ controller constant_speed; speed {speed} km/h; lane 1; start 300 m before crossing }}\n  {walker}\n  {own}"));
        let others = format!(
            "vehicle behind {{ controller constant_speed; speed 10 km/h; start 100 m before crossing }}
  vehicle oncoming {{ controller constant_speed; speed 30 km/h; lane 1; start 70 m before crossing }}
  {walker}
  {own}"
        );
        let among = course(&others);
        let both = alone.places.iter().zip(&among.places);
        // Runs end when the last has passed; what both have is the same.
        prop_assert!(both.clone().count() > 200);
        for (one, other) in both {
            prop_assert_eq!((one.0.to_bits(), one.1.to_bits()), (other.0.to_bits(), other.1.to_bits()), "{}", controller);
        }
    }
}

/// Without a vehicle ahead the driver is the same whether it follows vehicles or not, with all its noise.
#[test]
fn following_draws_nothing() {
    let drive = |follows: bool| {
        course(&format!(
            "vehicle other {{ controller constant_speed; speed 30 km/h; lane 1; start 70 m before crossing }}
  pedestrian p {{ model commotions; start 2 m from kerb; appears when time_to_arrival(av) = 5 s }}
  vehicle av {{ controller commotions {{ follows_vehicles: {follows} }}; speed 40 km/h; start 90 m before crossing }}"
        ))
    };
    assert!(drive(true).places == drive(false).places);
}

/// The driver that is blind to vehicles is as published: it drives into what stands there.
#[test]
fn who_does_not_follow_drives_into_it() {
    let drive = |follows: bool| {
        course(&format!(
            "vehicle first {{ controller constant_deceleration {{ deceleration: 4 m/s^2, distance: 12.5 m }}; speed 10 m/s; start 50 m before crossing }}
  {NOBODY}
  vehicle av {{ controller commotions {{ follows_vehicles: {follows} }}; speed 10 m/s; start 90 m before crossing }}"
        ))
    };
    assert!(drive(false).touches && !drive(true).touches);
}

/// As many controllers ship as are looked at here, beside those that look at nothing.
#[test]
fn every_controller_that_reacts_is_looked_at() {
    let names: Vec<_> = standard().controllers().names().map(|name| name.to_string()).collect();
    let scripted = ["constant_speed", "constant_deceleration", "timeline"];
    for name in names {
        // Its half brake and its believed distances are its own: it follows, but not without contact.
        let known = FOLLOWING.contains(&&*name) || scripted.contains(&&*name) || name == "carla_behavior";
        assert!(known, "{name} is to be looked at");
    }
}

/// A vehicle that waits at red does not set off into a pedestrian in its lane, or about to be there, when green comes.
#[test]
fn a_careful_driver_does_not_set_off_into_somebody() {
    for pace in [0.2, 0.25, 0.3, 0.4, 0.6] {
        for start in [0.3, 0.5, 0.8] {
            let text = format!(
                "scenario a {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing signalised {{ cycle: 60 s, pedestrian_green: 10 s, pedestrian_green_from: 10 s, amber: 3 s, clearance: 1 s }} }}
  vehicle other {{ controller constant_speed; speed 36 km/h; start 700 m before crossing }}
  vehicle av {{ controller careful_human; speed 36 km/h; start 190 m before crossing }}
  pedestrian slow {{ model scripted {{ speed: {pace} m/s }}; start {start} m from kerb; appears at 17 s }}
  horizon 60 s
}}"
            );
            let (case, mut hits) = (case(&text), Hits::default());
            simulate(&case.world, road_users(&case.world, case.seed).unwrap(), &mut hits).unwrap();
            assert_eq!(hits.of_people, 0, "{pace} m/s from {start} m");
            assert!(hits.passed, "it goes on: {pace} m/s from {start} m");
        }
    }
}

/// Contacts with people, and whether the last vehicle passes the crossing.
#[derive(Default)]
struct Hits {
    of_people: usize,
    passed: bool,
}

impl Observer for Hits {
    fn observe(&mut self, step: &Step) {
        let people = step.contacts.iter().filter(|touch| matches!(touch.second, Solid::Pedestrian(_)));
        self.of_people += people.count();
        self.passed |= step.after.vehicles.last().is_some_and(|car| car.motion.travelled > 10.0);
    }
}
