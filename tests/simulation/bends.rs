//! Roads that bend, from their text to what is measured: a path that is straight is a straight road, mirror images are run as mirror images,
//! whoever is to be hit in a turn is hit there, and what cannot be is an error.

use std::path::Path;
use std::sync::{Arc, Mutex};

use files::Memory;
use models::standard;
use proptest::prelude::*;
use results::Requests;
use runner::plan::{Plan, plan};
use runner::run::{FreeFlows, Unwatched, road_users, run_case};
use scenario::World;
use sim::{Command, Controller, ControllerError, Driver, Observation, Schedule, StopReason, simulate};

use crate::support::text::{loaded, measured, of};

fn assert_alike(one: &str, other: &str, tolerance: f64) -> usize {
    let (found, expected) = (measured(other), measured(one));
    let (end, ends) = (found.ending, expected.ending);
    assert_eq!(end.0, ends.0, "{other}");
    assert!((end.1 - ends.1).abs() < 1e-6, "{end:?}, not {ends:?}\n{other}");
    for ((name, found), (_, expected)) in found.values.iter().zip(&expected.values) {
        match (found, expected) {
            (Some(found), Some(expected)) => {
                let apart = (found - expected).abs();
                assert!(
                    apart <= tolerance * (1.0 + expected.abs()),
                    "{name}: {found}, not {expected}\n{other}"
                );
            }
            (found, expected) => assert_eq!(found, expected, "{name}\n{other}"),
        }
    }
    expected.values.iter().filter(|(_, value)| value.is_some()).count()
}

/// How the same straight road may be said: with this before its other statements, and the crossing at.
const PATHS: [(&str, &str); 4] = [
    ("", ""),
    ("path { straight 500 m }", ", at: 250.5 m"),
    // Turned by 37° and by 90°, 200 m and more before anybody is there.
    ("path { arc 37 deg radius 60 m left; straight 700 m }", ", at: 400 m"),
    (
        "path { turn right { radius: 9 m, clothoid: 20.62 deg, arc: 48.76 deg }; straight 700 m }",
        ", at: 420.25 m",
    ),
];

#[test]
fn a_path_that_is_straight_is_a_straight_road_wherever_it_points() {
    let mut values = 0;
    // Odd numbers: what is decided where something is exactly reached may be decided a step later for rounding.
    let cars = [
        "controller constant_speed; speed 31.7 km/h; start 51.13 m before crossing",
        "controller carla_behavior; speed 31.7 km/h; start 5.0137 s before crossing",
        "controller yielding; speed 28.3 km/h; lane 1; start 43.719 m before crossing; sees { range: 30 m }",
        "controller careful_human; speed 28.3 km/h",
        "controller idm_aeb; speed 28.3 km/h; sees { range: 61 m, field_of_view: 100 deg }",
        "controller autoware; speed 28.3 km/h; start 67.31 m before crossing",
    ];
    let people = [
        "model scripted { speed: 1.577 m/s }; start 2.113 m from kerb; appears when time_to_arrival(av.front) = 3.0137 s",
        "model scripted { speed: 1.577 m/s }; start 4.113 m from lane centre; from far side; along 1.17 m; appears when time_to_arrival(av) = 4.0137 s",
        "model scripted { speed: 1.577 m/s, acceleration_way: 0.71 m }; size 0.6 m x 0.5 m; start 4 m from lane centre; meets av at 37 %",
        "model scripted { speed: 1.577 m/s }; start 5.113 m from lane centre; turned 21.3 deg left; appears when time_to_arrival(av.front) = 3.0137 s",
        "model social_force { noise: 0 m/s }; start 2.113 m from kerb; along -2.31 m; appears when time_to_arrival(av.front) = 4.0137 s",
    ];
    for car in cars {
        for person in people {
            let texts = PATHS.map(|(path, at)| {
                format!(
                    "scenario a {{
  road {{ {path}; lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra {{ width: 4 m{at} }}
    parked_row vans {{ to: -6.3 m, cars: 3, gap: 1 m, across: -2.9 m, length: 4.5 m, width: 1.8 m }}
    bus stopped {{ along: 14 m, across: 7.1 m }} }}
  vehicle av {{ {car} }}
  pedestrian walker {{ {person} }}
}}"
                )
            });
            for path in &texts[1..] {
                values += assert_alike(&texts[0], path, 1e-9);
            }
        }
    }
    assert!(values > 500, "{values} values were compared");
}

