//! `diff KEY`: one run made in two ways as users read it, and what it must not claim.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::support::program::{code, scenario_runner, stderr, stdout};
use serde_json::Value;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

const FILE: &str = "scenario drive {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller carla_behavior; speed 36 km/h; start 60 m before crossing }
  let patience = 4 s
  pedestrian walker {
    model carla_walker
    start 1 m from kerb
    appears when time_to_arrival(av) = tta
  }
  vary tta in [2 s, 4 s, 6 s]
  repeat 3
  expect { no collision; pet >= 1.5 s; time_lost <= patience }
}
";

const KEY: &str = "a/drive/tta=2s/rep=2";

/// What is said of a run of the file, with more arguments.
fn diff(arguments: &[&str]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.scn"), FILE).unwrap();
    fs::write(folder.path().join("b.scn"), FILE).unwrap();
    scenario_runner(folder.path(), &[&["diff"], arguments].concat())
}

fn told(arguments: &[&str]) -> String {
    let output = diff(&[&[KEY, "a.scn"], arguments].concat());
    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    stdout(&output)
}

#[test]
fn two_controllers_and_two_parameters_are_laid_side_by_side() {
    let parameters = told(&["--set", "av.controller.braking_distance=4m,9m"]);
    let controllers = scenario_runner(
        root(),
        &["diff", "zebra/scripted/tta=6s/rep=1", "--controller", "av=carla_behavior,idm_aeb"],
    );
    for (name, said) in [("parameters", parameters), ("controllers", stdout(&controllers))] {
        let lines = said.lines().count();
        assert!((10..=35).contains(&lines), "{lines} lines: {said}");
        insta::assert_snapshot!(format!("diff_{name}"), said);
    }
}

#[test]
fn json_has_everything_and_is_exchanged_with_the_two() {
    let json = |value: &str| -> Value {
        serde_json::from_str(&told(&["--set", value, "--json"])).expect("it is JSON")
    };
    let [forth, back] = [json("tta=2s,4s"), json("tta=4s,2s")];
    assert_eq!(forth["seed"], back["seed"]);
    let without = |side: &Value| {
        let mut side = side.clone();
        side.as_object_mut().unwrap().remove("otherwise");
        side
    };
    assert_eq!(without(&forth["a"]), without(&back["b"]));
    assert_eq!(without(&forth["b"]), without(&back["a"]));
    assert_eq!(forth["parts"]["time"], back["parts"]["time"]);
    assert_eq!(forth["verdict_changes"], back["verdict_changes"]);
    let metrics = |json: &Value, one: &str, other: &str| -> Vec<(Value, Value, Value)> {
        let all = json["metrics"].as_array().unwrap().iter();
        all.map(|one_of| (one_of["metric"].clone(), one_of[one].clone(), one_of[other].clone())).collect()
    };
    assert_eq!(metrics(&forth, "a", "b"), metrics(&back, "b", "a"));
    // The run of the key itself is the one that `replay` makes.
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.scn"), FILE).unwrap();
    let replay = stdout(&scenario_runner(folder.path(), &["replay", KEY, "a.scn"]));
    let fingerprint = forth["a"]["fingerprint"].as_str().unwrap();
    assert!(replay.contains(&format!("fingerprint  {fingerprint}")), "{replay}");
}

#[test]
fn equal_values_do_not_part() {
    for same in ["tta=2s,2s", "tta=2s,2000ms", "av.speed=36km/h,10m/s"] {
        let said = told(&["--set", same]);
        assert!(said.contains("they do not part: the same bit for bit"), "{same}: {said}");
        assert!(said.contains("all 25 metrics are the same in both"), "{said}");
    }
    let said = told(&["--controller", "av=idm_aeb,idm_aeb"]);
    assert!(said.contains("nothing that this run is made of depends on what is otherwise"), "{said}");
}

