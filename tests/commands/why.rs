//! `why KEY`: the story of a run as users read it, and what it must not claim.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::program::{code, scenario_runner, stderr, stdout};
use serde_json::Value;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What is said of the only run of a file, with more arguments.
fn why(text: &str, more: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.scn"), text).unwrap();
    let output = scenario_runner(folder.path(), &[&["why", "a/drive/rep=1", "a.scn"], more].concat());
    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    stdout(&output)
}

/// A car that keeps its speed and meets somebody.
fn drive(appears: &str, horizon: &str, expect: &str) -> String {
    format!(
        "scenario drive {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller constant_speed; speed 36 km/h; start 60 m before crossing }}
  pedestrian walker {{
    model scripted {{ speed: 1.5 m/s }}
    start 1 m from kerb
    appears {appears}
  }}
  horizon {horizon}
  expect {{ {expect} }}
}}
"
    )
}

#[test]
fn a_failing_run_has_a_story() {
    for (name, key) in
        [("stands", "zebra_unsafe/stands_in_lane/tta=6s/rep=1"), ("late", "zebra_unsafe/late_walker/rep=1")]
    {
        let output = scenario_runner(root(), &["why", key]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let said = stdout(&output);
        let lines = said.lines().count();
        assert!((10..=20).contains(&lines), "{lines} lines: {said}");
        insta::assert_snapshot!(format!("why_{name}"), said);
    }
}

/// It stands behind everything else, of runs that fail, where the terminal shows it.
#[test]
fn who_was_where_when_it_failed_is_drawn() {
    let drawn = |folder: &Path, arguments: &[&str]| {
        let plain = stdout(&scenario_runner(folder, arguments));
        let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
        let output = command.args(arguments).current_dir(folder).env("LC_ALL", "C.UTF-8").output().unwrap();
        let said = stdout(&output);
        said.strip_prefix(&plain).unwrap_or_else(|| panic!("{said}\n{plain}")).to_string()
    };
    let picture = drawn(root(), &["why", "zebra_unsafe/stands_in_lane/tta=6s/rep=1"]);
    assert!((5..=10).contains(&picture.lines().count()), "{picture}");
    assert!(picture.lines().all(|line| line.chars().count() <= 76), "{picture}");
    insta::assert_snapshot!("why_picture", picture);
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.scn"), drive("at 15 s", "30 s", "no collision")).unwrap();
    assert_eq!(drawn(folder.path(), &["why", "a/drive/rep=1", "a.scn"]), "", "one that passes");
    let json = ["why", "zebra_unsafe/stands_in_lane/tta=6s/rep=1", "--json"];
    assert_eq!(drawn(root(), &json), "", "and none in JSON");
}

#[test]
fn json_says_the_same_and_every_deceleration() {
    let output = scenario_runner(root(), &["why", "zebra_unsafe/stands_in_lane/tta=6s/rep=1", "--json"]);
    let told: Value = serde_json::from_str(&stdout(&output)).expect("it is JSON");
    assert_eq!(told["standing"], "failed");
    assert_eq!(told["otherwise"].as_array().unwrap().len(), 4);
    let tried = told["otherwise"][1]["came"]["decelerations"].as_array().unwrap();
    // 0 to 10 m/s^2 in steps of 0.5, and halves to 0.01 of the one before the first that is enough.
    assert_eq!(tried.len(), 27);
    assert!(tried[0]["contact"].as_f64().unwrap() > 0.0 && tried[26]["contact"].is_null(), "{tried:?}");
    let replay = scenario_runner(root(), &["replay", "zebra_unsafe/stands_in_lane/tta=6s/rep=1"]);
    let fingerprint = told["fingerprint"].as_str().unwrap();
    assert!(stdout(&replay).contains(&format!("fingerprint  {fingerprint}")), "it is the same run");
}

#[test]
fn a_run_that_passes_has_its_margins_and_nothing_otherwise() {
    let said = why(&drive("at 15 s", "30 s", "no collision; max_deceleration <= 2 m/s^2"), &[]);
    assert!(said.starts_with("a/drive/rep=1: this run passes\n"), "{said}");
    assert!(
        said.contains("fulfils `max_deceleration <= 2 m/s^2`: max_deceleration 0 m/s^2 (+2 m/s^2)"),
        "{said}"
    );
    assert!(!said.contains("with av") && !said.contains("nearest"), "{said}");
}

/// A run that its horizon ended has not passed, whatever it came to so far.
#[test]
fn who_was_cut_off_has_not_passed() {
    let said = why(&drive("at 1 s", "2 s", "no collision; max_deceleration <= 2 m/s^2"), &[]);
    assert!(said.contains("it ended before somebody was met"), "{said}");
    assert!(!said.contains("this run passes") && said.contains("time is up; it was not over for"), "{said}");
    let json = why(&drive("at 1 s", "2 s", "no collision"), &["--json"]);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["standing"], "cut_off", "{json}");
    assert!(!json["cut_off"].is_null());
}

