//! What a user does at the command line, with the binary that ships.

use std::path::Path;
use std::process::{Command, Output};

use crate::support::program::{self, code, forget_times, stderr};
use files::Disk;
use models::standard;
use runner::experiment::ParameterFile;
use serde_json::Value;

/// Runs the program in the repository's root.
fn scenario_runner(arguments: &[&str]) -> Output {
    program::scenario_runner(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

/// Standard output without what differs from run to run.
fn stdout(output: &Output) -> String {
    program::stdout(output).lines().map(|line| without_time(line) + "\n").collect()
}

/// `PASS [   0.004s] key` as `PASS [time] key`.
fn without_time(line: &str) -> String {
    let Some((before, rest)) = line.split_once('[') else { return line.to_string() };
    match rest.split_once("s]") {
        Some((time, after)) if time.trim().parse::<f64>().is_ok() => format!("{before}[time]{after}"),
        _ => line.to_string(),
    }
}

/// The results of a run as JSON, with more arguments if wanted.
fn results(suite: &str, more: &[&str]) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results.json");
    let path_text = path.to_string_lossy();
    scenario_runner(&[&[suite, "--json", &path_text], more].concat());
    serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap()
}

#[test]
fn the_zebra_suite_passes() {
    let output = scenario_runner(&["suites/zebra.suite", "--test-threads", "1"]);
    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    insta::assert_snapshot!(stdout(&output));
}

#[test]
fn the_unsafe_suite_fails_readably() {
    let output = scenario_runner(&["suites/zebra_unsafe.suite", "--test-threads", "1"]);
    assert_eq!(code(&output), 100);
    insta::assert_snapshot!(stdout(&output));
}

#[test]
fn results_do_not_depend_on_threads() {
    let with = |threads| {
        let mut results = results("suites/zebra.suite", &["--test-threads", threads]);
        forget_times(&mut results);
        results
    };
    assert_eq!(with("1"), with("2"));
}

#[test]
fn every_failing_run_is_replayed_bit_for_bit() {
    let results = results("suites/zebra_unsafe.suite", &[]);
    for trial in results["suites"][0]["trials"].as_array().unwrap() {
        let key = trial["findings"][0]["worst"][0]["key"].as_str().expect("a failing run is named");
        let run = trial["runs"].as_array().unwrap().iter().find(|run| run["key"] == key).unwrap();
        let fingerprint = run["fingerprint"].as_str().unwrap();
        let output = scenario_runner(&["replay", key, "--fingerprint", fingerprint]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        assert!(stdout(&output).contains("the same run, bit for bit"));
        let other = scenario_runner(&["replay", key, "--fingerprint", "0000000000000000"]);
        assert_eq!(code(&other), 100, "another run is not taken for this one");
    }
}

#[test]
fn a_replay_tells_what_happened() {
    // In a folder of its own: what it says depends on whether the suite was run there before.
    let folder = tempfile::tempdir().unwrap();
    for part in ["suites", "scenarios"] {
        copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join(part), &folder.path().join(part));
    }
    let replay =
        || program::scenario_runner(folder.path(), &["replay", "zebra_unsafe/stands_in_lane/tta=6s/rep=1"]);
    let output = replay();
    assert_eq!(code(&output), 0);
    insta::assert_snapshot!(stdout(&output));

    program::scenario_runner(folder.path(), &["suites/zebra_unsafe.suite"]);
    let output = stdout(&replay());
    let last = output.lines().last();
    assert_eq!(last, Some("  the same run, bit for bit, as when its suite was last run"));
}

/// What the folder has is said, and that naming nothing is no success.
#[test]
fn a_project_without_suites_is_told_how_to_begin() {
    let folder = tempfile::tempdir().unwrap();
    let alone = || program::scenario_runner(folder.path(), &[]);
    assert!(code(&alone()) == 2 && stderr(&alone()).contains("scenario-runner init"), "{}", stderr(&alone()));
    std::fs::create_dir(folder.path().join("deep")).unwrap();
    std::fs::write(folder.path().join("deep/walk.scn"), "scenario a {").unwrap();
    assert!(stderr(&alone()).contains("scenario-runner deep/walk.scn"), "{}", stderr(&alone()));
    std::fs::write(folder.path().join("all.suite"), "suite all { \"Every walk.\"; scenarios \"deep/*\" }")
        .unwrap();
    let said = stderr(&alone());
    assert!(said.contains("all.suite  Every walk.") && !said.contains("walk.scn"), "{said}");
}

/// Copies a folder with all that is in it.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &to);
        } else {
            std::fs::copy(entry.path(), to).unwrap();
        }
    }
}

