//! Code lenses with what the last run came to, and when that is not of the text as it is.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};

use super::lsp::{Editor, address};

const STREET: &str = "road street { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }\n";
const WALK: &str = "\
use \"street.scn\"
scenario unsafe_walk {
  road street
  vehicle av { controller constant_speed; speed 36 km/h; start 40 m before crossing }
  pedestrian walker { model scripted; start 2 m from kerb; appears when time_to_arrival(av) = tta }
  vary tta in [2 s, 3 s]
  expect {
    no collision
    min_ttc >= 60 s undefined passes
  }
}
scenario empty_road : unsafe_walk {
  vary tta in [1 ms]
  pedestrian walker { start 9 m from kerb }
  expect { pet >= 0 s undefined passes }
}
";

struct Folder {
    _folder: tempfile::TempDir,
    root: PathBuf,
    walk: PathBuf,
    editor: Editor,
}

fn folder() -> Folder {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().canonicalize().unwrap();
    let walk = root.join("walk.scn");
    std::fs::write(root.join("street.scn"), STREET).unwrap();
    std::fs::write(&walk, WALK).unwrap();
    let mut editor = Editor::start_with(json!({
        "capabilities": {}, "workspaceFolders": [{ "uri": address(&root), "name": "root" }],
        "initializationOptions": { "results": ["mine.json"] },
    }));
    editor.open(&walk, WALK);
    Folder { _folder: folder, root, walk, editor }
}

impl Folder {
    /// Titles above a scenario, with the arguments of commands.
    fn lenses(&mut self, line: usize) -> Vec<(String, Vec<String>)> {
        let asked = json!({ "textDocument": { "uri": address(&self.walk) } });
        let found = self.editor.ask("textDocument/codeLens", asked);
        let here = found.as_array().unwrap().iter().filter(|one| one["range"]["start"]["line"] == line);
        let words = |one: &Value| {
            let arguments = one["command"]["arguments"][0]["arguments"].as_array();
            let arguments = arguments.into_iter().flatten().map(|word| word.as_str().unwrap().to_string());
            (one["command"]["title"].as_str().unwrap().to_string(), arguments.collect())
        };
        here.map(words).collect()
    }

    fn titles(&mut self, line: usize) -> Vec<String> {
        self.lenses(line).into_iter().map(|(title, _)| title).collect()
    }

    /// What an editor does when a lens is chosen.
    fn start(&self, arguments: &[String]) -> std::process::Output {
        let mut program = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
        program.args(arguments).current_dir(&self.root).output().unwrap()
    }

    fn run(&mut self, line: usize) {
        let (_, arguments) = self.lenses(line).into_iter().find(|(title, _)| title == "Run").unwrap();
        self.start(&arguments);
    }

    /// Findings of the last run: severity, line and message.
    fn findings(&mut self) -> Vec<(u64, u64, String)> {
        self.editor.tell("workspace/didChangeWatchedFiles", json!({ "changes": [] }));
        let (walk, _) = (self.walk.clone(), self.titles(1));
        let shown = self.editor.findings[&address(&walk)].iter().filter(|one| one["source"] == "last run");
        let words = |one: &Value| {
            let line = one["range"]["start"]["line"].as_u64().unwrap();
            (one["severity"].as_u64().unwrap(), line, one["message"].as_str().unwrap().to_string())
        };
        shown.map(words).collect()
    }

    fn results(&self) -> PathBuf {
        self.root.join(".scenario-runner/results/walk.scn/scenario/unsafe_walk.json")
    }

    fn edit(&self, change: impl FnOnce(&mut Value)) {
        let mut results: Value = serde_json::from_slice(&std::fs::read(self.results()).unwrap()).unwrap();
        change(&mut results);
        write(&self.results(), &results.to_string());
    }
}

/// Writes a file whose time and size need not tell that it was written.
fn write(path: &Path, text: &str) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, text).unwrap();
}

