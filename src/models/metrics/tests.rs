//! Encounters worked out by hand, for every metric, and what must hold for any encounter.

use proptest::prelude::*;

use super::fixture::{Profile, Walk, measure, measure_all, open_of, presence, request, world};
use super::*;
use scenario::Settings;
use scenario::{Appearance, Direction, Side, Value};
use sim::measure::{Closeness, Open, Presence};

const STEPS: [f64; 2] = [0.005, 0.025];

fn straight(place: f64) -> Profile {
    Profile::new(place, 10.0, &[])
}

/// Walks straight across at 1 m/s from `start` s on.
fn crossing_from(start: f64) -> Walk {
    if start == 0.0 {
        Walk(vec![(0.0, 0.0, -4.0), (8.0, 0.0, 4.0)])
    } else {
        Walk(vec![(0.0, 0.0, -4.0), (start, 0.0, -4.0), (start + 8.0, 0.0, 4.0)])
    }
}

#[track_caller]
fn assert_near(name: &str, found: Option<f64>, expected: Option<f64>, tolerance: f64) {
    let near = match (found, expected) {
        (Some(found), Some(expected)) => (found - expected).abs() <= tolerance,
        (found, expected) => found == expected,
    };
    assert!(near, "{name}: {found:?} instead of {expected:?}");
}

#[test]
fn pedestrian_first_at_constant_speeds() {
    for step in STEPS {
        let found = measure_all(&world(step, 15.0), &straight(-100.0), &crossing_from(0.0));
        // The pedestrian is on the line after 4 s and clear of the strip at 1.25 m; the vehicle is there after 10 s.
        for (name, expected) in [
            ("collision", Some(0.0)),
            ("impact_speed", None),
            ("pet", Some(6.0)),
            ("pet_area", Some(9.775 - 5.25)),
            ("passed_first", Some(1.0)),
            ("gap_accepted", Some(1.0)),
            ("tta_at_entry", Some(8.0)),
            ("min_ttc", None),
            ("min_distance", Some(2.75)),
            ("drac", None),
            // Clear of the strip after 5.25 s, when the front is 45.25 m away.
            ("time_headway", Some(4.525)),
            ("lateral_acceleration", Some(0.0)),
            ("max_deceleration", Some(0.0)),
            ("sudden_speed_change", Some(0.0)),
            ("max_jerk", Some(0.0)),
            ("rms_jerk", Some(0.0)),
            ("time_lost", Some(0.0)),
            ("travel_time", Some(12.0)),
            ("stopped_time", Some(0.0)),
            ("crossing_initiation_time", Some(0.0)),
            ("crossing_duration", Some(4.0)),
            // 6 m at 1 m/s instead of 1.25 m/s.
            ("pedestrian_delay", Some(1.2)),
        ] {
            assert_near(name, found(name), expected, 1e-9);
        }
    }
}

#[test]
fn vehicle_first_at_constant_speeds() {
    for step in STEPS {
        let found = measure_all(&world(step, 20.0), &straight(-50.0), &crossing_from(3.01));
        for (name, expected) in [
            ("pet", Some(7.01 - 5.0)),
            // The rear is clear of the pedestrian's width at 5.225 s, his front enters the strip at 2.75 m.
            ("pet_area", Some(5.76 - 5.225)),
            // Nobody is in the strip before the front has passed.
            ("time_headway", None),
            ("passed_first", Some(2.0)),
            ("gap_accepted", Some(0.0)),
            ("tta_at_entry", None),
            ("crossing_initiation_time", Some(3.01)),
            ("crossing_duration", Some(4.0)),
            ("pedestrian_delay", Some(9.01 - 4.8)),
        ] {
            // He sets off inside a step, which his velocity does not show.
            let tolerance = if name == "crossing_initiation_time" { step } else { 1e-9 };
            assert_near(name, found(name), expected, tolerance);
        }
    }
}

#[test]
fn tta_at_entry_from_the_front() {
    let requests = [request("tta_at_entry", [("reference", Value::Word("front".into()))])];
    let readings = measure(&world(0.025, 15.0), &requests, &straight(-100.0), &crossing_from(0.0));
    assert_near("tta_at_entry", readings[0].worst.and_then(|w| w.value), Some(7.8), 1e-9);
}