/// A bound is no part of the run: it does not part, and the verdict does.
#[test]
fn what_only_judges_changes_the_verdict_alone() {
    let said = told(&["--controller", "av=idm_aeb", "--set", "patience=1s,60s"]);
    assert!(said.contains("they do not part"), "{said}");
    assert!(said.contains("the verdict changes, A fails, B passes"), "{said}");
    assert!(said.contains("`time_lost <= patience`: A FAILS, time_lost 8.591 s (-7.591 s)"), "{said}");
}

/// What the horizon cut off in both looks the same and was not seen.
#[test]
fn who_is_cut_off_in_both_is_not_the_same() {
    let said = told(&["--set", "horizon=3s", "--controller", "av=carla_behavior,carla_behavior"]);
    assert!(said.contains("Both are cut off: what would have come was not seen"), "{said}");
    assert!(said.contains("each ends before somebody was met") || said.contains("each fails"), "{said}");
}

#[test]
fn another_value_is_on_the_noise_of_the_run_that_was_asked_for() {
    let said = told(&["--set", "tta=2s,4s"]);
    assert!(said.contains("B  tta=4s  (as a/drive/tta=4s/rep=2)"), "{said}");
    let remark = format!(
        "B is made on the noise of {KEY}: when its suite is run, a/drive/tta=4s/rep=2 has another seed"
    );
    assert!(said.contains(&remark) && !said.contains("A is made on the noise"), "{said}");
}

#[test]
fn a_baseline_has_metrics_and_no_courses() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.scn"), FILE).unwrap();
    let run = |arguments: &[&str]| scenario_runner(folder.path(), arguments);
    assert!(matches!(code(&run(&["baseline", "save", "a.scn", "--out", "b.json"])), 0 | 100));
    let same = run(&["diff", KEY, "a.scn", "--baseline", "b.json"]);
    assert_eq!(code(&same), 0, "{}", stderr(&same));
    let said = stdout(&same);
    assert!(said.contains("all 25 metrics are the same in both"), "{said}");
    assert!(said.contains("whether the course is the same cannot be told"), "{said}");
    let other = stdout(&run(&["diff", KEY, "a.scn", "--baseline", "b.json", "--controller", "av=idm_aeb"]));
    assert!(other.contains("av.controller: carla_behavior -> idm_aeb"), "{other}");
    assert!(other.contains("collision     yes -> no"), "{other}");
    // A trial of one run has a number for its course.
    fs::write(folder.path().join("a.scn"), FILE.replace("  repeat 3\n", "")).unwrap();
    run(&["baseline", "save", "a.scn", "--out", "one.json"]);
    let one = "a/drive/tta=2s/rep=1";
    let said = stdout(&run(&["diff", one, "a.scn", "--baseline", "one.json"]));
    assert!(said.contains("the course is the same, bit for bit"), "{said}");
    let refused: [(&[&str], &str); 4] = [
        (&["--seed", "9", "--baseline", "one.json"], "have other seeds than now"),
        (&["--baseline", "none.json"], "there is no baseline none.json"),
        (&["--baseline", "a.scn"], "is not a baseline"),
        (&["--set", "tta=2s,4s", "--baseline", "one.json"], "a baseline is one of the two"),
    ];
    for (arguments, error) in refused {
        let output = run(&[&["diff", one, "a.scn"], arguments].concat());
        assert!(code(&output) != 0 && stderr(&output).contains(error), "{}", stderr(&output));
        assert_eq!(stdout(&output), "", "nothing is told besides");
    }
    let gone = run(&["diff", "a/drive/tta=2s/rep=1", "a.scn", "--set", "tta=3s", "--baseline", "one.json"]);
    assert!(code(&gone) != 0, "{}", stdout(&gone));
}

