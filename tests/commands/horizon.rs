//! Runs that the horizon ends: nothing that it hides is green, and every report says what it cut off.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// Somebody stops in the lane for half a minute before a car that yields, or does not.
fn scenario(controller: &str, horizon: &str, what: &str, expect: &str) -> String {
    format!(
        "road street {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
scenario waits {{
  road street
  horizon {horizon}
  {what}
  vehicle av {{ controller {controller}; speed 30 km/h; size 4.5 m x 1.8 m }}
  pedestrian walker {{
    model scripted {{ speed: 1.4 m/s, stop_after: 4 m, stop_for: 30 s }}
    start 2 m from kerb
    appears when time_to_arrival(av) = 8 s
  }}
  expect {{ {expect} }}
}}
"
    )
}

fn program(folder: &Path, text: &str, arguments: &[&str]) -> Output {
    std::fs::write(folder.join("a.scn"), text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
    command.current_dir(folder).arg("a.scn").args(arguments).env_remove("CI").output().unwrap()
}

/// The exit code and the only trial.
fn run(text: &str) -> (Option<i32>, Value) {
    let folder = tempfile::tempdir().unwrap();
    let output = program(folder.path(), text, &["--json", "a.json"]);
    let json = std::fs::read_to_string(folder.path().join("a.json"));
    let json = json.unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)));
    let results: Value = serde_json::from_str(&json).unwrap();
    (output.status.code(), results["suites"][0]["trials"][0].clone())
}

fn verdicts(trial: &Value) -> Vec<String> {
    let findings = trial["findings"].as_array().unwrap().iter();
    findings.map(|one| one["verdict"].as_str().unwrap().to_string()).collect()
}

const BRAKES: &str = "yielding";

#[test]
fn a_shorter_horizon_turns_nothing_green() {
    let expect = "time_lost <= 10 s; rate(time_lost > 10 s) <= 5 %; median(time_lost) <= 10 s
      mean(time_lost) <= 10 s; stopped_time <= 10 s; rate(stopped_time > 20 s) <= 5 %
      rate(travel_time >= 40 s) = 0 %; max(time_lost) <= 10 s; rate(crossing_duration <= 20 s) >= 50 %";
    for horizon in ["120 s", "24 s", "12 s"] {
        let (code, trial) = run(&scenario(BRAKES, horizon, "", expect));
        let found = verdicts(&trial);
        assert!(found.iter().all(|verdict| verdict != "passed"), "{horizon}: {found:?}");
        assert_eq!(code, Some(100), "{horizon}");
        let cut_off: Vec<u64> = trial["findings"]
            .as_array()
            .unwrap()
            .iter()
            .map(|one| one["cut_off"].as_u64().unwrap())
            .collect();
        assert_eq!(cut_off.iter().all(|runs| *runs == 1), horizon != "120 s", "{horizon}: {cut_off:?}");
    }
}

#[test]
fn what_is_decided_before_the_horizon_is_judged_as_ever() {
    // Without the pedestrian it takes 20 s to the finish line: 4 s are lost for good.
    let (code, trial) = run(&scenario(BRAKES, "24 s", "", "max_deceleration <= 9 m/s^2; time_lost >= 3 s"));
    assert_eq!((code, verdicts(&trial)), (Some(0), vec!["passed".to_string(), "passed".to_string()]));
}

#[test]
fn who_never_arrives_after_a_collision_has_lost_more_than_any_time() {
    let expect = "rate(time_lost > 10 s) <= 50 %; median(time_lost) <= 10 s; mean(time_lost) <= 10 s";
    let (code, trial) = run(&scenario("constant_speed", "60 s", "end on collision", expect));
    assert_eq!(verdicts(&trial), ["failed", "failed", "inconclusive"]);
    assert_eq!(code, Some(100));
    assert!(trial.get("horizon").is_none());
}