#[test]
fn boxes_beside_a_bend_hide_and_are_hit() {
    let with = |boxes: &str, sees: &str, lane: usize| {
        format!(
            "scenario a {{
  road {{ path {{ straight 40 m; arc 80 deg radius 20 m left; straight 60 m }}; lanes forward, backward; lane_width 3.5 m
    speed_limit 50 km/h; crossing zebra {{ at: 55 m }}; {boxes} }}
  vehicle av {{ controller careful_human; speed 30 km/h; start 50 m before crossing; lane {lane}; {sees} }}
  pedestrian walker {{ model scripted {{ speed: 2.5 m/s }}; from far side; start 1 m from kerb; appears when time_to_arrival(av.front) = 2.6 s }}
}}"
        )
    };
    let row = "parked_row vans { to: -1.5 m, cars: 3, gap: 1 m, across: 6.1 m, length: 4.5 m, width: 1.6 m }";
    let open = measured(&with("", "sees { range: 60 m }", 0)).values;
    let hidden = measured(&with(row, "sees { range: 60 m }", 0)).values;
    assert_ne!(hidden, open, "who comes from behind the row is seen later");
    // Where it blocks nothing it changes nothing: the row is turned with the road, or its cars would stand in the lane.
    assert_eq!(measured(&with(row, "", 0)).values, measured(&with("", "", 0)).values);
    assert_eq!(
        measured(&with("bus outside { along: 5 m, across: -3.1 m }", "", 1)).values,
        measured(&with("", "", 1)).values
    );
}

/// A turn of 90° to a side, and people who come from the inside or the outside of it.
fn turn(left: bool, inside: bool, car: &str, person: &str) -> String {
    let (side, mirror) = if left { ("left", "right") } else { ("right", "left") };
    let far = inside == left;
    let person = person.replace("SIDE", side).replace("MIRROR", mirror);
    format!(
        "scenario a {{
  road {{ path {{ straight 60 m; turn {side} {{ radius: 9 m, clothoid: 20.62 deg, arc: 48.76 deg }}; straight 80 m }}
    lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked {{ at: 75 m }} }}
  vehicle av {{ {car}; size 4.358 m x 1.815 m }}
  pedestrian walker {{ {person}; {} }}
}}",
        if far { "from far side" } else { "from near side" }
    )
}