#[test]
fn braking_profile() {
    // Brakes at 3 m/s^2 for 1 s and regains its speed at the same rate: loses 0.3 s on 10 m/s.
    let car = Profile::new(-100.0, 10.0, &[(2.0, 0.0), (1.0, -3.0), (1.0, 3.0)]);
    for step in STEPS {
        let found = measure_all(&world(step, 15.0), &car, &crossing_from(0.0));
        assert_near("max_deceleration", found("max_deceleration"), Some(3.0), 0.0);
        assert_near("sudden_speed_change", found("sudden_speed_change"), Some(1.0), 0.0);
        assert_near("time_lost", found("time_lost"), Some(0.3), 1e-9);
        // From braking to accelerating the mean acceleration changes by 6 m/s^2 in one window.
        assert_near("max_jerk", found("max_jerk"), Some(30.0), 1e-6);
        // Three triangles, 0.4 s wide, of 15, 30 and 15 m/s^3.
        let integral = 0.4 / 3.0 * (225.0 + 900.0 + 225.0);
        assert_near("rms_jerk", found("rms_jerk"), Some((integral / 15.0_f64).sqrt()), 1e-3);
    }
}

#[test]
fn a_limit_kept_exactly_is_not_exceeded() {
    let car = Profile::new(-100.0, 10.0, &[(2.0, 0.0), (1.7, -2.5), (3.0, 1.0)]);
    for step in STEPS {
        let found = measure_all(&world(step, 15.0), &car, &crossing_from(0.0));
        assert_near("max_deceleration", found("max_deceleration"), Some(2.5), 0.0);
        assert_near("sudden_speed_change", found("sudden_speed_change"), Some(0.0), 0.0);
    }
}

#[test]
fn deceleration_is_exact_for_windows_between_steps() {
    // 0.1 s at 6 m/s^2 is a drop of 0.6 m/s in any window that holds it.
    let car = Profile::new(-100.0, 10.0, &[(2.0, 0.0), (0.1, -6.0)]);
    for (window, expected) in [(0.2, 3.0), (0.13, 0.6 / 0.13), (0.0731, 6.0), (1.0, 0.6)] {
        for step in STEPS {
            let requests = [request("max_deceleration", [("window", Value::Number(window))])];
            let readings = measure(&world(step, 5.0), &requests, &car, &crossing_from(0.0));
            assert_near("max_deceleration", readings[0].worst.and_then(|w| w.value), Some(expected), 1e-8);
        }
    }
}

#[test]
fn the_end_of_a_stop_does_not_count() {
    // Gentle down to 1.2 m/s, then at 10 m/s^2: of that only the drop to 1 m/s counts, and some braking before it.
    let car = Profile::new(-100.0, 10.0, &[(4.4, -2.0), (0.12, -10.0)]);
    for step in STEPS {
        let requests = [
            request("max_deceleration", []),
            request("max_deceleration", [("standstill", Value::Number(0.0))]),
        ];
        let readings = measure(&world(step, 8.0), &requests, &car, &crossing_from(0.0));
        let value = |index: usize| readings[index].worst.and_then(|worst| worst.value);
        // Bends at 1 m/s (4.42 s): 0.18 s before it at 2 m/s^2, 0.02 s at 10 m/s^2. Exact where the step meets 4.42 s.
        let expected = (0.18 * 2.0 + 0.2) / 0.2;
        assert_near("max_deceleration", value(0), Some(expected), if step == 0.005 { 1e-6 } else { 0.6 });
        assert_near(
            "max_deceleration",
            value(1),
            Some((1.2 + 0.08 * 2.0) / 0.2),
            if step == 0.005 { 1e-6 } else { 0.2 },
        );
    }
}

