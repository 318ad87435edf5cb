//! Groups of pedestrians as a user meets them: the same as its members by hand, and what is said of all of them is said of each.

use std::fs;

use serde_json::Value;

use crate::support::program::{code, scenario_runner, stdout};

const STREET: &str = "road street { lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }";
const CAR: &str = "road street; vehicle av { controller constant_speed; speed 40 km/h; start 60 m before crossing }";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, scenario: &str) {
        fs::write(self.0.path().join(name), format!("{STREET}\nscenario crossing {{ {CAR}\n{scenario}\n}}\n")).unwrap();
    }

    /// What came of a file, with its exit code.
    fn run(&self, name: &str) -> (i32, Value) {
        let ran = scenario_runner(self.0.path(), &[name, "--json", "r.json", "--no-progress"]);
        let text = fs::read_to_string(self.0.path().join("r.json")).unwrap_or_else(|_| panic!("{}", stdout(&ran)));
        (code(&ran), serde_json::from_str(&text).unwrap())
    }
}

fn fingerprints(results: &Value) -> Vec<(String, String)> {
    let runs = results["suites"][0]["trials"].as_array().unwrap().iter();
    let runs = runs.flat_map(|trial| trial["runs"].as_array().unwrap());
    let said: Vec<_> = runs.map(|run| (run["key"].to_string(), run["fingerprint"].to_string())).collect();
    assert!(!said.is_empty() && said.iter().all(|(_, fingerprint)| fingerprint != "null"), "{results}");
    said
}

/// The findings of the first trial: criterion and verdict.
fn findings(results: &Value) -> Vec<(String, String)> {
    let all = results["suites"][0]["trials"][0]["findings"].as_array().unwrap().iter();
    let text = |value: &Value| value.as_str().unwrap_or_else(|| panic!("{results}")).to_string();
    all.map(|one| (text(&one["criterion"]), text(&one["verdict"]))).collect()
}

#[test]
fn a_group_is_its_members_by_hand() {
    let folder = Folder::new();
    let rest = "repeat 3; vary late in [2 s, 4 s]; expect { no collision }";
    let block = |name: &str, place: &str, speed: &str| {
        format!("pedestrian {name} {{ model commotions {{ k_c: {speed} }}; start 2 m from kerb; along {place}; appears at late }}\n")
    };
    let group = block("walkers times 3", "each(0 m, 0.7 m, late * 1 m/s)", "each(2, 2.5, 3)");
    folder.write("group.scn", &format!("{group}{rest}"));
    let by_hand: String = [("0 m", "2"), ("0.7 m", "2.5"), ("late * 1 m/s", "3")]
        .iter()
        .enumerate()
        .map(|(index, (place, speed))| block(&format!("walkers_{}", index + 1), place, speed))
        .collect();
    fs::create_dir(folder.0.path().join("by_hand")).unwrap();
    folder.write("by_hand/group.scn", &format!("{by_hand}{rest}"));
    let (group, by_hand) = (folder.run("group.scn").1, folder.run("by_hand/group.scn").1);
    assert_eq!(fingerprints(&group), fingerprints(&by_hand));
    assert_eq!(fingerprints(&group).len(), 6);

    let yaml = scenario_runner(folder.0.path(), &["convert", "group.scn", "-o", "yaml/group.yaml"]);
    let _ = yaml;
}

/// One of three walks into the car; whoever says something of all of them says it of that one, too.
#[test]
fn what_is_said_of_a_group_is_said_of_each() {
    let folder = Folder::new();
    folder.write(
        "group.scn",
        "pedestrian walkers times 3 { model scripted { speed: 1.4 m/s }; start 2 m from kerb; along each(-30 m, 0 m, 30 m)
           appears when time_to_arrival(av) = each(2.5 s, 2.5 s, 4 s) }
         expect {
           no collision(av, walkers)
           count(collision(av, walkers)) = 0
           impact_speed(av, walkers) >= 1 m/s undefined passes
           pet(av, walkers) <= 60 s undefined passes
           no collision(av, walkers_1, walkers_3)
         }",
    );
    let (exit, results) = folder.run("group.scn");
    assert_eq!(exit, 100, "{results}");
    let found = findings(&results);
    let said: Vec<(&str, &str)> = found.iter().map(|(text, verdict)| (text.as_str(), verdict.as_str())).collect();
    assert_eq!(
        said,
        [
            ("no collision(av, walkers_1)", "passed"),
            ("no collision(av, walkers_2)", "failed"),
            ("no collision(av, walkers_3)", "passed"),
            ("count(collision(av, walkers)) = 0", "failed"),
            ("impact_speed(av, walkers_1) >= 1 m/s undefined passes", "passed"),
            ("impact_speed(av, walkers_2) >= 1 m/s undefined passes", "passed"),
            ("impact_speed(av, walkers_3) >= 1 m/s undefined passes", "passed"),
            ("pet(av, walkers_1) <= 60 s undefined passes", "passed"),
            ("pet(av, walkers_2) <= 60 s undefined passes", "passed"),
            ("pet(av, walkers_3) <= 60 s undefined passes", "passed"),
            ("no collision(av, walkers_1)", "passed"),
            ("no collision(av, walkers_3)", "passed"),
        ]
    );
}
