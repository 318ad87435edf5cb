//! The scenario language as users meet it: one file a case, expected findings beside the line they belong to.
//!
//! `#~ E0401 words` at the end of a line expects that code there, with those words in its message. Every file under
//! `tests/language/fails` must give exactly the findings it announces; how they look is held by snapshots.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::generated::stands_in;
use super::properties;

use files::{Disk, Overlay};
use lang::filter::{Filters, Show};
use lang::{self, Code, Diagnostic, Severity, Sources, Style};
use models::standard;
use results::Requests;
use runner::plan;
use runner::project;
use runner::run::{FreeFlows, Unwatched, run_case};
use scenario::{Claim, Suite};

fn folder(name: &str) -> PathBuf {
    Path::new("tests/language").join(name)
}

fn files(name: &str) -> Vec<PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(folder(name))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            let extension = path.extension().and_then(|extension| extension.to_str());
            matches!(extension, Some("scn" | "suite" | "yaml" | "filter"))
        })
        .collect();
    files.sort();
    files
}

fn findings(path: &Path) -> (Vec<Diagnostic>, Sources) {
    match lang::load(path, &standard(), &Disk) {
        Ok(loaded) => {
            let more = project::examine_claims(&loaded.suite, &loaded.sources);
            (loaded.warnings.into_iter().chain(more).collect(), loaded.sources)
        }
        Err(failure) => (failure.diagnostics, failure.sources),
    }
}

/// File, line, code and words that a text announces.
fn announced(name: &str, text: &str) -> Vec<(String, usize, String, String)> {
    text.lines()
        .enumerate()
        .flat_map(|(index, line)| line.split("#~").skip(1).map(move |note| (index + 1, note.trim())))
        .map(|(line, note)| {
            let (code, words) = note.split_once(' ').unwrap_or((note, ""));
            (name.to_string(), line, code.to_string(), words.trim().to_string())
        })
        .collect()
}

/// What was found but not expected, and the other way round. Both name file, line, code and words.
fn differences(
    found: impl IntoIterator<Item = (String, usize, String, String)>,
    mut expected: Vec<(String, usize, String, String)>,
) -> Vec<String> {
    let mut complaints = Vec::new();
    for (file, line, code, message) in found {
        let matching = expected.iter().position(|(name, at, wanted, words)| {
            *name == file && *at == line && *wanted == code && message.contains(words.as_str())
        });
        match matching {
            Some(index) => {
                expected.remove(index);
            }
            None => complaints.push(format!("{file}:{line}: unexpected {code}: {message}")),
        }
    }
    let missing = |(name, line, code, words)| format!("{name}:{line}: missing {code} {words}");
    complaints.into_iter().chain(expected.into_iter().map(missing)).collect()
}

