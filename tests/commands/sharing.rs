//! Several `exec` at one folder make the runs of a block together, and `merge` writes the reports of one machine.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::thread;
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

use crate::shards::settled;
use crate::support::program::{code, scenario_runner, stderr, stdout};

/// Steps are so short that each run takes several milliseconds. Where runs are much shorter, a worker that joins another leaves again.
const SUITE: &str = r#"suite people {
  seed 5
  scenario walk {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller carla_behavior; speed 30 km/h }
    pedestrian walker { model commotions; start 2 m from kerb; appears when time_to_arrival(av) = tta }
    vary tta in [3 s, 4 s, 5 s, 6 s, 7 s, 8 s]
    repeat 2
    step 0.00125 s
    expect { max_deceleration <= 9 m/s^2 }
  }
  scenario open {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller carla_behavior; speed 30 km/h }
    pedestrian walker { model carla_walker; start 2 m from kerb; appears when time_to_arrival(av) = tta }
    vary tta in [3 s, 12 s]
    runs 20 .. 300
    expect { rate(pet > 0.1 s) >= 50 % with 95 % confidence }
  }
}
tune good {
  on walk
  over av.controller.braking_distance in 4 m .. 12 m
  minimise mean(time_lost)
  budget 30 evaluations, 24 random first
  compare with default
}
evaluate both {
  on walk
  with default, good
}
"#;

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("people.suite"), SUITE).unwrap();
    folder
}

