//! What of a road may vary, end to end: the radius of a bend, the gradient, the friction, the amber of a signal, the station of a crossing
//! and the share of a vehicle's front that is hit are varied, searched, and what a search found is tuned for.

use std::fs;

use serde_json::Value;

use crate::support::program::{code, scenario_runner, stderr, stdout};

const LANES: &str = "lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h";
const WALKS: &str = "model scripted; start 2 m from kerb; appears when time_to_arrival(av) = 3 s";

/// Runs a scenario in which `x` varies between two values, a search over it, and a tune on what that kept.
fn varied_searched_and_tuned(what: &str, (low, high): (&str, &str), road: &str, person: &str, car: &str) {
    // CARLA's agent does not mind amber.
    let (controller, parameter) = match what {
        "an amber" => ("yielding", "deceleration in 1 m/s^2 .. 3 m/s^2"),
        _ => ("carla_behavior", "braking_distance in 4 m .. 25 m"),
    };
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        "scenario s {{
  vary x in [{low}, {high}]
  road {{ {road} }}
  vehicle av {{ controller {controller}; speed 30 km/h; {car} }}
  pedestrian p {{ {person} }}
  expect {{ min_distance >= 0 m undefined passes }}
}}
search closest {{ in s; minimise min_distance; over x in {low} .. {high}; budget 4 evaluations, 3 random first; repeat 1; keep min_distance < 100 m }}
tune braking {{ on closest; over av.controller.{parameter}; minimise mean(max_deceleration); budget 3 evaluations, 2 random first }}
"
    );
    fs::write(folder.path().join("v.scn"), &text).unwrap();
    let ran = scenario_runner(folder.path(), &["v.scn", "--json", "r.json", "--no-progress"]);
    assert_eq!(code(&ran), 0, "{what}\n{text}\n{}{}", stdout(&ran), stderr(&ran));
    let results: Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("r.json")).unwrap()).unwrap();
    let suite = &results["suites"][0];
    let fingerprints: Vec<String> = suite["trials"]
        .as_array()
        .unwrap()
        .iter()
        .map(|trial| trial["runs"][0]["fingerprint"].to_string())
        .collect();
    assert_eq!(fingerprints.len(), 2, "{what}");
    assert_ne!(fingerprints[0], fingerprints[1], "{what} changes nothing");
    let blocks = suite["blocks"].as_array().unwrap();
    let best = &blocks[0]["result"]["search"]["found"][0]["best"][0];
    assert_eq!(best[0], "x", "{what}: {best}");
    let unit =
        |text: &str| text.split_once(' ').map_or(1.0, |(_, unit)| if unit == "%" { 0.01 } else { 1.0 });
    let number = |text: &str| text.split(' ').next().unwrap().parse::<f64>().unwrap() * unit(text);
    let found = best[1].as_f64().unwrap();
    let within = found >= number(low) - 1e-9 && found <= number(high) + 1e-9;
    assert!(within, "{what}: {found} is not in {low} .. {high}");
    let tune = &blocks[1]["result"]["tune"];
    assert!(tune["cases"].as_u64().unwrap() >= 1, "{what}: nothing to tune on");
    assert!(tune["chosen"]["point"][0].as_f64().is_some(), "{what}: {tune}");
}

const FROM: &str = "start 40 m before crossing";

#[test]
fn the_radius_of_a_bend() {
    let road = format!(
        "path {{ straight 40 m; arc 60 deg radius x left; straight 60 m }}; {LANES}; crossing zebra {{ at: 50 m }}"
    );
    varied_searched_and_tuned("a radius", ("15 m", "30 m"), &road, WALKS, FROM);
}

#[test]
fn the_gradient_and_the_friction() {
    let road = |said: &str| format!("{LANES}; {said}; crossing zebra");
    varied_searched_and_tuned("a gradient", ("-6 %", "6 %"), &road("gradient x"), WALKS, FROM);
    varied_searched_and_tuned("a friction", ("0.1", "0.3"), &road("friction x"), WALKS, FROM);
}

#[test]
fn the_amber_of_a_signal() {
    let road = format!(
        "{LANES}; crossing signalised {{ cycle: 60 s, pedestrian_green: 15 s, pedestrian_green_from: 12 s, amber: x }}"
    );
    let person = "model scripted; start 2 m from kerb";
    varied_searched_and_tuned("an amber", ("0 s", "5 s"), &road, person, "start 100 m before crossing");
}

#[test]
fn the_station_of_a_crossing() {
    let road = format!("{LANES}; crossing zebra; crossing school zebra {{ width: 3 m, at: x }}");
    let person = format!("{WALKS}; crosses school");
    varied_searched_and_tuned("a station", ("20 m", "40 m"), &road, &person, FROM);
}

#[test]
fn the_share_of_the_front_that_is_hit() {
    let road = format!("{LANES}; crossing zebra");
    let person = "model scripted; start 4 m from lane centre; meets av at x";
    varied_searched_and_tuned("a share", ("25 %", "75 %"), &road, person, FROM);
}