#[test]
fn filters_select_trials() {
    let list = |arguments: &[&str]| {
        stdout(&scenario_runner(&[&["suites/zebra.suite", "--list"], arguments].concat()))
    };
    assert_eq!(list(&["scripted/tta=6s"]), "zebra/scripted/tta=6s\n");
    assert_eq!(list(&["zebra/scripted/tta=6s", "--exact"]), "zebra/scripted/tta=6s\n");
    assert_eq!(list(&["scripted", "--skip", "tta=1"]), "zebra/scripted/tta=6s\n");
    assert_eq!(list(&[]).lines().count(), 12);
}

/// What `--list` prints, for other programs: the same units, with what there is to know of each.
#[test]
fn what_is_listed_is_read_by_programs() {
    let list = |arguments: &[&str]| {
        let listed = scenario_runner(&[&["--list"], arguments].concat());
        assert_eq!(listed.status.code(), Some(0), "{}", stderr(&listed));
        stdout(&listed)
    };
    for words in [
        &["suites/zebra.suite", "scripted"][..],
        &["suites/worst_arrival.suite"],
        &["suites/zebra.suite", "suites/paper/beyond.suite"],
    ] {
        let json: serde_json::Value =
            serde_json::from_str(&list(&[words, &["--format=json"]].concat())).unwrap();
        assert_eq!(json["layout"], 1);
        let units = json["units"].as_array().unwrap();
        let keys: Vec<&str> = units.iter().map(|unit| unit["key"].as_str().unwrap()).collect();
        assert_eq!(keys, list(words).lines().collect::<Vec<_>>());
        for unit in units {
            let place = |name: &str| unit[name].as_str().is_some_and(|text| !text.is_empty());
            assert!(
                place("suite") && place("of") && place("file") && unit["line"].as_u64() > Some(0),
                "{unit}"
            );
            let is_trial = unit["kind"] == "trial";
            assert_eq!(
                is_trial,
                unit["runs"].as_u64() > Some(0) && unit["tags"].is_array() && place("scenario"),
                "{unit}"
            );
            assert!(
                is_trial
                    || ["search", "tune", "evaluate", "statement"].contains(&unit["kind"].as_str().unwrap())
            );
        }
    }
    let alone = scenario_runner(&["suites/zebra.suite", "--format=json"]);
    assert_eq!(alone.status.code(), Some(2), "{}", stdout(&alone));
}

#[test]
fn filter_expressions_select_trials_and_blocks() {
    let list = |arguments: &[&str]| {
        stdout(&scenario_runner(&[&["suites/zebra.suite", "--list"], arguments].concat()))
    };
    assert_eq!(list(&["-E", "scenario(=scripted) & variation(tta <= 6 s)"]), "zebra/scripted/tta=6s\n");
    assert_eq!(list(&["-E", "tag(paper) - variation(tta > 6 s)"]), "zebra/commotions_carla/tta=6s\n");
    let either = list(&["-E", "model(scripted)", "-E", "model(commotions)"]);
    assert_eq!(either.lines().count(), 8, "{either}");
    // With a word of the name, both have to agree.
    assert_eq!(list(&["scripted", "-E", "variation(tta = 6000 ms)"]), "zebra/scripted/tta=6s\n");
    let worst = "suites/worst_arrival.suite";
    let searches = scenario_runner(&[worst, "--list", "-E", "kind(search)"]);
    assert_eq!(stdout(&searches), "worst_arrival/search=low_pet\n");
    // What a block needs comes with it.
    let tuned = stdout(&scenario_runner(&[worst, "--list", "-E", "block(braking)"]));
    assert_eq!(tuned, "worst_arrival/search=low_pet\nworst_arrival/tune=braking_distance\n");

    let listed = scenario_runner(&["list", "suites/zebra.suite", "-E", "variation(tta=6s) & tag(paper)"]);
    assert!(stdout(&listed).starts_with("zebra/commotions_carla  1 trial, 20 runs"), "{}", stdout(&listed));
    assert_eq!(stdout(&listed).lines().count(), 2);
}