#[test]
fn a_result_is_of_the_text_or_stale() {
    let mut folder = folder();
    assert_eq!(folder.titles(1), ["Run"]);
    folder.run(1);
    let lenses = folder.lenses(1);
    assert_eq!(lenses[2].0, "last run failed: 2 of 2 trials");
    assert_eq!(lenses[1].0, "Replay worst");
    assert!(
        folder.start(&lenses[1].1).status.code().is_some_and(|code| code < 3 || code == 100),
        "{lenses:?}"
    );
    // The other scenario was not run.
    assert_eq!(folder.titles(11), ["Run"]);
    let found = folder.findings();
    assert!(found.iter().all(|one| one.0 == 2), "{found:?}");
    assert_eq!(found.iter().map(|one| one.1).max(), Some(8), "{found:?}");
    assert!(
        found.iter().any(|one| one.2.starts_with("`min_ttc >= 60 s undefined passes` failed in 2 trials")
            || one.2.contains("failed in 2 trials of the last run")),
        "{found:?}"
    );

    // What is typed makes it stale before it is saved, and what is taken back makes it current; criteria keep their lines.
    let walk = folder.walk.clone();
    folder.editor.change(&walk, &format!("# more\n{WALK}"));
    assert!(
        folder.titles(2)[2].starts_with("stale (walk.scn has changed): last run failed"),
        "{:?}",
        folder.titles(2)
    );
    let found = folder.findings();
    assert!(found.iter().all(|one| one.0 == 3 && one.2.starts_with("stale")), "{found:?}");
    assert_eq!(found.iter().map(|one| one.1).max(), Some(9), "{found:?}");
    folder.editor.change(&walk, WALK);
    assert_eq!(folder.titles(1)[2], "last run failed: 2 of 2 trials");

    // What is typed in a file that it uses makes its findings stale as well, and what is taken back current.
    let street = folder.root.join("street.scn");
    folder.editor.open(&street, STREET);
    for (text, severity) in [(STREET.replace("3.5 m", "3.6 m"), 3), (STREET.to_string(), 2)] {
        folder.editor.change(&street, &text);
        // Asks for something, so that all that was shown before has come.
        folder.titles(1);
        let shown = folder.editor.findings[&address(&walk)].iter().filter(|one| one["source"] == "last run");
        let severities: Vec<_> = shown.map(|one| one["severity"].as_u64().unwrap()).collect();
        assert!(!severities.is_empty() && severities.iter().all(|one| *one == severity), "{severities:?}");
    }

    folder.editor.tell("textDocument/didClose", json!({ "textDocument": { "uri": address(&street) } }));

    // A file that it uses, with the time of before and the same length.
    let before = std::fs::metadata(&street).unwrap().modified().unwrap();
    std::fs::write(&street, STREET.replace("3.5 m", "3.6 m")).unwrap();
    std::fs::File::options().write(true).open(&street).unwrap().set_modified(before).unwrap();
    assert!(folder.titles(1)[2].starts_with("stale (street.scn has changed)"), "{:?}", folder.titles(1));
    std::fs::remove_file(&street).unwrap();
    assert!(folder.titles(1)[2].starts_with("stale (street.scn cannot be read)"));
    folder.editor.end();
}

