//! Who walks along the lane of a road that bends follows it: held against the straight road, against closed forms on a circle, and against
//! itself elsewhere on that circle.

use proptest::prelude::*;
use sim::StopReason;

use crate::meetings::dummy_along;
use crate::support::text::{Measured, measured, planned};

fn assert_alike(one: &Measured, other: &Measured, what: &str) -> usize {
    assert_eq!(one.ending.0, other.ending.0, "{what}");
    assert!((one.ending.1 - other.ending.1).abs() < 1e-6, "{:?}, not {:?}: {what}", other.ending, one.ending);
    for ((name, found), (_, expected)) in other.values.iter().zip(&one.values) {
        match (found, expected) {
            (Some(found), Some(expected)) => {
                let near = (found - expected).abs() <= 1e-7 * (1.0 + expected.abs());
                assert!(near, "{name}: {found}, not {expected}: {what}");
            }
            (found, expected) => assert_eq!(found, expected, "{name}: {what}"),
        }
    }
    one.values.iter().filter(|(_, value)| value.is_some()).count()
}

#[test]
fn along_a_path_that_is_straight_they_walk_as_along_a_straight_road() {
    let paths = [
        ("", ""),
        ("path { straight 500 m }", ", at: 250.5 m"),
        ("path { arc 37 deg radius 60 m left; straight 700 m }", ", at: 400 m"),
    ];
    let people = [
        "model scripted { speed: 1.577 m/s }; walks with traffic; along 5.3 m; start 0.413 m from lane centre; goal 41.3 m further",
        "model scripted { speed: 2.177 m/s, acceleration_way: 0.71 m }; size 0.6 m x 0.5 m; walks against traffic; along 31.7 m; start 0.613 m from lane centre; goal 41.3 m further",
        "model scripted { speed: 1.577 m/s }; from far side; walks against traffic; along -25.7 m; start 0.317 m from kerb; goal 41.3 m further; appears when time_to_arrival(av.front) = 3.0137 s",
        "model scripted { speed: 1.577 m/s, stop_after: 11.3 m, stop_for: 2.13 s }; walks with traffic; along 5.3 m; start 0.413 m from lane centre; goal 21.3 m further",
        "model scripted { speed: 1.577 m/s }; size 0.6 m x 0.5 m; walks with traffic; along 25.3 m; goal 41.3 m further; meets av at 37 % after 11.3 m",
    ];
    let cars = [
        "controller constant_speed; speed 31.7 km/h; start 81.13 m before crossing",
        "controller yielding; speed 28.3 km/h; start 73.719 m before crossing; sees { range: 30 m }",
        "controller idm_aeb; speed 28.3 km/h; start 87.713 m before crossing",
    ];
    let mut values = 0;
    for car in cars {
        for person in people {
            let of = |(path, at): (&str, &str)| {
                measured(&format!(
                    "scenario a {{
  road {{ {path}; lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra {{ width: 4 m{at} }}
    parked_row vans {{ to: -6.3 m, cars: 3, gap: 1 m, across: -2.9 m, length: 4.5 m, width: 1.8 m }} }}
  vehicle av {{ {car} }}
  pedestrian jogger {{ {person} }}
  horizon 60 s
}}"
                ))
            };
            let straight = of(paths[0]);
            for path in &paths[1..] {
                values += assert_alike(&straight, &of(*path), &format!("{car}, {person}, {}", path.0));
            }
        }
    }
    assert!(values > 300, "{values} values were compared");
}

const RADIUS: f64 = 80.0;
const LENGTH: f64 = 4.4;
const WIDTH: f64 = 1.8;

/// A disc of 0.25 m that is 45 m before the centre of a car of 8 m/s, both in the middle of a lane that is a circle.
fn on_a_circle(crossing: f64, walks: &str, rest: &str) -> String {
    format!(
        "scenario a {{
  road {{ path {{ arc 180 deg radius {RADIUS} m left }}; lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h
    crossing unmarked {{ at: {crossing} m }} }}
  vehicle av {{ controller constant_speed; speed 8 m/s; size {LENGTH} m x {WIDTH} m; start 25 m before crossing }}
  pedestrian jogger {{ model scripted {{ speed: 2 m/s }}; radius 0.25 m; {walks}; along 20 m; start 0 m from lane centre; goal 60 m further }}
  horizon 60 s
  {rest}
}}"
    )
}

