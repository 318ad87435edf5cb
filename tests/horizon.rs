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
    assert_eq!(trial["findings"][0]["vacuous"], "cut_off");
    assert!(trial["findings"][1].get("vacuous").is_none(), "a contact decides nothing about braking so far");
    let course = &trial["horizon"]["on_course"][0];
    assert_eq!((&course["vehicle"], &course["with"]), (&"av".into(), &"walker".into()));
    assert!((course["time"].as_f64().unwrap() - 0.5).abs() < 0.03, "{course}");
    let folder = tempfile::tempdir().unwrap();
    let said = String::from_utf8(program(folder.path(), &text, &[]).stderr).unwrap();
    let said = said + &String::from_utf8(program(folder.path(), &text, &[]).stdout).unwrap();
    for words in ["WARN", "time was up with somebody on a collision course", "av and walker 0.5"] {
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
