//! Pedestrians that would appear where there is no room, or before the run begins: errors of their runs, and left out by blocks.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::support::program::{code, scenario_runner, stderr, stdout};

fn folder(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.scn"), text).unwrap();
    folder
}

fn results(folder: &Path) -> Value {
    let text = fs::read_to_string(folder.join("r.json")).unwrap();
    serde_json::from_str::<Value>(&text).unwrap()["suites"][0].clone()
}

const RUN: [&str; 4] = ["a.scn", "--no-progress", "--json", "r.json"];

/// A car is on the crossing from 4.775 s to 5.225 s; a pedestrian that appears in its lane then is inside it.
const IN_THE_CAR: &str = "scenario street {
  road { lane_width 4 m; speed_limit 50 km/h; crossing unmarked }
  vehicle av { controller constant_speed; size 4 m x 2 m; speed 10 m/s; start 50 m before crossing }
  pedestrian walker { model scripted { speed: 1 m/s }; radius 0.25 m; start 0.5 m from lane centre; appears at LATE }
  horizon 20 s
  end on collision
  WHAT
}
";

#[test]
fn who_appears_inside_a_vehicle_is_an_error_of_the_run_and_no_collision() {
    let text = |late: &str| IN_THE_CAR.replace("LATE", late).replace("WHAT", "expect { no collision }");
    let inside = folder(&text("5 s"));
    let output = scenario_runner(inside.path(), &RUN);
    let said = stdout(&output);
    assert_eq!(code(&output), 100, "{said}");
    let words = [
        "at 5 s pedestrian `walker` appears inside vehicle `av`",
        "let it appear at another place or time",
        "replay: ",
    ];
    assert!(words.iter().all(|words| said.contains(words)), "{said}");
    let trial = &results(inside.path())["trials"][0];
    assert!(!trial.to_string().contains("\"collision\":1"), "{trial}");
    // What is replayed is the same error.
    let replayed = scenario_runner(inside.path(), &["replay", "a/street/rep=1", "a.scn"]);
    assert_eq!(code(&replayed), 100);
    assert!(stderr(&replayed).contains(words[0]), "{}", stderr(&replayed));
    // A second later the car is gone.
    let behind = folder(&text("6 s"));
    assert_eq!(code(&scenario_runner(behind.path(), &RUN)), 0);
}

#[test]
fn appearing_inside_a_person_is_an_error_of_the_run() {
    let text = |late: &str| {
        format!(
            "scenario crowded {{
  road {{ lane_width 4 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller yielding; speed 10 m/s; start 80 m before crossing }}
  pedestrian first {{ model scripted {{ speed: 1 m/s, stop_after: 1 m, stop_for: 10 s }}; start 4 m from lane centre; appears at 0 s }}
  cyclist second {{ model scripted {{ speed: 4 m/s }}; start 3 m from lane centre; appears at {late} }}
  horizon 40 s
  expect {{ no collision }}
}}
"
        )
    };
    let inside = folder(&text("5 s"));
    let output = scenario_runner(inside.path(), &RUN);
    assert_eq!(code(&output), 100);
    let said = stdout(&output);
    assert!(said.contains("at 5 s cyclist `second` appears inside pedestrian `first`"), "{said}");
    // Once the first has gone on there is room.
    let later = folder(&text("20 s"));
    assert_eq!(code(&scenario_runner(later.path(), &RUN)), 0);
}

#[test]
fn a_search_leaves_out_encounters_that_there_are_not_and_says_how_many() {
    let block = "vary late in [3 s, 7 s]
}
search nearest {
  in street
  minimise min_distance
  over late in 4.6 s .. 5.4 s
  budget 9 evaluations, by grid
";
    let folder = folder(&IN_THE_CAR.replace("LATE", "late").replace("WHAT", block));
    let output = scenario_runner(folder.path(), &[&RUN[..], &["--html", "r.html"]].concat());
    let said = stdout(&output);
    assert_eq!(code(&output), 0, "{said}{}", stderr(&output));
    // Those from 4.8 s to 5.2 s.
    let words = "5 runs are left out, since there is no such encounter";
    assert!(said.contains(words), "{said}");
    assert!(fs::read_to_string(folder.path().join("r.html")).unwrap().contains(words));
    let search = &results(folder.path())["blocks"][0]["result"]["search"];
    assert_eq!(search["left_out"], 5);
    let evaluations = search["found"][0]["evaluations"].as_array().unwrap();
    assert_eq!(evaluations.iter().filter(|one| one[1].is_null()).count(), 5, "{evaluations:?}");
}

