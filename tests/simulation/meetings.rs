//! Who is to meet a vehicle is hit where the scenario says, whatever the step, the sides, the speeds and the starts are.

use proptest::prelude::*;

use crate::support::text::{measured, of};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_vehicle_that_keeps_its_speed_hits_where_it_is_said(
        speed in 2.0..25.0_f64,
        pace in 0.5..6.0_f64,
        share in 0.0..1.0_f64,
        accelerates in prop::option::of(0.1..2.0_f64),
        delay in 0.0..2.0_f64,
        start in 3.5..12.0_f64,
        far in any::<bool>(),
        lane in 0..2_usize,
        along in -30.0..30.0_f64,
        reference in -0.2..0.2_f64,
        given in prop::option::of(0.0..100.0_f64),
        step in prop::sample::select(vec![0.01, 0.025, 0.05]),
        disc in any::<bool>(),
    ) {
        // A disc that is not hit by its middle is hit at the corner.
        let reference = if disc { 0.0 } else { reference };
        // Far enough out for the slowest to be in time.
        let needed = speed * (start + 10.0 + 2.0) / pace + 2.0 * speed + speed * 2.0 * accelerates.unwrap_or(0.0) / pace + 40.0;
        let starts = given.map_or(String::new(), |more| format!("start {} m before crossing;", needed + more));
        prop_assume!(needed + given.unwrap_or(0.0) < 3000.0);
        let accelerates = accelerates.map_or(String::new(), |way| format!(", acceleration_way: {way} m"));
        let side = if far { "from far side;" } else { "" };
        let shape = if disc { "radius 0.3 m" } else { "size 0.6 m x 0.5 m" };
        let behind = if reference < 0.0 { "behind" } else { "ahead of" };
        let text = format!("
scenario meets {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }}
  vehicle av {{ controller constant_speed; speed {speed} m/s; size 4.4 m x 1.8 m; lane {lane}; {starts} }}
  pedestrian dummy {{
    model scripted {{ speed: {pace} m/s, delay: {delay} s{accelerates} }}
    {shape}; {side}
    start {start} m from lane centre
    along {along} m
    goal 10 m beyond kerb
    reference {} m {behind} centre
    meets av at {}
  }}
  horizon 3000 s
  step {step} s
  end on collision
}}", reference.abs(), share);
        let point = of(&text, "impact_point").expect("it is hit at the front");
        prop_assert!((point - share).abs() < 1e-3, "{point} instead of {share}\n{text}");
    }
}

/// Somebody who walks so (`scripted { … }`) along the lane of their side for 31 m, from `along` m on, and is hit at a share of the width after so much (m); their
/// reference point is so far (m) ahead of their centre.
pub fn dummy_along(
    model: &str,
    (far, against): (bool, bool),
    (along, reference): (f64, f64),
    (share, after): (f64, f64),
) -> String {
    let way = if against { "against" } else { "with" };
    let side = if far { "from far side;" } else { "" };
    let behind = if reference < 0.0 { "behind" } else { "ahead of" };
    format!(
        "  pedestrian dummy {{
    model {model}
    size 0.6 m x 0.5 m; {side}
    along {along} m
    goal 31 m further
    reference {} m {behind} centre
    walks {way} traffic
    meets av at {share} after {after} m
  }}",
        reference.abs()
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn who_walks_along_a_lane_is_hit_where_and_when_it_is_said(
        speed in 4.0..25.0_f64,
        pace in 0.5..3.9_f64,
        share in 0.0..1.0_f64,
        accelerates in prop::option::of(0.1..2.0_f64),
        after in 3.0..30.0_f64,
        far in any::<bool>(),
        against in any::<bool>(),
        lane in 0..2_usize,
        along in -30.0..30.0_f64,
        reference in -0.2..0.2_f64,
        step in prop::sample::select(vec![0.01, 0.025, 0.05]),
    ) {
        let gets_faster = accelerates.map_or(String::new(), |way| format!(", acceleration_way: {way} m"));
        let walks = format!("scripted {{ speed: {pace} m/s{gets_faster} }}");
        let dummy = dummy_along(&walks, (far, against), (along, reference), (share, after));
        let text = format!("
scenario meets {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }}
  vehicle av {{ controller constant_speed; speed {speed} m/s; size 4.4 m x 1.8 m; lane {lane} }}
{dummy}
  horizon 300 s
  step {step} s
  end on collision
}}");
        let found = measured(&text);
        let point = found.of("impact_point").expect("it is hit at the front");
        prop_assert!((point - share).abs() < 1e-9, "{point} instead of {share}\n{text}");
        // `with` and `against` are about the lane of the dummy's own side.
        let comes_towards = against != (usize::from(far) != lane);
        let closing = if comes_towards { speed + pace } else { speed - pace };
        let hit = found.of("impact_speed").expect("it is hit");
        prop_assert!((hit - closing).abs() < 1e-9, "{hit} instead of {closing}\n{text}");
        let walked = (after + accelerates.unwrap_or(0.0)) / pace;
        let time = found.ending.1;
        prop_assert!((time - walked).abs() < 1e-6, "{time} s instead of {walked} s\n{text}");
    }
}

