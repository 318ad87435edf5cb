//! Failing runs made into small scenarios of their own: what is written fails alike.

use std::fs;
use std::path::Path;

use crate::support::program::{scenario_runner, stderr, stdout};
use serde_json::Value;

/// People of their own kind who meet a car at sampled places and times; the second criterion fails in many runs. A
/// second pedestrian stands by.
const ENCOUNTER: &str = "scenario encounter {
  \"People meet a car that does not care.\"
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed pace }
  pedestrian walker {
    model commotions
    individuals 3 of standard
    start back from kerb
    appears when time_to_arrival(av) = tta
  }
  pedestrian bystander { model carla_walker; start 20 m from kerb; along 30 m; appears at 1 s }
  vary tta in [3 s, 5 s, 9 s]
  vary pace in [30 km/h, 40 km/h, 50 km/h]
  vary back in uniform(0.5 m, 2.5 m) 2 times
  repeat 2
  expect { max_deceleration <= 9 m/s^2; pet(av, walker) >= 5 s in 80 % of runs undefined passes }
}
";

/// The results of the only suite of a file.
fn results(folder: &Path, file: &str) -> Value {
    scenario_runner(folder, &[file, "--json", "results.json"]);
    let text = fs::read_to_string(folder.join("results.json")).expect("results are written");
    serde_json::from_str::<Value>(&text).expect("they are JSON")["suites"][0].clone()
}

fn runs(results: &Value) -> impl Iterator<Item = &Value> {
    results["trials"].as_array().unwrap().iter().flat_map(|trial| trial["runs"].as_array().unwrap())
}

/// A folder with the encounter, its results, and the keys of runs that fail it, apart from each other.
fn encounter() -> (tempfile::TempDir, Value, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("encounter.scn"), ENCOUNTER).unwrap();
    let results = results(folder.path(), "encounter.scn");
    let failing = runs(&results).filter(|run| run["criteria"][1]["holds"] == Value::Bool(false));
    let keys: Vec<_> = failing.map(|run| run["key"].as_str().unwrap().to_string()).collect();
    assert!(keys.len() > 8, "the encounter is too harmless: {keys:?}");
    let apart = keys.iter().step_by(keys.len() / 4).take(4).cloned().collect();
    (folder, results, apart)
}

/// Everything measured in the only run of a file.
fn only_run(folder: &Path, file: &str) -> Value {
    let results = results(folder, file);
    let all: Vec<_> = runs(&results).collect();
    assert_eq!(all.len(), 1);
    all[0].clone()
}

#[test]
fn a_run_as_it_is_is_the_same_run_to_the_last_bit() {
    let (folder, results, keys) = encounter();
    for key in keys {
        let output = scenario_runner(
            folder.path(),
            &["shrink", &key, "encounter.scn", "--as-is", "-o", "same.scn", "--force"],
        );
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let before = runs(&results).find(|run| run["key"] == key.as_str()).unwrap();
        let after = only_run(folder.path(), "same.scn");
        for same in ["metrics", "fingerprint", "seed", "ending"] {
            assert_eq!(before[same], after[same], "{same} of {key}");
        }
        assert_eq!(before["criteria"][1]["margin"], after["criteria"][0]["margin"]);
        assert_eq!(after["criteria"][0]["holds"], Value::Bool(false));
    }
}

#[test]
fn a_shrunk_run_fails_the_same_criterion_nearer_to_what_is_declared() {
    let (folder, _, keys) = encounter();
    for key in keys {
        let shrink = |path: &str| {
            let output =
                scenario_runner(folder.path(), &["shrink", &key, "encounter.scn", "-o", path, "--force"]);
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            (fs::read_to_string(folder.path().join(path)).unwrap(), stdout(&output))
        };
        let (text, said) = shrink("shrunk.scn");
        assert_eq!(shrink("again.scn").0, text, "the same run shrinks alike");
        assert!(text.starts_with(&format!("# The run `{key}` of encounter.scn (seed 1)\n")), "{text}");
        for part in ["It fails `pet(av, walker) >= 5 s in 80 % of runs undefined passes`", "all the way"] {
            assert!(text.contains(part) && said.contains(part), "{part}: {text}");
        }
        // Nobody needs the bystander.
        assert!(text.contains("# Left out, for it fails without: bystander"), "{text}");
        assert!(!text.contains("pedestrian bystander"), "{text}");
        let failed = scenario_runner(folder.path(), &["shrunk.scn"]);
        assert_eq!(failed.status.code(), Some(100), "{}{text}", stdout(&failed));
        assert!(stdout(&failed).contains("error: `pet(av, walker) >= 5 s undefined passes` failed"));
        assert_eq!(only_run(folder.path(), "shrunk.scn")["criteria"][0]["holds"], Value::Bool(false));
        let formatted = scenario_runner(folder.path(), &["fmt", "--check", "shrunk.scn"]);
        assert_eq!(formatted.status.code(), Some(0), "{}", stdout(&formatted));
    }
}