#[test]
fn a_retreating_pedestrian() {
    // Passes the line at 4 s, turns at 4.5 s, passes it again at 5 s.
    let retreat = Walk(vec![(0.0, 0.0, -4.0), (4.5, 0.0, 0.5), (9.0, 0.0, -4.0)]);
    // And once more, at 13 s.
    let again = Walk(vec![(0.0, 0.0, -4.0), (4.5, 0.0, 0.5), (9.0, 0.0, -4.0), (17.0, 0.0, 4.0)]);
    for step in STEPS {
        let world = world(step, 20.0);
        let found = measure_all(&world, &straight(-100.0), &retreat);
        assert_near("pet", found("pet"), Some(5.0), 1e-9);
        assert_near("pet_area", found("pet_area"), Some(9.775 - 6.25), 1e-9);
        assert_near("passed_first", found("passed_first"), Some(2.0), 0.0);
        assert_near("gap_accepted", found("gap_accepted"), Some(0.0), 0.0);
        assert_near("crossing_duration", found("crossing_duration"), None, 0.0);
        assert_near("tta_at_entry", found("tta_at_entry"), Some(8.0), 1e-9);
        let found = measure_all(&world, &straight(-100.0), &again);
        assert_near("pet", found("pet"), Some(3.0), 1e-9);
        assert_near("pet_area", found("pet_area"), Some(11.75 - 10.225), 1e-9);
        assert_near("passed_first", found("passed_first"), Some(2.0), 0.0);
        assert_near("crossing_duration", found("crossing_duration"), Some(4.0), 1e-9);
        assert_near("pedestrian_delay", found("pedestrian_delay"), Some(15.0 - 4.8), 1e-9);
    }
}

#[test]
fn collision_inside_a_step() {
    let standing = Walk(vec![(0.0, 0.0, 0.0)]);
    let walking = Walk(vec![(0.0, 0.0, -5.0), (10.0, 0.0, 5.0)]);
    for step in STEPS {
        let world = world(step, 20.0);
        for (walk, place, speed) in [(&standing, -50.11, 10.0), (&walking, -52.2, f64::hypot(10.0, 1.0))] {
            let found = measure_all(&world, &straight(place), walk);
            for (name, expected) in [
                ("collision", Some(1.0)),
                ("impact_speed", Some(speed)),
                ("pet", Some(0.0)),
                ("pet_area", Some(0.0)),
                ("gap_accepted", Some(0.0)),
                ("min_ttc", Some(0.0)),
                ("min_distance", Some(0.0)),
                ("drac", Some(20.0)),
                ("time_headway", Some(0.0)),
                ("time_lost", None),
                ("travel_time", None),
            ] {
                assert_near(name, found(name), expected, 1e-9);
            }
        }
        let requests = [request("pet", [("zero_on_collision", Value::Flag(false))])];
        let readings =
            measure(&world, &requests, &straight(-50.0), &Walk(vec![(0.0, 0.0, -0.1), (9.0, 0.0, -0.1)]));
        assert_eq!(readings[0].worst, None);
    }
}

/// A car that passes the conflict point at 5 s, and a pedestrian who does so later or never.
#[test]
fn times_beyond_what_counts_are_that() {
    let world = world(0.025, 12.0);
    let passes = |time: f64| Walk(vec![(0.0, 0.0, -4.0), (time - 4.0, 0.0, -4.0), (time + 4.0, 0.0, 4.0)]);
    let found = |name: &str, most: f64, walk: &Walk| {
        let requests = [request(name, []), request(name, [("at_most", Value::Number(most))])];
        let readings = measure(&world, &requests, &straight(-50.0), walk);
        readings.iter().map(|found| found.worst.and_then(|worst| worst.value)).collect::<Vec<_>>()
    };
    for name in ["pet", "pet_area"] {
        let plain = found(name, 100.0, &passes(9.0))[0].unwrap();
        assert!(plain > 2.0, "{name} {plain}");
        assert_eq!(found(name, 100.0, &passes(9.0)), [Some(plain); 2]);
        assert_eq!(found(name, 2.0, &passes(9.0)), [Some(plain), Some(2.0)]);
        // What is less stays, and what does not exist does not come to be.
        let near = found(name, 3.0, &passes(6.5));
        assert!(near[0] == near[1] && near[0].unwrap() < 3.0, "{name} {near:?}");
        assert_eq!(found(name, 3.0, &Walk(vec![(0.0, 0.0, -4.0), (12.0, 0.0, -4.0)])), [None, None]);
    }
    // Cut off before anybody passes the second time, it is open up to what counts.
    let requests = [request("pet", [("at_most", Value::Number(3.0))])];
    let open =
        |world: &scenario::World, walk: &Walk| measure(world, &requests, &straight(-50.0), walk)[0].open;
    let short = super::fixture::world(0.025, 6.0);
    let found = open(&short, &passes(9.0)).unwrap();
    assert!((found.low - 1.0).abs() < 1e-9 && found.high == 3.0, "{found:?}");
    assert_eq!(open(&super::fixture::world(0.025, 8.5), &passes(9.0)), Some(Open { low: 3.0, high: 3.0 }));
}