/// A pair that does not cross is followed, and neither passes anything of the other.
#[test]
fn who_walks_along_a_lane_passes_nothing_of_it() {
    let found = |along: &str, controller: &str| {
        measured(&format!(
            "
scenario follows {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }}
  vehicle av {{ controller {controller}; speed 30 km/h; size 4.4 m x 1.8 m; start 60 m before crossing }}
  pedestrian walker {{ model scripted; walks with traffic; goal 20 m further; {along} }}
}}"
        ))
    };
    let crossing =
        ["pet", "pet_area", "gap_accepted", "tta_at_entry", "crossing_duration", "pedestrian_delay"];
    for (along, controller, follows) in [
        // In the lane before the car, on the pavement beside it, and a person whom it runs into.
        ("start 0.45 m from lane centre", "yielding", true),
        ("start 3 m from lane centre", "yielding", false),
        // From one side of the lane's centre to the other nobody passes it who walks along it.
        ("start -0.01 m from lane centre", "yielding", true),
    ] {
        let found = found(along, controller);
        for metric in crossing {
            assert_eq!(found.of(metric), None, "{metric}, {along}");
        }
        assert_eq!(found.of("passed_first"), Some(0.0), "{along}");
        assert_eq!(found.of("collision"), Some(0.0), "{along}");
        assert!(found.of("min_distance").unwrap() > 0.0);
        for metric in ["time_headway", "min_ttc", "drac"] {
            assert_eq!(found.of(metric).is_some(), follows, "{metric}, {along}");
        }
    }
    let hit = found("start 0.45 m from lane centre", "constant_speed");
    assert_eq!((hit.of("collision"), hit.of("min_ttc")), (Some(1.0), Some(0.0)));
    assert!(hit.of("time_headway").is_some_and(|headway| headway < 1e-3));
    assert!((hit.of("impact_point").unwrap() - 0.25).abs() < 1e-9);
    assert!((hit.of("impact_speed").unwrap() - (30.0 / 3.6 - 1.4)).abs() < 1e-9);
    // A collision is one, whatever else there is to pass.
    assert_eq!((hit.of("pet"), hit.of("gap_accepted")), (Some(0.0), Some(0.0)));
}

#[test]
fn a_flank_is_no_front() {
    let text = "
scenario walks_into_it {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }
  vehicle av { controller constant_speed; speed 20 km/h; size 4.4 m x 1.8 m }
  pedestrian walker { model scripted { speed: 1.4 m/s }; start 4 m from lane centre; appears when time_to_arrival(av.front) = 2.1 s }
}";
    assert_eq!(of(text, "collision"), Some(1.0));
    assert_eq!(of(text, "impact_point"), None);
    assert!(of(text, "impact_speed").is_some_and(|speed| speed > 1.4));
}