#[test]
fn a_right_turn_is_run_as_the_mirror_image_of_a_left_one() {
    let (mut values, mut hits) = (0, 0);
    for car in [
        "controller constant_speed; speed 15.3 km/h; start 41.7 m before crossing",
        "controller careful_human; speed 15.3 km/h; start 41.7 m before crossing",
        "controller autoware; speed 15.3 km/h; start 41.7 m before crossing",
        "controller idm_aeb; speed 15.3 km/h; start 41.7 m before crossing; sees { range: 40 m, field_of_view: 90 deg }",
    ] {
        for person in [
            "model scripted { speed: 1.477 m/s }; size 0.6 m x 0.5 m; start 5 m from lane centre; appears when time_to_arrival(av.front) = 3.0137 s",
            "model scripted { speed: 1.477 m/s }; size 0.6 m x 0.5 m; start 6 m from lane centre; turned 12 deg SIDE; meets av at 30 %",
            "model scripted { speed: 1.477 m/s }; start 5 m from lane centre; along -3.1 m; turned 25 deg MIRROR; appears when time_to_arrival(av.front) = 3.2137 s",
        ] {
            for inside in [true, false] {
                let (left, right) = (turn(true, inside, car, person), turn(false, inside, car, person));
                values += assert_alike(&left, &right, 1e-7);
                hits += usize::from(of(&left, "collision") == Some(1.0));
            }
        }
    }
    assert!(values > 200 && hits > 3, "{values} values, {hits} hits");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn a_vehicle_that_keeps_its_speed_hits_in_a_turn_where_it_is_said(
        radius in 7.0..30.0_f64,
        share in 0.0..1.0_f64,
        speed in 2.0..8.0_f64,
        pace in 0.8..3.0_f64,
        start in 4.0..10.0_f64,
        along in -8.0..8.0_f64,
        turned in -30.0..30.0_f64,
        reference in -0.1..0.1_f64,
        left: bool,
        far: bool,
        disc: bool,
    ) {
        // A disc that is not hit by its middle is hit at the corner.
        let (shape, reference) = if disc { ("radius 0.3 m", 0.0) } else { ("size 0.6 m x 0.5 m", reference) };
        let (side, behind) = (if left { "left" } else { "right" }, if reference < 0.0 { "behind" } else { "ahead of" });
        let text = format!("
scenario meets {{
  road {{ path {{ straight 200 m; turn {side} {{ radius: {radius} m, clothoid: 20 deg, arc: 50 deg }}; straight 40 m }}
    lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked {{ at: {} m }} }}
  vehicle av {{ controller constant_speed; speed {speed} m/s; size 4.4 m x 1.8 m }}
  pedestrian dummy {{
    model scripted {{ speed: {pace} m/s, acceleration_way: 1 m }}
    {shape}; from {} side; start {start} m from lane centre; along {along} m; goal 10 m beyond kerb
    turned {} deg {}; reference {} m {behind} centre; meets av at {share}
  }}
  end on collision
}}", 200.0 + radius, if far { "far" } else { "near" }, turned.abs(), if turned < 0.0 { "right" } else { "left" }, reference.abs());
        let found = measured(&text);
        // A dummy that is slow against a car that turns into it is touched by a flank before.
        if let Some(point) = found.of("impact_point") {
            prop_assert!((point - share).abs() < 1e-3, "{point} instead of {share}\n{text}");
        } else {
            prop_assert!(found.of("collision") == Some(1.0) && !(0.2..0.8).contains(&share), "{found:?}\n{text}");
        }
    }

    #[test]
    fn whatever_a_path_is_what_is_measured_is_a_number_or_nothing(
        pieces in prop::collection::vec((0..4_usize, 5.0..60.0_f64, 8.0..200.0_f64, 5.0..80.0_f64, any::<bool>()), 1..6),
        at in 0.0..1.0_f64,
        controller in prop::sample::select(vec!["constant_speed", "yielding", "careful_human", "idm_aeb", "carla_behavior", "autoware"]),
        model in prop::sample::select(vec!["scripted", "carla_walker", "social_force", "jaywalker", "interceptor", "commotions"]),
        lanes in 1..3_usize,
        speed in 3.0..15.0_f64,
        starts in 5.0..80.0_f64,
        start in 0.5..8.0_f64,
        along in -30.0..30.0_f64,
        turned in -50.0..50.0_f64,
        far: bool,
        appears in prop::option::of(0.5..6.0_f64),
    ) {
        let mut length = 0.0;
        let path: Vec<String> = pieces.iter().map(|(kind, long, radius, angle, left)| {
            let side = if *left { "left" } else { "right" };
            length += match kind {
                0 | 1 => *long,
                2 => radius * angle.to_radians(),
                _ => 2.0 * angle.to_radians() / (1.0 / radius + 1.0 / 1500.0),
            };
            match kind {
                0 => format!("straight {long} m"),
                1 => format!("clothoid {long} m to radius {radius} m {side}"),
                2 => format!("arc {angle} deg radius {radius} m {side}"),
                _ => format!("turn {side} {{ radius: {radius} m, clothoid: {angle} deg, arc: {angle} deg }}"),
            }
        }).collect();
        let appears = appears.map_or("appears at 0 s".to_string(), |time| format!("appears when time_to_arrival(av.front) = {time} s"));
        let text = format!("
scenario random {{
  road {{ path {{ {} }}; lanes {lanes}; lane_width 3 m; speed_limit 50 km/h; crossing zebra {{ at: {} m }} }}
  vehicle av {{ controller {controller}; speed {speed} m/s; start {starts} m before crossing; lane {} }}
  pedestrian walker {{ model {model}; from {} side; start {start} m from kerb; along {along} m; turned {} deg {}; {appears} }}
  horizon 20 s
}}", path.join("; "), length * at, lanes - 1, if far { "far" } else { "near" }, f64::abs(turned), if turned < 0.0 { "right" } else { "left" });
        let suite = loaded(&text);
        // What cannot be is told: a road that comes back to itself, somebody who starts inside the car.
        let Ok(plan) = plan(&suite) else { return Ok(()) };
        let case = plan.trial(0).cases.first();
        let requests = Requests::defaults(&standard());
        let Ok(outcome) = run_case(&case, &requests, &FreeFlows::default(), &mut Unwatched) else { return Ok(()) };
        for (request, value) in requests.iter().zip(outcome.metrics.iter()) {
            prop_assert!(value.is_none_or(|value| !value.is_nan()), "{} is no number\n{text}", request.metric.name());
        }
        let value = |name: &str| {
            let index = requests.iter().position(|request| request.metric.name() == name).unwrap();
            outcome.metrics[index]
        };
        prop_assert_eq!(value("collision") == Some(1.0), value("min_distance") == Some(0.0), "{}", text);
        prop_assert!(value("pet").is_none_or(|pet| (0.0..=20.0).contains(&pet)), "{text}");
    }
}

#[test]
fn nobody_has_crossed_who_stands_beside_another_part_of_the_road() {
    // Inside a hairpin, nearer to the leg that the car comes back on: beyond that, but not across the leg that is to be crossed.
    let text = "
scenario hairpin {
  road { path { straight 60 m; arc 180 deg radius 12 m left; straight 60 m }; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { at: 30 m } }
  vehicle av { controller constant_speed; speed 40 km/h; start 40 m before crossing }
  pedestrian walker { model scripted { speed: 1 m/s }; from far side; start 16 m from lane centre }
  finish 0 m
}";
    let found = measured(text);
    let (reason, time) = found.ending;
    // The car is past after 4 s; who walks needs 17.75 s to the far edge of the lane.
    assert_eq!(reason, StopReason::Completed);
    assert!((time - 17.75).abs() < 0.1, "{time} s");
    assert_eq!(found.of("collision"), Some(0.0));
}

#[test]
fn a_car_that_never_comes_and_people_who_never_cross_end_at_the_horizon() {
    let text = |speed: &str, goal: &str| {
        format!(
            "scenario waits {{
  road {{ path {{ straight 60 m; arc 90 deg radius 12 m left; straight 60 m }}; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra {{ at: 70 m }} }}
  vehicle av {{ controller constant_speed; speed {speed}; start 40 m before crossing }}
  pedestrian walker {{ model scripted {{ speed: 1.5 m/s }}; start 2 m from kerb; {goal}; appears when time_to_arrival(av) = 2 s }}
  horizon 30 s
}}"
        )
    };
    let found = measured(&text("0 km/h", ""));
    assert_eq!(
        (found.ending.0, found.of("min_distance"), found.of("pet")),
        (StopReason::Horizon, None, None)
    );
    // Whose goal is in the lane is never across.
    let found = measured(&text("20 km/h", "goal -2 m beyond kerb"));
    assert_eq!((found.ending.0, found.of("crossing_duration")), (StopReason::Horizon, None));
    assert!(found.of("min_distance").is_some());
}