#[test]
fn whoever_walks_along_the_lane_is_followed_at_a_headway() {
    // Brakes from 10 m/s at 2 m/s^2 behind somebody who walks at 1 m/s: (40.75 - 9 t + t^2)/(10 - 2 t) is smallest at t = 0.4448 s.
    let car = Profile::new(-50.0, 10.0, &[(3.0, 0.0), (4.0, -2.0)]);
    let along = |beside: f64| Walk(vec![(0.0, 20.0, beside), (20.0, 40.0, beside)]);
    for step in STEPS {
        let found = measure_all(&world(step, 8.0), &car, &along(0.0));
        assert_near("time_headway", found("time_headway"), Some(4.055_219), 2e-4);
        // Beside the strip nobody is followed, and who stands follows nobody.
        let found = measure_all(&world(step, 8.0), &car, &along(1.26));
        assert_near("time_headway", found("time_headway"), None, 0.0);
        let found = measure_all(&world(step, 8.0), &Profile::new(-50.0, 0.0, &[]), &along(0.0));
        assert_near("time_headway", found("time_headway"), None, 0.0);
    }
}

#[test]
fn a_pedestrian_hit_beyond_the_line_had_passed_first() {
    let walking = Walk(vec![(0.0, 0.0, -5.0), (10.0, 0.0, 5.0)]);
    let found = measure_all(&world(0.025, 20.0), &straight(-52.4), &walking);
    assert_near("collision", found("collision"), Some(1.0), 0.0);
    assert_near("passed_first", found("passed_first"), Some(1.0), 0.0);
    assert_near("pet", found("pet"), Some(0.0), 0.0);
}

#[test]
fn the_smallest_distance_lies_inside_a_step() {
    // The front is 98 - 10 t before the pedestrian, who is t - 5.25 beside the car: nearest at t = 1970/202.
    let away = Walk(vec![(0.0, 0.0, -4.0), (18.0, 0.0, 14.0)]);
    let nearest = f64::hypot(98.0 - 19700.0 / 202.0, 1970.0 / 202.0 - 5.0) - 0.25;
    for step in STEPS {
        let found = measure_all(&world(step, 15.0), &straight(-100.0), &away);
        assert_near("min_distance", found("min_distance"), Some(nearest), 1e-9);
    }
}

#[test]
fn nothing_after_the_collision_counts() {
    // Over the last step the speed falls from 10 to 5 m/s. The gap of 0.25 m closes at 7.5 m/s, after two thirds of it.
    let car = Profile::new(-50.0, 10.0, &[(4.75, 0.0), (1.0, -100.0)]);
    let found = measure_all(&world(0.05, 6.0), &car, &Walk(vec![(0.0, 0.0, 0.0)]));
    assert_near("max_deceleration", found("max_deceleration"), Some(10.0 / 3.0 / 0.2), 1e-6);
    assert_near("impact_speed", found("impact_speed"), Some(10.0 - 10.0 / 3.0), 1e-6);
}

#[test]
fn a_vehicle_that_stops_for_good() {
    let car = Profile::new(-100.0, 10.0, &[(4.0, 0.0), (5.0, -2.0)]);
    for step in STEPS {
        let found = measure_all(&world(step, 20.0), &car, &crossing_from(0.0));
        for (name, expected) in [
            ("pet", None),
            ("pet_area", None),
            ("passed_first", Some(1.0)),
            ("gap_accepted", Some(1.0)),
            ("time_lost", None),
            ("travel_time", None),
            ("max_deceleration", Some(2.0)),
            // From 0.1 m/s, 0.05 s before standstill at 9 s.
            ("stopped_time", Some(11.05)),
        ] {
            assert_near(name, found(name), expected, 1e-9);
        }
    }
}

