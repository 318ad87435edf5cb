//! Baselines and comparisons as a user makes them, with the binary that ships.

use std::fs;
use std::path::Path;

use crate::support::program::{code, scenario_runner, stderr, stdout};

/// A suite whose car has to brake for most walkers; `more` settings of its controller and `extra` statements.
fn suite(more: &str, extra: &str) -> String {
    format!(
        "suite late {{
  seed 20261121
  scenario walker {{
    road {{ lanes forward, backward; lane_width 4 m; speed_limit 30 km/h; crossing zebra {{ width: 4 m }} }}
    vehicle av {{
      controller carla_behavior {{ profile: normal, obstacle_distance: extended{more} }}
      speed 30 km/h
    }}
    pedestrian walker {{
      model carla_walker
      size 0.375 m x 0.375 m
      start 4 m from lane centre, 2 m from kerb
      appears when time_to_arrival(av) = tta
    }}
    vary tta in [3 s, 3.5 s, 4 s, 4.5 s, 5 s]
    repeat 20
    expect {{ max_deceleration <= 100 m/s^2 }}
  }}
{extra}}}
"
    )
}

/// A folder with the suite as it was, and as it is.
fn folder(before: &str, now: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("before.suite"), before).unwrap();
    fs::write(folder.path().join("now.suite"), now).unwrap();
    folder
}

#[test]
fn a_baseline_is_the_same_bytes_every_time_and_reads_back() {
    let folder = folder(&suite("", GATE), &suite("", GATE));
    for name in ["a.json", "b.json"] {
        let output = scenario_runner(folder.path(), &["baseline", "save", "before.suite", "--out", name]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    }
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("a.json"), read("b.json"));
    let output = scenario_runner(folder.path(), &["baseline", "diff", "a.json", "b.json"]);
    assert!(stdout(&output).ends_with("every run went exactly as before\n"), "{}", stdout(&output));
    let output = scenario_runner(folder.path(), &["compare", "a.json", "now.suite"]);
    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    let output = scenario_runner(folder.path(), &["baseline", "show", "a.json"]);
    assert!(stdout(&output).contains("carla_behavior"), "{}", stdout(&output));
}

#[test]
fn braking_five_percent_later_is_caught() {
    let folder = folder(&suite("", ""), &suite(", braking_distance: 4.75 m", ""));
    let output = scenario_runner(folder.path(), &["compare", "before.suite", "now.suite"]);
    assert_eq!(code(&output), 104, "{}{}", stdout(&output), stderr(&output));
    insta::assert_snapshot!(stdout(&output));
    let output =
        scenario_runner(folder.path(), &["compare", "before.suite", "now.suite", "--format", "markdown"]);
    insta::assert_snapshot!(stdout(&output));
    // And the other way round it is no regression of those metrics.
    let output =
        scenario_runner(folder.path(), &["compare", "now.suite", "before.suite", "--format", "json"]);
    let verdicts: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    let regressed: Vec<_> = verdicts[0]["checks"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|check| check["outcome"] == "regressed")
        .map(|check| check["label"].as_str().unwrap())
        .collect();
    assert!(!regressed.contains(&"min_distance") && !regressed.contains(&"drac"), "{regressed:?}");
}

#[test]
fn two_parameter_files_are_compared_on_one_suite() {
    let folder = folder(&suite("", GATE), "");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("old.scn", "let braking_distance = 5 m\n");
    // Under its whole name, as `tune --save` writes it.
    write("new.scn", "let av_controller_braking_distance = 4.75 m\n");
    write("seconds.scn", "let braking_distance = 5 s\n");
    write("typo.scn", "let breaking_distance = 5 m\n");
    let json = r#"{"name":"braking","source":"by hand","parameters":[
        [{"setting":{"road_user":"av","part":"controller","parameter":"braking_distance"}},4.75]]}"#;
    write("new.json", json);
    let compare = |arguments: &[&str]| {
        let output = scenario_runner(folder.path(), &[&["compare", "before.suite"], arguments].concat());
        (code(&output), stdout(&output) + &stderr(&output))
    };
    let (code, text) =
        compare(&["--parameters", "old.scn", "--parameters", "new.scn", "--format", "markdown"]);
    assert_eq!(code, 104, "{text}");
    assert!(text.contains("av.controller.braking\\_distance: 5 m -&gt; 4.75 m"), "{text}");
    // Over what the suite declares, which is the same as the first.
    let (code, again) = compare(&["--parameters", "new.json", "--format", "markdown"]);
    assert_eq!((code, &again), (104, &text));
    assert_eq!(compare(&["--parameters", "old.scn"]).0, 0);
    let (code, text) = compare(&["--parameters", "seconds.scn"]);
    assert_eq!(code, 2);
    assert!(text.contains("seconds.scn:1:5") && text.contains("is a length, not a time"), "{text}");
    let (code, text) = compare(&["--parameters", "typo.scn"]);
    assert_eq!(code, 2);
    assert!(text.contains("typo.scn:1:5") && text.contains("did you mean `braking_distance`?"), "{text}");
}