#[test]
fn what_a_path_says_is_written_so_that_it_is_run_again() {
    let text = "
scenario varied {
  vary r in [9 m, 12 m]
  vary place in [84 m, 86 m]
  vary angle in [40 deg, 50 deg]
  road {
    path { straight 55 m + r / 2; clothoid 8 m to radius r right; arc angle; clothoid 8 m to radius 2 * r left; arc angle / 2; clothoid 5 m to straight; turn left { radius: r, clothoid: 10 deg, arc: angle / 2 } }
    lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { at: place }
    box van { along: -10 m, across: -2.8 m, length: 4 m, width: 1.8 m }
  }
  vehicle av { controller careful_human; speed 20 km/h; start 40 m before crossing }
  pedestrian walker { model scripted { speed: 1.5 m/s }; start 2 m from kerb; turned 11 deg right; appears when time_to_arrival(av) = 4 s }
}";
    let suite = loaded(text);
    let plan = plan(&suite).unwrap();
    let requests = Requests::defaults(&standard());
    let mut prints = Vec::new();
    for trial in (0..8).map(|number| plan.trial(number)) {
        let case = trial.cases.first();
        let one = run_case(&case, &requests, &FreeFlows::default(), &mut Unwatched).unwrap();
        let alone =
            runner::plan::standalone(&suite.scenarios[0], &trial.variation, &case.individuals, case.seed)
                .unwrap();
        let written = lang::write_scenario(&alone, &[], &[], std::path::Path::new(""));
        let again = loaded(&written);
        let plan = runner::plan::plan(&again).unwrap();
        let other =
            run_case(&plan.trial(0).cases.first(), &requests, &FreeFlows::default(), &mut Unwatched).unwrap();
        assert_eq!(other.fingerprint, one.fingerprint, "{written}");
        prints.push(one.fingerprint);
    }
    prints.sort();
    prints.dedup();
    assert_eq!(prints.len(), 8, "each of them is another run");
}