#[test]
fn what_the_horizon_cuts_off_is_open() {
    // The pedestrian crosses at once; the car stands at 9 s, 35 m before the crossing, for good.
    let car = Profile::new(-100.0, 10.0, &[(4.0, 0.0), (5.0, -2.0)]);
    let found = open_of(&world(0.025, 20.0), &car, &crossing_from(0.0));
    for (name, low) in [
        ("pet", 16.0),
        ("time_lost", 8.0),
        ("travel_time", 20.0),
        ("stopped_time", 11.05),
        ("pet_area", 14.75),
    ] {
        let open = found(name).unwrap_or_else(|| panic!("{name} is not open"));
        assert!((open.low - low).abs() < 1e-6 && open.high == f64::INFINITY, "{name}: {open:?}");
    }
    for name in ["collision", "min_distance", "max_deceleration", "crossing_duration", "pedestrian_delay"] {
        assert_eq!(found(name), None, "{name}");
    }
    // The car passes at 10 s, nobody ever goes.
    let found = open_of(&world(0.025, 30.0), &straight(-100.0), &Walk(vec![(0.0, 0.0, -4.0)]));
    for (name, low) in [("pet", 20.0), ("crossing_initiation_time", 30.0), ("crossing_duration", 0.0)] {
        assert!((found(name).unwrap().low - low).abs() < 1e-6, "{name}: {:?}", found(name));
    }
    for name in ["passed_first", "gap_accepted", "time_lost", "stopped_time"] {
        assert_eq!(found(name), None, "{name}");
    }
    // Nobody has passed yet.
    let found = open_of(&world(0.025, 3.0), &straight(-100.0), &crossing_from(0.0));
    assert_eq!(found("passed_first"), Some(Open { low: 1.0, high: 2.0 }));
    assert_eq!(found("gap_accepted"), Some(Open { low: 0.0, high: 1.0 }));
}

#[test]
fn not_back_at_cruise_speed_means_no_time_lost() {
    let slow = Profile::new(-100.0, 10.0, &[(2.0, 0.0), (1.0, -1.0)]);
    let found = measure_all(&world(0.025, 20.0), &slow, &crossing_from(0.0));
    assert_near("time_lost", found("time_lost"), None, 0.0);
}

#[test]
fn nobody_crosses() {
    let found = measure_all(&world(0.025, 20.0), &straight(-100.0), &Walk(vec![(0.0, 0.0, -4.0)]));
    for name in [
        "impact_speed",
        "pet",
        "pet_area",
        "tta_at_entry",
        "min_ttc",
        "drac",
        "crossing_initiation_time",
        "crossing_duration",
        "pedestrian_delay",
    ] {
        assert_near(name, found(name), None, 0.0);
    }
    assert_near("min_distance", found("min_distance"), Some(2.75), 1e-9);
    assert_near("passed_first", found("passed_first"), Some(2.0), 0.0);
    assert_near("gap_accepted", found("gap_accepted"), Some(0.0), 0.0);
}

#[test]
fn nobody_appears() {
    let mut world = world(0.025, 20.0);
    world.pedestrians[0].appears = Appearance::At(60.0);
    let found = measure_all(&world, &straight(-100.0), &crossing_from(0.0));
    assert_near("passed_first", found("passed_first"), Some(0.0), 0.0);
    assert_near("collision", found("collision"), Some(0.0), 0.0);
    for name in ["gap_accepted", "pet", "pet_area", "min_distance", "tta_at_entry", "pedestrian_delay"] {
        assert_near(name, found(name), None, 0.0);
    }
}

#[test]
fn delay_and_initiation_count_from_the_appearance() {
    let mut world = world(0.025, 20.0);
    world.pedestrians[0].appears = Appearance::At(2.0);
    let found = measure_all(&world, &straight(-150.0), &crossing_from(3.0));
    assert_near("crossing_initiation_time", found("crossing_initiation_time"), Some(1.0), 1e-9);
    // 1 s of waiting and 6 m at 1 m/s instead of 1.25 m/s.
    assert_near("pedestrian_delay", found("pedestrian_delay"), Some(2.2), 1e-9);
}