#[test]
fn findings_are_written_for_other_programs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a b%.scn");
    std::fs::write(&path, "let speed = 3 kn/h\n").unwrap();
    let found = |format: &str| {
        let output = scenario_runner(&["check", "--format", format, path.to_str().unwrap()]);
        assert_eq!(code(&output), 3, "{}", stderr(&output));
        stdout(&output)
    };
    let data = |format: &str| serde_json::from_str::<serde_json::Value>(&found(format)).unwrap();
    let label = &data("json")["diagnostics"][0]["labels"][0];
    assert_eq!((&label["line"], &label["column"], &label["end_column"]), (&1.into(), &15.into(), &19.into()));
    let result = &data("sarif")["runs"][0]["results"][0];
    assert_eq!(result["ruleId"], "E0401");
    let place = &result["locations"][0]["physicalLocation"];
    assert!(place["artifactLocation"]["uri"].as_str().unwrap().ends_with("/a%20b%25.scn"), "{place}");
    assert_eq!(place["region"]["startColumn"], 15);
    let line = found("github");
    let wanted = "a b%25.scn,line=1,endLine=1,col=15,endColumn=19,title=E0401::there is no unit `kn/h`%0A";
    assert!(line.starts_with("::error file=") && line.contains(wanted), "{line}");
}

#[test]
fn everything_in_a_suite_is_listed_as_text_and_as_json() {
    let gate = "suites/zebra_gate.suite";
    let listed = scenario_runner(&["list", gate, "-E", "kind(gate)"]);
    let braking = stdout(&listed);
    assert!(braking.starts_with("zebra_gate/gate=braking  ") && braking.contains(" rule"), "{braking}");
    assert_eq!(stderr(&listed), "");
    let listed = scenario_runner(&["list", gate, "--format", "json"]);
    let listed: serde_json::Value = serde_json::from_str(&stdout(&listed)).unwrap();
    assert_eq!(listed["version"], 1);
    let listed = listed["listed"].as_array().unwrap();
    let of = |kind: &str| listed.iter().filter(|one| one["kind"] == kind).collect::<Vec<_>>();
    assert!(
        !of("scenario").is_empty() && of("scenario")[0]["counts"]["runs"].as_u64() > Some(0),
        "{listed:?}"
    );
    assert_eq!(of("gate").len(), 1);
    assert_eq!(
        (&of("gate")[0]["name"], &of("gate")[0]["file"]),
        (&"zebra_gate/gate=braking".into(), &gate.into())
    );
    let listed = scenario_runner(&["list", "suites/paper.suite", "-E", "kind(evaluate) | kind(statement)"]);
    assert!(
        stdout(&listed).contains(" conditions") && stdout(&listed).contains(" claim"),
        "{}",
        stdout(&listed)
    );
}

#[test]
fn filter_expressions_that_are_wrong_or_select_nothing_say_so() {
    let wrong = scenario_runner(&["suites/zebra.suite", "-E", "scenaro(a) && tag(b)"]);
    assert_eq!(code(&wrong), 2);
    for words in ["error[E1001]", "did you mean `scenario`?", "error[E1002]", "2 errors"] {
        assert!(stderr(&wrong).contains(words), "{}", stderr(&wrong));
    }
    for program in ["run", "list"] {
        let idle = scenario_runner(&[program, "suites/zebra.suite", "-E", "tag(papr)"]);
        assert_eq!(code(&idle), 4, "{}", stderr(&idle));
        assert!(stderr(&idle).contains("did you mean `paper`?"), "{}", stderr(&idle));
    }
}

#[test]
fn help_tells_of_commands_and_of_the_filter_language() {
    let filter = scenario_runner(&["help", "filter"]);
    assert_eq!(stdout(&filter), stdout(&scenario_runner(&["explain", "filter"])));
    let page = std::fs::read_to_string("docs/filter.md").unwrap_or_default();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write("docs/filter.md", stdout(&filter)).unwrap();
    } else {
        assert!(
            page == stdout(&filter),
            "docs/filter.md is out of date; run the tests once with UPDATE_DOCS=1"
        );
    }
    let list = scenario_runner(&["help", "list"]);
    assert!(code(&list) == 0 && stdout(&list).contains("--tags"), "{}", stdout(&list));
    let all = scenario_runner(&["help"]);
    assert!(code(&all) == 0 && stdout(&all).contains("Exit codes:"), "{}", stdout(&all));
    let unknown = scenario_runner(&["help", "lst"]);
    assert!(code(&unknown) == 2 && stderr(&unknown).contains("help list"), "{}", stderr(&unknown));
}

