//! Contacts of all bodies, as users meet them: what ends a run, what fails, what a trace and a replay say.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const STREET: &str = "road street {
  lane_width 4 m
  speed_limit 30 km/h
  crossing zebra
  parked truck { along: 20 m, across: ACROSS, length: 8 m, width: 2.5 m }
}
scenario drive {
  road street
  WHAT
  vehicle av { controller constant_speed; speed 10 m/s; size 4 m x 2 m; start 60 m before crossing }
  pedestrian walker { model scripted { speed: 1.4 m/s }; start 2 m from kerb; appears at 10 s; ALONG }
  horizon 20 s
  finish 40 m
  EXPECT
}
";

/// A scenario with the truck `across`, and what else it says.
fn scenario(across: &str, what: &str, along: &str, expect: &str) -> String {
    let text = STREET.replace("ACROSS", across).replace("WHAT", what).replace("ALONG", along);
    text.replace("EXPECT", &format!("expect {{ {expect} }}"))
}

fn program(folder: &Path, arguments: &[&str]) -> Output {
    let program = Command::new(env!("CARGO_BIN_EXE_scenario-runner"))
        .current_dir(folder)
        .args(arguments)
        .env_remove("CI")
        .output();
    program.unwrap()
}

/// The exit code, the results and the trace of the only run.
fn run(text: &str) -> (Option<i32>, Value, Vec<Vec<String>>) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.scn"), text).unwrap();
    let output = program(folder.path(), &["a.scn", "--json", "a.json", "--trace", "traces"]);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    let json = std::fs::read_to_string(folder.path().join("a.json")).unwrap_or_else(|_| panic!("{stderr}"));
    let trace = std::fs::read_to_string(folder.path().join("traces/a__drive__rep=1.csv")).unwrap();
    let rows = trace.lines().map(|line| line.split(',').map(str::to_string).collect()).collect();
    (output.status.code(), serde_json::from_str(&json).unwrap(), rows)
}

fn replay(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.scn"), text).unwrap();
    String::from_utf8(program(folder.path(), &["replay", "a/drive/rep=1", "a.scn"]).stdout).unwrap()
}

/// The front is at the truck's rear after (60 + 20 - 4 - 2) m at 10 m/s.
const IMPACT: f64 = 7.4;

#[test]
fn a_truck_in_the_lane_is_no_thin_air() {
    let expect = "no collision; no collision(av, walker); impact_speed <= 5 m/s";
    let (code, results, trace) = run(&scenario("0.5 m", "end on collision", "", expect));
    assert_eq!(code, Some(100));
    let trial = &results["suites"][0]["trials"][0];
    let verdicts: Vec<_> = trial["findings"].as_array().unwrap().iter().map(|one| &one["verdict"]).collect();
    assert_eq!(verdicts, ["failed", "passed", "failed"]);
    let ending = &trial["runs"][0]["ending"];
    assert_eq!(ending["reason"], "collision");
    assert!((ending["time"].as_f64().unwrap() - IMPACT).abs() < 1e-9, "{ending}");
    let critical = &trial["findings"][0]["worst"][0]["critical"];
    assert_eq!((&critical["vehicle"], &critical["other"]), (&"av".into(), &"truck".into()));
    // The trace ends where the run does, and says at what.
    let last = trace.last().unwrap();
    assert!((last[0].parse::<f64>().unwrap() - IMPACT).abs() < 1e-9, "{last:?}");
    assert_eq!((last[1].as_str(), last[8].as_str()), ("av", "touches truck"));
    assert!((last[2].parse::<f64>().unwrap() - 14.0).abs() < 1e-9, "{last:?}");
}

#[test]
fn a_truck_beside_the_lane_is_passed() {
    let (code, results, trace) = run(&scenario("2.3 m", "end on collision", "", "no collision"));
    assert_eq!(code, Some(0));
    assert_eq!(results["suites"][0]["trials"][0]["runs"][0]["ending"]["reason"], "completed");
    assert!(trace.iter().all(|row| !row[8].contains("touches")));
}