#[test]
fn what_cannot_be_a_road_is_told_with_place_numbers_and_cure() {
    let errors_of = |start: &str, road: &str, more: &str| {
        let text = format!(
            "scenario a {{
  {more}
  road {{ {road}; lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h }}
  vehicle av {{ controller yielding; speed 30 km/h; start 20 m before crossing }}
  pedestrian walker {{ model scripted; {start} }}
}}"
        );
        let files = Memory::default().with("a.scn", &*text);
        match lang::load("a.scn".as_ref(), &standard(), &files) {
            Err(failure) => failure
                .diagnostics
                .iter()
                .map(|found| format!("{}: {}; {}", found.code, found.message, found.hints.join("; ")))
                .collect::<Vec<_>>()
                .join("\n"),
            Ok(loaded) => {
                let errors = plan(&loaded.suite).map(|_| ()).expect_err(&text);
                let error = &errors[0];
                let marked: String = error
                    .origin
                    .source_line
                    .chars()
                    .skip(error.origin.column - 1)
                    .take(error.origin.length)
                    .collect();
                format!("`{marked}`: {error}; {}", error.hint.clone().unwrap_or_default())
            }
        }
    };
    let errors = |road: &str, more: &str| errors_of("start 2 m from kerb", road, more);
    let found = [
        errors(
            "path { straight 20 m; clothoid 5 m to radius 5 m left; arc 40 deg }; crossing zebra { at: 10 m }",
            "",
        ),
        errors(
            "path { straight 20 m; turn left { radius: r, clothoid: 20 deg, arc: 40 deg } }; crossing zebra { at: 10 m }",
            "vary r in [9 m, 3 m]",
        ),
        errors("path { straight 20 m; arc 40 deg radius 30 m left }; crossing zebra { at: 50 m }", ""),
        errors("path { straight 20 m; arc 40 deg }; crossing zebra { at: 5 m }", ""),
        errors("path { straight 20 m; turn left { radius: 9 m } }; crossing zebra { at: 5 m }", ""),
        errors("path { straight 20 m }; crossing zebra", ""),
        errors("path { }; crossing zebra { at: 5 m }", ""),
        errors("crossing zebra { at: 5 m }", ""),
        errors(
            "path { straight 50 m; arc 300 deg radius 15 m left; straight 60 m }; crossing zebra { at: 5 m }",
            "",
        ),
        errors(
            "path { straight 50 m; arc 10 * a radius 15 m left }; crossing zebra { at: 5 m }",
            "vary a in uniform(1 deg, 80 deg) 3 times",
        ),
        // Where somebody starts who is beyond their goal already: said, and by what varies.
        errors_of(
            "start -9 m from kerb",
            "path { straight 20 m; arc 40 deg radius 30 m left }; crossing zebra { at: 25 m }",
            "",
        ),
        errors_of(
            "start out from kerb",
            "path { straight 20 m; arc 40 deg radius 30 m left }; crossing zebra { at: 25 m }",
            "vary out in [2 m, -9 m]",
        ),
    ];
    insta::assert_snapshot!(found.join("\n"));
}

/// The cells of a shipped suite with a car that keeps its speed.
fn plan_of_cells(suite: &str, is_wanted: impl Fn(&str) -> bool) -> Plan {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("suites/{suite}.suite"));
    let loaded = lang::load(&path, &standard(), &files::Disk)
        .unwrap_or_else(|failure| panic!("{:?}", failure.diagnostics));
    let mut suite = loaded.suite;
    suite.scenarios.retain(|scenario| is_wanted(&scenario.name));
    let keeps = standard().controllers().get("constant_speed").unwrap().clone();
    for car in suite.scenarios.iter_mut().flat_map(|scenario| &mut scenario.vehicles) {
        car.controller.first = keeps.clone().into();
    }
    plan(&suite).unwrap_or_else(|errors| panic!("{}", errors[0]))
}

