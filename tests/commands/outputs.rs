//! Results in files as users and other programs read them: every run, whatever the threads, and places that can be found.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::support::program::{code, scenario_runner, stderr, stdout};
use serde_json::Value;

/// Five times to arrival, of which the later ones fail, and a scenario that cannot be run to its end in time.
const SCENARIO: &str = "scenario walk {
  \"People meet a car that does not care.\"
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 30 km/h }
  pedestrian walker { model carla_walker; start 1 m from kerb; appears when time_to_arrival(av) = tta }
  vary tta in [2 s, 3 s, 4 s, 5 s, 6 s]
  repeat 3
  expect { max_deceleration >= 1 m/s^2 when tta >= 4 s; max_deceleration <= 100 m/s^2 }
}
";

/// A repository whose suites and scenarios lie in folders of their own, below its root.
fn repository() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in [".git", "av/suites", "av/scenarios"] {
        fs::create_dir_all(at(name)).unwrap();
    }
    fs::write(at("av/scenarios/walk.scn"), SCENARIO).unwrap();
    fs::write(at("av/suites/small.suite"), "suite small { scenarios \"../scenarios/*.scn\"; seed 7 }\n")
        .unwrap();
    folder
}

#[test]
fn every_run_is_a_line_and_a_row_whatever_the_threads() {
    let folder = repository();
    let place = folder.path().join("av/suites");
    let written = |threads: &str| {
        let files = ["--runs", "out/runs.jsonl", "--csv", "out/runs.csv", "--json", "out/all.json"];
        let output =
            scenario_runner(&place, &[&["small.suite", "--test-threads", threads][..], &files[..]].concat());
        assert_eq!(code(&output), 100, "{}", stderr(&output));
        let read = |name: &str| fs::read_to_string(place.join("out").join(name)).unwrap();
        (read("runs.jsonl"), read("runs.csv"), read("all.json"))
    };
    let (runs, rows, all) = written("1");
    for threads in ["2", "7"] {
        let (again, rows_again, _) = written(threads);
        assert!(again == runs && rows_again == rows, "{threads} threads give other bytes");
    }
    let all: Value = serde_json::from_str(&all).unwrap();
    let trials = all["suites"][0]["trials"].as_array().unwrap();
    let known: Vec<&Value> = trials.iter().flat_map(|trial| trial["runs"].as_array().unwrap()).collect();
    assert_eq!(known.len(), 15);
    // The same runs, in the order of the plan, with the same numbers.
    let lines: Vec<Value> = runs.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let mut reader = csv::Reader::from_reader(rows.as_bytes());
    let headings = reader.headers().unwrap().clone();
    let cell = |row: &csv::StringRecord, name: &str| {
        row[headings.iter().position(|known| known == name).unwrap()].to_string()
    };
    let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
    assert_eq!((lines.len(), rows.len()), (15, 15));
    for ((line, row), run) in lines.iter().zip(&rows).zip(known) {
        for member in ["key", "seed", "metrics", "criteria", "fingerprint", "ending", "individuals"] {
            assert_eq!(line[member], run[member]);
        }
        assert_eq!(cell(row, "run"), run["key"].as_str().unwrap());
        assert_eq!(cell(row, "state"), "finished");
        let distance = cell(row, "min_distance [m]").parse::<f64>().ok();
        assert_eq!(distance, run["metrics"]["min_distance"].as_f64());
        let fingerprint = format!("0x{}", run["fingerprint"].as_str().unwrap());
        assert_eq!(cell(row, "fingerprint"), fingerprint);
    }
    // What it says is what can be replayed.
    let (key, fingerprint) = (cell(&rows[14], "run"), cell(&rows[14], "fingerprint"));
    let output = scenario_runner(&place, &["replay", &key, "small.suite", "--fingerprint", &fingerprint]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}

#[test]
fn files_are_named_from_the_root_of_the_repository_on() {
    let folder = repository();
    let place = folder.path().join("av/suites");
    let output = scenario_runner(&place, &["small.suite", "--github", "--junit", "junit.xml"]);
    let said = stdout(&output);
    let annotations: Vec<_> = said.lines().filter(|line| line.starts_with("::")).collect();
    assert!(!annotations.is_empty(), "{said}");
    for line in annotations {
        assert!(line.contains("file=av/scenarios/walk.scn,line="), "{line}");
    }
    let junit = fs::read_to_string(place.join("junit.xml")).unwrap();
    assert_eq!(junit.matches("<testcase ").count(), 5);
    assert_eq!(junit.matches("file=\"av/scenarios/walk.scn\" line=\"1\"").count(), 5, "{junit}");

    fs::write(folder.path().join("av/scenarios/bad.scn"), "scenario bad { vehicle av { sped 3 km/h } }\n")
        .unwrap();
    let github = scenario_runner(&place, &["check", "../scenarios/bad.scn", "--format", "github"]);
    assert!(stdout(&github).contains("file=av/scenarios/bad.scn,"), "{}", stdout(&github));
    let sarif = scenario_runner(&place, &["check", "../scenarios/bad.scn", "--format", "sarif"]);
    assert!(stdout(&sarif).contains("\"uri\": \"av/scenarios/bad.scn\""), "{}", stdout(&sarif));
}

#[test]
fn failures_of_one_cause_stand_together_and_all_of_them_in_files() {
    let folder = repository();
    let place = folder.path().join("av/suites");
    let output = scenario_runner(
        &place,
        &["small.suite", "--test-threads", "1", "--json", "all.json", "--tap", "all.tap"],
    );
    let said = stdout(&output);
    let summary = &said[said.find("Summary").unwrap()..];
    assert!(
        summary.contains("small/walk: `max_deceleration >= 1 m/s^2 when tta >= 4 s` failed in 3 of 3 trials"),
        "{summary}"
    );
    assert_eq!(summary.matches("scenario-runner replay 'small/walk/tta=").count(), 1, "{summary}");
    let tap = fs::read_to_string(place.join("all.tap")).unwrap();
    let all: Value = serde_json::from_str(&fs::read_to_string(place.join("all.json")).unwrap()).unwrap();
    let failed: BTreeSet<&str> = all["suites"][0]["trials"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|trial| trial["verdict"] == "failed")
        .map(|trial| trial["key"].as_str().unwrap())
        .collect();
    assert_eq!(failed.len(), 3);
    for key in failed {
        assert!(tap.contains(&format!("- {key}\n")), "{tap}");
    }
}

#[test]
fn a_report_to_somebody_who_has_gone_is_no_error() {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let folder = repository();
    let status = std::process::Command::new(env!("CARGO_BIN_EXE_scenario-runner"))
        .args(["small.suite", "tta=2s", "--json", "/dev/stdout", "--csv", "runs.csv"])
        .current_dir(folder.path().join("av/suites"))
        .stdout(writer)
        .output()
        .unwrap();
    assert_eq!((status.status.code(), &*status.stderr), (Some(0), &b""[..]));
    assert!(folder.path().join("av/suites/runs.csv").exists());
}

#[test]
fn names_of_files_and_words_in_them_command_no_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let name = "red\u{1b}[31m\u{202e}.scn";
    let text = "# \u{1b}[2J\u{9b}2J \u{202e}\nscenario a { sped \u{1b}]0;x\u{7} 3 km/h }\n";
    fs::write(folder.path().join(name), text).unwrap();
    let runs = [
        scenario_runner(folder.path(), &["check", name]),
        scenario_runner(folder.path(), &[name]),
        scenario_runner(folder.path(), &["fmt", name]),
        scenario_runner(folder.path(), &["explain", "E\u{1b}[2J"]),
        scenario_runner(folder.path(), &["--\u{1b}[2J"]),
        scenario_runner(Path::new("."), &["models", "\u{9b}2J"]),
    ];
    for output in runs {
        let said = stdout(&output) + &stderr(&output);
        assert_ne!(code(&output), 0);
        let obeyed = said.chars().find(|letter| letter.is_control() && !matches!(letter, '\n' | '\t'));
        assert!(obeyed.is_none() && !said.contains('\u{202e}'), "{obeyed:?} in {said:?}");
    }
}