#[test]
fn wrong_input_is_refused_with_its_cure() {
    let refused: [(&[&str], i32, &str, &str); 15] = [
        (&[KEY, "a.scn"], 2, "no option has two values", "--set tta=4s,5s"),
        (&[KEY, "a.scn", "--set", "tta=4s"], 2, "no option has two values", "give two values"),
        (&[KEY, "a.scn", "--set", "tta=1s,2s,3s"], 2, "has 3 values", "one for A and one for B"),
        (&[KEY, "a.scn", "--set", "tta=[1s, 2s],3s"], 2, "gives several values", "one value"),
        (&[KEY, "a.scn", "--set", "tta=4s,5s", "--set", "tta=6s"], 2, "set twice", "leave out one"),
        (&[KEY, "a.scn", "--set", "repeat=1,2"], 2, "`repeat` says how many runs", "name another with KEY"),
        (&[KEY, "a.scn", "--set", "tta=4s,5s", "--html", "b.scn"], 2, "would replace a scenario", ""),
        (&[KEY, "a.scn", "--baseline", "b.json", "--html", "b.html"], 2, "cannot be used with", ""),
        (&[KEY, "a.scn", "--set", "seed=4,5"], 2, "seed of the run", "--seed"),
        (&[KEY, "a.scn", "--set", "tto=4s,5s"], 3, "nothing called `tto`", "did you mean `tta`"),
        (
            &[KEY, "a.scn", "--controller", "ego=idm_aeb,carla_behavior"],
            3,
            "no scenario has a vehicle `ego`",
            "`av`",
        ),
        (
            &[KEY, "a.scn", "--controller", "av=idm_aeb,carla_behavio"],
            3,
            "no controller `carla_behavio`",
            "did you mean",
        ),
        (&["a/drive/tta=2s", "a.scn", "--set", "tta=4s,5s"], 4, "no run is called", "a trial of 3 runs"),
        (
            &["a/drive/tta=2s/rep=8", "a.scn", "--set", "tta=4s,5s"],
            4,
            "no run is called",
            "the nearest name is",
        ),
        (&[KEY, "none.scn", "--set", "tta=4s,5s"], 3, "none.scn", ""),
    ];
    for (arguments, exit, error, help) in refused {
        let output = diff(arguments);
        let said = stderr(&output);
        assert_eq!(code(&output), exit, "{arguments:?}: {said}");
        assert!(said.contains(error) && said.contains(help), "{arguments:?}: {said}");
        assert_eq!(stdout(&output), "");
    }
}

/// A page of its own, whose command makes it again.
#[test]
fn a_page_shows_both_and_how_to_make_it_again() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.scn"), FILE).unwrap();
    let made = |name: &str, arguments: &[&str]| {
        let output = scenario_runner(folder.path(), &[&["diff"], arguments, &["--html", name]].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        fs::read_to_string(folder.path().join(name)).unwrap()
    };
    let more = ["--controller", "av=carla_behavior { braking_distance: 4 m },idm_aeb", "--set", "tta=2s"];
    let page = made("one.html", &[&[KEY, "a.scn"][..], &more].concat());
    let command = page.split("id=\"command\">").nth(1).unwrap().split("</code>").next().unwrap();
    let command = command.replace("&#x27;", "'").replace("&#x2f;", "/").replace("&quot;", "\"");
    assert_eq!(
        command,
        format!(
            "scenario-runner diff '{KEY}' 'a.scn' --controller 'av=carla_behavior {{ braking_distance: 4 m }},idm_aeb' --set 'tta=2s'"
        )
    );
    assert_eq!(page, made("other.html", &[&[KEY, "a.scn"][..], &more].concat()));
    assert!(page.contains("contact in ") || page.contains("No contact of a vehicle in either."), "{page}");
}

/// The course of who is hit ends in the table, too.
#[test]
fn a_contact_has_a_row() {
    let said = told(&["--set", "av.controller.braking_distance=0.1m,9m"]);
    let row = said
        .lines()
        .find(|line| line.contains("contact in A: av with walker"))
        .unwrap_or_else(|| panic!("{said}"));
    let time = said.split("contacts: in A av with walker at ").nth(1).unwrap().split(',').next().unwrap();
    assert!(row.trim_start().starts_with(time), "{row} {time}");
}
