//! A `search` or `tune` that is killed for good, again and again, ends with the bytes of one that is left alone.

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use numbers::random::Stream;
use tempfile::TempDir;

/// Kills that each command has to survive.
const KILLS: usize = 4;
const SIGKILL: i32 = 9;

const SUITE: &str = r#"
use "SCENARIOS/zebra/commotions_carla.scn"

suite resumed {
  scenarios "SCENARIOS/zebra/commotions_carla.scn"
  seed 3
}

search low_pet {
  in commotions_carla
  individuals 3 of standard
  minimise pet
  over tta in 6 s .. 18 s
  budget 14 evaluations, 5 random first
}

tune braking {
  on low_pet
  over av.controller.braking_distance in 4 m .. 25 m
  minimise mean(time_lost)
  subject to no collision
  budget 16 evaluations, 5 random first
  compare with default
}
"#;

/// The command in a folder of its own, its result in `result.json`.
fn command(kind: &str, name: &str, folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
    command.args([kind, name, "resumed.suite", "--json", "result.json"]).current_dir(folder);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn prepared() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scenarios = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios");
    fs::write(folder.path().join("resumed.suite"), SUITE.replace("SCENARIOS", scenarios)).unwrap();
    folder
}

/// Evaluations in all journals that a command has left so far.
fn recorded(folder: &Path) -> usize {
    let Ok(files) = fs::read_dir(folder.join(".scenario-runner/journal")) else { return 0 };
    let lines = |path| fs::read(path).map_or(0, |bytes| bytes.iter().filter(|&&byte| byte == b'\n').count());
    // The first line of each is its definition.
    files.flatten().map(|file| lines(file.path()).saturating_sub(1)).sum()
}

/// What a command says and writes.
fn result(output: &Output, folder: &Path) -> (String, String) {
    let said = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    (said, fs::read_to_string(folder.join("result.json")).unwrap())
}

/// Runs the command until it has been killed `KILLS` times, each time some evaluations further, and then to its end.
fn survives(kind: &str, name: &str, seed: u64) {
    let undisturbed = prepared();
    let expected = result(&command(kind, name, undisturbed.path()).output().unwrap(), undisturbed.path());
    let mut stream = Stream::seeded(seed);
    let disturbed = prepared();
    let (mut kills, mut furthest) = (0, 0);
    for _ in 0..10 * KILLS {
        let so_far = recorded(disturbed.path());
        // One to nine evaluations more, and not always just when one has been written.
        let target = so_far + 1 + (9.0 * stream.uniform()) as usize;
        let delay = Duration::from_micros((20_000.0 * stream.uniform()) as u64);
        let mut child = command(kind, name, disturbed.path()).spawn().unwrap();
        while recorded(disturbed.path()) < target && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(delay);
        child.kill().unwrap();
        let output = child.wait_with_output().unwrap();
        if output.status.signal() == Some(SIGKILL) {
            kills += 1;
            furthest = furthest.max(recorded(disturbed.path()));
        } else {
            // It had ended, and a tune leaves its journal for a larger budget: the next one begins anew.
            assert_eq!(result(&output, disturbed.path()), expected);
            let _ = fs::remove_dir_all(disturbed.path().join(".scenario-runner/journal"));
        }
        if kills == KILLS {
            break;
        }
    }
    assert_eq!(kills, KILLS, "{kind} {name} ended too fast to be killed");
    assert!(furthest > 0, "no kill left anything to resume from");
    let resumed = command(kind, name, disturbed.path()).output().unwrap();
    assert_eq!(result(&resumed, disturbed.path()), expected);
    let left = if kind == "tune" { 16 } else { 0 };
    assert_eq!(recorded(disturbed.path()), left, "searches remove their journals in the end");
}

#[test]
fn a_killed_search_resumes_to_the_same_bytes() {
    survives("search", "low_pet", 1);
}

#[test]
fn a_killed_tune_resumes_to_the_same_bytes() {
    survives("tune", "braking", 2);
}
