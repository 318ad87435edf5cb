//! Verdicts as users meet them at the command line: stated confidence and what it takes.

use std::collections::BTreeMap;
use std::fs::DirEntry;
use std::path::{Path, PathBuf};

use crate::support::program::{forget_times, scenario_runner, stderr, stdout};
use proptest::prelude::*;
use serde_json::{Value, json};

/// A street, a car and someone who crosses it, with what a test adds to the scenario.
fn walk(folder: &Path, more: &str) -> PathBuf {
    walk_at(folder, "6 s", more)
}

/// As [`walk`], with the arrival time of the car when the pedestrian appears.
fn walk_at(folder: &Path, arrival: &str, more: &str) -> PathBuf {
    let text = format!(
        "scenario walk {{
  road {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
  vehicle av {{ controller carla_behavior; speed 30 km/h }}
  pedestrian walker {{ model carla_walker; start 2 m from kerb; appears when time_to_arrival(av) = {arrival} }}
  {more}
}}
"
    );
    let path = folder.join("walk.scn");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn what_its_runs_can_never_show_is_refused_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    walk(folder.path(), "repeat 60; expect { pet >= 1 s in 99 % of runs with 95 % confidence }");
    for arguments in [&["walk.scn"][..], &["check", "walk.scn"]] {
        let output = scenario_runner(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
        assert!(stderr(&output).contains("error[E0611]"), "{}", stderr(&output));
        assert!(
            stderr(&output).contains("needs at least 299 runs; this trial has 60"),
            "{}",
            stderr(&output)
        );
        assert!(stderr(&output).contains("walk.scn:5:23"), "{}", stderr(&output));
        assert!(output.stdout.is_empty());
    }
}

/// The results of a run as JSON, without times.
fn results(folder: &Path, arguments: &[&str]) -> Value {
    let path = folder.join("results.json");
    scenario_runner(folder, &[&["walk.scn", "--json", "results.json"], arguments].concat());
    let mut value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    forget_times(&mut value);
    value
}

#[test]
fn runs_are_added_until_the_criteria_are_decided() {
    let folder = tempfile::tempdir().unwrap();
    walk(
        folder.path(),
        "runs 20 .. 300; expect { pet >= 0.1 s in 90 % of runs with 95 % confidence; no collision }",
    );
    let output = scenario_runner(folder.path(), &["walk.scn"]);
    assert_eq!(output.status.code(), Some(0), "{}{}", stdout(&output), stderr(&output));
    // 43 runs that all hold show 90 %.
    assert!(
        stdout(&output).contains("walk/walk (decided after 43 of at most 300 runs)"),
        "{}",
        stdout(&output)
    );
    let one = results(folder.path(), &["--test-threads", "1"]);
    assert_eq!(one, results(folder.path(), &["--test-threads", "7"]));
    let trial = &one["suites"][0]["trials"][0];
    assert_eq!(trial["runs"].as_array().unwrap().len(), 43);
    assert_eq!(trial["stopping"], json!({ "least": 20, "most": 300, "runs": 43, "reason": "decided" }));
}

/// The courses that `--trace` writes, by the names of their files.
fn traces(folder: &Path, threads: &str) -> BTreeMap<String, String> {
    let traces = folder.join(threads);
    let arguments = ["walk.scn", "--test-threads", threads, "--trace", threads];
    scenario_runner(folder, &arguments);
    let file = |entry: std::io::Result<DirEntry>| {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        (name, std::fs::read_to_string(path).unwrap())
    };
    std::fs::read_dir(traces).unwrap().map(file).collect()
}