#[test]
fn a_report_made_later_needs_neither_the_suite_nor_luck_and_ends_as_the_run_did() {
    let folder = repository();
    let at = |name: &str| folder.path().join(name);
    let output =
        scenario_runner(folder.path(), &["av/suites/small.suite", "--json", "r.json", "--junit", "j.xml"]);
    let failed = code(&output);
    assert_eq!(failed, 100, "{}", stderr(&output));
    fs::remove_dir_all(at("av")).unwrap();
    let report = |arguments: &[&str]| scenario_runner(folder.path(), &[&["report"], arguments].concat());
    let output = report(&["r.json", "--junit", "again.xml", "--html", "page.html"]);
    assert_eq!(code(&output), failed, "{}", stderr(&output));
    assert!(stdout(&output).contains("small/walk"), "{}", stdout(&output));
    assert_eq!(fs::read(at("again.xml")).unwrap(), fs::read(at("j.xml")).unwrap());
    assert!(at("page.html").exists());
    // What is not there, cut short, changed or of somebody else is no result, and nothing is written of it.
    let text = fs::read_to_string(at("r.json")).unwrap();
    fs::write(at("short.json"), &text[..text.len() / 2]).unwrap();
    fs::write(at("green.json"), text.replacen("\"verdict\": \"failed\"", "\"verdict\": \"passed\"", 1))
        .unwrap();
    fs::write(at("other.json"), "{\"numTotalTests\": 3, \"success\": true}").unwrap();
    for file in ["missing.json", "short.json", "green.json", "other.json", "av"] {
        let output = report(&[file, "--junit", "none.xml"]);
        assert_eq!(code(&output), 2, "{file}: {}", stderr(&output));
        assert!(
            stderr(&output).starts_with(&format!("error: cannot report {file}: ")),
            "{}",
            stderr(&output)
        );
        assert!(!at("none.xml").exists(), "{file}");
    }
    // Results are never written over by a report of them.
    let output = report(&["r.json", "--json", "./r.json"]);
    assert_eq!(code(&output), 2, "{}", stderr(&output));
    assert_eq!(fs::read_to_string(at("r.json")).unwrap(), text);
}