#[test]
fn braking_for_a_standing_pedestrian() {
    // Brakes at 5 m/s^2 from a gap of 15 m: g/v is smallest where v^2 = 5 g, at g = 10 m.
    let car = Profile::new(-47.25, 10.0, &[(3.0, 0.0), (2.0, -5.0)]);
    for step in STEPS {
        let found = measure_all(&world(step, 8.0), &car, &Walk(vec![(0.0, 0.0, 0.0)]));
        assert_near("min_ttc", found("min_ttc"), Some(2.0_f64.sqrt()), 1e-3);
        assert_near("drac", found("drac"), Some(100.0 / 30.0), 1e-9);
        assert_near("min_distance", found("min_distance"), Some(5.0), 1e-9);
        assert_near("collision", found("collision"), Some(0.0), 0.0);
    }
}

#[test]
fn the_worst_pair_is_named() {
    let mut world = world(0.025, 15.0);
    world.vehicles[0].name = "av".into();
    let mut requests = vec![request("pet", []), request("max_deceleration", []), request("pet", [])];
    requests[2].pair = Some(("av".into(), "somebody".into()));
    let readings = measure(&world, &requests, &straight(-100.0), &crossing_from(0.0));
    let worst = readings[0].worst.unwrap();
    assert_eq!((worst.vehicle, worst.pedestrian), (Some(0), Some(0)));
    let worst = readings[1].worst.unwrap();
    assert_eq!((worst.vehicle, worst.pedestrian), (Some(0), None));
    assert!(readings[2].subjects.is_empty());
}

