//! A session at the command line: blocks among trials, what is shown, what is left out, and how it is stopped.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// A folder of its own with a suite in it, in which the program runs.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    /// With `small.suite`: the given blocks over two of the scenarios that ship.
    fn new(blocks: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let place = Self { folder };
        let (scripted, commotions) = (shipped("zebra/scripted"), shipped("zebra/commotions_carla"));
        let scenarios = format!("scenarios \"{scripted}\", \"{commotions}\"");
        place.write("small.suite", &format!("suite small {{ {scenarios}; seed 7 }}\n{blocks}"));
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
        command.args(arguments).current_dir(self.folder.path()).env("NO_COLOR", "1");
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the binary runs")
    }

    /// Everything as JSON.
    fn results(&self, arguments: &[&str]) -> Value {
        self.run(&[arguments, &["--json", "results.json"]].concat());
        serde_json::from_str(&fs::read_to_string(self.path("results.json")).unwrap()).unwrap()
    }
}

/// A scenario that ships, as a suite elsewhere names it.
fn shipped(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenarios/{name}.scn")).to_string_lossy().into_owned()
}

const BLOCKS: &str = "
search low_pet {
  in commotions_carla
  individuals 2 of standard
  minimise pet
  over tta in 6 s .. 18 s
  budget 6 evaluations, 4 random first
}
search nobody {
  in commotions_carla
  individuals 1 of standard
  minimise pet
  over tta in 6 s .. 18 s
  budget 3 evaluations, by random
  keep pet < 0 s
}
tune braking_distance {
  on low_pet
  over av.controller.braking_distance in 4 m .. 25 m
  minimise mean(time_lost)
  budget 4 evaluations, 3 random first
}
tune hopeless {
  on low_pet
  over av.controller.braking_distance in 4 m .. 25 m
  minimise mean(time_lost)
  subject to pet >= 1000 s
  budget 3 evaluations, by random
}
tune on_nothing {
  on nobody
  over av.controller.braking_distance in 4 m .. 25 m
  minimise mean(time_lost)
  budget 3 evaluations, by random
}
";

fn code(output: &Output) -> i32 {
    output.status.code().expect("the program ends by itself")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("output is UTF-8")
}

/// Standard output with every time as `[time]`, and without where the repository is.
fn stdout(output: &Output) -> String {
    let text = String::from_utf8(output.stdout.clone()).expect("output is UTF-8");
    let text = text.replace(env!("CARGO_MANIFEST_DIR"), "[root]");
    text.lines().map(|line| without_time(line) + "\n").collect()
}

/// `PASS [   0.004s] key` as `PASS [time] key`.
fn without_time(line: &str) -> String {
    let Some((before, rest)) = line.split_once('[') else { return line.to_string() };
    match rest.split_once("s]") {
        Some((time, after)) if time.trim().parse::<f64>().is_ok() => format!("{before}[time]{after}"),
        _ => line.to_string(),
    }
}

/// The status lines: verb and key.
fn status(output: &Output) -> Vec<(String, String)> {
    let text = stdout(output);
    let lines = text.split("────").next().unwrap_or_default().lines();
    let parts = lines.filter_map(|line| {
        let (verb, rest) = line.split_once(" [")?;
        let (_, key) = rest.split_once("] ")?;
        Some((verb.trim().to_string(), key.to_string()))
    });
    parts.collect()
}

fn names(arguments: &[&str]) -> Vec<String> {
    names_in(&Place::new(BLOCKS), arguments)
}

fn names_in(place: &Place, arguments: &[&str]) -> Vec<String> {
    let output = place.run(arguments);
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_string).collect()
}

