//! `plan`, `exec` and `merge`: many machines write the reports of one, or none.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use fancy_regex::Regex;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::program::{code, scenario_runner, stderr, stdout};

const SUITE: &str = r#"suite crossing {
  seed 11
  scenario walker {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller carla_behavior; speed 30 km/h }
    pedestrian walker { model carla_walker; start 2 m from kerb; appears when time_to_arrival(av) = tta }
    vary tta in [3 s, 4 s, 5 s]
    repeat 12
    expect { max_deceleration <= 2 m/s^2; no collision }
  }
  scenario open {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller carla_behavior; speed 30 km/h }
    pedestrian walker { model carla_walker; start 2 m from kerb; appears when time_to_arrival(av) = tta }
    vary tta in [3 s, 12 s]
    runs 20 .. 60
    expect { rate(pet > 0.1 s) >= 50 % with 95 % confidence }
  }
}
search found {
  in walker
  minimise pet
  over tta in 3 s .. 9 s
  budget 8 evaluations, 3 random first
}
evaluate both {
  on walker
  with default
}
"#;

/// The reports that are files, by their options.
const REPORTS: [&str; 6] = ["junit", "json", "tap", "html", "runs", "csv"];

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("crossing.suite"), SUITE).unwrap();
    folder
}

/// Runs the program with all reports, and gives its exit code with what they say but for times.
fn reported(folder: &Path, name: &str, arguments: &[&str]) -> (i32, Vec<String>) {
    let options: Vec<String> = REPORTS.iter().map(|kind| format!("--{kind}={name}.{kind}")).collect();
    let all: Vec<&str> = arguments
        .iter()
        .copied()
        .chain(["--no-progress"])
        .chain(options.iter().map(String::as_str))
        .collect();
    let output = scenario_runner(folder, &all);
    let read = |kind: &&str| {
        let text = fs::read_to_string(folder.join(format!("{name}.{kind}")));
        settled(&text.unwrap_or_else(|error| panic!("{kind}: {error}\n{}", stderr(&output))))
    };
    (code(&output), REPORTS.iter().map(read).collect())
}

