//! `--set NAME=VALUE` and `--repeat N`: as if it stood in the file, checked like it, said in reports, and never taken for the runs
//! that the file declares.

use std::fs;
use std::process::{Command, Output};

use serde_json::Value;

const FILE: &str = "
let early = 1 s
road street { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
define meeting(pace = 1.4 m/s) {
  road street
  vehicle av { controller carla_behavior { profile: normal }; speed 30 km/h }
  pedestrian walker {
    model carla_walker { walking_speed: pace }
    start 2 m from kerb
    appears when time_to_arrival(av) = tta - early
  }
}
scenario walk : meeting {
  vary tta in [6 s, 14 s]
  expect {
    pet >= 20 s undefined passes
    no collision when tta >= 10 s
  }
}
";

/// A folder with the file in it.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self::with(FILE)
    }

    fn with(text: &str) -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        place.write("walks.scn", text);
        place
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.path().join(name), text).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
        command.args(arguments).current_dir(self.0.path()).env("NO_COLOR", "1");
        command.output().expect("the binary runs")
    }

    /// Exit code, standard output and standard error.
    fn said(&self, arguments: &[&str]) -> (i32, String, String) {
        let Output { status, stdout, stderr } = self.run(arguments);
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (status.code().unwrap(), text(stdout), text(stderr))
    }

    fn results(&self, arguments: &[&str]) -> Value {
        let (_, out, err) = self.said(&[arguments, &["--json", "results.json"]].concat());
        let text = fs::read_to_string(self.0.path().join("results.json"));
        serde_json::from_str(&text.unwrap_or_else(|_| panic!("{out}{err}"))).unwrap()
    }
}

/// Keys and fingerprints of all runs.
fn runs(results: &Value) -> Vec<(String, String)> {
    let trials = results["suites"][0]["trials"].as_array().unwrap();
    let runs = trials.iter().flat_map(|trial| trial["runs"].as_array().unwrap());
    let text = |value: &Value| value.as_str().unwrap().to_string();
    runs.map(|run| (text(&run["key"]), text(&run["fingerprint"]))).collect()
}

#[test]
fn a_value_that_is_set_is_as_good_as_written() {
    let place = Place::new();
    for (set, was, written) in [
        ("tta=12s", "[6 s, 14 s]", "[12s]"),
        ("early=1500 ms", "early = 1 s", "early = 1500 ms"),
        ("pace=1.7m/s", "pace = 1.4 m/s", "pace = 1.7m/s"),
        ("av.speed=40km/h", "speed 30 km/h", "speed 40km/h"),
        ("walker.model.start_delay=1s", "walking_speed: pace", "walking_speed: pace, start_delay: 1s"),
        ("walker.along=1m", "start 2 m from kerb", "start 2 m from kerb; along 1m"),
        ("walker.start=3m", "start 2 m", "start 3m"),
        ("horizon=20s", "vary tta", "horizon 20s; vary tta"),
        ("tta=[7s, 12s]", "[6 s, 14 s]", "[7s, 12s]"),
    ] {
        assert!(FILE.contains(was));
        let by_hand = Place::with(&FILE.replace(was, written));
        let (set_runs, written_runs) =
            (runs(&place.results(&["walks.scn", "--set", set])), runs(&by_hand.results(&["walks.scn"])));
        assert_eq!(set_runs, written_runs, "{set}");
        assert_ne!(set_runs, runs(&place.results(&["walks.scn"])), "{set} changes something");
    }
    let again = runs(&place.results(&["walks.scn", "--repeat", "3"]));
    assert_eq!(again.len(), 6);
    assert_eq!(again[0], runs(&place.results(&["walks.scn"]))[0], "the first runs stay what they are");
}

#[test]
fn files_in_yaml_take_the_same_values() {
    let place = Place::new();
    let (_, yaml, _) = place.said(&["convert", "walks.scn", "--to", "yaml"]);
    place.write("walks.yaml", &yaml);
    let set = ["--set", "tta=8s", "--set", "av.controller.braking_distance=9m", "--set", "walker.along=1m"];
    let of = |file: &str| runs(&place.results(&[&[file], &set[..]].concat()));
    assert_eq!(of("walks.yaml"), of("walks.scn"));
    let (code, _, err) = place.said(&["walks.yaml", "--set", "av.speed=-1m/s"]);
    assert!(code == 3 && err.contains("walks.yaml:") && err.contains("-1 m/s"), "{err}");
}

