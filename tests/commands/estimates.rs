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
  budget 2000 runs, by importance
  claim <= 1e-5
}
";

/// [`WALK`] with the smallest budget that the program accepts: enough to tell 1e-5 from 1e-7.
fn quick() -> String {
    WALK.replace("2000 runs", "1000 runs")
}

fn folder(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("walk.scn"), text).unwrap();
    folder
}

/// What is written has the names that the published schema knows, and all that it requires.
fn assert_published(definition: &str, written: &Value) {
    let schema: Value = serde_json::from_str(include_str!("../../docs/results.schema.json")).unwrap();
    let known = &schema["$defs"][definition];
    let (written, properties) = (written.as_object().unwrap(), known["properties"].as_object().unwrap());
    let unknown: Vec<_> = written.keys().filter(|name| !properties.contains_key(*name)).collect();
    let required = known["required"].as_array().unwrap().iter().map(|name| name.as_str().unwrap());
    let missing: Vec<_> = required.filter(|name| !written.contains_key(*name)).collect();
    assert!(unknown.is_empty() && missing.is_empty(), "{definition}: {unknown:?} {missing:?}");
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
    assert_eq!(estimate["nominal_runs"], 160);
    assert_published("estimateResult", estimate);
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

/// The run that it is compared with has a name of its own, with the noise of the other.
#[test]
fn two_in_the_same_encounters_are_told_and_their_runs_are_replayed() {
    let text = WALK.replace("80.5 m", "75 m").replace(
        "estimate hit {\n  of walk",
        "scenario longer : walk { vehicle av { size 5 m x 2 m } }\nestimate hit {\n  of walk\n  compare with longer",
    );
    let folder = folder(&text.replace("claim <= 1e-5", "claim ratio <= 1"));
    let path = folder.path();
    let all = ["walk.scn", "--no-progress", "--json", "r.json", "--junit", "r.xml", "--html", "r.html"];
    let output = scenario_runner(path, &all);
    assert_eq!(output.status.code(), Some(0), "{}{}", stdout(&output), stderr(&output));
    let read = |name: &str| fs::read_to_string(path.join(name)).unwrap();
    let results: Value = serde_json::from_str(&read("r.json")).unwrap();
    let compared = &results["suites"][0]["blocks"][0]["result"]["estimate"]["compared"];
    assert_published("estimateResult", &results["suites"][0]["blocks"][0]["result"]["estimate"]);
    assert_published("comparedEstimate", compared);
    assert_eq!(compared["differs"], serde_json::json!(["av.length: 5 m -> 4 m"]));
    assert!(
        read("r.xml").contains("name=\"ratio_estimate\"") && read("r.xml").contains("name=\"compared_with\"")
    );
    for words in ["in the same encounters", "ratio to `longer`", "runs with the event in `longer` alone"] {
        assert!(read("r.html").contains(words), "{words}");
    }
    let again = scenario_runner(path, &["report", "r.json", "--json", "again.json"]);
    assert!(again.status.success(), "{}", stderr(&again));
    let again: Value = serde_json::from_str(&read("again.json")).unwrap();
    assert_eq!(again["suites"][0]["blocks"][0]["result"]["estimate"]["compared"], *compared);
    let key = compared["there"][0]["key"].as_str().unwrap();
    assert!(key.contains("/longer/") && key.contains("/chance=walk/u="), "{key}");
    let collision = |key: &str| {
        let output = scenario_runner(path, &["replay", key, "walk.scn"]);
        let text = stdout(&output);
        let line = text.lines().find(|line| line.trim_start().starts_with("collision"));
        line.unwrap_or_else(|| panic!("{key}: {text}{}", stderr(&output))).contains("yes")
    };
    let own = key.replace("/longer/", "/walk/").replace("/chance=walk", "");
    assert!(collision(key) && !collision(&own), "it is hit by the longer car alone");
}

#[test]
fn an_estimate_that_is_not_passed_ends_with_another_code() {
    let failed = folder(&quick().replace("<= 1e-5", "<= 1e-7"));
    let output = scenario_runner(failed.path(), &["walk.scn", "--no-progress"]);
    assert_eq!(output.status.code(), Some(100), "{}", stdout(&output));
    // What is not found is no evidence, with a claim or without.
    for claim in ["claim <= 1e-5", ""] {
        let text = quick().replace("80.5 m", "99 m").replace("score pet", "score min_distance");
        let refused = folder(&text.replace("claim <= 1e-5", claim));
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
    // Without the line nothing is told of any distance, which fewer runs show as well.
    let text = fs::read_to_string(root.join(shipped)).unwrap();
    let without = |line: &&str| !line.contains("exposure 0.5") && !line.contains("per 1000 km");
    let text: Vec<&str> = text.lines().filter(without).collect();
    let roads = format!("use \"{}/scenarios/roads/town01_zebra.scn\"", root.display());
    let text = text.join("\n").replace("use \"../roads/town01_zebra.scn\"", &roads);
    let text = text.replace("budget 8000 runs", "budget 1000 runs");
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

/// Who tries seeds or budgets until an estimate passes has shown nothing, and every report says so; until those that failed pass.
#[test]
fn other_seeds_and_budgets_that_did_not_pass_are_told() {
    let folder = folder(&quick().replace("<= 1e-5", "<= 1e-7"));
    let path = folder.path();
    let store = path.join(".scenario-runner/estimates.json");
    let run = |arguments: &[&str]| {
        let output = scenario_runner(path, &[arguments, &["--no-progress"]].concat());
        (output.status.code(), stdout(&output) + &stderr(&output))
    };
    let told = "other seeds or budgets were tried before";
    for (arguments, seen) in
        [(&["estimate", "hit", "walk.scn"][..], false), (&["walk.scn", "--seed", "2"], true)]
    {
        let (code, text) = run(arguments);
        assert_eq!(code, Some(100), "{text}");
        assert_eq!(text.contains(told), seen, "{text}");
    }
    // With another budget and a claim that holds it passes, and says what went before.
    let write = |text: String| fs::write(path.join("walk.scn"), text).unwrap();
    write(quick().replace("1000 runs", "1200 runs"));
    let said = format!(
        "{told}: 2, of which 2 did not pass: seed 1 with 1000 runs by importance, seed 2 with 1000 runs by importance"
    );
    let files = ["--json", "r.json", "--junit", "r.xml", "--html", "r.html"];
    for command in [&["walk.scn"][..], &["estimate", "hit", "walk.scn"]] {
        let (code, text) = run(&[command, &files].concat());
        assert!(code == Some(0) && text.contains(&said), "{text}");
        for file in ["r.json", "r.xml", "r.html"] {
            assert!(fs::read_to_string(path.join(file)).unwrap().contains(&said), "{file}");
        }
    }
    // Those that failed are forgotten once they pass.
    write(quick());
    let (_, text) = run(&["walk.scn", "--seed", "1"]);
    assert!(text.contains(&format!("{told}: 2, of which 1 did not pass: seed 2 with 1000 runs")), "{text}");
    let (_, text) = run(&["estimate", "hit", "walk.scn", "--seed", "2"]);
    assert!(!text.contains(told), "{text}");
    assert!(!store.exists());
}

#[test]
fn the_commands_of_one_block_write_reports() {
    let search = "search near {\n  in walk\n  over far in 60 m .. 90 m\n  minimise min_distance\n  budget 6 evaluations, 3 random first\n}\n";
    let folder = folder(&(quick() + search));
    let path = folder.path();
    for (command, name) in [("estimate", "hit"), ("search", "near")] {
        let files = ["--html=r.html", "--junit=r.xml", "--tap=r.tap", "--github"];
        let output =
            scenario_runner(path, &[&[command, name, "walk.scn", "--no-progress"], &files[..]].concat());
        assert_eq!(output.status.code(), Some(0), "{}{}", stdout(&output), stderr(&output));
        let read = |name: &str| fs::read_to_string(path.join(name)).unwrap();
        assert!(read("r.html").contains(name) && read("r.html").contains("<svg"), "{command}");
        assert!(read("r.xml").contains(&format!("{command}={name}")), "{command}: {}", read("r.xml"));
        assert!(read("r.tap").contains(&format!("{command}={name}")), "{command}: {}", read("r.tap"));
    }
    // What they read is not written over, nor one report by another.
    for (files, words) in [
        (["--html=walk.scn", "--json=r.json"], "would replace a scenario"),
        (["--html=r.html", "--json=r.html"], "would both be written"),
    ] {
        let output = scenario_runner(path, &[&["estimate", "hit", "walk.scn"], &files[..]].concat());
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    }
    assert!(fs::read_to_string(path.join("walk.scn")).unwrap().contains("estimate hit"));
}
