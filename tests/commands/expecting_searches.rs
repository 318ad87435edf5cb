//! What a search expects of what it found, and how it fails a build.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::program::{code, scenario_runner, stderr, stdout};

/// A pedestrian stops in the lane, and the car does not brake.
const HIT: &str = "scenario hit {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed v; start 60 m before crossing }
  pedestrian walker { model scripted { stop_after: 2.75 m }; start 1 m from kerb; appears at 0 s }
  vary v in [20 km/h]
}
";

fn place(scenario: &str, rest: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let search = "search fastest { in hit; maximise impact_speed; over v in 10 km/h .. 60 km/h; budget 6 evaluations, by random; ";
    fs::write(folder.path().join("hit.scn"), format!("{scenario}{search}{rest} }}\n")).unwrap();
    folder
}

/// Runs the search alone, as a suite and as a command; both have the same exit code. What is said, and the block as JSON.
fn run(folder: &Path, expected: i32) -> (String, Value) {
    let all =
        ["hit.scn", "search=fastest", "--json", "all.json", "--junit", "junit.xml", "--html", "page.html"];
    let output = scenario_runner(folder, &all);
    assert_eq!(code(&output), expected, "{}{}", stdout(&output), stderr(&output));
    let alone = scenario_runner(folder, &["search", "fastest", "hit.scn"]);
    assert_eq!(code(&alone), expected, "{}{}", stdout(&alone), stderr(&alone));
    let reported = scenario_runner(folder, &["report", "all.json"]);
    assert_eq!(code(&reported), expected, "{}{}", stdout(&reported), stderr(&reported));
    let text = fs::read_to_string(folder.join("all.json")).unwrap();
    let results: Value = serde_json::from_str(&text).unwrap();
    (stdout(&output), results["suites"][0]["blocks"][0].clone())
}

#[test]
fn without_expectations_it_is_found_and_not_judged() {
    let folder = place(HIT, "keep impact_speed > 30 km/h");
    let (said, block) = run(folder.path(), 0);
    assert!(said.contains("FOUND") && said.contains("found, not judged") && !said.contains("PASS"), "{said}");
    assert!(said.contains("1 block, 6 evaluations") && !said.contains("0 runs"), "{said}");
    assert_eq!(block["verdict"], "found");
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(text("junit.xml").contains("<skipped message=\"found, not judged\"/>"));
    let page = text("page.html");
    assert!(
        page.contains("<b>6</b> evaluations") && !page.contains("<b>0</b> runs"),
        "tiles count evaluations"
    );
    assert!(page.contains("– found, not judged") && !page.contains("✓ all"), "there is no tick");
}

#[test]
fn a_kept_run_that_breaks_what_is_expected_fails() {
    let folder = place(HIT, "keep impact_speed > 30 km/h; expect { impact_speed <= 40 km/h }");
    let (said, block) = run(folder.path(), 100);
    assert!(said.contains("`impact_speed <= 40 km/h` does not hold in the kept run: hit/fastest/"), "{said}");
    let judged = &block["result"]["search"]["judged"]["runs"][0];
    // The share on fresh seeds stands beside it.
    assert_eq!((&judged["fresh_holding"], &judged["fresh_runs"]), (&0.into(), &20.into()));
    let key = judged["key"].as_str().unwrap();
    let replayed = scenario_runner(folder.path(), &["replay", key, "hit.scn"]);
    let speed = block["result"]["search"]["found"][0]["observed"].as_f64().unwrap();
    assert!(stdout(&replayed).contains(&format!("{:.2}", speed)[..4]), "{}", stdout(&replayed));
    // Where all of it holds it passes, with what was found.
    let folder = place(HIT, "keep impact_speed > 30 km/h; expect { impact_speed <= 60 km/h }");
    let (said, block) = run(folder.path(), 0);
    assert!(said.contains("PASS") && block["verdict"] == "passed", "{said}");
}

#[test]
fn where_nothing_is_kept_the_best_observed_run_is_judged() {
    let folder = place(HIT, "keep impact_speed > 90 km/h; expect { no collision }");
    let (said, block) = run(folder.path(), 100);
    assert!(said.contains("0 of 1 kept") && said.contains("since nothing was kept"), "{said}");
    assert_eq!(block["result"]["search"]["judged"]["of_kept"], false);
}

#[test]
fn without_any_value_nothing_was_found_and_nothing_passes() {
    // They stop at the kerb, so that there is no time between them and the car.
    let kerb = HIT.replace("stop_after: 2.75 m", "stop_after: 0.5 m");
    for expect in ["", "; expect { pet >= 1 s undefined passes }"] {
        let folder = place(&kerb, &format!("keep collision{expect}"));
        let text = fs::read_to_string(folder.path().join("hit.scn")).unwrap();
        fs::write(folder.path().join("hit.scn"), text.replace("maximise impact_speed", "minimise pet"))
            .unwrap();
        let (said, block) = run(folder.path(), 102);
        assert!(said.contains("no evaluation has a value of `minimise mean(pet)`"), "{said}");
        assert_eq!(block["verdict"], "inconclusive");
    }
}

#[test]
fn what_was_never_put_to_the_test_is_said_and_can_be_denied() {
    // The car is slow enough to meet no pedestrian, and the distance between them has a value all the same.
    let kerb = HIT.replace("stop_after: 2.75 m", "stop_after: 0.5 m");
    let folder = place(&kerb, "expect { no collision }");
    let text = fs::read_to_string(folder.path().join("hit.scn")).unwrap();
    fs::write(folder.path().join("hit.scn"), text.replace("maximise impact_speed", "minimise min_distance"))
        .unwrap();
    let (said, _) = run(folder.path(), 0);
    assert!(said.contains("untested"), "{said}");
    let denied = scenario_runner(folder.path(), &["hit.scn", "search=fastest", "--deny", "untested"]);
    assert_eq!(code(&denied), 102, "{}", stderr(&denied));
    assert!(stderr(&denied).contains("in 1 unit criteria passed untested"), "{}", stderr(&denied));
}

#[test]
fn a_tune_takes_what_a_search_that_failed_has_kept() {
    let folder = place(HIT, "keep impact_speed > 30 km/h; expect { no collision }");
    let text = fs::read_to_string(folder.path().join("hit.scn")).unwrap();
    let tune = "tune ticks { on fastest; over av.controller.period in 20 ms .. 50 ms; minimise mean(impact_speed); \
                budget 2 evaluations, by random }\n";
    fs::write(folder.path().join("hit.scn"), text + tune).unwrap();
    let output = scenario_runner(folder.path(), &["hit.scn", "tune=ticks"]);
    assert_eq!(code(&output), 100);
    assert!(
        stdout(&output).contains("tune ticks: minimise mean(impact_speed) over 1 cases"),
        "{}",
        stdout(&output)
    );
}