#[test]
fn the_line_to_replay_makes_the_same_run() {
    let place = Place::new();
    let set =
        ["walks.scn", "--set", "tta=5 s", "--set", "walker.model.walking_speed='1.5m/s'", "--repeat", "2"];
    let (code, ..) = place.said(&set);
    assert_eq!(code, 2, "a text in quotes is no speed");
    let set =
        ["walks.scn", "--set", "tta=5 s", "--set", "walker.model.walking_speed=1.5 m/s", "--repeat", "2"];
    let results = place.results(&set);
    assert_eq!(
        results["suites"][0]["set"],
        serde_json::json!(["repeat=2", "tta=5 s", "walker.model.walking_speed=1.5 m/s"])
    );
    let (_, out, err) = place.said(&set);
    assert!(out.contains("with repeat=2, tta=5 s, walker.model.walking_speed=1.5 m/s"), "{out}");
    let text = out + &err;
    let line = text.lines().find_map(|line| line.split_once("replay: ")).expect("a run failed").1;
    assert!(line.contains("--repeat 2 --set 'tta=5 s' --set 'walker.model.walking_speed=1.5 m/s'"), "{line}");
    let program = env!("CARGO_BIN_EXE_scenario-runner");
    let command = line.replacen("scenario-runner", &format!("'{program}'"), 1);
    let replayed = Command::new("sh").args(["-c", &command]).current_dir(place.0.path()).output().unwrap();
    let replayed = String::from_utf8(replayed.stdout).unwrap();
    let runs = runs(&results);
    let (_, fingerprint) = runs.iter().find(|(key, _)| line.contains(key.as_str())).unwrap();
    assert!(replayed.contains(&format!("fingerprint  {fingerprint}")), "{command}\n{replayed}");
    assert!(replayed.contains("the same run, bit for bit, as when its suite was last run"), "{replayed}");
}

#[test]
fn values_that_are_set_are_checked_as_any_others() {
    let place = Place::new();
    let refused = |set: &str, code: &str, words: &str| {
        let (exit, _, err) = place.said(&["walks.scn", "--set", set]);
        assert_eq!(exit, 3, "{set}: {err}");
        assert!(err.contains(code) && err.contains(words), "{set}: {err}");
        err
    };
    let err = refused("av.speed=400km/h", "E0405", "is 400 km/h, but must be between 0 and 360 km/h");
    assert!(err.contains("`av.speed=400km/h` is set on the command line"), "{err}");
    refused("av.speed=4s", "E0402", "not a time");
    refused("av.speed=fast", "E0302", "fast");
    refused("tta=uniform(-9s, -8s) 3 times", "the time to arrival at which", "in walks/walk/tta=-");
    refused("av.sped=40km/h", "E0550", "did you mean `av.speed`?");
    refused("ttta=4s", "E0550", "did you mean `tta`?");
    refused("av.controller.braking_distanc=4m", "E0550", "did you mean `av.controller.braking_distance`?");
    for (arguments, words) in [
        (&["--set", "tta"][..], "write it like tta=4s"),
        (&["--set", "tta=4s }"], "is no value"),
        (&["--set", "tta=4s", "--set", "tta=5s"], "`tta` is set twice"),
        (&["--repeat", "0"], "0"),
    ] {
        let (exit, _, err) = place.said(&[&["walks.scn"], arguments].concat());
        assert!(exit == 2 && err.contains(words), "{arguments:?}: {err}");
    }
}

/// What could be green though nothing was asked: the only criterion is about other values.
#[test]
fn a_run_that_no_criterion_applies_to_is_refused() {
    let place = Place::new();
    let (code, _, err) = place.said(&["walks.scn", "--set", "tta=5s"]);
    assert!(code == 100 && err.contains("W0955"), "the other criterion still judges: {err}");
    let only = Place::with(&FILE.replace("    pet >= 20 s undefined passes\n", ""));
    let (code, _, err) = only.said(&["walks.scn", "--set", "tta=5s"]);
    assert_eq!(code, 3, "{err}");
    assert!(err.contains("no criterion applies to walks/walk/tta=5s"), "{err}");
    let (code, _, err) = only.said(&["walks.scn", "--set", "tta=12s"]);
    assert!(code == 0 || code == 100, "{err}");
}

/// Other values make other runs: nothing of them is mixed with what the files declare.
#[test]
fn what_is_set_is_not_compared_with_what_is_declared() {
    let place = Place::new();
    place.write(
        "all.suite",
        "suite all { scenarios \"walks.scn\"; gate speed { baseline \"all.json\"; no metric worse } }",
    );
    let (code, _, err) = place.said(&["baseline", "save", "all.suite"]);
    assert_eq!(code, 0, "{err}");
    let gate = |arguments: &[&str]| {
        let results = place.results(&[&["all.suite"], arguments].concat());
        results["suites"][0]["gates"][0].clone()
    };
    assert!(gate(&[]).to_string().contains("passed"), "{}", gate(&[]));
    for arguments in [&["--set", "av.controller.braking_distance=9m"][..], &["--repeat", "2"]] {
        let said = gate(arguments).to_string();
        assert!(said.contains("these are not the runs that the baseline is of"), "{said}");
        assert_eq!(place.said(&[&["all.suite"], arguments].concat()).0, 100, "criteria fail by themselves");
    }
    let (code, _, err) = place.said(&["walks.scn", "--set", "tta=5s", "--record-failures"]);
    assert!(code == 110 && err.contains("is left alone"), "{code} {err}");
    assert!(!place.0.path().join("walks.failures").exists());
}