#[test]
fn time_that_is_up_before_the_impact_is_a_warning() {
    let (code, trial) = run(&scenario("constant_speed", "60 s", "end on collision", "no collision"));
    assert_eq!(code, Some(100));
    let impact = trial["runs"][0]["ending"]["time"].as_f64().unwrap();
    let horizon = format!("{:.3} s", impact - 0.5);
    let text =
        scenario("constant_speed", &horizon, "end on collision", "no collision; max_deceleration <= 1 m/s^2");
    let (code, trial) = run(&text);
    assert_eq!(code, Some(0));
    assert_eq!(trial["findings"][0]["untested"]["reason"], "cut_off");
    assert_eq!(trial["findings"][1]["untested"]["reason"], "cut_off", "it might still have braked");
    let course = &trial["horizon"]["on_course"][0];
    assert_eq!((&course["vehicle"], &course["with"]), (&"av".into(), &"walker".into()));
    assert!((course["time"].as_f64().unwrap() - 0.5).abs() < 0.03, "{course}");
    let folder = tempfile::tempdir().unwrap();
    let said = String::from_utf8(program(folder.path(), &text, &[]).stderr).unwrap();
    let said = said + &String::from_utf8(program(folder.path(), &text, &[]).stdout).unwrap();
    for words in ["WARN", "runs ended before what that is about was over", "av and walker 0.5"] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn every_report_counts_and_names_those_who_never_arrived() {
    let folder = tempfile::tempdir().unwrap();
    let text = scenario(BRAKES, "24 s", "repeat 2", "no collision");
    let output = program(
        folder.path(),
        &text,
        &["--json", "a.json", "--junit", "a.xml", "--tap", "a.tap", "--html", "a.html"],
    );
    assert_eq!(output.status.code(), Some(0));
    let line =
        "2 of 2 runs ended at the horizon; not hit and not arrived in 2 runs: av and walker in a/waits/rep=1";
    for name in ["a.xml", "a.tap", "a.html"] {
        let report = std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(report.replace("&#x2f;", "/").contains(line), "{name}");
    }
    let said =
        String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
    assert!(said.contains(line) && said.contains("; 2 runs ended at the horizon"), "{said}");
    let (_, trial) = run(&text);
    assert_eq!(trial["horizon"]["stranded"][1]["who"], serde_json::json!(["av", "walker"]));
    // A run of which all is seen has nothing of that.
    assert!(run(&scenario(BRAKES, "120 s", "", "no collision")).1.get("horizon").is_none());
}

/// The only trial of a scenario on a road with a zebra.
fn street(road: &str, what: &str, expect: &str) -> Value {
    let text = format!(
        "scenario s {{
  tags blocked_lane
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra {{ width: 4 m }}; {road} }}
  {what}
  expect {{ {expect} }}
}}
"
    );
    run(&text).1
}

/// Whether each criterion passed without being put to the test, for any reason.
fn untested(trial: &Value) -> Vec<bool> {
    trial["findings"].as_array().unwrap().iter().map(|one| !one["untested"].is_null()).collect()
}

/// Whether each criterion passed without being put to the test, because of how a run ended.
fn cut_off(trial: &Value) -> Vec<bool> {
    let findings = trial["findings"].as_array().unwrap().iter();
    findings.map(|one| one["verdict"] == "passed" && one["untested"]["reason"] == "cut_off").collect()
}

#[test]
fn a_contact_that_ends_the_run_decides_nothing_of_others() {
    let van = "parked van { along: -30 m, across: 1.0 m, length: 2 m, width: 1 m }";
    let what = |end: &str, speed: f64| {
        format!(
            "{end}
  vehicle av {{ controller constant_speed; speed 30 km/h; start 80 m before crossing }}
  pedestrian w {{ model scripted {{ speed: {speed} m/s }}; start 2 m from kerb; appears at 1 s }}"
        )
    };
    let expect = "no collision(av, w); rate(impact_speed(av, w) > 1 m/s) <= 1 %; min_distance(av, w) >= 0.5 m
      rate(pet(av, w) < 1 s) <= 0 %; min_distance(av, w) <= 100 m; impact_speed(av, van) <= 9 m/s";
    let trial = street(van, &what("end on collision", 0.45), expect);
    assert_eq!(cut_off(&trial), [true, true, true, false, false, false]);
    // A metric that has yet to be decided is open, and the contact itself is decided.
    assert_ne!(trial["findings"][3]["verdict"], "passed");
    assert_eq!(trial["findings"][3]["cut_off"], 1);
    assert_eq!(verdicts(&trial)[4..], ["passed", "passed"]);
    // Who is across before has nothing more to fear.
    let trial =
        street(van, &what("end on collision", 3.0), "no collision(av, w); min_distance(av, w) >= 0.5 m");
    assert_eq!((verdicts(&trial), cut_off(&trial)), (vec!["passed".to_string(); 2], vec![false; 2]));
}

#[test]
fn everybody_on_a_collision_course_is_seen_when_time_is_up() {
    let person = |name: &str, along: f64| {
        format!(
            "pedestrian {name} {{ model scripted {{ speed: 0.6 m/s }}; start 1 m from kerb; along {along} m }}"
        )
    };
    let what = format!(
        "horizon 2.5 s
  vehicle av {{ controller constant_speed; speed 30 km/h; start 30 m before crossing }}
  {}
  {}",
        person("a", -2.0),
        person("b", 2.0)
    );
    let trial = street("", &what, "no collision(av, a); no collision(av, b); min_distance(av, b) >= 0.5 m");
    assert_eq!(cut_off(&trial), [true; 3]);
    let courses = trial["horizon"]["on_course"].as_array().unwrap();
    assert_eq!([&courses[0]["with"], &courses[1]["with"]], ["a", "b"]);
}