/// Without what differs from run to run of the same suite.
pub fn settled(text: &str) -> String {
    let replaced = [
        (r"duration_ms: \d+", "duration_ms: 0"),
        (r", \d+\.\d{2} s<", ", TIME s<"),
        (r#"<td class="n">\d+\.\d{2}</td></tr>\n"#, "<td>TIME</td></tr>\n"),
        (r#" (time|timestamp)="[^"]*""#, r#" $1="…""#),
        (r#""(wall_time_s|duration_s|(secs|nanos)(_since_epoch)?)": ?[0-9.e-]+"#, r#""$1": 0"#),
        (r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(\.\d+)?(Z|\+00:00| UTC)", "DATE"),
    ];
    replaced.iter().fold(text.to_string(), |text, (pattern, by)| {
        Regex::new(pattern).unwrap().replace_all(&text, *by).into_owned()
    })
}

/// The suite with so many runs that its first scenario makes several batches.
fn many_runs() -> String {
    SUITE.replace("repeat 12", "repeat 60")
}

fn planned(folder: &Path, more: &[&str]) {
    let arguments: Vec<&str> = ["plan", "crossing.suite", "--out", "manifest.jsonl"]
        .into_iter()
        .chain(more.iter().copied())
        .collect();
    let output = scenario_runner(folder, &arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}

/// Runs a worker that makes its own share only, and returns what it prints.
fn executed(folder: &Path, share: &str, threads: &str) -> String {
    executed_with(folder, share, threads, &["--own-share-only"])
}

/// Runs a worker that also looks for others to help, for half a second, and returns what it prints.
fn executed_looking_for_others(folder: &Path, share: &str, threads: &str) -> String {
    executed_with(folder, share, threads, &[])
}

fn executed_with(folder: &Path, share: &str, threads: &str, more: &[&str]) -> String {
    let arguments =
        ["exec", "manifest.jsonl", "--partition", share, "--results", "results", "--test-threads", threads];
    let output = scenario_runner(folder, &[&arguments, more].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    stdout(&output)
}

/// Files of results, one for each batch that is made, in any order.
fn result_files(folder: &Path) -> Vec<PathBuf> {
    let inside = |folder: &Path| fs::read_dir(folder).into_iter().flatten().map(|one| one.unwrap().path());
    let batches = inside(&folder.join("results")).filter(|one| one.file_name().unwrap().len() == 2);
    batches.flat_map(|one| inside(&one).collect::<Vec<_>>()).collect()
}

const MERGE: [&str; 4] = ["merge", "manifest.jsonl", "--results", "results"];

#[test]
fn the_reports_of_shares_are_those_of_one_machine_byte_for_byte() {
    let folder = folder();
    let folder = folder.path();
    let local = reported(folder, "local", &["crossing.suite"]);
    planned(folder, &[]);
    for (share, threads) in [("slice:3/3", "1"), ("slice:1/3", "2"), ("slice:2/3", "5")] {
        executed_looking_for_others(folder, share, threads);
    }
    let merged = reported(folder, "merged", &MERGE);
    assert_eq!(merged.0, local.0);
    for ((kind, one), many) in REPORTS.iter().zip(local.1).zip(merged.1) {
        assert!(one == many, "{kind} differs");
    }
    // Those without times need no settling.
    let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
    assert_eq!(bytes("local.runs"), bytes("merged.runs"));
    assert!(executed(folder, "slice:1/1", "2").contains("made 0 batches of 0 runs"));
}

#[test]
fn a_part_that_was_chosen_is_what_a_run_of_that_part_comes_to() {
    let folder = folder();
    let folder = folder.path();
    let chosen = ["-E", "kind(search)", "--seed", "5", "--set", "repeat=6"];
    let local = reported(folder, "local", &[&["crossing.suite"], &chosen[..]].concat());
    planned(folder, &chosen);
    executed(folder, "hash:1/2", "2");
    executed(folder, "hash:2/2", "2");
    assert_eq!(reported(folder, "merged", &MERGE), local);
}

#[test]
fn what_is_not_there_or_not_of_the_plan_is_no_green() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("crossing.suite"), many_runs()).unwrap();
    planned(folder, &["walker/"]);
    executed(folder, "slice:1/2", "2");
    let refused = |arguments: &[&str], words: &[&str]| {
        let all: Vec<&str> = arguments.iter().copied().chain(["--junit", "never.xml"]).collect();
        let output = scenario_runner(folder, if arguments[0] == "merge" { &all } else { arguments });
        assert_eq!(code(&output), 2, "{}{}", stdout(&output), stderr(&output));
        for word in words {
            assert!(stderr(&output).contains(word), "{word}: {}", stderr(&output));
        }
        assert!(!folder.join("never.xml").exists());
    };
    refused(
        &MERGE,
        &["missing", "crossing/walker/tta=", "scenario-runner exec 'manifest.jsonl' --results 'results'"],
    );
    executed(folder, "slice:2/2", "2");
    assert_eq!(code(&scenario_runner(folder, &MERGE)), 100);
    refused(
        &["merge", "manifest.jsonl", "--results", "results", "--json", "manifest.jsonl"],
        &["would replace a file"],
    );
    for among in ["results/new.runs", "results/00/new.runs", "./results/new.runs"] {
        refused(
            &["merge", "manifest.jsonl", "--results", "results", "--runs", among],
            &["would lie among the results"],
        );
    }
    let exec = ["exec", "manifest.jsonl", "--results", "results"];
    let suite = fs::read_to_string(folder.join("crossing.suite")).unwrap();
    fs::write(folder.join("crossing.suite"), suite.replace("tta in [3 s", "tta in [3.5 s")).unwrap();
    refused(&MERGE, &["crossing.suite is not what it was when the plan was made"]);
    refused(&exec, &["crossing.suite is not what it was"]);
    fs::write(folder.join("crossing.suite"), suite).unwrap();
    let manifest = fs::read_to_string(folder.join("manifest.jsonl")).unwrap();
    fs::write(folder.join("manifest.jsonl"), manifest.replacen("\"digest\":\"", "\"digest\":\"0", 1))
        .unwrap();
    refused(&exec, &["manifest.jsonl", "damaged or was changed"]);
    fs::write(folder.join("manifest.jsonl"), &manifest[..manifest.len() / 2]).unwrap();
    refused(&MERGE, &["manifest.jsonl", "cut off"]);
    refused(&["exec", "nowhere.jsonl", "--results", "results"], &["nowhere.jsonl"]);
}

/// With the manifest's lines sealed again, as whoever forges one would.
#[test]
fn a_plan_of_another_program_is_refused_by_name() {
    let folder = folder();
    let folder = folder.path();
    planned(folder, &["walker/tta=3s"]);
    let text = fs::read_to_string(folder.join("manifest.jsonl")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let mut header: Value = serde_json::from_str(lines[0]).unwrap();
    header["build"]["target"] = "riscv64-plan9".into();
    let body = format!("{header}\n{}\n", lines[1..lines.len() - 1].join("\n"));
    let seal = scenario::sha256(body.as_bytes());
    fs::write(folder.join("manifest.jsonl"), format!("{body}{{\"sha256\":\"{seal}\"}}\n")).unwrap();
    let output = scenario_runner(folder, &["exec", "manifest.jsonl", "--results", "results"]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("riscv64-plan9"), "{}", stderr(&output));
}

/// The only file of results, with a run in it that is called otherwise, sealed again.
fn renamed_run(folder: &Path) {
    let path = &result_files(folder)[0];
    let text = fs::read_to_string(path).unwrap();
    let body = &text[..text.trim_end().rfind('\n').unwrap() + 1];
    let at = body.find("{\"run\":\"").unwrap() + 8;
    let other = if &body[at..=at] == "0" { "1" } else { "0" };
    let body = format!("{}{other}{}", &body[..at], &body[at + 1..]);
    let seal = scenario::sha256(body.as_bytes());
    fs::write(path, format!("{body}{{\"sha256\":\"{seal}\"}}\n")).unwrap();
}

#[test]
fn a_merge_that_refuses_results_tells_no_summary_and_remembers_nothing() {
    let folder = folder();
    let folder = folder.path();
    planned(folder, &["walker/tta=3s"]);
    executed(folder, "slice:1/1", "2");
    let memory = || fs::read_dir(folder.join(".scenario-runner")).map_or(0, Iterator::count);
    let before = memory();
    renamed_run(folder);
    let output = scenario_runner(folder, &[&MERGE[..], &["--junit", "never.xml"]].concat());
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("there is no result of crossing/walker/tta=3s"), "{}", stderr(&output));
    assert!(
        !stdout(&output).contains("Summary") && !folder.join("never.xml").exists(),
        "{}",
        stdout(&output)
    );
    assert_eq!(memory(), before);
}

fn limited(suite: &str, limit: &str) -> String {
    suite.replace("seed 11", &format!("seed 11\n  time_limit {limit} per case"))
}

/// The suite with a time limit and so many runs that none of its trials is over within a millisecond.
fn with_limit(folder: &Path, limit: &str) {
    let text = limited(&many_runs(), limit).replace("runs 20 .. 60", "runs 200 .. 300");
    fs::write(folder.join("crossing.suite"), text).unwrap();
}

/// A report without how far those trials were that took too long.
fn verdicts(report: &str) -> String {
    let far = Regex::new(r#"(exceeded after|name="runs" value=")\s*\d+"#).unwrap();
    far.replace_all(report, "$1 …").into_owned()
}

#[test]
fn a_time_limit_that_is_kept_changes_nothing() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("crossing.suite"), limited(SUITE, "100 s")).unwrap();
    let local = reported(folder, "local", &["crossing.suite"]);
    planned(folder, &[]);
    for share in ["slice:2/2", "slice:1/2"] {
        executed(folder, share, "2");
    }
    assert_eq!(reported(folder, "merged", &MERGE), local);
}

/// Every trial takes longer than its limit wherever it is made, and none of them is judged.
#[test]
fn what_took_too_long_on_a_share_has_not_passed() {
    let folder = folder();
    let folder = folder.path();
    with_limit(folder, "1 ms");
    let (code_of_one, local) = reported(folder, "local", &["crossing.suite"]);
    planned(folder, &[]);
    let exec = ["exec", "manifest.jsonl", "--results", "results"];
    let output = scenario_runner(folder, &exec);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    for trial in ["crossing/walker/tta=3s", "crossing/open/tta=12s"] {
        assert!(stderr(&output).contains(&format!("{trial} took longer here than its `time_limit`")));
    }
    let (code_of_many, merged) = reported(folder, "merged", &MERGE);
    assert_eq!((code_of_one, code_of_many), (100, 100));
    for ((kind, one), many) in REPORTS.iter().zip(&local).zip(&merged) {
        if *kind == "junit" {
            assert_eq!(many.matches(r#"type="time_limit""#).count(), 5, "{many}");
            assert!(verdicts(one) == verdicts(many), "{kind} differs");
        }
        assert!(*kind != "tap" || many.contains("time limit of 0.001 s exceeded"), "{many}");
    }
    // Results under another limit are others: neither the strict ones nor those of a loose one are taken for each other.
    with_limit(folder, "100 s");
    planned(folder, &[]);
    let refused = scenario_runner(folder, &MERGE);
    assert_eq!(code(&refused), 2, "{}", stderr(&refused));
    fs::remove_dir_all(folder.join("results")).unwrap();
    executed(folder, "slice:1/1", "2");
    with_limit(folder, "1 ms");
    planned(folder, &[]);
    let refused = scenario_runner(folder, &MERGE);
    assert_eq!(code(&refused), 2, "{}", stderr(&refused));
}

const PEOPLE: &str = r#"suite people {
  seed 5
  scenario walk {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller carla_behavior; speed 30 km/h }
    pedestrian walker { model commotions; start 2 m from kerb; appears when time_to_arrival(av) = tta }
    vary tta in [6 s, 7 s]
    repeat 2
    expect { no collision }
  }
}
search worst {
  in walk
  individuals 5 of standard
  minimise pet
  over tta in 3 s .. 9 s
  keep pet <= 1.8 s
  budget 8 evaluations, 8 random first
}
tune good {
  on worst
  over av.controller.braking_distance in 4 m .. 12 m
  minimise mean(time_lost)
  budget 4 evaluations, 2 random first
}
"#;

fn people() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("crossing.suite"), PEOPLE).unwrap();
    folder
}

#[test]
fn a_search_for_several_people_is_shared_out() {
    let folder = people();
    let folder = folder.path();
    let local = reported(folder, "local", &["crossing.suite"]);
    planned(folder, &[]);
    let manifest = fs::read_to_string(folder.join("manifest.jsonl")).unwrap();
    let groups = manifest.lines().filter(|line| line.contains("\"group\":")).count();
    assert_eq!(groups, 5, "{manifest}");
    for shares in [1, 5] {
        let _ = fs::remove_dir_all(folder.join("results"));
        // Not in their order.
        (0..shares).for_each(|share| {
            let share = (share * 2 + 1) % shares + 1;
            executed(folder, &format!("slice:{share}/{shares}"), "2");
        });
        assert_eq!(reported(folder, "merged", &MERGE), local, "{shares} shares");
        // A journal is kept as long as there is something to go on with.
        let journals = fs::read_dir(folder.join("results/journal")).map_or(0, Iterator::count);
        assert_eq!(journals, 0);
    }
}

#[cfg(unix)]
#[test]
fn a_worker_that_is_killed_within_a_search_is_gone_on_from() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = SUITE.replace("budget 8 evaluations", "repeat 20\n  budget 40 evaluations");
    fs::write(folder.join("crossing.suite"), text).unwrap();
    planned(folder, &["-E", "kind(search)"]);
    let begun = || {
        Command::new(env!("CARGO_BIN_EXE_scenario-runner"))
            .args(["exec", "manifest.jsonl", "--results", "results", "--test-threads", "1"])
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    };
    let held = || -> u64 {
        let files = fs::read_dir(folder.join("results/journal")).into_iter().flatten();
        files.map(|file| file.unwrap().metadata().unwrap().len()).sum()
    };
    let mut worker = begun();
    while held() < 100_000 && worker.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    worker.kill().unwrap();
    worker.wait().unwrap();
    assert!(held() >= 100_000, "it ended before it could be killed");
    let said = executed(folder, "slice:1/1", "2");
    let numbers = Regex::new(r"of (\d+) runs \((\d+) of which a journal held\)").unwrap();
    let found = numbers.captures(&said).unwrap().unwrap_or_else(|| panic!("{said}"));
    let number = |place: usize| found.get(place).unwrap().as_str().parse::<usize>().unwrap();
    assert!(number(2) > 10 && number(2) < number(1), "{said}");
    let resumed = reported(folder, "resumed", &MERGE);
    let local = reported(folder, "local", &["crossing.suite", "-E", "kind(search)"]);
    assert_eq!(resumed, local);
    // And the same bytes as of a worker that was not killed.
    let bytes = || result_files(folder).iter().map(|path| fs::read(path).unwrap()).collect::<Vec<_>>();
    let one = bytes();
    fs::remove_dir_all(folder.join("results")).unwrap();
    assert!(!executed(folder, "slice:1/1", "2").contains("journal"));
    assert!(bytes() == one && one.len() == 1);
}