#[test]
fn a_car_catches_up_on_a_circle_when_the_closed_form_says() {
    // Seen from the car's centre somebody who is the angle a ahead on the circle is R sin a ahead and R (1 - cos a) to the left: the front
    // touches a disc when R sin a is half the car's length and the disc's radius.
    let angle = ((LENGTH / 2.0 + 0.25) / RADIUS).asin();
    let inwards = RADIUS * (1.0 - angle.cos());
    for (walks, speed) in [("walks with traffic", 2.0), ("walks against traffic", -2.0_f64)] {
        let run = measured(&on_a_circle(70.0, walks, "end on collision"));
        let (reason, time) = run.ending;
        let expected = (45.0 - RADIUS * angle) / (8.0 - speed);
        assert_eq!(reason, StopReason::Collision, "{walks}");
        assert!((time - expected).abs() < 1e-4, "{walks}: {time} s, not {expected}");
        // A walker's place is taken as even within a step, along a chord: 4e-6 m at 80 m.
        let impact = (64.0 + 4.0 - 2.0 * 8.0 * speed * angle.cos()).sqrt();
        let found = run.of("impact_speed").unwrap();
        assert!((found - impact).abs() < 1e-3, "{walks}: {found} m/s, not {impact}");
        let point = run.of("impact_point").unwrap();
        assert!((point - 0.5 - inwards / WIDTH).abs() < 1e-3, "{walks}: {point}");
        let headway = (RADIUS * angle - 0.25 - LENGTH / 2.0) / 8.0;
        let found = run.of("time_headway").unwrap();
        assert!((found - headway).abs() < 1e-4, "{walks}: {found} s, not {headway}");
        for nothing in ["tta_at_entry", "crossing_duration", "pedestrian_delay"] {
            assert_eq!(run.of(nothing), None, "{nothing} of who walks along the lane");
        }
    }
}

#[test]
fn behind_somebody_of_its_speed_a_car_keeps_its_headway_all_the_way_round() {
    let text = on_a_circle(70.0, "walks with traffic", "")
        .replace("speed: 2 m/s", "speed: 8 m/s")
        .replace("horizon 60 s", "horizon 7 s");
    let run = measured(&text);
    let headway = (45.0 - 0.25 - LENGTH / 2.0) / 8.0;
    let found = run.of("time_headway").unwrap();
    assert!((found - headway).abs() < 1e-6, "{found} s, not {headway}");
    assert_eq!(run.of("collision"), Some(0.0));
    assert_eq!(run.ending, (StopReason::Horizon, 7.0));
}

#[test]
fn it_is_the_same_anywhere_on_a_circle() {
    for walks in ["walks with traffic", "walks against traffic", "from far side; walks with traffic"] {
        for controller in ["constant_speed", "yielding", "idm_aeb", "careful_human"] {
            let at = |crossing: f64| {
                let text = on_a_circle(crossing, walks, "").replace("constant_speed", controller);
                measured(&text)
            };
            let one = at(60.0);
            for crossing in [71.3, 88.7] {
                assert_alike(&one, &at(crossing), &format!("{walks}, {controller} at {crossing} m"));
            }
        }
    }
}

#[test]
fn a_bend_matters_and_a_hedge_inside_it_hides_who_walks_round_it() {
    let straight =
        on_a_circle(70.0, "walks with traffic", "").replace("arc 180 deg radius 80 m left", "straight 300 m");
    let (bend, line) = (measured(&on_a_circle(70.0, "walks with traffic", "")), measured(&straight));
    assert_ne!(
        bend.of("impact_point"),
        line.of("impact_point"),
        "who walks straight on would be hit elsewhere"
    );
    let seen = |hedge: &str| {
        let text = on_a_circle(70.0, "walks against traffic", "")
            .replace(
                "controller constant_speed; speed 8 m/s",
                "controller careful_human; speed 20 m/s; sees { range: 150 m }",
            )
            .replace("crossing unmarked { at: 70 m }", &format!("crossing unmarked {{ at: 70 m }}; {hedge}"))
            .replace("along 20 m", "along 40 m")
            .replace("radius 80 m", "radius 40 m");
        measured(&text)
    };
    let open = seen("");
    let hedge = |across: &str| {
        seen(&format!(
            "parked_row hedge {{ to: 25 m, cars: 14, gap: 0.1 m, across: {across} m, length: 3 m, width: 1 m }}"
        ))
    };
    assert_ne!(hedge("6.4").values, open.values, "a hedge inside the bend hides nobody");
    assert_eq!(hedge("-3.4").values, open.values, "a hedge outside the bend hides somebody");
}

