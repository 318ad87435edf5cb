//! Commands that are printed: a shell reads them as they are meant, whatever files are called.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::program::{scenario_runner, stderr, stdout};

const FAILS: &str = "scenario s {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 30 km/h }
  pedestrian p { model scripted; start 2 m from kerb; appears when time_to_arrival(av) = 3.4 s }
  expect { no collision }
}
";

/// Names of folders and files that mean something to a shell or to another reader.
const NAMES: [&str; 12] = [
    "plain",
    "with space",
    "a;touch HACK",
    "it's",
    "say \"so\"",
    "$HOME $(touch HACK)",
    "`touch HACK`",
    "-x",
    "two\nlines",
    "100%s\\n*?[a]",
    "\u{1b}[31mred",
    "::error::x",
];

/// A command as a shell of this system runs it, with the program on its path.
fn shell(folder: &Path, command: &str) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_scenario-runner"));
    let path =
        format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap_or_default());
    let shell = Command::new("sh").arg("-c").arg(command).current_dir(folder).env("PATH", path).output();
    shell.expect("there is a shell")
}

#[test]
fn a_failure_is_replayed_by_the_line_that_it_prints() {
    for name in NAMES {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        fs::create_dir(path.join(name)).unwrap();
        let file = format!("{name}/{name}.scn");
        fs::write(path.join(&file), FAILS).unwrap();
        let output = scenario_runner(path, &["--no-progress", "--json", "r.json", "--", &file]);
        let said = stdout(&output);
        assert_eq!(output.status.code(), Some(100), "{name}: {said}{}", stderr(&output));
        let replay = said.lines().find_map(|line| line.split_once("replay: ")).map(|(_, command)| command);
        let replay = replay.unwrap_or_else(|| panic!("{name}: {said}"));
        let replayed = shell(path, replay);
        let told = stdout(&replayed);
        assert_eq!(replayed.status.code(), Some(0), "{replay}: {told}{}", stderr(&replayed));
        assert!(told.contains("COLLIDES"), "{replay}: {told}");
        assert!(!path.join("HACK").exists(), "{replay}");
        // Nothing that is said is a command for GitHub, nor one for a terminal.
        for text in [said.as_str(), &stderr(&output), &told] {
            assert!(!text.lines().any(|line| line.trim_start().starts_with("::")), "{name}: {text}");
            assert!(!text.contains('\u{1b}'), "{name}: {text}");
        }
    }
}

#[test]
fn a_name_is_no_command_beside_annotations() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("::error::x.scn"), FAILS).unwrap();
    let output = scenario_runner(folder.path(), &["::error::x.scn", "--no-progress", "--github"]);
    let said = stdout(&output);
    let commands: Vec<&str> = said.lines().filter(|line| line.trim_start().starts_with("::")).collect();
    assert_eq!(commands.len(), 1, "{said}");
    assert!(commands[0].starts_with("::error file="), "{said}");
    let text = stderr(&output);
    assert!(!text.lines().any(|line| line.trim_start().starts_with("::")), "{text}");
}

#[test]
fn nothing_in_a_file_of_failures_is_obeyed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("a.scn"), FAILS).unwrap();
    for line in ["\u{1b}[31mall is well\u{1b}[0m 7", "  seed \u{1b}[32mPASS", "::error::x\n  sead 7"] {
        let text = format!("a/s/rep=1\n  scenario s\n{line}\n");
        fs::write(path.join("a.failures"), text).unwrap();
        let output = scenario_runner(path, &["a.scn", "--no-progress"]);
        let said = format!("{}{}", stdout(&output), stderr(&output));
        assert!(!said.contains('\u{1b}'), "{said:?}");
        assert!(!said.lines().any(|line| line.trim_start().starts_with("::")), "{said}");
    }
    // What is written of a run with such a name obeys nothing either, and is read back.
    let name = "\u{1b}[31mred\nnight.scn";
    fs::write(path.join(name), FAILS).unwrap();
    let record = scenario_runner(path, &[name, "--no-progress", "--record-failures"]);
    let kept = fs::read_to_string(path.join("\u{1b}[31mred\nnight.failures"));
    let kept = kept.unwrap_or_else(|_| panic!("{}", stderr(&record)));
    assert!(!kept.contains('\u{1b}'), "{kept:?}");
    let again = scenario_runner(path, &[name, "--no-progress"]);
    assert!(stdout(&again).contains("recorded=s/rep=1"), "{}{}", stdout(&again), stderr(&again));
}