#[test]
fn an_estimate_is_of_the_encounters_that_there_are() {
    // Between 4 s and 6 s, 0.45 s of which are inside the car: of the others half come before it, and are hit.
    let block = "draw late from uniform(4 s, 6 s)
}
estimate hit {
  of street
  event collision
  budget 1000 runs, by crude
  claim <= 0.43
";
    let folder = folder(&IN_THE_CAR.replace("LATE", "late").replace("WHAT", block));
    let output = scenario_runner(folder.path(), &RUN);
    let said = format!("{}{}", stdout(&output), stderr(&output));
    let estimate = &results(folder.path())["blocks"][0]["result"]["estimate"];
    let warning = estimate["warnings"][0].as_str().unwrap_or_else(|| panic!("{estimate}: {said}"));
    let left_out: f64 = warning.split(' ').next().unwrap().parse().unwrap();
    assert!((185.0..265.0).contains(&left_out) && warning.contains("encounters are left out"), "{warning}");
    assert!(said.contains("encounters are left out"), "{said}");
    assert!(said.contains(&format!("of {} runs that count", 1000.0 - left_out)), "{said}");
    // All that come before the car's rear are hit.
    let (value, nominal) = (estimate["value"].as_f64().unwrap(), estimate["nominal_runs"].as_f64().unwrap());
    assert_eq!(nominal, 1000.0 - left_out);
    assert_eq!(value, estimate["nominal_hits"].as_f64().unwrap() / nominal, "{estimate}");
    // Of all encounters it would be 0.39, and the claim shown; of those that there are it is a half.
    assert!((0.43..0.57).contains(&value), "{value}");
    assert_eq!(code(&output), 100, "{said}");
}

#[test]
fn an_arrival_that_is_past_is_told_before_anything_runs() {
    let text = |gap: &str, more: &str| {
        format!(
            "scenario walk {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller constant_speed; speed 12 m/s; start 72 m before crossing }}
  pedestrian p {{ model scripted; start 2 m from kerb; appears when time_to_arrival(av) = {gap} }}
  {more}
  expect {{ min_distance >= 0 m }}
}}
"
        )
    };
    let refused = |text: &str, words: &[&str]| {
        let folder = folder(text);
        let output = scenario_runner(folder.path(), &RUN);
        assert_eq!(code(&output), 3, "{}", stdout(&output));
        let said = stderr(&output);
        for words in words.iter().chain(&["error[E0518]", "leave `start` of `av` out"]) {
            assert!(said.contains(words), "{words}: {said}");
        }
    };
    let at_start = "a time to arrival of 9 s, and `av` is 6 s away at the start";
    refused(&text("9 s", ""), &[at_start, "in a/walk"]);
    // The value that is past, and not the others.
    refused(&text("gap", "vary gap in [5 s, 9 s]"), &[at_start, "in a/walk/gap=9s"]);
    refused(
        &text("gap", "draw gap from uniform(4 s, 8 s)\n  repeat 100"),
        &["of the 100 runs to be made", "in a/walk/rep=", "`truncated_normal("],
    );
    // None of these runs has one, though others could.
    let rarely = folder(&text("gap", "draw gap from normal(4 s, 0.4 s)\n  repeat 5"));
    let output = scenario_runner(rarely.path(), &RUN);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}

/// No two trials of different times are the same run.
#[test]
fn trials_of_different_times_to_arrival_have_different_fingerprints() {
    let text = "scenario walk {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller yielding; speed 36 km/h; start 10 s before crossing }
  pedestrian p { model scripted { speed: 1.4 m/s }; start 2 m from kerb; appears when time_to_arrival(av) = tta }
  vary tta in 1 s .. 10 s step 0.25 s
  expect { min_distance >= 0 m }
}
";
    let folder = folder(text);
    let output = scenario_runner(folder.path(), &RUN);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let results = results(folder.path());
    let trials = results["trials"].as_array().unwrap();
    let mut fingerprints: Vec<&str> =
        trials.iter().map(|trial| trial["runs"][0]["fingerprint"].as_str().unwrap()).collect();
    let count = fingerprints.len();
    assert_eq!(count, 37);
    fingerprints.sort_unstable();
    fingerprints.dedup();
    assert_eq!(fingerprints.len(), count);
}

#[test]
fn a_car_sets_off_from_standstill() {
    let text = |speed: &str| {
        format!(
            "scenario sets_off {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller idm_aeb; speed {speed}; start 40 m before crossing }}
  pedestrian p {{ model scripted; start 2 m from kerb; appears at 30 s }}
  vary begins in [0 km/h, 18 km/h]
  expect {{ travel_time >= 0 s }}
}}
"
        )
    };
    let folder = folder(&text("36 km/h from begins"));
    let output = scenario_runner(folder.path(), &[&RUN[..], &["--trace", "traces"]].concat());
    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    for (from, speed) in [("=0km__h", 0.0), ("=18km__h", 5.0)] {
        let traces = fs::read_dir(folder.path().join("traces")).unwrap().map(|one| one.unwrap().path());
        let trace = traces.into_iter().find(|path| path.to_string_lossy().contains(from));
        let text = fs::read_to_string(trace.unwrap_or_else(|| panic!("{from}"))).unwrap();
        let mut lines = text.lines();
        let column = lines.next().unwrap().split(',').position(|name| name == "vx_m_s");
        let column = column.unwrap_or_else(|| panic!("{text:.200}"));
        let speeds: Vec<f64> = lines
            .filter(|line| line.contains(",av,"))
            .map(|line| line.split(',').nth(column).unwrap().parse().unwrap())
            .collect();
        assert_eq!(speeds[0], speed);
        assert!(speeds.iter().copied().fold(0.0, f64::max) > 9.5, "{from}");
    }
}