/// Threads share the runs of a single trial.
#[test]
fn threads_do_not_matter_within_a_trial() {
    let folder = tempfile::tempdir().unwrap();
    let expect = "expect { pet >= 1.2 s in 80 % of runs with 99 % confidence; no collision }";
    for (runs, least) in [("repeat 200", 200), ("runs 50 .. 2000", 50)] {
        walk(folder.path(), &format!("{runs}; {expect}"));
        let with = |threads| results(folder.path(), &["--test-threads", threads]);
        let one = with("1");
        let ran = one["suites"][0]["trials"][0]["runs"].as_array().unwrap();
        let names: Vec<_> = (1..=ran.len()).map(|run| format!("walk/walk/rep={run}")).collect();
        assert!(ran.len() >= least, "{}", ran.len());
        assert!(ran.iter().map(|run| run["key"].as_str().unwrap()).eq(&names));
        for threads in ["2", "5"] {
            assert!(one == with(threads), "{runs} with {threads} threads");
        }
    }
    // Of a trial that was decided, with the runs that count and no others.
    let one = traces(folder.path(), "1");
    let ran = results(folder.path(), &[])["suites"][0]["trials"][0]["runs"].as_array().unwrap().len();
    assert!((50..2000).contains(&ran) && one.len() == ran, "{ran} runs, {} courses", one.len());
    assert!(one == traces(folder.path(), "5"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, ..ProptestConfig::default() })]

    /// Several trials that end at different times, with as many threads as there may be.
    #[test]
    fn threads_do_not_matter(
        seed in any::<u32>(),
        least in 1_u32..25,
        more in 0_u32..40,
        share in 50_u32..90,
        bound in 0.5_f64..4.0,
    ) {
        let folder = tempfile::tempdir().unwrap();
        walk_at(
            folder.path(),
            "tta",
            &format!(
                "vary tta in [5 s, 6 s, 7 s]
  runs {least} .. {}
  expect {{
    pet >= {bound} s in {share} % of runs with 90 % confidence
    median(time_lost) <= {bound} s with 90 % confidence
    rate(max_deceleration > 2.5 m/s^2) < {share} % with 90 % confidence
  }}",
                least + 25 + more
            ),
        );
        let seed = seed.to_string();
        let with = |threads| results(folder.path(), &["--seed", &seed, "--test-threads", threads]);
        let one = with("1");
        for trial in one["suites"][0]["trials"].as_array().unwrap() {
            prop_assert!(trial["stopping"]["runs"].as_u64() >= Some(u64::from(least)), "{trial}");
        }
        prop_assert_eq!(&one, &with("2"));
        prop_assert_eq!(&one, &with("5"));
    }
}

#[test]
fn what_a_budget_cannot_decide_is_inconclusive() {
    let folder = tempfile::tempdir().unwrap();
    // Some walkers run and make the car brake: as seldom as is allowed, more or less.
    walk(
        folder.path(),
        "runs 50 .. 60; expect { rate(max_deceleration > 1 m/s^2) <= 10 % with 95 % confidence }",
    );
    let output = scenario_runner(folder.path(), &["walk.scn"]);
    assert_eq!(output.status.code(), Some(102), "{}{}", stdout(&output), stderr(&output));
    assert!(stdout(&output).contains("not decided by all 60 runs"), "{}", stdout(&output));
}

#[test]
fn runs_name_their_margin_and_critical_instant_and_who() {
    let folder = tempfile::tempdir().unwrap();
    walk(folder.path(), "repeat 20; expect { max_deceleration <= 0 m/s^2; pet >= 50 s; pet >= 0.1 s }");
    let output = scenario_runner(folder.path(), &["walk.scn", "--junit", "junit.xml", "--tap", "tap.txt"]);
    assert_eq!(output.status.code(), Some(100));
    let results = results(folder.path(), &[]);
    let trial = &results["suites"][0]["trials"][0];
    let worst = |criterion: usize| &trial["findings"][criterion]["worst"][0];
    assert_eq!(
        (&worst(0)["critical"]["vehicle"], &worst(0)["critical"]["pedestrian"]),
        (&json!("av"), &Value::Null)
    );
    let (far, near) = (worst(1), &trial["findings"][2]["closest"]);
    assert_eq!(trial["findings"][2]["worst"], json!([]));
    assert_eq!(far["critical"]["pedestrian"], json!("walker"));
    // The same run is the worst of one criterion and the closest to another.
    assert_eq!((&far["key"], &far["value"]), (&near["key"], &near["value"]));
    let number = |value: &Value| value.as_f64().unwrap();
    assert!((number(&far["margin"]) - (number(&far["value"]) - 50.0)).abs() < 1e-12);
    assert!((number(&near["margin"]) - (number(&near["value"]) - 0.1)).abs() < 1e-12);
    let at = format!("s) at {:.2} s, av and walker", number(&far["critical"]["time"]));
    assert!(stdout(&output).contains(&at), "{at}: {}", stdout(&output));
    assert!(stdout(&output).contains("closest to `pet >= 0.1 s`: pet "), "{}", stdout(&output));
    for report in ["junit.xml", "tap.txt"] {
        let text = std::fs::read_to_string(folder.path().join(report)).unwrap();
        assert!(text.contains(&at) && text.contains("closest: pet "), "{report}: {text}");
    }
    // Every single run says how it stands.
    for run in trial["runs"].as_array().unwrap() {
        let standings = run["criteria"].as_array().unwrap();
        let holds: Vec<_> = standings.iter().map(|one| one["holds"].as_bool().unwrap()).collect();
        let braked = number(&run["metrics"]["max_deceleration"]) > 0.0;
        assert_eq!(holds, [!braked, false, true], "{run}");
        assert_eq!(standings[1]["pedestrian"], json!("walker"));
    }
}