#[test]
fn a_value_moves_as_far_as_it_fails_to_a_round_number() {
    let folder = tempfile::tempdir().unwrap();
    // The walker is on the car's line after (2 + 1.75) m / 1.4 m/s = 2.68 s: the two are less than 1.5 s apart where the
    // car comes before 4.18 s.
    let text = "scenario pass {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 30 km/h }
  pedestrian walker {
    model scripted { speed: 1.4 m/s }
    start 2 m from kerb
    appears when time_to_arrival(av) = tta
  }
  vary tta in [3 s, 8 s, 20 s]
  expect { pet >= 1.5 s }
}
";
    fs::write(folder.path().join("pass.scn"), text).unwrap();
    let output = scenario_runner(folder.path(), &["shrink", "pass/pass/tta=3s/rep=1", "pass.scn"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        stdout(&output).contains("  tta  3 s -> 4.1 s  22 % of the way to 8 s, the middle of its values")
    );
    let written = fs::read_to_string(folder.path().join("pass_shrunk.scn")).unwrap();
    assert!(written.contains("appears when time_to_arrival(av) = 4.1 s"), "{written}");
    let run = only_run(folder.path(), "pass_shrunk.scn");
    let margin = run["criteria"][0]["margin"].as_f64().unwrap();
    assert!((-0.1..0.0).contains(&margin), "{margin}");
}

#[test]
fn what_cannot_be_shrunk_is_said() {
    let (folder, results, keys) = encounter();
    let shrink = |more: &[&str]| scenario_runner(folder.path(), &[&["shrink"], more].concat());
    let typo = keys[0].replace("walker", "wolker").replace("encounter/encounter", "encounter/encunter");
    let unknown = shrink(&[&typo, "encounter.scn"]);
    assert_eq!(unknown.status.code(), Some(4));
    assert!(stderr(&unknown).contains(&format!("no run is called `{typo}`")), "{}", stderr(&unknown));
    assert!(stderr(&unknown).contains(&format!("the nearest name is `{}`", keys[0])), "{}", stderr(&unknown));

    let holds = |run: &&Value| run["criteria"].as_array().unwrap().iter().all(|one| one["holds"] == true);
    let harmless = runs(&results).find(holds).expect("some run is harmless")["key"].as_str().unwrap();
    let nothing = shrink(&[harmless, "encounter.scn"]);
    assert_eq!(nothing.status.code(), Some(4));
    assert!(stderr(&nothing).contains("fails nothing"), "{}", stderr(&nothing));

    let other = shrink(&[&keys[0], "encounter.scn", "--criterion", "drac"]);
    assert_eq!(other.status.code(), Some(2));
    assert!(stderr(&other).contains("help: there are `max_deceleration"), "{}", stderr(&other));

    fs::write(folder.path().join("encounter_shrunk.scn"), "mine").unwrap();
    let taken = shrink(&[&keys[0], "encounter.scn"]);
    assert_eq!(taken.status.code(), Some(110));
    assert!(stderr(&taken).contains("`shrink` did not write it"), "{}", stderr(&taken));
    let forced = shrink(&[&keys[0], "encounter.scn", "--as-is", "--force"]);
    assert_eq!(forced.status.code(), Some(110), "not even then");
    assert_eq!(fs::read_to_string(folder.path().join("encounter_shrunk.scn")).unwrap(), "mine");
    fs::remove_file(folder.path().join("encounter_shrunk.scn")).unwrap();
    assert_eq!(shrink(&[&keys[0], "encounter.scn", "--as-is"]).status.code(), Some(0));
    let own = shrink(&[&keys[0], "encounter.scn", "--as-is"]);
    assert_eq!(own.status.code(), Some(110));
    assert!(stderr(&own).contains("`--force` replaces it"), "{}", stderr(&own));
    assert_eq!(shrink(&[&keys[0], "encounter.scn", "--as-is", "--force"]).status.code(), Some(0));
}