#[test]
fn wrong_files_give_exactly_the_findings_they_announce() {
    let mut complaints = Vec::new();
    for path in files("fails") {
        let (found, sources) = findings(&path);
        let expected = sources.iter().flat_map(|(_, source)| announced(&source.name, &source.text)).collect();
        let found = found.iter().map(|finding| {
            let file = sources.get(finding.span().source).name.clone();
            let line = sources.location(finding.span()).line;
            (file, line, finding.code.name().to_string(), finding.message.clone())
        });
        complaints.extend(differences(found, expected));
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// Twenty thousand files, which no repository should hold.
#[test]
fn patterns_that_match_too_much_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    std::fs::create_dir(folder.path().join("many")).unwrap();
    for number in 0..=20_000 {
        write(&format!("many/{number}.scn"), "");
    }
    write("all.suite", "suite all {\n  scenarios \"many/*\"\n}\n");
    let (found, _) = findings(&folder.path().join("all.suite"));
    let refused = found.iter().find(|one| one.code == Code::TooManyFiles).expect("it is refused");
    assert_eq!(refused.message, "`many/*` matches more than 20000 files and folders");
    assert!(!refused.hints.is_empty());
}

/// One filter expression a file; it is asked about one trial.
#[test]
fn wrong_filters_give_exactly_the_findings_they_announce() {
    for path in files("filters") {
        let text = std::fs::read_to_string(&path).unwrap();
        let code: Vec<&str> = text.lines().map(|line| line.split("#~").next().unwrap()).collect();
        let (found, sources) = match Filters::parse(&[code.join("\n")]) {
            Ok(filters) => (
                properties::ask_of_trial(|trial| filters.warnings(&|show: &mut Show| show(trial))),
                filters.sources,
            ),
            Err(failure) => (failure.diagnostics, failure.sources),
        };
        for finding in &found {
            assert!(!finding.hints.is_empty() && !finding.labels[0].text.is_empty(), "{finding:?}");
        }
        let found = found.iter().map(|finding| {
            let line = sources.location(finding.span()).line;
            ("-E".to_string(), line, finding.code.name().to_string(), finding.message.clone())
        });
        let complaints = differences(found, announced("-E", &text));
        assert!(complaints.is_empty(), "{}:\n{}", path.display(), complaints.join("\n"));
    }
}

/// Files that the language takes but that cannot be run: `check` says so at the line, and `run` stops before it begins.
#[test]
fn files_that_cannot_be_run_are_refused_by_check_and_by_run() {
    let program = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_scenario-runner")).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(3), "{arguments:?}");
        output
    };
    for path in files("run_fails") {
        let name = path.display().to_string();
        if let Err(failure) = lang::load(&path, &standard(), &Disk) {
            panic!("the language takes {name}:\n{}", failure.render(Style::default()));
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let expected = announced(&name, &text);
        let output = program(&["check", "--format", "json", &name]);
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let found = found["diagnostics"].as_array().unwrap();
        let errors = found.iter().filter(|finding| finding["severity"] == "error").map(|finding| {
            assert!(!finding["hints"].as_array().unwrap().is_empty(), "{finding}");
            let text = |value: &serde_json::Value| value.as_str().unwrap().to_string();
            let place = &finding["labels"][0];
            let line = place["line"].as_u64().unwrap();
            (text(&place["file"]), line as usize, text(&finding["code"]), text(&finding["message"]))
        });
        let complaints = differences(errors, expected.clone());
        assert!(complaints.is_empty(), "{}", complaints.join("\n"));
        let said = String::from_utf8(program(&["run", &name]).stderr).unwrap();
        let stage = |code: &str| expected.iter().any(|(.., found, _)| found == code);
        for (_, line, code, words) in &expected {
            // Models are asked once everything is planned.
            if code == "E0518" || !stage("E0518") {
                assert!(
                    said.contains(words) && said.contains(&format!("{name}:{line}:")),
                    "{code} {words}: {said}"
                );
            }
        }
    }
}

/// Files that run, but of which something is to be known: `check` says so at the line, `run` before it begins, and every
/// report and baseline beside the trial.
#[test]
fn warnings_about_models_stand_in_every_report_and_baseline() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    for path in files("run_warns") {
        let name = path.display().to_string();
        let program = |arguments: &[&str]| {
            Command::new(env!("CARGO_BIN_EXE_scenario-runner"))
                .args(arguments)
                .env("NO_COLOR", "1")
                .output()
                .unwrap()
        };
        let expected = announced(&name, &std::fs::read_to_string(&path).unwrap());
        let output = program(&["check", "--format", "json", &name]);
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let found = found["diagnostics"].as_array().unwrap().iter().map(|finding| {
            let text = |value: &serde_json::Value| value.as_str().unwrap().to_string();
            let place = &finding["labels"][0];
            let line = place["line"].as_u64().unwrap();
            (text(&place["file"]), line as usize, text(&finding["code"]), text(&finding["message"]))
        });
        let complaints = differences(found, expected.clone());
        assert!(complaints.is_empty(), "{}", complaints.join("\n"));

        let [json, junit, html, tap, baseline] = ["r.json", "r.xml", "r.html", "r.tap", "b.json"].map(file);
        let output = program(&[
            "run", &name, "--json", &json, "--junit", &junit, "--html", &html, "--tap", &tap, "--github",
        ]);
        let mut said = vec![
            ("stderr", String::from_utf8(output.stderr).unwrap()),
            ("stdout", String::from_utf8(output.stdout).unwrap()),
        ];
        assert!(said[1].1.contains("::warning "), "{}", said[1].1);
        program(&["baseline", "save", &name, "--out", &baseline]);
        for path in [&json, &junit, &html, &tap, &baseline] {
            said.push((path, std::fs::read_to_string(path).unwrap()));
        }
        let shown = program(&["baseline", "show", &baseline]);
        said.push(("baseline show", String::from_utf8(shown.stdout).unwrap()));
        for (where_said, text) in &said {
            for (_, line, _, words) in &expected {
                assert!(text.contains(words), "line {line}: `{words}` is not said in {where_said}");
            }
        }
    }
}