#[test]
fn what_cannot_be_followed_is_an_error_with_a_cure() {
    let text = on_a_circle(70.0, "walks with traffic", "");
    for (one, other, message) in [
        (
            "model scripted { speed: 2 m/s }",
            "model scripted { speed: 2 m/s, keeps_clear: 0.1 m }",
            "decides for itself",
        ),
        ("model scripted { speed: 2 m/s }", "model social_force", "decides for itself"),
        (
            "along 20 m; start 0 m from lane centre",
            "along 20 m; meets av at 50 % after 400 m",
            "beyond its goal",
        ),
        ("model scripted { speed: 2 m/s }", "model commotions", "decides for itself"),
        (
            "arc 180 deg radius 80 m left }; lanes forward, backward",
            "arc 60 deg radius 5 m right; straight 300 m }; lanes forward",
            "too tight",
        ),
    ] {
        assert!(text.contains(one), "{one}");
        // On the pavement, where nothing else does so too.
        let text = if message == "too tight" {
            text.replace("0 m from lane centre", "3.5 m from kerb")
        } else {
            text.clone()
        };
        let error = planned(&text.replace(one, other)).unwrap_err();
        assert!(error.contains(message), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]
    /// Whoever walks along a bend is hit where it is said, when they have walked so far.
    #[test]
    fn in_a_bend_who_is_met_is_hit_there_by_who_keeps_their_speed(
        (far, against, lane) in (any::<bool>(), any::<bool>(), 0..2_usize),
        share in 0.02..0.98_f64,
        (after, along) in (5.0..30.0_f64, -20.0..30.0_f64),
        (pace, speed) in (0.5..3.0_f64, 4.0..12.0_f64),
        reference in -0.2..0.2_f64,
        rear_axle in prop::option::of(0.8..1.4_f64),
        path in prop::sample::select(vec![
            "straight 60 m; turn left { radius: 9 m, clothoid: 20.62 deg, arc: 48.76 deg }; straight 60 m",
            "straight 50 m; clothoid 10 m to radius 40 m right; arc 60 deg; clothoid 10 m to straight; straight 60 m",
            "arc 200 deg radius 60 m left",
        ]),
    ) {
        let walks = format!("scripted {{ speed: {pace} m/s }}");
        let dummy = dummy_along(&walks, (far, against), (along, reference), (share, after));
        let axle = rear_axle.map_or(String::new(), |axle| format!("follows by rear axle {axle} m behind centre;"));
        let text = format!("
scenario meets {{
  road {{
    path {{ {path} }}
    lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked {{ at: 60 m }}
  }}
  vehicle av {{ controller constant_speed; speed {speed} m/s; size 4.4 m x 1.8 m; lane {lane}; {axle} }}
{dummy}
  horizon 300 s
  step 0.01 s
  end on collision
}}");
        // In a tight bend it may be a flank that they would be hit by at first.
        if let Err(error) = planned(&text) {
            prop_assert!(error.contains("nowhere beside its lane") && path.contains("9 m"), "{error}\n{text}");
            return Ok(());
        }
        let found = measured(&text);
        let point = found.of("impact_point").expect("it is hit at the front");
        // Between two steps who walks goes straight on, as they stood at the beginning.
        prop_assert!((point - share).abs() < 1e-3, "{point} instead of {share}\n{text}");
        let (time, walked) = (found.ending.1, after / pace);
        prop_assert!((time - walked).abs() < 1e-3, "{time} s instead of {walked} s\n{text}");
    }
}

/// 10 s of steps of 0.025 s, and then a last one of no duration.
#[test]
fn a_touch_at_the_very_beginning_of_a_step_has_a_point_too() {
    let dummy = dummy_along("scripted { speed: 0.5 m/s }", (false, false), (0.0, 0.0), (0.1, 5.0));
    let found = measured(&format!(
        "scenario meets {{
  road {{
    path {{ straight 60 m; turn left {{ radius: 9 m, clothoid: 20.62 deg, arc: 48.76 deg }}; straight 60 m }}
    lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked {{ at: 60 m }}
  }}
  vehicle av {{ controller constant_speed; speed 4 m/s; size 4.4 m x 1.8 m; lane 0 }}
{dummy}
  horizon 300 s
  end on collision
}}"
    ));
    assert!((found.ending.1 - 10.0).abs() < 1e-9, "{:?}", found.ending);
    let point = found.of("impact_point").unwrap();
    assert!((point - 0.1).abs() < 1e-3, "{point}");
}