#[test]
fn what_does_not_apply_is_said() {
    let said = why(&drive("at 0 s", "30 s", "pet >= 30 s"), &[]);
    assert!(said.contains("with av braking 0.5 s earlier: does not apply: av did not brake"), "{said}");
    assert!(
        said.contains("with walker 0.2 s later: does not apply: walker is there from the start"),
        "{said}"
    );
    // A criterion that does not exist is not passed.
    assert!(said.contains("with nobody there: no contact, and nothing that is asked applies then"), "{said}");
}

#[test]
fn the_nearest_run_that_passed_is_found_among_results() {
    let folder = tempfile::tempdir().unwrap();
    let text = drive("when time_to_arrival(av) = tta", "30 s", "pet >= 1.5 s")
        .replace("start 60 m before crossing", "start 120 m before crossing")
        .replace("  horizon", "  vary tta in [2 s, 3 s, 4 s, 9 s, 12 s]\n  horizon");
    fs::write(folder.path().join("a.scn"), text).unwrap();
    let results = scenario_runner(folder.path(), &["a.scn", "--json", "results.json"]);
    let read = fs::read_to_string(folder.path().join("results.json")).unwrap();
    let read: Value = serde_json::from_str(&read).unwrap();
    let runs = read["suites"][0]["trials"].as_array().unwrap().iter();
    let holds: Vec<(String, bool)> = runs
        .map(|trial| &trial["runs"][0])
        .map(|run| {
            (run["key"].as_str().unwrap().to_string(), run["criteria"][0]["holds"] == Value::Bool(true))
        })
        .collect();
    let tta = |key: &str| -> f64 {
        let part = key.split('/').find_map(|part| part.strip_prefix("tta=")).unwrap();
        part.trim_end_matches('s').parse().unwrap()
    };
    let failing: Vec<&String> = holds.iter().filter(|one| !one.1).map(|one| &one.0).collect();
    assert!(!failing.is_empty() && failing.len() < 5, "{holds:?}{}", stdout(&results));
    for key in failing {
        let passing = holds.iter().filter(|one| one.1);
        let distance = |one: &&(String, bool)| (tta(&one.0) - tta(key)).abs();
        let nearest = passing.min_by(|one, other| distance(one).total_cmp(&distance(other))).unwrap();
        let said = scenario_runner(folder.path(), &["why", key, "a.scn", "--among", "results.json"]);
        let expected = format!("nearest run that passed: {}, with tta ", nearest.0);
        assert!(stdout(&said).contains(&expected), "{expected}{}", stdout(&said));
    }
}

#[test]
fn wrong_input_is_refused_as_by_replay() {
    let arguments: [&[&str]; 4] = [
        &["zebra/scripted/tta=6s/rep=9"],
        &["nothing/x"],
        &["zebra/scripted/tta=6s/rep=1", "suites/none.suite"],
        &["zebra/scripted/tta=6s/rep=1", "--set", "tto=4s"],
    ];
    for arguments in arguments {
        let [why, replay] =
            ["why", "replay"].map(|command| scenario_runner(root(), &[&[command], arguments].concat()));
        assert_eq!(code(&why), code(&replay), "{}", stderr(&why));
        assert_eq!(stderr(&why).replace("runner why", "runner replay"), stderr(&replay));
        assert!(code(&why) != 0);
    }
    let none = scenario_runner(root(), &["why", "zebra/scripted/tta=6s/rep=1", "--among", "none.json"]);
    assert!(code(&none) == 2 && stderr(&none).contains("`--among` takes what"), "{}", stderr(&none));
}
