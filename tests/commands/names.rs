//! Two suites, or two files, of one name in one invocation: every report and every command tells them apart.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::support::program::{code, scenario_runner, stderr, stdout};

fn scenario(speed: &str, late: &str) -> String {
    format!(
        "scenario s {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller constant_speed; speed 30 km/h }}
  pedestrian p {{ model scripted {{ speed: {speed} }}; start 2 m from kerb; appears when time_to_arrival(av) = {late} }}
  draw pace from uniform(1 m, 2 m)
  expect {{ no collision }}
}}
"
    )
    .replace("start 2 m", "start pace")
}

/// `a` passes and `b` fails; both are called `zebra`.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("a", scenario("3 m/s", "9 s")), ("b", scenario("1.4 m/s", "3.4 s"))] {
        fs::create_dir_all(folder.path().join(name)).unwrap();
        fs::write(folder.path().join(name).join("x.scn"), text).unwrap();
        fs::write(folder.path().join(name).join("zebra.suite"), "suite zebra {\n  scenarios \"x.scn\"\n}\n")
            .unwrap();
    }
    folder
}

const BOTH: [&str; 2] = ["a/zebra.suite", "b/zebra.suite"];

fn run(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = scenario_runner(folder, arguments);
    (code(&output), format!("{}{}", stdout(&output), stderr(&output)))
}

fn fingerprint(suite: &Value) -> String {
    suite["trials"][0]["runs"][0]["fingerprint"].as_str().unwrap().to_string()
}