fn planned(folder: &Path, more: &[&str]) {
    let arguments = [&["plan", "people.suite", "--out", "manifest.jsonl"], more].concat();
    let output = scenario_runner(folder, &arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}

/// An `exec` with a thread, which is not waited for.
fn begun(folder: &Path, more: &[&str]) -> Child {
    let arguments = ["exec", "manifest.jsonl", "--results", "results", "--test-threads", "1"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
    command.args(arguments).args(more).current_dir(folder).env("NO_COLOR", "1").env("LC_ALL", "C");
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn ended(worker: Child) -> Output {
    let output = worker.wait_with_output().unwrap();
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    output
}

/// How many runs of undecided units a worker has made, and how many there are in those that it has completed, by its log.
fn made(folder: &Path, pid: u32) -> (u64, u64) {
    let ending = format!(".{pid}.jsonl");
    let logs = fs::read_dir(folder.join("results/log")).unwrap().map(|file| file.unwrap().path());
    let of_worker = logs.filter(|path| path.to_string_lossy().ends_with(&ending));
    let text: String = of_worker.map(|path| fs::read_to_string(path).unwrap()).collect();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let sum = |what: &str| lines.iter().filter_map(|line| line["what"][what].as_u64()).sum();
    (sum("own"), sum("runs"))
}

fn journals(folder: &Path) -> Vec<PathBuf> {
    let found = fs::read_dir(folder.join("results/journal")).into_iter().flatten();
    found.map(|file| file.unwrap().path()).collect()
}

/// Waits until a worker has written that much of a journal.
fn await_journal(folder: &Path, worker: &mut Child, length: u64) {
    let ending = format!(".{}.jsonl", worker.id());
    let held = || {
        let of_worker = journals(folder).into_iter().filter(|path| path.to_string_lossy().ends_with(&ending));
        of_worker.filter_map(|path| path.metadata().ok()).map(|metadata| metadata.len()).sum::<u64>()
    };
    while held() < length {
        if worker.try_wait().unwrap().is_some() {
            let said = worker.stdout.take().map(|stream| io::read_to_string(stream).unwrap());
            panic!("it ended before it could be looked at: {}", said.unwrap_or_default());
        }
        thread::sleep(Duration::from_millis(1));
    }
}

/// What a report of one machine says, and one of many.
fn reports(folder: &Path, arguments: &[&str]) -> (i32, String, Vec<u8>) {
    let reports = ["--no-progress", "--json", "r.json", "--runs", "r.jsonl"];
    let output = scenario_runner(folder, &[arguments, &reports].concat());
    let text = fs::read_to_string(folder.join("r.json")).unwrap_or_else(|_| panic!("{}", stderr(&output)));
    (code(&output), settled(&text), fs::read(folder.join("r.jsonl")).unwrap())
}

fn assert_merged(path: &Path, selected: &[&str], what: &str) {
    let merged = reports(path, &["merge", "manifest.jsonl", "--results", "results"]);
    let here = |path: &Path| reports(path, &[&["people.suite"], selected].concat());
    // Several tests compare with the tune.
    static TUNED: OnceLock<(i32, String, Vec<u8>)> = OnceLock::new();
    let tuned = || TUNED.get_or_init(|| here(folder().path())).clone();
    let local = if selected == TUNE { tuned() } else { here(path) };
    assert!(merged == local, "{what}: {} and {}", merged.0, local.0);
    assert!(journals(path).is_empty(), "{what}");
}

const TUNE: [&str; 2] = ["-E", "kind(tune)"];

#[test]
fn workers_that_begin_at_once_and_one_that_is_late_share_the_runs_of_a_tune() {
    let folder = folder();
    let folder = folder.path();
    planned(folder, &TUNE);
    let mut workers = vec![begun(folder, &[]), begun(folder, &["--partition", "slice:1/1"])];
    await_journal(folder, &mut workers[1], 14_000);
    // None of it is of this share.
    workers.push(begun(folder, &["--partition", "slice:2/2"]));
    let pids: Vec<u32> = workers.iter().map(Child::id).collect();
    let said: Vec<Output> = workers.into_iter().map(ended).collect();
    let (made, completed): (Vec<u64>, Vec<u64>) = pids.iter().map(|pid| made(folder, *pid)).unzip();
    let all = completed.into_iter().max().unwrap();
    let told = format!("{made:?} of {all}: {}{}", stdout(&said[0]), stdout(&said[2]));
    assert!(made[0] * 15 > all && made[1] * 15 > all && made[2] > 0, "{told}");
    assert!(made.iter().sum::<u64>() < all * 7 / 4, "{told}");
    assert!(stderr(&said[2]).contains("helps another worker with people/tune=good"), "{}", stderr(&said[2]));
    assert!(
        stdout(&said[2]).contains("made 0 batches of 0 runs; helped others with 1, of which it made"),
        "{told}"
    );
    assert_merged(folder, &TUNE, &told);
}

#[cfg(unix)]
#[test]
fn the_part_of_a_worker_that_is_killed_is_made_by_who_has_joined_it() {
    let folder = folder();
    let folder = folder.path();
    planned(folder, &TUNE);
    // A journal of somebody else that is damaged is there as well.
    let unit = || {
        let manifest = fs::read_to_string(folder.join("manifest.jsonl")).unwrap();
        let line: Value = serde_json::from_str(manifest.lines().nth(1).unwrap()).unwrap();
        line["id"].as_str().unwrap().to_string()
    };
    fs::create_dir_all(folder.join("results/journal")).unwrap();
    fs::write(folder.join(format!("results/journal/{}.ghost.1.jsonl", unit())), "a poem\n").unwrap();
    let mut owner = begun(folder, &[]);
    await_journal(folder, &mut owner, 7_000);
    let mut joined = begun(folder, &["--partition", "slice:2/2"]);
    await_journal(folder, &mut joined, 7_000);
    owner.kill().unwrap();
    owner.wait().unwrap();
    let pid = joined.id();
    let output = ended(joined);
    let (made, all) = made(folder, pid);
    assert!(made * 15 > all && made < all, "{made} of {all}");
    assert!(stderr(&output).contains(".ghost.1.jsonl is no scenario-runner journal"), "{}", stderr(&output));
    assert_merged(folder, &TUNE, "killed");
}

#[test]
fn who_is_to_make_its_own_share_only_does_no_more() {
    let folder = folder();
    let folder = folder.path();
    planned(folder, &TUNE);
    let mut owner = begun(folder, &[]);
    await_journal(folder, &mut owner, 3_000);
    for more in [&["--own-share-only"][..], &["--join-once", "not there"]] {
        let output = ended(begun(folder, &[&["--partition", "slice:2/2"], more].concat()));
        assert!(stdout(&output).contains("made 0 batches of 0 runs\n"), "{}", stdout(&output));
        assert!(!stderr(&output).contains("helps"), "{}", stderr(&output));
        assert!(owner.try_wait().unwrap().is_none(), "there was something to help with all the time");
    }
    ended(owner);
    assert_merged(folder, &TUNE, "alone");
}

#[test]
fn shares_of_a_whole_suite_that_help_each_other_come_to_the_reports_of_one_machine() {
    let folder = folder();
    let folder = folder.path();
    planned(folder, &[]);
    let shares = ["slice:1/3", "slice:2/3", "slice:3/3"];
    let workers = shares.map(|share| begun(folder, &["--partition", share]));
    let said: String = workers.into_iter().map(|worker| stdout(&ended(worker))).collect();
    assert!(said.contains("helped others with"), "{said}");
    assert_merged(folder, &[], &said);
}