#[test]
fn findings_look_as_they_should() {
    for path in files("fails") {
        let (found, sources) = findings(&path);
        let name = path.file_name().unwrap().to_string_lossy().replace('.', "_");
        insta::with_settings!({ prepend_module_to_snapshot => false, snapshot_path => "../language/snapshots", omit_expression => true }, {
            insta::assert_snapshot!(name, lang::render_all(&found, &sources, Style::default()));
        });
    }
}

#[test]
fn every_finding_says_what_to_do() {
    for path in files("fails") {
        for finding in findings(&path).0 {
            assert!(!finding.hints.is_empty(), "{}: {}", path.display(), finding.message);
            assert!(!finding.labels[0].text.is_empty(), "{}: {}", path.display(), finding.message);
        }
    }
}

#[test]
fn good_files_have_no_errors() {
    for path in files("ok") {
        if let Err(failure) = lang::load(&path, &standard(), &Disk) {
            panic!("{}", failure.render(Style::default()));
        }
    }
}

#[test]
fn good_files_stay_what_they_are_when_formatted() {
    for path in files("ok").into_iter().chain(files("fails")) {
        if path.extension().is_some_and(|extension| extension == "yaml") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let source = Sources::default().add("test", "");
        let Ok(once) = lang::format(source, &text) else { continue };
        assert_eq!(lang::format(source, &once).unwrap(), once, "{}", path.display());
        if let (Ok(before), Ok(after)) = (
            lang::load(&path, &standard(), &Disk),
            lang::load(&path, &standard(), &Overlay::new(&Disk, &path, &once)),
        ) {
            assert_eq!(before.suite.scenarios.len(), after.suite.scenarios.len());
            for (before, after) in before.suite.scenarios.iter().zip(&after.suite.scenarios) {
                assert_eq!(without_places(before), without_places(after), "{}", path.display());
            }
        }
    }
}

/// Every scenario file and suite that can be run: the good test cases and what ships.
fn runnable() -> Vec<PathBuf> {
    let patterns = ["tests/language/ok/*", "scenarios/**/*.scn", "suites/*.suite", "templates/**/*.s[cu]*"];
    let paths = patterns.iter().flat_map(|pattern| glob::glob(pattern).unwrap().map(Result::unwrap));
    let known = |path: &PathBuf| path.extension().is_some_and(|kind| kind == "scn" || kind == "suite");
    let mut paths: Vec<_> =
        paths.filter(known).filter(|path| lang::load(path, &standard(), &Disk).is_ok()).collect();
    paths.sort();
    paths
}

/// Scenarios, searches, tunes, evaluates, statements, gates and everything else that a suite holds, field by field.
#[test]
fn yaml_says_the_same() {
    let paths = runnable();
    assert!(paths.len() >= 15, "{paths:?}");
    for path in paths {
        let text = std::fs::read_to_string(&path).unwrap();
        let source = Sources::default().add("test", "");
        let yaml = lang::to_yaml(source, &text).unwrap();
        // Beside the original, where the paths in it lead to the same files.
        let loaded = lang::load(
            &path.with_extension("yaml"),
            &standard(),
            &Overlay::new(&Disk, &path.with_extension("yaml"), &yaml),
        )
        .unwrap_or_else(|failure| panic!("{yaml}\n{}", failure.render(Style::default())));
        let original = lang::load(&path, &standard(), &Disk).unwrap();
        let lines = |suite: &Suite| serde_json::to_string_pretty(&without_places(suite)).unwrap();
        let (before, after) = (lines(&original.suite), lines(&loaded.suite));
        let differs = before.lines().zip(after.lines()).position(|(before, after)| before != after);
        if let Some(line) = differs.or((before != after).then_some(0)) {
            let around =
                |text: &str| text.lines().skip(line.saturating_sub(6)).take(9).collect::<Vec<_>>().join("\n");
            panic!("{}:\n{}\nas YAML:\n{}", path.display(), around(&before), around(&after));
        }
        // And back again.
        let scn = lang::from_yaml(source, &yaml).unwrap();
        assert_eq!(lang::to_yaml(source, &scn).unwrap(), yaml);
    }
}

