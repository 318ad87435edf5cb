//! Groups of pedestrians as a user meets them: the same as its members by hand, and what is said of all of them is said of each.

use std::fs;

use serde_json::Value;

use crate::support::program::{code, scenario_runner, stderr, stdout};

const STREET: &str = "road street { lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }";
const CAR: &str =
    "road street; vehicle av { controller constant_speed; speed 40 km/h; start 60 m before crossing }";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, scenario: &str) {
        fs::write(
            self.0.path().join(name),
            format!("{STREET}\nscenario crossing {{ {CAR}\n{scenario}\n}}\n"),
        )
        .unwrap();
    }

    /// What came of a file, with its exit code.
    fn run(&self, name: &str) -> (i32, Value) {
        let ran = scenario_runner(self.0.path(), &[name, "--json", "r.json", "--no-progress"]);
        let text = fs::read_to_string(self.0.path().join("r.json"))
            .unwrap_or_else(|_| panic!("{}{}", stdout(&ran), stderr(&ran)));
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
        format!(
            "pedestrian {name} {{ model commotions {{ ped_free_speed: {speed} }}; start 2 m from kerb; along {place}; appears at late }}\n"
        )
    };
    let group = block("walkers times 3", "each(0 m, 0.7 m, late * 1 m/s)", "each(1.2 m/s, 1.4 m/s, 1.6 m/s)");
    folder.write("group.scn", &format!("{group}{rest}"));
    let by_hand: String = [("0 m", "1.2 m/s"), ("0.7 m", "1.4 m/s"), ("late * 1 m/s", "1.6 m/s")]
        .iter()
        .enumerate()
        .map(|(index, (place, speed))| block(&format!("walkers_{}", index + 1), place, speed))
        .collect();
    fs::create_dir(folder.0.path().join("by_hand")).unwrap();
    folder.write("by_hand/group.scn", &format!("{by_hand}{rest}"));
    let (group, by_hand) = (folder.run("group.scn").1, folder.run("by_hand/group.scn").1);
    assert_eq!(fingerprints(&group), fingerprints(&by_hand));
    assert_eq!(fingerprints(&group).len(), 6);

    let yaml = scenario_runner(folder.0.path(), &["convert", "group.scn", "--to", "yaml"]);
    assert!(stdout(&yaml).contains("times: 3"), "{}", stdout(&yaml));
    fs::create_dir(folder.0.path().join("yaml")).unwrap();
    fs::write(folder.0.path().join("yaml/group.yaml"), stdout(&yaml)).unwrap();
    assert_eq!(fingerprints(&folder.run("yaml/group.yaml").1), fingerprints(&by_hand));
}

/// Everybody is somebody else, in a group and between groups, and who they are depends on the seed alone.
#[test]
fn every_member_is_another_person() {
    let folder = Folder::new();
    let text = |count: &str, group: &str| {
        format!(
            "pedestrian {group} times 5 {{ model commotions; individuals {count} of standard; start 2 m from kerb; along each(0 m, 1 m, 2 m, 3 m, 4 m) }}; expect {{ no collision }}"
        )
    };
    let people = |count: &str, group: &str| -> Vec<String> {
        folder.write("group.scn", &text(count, group));
        let keys = fingerprints(&folder.run("group.scn").1).into_iter().map(|(key, _)| key);
        let numbers = keys.flat_map(|key| {
            let people = key.split('/').find(|part| part.contains('+')).map(str::to_string);
            let people = people.unwrap_or_else(|| panic!("{key}"));
            people.split('+').map(|one| one.split('=').nth(1).unwrap().to_string()).collect::<Vec<_>>()
        });
        numbers.collect()
    };
    let twenty = people("4", "walkers");
    let different: std::collections::BTreeSet<_> = twenty.iter().collect();
    assert_eq!((twenty.len(), different.len()), (20, 20), "{twenty:?}");
    assert_eq!(twenty, people("4", "walkers"));
    assert_ne!(twenty, people("4", "others"));
    assert_eq!(people("1", "walkers"), twenty[..5], "more groups do not change the first ones");
    for (wrong, said) in [("all", "3 are left over"), ("225", "are 1125 people")] {
        folder.write("wrong.scn", &text(wrong, "walkers"));
        let ran = scenario_runner(folder.0.path(), &["check", "wrong.scn"]);
        assert_ne!(code(&ran), 0, "{}", stdout(&ran));
        assert!(stderr(&ran).contains(said) || stdout(&ran).contains(said), "{}", stderr(&ran));
    }
    folder.write("one.scn", &text("4", "walkers").replace("individuals 4", "individual 4"));
    let ran = scenario_runner(folder.0.path(), &["check", "one.scn"]);
    assert!(
        (stdout(&ran) + &stderr(&ran)).contains("individual 4 is one person, and the group `walkers` is 5")
    );
}

