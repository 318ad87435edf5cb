//! Estimates on the command line: told in all reports, read back, replayed, refused and claimed.

use std::fs;
use std::path::Path;

use crate::support::program::{scenario_runner, stderr, stdout};
use serde_json::Value;

const WALK: &str = "scenario walk {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; size 4 m x 2 m; speed 10 m/s; start far before crossing }
  pedestrian walker { model scripted { speed: 1 m/s }; radius 0.3 m; start 3 m from kerb; appears at 0 s }
  draw far from normal(80.5 m, 4 m)
  horizon 15 s
  end on collision
  expect { no collision }
}
estimate hit {
  of walk
  event collision
  score pet
  budget 4000 runs, by importance
  claim <= 1e-5
}
";

fn folder(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("walk.scn"), text).unwrap();
    folder
}

#[test]
fn an_estimate_is_told_in_all_reports_and_its_runs_are_replayed() {
    let folder = folder(WALK);
    let path = folder.path();
    let all = ["walk.scn", "--no-progress", "--json", "r.json", "--junit", "r.xml", "--html", "r.html"];
    let output = scenario_runner(path, &all);
    assert_eq!(output.status.code(), Some(0), "{}{}", stdout(&output), stderr(&output));
    let read = |name: &str| fs::read_to_string(path.join(name)).unwrap();
    let results: Value = serde_json::from_str(&read("r.json")).unwrap();
    let block = &results["suites"][0]["blocks"][0];
    assert_eq!((&block["kind"], &block["verdict"]), (&"estimate".into(), &"passed".into()), "{block}");
    let estimate = &block["result"]["estimate"];
    assert!((estimate["value"].as_f64().unwrap() / 3.46e-6 - 1.0).abs() < 0.15, "{estimate}");
    assert_eq!(estimate["nominal_runs"], 300);
    let junit = read("r.xml");
    assert!(junit.matches("estimate=hit").count() >= 1 && junit.contains("guaranteed"), "{junit}");
    let html = read("r.html");
    for words in ["guaranteed", "may be unseen", "the runs that carry the estimate", "replay"] {
        assert!(html.contains(words), "{words}");
    }
    // Read back, it is told the same.
    let again = scenario_runner(path, &["report", "r.json", "--json", "again.json"]);
    assert!(again.status.success(), "{}", stderr(&again));
    let again: Value = serde_json::from_str(&read("again.json")).unwrap();
    assert_eq!(again["suites"][0]["blocks"][0]["result"], block["result"]);

    let key = estimate["carrying"][0]["key"].as_str().unwrap();
    let replayed = scenario_runner(path, &["replay", key, "walk.scn"]);
    assert!(stdout(&replayed).contains("collision"), "{}{}", stdout(&replayed), stderr(&replayed));

    // By itself, and the same.
    let alone = scenario_runner(path, &["estimate", "hit", "walk.scn", "--no-progress", "--json", "e.json"]);
    assert_eq!(alone.status.code(), Some(0), "{}", stderr(&alone));
    assert!(stdout(&alone).contains("guaranteed: at most"), "{}", stdout(&alone));
    let own: Value = serde_json::from_str(&read("e.json")).unwrap();
    assert_eq!(own, *estimate);
}

#[test]
fn an_estimate_that_is_not_passed_ends_with_another_code() {
    let failed = folder(&WALK.replace("<= 1e-5", "<= 1e-7"));
    let output = scenario_runner(failed.path(), &["walk.scn", "--no-progress"]);
    assert_eq!(output.status.code(), Some(100), "{}", stdout(&output));
    // What is not found is no evidence, with a claim or without.
    for claim in ["claim <= 1e-5", ""] {
        let text = WALK.replace("80.5 m", "99 m").replace("score pet", "score min_distance");
        let refused = folder(&text.replace("4000", "1000").replace("claim <= 1e-5", claim));
        for arguments in
            [&["walk.scn", "--no-progress"][..], &["estimate", "hit", "walk.scn", "--no-progress"]]
        {
            let output = scenario_runner(refused.path(), arguments);
            assert_eq!(output.status.code(), Some(102), "{}{}", stdout(&output), stderr(&output));
        }
    }
}

/// The shipped example: every assumption is named, and what is made up says so beside the result.
#[test]
fn the_example_tells_events_in_1_000_km_with_the_source_of_the_exposure() {
    let (root, folder) = (Path::new(env!("CARGO_MANIFEST_DIR")), tempfile::tempdir().unwrap());
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (json, junit, html) = (file("r.json"), file("r.xml"), file("r.html"));
    let shipped = "scenarios/drawn/per_1000_km.scn";
    let all = [shipped, "--no-progress", "--json", &json, "--junit", &junit, "--html", &html];
    let output = scenario_runner(root, &all);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{text}{}", stderr(&output));
    for words in
        ["per 1,000 km, events to be expected", "exposure: 0.5 to 4 encounters", "Made up for this example"]
    {
        assert!(text.contains(words), "{words}: {text}");
        assert!(fs::read_to_string(&html).unwrap().contains(words), "{words}");
    }
    let results: Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    let estimate = &results["suites"][0]["blocks"][0]["result"]["estimate"];
    let number = |value: &Value| value.as_f64().unwrap();
    let along = &estimate["per_1000_km"];
    assert!((number(&along["guaranteed"]) - 4.0 * number(&estimate["guaranteed"])).abs() < 1e-12, "{along}");
    assert!((number(&along["interval"]["low"]) - 0.5 * number(&estimate["interval"]["low"])).abs() < 1e-12);
    let junit = fs::read_to_string(&junit).unwrap();
    assert!(junit.contains("per_1000_km_guaranteed") && junit.contains("exposure_source"), "{junit}");
    // Without the line nothing is told of any distance.
    let text = fs::read_to_string(root.join(shipped)).unwrap();
    let without = |line: &&str| !line.contains("exposure 0.5") && !line.contains("per 1000 km");
    let text: Vec<&str> = text.lines().filter(without).collect();
    let roads = format!("use \"{}/scenarios/roads/town01_zebra.scn\"", root.display());
    let text = text.join("\n").replace("use \"../roads/town01_zebra.scn\"", &roads);
    fs::write(file("plain.scn"), text).unwrap();
    let plain =
        scenario_runner(folder.path(), &["estimate", "hit_per_1000_km", "plain.scn", "--no-progress"]);
    assert!(
        !stdout(&plain).contains("1,000 km") && stdout(&plain).contains("guaranteed"),
        "{}{}",
        stdout(&plain),
        stderr(&plain)
    );
}