/// What the test above compares is there to be compared.
#[test]
fn the_good_files_hold_one_of_everything() {
    let suites: Vec<Suite> =
        files("ok").iter().map(|path| lang::load(path, &standard(), &Disk).unwrap().suite).collect();
    let count = |of: fn(&Suite) -> usize| suites.iter().map(of).sum::<usize>();
    assert!(count(|suite| suite.searches.len()) > 0 && count(|suite| suite.tunes.len()) > 0);
    assert!(count(|suite| suite.evaluates.len()) > 0 && count(|suite| suite.statements.len()) > 0);
    assert!(
        count(|suite| suite.gates.len()) > 0 && count(|suite| usize::from(suite.time_limit.is_some())) > 0
    );
}

/// As JSON, without where things were said.
fn without_places(data: &impl serde::Serialize) -> serde_json::Value {
    fn forget(value: &mut serde_json::Value) {
        match value {
            serde_json::Value::Object(fields) => {
                fields.remove("origin");
                fields.values_mut().for_each(forget);
            }
            serde_json::Value::Array(values) => values.iter_mut().for_each(forget),
            _ => {}
        }
    }
    let mut value = serde_json::to_value(data).unwrap();
    forget(&mut value);
    value
}

#[test]
fn what_is_written_is_read_back_to_the_last_bit() {
    let text = "
scenario all {
  \"With \\\"everything\\\".\"
  tags one, two
  road {
    lanes forward, backward
    lane_width 3.4 m
    speed_limit 50 km/h
    no kerbs
    crossing signalised { width: 3 m, cycle: 61.7 s, pedestrian_green: 20 s, pedestrian_green_from: 1.3 s }
    parked van { along: -12.345678901 m, across: -2.5 m, length: 5 m, width: 2 m }
  }
  step 20 ms; horizon 31 s; finish 80 m; end on collision; repeat 3; seed 18446744073709551615
  vehicle av {
    controller carla_behavior { profile: cautious, braking_distance: 5.123456789012345 m }
    dynamics prius
    size 4.5 m x 1.83 m
    speed 31.7 km/h
    start 61.3 m before crossing
    sees { range: 50 m, occlusion: true }
  }
  vehicle other { controller constant_speed; speed 36 km/h; lane 1; start 8 s before crossing }
  pedestrian first {
    model scripted { speed: 1.37281931 m/s }
    size 0.4 m x 0.5 m
    from far side
    start 1.234 m from kerb
    along 0.5 m; goal 3 m beyond kerb
    appears when time_to_arrival(av.front) = 6.1 s
  }
  pedestrian second { model carla_walker; radius 0.3 m; start 1 m from kerb; appears at 2 s }
  expect { pet(av, second) >= 1.5 s undefined passes; no collision; passed_first != vehicle;
    max_deceleration(av, window: 0.3 s) <= 2.5 m/s^2; gap_accepted }
}
";
    let path = Path::new("all.scn");
    let read = |text: &str| {
        lang::load(path, &standard(), &Overlay::new(&Disk, path, text))
            .unwrap_or_else(|failure| panic!("{text}\n{}", failure.render(Default::default())))
    };
    let before = read(text).suite.scenarios.remove(0);
    let expect: Vec<_> = before
        .criteria
        .iter()
        .map(|criterion| match &criterion.claim {
            Claim::Runs { comparison, .. } => lang::write_comparison(comparison),
            claim => panic!("{claim:?}"),
        })
        .collect();
    let written = lang::write_scenario(&before, &expect, &["All of it.".to_string()], Path::new(""));
    let after = read(&written).suite.scenarios.remove(0);
    assert_eq!(without_places(&before), without_places(&after), "{written}");
    let source = lang::Sources::default().add("all.scn", "");
    assert_eq!(lang::format(source, &written).as_deref(), Ok(written.as_str()));
}

#[test]
fn a_full_scenario_becomes_the_data_it_describes() {
    let loaded = lang::load(&folder("ok/whole.suite"), &standard(), &Disk).unwrap();
    insta::with_settings!({ prepend_module_to_snapshot => false, snapshot_path => "../language/snapshots", omit_expression => true }, {
        insta::assert_json_snapshot!("whole_suite", loaded.suite);
    });
}