/// A parameter that is searched over a group is that of all of its members, and the worst of them counts.
#[test]
fn searches_and_gates_are_about_the_worst_member() {
    let folder = Folder::new();
    let car =
        "road street; vehicle av { controller constant_speed; speed 40 km/h; start 60 m before crossing }";
    let walkers = "pedestrian walkers times 2 { model scripted { speed: 1.4 m/s }; start 2 m from kerb; along each(0 m, 20 m); appears at each(1 s, 0 s) }";
    let suite = format!(
        "{STREET}
         suite crossing {{
           scenario crossing {{ {car}; {walkers}; expect {{ pet(av, walkers) >= 0 s undefined passes }} }}
           search fast {{ in crossing; minimise min_distance(av, walkers); over walkers.model.speed in 1 m/s .. 2 m/s; budget 4 evaluations, by random }}
         }}"
    );
    fs::write(folder.0.path().join("crossing.suite"), suite).unwrap();
    let (exit, results) = folder.run("crossing.suite");
    assert!(exit == 0 || exit == 100, "{results}");
    let found = results["suites"][0]["blocks"][0].to_string();
    assert!(found.contains("min_distance(av, walkers)"), "{found}");
}

/// One of three walks into the car; whoever says something of all of them says it of that one, too.
#[test]
fn what_is_said_of_a_group_is_said_of_each() {
    let folder = Folder::new();
    folder.write(
        "group.scn",
        "pedestrian walkers times 3 { model scripted { speed: 1.4 m/s }; start 2 m from kerb; along each(-30 m, 0 m, 30 m)
           appears when time_to_arrival(av) = each(1 s, 2.5 s, 4 s) }
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
    let said: Vec<(&str, &str)> =
        found.iter().map(|(text, verdict)| (text.as_str(), verdict.as_str())).collect();
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

/// A group of the same name may have other members in another scenario: its metric is one, of those who are there.
#[test]
fn groups_of_one_name_keep_their_own_members() {
    let folder = Folder::new();
    let scenario = |name: &str, count: usize, times: &str| {
        format!(
            "scenario {name} {{ {CAR}
               pedestrian walkers times {count} {{ model scripted {{ speed: 1.4 m/s }}; start 2 m from kerb
                 along each({}); appears when time_to_arrival(av) = each({times}) }}
               expect {{ count(collision(av, walkers)) = 0 }} }}",
            ["-30 m", "0 m", "30 m"][..count].join(", ")
        )
    };
    let (safe, hit) = (scenario("safe", 2, "1 s, 1 s"), scenario("hit", 3, "1 s, 1 s, 2.5 s"));
    for (first, second) in [(&safe, &hit), (&hit, &safe)] {
        fs::write(folder.0.path().join("two.scn"), format!("{STREET}\n{first}\n{second}\n")).unwrap();
        let (exit, results) = folder.run("two.scn");
        assert_eq!(exit, 100, "{results}");
        let trials = results["suites"][0]["trials"].as_array().unwrap();
        assert_eq!(trials.len(), 2);
        for trial in trials {
            let is_hit = trial["key"].as_str().unwrap().ends_with("/hit");
            assert_eq!(trial["findings"][0]["verdict"], if is_hit { "failed" } else { "passed" }, "{trial}");
            let measured = &trial["runs"][0]["metrics"]["collision(av, walkers)"];
            assert_eq!(measured.as_f64(), Some(f64::from(u8::from(is_hit))), "{trial}");
        }
    }
}