#[test]
fn names_are_unique_and_defaults_resolve() {
    let all = metrics();
    for (index, one) in all.iter().enumerate() {
        assert!(one.declaration.resolve(&Settings::default()).is_ok(), "{}", one.declaration.name);
        assert!(all[..index].iter().all(|other| other.declaration.name != one.declaration.name));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn what_holds_for_any_encounter(
        place in -120.0..-30.0, brake in 0.0..6.0_f64, at in 0.0..5.0, long in 0.0..2.0, start in 0.0..8.0,
        walking in 0.5..3.0, drift in -0.5..0.5,
    ) {
        let car = Profile::new(place, 10.0, &[(at, 0.0), (long, -brake), (3.0, 1.0)]);
        let walk = |side: f64, direction: f64| {
            let end = start + 1.0 + 8.0 / walking;
            Walk(vec![
                (0.0, 0.0, -4.0 * side),
                (start + 1.0, 0.0, -4.0 * side),
                (end, drift * direction * (end - start - 1.0), 4.0 * side),
            ])
        };
        let near = world(0.025, 30.0);
        let found = measure_all(&near, &car, &walk(1.0, 1.0));
        let (pet, area) = (found("pet"), found("pet_area"));
        prop_assert!(pet.is_none_or(|pet| pet >= 0.0));
        if let (Some(pet), Some(area)) = (pet, area) {
            prop_assert!(0.0 <= area && area <= pet + 1e-9, "{} {}", area, pet);
        }
        prop_assert_eq!(found("collision") == Some(1.0), found("impact_speed").is_some());
        prop_assert_eq!(found("collision") == Some(1.0), found("min_distance") == Some(0.0));
        if found("min_ttc").is_none() {
            prop_assert_eq!(found("drac"), None);
            prop_assert_eq!(found("collision"), Some(0.0));
        }

        // From the other side, and on a lane in the other direction, everything is the same.
        let mut far = near.clone();
        far.pedestrians[0].side = Side::Far;
        (far.pedestrians[0].start.y, far.pedestrians[0].goal.y) = (4.0, -4.0);
        let mut backward = near.clone();
        backward.road.lanes[0].direction = Direction::Backward;
        let mirrored = [measure_all(&far, &car, &walk(-1.0, 1.0)), measure_all(&backward, &car, &walk(1.0, -1.0))];
        for metric in metrics() {
            let name = &*metric.declaration.name;
            for other in &mirrored {
                match (found(name), other(name)) {
                    (Some(one), Some(two)) => prop_assert!((one - two).abs() < 1e-9, "{}: {} {}", name, one, two),
                    (one, two) => prop_assert_eq!(one, two, "{}", name),
                }
            }
        }

        // Two steps of the simulation agree as far as interpolation goes.
        let fine = measure_all(&world(0.005, 30.0), &car, &walk(1.0, 1.0));
        if fine("collision") == found("collision") {
            for (name, tolerance) in [
                ("pet", 1e-3), ("pet_area", 1e-3), ("max_deceleration", 0.8), ("crossing_duration", 1e-6),
                ("min_distance", 0.05), ("pedestrian_delay", 1e-6), ("stopped_time", 0.02),
            ] {
                if let (Some(one), Some(two)) = (found(name), fine(name)) {
                    prop_assert!((one - two).abs() <= tolerance, "{}: {} {}", name, one, two);
                }
            }
        }
    }
}

/// Critical instants of the run-level values, by name.
fn instants(world: &scenario::World, car: &Profile, walk: &Walk) -> impl Fn(&str) -> Option<f64> + use<> {
    let requests: Vec<_> = metrics().iter().map(|metric| request(&metric.declaration.name, [])).collect();
    let readings = measure(world, &requests, car, walk);
    move |name| {
        let index = metrics().iter().position(|metric| metric.declaration.name == name).unwrap();
        readings[index].worst.and_then(|worst| worst.instant)
    }
}

#[test]
fn critical_instants_of_extremes() {
    for step in STEPS {
        // Brakes by 4 m/s^2 from 5 s to 6 s; the window of 0.2 s is full of it at 5.2 s. Then it goes on at 6 m/s.
        let braking = Profile::new(-100.0, 10.0, &[(5.0, 0.0), (1.0, -4.0)]);
        let standing = Walk(vec![(0.0, 0.0, -4.0), (1.0, 0.0, -4.0)]);
        let found = instants(&world(step, 20.0), &braking, &standing);
        assert_near("max_deceleration", found("max_deceleration"), Some(5.2), 1e-9);
        assert_near("sudden_speed_change", found("sudden_speed_change"), Some(5.2), 1e-9);
        // 58 m are done by 6 s; the front is beside the pedestrian 40 m later.
        assert_near("min_distance", found("min_distance"), Some(6.0 + 40.0 / 6.0), step);

        // Steps into the way of a car that does not brake: they touch when the disc reaches its side or front.
        let into = Walk(vec![(0.0, 0.0, -4.0), (8.0, 0.0, -4.0), (12.0, 0.0, 4.0)]);
        let found = instants(&world(step, 15.0), &straight(-100.0), &into);
        for name in ["collision", "impact_speed", "pet", "pet_area", "min_ttc", "min_distance"] {
            let touch = found(name).unwrap_or(f64::NAN);
            assert!((9.0..9.8).contains(&touch), "{name}: {touch}");
            assert_eq!(found(name), found("collision"), "{name}");
        }
    }
}

#[test]
fn critical_instants_of_a_pedestrian_who_passes_first() {
    for step in STEPS {
        let found = instants(&world(step, 15.0), &straight(-100.0), &crossing_from(0.0));
        for (name, expected) in [
            ("collision", None),
            // The second of the two, which is the vehicle, passes after 10 s and enters after 9.775 s.
            ("pet", Some(10.0)),
            ("pet_area", Some(9.775)),
            // The pedestrian is on the line after 4 s, in the lane from 2 s to 6 s.
            ("passed_first", Some(4.0)),
            ("gap_accepted", Some(4.0)),
            ("tta_at_entry", Some(2.0)),
            ("crossing_initiation_time", Some(0.0)),
            ("crossing_duration", Some(6.0)),
            ("pedestrian_delay", Some(6.0)),
            ("min_ttc", None),
            ("drac", None),
            ("max_deceleration", None),
            ("max_jerk", None),
            // Nothing that happens at one instant.
            ("rms_jerk", None),
            ("time_lost", None),
            ("stopped_time", None),
        ] {
            assert_near(name, found(name), expected, 1e-9);
        }
    }
}

#[test]
fn how_close_a_pedestrian_and_a_vehicle_come() {
    let world = world(0.025, 30.0);
    let of = |car: Profile, walk: &[(f64, f64, f64)]| presence(&world, &car, &Walk(walk.to_vec()));
    let closest = |car: Profile, walk: &[(f64, f64, f64)]| of(car, walk).closest;
    let car = |place, speed, stretches: &[(f64, f64)]| Profile::new(place, speed, stretches);
    let (lane, half) = (world.road.path(0).point(0.0).y, world.road.lane_width / 2.0);
    let across = |from: f64| [(0.0, 0.0, lane - 5.0), (from, 0.0, lane - 5.0), (from + 8.0, 0.0, lane + 5.0)];
    // In the lane from 2.4 s to 5.6 s on; at 10 m/s from 120 m away the car is then 6 s away, from 95 m 3.6 s.
    let enters = 8.0 * (5.0 - half) / 10.0;
    assert!((enters - 2.4).abs() < 0.5, "{enters}");
    assert_eq!(closest(car(-120.0, 10.0, &[]), &across(0.001)), Closeness::InTheWay);
    assert_eq!(closest(car(-95.0, 10.0, &[]), &across(0.001)), Closeness::Met);
    // Behind a car that has been gone for less than 5 s, or longer; behind one that was past when they appeared, however near.
    assert_eq!(closest(car(-10.0, 10.0, &[]), &across(0.001)), Closeness::Met);
    assert_eq!(closest(car(-10.0, 10.0, &[]), &across(8.0)), Closeness::InTheWay);
    assert_eq!(closest(car(10.0, 10.0, &[]), &across(0.001)), Closeness::Apart);
    // Beside the lane no pedestrian is in the way, however near.
    let beside = [(0.0, 0.0, lane - half - 0.5), (30.0, 0.1, lane - half - 0.5)];
    let passed = of(car(-50.0, 10.0, &[]), &beside);
    assert_eq!(passed, Presence { closest: Closeness::Abreast, moved: true, passed: true });
    let stops = of(car(-50.0, 10.0, &[(2.0, 0.0), (4.0, -10.0)]), &beside);
    assert_eq!(stops, Presence { closest: Closeness::Together, moved: true, passed: false });
    // A car that stops early was on its way when they appeared; one that stood by then has met what comes within 25 m.
    assert_eq!(closest(car(-45.0, 10.0, &[(20.0, -2.0)]), &across(15.0)), Closeness::Met);
    let mut late = world.clone();
    late.pedestrians[0].appears = Appearance::At(10.0);
    let walk = Walk(vec![(0.0, 0.0, lane - 5.0), (15.0, 0.0, lane - 5.0), (23.0, 0.0, lane + 5.0)]);
    for (place, expected) in [(-50.0, Closeness::Met), (-60.0, Closeness::InTheWay)] {
        // It stands 25 m further on before they appear.
        let stood = presence(&late, &car(place, 10.0, &[(20.0, -2.0)]), &walk);
        assert_eq!((stood.closest, stood.moved), (expected, false), "{place}");
    }
    // A parked car meets no pedestrian, and neither does one that moves by rounding.
    for speed in [0.0, 1e-9] {
        let parked = of(car(-10.0, speed, &[]), &across(0.001));
        assert_eq!(parked, Presence { closest: Closeness::Apart, moved: false, passed: false });
    }
    late.pedestrians[0].appears = Appearance::At(1000.0);
    assert_eq!(presence(&late, &straight(-50.0), &walk), Presence::default());
    // A car that drives into a pedestrian that stands there.
    let stands = Walk(vec![(0.0, 0.0, lane), (30.0, 0.1, lane)]);
    assert_eq!(presence(&world, &straight(-50.0), &stands).closest, Closeness::Touched);
}

/// A controller that stops exactly leaves speeds of rounding, over which a distance is no time to arrival.
#[test]
fn a_vehicle_that_stands_but_for_rounding_does_not_arrive() {
    let requests = [request("tta_at_entry", [])];
    for (speed, expected) in [(1e-16, None), (0.1, None), (0.2, Some(8.0))] {
        // The pedestrian enters after 2 s.
        let car = Profile::new(-2.0, speed, &[]);
        let readings = measure(&world(0.025, 15.0), &requests, &car, &crossing_from(0.0));
        let found = readings[0].worst.and_then(|worst| worst.value);
        assert_near("tta_at_entry", found, expected, 1e-9);
    }
}