#[test]
fn blocks_bring_what_they_build_on() {
    let suite = lang::load(&folder("ok/parts.suite"), &standard(), &Disk).unwrap().suite;
    // What is measured is run; what is only searched or drawn from is there for that alone.
    assert_eq!(suite.scenarios.iter().map(|one| one.name.as_str()).collect::<Vec<_>>(), ["stroll"]);
    assert_eq!(suite.supporting.iter().map(|one| one.name.as_str()).collect::<Vec<_>>(), ["walk"]);
    assert_eq!(suite.searches.iter().map(|one| one.name.as_str()).collect::<Vec<_>>(), ["low_pet"]);
    assert_eq!(suite.tunes.iter().map(|one| one.name.as_str()).collect::<Vec<_>>(), ["near"]);
}

#[test]
fn the_same_file_over_two_ways_is_one() {
    let loaded = lang::load(&folder("ok/twice.suite"), &standard(), &Disk)
        .unwrap_or_else(|failure| panic!("{}", failure.render(Style::default())));
    let suite = loaded.suite;
    assert_eq!(suite.scenarios.iter().map(|one| one.name.as_str()).collect::<Vec<_>>(), ["walk", "stroll"]);
    assert_eq!(
        suite.searches.iter().map(|one| one.name.as_str()).collect::<Vec<_>>(),
        ["low_pet", "nobody_asks"]
    );
    assert!(suite.supporting.is_empty());
}

#[test]
fn variations_choose_what_drives_and_walks() {
    let suite = lang::load(&folder("ok/choices.scn"), &standard(), &Disk).unwrap().suite;
    let plan = runner::plan::plan(&suite).unwrap();
    let chosen = |key: &str| {
        let trial = plan.trials().find(|trial| trial.key == key).unwrap_or_else(|| panic!("no {key}"));
        let world = trial.cases.first().world;
        let car = &world.vehicles[0];
        let person = &world.pedestrians[0];
        [car.controller.model.name(), car.dynamics.model.name(), person.model.model.name()]
            .map(str::to_string)
    };
    let open = "choices/open_settings/vehicle_dynamics";
    assert_eq!(chosen(&format!("{open}=model3/mode=stock/gap=9m")), ["carla_behavior", "model3", "scripted"]);
    assert_eq!(chosen(&format!("{open}=prius/mode=stock/gap=9m")), ["carla_behavior", "prius", "scripted"]);
    let pair = "choices/pairings/driver=autoware/wheels=delay_lag/who=carla_walker";
    assert_eq!(chosen(pair), ["autoware", "delay_lag", "carla_walker"]);
    assert_eq!(chosen("choices/given"), ["carla_behavior", "generic", "carla_walker"]);
    let drawn = plan.trials().filter(|trial| trial.scenario == "drawn");
    for trial in drawn {
        let car = &trial.cases.first().world.vehicles[0];
        assert!(trial.key.contains(&format!("wheels={}", car.dynamics.model)), "{}", trial.key);
    }
}

/// Codes that need a file no repository should hold, or values from the command line (`tests/commands/set.rs`).
const TESTED_ELSEWHERE: [Code; 12] = [
    Code::NotUtf8,
    Code::FileTooLarge,
    Code::TooManyFiles,
    Code::UnknownSetting,
    Code::SetAside,
    // Of the command line alone: tests/under_test/instead.rs.
    Code::PartlyTested,
    // By programs that run: tests/under_test.rs.
    Code::NotAllowed,
    Code::CannotStart,
    Code::NoHello,
    Code::Disagreement,
    Code::KnowsMore,
    Code::Undeterministic,
];

#[test]
fn every_code_is_tested() {
    let mut tested: BTreeSet<String> = TESTED_ELSEWHERE.iter().map(|code| code.name().to_string()).collect();
    for path in files("fails") {
        tested.extend(findings(&path).0.iter().map(|finding| finding.code.name().to_string()));
    }
    for path in files("run_fails").iter().chain(&files("run_warns")).chain(&files("filters")) {
        let text = std::fs::read_to_string(path).unwrap();
        tested.extend(announced("", &text).into_iter().map(|(_, _, code, _)| code));
    }
    let missing: Vec<_> = Code::ALL.iter().filter(|code| !tested.contains(code.name())).collect();
    assert!(Code::ALL.len() >= 60, "there are {} codes", Code::ALL.len());
    assert!(missing.is_empty(), "no file under tests/language/fails leads to {missing:?}");
}