#[test]
fn what_passed_without_being_put_to_the_test_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    // Nobody gets from two metres behind the kerb into the lane so soon.
    let untested = |trial: &Value| trial["findings"][0]["untested"].clone();
    let trial = || results(folder.path(), &[])["suites"][0]["trials"][0].clone();
    walk(folder.path(), "horizon 1 s; repeat 3; expect { no collision; max_deceleration <= 9 m/s^2 }");
    let output = scenario_runner(folder.path(), &["walk.scn", "--tap", "tap.txt"]);
    assert_eq!(output.status.code(), Some(0));
    let said = "`no collision` passed untested: `walker` did not come into the way of `av` in any of 3 runs";
    assert!(stdout(&output).contains(&format!("WARN walk/walk: {said}")), "{}", stdout(&output));
    assert!(stdout(&output).contains("1 passed; 1 with untested criteria"), "{}", stdout(&output));
    assert!(std::fs::read_to_string(folder.path().join("tap.txt")).unwrap().contains(said));
    let pair = json!([{ "vehicle": "av", "other": "walker", "closest": "together" }]);
    assert_eq!(untested(&trial()), json!({ "reason": "pairs", "pairs": pair }));
    // Braking may have been still to come.
    assert_eq!(trial()["findings"][1]["untested"]["reason"], json!("cut_off"));

    // Some builds must not rest on that.
    let denied = scenario_runner(folder.path(), &["walk.scn", "--deny", "untested"]);
    assert_eq!(denied.status.code(), Some(102));
    let said_so = "in 1 unit criteria passed untested, which `--deny untested` does not count as passed";
    let errors = String::from_utf8_lossy(&denied.stderr);
    assert!(errors.contains(said_so), "{errors}");
    assert_eq!(scenario_runner(folder.path(), &["walk.scn", "--deny", "all"]).status.code(), Some(2));

    // A criterion that is stated twice is one.
    walk(folder.path(), "horizon 1 s; repeat 3; expect { no collision; no collision }");
    let output = scenario_runner(folder.path(), &["walk.scn"]);
    assert!(stdout(&output).contains(&format!("WARN walk/walk: {said}")), "{}", stdout(&output));

    // A car that has not passed the pedestrian by then does not show which of the two goes first.
    walk(folder.path(), "horizon 1 s; expect { no collision; passed_first = none }");
    let output = scenario_runner(folder.path(), &["walk.scn"]);
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
    assert!(stdout(&output).contains("did not come into the way"), "{}", stdout(&output));
    walk(folder.path(), "expect { no collision }");
    assert_eq!(untested(&trial()), Value::Null);
    assert_eq!(scenario_runner(folder.path(), &["walk.scn", "--deny", "untested"]).status.code(), Some(0));
    // What failed stays so.
    walk(folder.path(), "horizon 1 s; expect { no collision; min_distance >= 1000 m }");
    let failed = scenario_runner(folder.path(), &["walk.scn", "--deny", "untested"]);
    assert_eq!(failed.status.code(), Some(100));

    // How many runs were cut off is said of counts as of everything else, passed or not.
    walk(
        folder.path(),
        "horizon 1 s; repeat 3; expect { count(collision) <= 1; count(min_distance < 1000 m) <= 1 }",
    );
    let output = scenario_runner(folder.path(), &["walk.scn"]);
    let over = "3 of 3 runs ended before what that is about was over: what would have come is not in it";
    assert!(stdout(&output).contains(over), "{}", stdout(&output));
    assert_eq!([0, 1].map(|index| trial()["findings"][index]["unseen"].clone()), [json!(3), json!(3)]);
}