/// A gate of one metric that every run has: the program judges it in no time.
const GATE: &str = "  gate braking {
    baseline \"b.json\"
    min_distance not worse by more than 5 % with 95 % confidence
  }
";

#[test]
fn a_gate_is_judged_in_every_run() {
    let weaker = suite(", braking_distance: 4.75 m", GATE);
    let folder = folder(&suite("", GATE), &weaker);
    let run = |arguments: &[&str]| {
        let output = scenario_runner(folder.path(), arguments);
        (code(&output), stdout(&output) + &stderr(&output))
    };
    let (code, text) = run(&["before.suite"]);
    assert_eq!(code, 103);
    assert!(text.contains("gate `braking` cannot be judged: there is no baseline b.json"), "{text}");
    assert!(
        text.contains("record it with `scenario-runner baseline save before.suite --out b.json`"),
        "{text}"
    );
    assert_eq!(run(&["baseline", "save", "before.suite"]).0, 0);
    let (code, text) = run(&["before.suite"]);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("every run went exactly as before"), "{text}");
    // A part of a suite says nothing about the whole: that is no pass, and the last line says so.
    for part in [&["before.suite", "tta=3s"][..], &["before.suite", "--partition", "slice:1/2"]] {
        let output = scenario_runner(folder.path(), part);
        assert_eq!(output.status.code(), Some(102), "{}", stdout(&output));
        let last = stdout(&output).lines().last().unwrap().to_string();
        let said =
            last.starts_with("gate braking is NOT JUDGED: ") && last.contains(" of 5 trials were not run");
        assert!(said, "{last}");
    }
    // Unless nothing of the suite was asked for.
    fs::write(folder.path().join("free.suite"), suite("", "").replace("suite late", "suite free")).unwrap();
    assert_eq!(run(&["before.suite", "free.suite", "free/"]).0, 0);

    let reports = ["--junit", "j.xml", "--json", "r.json", "--tap", "r.tap", "--html", "r.html", "--github"];
    let (code, text) = run(&[&["now.suite"], &reports[..]].concat());
    assert_eq!(code, 104, "{text}");
    assert!(
        text.contains("gate braking ✗ regressed") && text.contains("::error file=now.suite,line=19"),
        "{text}"
    );
    let report = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(report("j.xml").contains("type=\"regression\""));
    assert!(report("r.tap").contains("not ok 6 - late/gate=braking\n"));
    assert!(report("r.html").contains("1 of 6 trials and gates failed"));
    let json: serde_json::Value = serde_json::from_str(&report("r.json")).unwrap();
    assert_eq!(json["suites"][0]["gates"][0]["verdict"], "failed");

    // It has not passed: what failed last is all that it takes to judge it.
    let (code, text) = run(&["now.suite", "--last-failed"]);
    assert_eq!(code, 104, "{text}");

    let other = weaker.replace("suite late", "suite other");
    fs::write(folder.path().join("other.suite"), other).unwrap();
    let (code, text) = run(&["other.suite"]);
    assert_eq!(code, 103);
    assert!(text.contains("it is of suite `late`, and this is suite `other`"), "{text}");
}

#[test]
fn the_gate_that_ships_passes() {
    let folder = tempfile::tempdir().unwrap();
    let suite = Path::new(env!("CARGO_MANIFEST_DIR")).join("suites/zebra_gate.suite");
    let output = scenario_runner(folder.path(), &[&suite.to_string_lossy()]);
    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    assert!(stdout(&output).contains("gate braking ✓ passed"), "{}", stdout(&output));
}