/// However a target is moved beside the cells, it is met at the middle of the front.
#[test]
fn cells_that_are_varied_are_hit_in_the_middle() {
    let plan = plan_of_cells("euro_ncap_robustness", |_| true);
    let requests = Requests::defaults(&standard());
    let index = requests.iter().position(|request| request.metric.name() == "impact_point").unwrap();
    for number in 0..plan.len() {
        let case = plan.trial(number).cases.first();
        let outcome = run_case(&case, &requests, &FreeFlows::default(), &mut Unwatched).unwrap();
        let point = outcome.metrics[index].unwrap_or_else(|| panic!("{} is not hit by the front", case.key));
        assert!((point - 0.5).abs() < 1e-3, "{}: {point}", case.key);
    }
    assert_eq!(plan.len(), 96 + 36 + 24);
}

/// What the shipped cells of Euro NCAP's CPTA come to under a controller: where the dummy is hit, and the car's heading (degrees against the road that it
/// left) when the middle of its front comes to the dummy's near flank.
#[test]
fn cars_that_turn_hit_the_dummy_of_euro_ncap_where_each_cell_says() {
    let plan = plan_of_cells("euro_ncap_vru", |scenario| scenario.starts_with("cpta"));
    let requests = Requests::defaults(&standard());
    let index = requests.iter().position(|request| request.metric.name() == "impact_point").unwrap();
    let (mut cells, mut headings) = (0, Vec::new());
    for number in 0..plan.len() {
        let trial = plan.trial(number);
        let case = trial.cases.first();
        let outcome = run_case(&case, &requests, &FreeFlows::default(), &mut Unwatched).unwrap();
        let share =
            trial.variation.iter().find(|one| one.name == "impact").unwrap().value.as_number().unwrap();
        let point = outcome.metrics[index].unwrap_or_else(|| panic!("{} is not hit by the front", case.key));
        assert!((point - share).abs() < 1e-3, "{}: {point}, not {share}", case.key);
        cells += 1;
        // The dummy's line is parallel to the road that the car leaves, as far from it as the protocol says.
        let (car, dummy) = (&case.world.vehicles[0], &case.world.pedestrians[0]);
        let beside = dummy.start.y;
        assert!((dummy.goal.y - beside).abs() < 2e-3, "{}: {:?} to {:?}", case.key, dummy.start, dummy.goal);
        let wanted = if beside > 0.0 { 11.25 } else { -7.75 };
        assert!((beside - wanted).abs() < 1e-3, "{}: {beside} m beside the lane", case.key);
        let path = car.path(&case.world.road);
        let front = |place: f64| {
            let (centre, ahead) = path.pose(place);
            (centre + ahead * (car.length / 2.0), libm::atan2(ahead.y, ahead.x).to_degrees().abs())
        };
        let reaches = (0..40_000)
            .map(|step| f64::from(step) * 1e-3 - 30.0)
            .find(|place| front(*place).0.y.abs() >= beside.abs() - 0.25);
        let (met, heading) = front(reaches.unwrap());
        // From its start the dummy walks 9.5 m or 6 m to there.
        let walks = (met.x - dummy.start.x).abs();
        let long = case.key.contains("far_same") || case.key.contains("near_opposite");
        assert!((walks - if long { 9.5 } else { 6.0 }).abs() < 5e-3, "{}: {walks} m", case.key);
        headings.push(heading);
    }
    assert_eq!(cells, 2 * (3 + 1) * 5);
    headings.sort_by(f64::total_cmp);
    headings.dedup_by(|one, other| (*one - *other).abs() < 0.1);
    assert_eq!(headings.len(), 4, "{headings:?}");
    for (found, published) in headings.iter().zip([60.9, 61.5, 68.6, 78.2]) {
        assert!((found - published).abs() < 0.07, "{found}°, not {published}°");
    }
}