/// What a criterion over several people is called is the criterion of one of them, also where no vehicle is named.
#[test]
fn each_is_told_by_their_own_name() {
    let folder = Folder::new();
    folder.write(
        "group.scn",
        "pedestrian walkers times 3 { model scripted { speed: 1.4 m/s }; start 2 m from kerb; along each(-30 m, 0 m, 30 m) }
         expect { crossing_initiation_time(walkers_1, walkers_3) <= 60 s; crossing_initiation_time(walkers) <= 60 s }",
    );
    let texts: Vec<String> = findings(&folder.run("group.scn").1).into_iter().map(|(text, _)| text).collect();
    let wanted =
        ["1", "3", "1", "2", "3"].map(|one| format!("crossing_initiation_time(walkers_{one}) <= 60 s"));
    assert_eq!(texts, wanted);
}

/// The members of a group may differ: then what is shown of a parameter is not that of the first of them.
#[test]
fn a_parameter_in_which_members_differ_varies() {
    let folder = Folder::new();
    let suite = format!(
        "{STREET}
         suite crossing {{
           scenario crossing {{ {CAR}
             pedestrian walkers times 2 {{ model scripted {{ speed: each(1 m/s, 2 m/s) }}; start 2 m from kerb; along each(0 m, 5 m) }}
             expect {{ no collision }} }}
           evaluate paces {{ on crossing; with default as own, {{ walkers.model.speed: 1.5 m/s }} as same; measure mean(min_distance) }}
         }}"
    );
    fs::write(folder.0.path().join("crossing.suite"), suite).unwrap();
    let (_, results) = folder.run("crossing.suite");
    let conditions = results["suites"][0]["blocks"][0].to_string();
    let block = &results["suites"][0]["blocks"][0];
    let of = |index: usize| {
        let parameter = block.pointer(&format!("/result/evaluate/conditions/{index}/parameters/0"));
        parameter.unwrap_or_else(|| panic!("{conditions}")).clone()
    };
    assert_eq!(
        (of(0)["varies"].as_bool(), of(1)["varies"].as_bool()),
        (Some(true), Some(false)),
        "{conditions}"
    );
    assert!(of(0)["value"].is_null() && !of(1)["value"].is_null(), "{conditions}");
}

/// A criterion over a group is one column, which names the member of whom it is worst: first by its verdict, then by its value.
#[test]
fn a_criterion_over_a_group_is_one_column() {
    let folder = Folder::new();
    let group = |criteria: &str| {
        format!(
            "pedestrian walkers times 3 {{ model scripted; start 2 m from kerb; along each(0 m, 1 m, 2 m) }}; expect {{ {criteria} }}"
        )
    };
    let shown = |criteria: &str| {
        folder.write("group.scn", &group(criteria));
        let ran = scenario_runner(folder.0.path(), &["group.scn", "--no-progress"]);
        stdout(&ran)
    };
    let table = shown("min_distance(av, walkers) >= 0.5 m");
    assert_eq!(table.matches("min_distance(av, walkers_1…3)").count(), 1, "{table}");
    assert!(!table.contains("  min_distance(av, walkers_2)"), "{table}");
    assert!(table.matches("closest to").count() <= 1, "{table}");
    // Who is worst is who each of them alone says is worst.
    let value = |member: &str| -> f64 {
        let alone = shown(&format!("min_distance(av, {member}) >= 0.5 m"));
        assert!(alone.contains(&format!("min_distance(av, {member})")), "{alone}");
        let row = alone.lines().find(|line| line.trim_start().starts_with("crossing")).unwrap();
        row.split_whitespace().last().unwrap().parse().unwrap_or_else(|_| panic!("{alone}"))
    };
    let values = ["walkers_1", "walkers_2", "walkers_3"].map(|member| (value(member), member));
    let worst = values.iter().min_by(|one, other| one.0.total_cmp(&other.0)).unwrap();
    let row = table.lines().find(|line| line.trim_start().starts_with("crossing")).unwrap();
    assert!(row.trim_end().ends_with(&format!("{} {}", worst.0, worst.1)), "{values:?}\n{table}");
    // Some of them, and others: each as it is written.
    let some = shown("min_distance(av, walkers_1, walkers_3) >= 0.5 m");
    assert!(some.contains("min_distance(av, walkers_1,3)") || some.contains("walkers_3"), "{some}");
    let apart = shown("min_distance(av, walkers_1) >= 0.5 m; min_distance(av, walkers_2) >= 0.5 m");
    assert!(
        apart.contains("min_distance(av, walkers_1)") && apart.contains("min_distance(av, walkers_2)"),
        "{apart}"
    );
}
