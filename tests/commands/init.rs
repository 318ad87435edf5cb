//! The starter project of `init`, written into an empty folder and used as a newcomer would.

use std::path::Path;
use std::process::Output;

use crate::support::program::{code, scenario_runner as run};

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

const SCENARIOS: [&str; 3] = ["scenarios/roads/street.scn", "scenarios/zebra.scn", "scenarios/hidden.scn"];
const SUITES: [&str; 2] = ["suites/every_change.suite", "suites/nightly.suite"];

/// Every file below a folder, as `/`-separated paths.
fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => folders.push(path),
                false => {
                    found.push(path.strip_prefix(folder).unwrap().display().to_string().replace('\\', "/"))
                }
            }
        }
    }
    found.sort();
    found
}

#[test]
fn the_starter_project_passes_in_an_empty_folder() {
    let folder = tempfile::tempdir().unwrap();
    let written = run(folder.path(), &["init"]);
    assert_eq!(code(&written), 0, "{}", text(&written));
    assert!(text(&written).contains("scenario-runner suites/every_change.suite"), "{}", text(&written));

    let reports = ["--json", "found.json", "--html", "found.html"];
    let ran = run(folder.path(), &[&["suites/every_change.suite", "--no-progress"], &reports[..]].concat());
    assert_eq!(code(&ran), 0, "{}", text(&ran));
    assert!(text(&ran).contains("10 trials, 67 runs: 10 passed"), "{}", text(&ran));
    let unknown =
        "people of `humans` were observed before vehicles at 50 km/h, and here they meet vehicles at 30 km/h";
    assert_eq!(text(&ran).matches(unknown).count(), 1, "said once: {}", text(&ran));
    let written = |file: &str| std::fs::read_to_string(folder.path().join(file)).unwrap();
    let (json, html) = (written("found.json"), written("found.html"));
    assert_eq!(json.matches(unknown).count(), 1);
    assert_eq!(html.matches("people of `humans` were observed before vehicles at ").count(), 1);
    // Who they are is said beside.
    let packed = json.replace(' ', "");
    assert!(packed.contains(r#""population":"humans""#) && packed.contains(r#""version":2"#));
    assert!(html.contains("humans, version 2, digest "));
    // At the speed that people were observed with there is nothing to be told.
    let known = run(folder.path(), &["suites/every_change.suite", "--no-progress", "--set", "pace=50km/h"]);
    assert!(text(&known).contains("8 trials, 65 runs"), "{}", text(&known));
    assert!(!text(&known).contains("were observed before"), "{}", text(&known));

    let all = [&SCENARIOS[..], &SUITES[..]].concat();
    let checked = run(folder.path(), &[&["check"], all.as_slice()].concat());
    assert_eq!(code(&checked), 0);
    assert!(text(&checked).contains("no errors"), "without warnings: {}", text(&checked));
    let formatted = run(folder.path(), &[&["fmt", "--check"], all.as_slice()].concat());
    assert_eq!(code(&formatted), 0, "{}", text(&formatted));

    let searched = run(folder.path(), &["search", "closest", "suites/nightly.suite"]);
    assert_eq!(code(&searched), 0, "{}", text(&searched));
}

/// The readme invites to break the controller; that has to show.
#[test]
fn a_controller_that_does_not_brake_fails_in_the_starter_project() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), &["init"]);
    let path = folder.path().join("scenarios/zebra.scn");
    let scenario = std::fs::read_to_string(&path).unwrap();
    assert!(scenario.contains("controller yielding\n"));
    std::fs::write(&path, scenario.replace("controller yielding\n", "controller constant_speed\n")).unwrap();
    let ran = run(folder.path(), &["suites/every_change.suite", "--no-progress"]);
    assert_eq!(code(&ran), 100, "{}", text(&ran));
    assert!(text(&ran).contains("`no collision` failed"), "{}", text(&ran));
}

#[test]
fn every_file_of_the_template_is_written_and_told_of() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), &["init", "deep/er"]);
    let written = files(&folder.path().join("deep/er"));
    let mut template = files(Path::new("templates/starter"));
    template.iter_mut().filter(|name| *name == "gitignore").for_each(|name| *name = ".gitignore".to_string());
    template.sort();
    assert_eq!(written, template);
    let list = run(folder.path(), &["init", "--list", "elsewhere"]);
    for name in &written {
        assert!(text(&list).contains(&format!("elsewhere/{name}")), "{name}: {}", text(&list));
    }
    assert!(!folder.path().join("elsewhere").exists(), "--list writes nothing");
    let readme = std::fs::read_to_string("templates/starter/README.md").unwrap();
    for name in SCENARIOS.iter().chain(&SUITES) {
        assert!(readme.contains(&format!("`{name}`")), "the readme does not say what {name} is");
    }
}

#[test]
fn nothing_is_overwritten_and_nothing_half_written() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("README.md"), "mine").unwrap();
    let refused = run(folder.path(), &["init"]);
    assert_eq!(code(&refused), 2);
    assert!(text(&refused).contains("README.md"), "{}", text(&refused));
    assert_eq!(files(folder.path()), ["README.md"]);
    assert_eq!(std::fs::read_to_string(folder.path().join("README.md")).unwrap(), "mine");
    let list = run(folder.path(), &["init", "--list"]);
    assert!(text(&list).contains("README.md") && text(&list).contains("is there already"), "{}", text(&list));
}

/// What each language needs besides is tried by `sdk/tests/check`.
#[test]
fn a_controller_of_ones_own_is_written_in_each_language() {
    for (language, program) in [
        ("python", "controllers/my_av.py"),
        ("c", "controllers/my_av.c"),
        ("rust", "controllers/my_av/src/main.rs"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let written = run(folder.path(), &["init", "--controller", language]);
        assert_eq!(code(&written), 0, "{}", text(&written));
        assert!(text(&written).contains("scenario-runner allow controllers/my_av.scn"), "{}", text(&written));
        let mut expected = files(&Path::new("templates/controllers").join(language));
        for name in &mut expected {
            *name = name.replace("manifest.toml", "Cargo.toml").replace("gitignore", ".gitignore");
        }
        expected.push("scenarios/crossing.scn".to_string());
        if language == "c" {
            expected.push("controllers/scenario_runner_av.h".to_string());
        }
        expected.sort();
        assert_eq!(files(folder.path()), expected);
        let readme = std::fs::read_to_string(folder.path().join("README.md")).unwrap();
        assert!(readme.contains(program), "{readme}");
        let checked = run(folder.path(), &["check", "scenarios/crossing.scn", "controllers/my_av.scn"]);
        assert!(code(&checked) == 0 && text(&checked).contains("no errors"), "{}", text(&checked));
        let formatted =
            run(folder.path(), &["fmt", "--check", "scenarios/crossing.scn", "controllers/my_av.scn"]);
        assert_eq!(code(&formatted), 0, "{}", text(&formatted));
        let refused = run(folder.path(), &["scenarios/crossing.scn"]);
        assert!(code(&refused) == 3 && text(&refused).contains("E1105"), "{}", text(&refused));
        assert_eq!(
            code(&run(folder.path(), &["init", "--controller", language])),
            2,
            "nothing is overwritten"
        );
    }
}