#[test]
fn what_cannot_be_done_has_its_own_exit_code() {
    let cases: &[(&[&str], i32, &str)] = &[
        (&["suites/zebra.suite", "no_such_trial"], 4, "no trial is selected"),
        (&["suites/zebra.suite", "no_such_trial"], 4, "selected by `no_such_trial`"),
        (&["suites/zebra.suite", "comotions_carla"], 4, "did you mean `commotions_carla`?"),
        (
            &["suites/zebra.suite", "carla_walker/tta=6", "--exact"],
            4,
            "did you mean `zebra/carla_walker/tta=6s`?",
        ),
        (&["zebra"], 2, "no suite or scenario is named"),
        (&["chek", "suites/zebra.suite"], 4, "did you mean the command `check`?"),
        (&["chek"], 2, "there is no command `chek`"),
        (&["repaly", "zebra/scripted/tta=6s/rep=1", "suites/zebra.suite"], 2, "did you mean `replay`?"),
        (&[], 2, "suites/zebra.suite"),
        (&[], 2, "run one of them by `scenario-runner suites/"),
        (&["suites/zebra.suite", "one", "two"], 2, "more than one filter"),
        (&["suites/missing.suite"], 3, "missing.suite"),
        (&["--no-such-flag"], 2, "no-such-flag"),
        (&["replay", "zebra/scripted/tta=6s/rep=9"], 4, "the nearest name is `zebra/scripted/tta=6s/rep=1`"),
        (&["replay", "nothing/x"], 2, "name it"),
        (&["fmt", "tests/language/ok/plain.yaml"], 2, "convert tests/language/ok/plain.yaml --to scn"),
        (&["models", "carla_behaviour"], 2, "`carla_behavior`"),
        (&["suites/zebra.suite", "--junit", "/dev/null/x.xml"], 110, "cannot write"),
    ];
    for (arguments, expected, message) in cases {
        let output = scenario_runner(arguments);
        assert_eq!(code(&output), *expected, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(message), "{arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn junit_can_be_read_back_and_traces_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (junit, traces) = (at("deep/junit.xml"), at("traces"));
    let output = scenario_runner(&["suites/zebra.suite", "scripted", "--junit", &junit, "--trace", &traces]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let report = quick_junit::Report::deserialize_from_str(&std::fs::read_to_string(junit).unwrap()).unwrap();
    assert_eq!(report.test_suites.len(), 3, "one testsuite per scenario");
    let cases = || report.test_suites.iter().flat_map(|suite| &suite.test_cases);
    let skipped =
        |case: &&quick_junit::TestCase| matches!(case.status, quick_junit::TestCaseStatus::Skipped { .. });
    assert_eq!(cases().filter(|case| !skipped(case)).count(), 4);
    assert!(cases().filter(|case| !skipped(case)).all(|case| case.name.as_str().contains("/scripted/")));
    let trace =
        std::fs::read_to_string(Path::new(&traces).join("zebra__scripted__tta=6s__rep=1.csv")).unwrap();
    let mut lines = trace.lines();
    assert_eq!(lines.next(), Some("time_s,who,x_m,y_m,vx_m_s,vy_m_s,acceleration_m_s2,mode,event"));
    assert!(lines.clone().any(|line| line.contains(",walker,")) && lines.any(|line| line.contains(",av,")));
}

#[test]
fn a_search_and_a_tune_from_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (cases, parameters, journal) = (at("low_pet.json"), at("tuned.scn"), at("journal"));
    let suite = "tests/commands/arrival.suite";
    let found = scenario_runner(&["search", "low_pet", suite, "--save", &cases, "--journal", &journal]);
    assert_eq!(code(&found), 0, "{}", stderr(&found));
    insta::assert_snapshot!(stdout(&found));
    let set: Value = serde_json::from_str(&std::fs::read_to_string(cases).unwrap()).unwrap();
    assert!(!set["cases"].as_array().unwrap().is_empty());
    let tuned =
        scenario_runner(&["tune", "braking_distance", suite, "--save", &parameters, "--journal", &journal]);
    assert_eq!(code(&tuned), 0, "{}", stderr(&tuned));
    insta::assert_snapshot!(stdout(&tuned));
    // A scenario that uses what was saved, and the same as a condition, have the number that was chosen.
    let carla = std::fs::read_to_string("scenarios/zebra/commotions_carla.scn").unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/roads");
    let carla = carla.replace("../roads", &shipped.to_string_lossy()).replacen(
        "scenario ",
        "use \"tuned.scn\"\n\nscenario ",
        1,
    );
    let set = "profile: normal, braking_distance: av_controller_braking_distance,";
    std::fs::write(at("again.scn"), carla.replacen("profile: normal,", set, 1)).unwrap();
    let checked = scenario_runner(&["check", &at("again.scn")]);
    assert_eq!(code(&checked), 0, "{}", stderr(&checked));
    let used = lang::load(Path::new(&at("again.scn")), &standard(), &Disk).unwrap().suite;
    let mut settings = used.scenarios[0].vehicles[0].controller.settings.iter();
    let (_, used) = settings.find(|(name, _)| name == "braking_distance").unwrap();
    let used = used.evaluate_number(&Default::default()).unwrap();
    let condition = at("tuned.json");
    scenario_runner(&["tune", "braking_distance", suite, "--save", &condition, "--journal", &journal]);
    let saved = ParameterFile::read(Path::new(&condition), &files::Disk).unwrap();
    let [(target, scenario::Value::Number(chosen))] = &saved.parameters[..] else { panic!("{saved:?}") };
    assert_eq!((target.to_string().as_str(), used), ("av.controller.braking_distance", *chosen));
    let unknown = scenario_runner(&["search", "low_pett", suite]);
    assert_eq!(code(&unknown), 2);
    assert!(stderr(&unknown).contains("it declares `low_pet`"), "{}", stderr(&unknown));
}

#[test]
fn reports_are_written_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (html, tap, summary) = (path("deep/report.html"), path("report.tap"), path("summary.md"));
    let output = Command::new(env!("CARGO_BIN_EXE_scenario-runner"))
        .args(["suites/zebra_unsafe.suite", "--html", &html, "--tap", &tap, "--github"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env("GITHUB_STEP_SUMMARY", &summary)
        .output()
        .expect("the binary runs");
    assert_eq!(code(&output), 100, "{}", stderr(&output));
    assert!(stdout(&output).contains("::error file=scenarios/unsafe/stands_in_lane.scn,line="));
    let page = std::fs::read_to_string(&html).unwrap();
    // Drawn from runs that were run again, which succeeds only if they are the same bit for bit.
    assert!(page.contains("<b>Trajectories</b>") && page.contains("\"key\":\"zebra_unsafe/late_walker/rep="));
    assert!(std::fs::read_to_string(&tap).unwrap().contains("not ok 1 - zebra_unsafe/late_walker\n"));
    assert!(std::fs::read_to_string(&summary).unwrap().contains("## zebra\\_unsafe: 4 ❌ failed"));
}

#[test]
fn trials_that_were_not_selected_are_reported_as_skipped() {
    let results = results("suites/zebra.suite", &["scripted/tta=6s"]);
    let trials = results["suites"][0]["trials"].as_array().unwrap();
    let skipped = trials.iter().filter(|trial| trial["verdict"] == "skipped");
    assert!(skipped.clone().all(|trial| trial["message"] == "not selected"));
    assert_eq!((skipped.count(), trials.len()), (11, 12));
}

#[test]
fn what_ships_is_in_the_one_style() {
    let list = |pattern: &str| {
        let paths = glob::glob(&format!("{}/{pattern}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        paths.map(|path| path.unwrap().to_string_lossy().into_owned()).collect::<Vec<_>>()
    };
    let files = [list("scenarios/**/*.scn"), list("suites/*.suite")].concat();
    assert!(files.len() > 10, "{files:?}");
    let arguments: Vec<&str> =
        ["fmt", "--check"].into_iter().chain(files.iter().map(String::as_str)).collect();
    let output = scenario_runner(&arguments);
    assert_eq!(code(&output), 0, "not formatted: {}{}", stdout(&output), stderr(&output));
    let folder = tempfile::tempdir().unwrap();
    let untidy = folder.path().join("untidy.scn");
    std::fs::write(&untidy, "let   a=1 s\n").unwrap();
    assert_eq!(code(&scenario_runner(&["fmt", "--check", &untidy.to_string_lossy()])), 5);
}