#[test]
fn only_what_passed_in_every_trial_of_this_text_is_shown_as_passed() {
    let mut folder = folder();
    folder.run(1);
    let verdict = |results: &mut Value, word: &str, trials: &[usize]| {
        for trial in trials {
            let trial = &mut results["suites"][0]["trials"][*trial];
            trial["verdict"] = json!(word);
            trial["findings"] = json!([]);
        }
    };
    folder.edit(|results| verdict(results, "passed", &[0, 1]));
    assert_eq!(folder.titles(1), ["Run", "last run passed: 2 trials"]);
    assert_eq!(folder.findings(), []);
    folder.edit(|results| verdict(results, "not_finished", &[1]));
    assert_eq!(folder.titles(1)[1], "last run not passed: 1 not finished of 2 trials");
    folder.edit(|results| verdict(results, "inconclusive", &[1]));
    assert_eq!(folder.titles(1)[1], "last run not passed: 1 inconclusive of 2 trials");
    folder.edit(|results| verdict(results, "skipped", &[1]));
    assert_eq!(folder.titles(1)[1], "last run not passed: 1 skipped of 2 trials");
    folder.edit(|results| verdict(results, "skipped", &[0, 1]));
    assert_eq!(folder.titles(1), ["Run"]);
    folder.run(1);
    folder.edit(|results| {
        verdict(results, "passed", &[0, 1]);
        results["suites"][0]["set"] = json!(["tta=9s"]);
    });
    assert_eq!(folder.titles(1)[1], "last run passed: 2 trials, with tta=9s");
    for (member, why) in
        [("texts", "the results do not say of which text"), ("version", "made by version 0.0.9")]
    {
        folder.run(1);
        folder.edit(|results| {
            verdict(results, "passed", &[0, 1]);
            match member {
                "texts" => _ = results["suites"][0].as_object_mut().unwrap().remove("texts"),
                _ => results["tool"]["version"] = json!("0.0.9"),
            }
        });
        assert_eq!(folder.titles(1)[1], format!("stale ({why}): last run passed: 2 trials"));
    }
    // A text elsewhere is not read, so nobody knows whether it is the same.
    folder.run(1);
    folder.edit(|results| {
        verdict(results, "passed", &[0, 1]);
        results["suites"][0]["texts"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "file": "/dev/zero", "sha256": "00" }));
    });
    assert_eq!(
        folder.titles(1)[1],
        "stale (/dev/zero lies outside of the workspace): last run passed: 2 trials"
    );
    // Of another scenario, nothing is said of this one.
    folder.run(1);
    folder.edit(|results| {
        for trial in results["suites"][0]["trials"].as_array_mut().unwrap() {
            trial["scenario"] = json!("another");
        }
    });
    assert_eq!(folder.titles(1), ["Run"]);
    folder.editor.end();
}

#[test]
fn what_are_no_results_is_ignored_and_a_key_is_no_option() {
    let mut folder = folder();
    for text in ["", "{", "[]", "null", "{\"layout\": 2}", "\u{0}", &"[".repeat(100_000)] {
        write(&folder.results(), text);
        assert_eq!(folder.titles(1), ["Run"], "{text:?}");
    }
    folder.run(1);
    folder.edit(|results| {
        for trial in results["suites"][0]["trials"].as_array_mut().unwrap() {
            let findings = trial.get_mut("findings").and_then(Value::as_array_mut);
            for finding in findings.into_iter().flatten() {
                let worst = finding.get_mut("worst").and_then(Value::as_array_mut);
                for worst in worst.into_iter().flatten() {
                    worst["key"] = json!("--allow-run");
                }
            }
        }
    });
    let titles = folder.titles(1);
    assert!(titles.iter().all(|title| title != "Replay worst") && titles.len() == 2, "{titles:?}");
    // Results that a user made and named, from the folder that is open.
    std::fs::remove_file(folder.results()).unwrap();
    folder.start(&["run", "walk.scn", "--json", "mine.json"].map(String::from));
    assert_eq!(folder.titles(1)[2], "last run failed: 2 of 2 trials");
    // A link leads to nothing that is elsewhere.
    #[cfg(unix)]
    {
        let elsewhere = tempfile::tempdir().unwrap();
        std::fs::rename(folder.root.join("mine.json"), elsewhere.path().join("mine.json")).unwrap();
        std::os::unix::fs::symlink(elsewhere.path().join("mine.json"), folder.root.join("mine.json"))
            .unwrap();
        assert_eq!(folder.titles(1), ["Run"]);
    }
    folder.editor.end();
}