#[test]
fn a_trial_that_nothing_is_claimed_of_has_not_passed() {
    let folder = tempfile::tempdir().unwrap();
    walk_at(
        folder.path(),
        "tta",
        "vary tta in [6 s, 9 s]; repeat 2; expect { no collision when tta > 8 s; pet >= 0.1 s when tta > 8 s }",
    );
    let checked = scenario_runner(folder.path(), &["check", "walk.scn"]);
    assert!(stderr(&checked).contains("warning[W0938]"), "{}", stderr(&checked));
    let reports = ["--tap", "tap.txt", "--junit", "junit.xml", "--csv", "runs.csv", "--html", "report.html"];
    let output = scenario_runner(folder.path(), &[&["walk.scn"][..], &reports].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let why = "none of the 2 criteria of its scenario applies, so nothing is claimed of its 2 runs";
    let said = stdout(&output);
    for words in [
        "NOT JUDGED [",
        "– not judged",
        "1 passed, 1 not judged",
        &format!("WARN walk/walk/tta=6s: not judged: {why}"),
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(read("tap.txt").contains("ok 1 - walk/walk/tta=6s # SKIP not judged: no criterion applies"));
    assert!(
        read("junit.xml").contains(&format!("<skipped message=\"not judged: {why}")),
        "{}",
        read("junit.xml")
    );
    assert!(read("report.html").contains("1</b> – not judged"));
    let rows = read("runs.csv");
    let verdicts: Vec<&str> = rows.lines().skip(1).map(|row| row.split(',').nth(5).unwrap()).collect();
    assert_eq!(verdicts, ["", "", "passed", "passed"], "{rows}");
    let trials = &results(folder.path(), &[])["suites"][0]["trials"];
    assert_eq!((&trials[0]["verdict"], &trials[0]["judged"]), (&json!("passed"), &json!(false)));
    assert_eq!(trials[0]["warnings"], json!([format!("not judged: {why}")]));
    assert_eq!(trials[1].get("judged"), None);
}

#[test]
fn who_crosses_long_before_the_car_comes_puts_nothing_to_the_test() {
    let folder = tempfile::tempdir().unwrap();
    walk_at(
        folder.path(),
        "14 s",
        "repeat 2; expect { no collision; pet >= 1 s; max_deceleration <= 9 m/s^2 }",
    );
    let trial = &results(folder.path(), &[])["suites"][0]["trials"][0];
    let closest = |index: usize| trial["findings"][index]["untested"]["pairs"][0]["closest"].clone();
    assert_eq!([0, 1, 2].map(closest), [json!("in_the_way"), json!("in_the_way"), Value::Null]);
    let output = scenario_runner(folder.path(), &["walk.scn"]);
    let said = "`no collision`, `pet >= 1 s` passed untested: `walker` was in the way of `av`, but not within 5 s of it";
    assert!(stdout(&output).contains(said), "{}", stdout(&output));
}

/// Runs without a value are left out of a mean: the worst is one that has a small one.
#[test]
fn the_worst_run_of_a_mean_is_one_that_counts() {
    const SOME_MEET: &str = "scenario some_meet {
  road { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }
  vehicle av { start 60 m before crossing; speed 40 km/h; controller constant_speed }
  pedestrian walker { model scripted; start 2 m from kerb; appears at late }
  draw late from uniform(0 s, 12 s)
  repeat 12
  expect { mean(min_ttc) >= 10 s }
}
";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.scn"), SOME_MEET).unwrap();
    let output = scenario_runner(folder.path(), &["a.scn", "--json", "r.json"]);
    assert_eq!(output.status.code(), Some(100), "{}", stdout(&output));
    let json: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("r.json")).unwrap()).unwrap();
    let finding = &json["suites"][0]["trials"][0]["findings"][0];
    let (holding, runs) = (finding["holding"].as_u64().unwrap(), finding["runs"].as_u64().unwrap());
    assert!(0 < holding && holding < runs, "{finding}");
    let worst = finding["worst"].as_array().unwrap();
    assert!(!worst.is_empty() && worst.iter().all(|run| run["value"].is_number()), "{finding}");
    let values: Vec<f64> = worst.iter().map(|run| run["value"].as_f64().unwrap()).collect();
    assert!(values.is_sorted(), "{values:?}");
}