#[test]
fn a_car_that_follows_by_its_rear_axle_swings_its_front_out_of_the_bend() {
    let text = |follows: &str, path: &str, at: &str| {
        format!(
            "scenario a {{
  road {{ {path}; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked {{ {at} }} }}
  vehicle av {{ controller constant_speed; speed 15.3 km/h; start 41.7 m before crossing; {follows} }}
  pedestrian walker {{ model scripted {{ speed: 1.477 m/s }}; start 5 m from lane centre; appears when time_to_arrival(av.front) = 3.9137 s }}
}}"
        )
    };
    let axle = "follows by rear axle 1.3 m behind centre";
    // On a straight road it makes no difference, also where that is said as a path.
    assert_eq!(measured(&text(axle, "", "")), measured(&text("", "", "")));
    assert_alike(&text("", "", ""), &text(axle, "path { straight 300 m }", "at: 200.5 m"), 1e-9);
    // In a left bend somebody who comes from the outside is nearer to the front that swings out.
    let bend = "path { straight 60 m; turn left { radius: 9 m, clothoid: 20.62 deg, arc: 48.76 deg }; straight 80 m }";
    let (centre, rear) =
        (measured(&text("", bend, "at: 70 m")).values, measured(&text(axle, bend, "at: 70 m")).values);
    assert_ne!(centre, rear);
    let setup = |text: &str| plan(&loaded(text)).unwrap().trial(0).cases.first().world.clone();
    let world = setup(&text(axle, bend, "at: 70 m"));
    let (path, lane) = (world.vehicles[0].path(&world.road), world.road.path(0));
    for place in [-5.0, 0.0, 3.0, 9.0] {
        let (centre, ahead) = path.pose(place);
        // The axle is on the lane, and the car points as the lane does there.
        assert!((centre - ahead * 1.3 - lane.point(place - 1.3)).norm() < 1e-12);
        assert!((ahead - lane.heading(place - 1.3)).norm() < 1e-12);
        if (0.0..4.0).contains(&place) {
            assert!(lane.beside(centre + ahead * 2.2) < -0.2, "its front is outside of the lane's centre");
        }
        let moved = (path.point(place + 1e-6) - path.point(place - 1e-6)) / 2e-6;
        assert!((moved * 4.0 - path.velocity(place, 4.0)).norm() < 1e-6);
    }
}

/// Test (f) of the specification, from the text on: whoever meets on a circle meets alike wherever on it that is.
#[test]
fn on_a_circle_every_place_is_like_every_other() {
    let cars = [
        "controller constant_speed; speed 28.3 km/h; start 43.719 m before crossing",
        "controller careful_human; speed 28.3 km/h; start 43.719 m before crossing; lane 1",
        "controller idm_aeb; speed 31.7 km/h; start 5.0137 s before crossing; sees { range: 61 m, field_of_view: 100 deg }",
        "controller yielding; speed 28.3 km/h; start 43.719 m before crossing; follows by rear axle",
        "controller carla_behavior; speed 28.3 km/h; start 43.719 m before crossing; lane 1; follows by rear axle",
    ];
    let people = [
        "model scripted { speed: 1.577 m/s }; start 2.113 m from kerb; appears when time_to_arrival(av.front) = 3.0137 s",
        "model scripted { speed: 1.577 m/s }; start 4.113 m from lane centre; from far side; along -3.17 m; appears at 1.0137 s",
        // Who stands in the lane, at rest on the road.
        "model scripted { speed: 2.577 m/s, stop_after: 2.31 m, stop_for: 60 s }; size 0.6 m x 0.5 m; start 0.7 m from kerb",
    ];
    let mut values = 0;
    for (car, person) in cars.iter().flat_map(|car| people.map(|person| (car, person))) {
        for side in ["left", "right"] {
            // Of 314 m of road the first 60 and the last 60 are driven only towards and away from the others.
            let texts = [62.0, 97.3, 151.9, 203.457, 251.0].map(|at| {
                format!(
                    "scenario a {{
  road {{ path {{ arc 170 deg radius 106 m {side} }}; lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h
    crossing zebra {{ at: {at} m }}; parked van {{ along: -14 m, across: -3.1 m, length: 5 m, width: 2 m }} }}
  finish 20 m; horizon 30 s
  vehicle av {{ {car} }}
  pedestrian walker {{ {person} }}
}}"
                )
            });
            for other in &texts[1..] {
                values += assert_alike(&texts[0], other, 1e-9);
            }
        }
    }
    assert!(values > 1000, "{values} values were compared");
}

/// What a driver is told of how its lane bends, wherever it is.
struct Told {
    seen: Arc<Mutex<Vec<Observation>>>,
}

impl Controller for Told {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.1)
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        self.seen.lock().unwrap().push(seen.clone());
        Ok(Command::Acceleration(2.0 * (10.0 - seen.ego.speed)))
    }
}