#[test]
fn blocks_run_among_the_trials_in_the_order_in_which_they_need_each_other() {
    let place = Place::new(BLOCKS);
    let output = place.run(&["small.suite", "-j", "1"]);
    assert_eq!(code(&output), 100, "{}{}", stdout(&output), stderr(&output));
    insta::assert_snapshot!(stdout(&output));
    // Tunes leave theirs for a larger budget.
    let journals = fs::read_dir(place.path(".scenario-runner/journal")).unwrap();
    let names = journals.map(|one| one.unwrap().file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> =
        names.filter_map(|name| Some(name.rsplit_once('-')?.0.to_string())).collect();
    names.sort_unstable();
    assert_eq!(names, ["small-braking_distance", "small-hopeless"]);
}

#[test]
fn blocks_are_in_every_report() {
    let place = Place::new(BLOCKS);
    let reports =
        ["--junit", "junit.xml", "--tap", "report.tap", "--json", "results.json", "--html", "page.html"];
    let output =
        place.run(&[&["small.suite", "=low_pet", "--skip", "tta", "-j", "2"], &reports[..]].concat());
    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    let text = |name: &str| fs::read_to_string(place.path(name)).unwrap();
    let results: Value = serde_json::from_str(&text("results.json")).unwrap();
    let blocks = results["suites"][0]["blocks"].as_array().unwrap();
    let verdicts: Vec<_> = blocks.iter().map(|block| block["verdict"].as_str().unwrap()).collect();
    assert_eq!(verdicts, ["found", "skipped", "skipped", "skipped", "skipped"]);
    assert_eq!(blocks[0]["result"]["search"]["found"].as_array().unwrap().len(), 2);
    assert!(text("junit.xml").contains("classname=\"small.search\""));
    assert!(text("report.tap").contains("- small/search=low_pet # SKIP found, not judged\n"));
}

#[test]
fn what_a_unit_needs_comes_along() {
    let list = names(&["small.suite", "tune=braking_distance", "--list"]);
    assert_eq!(list, ["small/search=low_pet", "small/tune=braking_distance"]);
    let all = names(&["small.suite", "--list"]);
    assert_eq!(all.len(), 8 + 5, "{all:?}");
}

#[test]
fn the_suite_and_the_commands_find_the_same() {
    let place = Place::new(BLOCKS);
    let whole = place.results(&["small.suite", "-j", "2"]);
    let alone = place.run(&["tune", "braking_distance", "small.suite", "--json", "tune.json"]);
    assert_eq!(code(&alone), 0, "{}", stderr(&alone));
    let alone: Value = serde_json::from_str(&fs::read_to_string(place.path("tune.json")).unwrap()).unwrap();
    assert_eq!(whole["suites"][0]["blocks"][2]["result"]["tune"], alone);
}

#[test]
fn partitions_share_the_units_out() {
    for by in ["slice", "hash"] {
        let share =
            |part| names(&["small.suite", "tta=", "--list", "--partition", &format!("{by}:{part}/2")]);
        let (one, two) = (share(1), share(2));
        let mut both = [one.clone(), two.clone()].concat();
        both.sort();
        let mut all = names(&["small.suite", "tta=", "--list"]);
        all.sort();
        assert_eq!(both, all, "{by}: {one:?} {two:?}");
    }
    let output = Place::new("").run(&["small.suite", "--partition", "hash:3/2"]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("there is no share 3 of 2"), "{}", stderr(&output));
}

#[test]
fn a_session_ends_early_after_enough_failures() {
    let place = Place::new("");
    let suite = format!("suite bad {{ scenarios \"{}\" }}", shipped("unsafe/stands_in_lane"));
    place.write("bad.suite", &suite);
    let output = place.run(&["bad.suite", "-j", "1", "--max-fail", "2", "--status-level", "skip"]);
    assert_eq!(code(&output), 100);
    let said = "bad/stands_in_lane/tta=10s: stopped after 2 failures (--max-fail 2)";
    let lines = status(&output);
    assert_eq!(lines[2], ("SKIP".to_string(), said.to_string()), "{}", stdout(&output));
    let first = place.results(&["bad.suite", "-j", "1", "--fail-fast"]);
    let verdicts: Vec<_> = first["suites"][0]["trials"]
        .as_array()
        .unwrap()
        .iter()
        .map(|trial| trial["verdict"].clone())
        .collect();
    assert_eq!(verdicts, ["failed", "skipped", "skipped"]);
    let all = place.run(&["bad.suite", "--max-fail", "all"]);
    assert_eq!(status(&all).len(), 3);
    assert_eq!(code(&place.run(&["bad.suite", "--max-fail", "0"])), 2);
}

#[test]
fn the_status_level_says_who_gets_a_line() {
    let place = Place::new("");
    let lines = |level: &str| {
        status(&place.run(&["small.suite", "scripted/tta=6s", "-j", "1", "--status-level", level]))
    };
    assert_eq!(lines("none"), []);
    assert_eq!(lines("fail"), []);
    assert_eq!(lines("slow"), []);
    let passed = ("PASS".to_string(), "small/scripted/tta=6s".to_string());
    assert_eq!(lines("pass"), [passed]);
    assert_eq!(lines("skip").len(), 1, "what was not selected is not listed line by line");
}

/// One character for each unit, in rows that carry how many are done, and what failed below them as without.
#[test]
fn every_unit_has_its_dot() {
    let place = Place::new("");
    let suite = format!("suite bad {{ scenarios \"{}\" }}", shipped("unsafe/stands_in_lane"));
    place.write("bad.suite", &suite);
    let run =
        |arguments: &[&str]| stdout(&place.run(&[arguments, &["-j", "1", "--status-level", "dot"]].concat()));
    let rows = |said: &str| -> Vec<String> {
        let is_row = |line: &&str| {
            line.ends_with(']') && line.len() == 80 && line.starts_with(['.', 'F', '?', 's', 'E', '-'])
        };
        said.lines().filter(is_row).map(str::to_string).collect()
    };
    let passed = run(&["small.suite"]);
    let units =
        stdout(&place.run(&["small.suite", "--list"])).lines().filter(|line| line.contains('/')).count();
    let [row] = &rows(&passed)[..] else { panic!("{passed}") };
    let marks: String = row.chars().take_while(|mark| *mark != ' ').collect();
    assert_eq!(marks.len(), units, "{passed}");
    assert!(row.ends_with(&format!(" [{units}/{units}]")), "{row}");
    let failed = run(&["bad.suite", "--fail-fast"]);
    let [row] = &rows(&failed)[..] else { panic!("{failed}") };
    assert!(row.starts_with("Fss "), "a failure is no dot, and what was not run is not either: {failed}");
    // What is told below the rows is what is told where units have no lines.
    let without = stdout(&place.run(&["bad.suite", "--fail-fast", "-j", "1", "--status-level", "none"]));
    let timeless = |said: &str| -> Vec<String> {
        said.lines().filter(|line| !line.contains("[ ")).map(str::to_string).collect()
    };
    let told = timeless(&failed);
    for line in timeless(&without).iter().filter(|line| !line.is_empty()) {
        assert!(told.contains(line), "`{line}` is missing: {failed}");
    }
}

#[test]
fn nothing_selected_is_an_error_unless_told_otherwise() {
    let place = Place::new("");
    let with = |arguments: &[&str]| place.run(&[&["small.suite", "no_such_unit"], arguments].concat());
    assert_eq!(code(&with(&[])), 4);
    let warned = with(&["--no-tests", "warn"]);
    assert_eq!(code(&warned), 0);
    assert!(stderr(&warned).contains("warning: no trial is selected"));
    let silent = with(&["--no-tests", "pass"]);
    assert_eq!(code(&silent), 0);
    assert!(!stderr(&silent).contains("no trial is selected"), "{}", stderr(&silent));
}

#[test]
fn what_failed_is_kept_in_a_file_and_run_first_from_then_on() {
    let place = Place::new("");
    let scenario = |stop_for: &str, pet: &str| {
        let text = fs::read_to_string(shipped("unsafe/stands_in_lane")).unwrap();
        let text = text.replace("../roads", &shipped("roads").replace(".scn", ""));
        place.write("stands.scn", &text.replace("stop_for: 10 s", stop_for).replace("pet >= 1.5 s", pet));
    };
    scenario("stop_for: 10 s", "pet >= 1.5 s");
    place.write("bad.suite", "suite bad { scenarios \"stands.scn\" }");
    let run = |arguments: &[&str]| place.run(&[&["bad.suite", "-j", "1"], arguments].concat());

    let first = run(&[]);
    assert!(
        stderr(&first).contains("`--record-failures` keeps 3 failing runs in bad.failures"),
        "{}",
        stderr(&first)
    );
    assert!(!place.path("bad.failures").exists(), "nothing is written beside a suite unless wished");
    run(&["--record-failures"]);
    insta::assert_snapshot!(fs::read_to_string(place.path("bad.failures")).unwrap());

    // Another seed makes other runs of the suite, but not of what was recorded.
    let again = run(&["--seed", "5"]);
    assert_eq!(status(&again)[0], ("FAIL".into(), "bad/recorded=stands_in_lane/tta=10s/rep=1".into()));
    // Failures that have scrolled away are shown again, so lines are counted once.
    let lines: BTreeSet<_> = status(&again).into_iter().collect();
    assert_eq!(lines.len(), 3 + 3, "{}", stdout(&again));
    let key = "bad/recorded=stands_in_lane/tta=4s/rep=1";
    let replayed = place.run(&["replay", key, "bad.suite", "--seed", "5"]);
    assert_eq!(code(&replayed), 0);
    let said = "the same run, bit for bit, as the one recorded in bad.failures";
    assert!(stdout(&replayed).contains(said), "{}", stdout(&replayed));

    // Who takes the criteria out has mended nothing.
    let text = fs::read_to_string(place.path("stands.scn")).unwrap();
    place.write("stands.scn", &format!("{}}}\n", &text[..text.find("  expect {").unwrap()]));
    let unclaimed = run(&["recorded="]);
    assert!(stdout(&unclaimed).contains("no criterion applies to it any more"), "{}", stdout(&unclaimed));
    assert!(!stdout(&unclaimed).contains("does not fail any more"), "{}", stdout(&unclaimed));

    // Once the cause is gone they are named, and taken out when that is wished.
    scenario("stop_for: 0 s", "pet >= 1 s");
    let fixed = run(&["recorded="]);
    assert_eq!(code(&fixed), 0, "{}", stdout(&fixed));
    let line =
        "bad/recorded=stands_in_lane/tta=6s/rep=1: does not fail any more (the case has changed since)";
    assert!(status(&fixed).contains(&("PASS".to_string(), line.to_string())), "{}", stdout(&fixed));
    assert!(stderr(&fixed).contains("3 of the failures in bad.failures can go"), "{}", stderr(&fixed));
    let replayed = stdout(&place.run(&["replay", key, "bad.suite"]));
    let said = "not as the one recorded in bad.failures: the case has changed since";
    assert!(replayed.contains(said), "{replayed}");
    run(&["recorded=", "--skip", "tta=4s", "--prune-failures"]);
    assert_eq!(names_in(&place, &["bad.suite", "recorded=", "--list"]), [key], "only what was run can go");

    // A file that cannot be understood is an error with its line.
    place.write("bad.failures", "bad/x/rep=1\n  sead 7\n");
    let broken = run(&[]);
    assert_eq!(code(&broken), 3);
    assert!(stderr(&broken).contains("bad.failures:2: nothing is called `sead` here"), "{}", stderr(&broken));
}

#[test]
fn what_failed_last_time_can_be_run_alone() {
    let place = Place::new("");
    let scenarios = format!("\"{}\", \"{}\"", shipped("unsafe/stands_in_lane"), shipped("zebra/scripted"));
    place.write("mixed.suite", &format!("suite mixed {{ scenarios {scenarios} }}"));
    let last =
        |arguments: &[&str]| place.run(&[&["mixed.suite", "-j", "1", "--last-failed"], arguments].concat());
    // Where nothing is known of, nothing has passed either.
    let everything = last(&[]);
    assert_eq!(code(&everything), 100);
    assert!(stderr(&everything).contains("all of it is run"), "{}", stderr(&everything));
    let keys = |output: &Output| status(output).into_iter().map(|(_, key)| key).collect::<Vec<_>>();
    let all = ["mixed/stands_in_lane/tta=4s", "mixed/stands_in_lane/tta=6s", "mixed/stands_in_lane/tta=10s"];
    assert_eq!(keys(&last(&[])), all);
    assert_eq!(keys(&last(&["tta=6s"])), all[1..2]);
    assert_eq!(keys(&last(&[])), all, "those that were not run are still to be run");
    assert_eq!(fs::read_to_string(place.path(".scenario-runner/.gitignore")).unwrap(), "*\n");
    let replayed = place.run(&["replay", "mixed/stands_in_lane/tta=6s/rep=1", "mixed.suite"]);
    let said = "the same run, bit for bit, as when its suite was last run";
    assert!(stdout(&replayed).contains(said), "{}", stdout(&replayed));
    let other = place.run(&["replay", "mixed/scripted/tta=6s/rep=1", "mixed.suite"]);
    assert!(stdout(&other).contains("run twice: the same, bit for bit\n"), "{}", stdout(&other));
}

/// What an early end kept from beginning has not passed.
#[test]
fn what_was_not_begun_is_run_with_what_failed() {
    let place = Place::new("");
    let scenarios = format!("\"{}\", \"{}\"", shipped("unsafe/stands_in_lane"), shipped("zebra/scripted"));
    place.write("mixed.suite", &format!("suite mixed {{ scenarios {scenarios} }}"));
    let all = names_in(&place, &["mixed.suite", "--list"]);
    assert_eq!(code(&place.run(&["mixed.suite", "-j", "1", "--fail-fast"])), 100);
    let left = names_in(&place, &["mixed.suite", "--last-failed", "--list"]);
    assert!(left.len() > 3, "{left:?}");
    assert_eq!(left, all, "the first of all failed");
    // Once everything has been run, only what failed.
    place.run(&["mixed.suite", "--last-failed"]);
    assert_eq!(names_in(&place, &["mixed.suite", "--last-failed", "--list"]).len(), 3);
}

/// A name that a flipped bit changed would be a failure that is forgotten.
#[test]
fn a_damaged_memory_of_what_failed_runs_everything() {
    let place = Place::new("");
    let scenarios = format!("\"{}\", \"{}\"", shipped("unsafe/stands_in_lane"), shipped("zebra/scripted"));
    place.write("mixed.suite", &format!("suite mixed {{ scenarios {scenarios} }}"));
    let all = names_in(&place, &["mixed.suite", "--list"]);
    place.run(&["mixed.suite"]);
    let memory = place.path(".scenario-runner/last-run.json");
    let good = fs::read_to_string(&memory).unwrap();
    assert_eq!(names_in(&place, &["mixed.suite", "--last-failed", "--list"]).len(), 3);
    let cut = &good[..good.len() / 2];
    for damaged in
        [&*good.replacen("tta=4s", "tta=5s", 1), &*good.replacen("\"failed\"", "\"fa1led\"", 1), cut, ""]
    {
        fs::write(&memory, damaged).unwrap();
        let listed = place.run(&["mixed.suite", "--last-failed", "--list"]);
        let said = "what failed when it was last run cannot be read, or is damaged: all of it is run";
        assert!(stderr(&listed).contains(said), "{}", stderr(&listed));
        assert_eq!(stdout(&listed).lines().count(), all.len(), "{}", stdout(&listed));
    }
    // One of an earlier version has no checksum.
    let before: Vec<&str> = good.lines().filter(|line| !line.contains("\"crc\"")).collect();
    fs::write(&memory, before.join("\n").replace("},\n}", "}\n}")).unwrap();
    assert_eq!(names_in(&place, &["mixed.suite", "--last-failed", "--list"]).len(), 3);
}

#[cfg(unix)]
mod interrupts {
    use std::io::{BufRead, BufReader, Read};
    use std::process::{Child, Stdio};
    use std::thread;
    use std::time::Duration;

    use super::*;

    /// Presses Ctrl-C.
    fn interrupt(child: &Child) {
        let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
    }

    fn start(place: &Place, arguments: &[&str]) -> Child {
        place.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Reads lines until one has `text` in it.
    fn wait_for(reader: &mut impl BufRead, text: &str) {
        let mut line = String::new();
        while !line.contains(text) {
            line.clear();
            assert!(reader.read_line(&mut line).unwrap() > 0, "no line with `{text}`");
        }
    }

    /// A pedestrian who takes an hour, over and over; the smaller the step (s), the longer each run.
    fn endless(place: &Place, step: f64) {
        let text = fs::read_to_string(shipped("unsafe/stands_in_lane")).unwrap();
        let varied = "vary tta in [4 s, 6 s]\n  repeat 500\n  horizon 3600 s";
        let text = text
            .replace("../roads", &shipped("roads").replace(".scn", ""))
            .replace("speed: 1.4 m/s, stop_after: 4 m, stop_for: 10 s", "speed: 0.0001 m/s")
            .replace("vary tta in [4 s, 6 s, 10 s]", &format!("{varied}\n  step {step} s"));
        place.write("endless.scn", &text);
    }

    #[test]
    fn once_reports_what_is_finished() {
        let place = Place::new("");
        endless(&place, 0.01);
        let quick = format!("suite both {{ scenarios \"{}\", \"endless.scn\" }}", shipped("zebra/scripted"));
        place.write("both.suite", &quick);
        let reports =
            ["--json", "results.json", "--junit", "j.xml", "--tap", "r.tap", "--html", "r.html", "--github"];
        let options = ["both.suite", "-j", "1", "--status-level", "all"];
        let mut child = start(&place, &[&options[..], &reports].concat());
        let mut out = BufReader::new(child.stdout.take().unwrap());
        wait_for(&mut out, "BEGIN both/stands_in_lane/tta=4s");
        interrupt(&child);
        let mut rest = String::new();
        out.read_to_string(&mut rest).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(105), "{rest}");
        assert!(rest.contains("Stopping no more runs begin"), "{rest}");
        let cut = "NOT FINISHED [";
        assert!(
            rest.contains(cut) && rest.contains("both/stands_in_lane/tta=4s: interrupted after "),
            "{rest}"
        );
        assert!(rest.contains("4 passed, 1 not finished, 1 not run"), "{rest}");
        assert!(rest.contains("::error file=both.suite,line=1,"), "{rest}");
        let read = |name: &str| fs::read_to_string(place.path(name)).unwrap();
        let results: Value = serde_json::from_str(&read("results.json")).unwrap();
        let suite = &results["suites"][0];
        assert_eq!(suite["interrupted"], true);
        let verdict = |trial: usize| (&suite["trials"][trial]["verdict"], &suite["trials"][trial]["message"]);
        assert_eq!(verdict(4).0, "not_finished");
        assert_eq!(verdict(5), (&"skipped".into(), &"interrupted".into()));
        // What a CI reads must not be green: what was begun is an error, and the suite says why the rest is missing.
        let junit = quick_junit::Report::deserialize_from_str(&read("j.xml")).unwrap();
        assert_eq!((junit.errors, junit.failures), (2, 0), "{}", read("j.xml"));
        assert_eq!(read("j.xml").matches("type=\"interrupted\"").count(), 2, "{}", read("j.xml"));
        assert!(read("r.tap").contains("not ok 5 - both/stands_in_lane/tta=4s\n"));
        assert!(
            read("r.tap")
                .ends_with("Bail out! suite both interrupted: 4 finished, 1 not finished, 1 not run\n")
        );
        assert!(read("r.html").contains("interrupted: 1 not finished, 1 not run"));
    }

    /// Waits until the program hears Ctrl-C.
    #[cfg(target_os = "linux")]
    fn wait_until_it_listens(child: &Child) {
        const INTERRUPT: u64 = 1 << 1;
        let begun = std::time::Instant::now();
        loop {
            let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
            let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap().trim();
            if u64::from_str_radix(caught, 16).unwrap() & INTERRUPT != 0 {
                return;
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "it never hears Ctrl-C");
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Commands that run suites for their numbers end like a run: they say so, and nothing is left behind.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_was_not_measured_to_its_end_is_neither_saved_nor_compared() {
        let place = Place::new("");
        endless(&place, 0.01);
        let cases: [(&[&str], &str); 2] = [
            (&["baseline", "save", "endless.scn", "--out", "new.json"], "interrupted: nothing saved\n"),
            (&["compare", "endless.scn", "endless.scn"], "interrupted: nothing was compared\n"),
        ];
        for (arguments, said) in cases {
            let child = start(&place, arguments);
            wait_until_it_listens(&child);
            interrupt(&child);
            let output = child.wait_with_output().unwrap();
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            assert_eq!(output.status.code(), Some(105), "{arguments:?}: {}", text(&output.stderr));
            assert!(text(&output.stderr).ends_with(said), "{}", text(&output.stderr));
            assert_eq!(text(&output.stdout), "");
            assert!(!place.path("new.json").exists());
        }
    }

    #[test]
    fn the_time_limit_is_an_error_and_no_verdict() {
        let place = Place::new("");
        endless(&place, 0.01);
        place.write("limit.suite", "suite limit { time_limit 0.01 s per case; scenarios \"endless.scn\" }");
        let output = place.run(&["limit.suite", "-j", "1", "--junit", "j.xml", "--json", "r.json"]);
        let said = stdout(&output);
        assert_eq!(code(&output), 100, "{said}");
        assert!(said.contains("2 not finished") && !said.contains("failed"), "{said}");
        assert!(said.contains("this machine was too slow, or the limit is too tight"), "{said}");
        let junit = fs::read_to_string(place.path("j.xml")).unwrap();
        assert_eq!(junit.matches("type=\"time_limit\"").count(), 2, "{junit}");
        let results: Value =
            serde_json::from_str(&fs::read_to_string(place.path("r.json")).unwrap()).unwrap();
        let trial = &results["suites"][0]["trials"][0];
        assert_eq!((&trial["verdict"], &trial["cut_by"]), (&"not_finished".into(), &"time_limit".into()));
        assert_eq!(results["suites"][0]["interrupted"], false);
    }

    #[test]
    fn twice_stops_at_once() {
        // On a busy machine the run may be over before the second one comes, which then tells nothing.
        assert!((0..10).any(|_| is_stopped_by_two()), "it always ended as after one");
    }

    /// Whether two interrupts stopped it before it could sum up.
    fn is_stopped_by_two() -> bool {
        let place = Place::new("");
        endless(&place, 0.0001);
        let mut child = start(&place, &["endless.scn", "-j", "1", "--status-level", "all"]);
        let mut out = BufReader::new(child.stdout.take().unwrap());
        wait_for(&mut out, "BEGIN");
        interrupt(&child);
        wait_for(&mut out, "Stopping");
        interrupt(&child);
        let mut rest = String::new();
        out.read_to_string(&mut rest).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(105));
        !rest.contains("Summary")
    }

    /// Interrupts a block after `evaluations` lines of its journals, alone and as a part of its suite, and lets it go on.
    fn goes_on(kind: &str, block: &str, evaluations: usize) {
        let (alone, key) = ([kind, "many", "small.suite", "--json", "result.json"], format!("{kind}=many"));
        let result = |place: &Place| {
            let output = place.run(&alone);
            assert_eq!(code(&output), 0, "{}", stderr(&output));
            (stdout(&output), fs::read_to_string(place.path("result.json")).unwrap())
        };
        let undisturbed = result(&Place::new(block));
        for arguments in [&alone[..], &["small.suite", &key][..]] {
            let place = Place::new(block);
            let mut child = start(&place, arguments);
            let journals = place.path(".scenario-runner/journal");
            let recorded = || {
                let files = fs::read_dir(&journals).into_iter().flatten();
                files
                    .filter_map(|entry| fs::read_to_string(entry.ok()?.path()).ok())
                    .map(|text| text.lines().count())
                    .sum::<usize>()
            };
            while recorded() < evaluations {
                assert!(child.try_wait().unwrap().is_none(), "it ended before it could be interrupted");
                thread::sleep(Duration::from_millis(1));
            }
            interrupt(&child);
            let output = child.wait_with_output().unwrap();
            assert_eq!(code(&output), 105, "{}{}", stdout(&output), stderr(&output));
            let said = format!("{}{}", stdout(&output), stderr(&output));
            assert!(said.contains("interrupted") && said.contains("goes on from"), "{said}");
            let kept = || fs::read_dir(&journals).into_iter().flatten().count();
            assert_ne!(kept(), 0);
            assert_eq!(result(&place), undisturbed);
            // A tune leaves its journal for a larger budget.
            assert_eq!(kept() > 0, kind == "tune");
        }
    }

    #[test]
    fn a_search_goes_on_from_its_journal_to_the_same_result() {
        let search = "search many {\n  in commotions_carla\n  individuals 5 of standard\n  minimise pet\n\
                      over tta in 6 s .. 18 s\n  budget 60 evaluations, by random\n}\n";
        goes_on("search", search, 20);
    }

    #[test]
    fn a_tune_goes_on_from_its_journal_to_the_same_result() {
        let tune = "tune many {\n  on commotions_carla\n  over av.controller.braking_distance in 4 m .. 25 m\n\
                    minimise mean(time_lost)\n  subject to no collision\n  budget 12 evaluations, by random\n}\n";
        goes_on("tune", tune, 4);
    }
}
