//! Results that were edited by hand: `report` works verdicts out again from the runs, and refuses those that do not follow.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::support::program::{scenario_runner, stderr, stdout};

const SUITE: &str = "road r { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
define street {
  road r
  vehicle av { controller constant_speed; speed 36 km/h; start 30 m before crossing }
  pedestrian walker { model scripted { speed: 1.4 m/s }; start 2 m from kerb; appears at late }
}
scenario hit : street {
  vary late in [0.5 s, 1 s]
  expect { no collision; pet >= 1 s }
}
statement many { \"many\"; source \"free choice\"; claim rate(collision) of hit <= 10 % }
";

/// The results of a run that fails.
fn results(folder: &Path) -> Value {
    fs::write(folder.join("a.scn"), SUITE).unwrap();
    let output = scenario_runner(folder, &["run", "a.scn", "--json", "r.json"]);
    assert_eq!(output.status.code(), Some(100), "{}{}", stdout(&output), stderr(&output));
    serde_json::from_str(&fs::read_to_string(folder.join("r.json")).unwrap()).unwrap()
}

/// The exit code of `report` on these results, and what it says.
fn report(folder: &Path, results: &Value) -> (Option<i32>, String) {
    fs::write(folder.join("edited.json"), results.to_string()).unwrap();
    let output = scenario_runner(folder, &["report", "edited.json"]);
    (output.status.code(), stderr(&output))
}

/// Says that everything passed, wherever there is a word for it.
fn all_green(value: &mut Value) {
    match value {
        Value::String(word) if word == "failed" => *word = "passed".to_string(),
        Value::Array(items) => items.iter_mut().for_each(all_green),
        Value::Object(members) => members.values_mut().for_each(all_green),
        _ => {}
    }
}

#[test]
fn edited_verdicts_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let whole = results(folder.path());
    assert_eq!(report(folder.path(), &whole).0, Some(100));
    assert_eq!(whole["overall"], json!({ "verdict": "failed", "exit_code": 100 }));
    let green = json!({ "verdict": "passed", "exit_code": 0 });
    type Edit = fn(&mut Value);
    let edits: [(&str, Edit); 6] = [
        ("the overall verdict alone", |_| {}),
        ("the verdicts of trials", |value| {
            for trial in value["suites"][0]["trials"].as_array_mut().unwrap() {
                trial["verdict"] = json!("passed");
            }
        }),
        ("every verdict", all_green),
        ("every verdict, and the runs that hold", |value| {
            all_green(value);
            for trial in value["suites"][0]["trials"].as_array_mut().unwrap() {
                for finding in trial["findings"].as_array_mut().unwrap() {
                    finding["holding"] = finding["runs"].clone();
                    finding["observed"] = json!(1.0);
                }
            }
        }),
        ("every verdict, and what the statement says", |value| {
            all_green(value);
            let result = &mut value["suites"][0]["blocks"][0]["result"]["statement"];
            result["conclusion"] = json!("reproduced");
            result["claims"][0]["holds"] = json!(true);
        }),
        ("a value of a run", |value| {
            value["overall"] = json!({ "verdict": "failed", "exit_code": 100 });
            value["suites"][0]["trials"][0]["runs"][0]["metrics"]["collision"] = json!(0.0);
        }),
    ];
    for (what, edit) in edits {
        let mut edited = whole.clone();
        edited["overall"] = green.clone();
        edit(&mut edited);
        let (code, said) = report(folder.path(), &edited);
        assert_eq!(code, Some(2), "{what}: {said}");
        assert!(said.contains("error: cannot report edited.json:"), "{what}: {said}");
    }
}

/// A statement that is declared not to be comparable stays so whatever its claims say.
#[test]
fn a_statement_that_is_declared_not_comparable_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let text = SUITE.replace("<= 10 % }", "<= 10 %; not comparable \"free choice\" }");
    fs::write(folder.path().join("a.scn"), text).unwrap();
    let output = scenario_runner(folder.path(), &["run", "a.scn", "--json", "r.json"]);
    let results: Value = serde_json::from_slice(&fs::read(folder.path().join("r.json")).unwrap()).unwrap();
    let statement = &results["suites"][0]["blocks"][0]["result"]["statement"];
    assert_eq!(statement["claims"][0]["holds"], json!(false));
    let (code, said) = report(folder.path(), &results);
    assert_eq!((code, said), (output.status.code(), String::new()));
    let mut edited = results;
    edited["suites"][0]["blocks"][0]["result"]["statement"]["conclusion"] = json!("reproduced");
    assert_eq!(report(folder.path(), &edited).0, Some(2));
}