#[test]
fn text_that_is_not_utf8_is_refused_at_its_byte() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("latin.scn");
    std::fs::write(&path, b"# caf\xe9\n").unwrap();
    let (found, sources) = findings(&path);
    assert_eq!(found[0].code, Code::NotUtf8);
    assert!(found[0].message.contains("byte 5 is 0xe9"), "{}", found[0].message);
    assert_eq!(sources.location(found[0].span()).column, 6);
}

#[test]
fn files_beyond_the_limit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.scn");
    std::fs::File::create(&path).unwrap().set_len(lang::LARGEST_FILE as u64 + 1).unwrap();
    assert_eq!(findings(&path).0[0].code, Code::FileTooLarge);
}

#[test]
fn what_might_never_end_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.scn");
    std::fs::create_dir(folder.path().join("folder.scn")).unwrap();
    std::fs::write(&path, "use \"/dev/zero\"\nuse \"folder.scn\"\n").unwrap();
    let (found, _) = findings(&path);
    let codes: Vec<_> = found.iter().map(|finding| finding.code).collect();
    assert_eq!(codes, [Code::UnknownFileKind, Code::UnreadableFile], "{found:?}");
}

#[test]
fn a_file_that_is_not_there_is_refused_with_the_nearest_name() {
    let (found, _) = findings(Path::new("tests/language/ok/everythin.scn"));
    assert_eq!((found[0].code, found[0].severity), (Code::UnreadableFile, Severity::Error));
    assert_eq!(found[0].hints, ["did you mean `everything.scn`?"]);
}

/// The fenced blocks of a language in the reference.
fn examples(language: &str) -> Vec<String> {
    let text = std::fs::read_to_string("docs/language.md").unwrap();
    let fence = format!("```{language}\n");
    text.split(&fence).skip(1).map(|rest| rest.split("```").next().unwrap().to_string()).collect()
}

/// Simulates the first case of every scenario, so that an example that cannot be run is found.
fn run_one_of_each(suite: &Suite) {
    let plan = plan::plan(suite).unwrap_or_else(|errors| panic!("{errors:?}"));
    let mut requests = Requests::defaults(&standard());
    plan.trials().for_each(|trial| requests.include(&trial.criteria));
    for scenario in plan.scenarios() {
        let case = &scenario.trial(0).cases.first();
        let outcome = run_case(case, &requests, &FreeFlows::default(), &mut Unwatched);
        outcome.unwrap_or_else(|error| panic!("{}: {error}", case.key));
    }
}

#[test]
fn the_reference_compiles_and_runs() {
    let whole = examples("scn").concat();
    let pieces = [("docs/whole.scn", whole.clone())];
    let suites = examples("suite").into_iter().map(|text| ("docs/example.suite", text));
    let yaml = examples("yaml").into_iter().map(|text| ("docs/example.yaml", text));
    for (name, text) in pieces.into_iter().chain(suites).chain(yaml) {
        match lang::load(Path::new(name), &standard(), &Overlay::new(&Disk, Path::new(name), &text)) {
            Ok(loaded) => {
                assert!(
                    loaded.warnings.is_empty(),
                    "{}",
                    lang::render_all(&loaded.warnings, &loaded.sources, Style::default())
                );
                run_one_of_each(&loaded.suite);
            }
            Err(failure) => panic!("{}", failure.render(Style::default())),
        }
    }
    assert!(whole.len() > 3000);
}

#[test]
fn the_schema_in_the_repository_is_current() {
    stands_in("grammar/scenario.schema.json", &format!("{:#}\n", lang::yaml_schema(&standard())));
}

#[test]
fn a_file_for_others_to_use_may_be_checked_but_not_run() {
    let path = folder("support/street.scn");
    assert!(lang::examine(&path, &standard(), &Disk).found.is_empty());
    assert_eq!(lang::load(&path, &standard(), &Disk).unwrap_err().diagnostics[0].code, Code::NoScenario);
}