#[cfg(unix)]
#[test]
fn workers_that_are_killed_lose_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("crossing.suite"), many_runs()).unwrap();
    planned(folder, &[]);
    let mut killed = 0;
    // Just when a file of results appears, and in the middle of a batch (ms later).
    for (batches, later) in [(0, 40), (1, 0), (2, 0), (3, 20)] {
        let mut worker = Command::new(env!("CARGO_BIN_EXE_scenario-runner"))
            .args(["exec", "manifest.jsonl", "--results", "results", "--test-threads", "2"])
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        while result_files(folder).len() < batches && worker.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(later));
        worker.kill().unwrap();
        killed += usize::from(worker.wait().unwrap().code().is_none());
    }
    assert!(killed > 1, "{killed} workers were killed before they came to their end");
    executed(folder, "slice:1/1", "2");
    let merged = reported(folder, "merged", &MERGE);
    assert_eq!(merged, reported(folder, "local", &["crossing.suite"]));
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_said_and_loses_nothing() {
    let folder = folder();
    let folder = folder.path();
    planned(folder, &["walker/"]);
    // No file may get longer than so many blocks: what is written beyond is refused, as on a full disk.
    let script = "trap '' XFSZ; ulimit -f 2; exec \"$0\" exec manifest.jsonl --results results";
    let output = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_scenario-runner")])
        .current_dir(folder)
        .output()
        .unwrap();
    assert_eq!(code(&output), 110, "{}", stderr(&output));
    assert!(stderr(&output).contains("cannot be written"), "{}", stderr(&output));
    executed(folder, "slice:1/1", "2");
    assert_eq!(code(&scenario_runner(folder, &MERGE)), 100);
}