#[test]
fn results_say_the_exit_code_that_the_run_earned() {
    let folder = tempfile::tempdir().unwrap();
    let of = |text: &str, more: &[&str]| {
        fs::write(folder.path().join("b.scn"), text).unwrap();
        let ran = scenario_runner(folder.path(), &[&["run", "b.scn", "--json", "b.json"], more].concat());
        let text = fs::read_to_string(folder.path().join("b.json")).unwrap();
        let results: Value = serde_json::from_str(&text).unwrap();
        let again = scenario_runner(folder.path(), &["report", "b.json"]);
        let code = ran.status.code();
        assert_eq!(results["overall"]["exit_code"].as_i64(), code.map(i64::from), "{}", stderr(&ran));
        assert_eq!(again.status.code(), code, "{}", stderr(&again));
        (code, results["overall"]["verdict"].as_str().unwrap().to_string())
    };
    let said = |code: i32, verdict: &str| (Some(code), verdict.to_string());
    assert_eq!(of(SUITE, &[]), said(100, "failed"));
    let passes =
        SUITE.replace("[0.5 s, 1 s]", "[0 s]").replace("no collision; pet >= 1 s", "time_lost <= 9 s");
    let alone = &passes[..passes.find("statement").unwrap()];
    assert_eq!(of(alone, &[]), said(0, "passed"));
    assert_eq!(of(&alone.replace("time_lost <= 9 s", ""), &[]), said(102, "nothing_judged"));
    // What was never put to the test, and may not be.
    let late = alone.replace("[0 s]", "[200 s]").replace("time_lost <= 9 s", "no collision");
    assert_eq!(of(&late, &[]), said(0, "passed"));
    assert_eq!(of(&late, &["--deny", "untested"]), said(102, "inconclusive"));
}

const BLOCKS: &str = "scenario s {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller carla_behavior { braking_distance: 8 m }; speed 30 km/h }
  pedestrian p { model scripted { speed: 1.4 m/s }; start 2 m from kerb; appears when time_to_arrival(av) = tta }
  vary tta in [5 s]
}
search w { in s; minimise pet; over tta in 3 s .. 9 s; budget 4 evaluations, by sobol; expect { pet >= 30 s } }
tune t { on s; over av.controller.braking_distance in 20 m .. 30 m; minimise mean(time_lost); subject to pet >= 30 s; budget 2 evaluations, by sobol }
";

#[test]
fn edited_searches_and_tunes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.scn"), BLOCKS).unwrap();
    type Edit = fn(&mut Value);
    let search: [Edit; 4] = [
        |search| search["judged"]["runs"][0]["findings"] = json!([]),
        |search| search["judged"]["runs"][0]["findings"][0]["verdict"] = json!("passed"),
        |search| search["judged"]["runs"] = json!([]),
        |search| drop(search.as_object_mut().unwrap().remove("judged")),
    ];
    let tune: [Edit; 2] = [
        |tune| tune["chosen"] = tune["evaluations"][0].clone(),
        |tune| {
            tune["evaluations"][0]["feasible"] = json!(true);
            tune["evaluations"][0]["keeps_constraints"] = json!(true);
            tune["chosen"] = tune["evaluations"][0].clone();
            tune["fresh_violations"] = json!([{ "runs": 0, "of": 1 }]);
        },
    ];
    for (kind, block, edits) in [("search", "search=w", &search[..]), ("tune", "tune=t", &tune[..])] {
        let tap = ["--json", "r.json", "--tap", "run.tap"];
        let output = scenario_runner(folder.path(), &[&["run", "a.scn", block], &tap[..]].concat());
        assert_eq!(output.status.code(), Some(100), "{}{}", stdout(&output), stderr(&output));
        let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
        let whole: Value = serde_json::from_str(&read("r.json")).unwrap();
        assert_eq!(report(folder.path(), &whole).0, Some(100));
        // The report that is made later is that of the run.
        scenario_runner(folder.path(), &["report", "r.json", "--tap", "report.tap"]);
        let told = |name| {
            read(name).lines().filter(|line| line.contains("pet")).map(String::from).collect::<Vec<_>>()
        };
        assert_eq!(told("run.tap"), told("report.tap"));
        let blocks = whole["suites"][0]["blocks"].as_array().unwrap();
        let place = blocks.iter().position(|block| !block["result"][kind].is_null()).unwrap();
        for (index, edit) in edits.iter().enumerate() {
            let mut edited = whole.clone();
            all_green(&mut edited);
            edit(&mut edited["suites"][0]["blocks"][place]["result"][kind]);
            edited["overall"] = json!({ "verdict": "passed", "exit_code": 0 });
            let (code, said) = report(folder.path(), &edited);
            assert!(code == Some(2) && said.contains("cannot report"), "{kind} {index}: {code:?} {said}");
        }
    }
}

#[test]
fn a_run_that_speaks_against_a_search_is_told_and_shrunk() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.scn"), BLOCKS).unwrap();
    let output = scenario_runner(folder.path(), &["run", "a.scn", "search=w", "--json", "r.json"]);
    assert_eq!(output.status.code(), Some(100));
    let text = fs::read_to_string(folder.path().join("r.json")).unwrap();
    let whole: Value = serde_json::from_str(&text).unwrap();
    let block = &whole["suites"][0]["blocks"][0]["result"]["search"];
    let key = block["judged"]["runs"][0]["key"].as_str().unwrap();
    let why = stdout(&scenario_runner(folder.path(), &["why", key, "a.scn"])).to_string();
    assert!(why.contains("FAILS `pet >= 30 s`"), "{why}");
    let shrunk = scenario_runner(folder.path(), &["shrink", key, "a.scn", "--output", "small.scn"]);
    assert_eq!(shrunk.status.code(), Some(0), "{}", stderr(&shrunk));
}