#[test]
fn keys_have_the_shortest_end_of_the_path_that_tells_them_apart() {
    let folder = folder();
    let path = folder.path();
    let reports =
        ["--no-progress", "--json=r.json", "--junit=r.xml", "--csv=r.csv", "--tap=r.tap", "--html=r.html"];
    let (exit, said) = run(path, &[&BOTH[..], &reports].concat());
    assert_eq!(exit, 100, "{said}");
    assert!(said.contains("PASS") && said.contains("a/zebra/s") && said.contains("b/zebra/s"), "{said}");
    let read = |name: &str| fs::read_to_string(path.join(name)).unwrap();
    let json: Value = serde_json::from_str(&read("r.json")).unwrap();
    let names: Vec<&str> =
        json["suites"].as_array().unwrap().iter().map(|suite| suite["suite"].as_str().unwrap()).collect();
    assert_eq!(names, ["a/zebra", "b/zebra"]);
    let junit = read("r.xml");
    let cases: Vec<&str> = junit.lines().filter(|line| line.contains("<testcase ")).collect();
    assert_eq!(cases.iter().collect::<BTreeSet<_>>().len(), cases.len(), "{cases:?}");
    for file in ["r.csv", "r.tap", "r.html"] {
        let text = read(file);
        assert!(text.contains("a/zebra") && text.contains("b/zebra"), "{file}");
    }
    let html = read("r.html");
    let ids: Vec<&str> = html.split(" id=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "ids of the page stand once each");

    // What failed is one of them, and is replayed by the name that reports give it, with both files and with its own.
    let (exit, said) = run(path, &[&BOTH[..], &["--last-failed", "--no-progress"]].concat());
    assert_eq!(exit, 100);
    assert!(said.contains("1 trial") && !said.contains("PASS"), "{said}");
    for files in [&BOTH[..], &BOTH[1..]] {
        let (exit, said) = run(path, &[&["replay", "b/zebra/s/rep=1"], files].concat());
        assert_eq!(exit, 0, "{said}");
        assert!(said.contains("COLLIDES"), "{said}");
    }
    let (exit, said) = run(path, &["replay", "zebra/s/rep=1", BOTH[0], BOTH[1]]);
    assert!(exit != 0 && said.contains("the nearest name is"), "{said}");
    // A name of one that is alone is selected by either.
    for word in ["b/zebra/s", "zebra/s"] {
        let (exit, said) = run(path, &[BOTH[1], word, "--exact", "--list"]);
        assert!(exit == 0 && said.contains("zebra/s"), "{said}");
    }
}

#[test]
fn runs_and_what_is_kept_beside_a_suite_are_the_same_alone_and_together() {
    let folder = folder();
    let path = folder.path();
    let json = |name: &str| -> Value {
        serde_json::from_str(&fs::read_to_string(path.join(name)).unwrap()).unwrap()
    };
    run(path, &[&BOTH[..], &["--json", "both.json", "--record-failures", "--no-progress"]].concat());
    let kept = fs::read_to_string(path.join("b/zebra.failures")).unwrap();
    assert!(kept.contains("\nzebra/s/rep=1\n"), "{kept}");
    assert!(!path.join("a/zebra.failures").exists());
    run(path, &[BOTH[1], "--json", "one.json", "--no-progress", "-E", "!kind(recorded)"]);
    let (both, one) = (json("both.json"), json("one.json"));
    assert_eq!(one["suites"][0]["suite"], "zebra", "of one that is alone keys stay as they are");
    assert_eq!(one["suites"][0]["trials"][0]["key"], "zebra/s");
    assert_eq!(fingerprint(&one["suites"][0]), fingerprint(&both["suites"][1]));
    assert_ne!(fingerprint(&both["suites"][0]), fingerprint(&both["suites"][1]));
    // The recorded run has a key of its own in both.
    let (_, said) = run(path, &[&BOTH[..], &["--list"]].concat());
    assert!(said.contains("b/zebra/recorded=s/rep=1"), "{said}");
}

#[test]
fn a_file_that_is_named_twice_is_run_once() {
    let folder = folder();
    let (exit, said) = run(folder.path(), &["a/zebra.suite", "./a/zebra.suite", "--no-progress"]);
    assert_eq!(exit, 0, "{said}");
    assert!(said.contains("is named twice: it is run once") && said.contains("1 trial"), "{said}");
}

#[test]
fn scenario_files_of_one_name_are_told_apart_as_well() {
    let folder = folder();
    let (exit, said) = run(folder.path(), &["a/x.scn", "b/x.scn", "--no-progress"]);
    assert_eq!(exit, 100, "{said}");
    assert!(said.contains("a/x/s") && said.contains("b/x/s"), "{said}");
}

#[test]
fn what_failed_is_known_of_each_file_alone_and_together() {
    let folder = folder();
    let path = folder.path();
    run(path, &[&BOTH[..], &["--no-progress"]].concat());
    // The one that failed is known where it is alone, however it is named.
    for file in [BOTH[1], "./b/../b/zebra.suite"] {
        let (exit, said) = run(path, &["--last-failed", "--no-progress", file]);
        assert!(exit == 100 && !said.contains("nothing of this is known"), "{said}");
    }
    // That another suite of the name passes takes nothing away.
    let (exit, said) = run(path, &["--last-failed", "--no-progress", BOTH[0]]);
    assert!(exit == 0 && said.contains("nothing of this is known"), "{said}");
    let (exit, said) = run(path, &[&["--last-failed", "--no-progress"], &BOTH[..]].concat());
    assert!(exit == 100 && said.contains("1 trial") && said.contains("b/zebra/s"), "{said}");
}

#[test]
fn all_of_them_are_listed_and_drawn_by_the_same_names() {
    let folder = folder();
    let (exit, said) = run(folder.path(), &["list", BOTH[0], BOTH[1], "./b/zebra.suite"]);
    assert_eq!(exit, 0, "{said}");
    let listed: Vec<&str> = said.lines().filter(|line| line.contains("zebra/s ")).collect();
    assert_eq!(listed.len(), 2, "{said}");
    assert!(said.contains("a/zebra/s") && said.contains("b/zebra/s"), "{said}");
    let (exit, said) = run(folder.path(), &["sketch", BOTH[1], "b/zebra/s"]);
    assert_eq!(exit, 0, "{said}");
}

#[test]
fn tunes_of_one_name_keep_a_journal_each_and_answer_as_alone() {
    let folder = folder();
    let path = folder.path();
    let suite = "use \"../a/x.scn\"\nsuite zebra {\n  scenarios \"../a/x.scn\"\n}\n\
                 tune t { on s; over p.model.speed in 2 m/s .. 3 m/s; minimise mean(time_lost); \
                 budget 2 evaluations, 2 random first }\n";
    BOTH.iter().for_each(|file| fs::write(path.join(file), suite).unwrap());
    let tune = |name: &str, index: usize| -> Value {
        let all: Value = serde_json::from_str(&fs::read_to_string(path.join(name)).unwrap()).unwrap();
        all["suites"][index]["blocks"][0]["result"]["tune"].clone()
    };
    let (exit, said) = run(path, &[&BOTH[..], &["--json", "both.json", "--no-progress"]].concat());
    assert_eq!(exit, 0, "{said}");
    let journals = fs::read_dir(path.join(".scenario-runner/journal")).unwrap();
    assert_eq!(journals.count(), 2, "{said}");
    run(path, &[BOTH[1], "--json", "one.json", "--no-progress"]);
    assert!(tune("one.json", 0)["chosen"].is_object());
    assert_eq!(tune("one.json", 0), tune("both.json", 1));
    assert_eq!(tune("one.json", 0), tune("both.json", 0));
}