#[test]
fn one_who_has_yet_to_go_is_not_tested_by_another_who_went() {
    let expect =
        "no collision; min_distance >= 0.5 m; impact_speed <= 1 m/s undefined passes; no collision(av, a)";
    let with = |horizon: &str, b: &str| {
        let what = format!(
            "horizon {horizon}
  vehicle av {{ controller constant_speed; speed 30 km/h; start 120 m before crossing }}
  pedestrian a {{ model scripted {{ speed: 1.4 m/s }}; start 2 m from kerb; appears at 8 s }}
  pedestrian b {{ {b} }}"
        );
        street("", &what, expect)
    };
    let stands = |horizon| {
        with(horizon, "model scripted { speed: 1.4 m/s, delay: 50 s }; start 0.6 m from kerb; appears at 0 s")
    };
    assert_eq!(untested(&stands("12.7 s")), [true, true, true, false]);
    // The car is gone, and whoever stands there stands for ever.
    let trial = stands("30 s");
    assert_eq!(verdicts(&trial), ["passed"; 4]);
    assert!(!cut_off(&trial)[0] && !cut_off(&trial)[3], "{trial}");
    let late =
        "model scripted { speed: 1.4 m/s }; start 2 m from kerb; appears when time_to_arrival(av) = 1 s";
    let absent = with("12.7 s", late);
    assert_eq!(untested(&absent), [true, true, true, false]);
}

#[test]
fn braking_that_was_still_to_come_is_not_tested() {
    let what = |horizon: &str| {
        format!(
            "horizon {horizon}
  vehicle av {{ controller yielding; speed 30 km/h }}
  pedestrian w {{ model scripted {{ speed: 1.4 m/s }}; start 2 m from kerb; appears when time_to_arrival(av) = 4 s }}"
        )
    };
    let expect = "max_deceleration <= 9 m/s^2; no sudden_speed_change; rms_jerk <= 500 m/s^3
      rate(max_deceleration > 9 m/s^2) <= 0 %; mean(max_deceleration) <= 9 m/s^2";
    assert_eq!(cut_off(&street("", &what("2 s"), expect)), [true; 5]);
    assert_eq!(cut_off(&street("", &what("60 s"), expect)), [false; 5]);
}

/// What stood closest to a car is so far what it is, and may yet be less: of what holds so far only what is claimed from above
/// is sure, of what does not only what is claimed from below.
#[test]
fn claims_over_runs_that_were_cut_off_hold_only_whatever_would_have_come() {
    let folder = tempfile::tempdir().unwrap();
    let suite = r#"suite st { scenarios "s.scn" }
evaluate ev {
  "e"
  on waits
  with default
  measure min(min_distance)
}
statement above_so_far { "f"; claim min(min_distance) of waits >= 1 m }
statement above_not { "f"; claim min(min_distance) of waits >= 1000 m }
statement below_so_far { "f"; claim min(min_distance) of waits <= 1000 m }
statement below_not { "f"; claim min(min_distance) of waits <= 1 m }
statement measured { "m"; claim min(min_distance) of ev.default >= 1 m }
statement counted { "c"; claim rate(collision) of waits = 0 % }
statement lost { "l"; claim mean(time_lost) of waits >= 1000 s }
statement difference { "d"; claim min(min_distance) of waits - min(min_distance) of ev.default <= 1000 m }
"#;
    std::fs::write(folder.path().join("a.suite"), suite).unwrap();
    std::fs::write(folder.path().join("s.scn"), scenario("constant_speed", "2 s", "", "no collision"))
        .unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
    let output = command.current_dir(folder.path()).arg("a.suite").output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    for words in [
        "min(min_distance) of default: 1 of 1 runs were cut off before the encounter was over",
        "statement above_so_far: not comparable",
        "(1 of 1 runs of `waits` were cut off at 2 s, which leaves anything between 0 m and ",
        "statement above_not: not reproduced",
        "statement below_so_far: untested",
        "statement below_not: not comparable",
        "statement measured: not comparable",
        "1 of 1 runs of `ev.default` were cut off at 2 s",
        "statement counted: not comparable",
        "which leaves anything between 0 % and 100 %",
        "statement lost: not comparable",
        "which leaves anything from ",
        "statement difference: untested",
    ] {
        assert!(said.contains(words), "{words}: {said}{}", String::from_utf8_lossy(&output.stderr));
    }
}
