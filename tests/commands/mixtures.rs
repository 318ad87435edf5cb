//! `calibrate --mix`: populations as one, with where they come from.

use std::fs;

use crate::support::program::{code, scenario_runner, stderr, stdout};

const HERE: &str = r#"{"model": "commotions", "source": "here", "provenance": {"vehicle_speeds": [8.33]},
 "parameters": ["T_delta", "T"], "individuals": [[20, 0.2], [40, 0.3]], "weights": [0.25, 0.75]}"#;
const THERE: &str = r#"{"model": "commotions", "source": "there",
 "parameters": ["T", "T_delta"], "individuals": [[0.1, 80]]}"#;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("here.json"), HERE).unwrap();
    fs::write(folder.path().join("there.json"), THERE).unwrap();
    folder
}

#[test]
fn two_populations_are_walked_with_as_one() {
    let folder = folder();
    let mix = |shares: [&str; 2]| {
        let output = scenario_runner(
            folder.path(),
            &["calibrate", "--mix", shares[0], "--mix", shares[1], "--out", "both.json"],
        );
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let text = fs::read_to_string(folder.path().join("both.json")).unwrap();
        (stdout(&output), serde_json::from_str::<serde_json::Value>(&text).unwrap())
    };
    let (said, halves) = mix(["here.json", "there.json"]);
    assert!(said.contains("a mixture: 50 % of here.json: here; 50 % of there.json: there"), "{said}");
    assert_eq!(halves["individuals"][2], serde_json::json!([80.0, 0.1]));
    assert_eq!(halves["weights"], serde_json::json!([0.125, 0.375, 0.5]));
    assert_eq!(halves["provenance"]["mixture"][0]["provenance"]["vehicle_speeds"][0], 8.33);
    let (_, unequal) = mix(["here.json=0.2", "there.json=0.8"]);
    assert_eq!(unequal["weights"][2], 0.8);
    // It is a population like others.
    let walk = "scenario walk {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 30 km/h }
  pedestrian walker { model commotions; individuals 4 of \"both.json\"; start 1 m from kerb; appears when time_to_arrival(av) = 4 s }
  horizon 20 s
  expect { min_distance >= 0 m undefined passes }
}
";
    fs::write(folder.path().join("walk.scn"), walk).unwrap();
    let output = scenario_runner(folder.path(), &["check", "walk.scn"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}

#[test]
fn what_does_not_mix_is_refused_and_writes_nothing() {
    let folder = folder();
    fs::copy(folder.path().join("here.json"), folder.path().join("copy.json")).unwrap();
    let refused: [(&[&str], &str); 8] = [
        // Those that ship are known by their names.
        (&["--mix", "humans", "--mix", "humans_1"], "`humans_1` has the parameters"),
        (&["--mix", "here.json"], "1 population is no mixture"),
        (&["--mix", "here.json", "--mix", "copy.json"], "they would count twice"),
        (&["--mix", "here.json", "--mix", "humans"], "they cannot stand in one population"),
        (&["--mix", "here.json=0.5", "--mix", "there.json"], "says no share"),
        (&["--mix", "here.json=0.5", "--mix", "there.json=0.6"], "add up to 1.1"),
        (&["--mix", "here.json=half", "--mix", "there.json"], "`half` is no share"),
        (&["--mix", "here.json", "--mix", "nowhere.json"], "cannot read the population nowhere.json"),
    ];
    for (arguments, expected) in refused {
        let output = scenario_runner(folder.path(), &[&["calibrate", "--out", "o.json"], arguments].concat());
        let said = stderr(&output);
        assert_eq!(code(&output), 2, "{said}");
        assert!(said.contains(expected), "{said}");
        assert!(!folder.path().join("o.json").exists());
    }
    let output = scenario_runner(
        folder.path(),
        &["calibrate", "--mix", "here.json", "--mix", "there.json", "--count", "5", "--out", "o.json"],
    );
    assert_eq!(code(&output), 2, "{}", stdout(&output));
}