/// A module decides without leave, and its file is part of what is planned.
#[test]
fn a_controller_under_test_decides_on_shares_as_on_one_machine() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let module = include_str!("../under_test/brakes.wat");
    let write_module =
        |text: &str| fs::write(folder.join("own.wasm"), wat::parse_str(text).unwrap()).unwrap();
    write_module(module);
    let text = "controller own {
  wasm \"own.wasm\"
  parameter gap = 5 m in 1 m .. 30 m
  period 100 ms
}
scenario meet {
  road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
  vehicle av { controller own; speed 30 km/h; start 30 m before crossing }
  pedestrian walker { model scripted; start 2 m from kerb; appears at later }
  vary later in [0 s, 0.2 s, 0.4 s]
  repeat 20
  expect { max_deceleration <= 9 m/s^2 }
}
";
    fs::write(folder.join("meet.scn"), text).unwrap();
    let plan = |manifest: &str, verify: &str| {
        let arguments = ["plan", "meet.scn", "--out", manifest, "--verify-runs", verify];
        let output = scenario_runner(folder, &arguments);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let text = fs::read_to_string(folder.join(manifest)).unwrap();
        let unit =
            |line: &str| serde_json::from_str::<Value>(line).unwrap()["id"].as_str().map(str::to_string);
        text.lines().filter_map(unit).collect::<Vec<_>>()
    };
    let units = plan("manifest.jsonl", "some");
    assert!(!units.is_empty());
    // What is made twice is part of what results hold, so that those of another plan are not taken.
    assert!(plan("other.jsonl", "all").iter().all(|unit| !units.contains(unit)));
    executed(folder, "slice:2/2", "1");
    executed(folder, "slice:1/2", "3");
    let local = scenario_runner(folder, &["meet.scn", "--no-progress", "--runs", "local.runs"]);
    let merged = scenario_runner(folder, &[&MERGE[..], &["--no-progress", "--runs", "merged.runs"]].concat());
    assert_eq!((code(&local), code(&merged)), (0, 0), "{}{}", stderr(&local), stderr(&merged));
    let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
    assert!(bytes("local.runs") == bytes("merged.runs") && !bytes("local.runs").is_empty());
    // The results of another plan are missing, and another module is another controller.
    let output = scenario_runner(folder, &["merge", "other.jsonl", "--results", "results"]);
    assert_eq!(code(&output), 2, "{}", stderr(&output));
    write_module(&module.replace("(f64.const -3)", "(f64.const -4)"));
    let output = scenario_runner(folder, &MERGE);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("the program of `own`"), "{}", stderr(&output));
}

#[test]
fn a_baseline_that_was_changed_since_is_refused_by_name() {
    let folder = folder();
    let folder = folder.path();
    let gate = "  gate braking { baseline \"base.json\"; min_distance not worse by more than 5 % }\n";
    let suite = SUITE.replacen("  scenario open", &format!("{gate}  scenario open"), 1);
    fs::write(folder.join("crossing.suite"), suite.replace("repeat 12", "repeat 10")).unwrap();
    let saved = scenario_runner(folder, &["baseline", "save", "crossing.suite", "--out", "base.json"]);
    assert_eq!(code(&saved), 0, "{}", stderr(&saved));
    planned(folder, &["walker/"]);
    executed(folder, "slice:1/1", "2");
    assert_ne!(code(&scenario_runner(folder, &MERGE)), 2);
    let baseline = fs::read_to_string(folder.join("base.json")).unwrap();
    fs::write(folder.join("base.json"), baseline + "\n").unwrap();
    let output = scenario_runner(folder, &MERGE);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("base.json is not what it was"), "{}", stderr(&output));
}