#[test]
fn what_may_not_be_compared_is_refused_with_the_way_out() {
    let now = suite("", "").replace("width: 4 m", "width: 3 m").replace("5 s]", "5 s, 6 s]");
    let folder = folder(&suite("", ""), &now);
    let run = |arguments: &[&str]| {
        let output = scenario_runner(folder.path(), arguments);
        (code(&output), stdout(&output) + &stderr(&output))
    };
    run(&["baseline", "save", "before.suite", "--out", "a.json"]);
    fs::write(folder.path().join("broken.json"), "{ \"baseline\": 1 }").unwrap();
    fs::write(folder.path().join("newer.json"), "{ \"baseline\": 99 }").unwrap();
    let mut said = String::new();
    for arguments in [
        ["compare", "a.json", "now.suite"],
        ["compare", "missing.json", "now.suite"],
        ["compare", "broken.json", "now.suite"],
        ["compare", "newer.json", "now.suite"],
    ] {
        let (code, text) = run(&arguments);
        said += &format!("$ scenario-runner {}\n{text}exit code {code}\n\n", arguments.join(" "));
    }
    insta::assert_snapshot!(said);
}

/// A car that brakes by `deceleration` for somebody who walks in front of it, and a gate that asks for gentle braking.
fn gentle(deceleration: &str) -> String {
    format!(
        "suite gentle {{
  scenario walk {{
    road {{ lanes forward, backward; lane_width 4 m; speed_limit 30 km/h; crossing zebra {{ width: 4 m }} }}
    vehicle av {{
      controller constant_deceleration {{ deceleration: {deceleration}, distance: 20 m }}
      speed 30 km/h
    }}
    pedestrian walker {{
      model scripted {{ speed: 1.4 m/s, stop_after: 4 m, stop_for: 20 s }}
      start 4 m from lane centre, 2 m from kerb
      appears when time_to_arrival(av) = 3 s
    }}
    expect {{ max_deceleration <= 9 m/s^2 }}
  }}
  gate braking {{
    baseline \"gentle.json\"
    max_deceleration not worse
  }}
}}
"
    )
}