#[test]
fn a_run_that_goes_on_has_a_row_at_the_contact_and_the_first_of_everybody() {
    let (_, results, trace) = run(&scenario("0.5 m", "", "", "no collision"));
    assert_eq!(results["suites"][0]["trials"][0]["runs"][0]["ending"]["reason"], "completed");
    let times: Vec<f64> = trace[1..].iter().map(|row| row[0].parse().unwrap()).collect();
    assert!(times.is_sorted(), "rows stand in order");
    let marked = |event: &str| -> Vec<(f64, String)> {
        let rows = trace.iter().filter(|row| row[8] == event);
        rows.map(|row| (row[0].parse().unwrap(), row[1].clone())).collect()
    };
    let touches = marked("touches truck");
    assert_eq!(touches.len(), 1, "a contact is marked where it begins, not while it lasts");
    assert!((touches[0].0 - IMPACT).abs() < 1e-9 && touches[0].1 == "av", "{touches:?}");
    let appears = marked("appears");
    assert_eq!(appears.len(), 1);
    assert!((appears[0].0 - 10.0).abs() < 1e-9 && appears[0].1 == "walker", "{appears:?}");
    let rows = |who: &str, time: f64| {
        let same = |row: &&Vec<String>| row[1] == who && (row[0].parse::<f64>().unwrap() - time).abs() < 1e-9;
        trace[1..].iter().filter(same).count()
    };
    assert_eq!((rows("av", 10.0), rows("walker", 10.0)), (1, 1), "one row each a moment");
}

#[test]
fn vehicles_meet_vehicles() {
    let other = "vehicle other { controller constant_speed; speed 0 m/s; size 4 m x 2 m; start 20 m before crossing }";
    let what = format!("end on collision; {other}");
    let text = scenario("5 m", &what, "", "no collision(av, other)");
    let (code, results, _) = run(&text);
    assert_eq!(code, Some(100));
    let ending = &results["suites"][0]["trials"][0]["runs"][0]["ending"];
    assert!((ending["time"].as_f64().unwrap() - 3.6).abs() < 1e-9, "{ending}");
    let said = replay(&text);
    assert!(said.contains("COLLIDES with") && said.contains("at a relative speed of 10 m/s"), "{said}");
}

#[test]
fn people_touch_people_and_boxes_without_colliding() {
    let child =
        "pedestrian child { model scripted { speed: 0.1 m/s }; start 0.5 m from kerb; appears at 10 s }";
    let text = scenario("-2.3 m", child, "along 20 m", "no collision");
    let said = replay(&text);
    assert!(said.contains("walker  touches truck"), "{said}");
    let text = scenario("8 m", child, "", "no collision");
    let (code, ..) = run(&text);
    assert_eq!(code, Some(0));
    let said = replay(&text);
    assert!(said.contains("child   touches walker") && !said.contains("COLLIDES"), "{said}");
}

#[test]
fn who_is_displaced_jumps_in_that_step_and_nobody_else_does() {
    let walk = |snap: &str| {
        let walker = format!("carla_walker {{ snap_min: {snap}; snap_max: {snap} }}");
        let text = scenario("8 m", "", "", "no collision").replace("scripted { speed: 1.4 m/s }", &walker);
        let (_, _, trace) = run(&text);
        let of_walker: Vec<Vec<String>> = trace.into_iter().filter(|row| row[1] == "walker").collect();
        of_walker
    };
    let number = |row: &[String], column: usize| row[column].parse::<f64>().unwrap();
    let (still, displaced) = (walk("0 m"), walk("0.5 m"));
    for (rows, jumps) in [(&still, &[][..]), (&displaced, &[1][..])] {
        let with = |event: &str| {
            let marked = rows.iter().enumerate().filter(|(_, row)| row[8] == event);
            marked.map(|(place, _)| place).collect::<Vec<_>>()
        };
        assert_eq!(with("appears"), [0], "the first row, at {} s", rows[0][0]);
        assert!((number(&rows[0], 0) - 10.0).abs() < 1e-9, "{:?}", rows[0]);
        assert_eq!(with("jumps"), jumps);
        // Nobody else moves farther in a step than walking at 1.4 m/s takes.
        let leaps = (1..rows.len()).filter(|&row| {
            let moved = (number(&rows[row], 3) - number(&rows[row - 1], 3)).abs();
            moved > 1.4 * (number(&rows[row], 0) - number(&rows[row - 1], 0)) + 1e-9
        });
        assert_eq!(leaps.collect::<Vec<_>>(), jumps);
    }
    // Half a metre back from where it appeared, from the pavement of the near side.
    assert!((number(&displaced[0], 3) - number(&displaced[1], 3) - 0.5).abs() < 1e-9, "{:?}", displaced[1]);
}