/// The road, lane, what follows it, and what is seen.
fn told(road: &str, car: &str) -> (Arc<World>, Vec<Observation>) {
    let text = format!(
        "scenario a {{
  road {{ {road}; lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h }}
  finish 120 m
  vehicle av {{ controller constant_speed; speed 36 km/h; {car} }}
  pedestrian walker {{ model scripted; start 2 m from kerb; appears at 100 s }}
}}"
    );
    let case =
        plan(&loaded(&text)).unwrap_or_else(|errors| panic!("{text}\n{}", errors[0])).trial(0).cases.first();
    let seen = Arc::<Mutex<Vec<Observation>>>::default();
    let mut users = road_users(&case.world, case.seed).unwrap();
    // What perception is shown is handed on by it.
    users.vehicles[0].driver = Driver::Inside(Box::new(Told { seen: seen.clone() }));
    simulate(&case.world, users, &mut Unwatched).unwrap();
    let seen = seen.lock().unwrap().clone();
    (case.world.clone(), seen)
}

#[test]
fn drivers_are_told_how_their_lane_bends() {
    let path = "path { straight 60 m; clothoid 30 m to radius 40 m left; arc 40 deg; clothoid 30 m to straight; straight 20 m
    arc 20 deg radius 25 m right; straight 60 m }; crossing zebra { at: 110 m }; gradient 4 %";
    for car in [
        "start 100 m before crossing",
        "start 100 m before crossing; lane 1",
        "start 100 m before crossing; follows by rear axle",
        "start 100 m before crossing; lane 1; sees { range: 50 m, latency: 0.2 s }",
    ] {
        let (world, seen) = told(path, car);
        let (road, setup) = (&world.road, &world.vehicles[0]);
        let way = setup.path(road);
        let (mut jumps, mut most) = (0, 0);
        assert!(seen.len() > 200, "{car}");
        for one in &seen {
            let (ego, ahead) = (&one.ego, &one.road.curvature_ahead);
            assert_eq!(ego.travelled, -ego.distance_to_crossing);
            assert_eq!(one.road.gradient, Some(if setup.lane == 0 { 0.04 } else { -0.04 }), "{car}");
            assert_eq!(ego.curvature, way.curvature(ego.travelled), "{car}");
            assert!(ahead.is_sorted_by(|one, other| one.0 <= other.0), "{ahead:?}");
            assert!(ahead.iter().all(|(distance, _)| (0.0..=150.0).contains(distance)), "{ahead:?}");
            jumps += ahead.windows(2).filter(|pair| pair[0].0 == pair[1].0).count();
            most = most.max(ahead.len());
            // What the lane is wherever they say something.
            for step in 0..300 {
                let distance = f64::from(step) * 0.5 + 0.25;
                let next = ahead.partition_point(|(at, _)| *at <= distance);
                let before = if next == 0 { (0.0, ego.curvature) } else { ahead[next - 1] };
                let said = match ahead.get(next) {
                    None => before.1,
                    Some(after) => {
                        before.1 + (after.1 - before.1) * (distance - before.0) / (after.0 - before.0)
                    }
                };
                let is = way.curvature(ego.travelled + distance);
                let near_a_jump = ahead.iter().any(|(at, _)| (at - distance).abs() < 1e-6);
                let tolerance = if setup.lane == 0 { 1e-9 } else { 2e-3 };
                assert!(
                    near_a_jump || (said - is).abs() < tolerance,
                    "{car}: {said}, not {is}, {distance} m ahead of {}",
                    ego.travelled
                );
            }
        }
        assert!(jumps > 50 && most >= 6, "{car}: {jumps} jumps, {most} changes at once");
        // All of it lies behind it at the end.
        assert!(seen.last().unwrap().road.curvature_ahead.is_empty(), "{car}");
    }
    let (_, seen) = told("crossing zebra", "start 100 m before crossing");
    let plain = |one: &Observation| {
        one.ego.curvature == 0.0 && one.road.curvature_ahead.is_empty() && one.road.gradient.is_none()
    };
    assert!(seen.iter().all(plain));
    // And is not written.
    let written = serde_json::to_string(&seen[3]).unwrap();
    assert!(["curvature", "gradient"].iter().all(|name| !written.contains(name)), "{written}");
    let (_, seen) = told(path, "start 100 m before crossing");
    let written = serde_json::to_string(&seen[3]).unwrap();
    assert_eq!(serde_json::from_str::<Observation>(&written).unwrap(), seen[3]);
}