/// A baseline names what was set when it was recorded, and stands for nothing else.
#[test]
fn a_baseline_of_what_was_set_is_one_for_the_same_values_only() {
    let place = Place::new();
    place.write(
        "all.suite",
        "suite all { scenarios \"walks.scn\"; gate speed { baseline \"all.json\"; no metric worse } }",
    );
    let set = ["--set", "av.controller.braking_distance=9m", "--repeat", "2"];
    let other = ["--set", "av.controller.braking_distance=8m"];
    let (code, out, err) = place.said(&[&["baseline", "save", "all.suite"][..], &set].concat());
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("4 runs"), "two trials, run twice: {out}");
    let text = fs::read_to_string(place.0.path().join("all.json")).unwrap();
    assert!(text.contains("\"set\": [\"av.controller.braking_distance=9m\",\"repeat=2\"]"), "{text}");
    let (_, shown, _) = place.said(&["baseline", "show", "all.json"]);
    assert!(shown.contains("with av.controller.braking_distance=9m, repeat=2"), "{shown}");
    let gate = |arguments: &[&str]| {
        place.results(&[&["all.suite"], arguments].concat())["suites"][0]["gates"][0].to_string()
    };
    // In whatever order.
    let turned = ["--repeat", "2", "--set", "av.controller.braking_distance=9m"];
    assert!(gate(&set).contains("passed") && gate(&turned).contains("passed"), "{}", gate(&set));
    assert!(gate(&other).contains("which were run with av.controller.braking_distance=9m, repeat=2"));
    let said = gate(&[]);
    assert!(said.contains("the base was run with av.controller.braking_distance=9m, repeat=2"), "{said}");
    assert!(said.contains("the candidate as the files say"), "{said}");
    // `compare` runs what it compares with the same values.
    let compare = |arguments: &[&str]| place.said(&[&["compare", "all.json"], arguments].concat());
    assert_eq!(compare(&[&["all.suite"][..], &set].concat()).0, 0);
    let (code, _, err) = compare(&["all.suite"]);
    assert!(code == 103 && err.contains("the candidate as the files say"), "{code} {err}");
    assert!(err.contains("baseline save all.suite --out all.json"), "{err}");
    let (code, _, err) = compare(&[&["all.json"][..], &other].concat());
    assert!(code == 2 && err.contains("neither side is run"), "{code} {err}");
    let (code, _, err) = place.said(&["compare", "all.suite", "all.suite", "--set", "av.speed=-1m/s"]);
    assert!(code == 3 && err.contains("E0405"), "{code} {err}");
}

/// A replay begins with what the run fails and the values that it has, each in the unit that it is written in.
#[test]
fn a_replay_says_first_why_the_run_fails() {
    let text =
        FILE.replace("pet >= 20 s undefined passes", "min_distance >= 9000 cm\n    rate(collision) <= 5 %");
    let text = text
        .replace("speed 30 km/h }", "speed cruise }")
        .replace("vary tta", "vary cruise in uniform(36 km/h, 37 km/h) 1 times\n  vary tta");
    let place = Place::with(&text);
    let results = place.results(&["walks.scn", "--set", "tta=6s"]);
    let key = &runs(&results)[0].0;
    let (_, run, _) = place.said(&["walks.scn", "--set", "tta=6s"]);
    assert!(run.contains("worst: min_distance "), "{run}");
    assert!(run.contains(" cm (-"), "{run}");
    let (code, out, err) = place.said(&["replay", key, "walks.scn", "--set", "tta=6s"]);
    assert_eq!(code, 0, "{err}");
    let place_of = |words: &str| out.find(words).unwrap_or_else(|| panic!("no {words} in {out}"));
    let fails = place_of("FAILS `min_distance >= 9000 cm`: min_distance ");
    assert!(place_of("rate(collision) <= 5 %`: collision") > fails);
    assert!(fails < place_of("appears") && place_of("tta          6 s") < fails);
    assert!(place_of("cruise       36.") < fails && place_of("set          tta=6s") < fails);
    let line = out.lines().find(|line| line.contains("FAILS")).unwrap();
    assert!(line.contains(" cm (-") && line.contains(" s, av"), "{line}");
}