#[test]
fn a_new_collision_fails_the_gate_though_no_rule_names_it() {
    let folder = folder(&gentle("4 m/s^2"), &gentle("1 m/s^2"));
    let output = scenario_runner(folder.path(), &["baseline", "save", "before.suite"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(code(&scenario_runner(folder.path(), &["before.suite"])), 0);
    let output = scenario_runner(folder.path(), &["now.suite", "--junit", "j.xml", "--json", "r.json"]);
    let text = stdout(&output);
    assert_eq!(code(&output), 104, "{text}");
    assert!(
        text.contains(
            "new collision in walk: 1 run that had none on the same seed; that needs no statistics"
        ),
        "{text}"
    );
    assert!(text.contains("replay: scenario-runner replay 'gentle/walk/rep=1' now.suite"), "{text}");
    let junit = fs::read_to_string(folder.path().join("j.xml")).unwrap();
    assert!(
        junit.contains(
            "message=\"max_deceleration not worse; no new collision, where the baseline has none\""
        ),
        "{junit}"
    );
    // Who tolerates collisions has to say so.
    let tolerant =
        gentle("1 m/s^2").replace("not worse\n", "not worse\n    collision not worse by more than 100 %\n");
    fs::write(folder.path().join("tolerant.suite"), tolerant).unwrap();
    let output = scenario_runner(folder.path(), &["tolerant.suite"]);
    assert_eq!(code(&output), 0, "{}", stdout(&output));
}

#[test]
fn a_changed_population_is_refused_under_another_seed_too() {
    let standard = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/scenario/population/standard.json");
    let mut people: serde_json::Value = serde_json::from_str(&fs::read_to_string(standard).unwrap()).unwrap();
    let with_people = gentle("4 m/s^2").replace(
        "model scripted { speed: 1.4 m/s, stop_after: 4 m, stop_for: 20 s }",
        "model commotions { variant: oVAoBEvoAIoEAoSNvoPF }\n      individuals 2 of \"people.json\"",
    );
    let folder = folder(&with_people, "");
    let write = |people: &serde_json::Value| {
        fs::write(folder.path().join("people.json"), people.to_string()).unwrap()
    };
    write(&people);
    let run = |arguments: &[&str]| {
        let output = scenario_runner(folder.path(), arguments);
        (code(&output), stdout(&output) + &stderr(&output))
    };
    let (code, text) = run(&["baseline", "save", "before.suite"]);
    assert_eq!(code, 0, "{text}");
    let (code, text) = run(&["before.suite", "--seed", "2"]);
    assert!(code == 0 || code == 102, "{code}: {text}");
    // No report takes the place of what the run reads.
    for read in ["people.json", "gentle.json"] {
        let before = fs::read(folder.path().join(read)).unwrap();
        let (code, text) = run(&["before.suite", "--json", read]);
        assert_eq!(code, 2, "{text}");
        assert!(text.contains("would replace a file that this run reads"), "{text}");
        assert_eq!(fs::read(folder.path().join(read)).unwrap(), before);
    }
    // One person of all changes a little, whether drawn or not.
    let rows = people["individuals"].as_array_mut().unwrap();
    let cell = &mut rows.last_mut().unwrap()[0];
    *cell = (cell.as_f64().unwrap() * 1.000_001).into();
    write(&people);
    for seed in ["1", "2", "3"] {
        let (code, text) = run(&["before.suite", "--seed", seed]);
        assert_eq!(code, 103, "{text}");
        assert!(
            text.contains("the people of people.json are not those of the base, whoever is drawn"),
            "{text}"
        );
    }
}

/// Before anybody relies on a gate it says what it sees; a primary rule sees more than one among many, and too few runs nothing.
#[test]
fn what_a_gate_will_see_is_said_when_its_baseline_is_saved() {
    let gate = |rule: &str| {
        let rules = format!("no metric worse by more than 5 %\n    {rule}");
        format!("  gate careful {{\n    baseline \"late.json\"\n    {rules}\n  }}\n")
    };
    let said = |rule: &str, repeat: &str| {
        let suite = suite("", &gate(rule)).replace("repeat 20", repeat);
        let folder = folder(&suite, &suite);
        let output = scenario_runner(folder.path(), &["baseline", "save", "before.suite"]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        stdout(&output)
    };
    let rise = |said: &str, rule: &str| -> f64 {
        let line = said.lines().find(|line| line.contains("a rise of collision") && line.contains(rule));
        let line = line.unwrap_or_else(|| panic!("{rule}: {said}"));
        let (_, after) = line.split_once(" to about ").unwrap();
        after.split_once(" % is seen in 80 % of cases").unwrap().0.parse().unwrap()
    };
    let (plain, primary) =
        (said("collision not worse", "repeat 20"), said("primary collision not worse", "repeat 20"));
    let (among, alone) =
        (rise(&plain, "`collision not worse`"), rise(&primary, "`primary collision not worse`"));
    assert!(alone < 0.8 * among && among < 25.0, "{alone} %, {among} %");
    // One of 100 is enough on the same seeds: 1 - 0.2^(1/100).
    let new = rise(&plain, "`no new collision, where the baseline has none`");
    assert!((new - 1.6).abs() < 0.01, "{new}");
    let few = said("collision not worse", "repeat 1");
    assert!(few.contains("walker: with these 5 runs no change of collision is seen; it takes "), "{few}");
    assert!(few.contains(" quantities is seen; it takes "), "{few}");
    // Without gates nothing is said.
    let folder = folder(&suite("", ""), &suite("", ""));
    let output = scenario_runner(folder.path(), &["baseline", "save", "before.suite", "--out", "b.json"]);
    assert_eq!(stdout(&output).lines().count(), 1);
}

/// Who tries seeds until one passes has shown nothing, and every report says so; until those that failed pass.
#[test]
fn seeds_that_were_tried_and_did_not_pass_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let suite = |bound: &str| {
        fs::write(
            folder.path().join("s.suite"),
            format!(
                "suite s {{
  scenario walk {{
    road {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
    vehicle av {{ controller constant_speed; speed 30 km/h; start 60 m before crossing }}
    pedestrian walker {{ model scripted; start 2 m from kerb; appears at 0 s }}
    expect {{ max_deceleration {bound} }}
  }}
}}
"
            ),
        )
        .unwrap();
    };
    let run = |arguments: &[&str]| {
        let output = scenario_runner(folder.path(), &[&["s.suite"], arguments].concat());
        (code(&output), stdout(&output))
    };
    let store = folder.path().join(".scenario-runner/seeds.json");
    // Nothing is remembered of what passes.
    suite("<= 9 m/s^2");
    assert_eq!(run(&["--seed", "7"]).0, 0);
    assert!(!store.exists());
    suite("> 9 m/s^2");
    for seed in ["1", "2", "2"] {
        assert_eq!(run(&["--seed", seed]).0, 100);
    }
    suite("<= 9 m/s^2");
    let files = ["--json", "r.json", "--junit", "j.xml", "--html", "r.html"];
    let (code, text) = run(&[&["--seed", "3"][..], &files].concat());
    let said = "the 3rd seed tried; of those before 2 did not pass: 1, 2";
    assert!(code == 0 && text.contains(&format!("seed 3 ({said})")), "{text}");
    let report = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let json: serde_json::Value = serde_json::from_str(&report("r.json")).unwrap();
    let earlier = serde_json::json!([{ "seed": 1, "passed": false }, { "seed": 2, "passed": false }]);
    assert_eq!(json["suites"][0]["earlier_seeds"], earlier);
    for name in ["j.xml", "r.html"] {
        assert!(report(name).contains(said), "{name}");
    }
    // A seed that passed is told as tried; those that failed are forgotten once they pass.
    assert_eq!(run(&["--seed", "1"]).0, 0);
    let (_, text) = run(&["--seed", "4"]);
    assert!(text.contains("seed 4 (the 4th seed tried; of those before 1 did not pass: 2)"), "{text}");
    let (_, text) = run(&["--seed", "2"]);
    assert!(!text.contains("tried"), "{text}");
    assert!(!store.exists());
}

/// What a sequential gate says leaves no doubt ends its suite, and every report says so.
#[test]
fn a_sequential_gate_ends_its_suite() {
    const SEQUENTIAL: &str =
        "  gate careful {\n    baseline \"b.json\"\n    sequential\n    primary collision not worse\n  }\n";
    let folder = folder(&suite("", SEQUENTIAL), &suite(", braking_distance: 2.5 m", SEQUENTIAL));
    let run = |arguments: &[&str]| {
        let output = scenario_runner(folder.path(), arguments);
        (code(&output), stdout(&output) + &stderr(&output))
    };
    assert_eq!(run(&["baseline", "save", "before.suite"]).0, 0);
    let (same, text) = run(&["before.suite"]);
    assert!(
        same == 0 && text.contains("sequential: no doubt at 12 looks before all runs were there"),
        "{text}"
    );
    let (worse, text) = run(&["now.suite", "--json", "r.json", "--junit", "j.xml", "--html", "r.html"]);
    assert_eq!(worse, 104, "{text}");
    for said in [
        "a gate failed before all runs were made; what is left of its suite is not run",
        "sequential: failed after ",
        " of 100 runs, at look ",
        "5 not finished",
    ] {
        assert!(text.contains(said), "{said}: {text}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("r.json")).unwrap()).unwrap();
    let gate = &json["suites"][0]["gates"][0];
    assert_eq!(
        (gate["verdict"].as_str(), gate["result"]["looks"]["ended_it_of"].as_u64()),
        (Some("failed"), Some(100))
    );
    // What was written is read again as it was.
    let (code, again) = run(&["report", "r.json"]);
    assert_eq!(code, 104, "{again}");
    assert!(again.contains("sequential: failed after "), "{again}");
    for page in ["j.xml", "r.html"] {
        let page = fs::read_to_string(folder.path().join(page)).unwrap();
        assert!(page.contains("a gate failed after "), "{page}");
    }
    // Whoever has all runs comes to the same.
    let (code, compared) = run(&["compare", "b.json", "now.suite"]);
    assert!(code == 104 && compared.contains("sequential: failed after "), "{compared}");
}

#[test]
fn a_baseline_is_saved_wherever_a_gate_looks_for_it() {
    let two = format!("{GATE}{}", GATE.replace("braking", "other").replace("b.json", "c.json"));
    let folder = folder(&suite("", &two), "");
    let output = scenario_runner(folder.path(), &["baseline", "save", "before.suite"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("b.json: 5 trials") && stdout(&output).contains("c.json: 5 trials"));
    assert_eq!(code(&scenario_runner(folder.path(), &["before.suite"])), 0);
}
