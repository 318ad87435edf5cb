//! Users' own controllers: programs that decide, and all that programs do which they must not.
//!
//! The programs under test are this one, and so is the runner: `TESTS_UNDER_TEST` says which it is.

#[path = "under_test/child.rs"]
mod child;
#[path = "under_test/estimates.rs"]
mod estimates;
#[cfg(feature = "fmu")]
#[path = "under_test/fmus.rs"]
mod fmus;
#[path = "under_test/instead.rs"]
mod instead;
#[cfg(feature = "wasm")]
#[path = "under_test/modules.rs"]
mod modules;
#[path = "under_test/parent.rs"]
mod parent;
#[path = "under_test/permission.rs"]
mod permission;
#[path = "under_test/second_runs.rs"]
mod second_runs;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use libtest_mimic::{Arguments, Failed, Trial};
use models::standard;
use scenario_runner::cli;

use estimates::a_program_that_dies_in_one_of_many_runs_leaves_no_number;
use permission::{nothing_runs_that_is_not_allowed, what_is_allowed_runs_until_it_is_another};
use second_runs::{
    a_recorded_failure_of_chance_is_kept, what_goes_by_the_clock_is_not_deterministic,
    what_is_deterministic_is_not_warned_of,
};

const ROLE: &str = "TESTS_UNDER_TEST";

type Outcome = Result<(), Failed>;

/// A scenario whose vehicle is driven by this program with these words, and what else the declaration says.
fn scenario(words: &str, more: &str) -> String {
    let own = std::env::current_exe().unwrap();
    let words: String = words.split_whitespace().map(|word| format!(", \"{word}\"")).collect();
    format!(
        "controller own {{
  command \"{}\"{words}
  environment \"{ROLE}=child\"
  parameter gap = 5 m in 1 m .. 30 m
  {more}
}}

scenario meet {{
  road {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
  vehicle av {{ controller own; speed 30 km/h; start 30 m before crossing }}
  pedestrian walker {{ model scripted; start 2 m from kerb; appears at later }}
  vary later in [0 s, 0.2 s]
  finish 20 m
  expect {{ max_deceleration <= 9 m/s^2 }}
}}
",
        // As one writes it on Windows, too.
        own.display().to_string().replace('\\', "/")
    )
}

/// What the runner said, on both streams, and its exit code.
#[derive(Debug)]
struct Said {
    code: Option<i32>,
    text: String,
}

fn runner(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command
        .args(arguments)
        .current_dir(folder)
        .env(ROLE, "runner")
        .env("NO_COLOR", "1")
        .env("XDG_CONFIG_HOME", folder.join("config"))
        .env("APPDATA", folder.join("config"))
        .env_remove("SCENARIO_RUNNER_ALLOW_RUN");
    command
}

fn run(folder: &Path, arguments: &[&str]) -> Said {
    let output = runner(folder, arguments).output().unwrap();
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    let text = if cfg!(windows) { text.replace('\\', "/") } else { text };
    Said { code: output.status.code(), text }
}

fn in_folder(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("meet.scn"), text).unwrap();
    folder
}

fn expect(holds: bool, otherwise: impl FnOnce() -> String) -> Outcome {
    if holds { Ok(()) } else { Err(otherwise().into()) }
}

fn expect_all(said: &Said, code: i32, words: &[&str]) -> Outcome {
    let missing: Vec<_> = words.iter().filter(|word| !said.text.contains(**word)).collect();
    expect(missing.is_empty() && said.code == Some(code), || {
        format!("{missing:?} missing, exit {:?} in\n{}", said.code, said.text)
    })
}

/// What runs come to: key and fingerprint of each.
fn fingerprints(text: &str, arguments: &[&str]) -> Result<Vec<(String, String)>, Failed> {
    let folder = in_folder(text);
    let mut all = vec!["meet.scn", "--allow-run", "--no-progress", "--json=out.json"];
    all.extend(arguments);
    let said = run(folder.path(), &all);
    expect(said.code == Some(0), || said.text.clone())?;
    written_fingerprints(folder.path())
}

/// Key and fingerprint of each run in the results that were written there.
fn written_fingerprints(folder: &Path) -> Result<Vec<(String, String)>, Failed> {
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(folder.join("out.json"))?)?;
    let mut found = Vec::new();
    gather(&json, &mut found);
    found.sort();
    found.dedup();
    expect(!found.is_empty(), || "no run has a fingerprint".to_string())?;
    Ok(found)
}

fn gather(value: &serde_json::Value, found: &mut Vec<(String, String)>) {
    if let (Some(key), Some(fingerprint)) = (value["key"].as_str(), value.get("fingerprint")) {
        found.push((key.to_string(), fingerprint.to_string()));
    }
    value.as_object().into_iter().flat_map(|fields| fields.values()).for_each(|one| gather(one, found));
    value.as_array().into_iter().flatten().for_each(|one| gather(one, found));
}

fn many(words: &str, more: &str) -> String {
    scenario(words, more)
        .replace("  expect {", "  vary own_gap in [5 m, 8 m, 20 m]\n  repeat 3\n  expect {")
        .replace("controller own;", "controller own { gap: own_gap };")
}

/// The same without repetitions.
fn each_once(words: &str, more: &str) -> String {
    many(words, more).replace("repeat 3", "repeat 1")
}

fn every_wire_and_batch_gives_the_same_bits() -> Outcome {
    let known = fingerprints(&many("", "period 100 ms"), &["-j1"])?;
    for (words, threads) in [
        ("at_once=1 encoding=f64", "-j3"),
        ("at_once=8", "-j3"),
        ("at_once=5 encoding=f64", "-j1"),
        ("at_once=64 encoding=f64", "-j3"),
    ] {
        let found = fingerprints(&many(words, "period 100 ms"), &[threads])?;
        expect(found == known, || format!("{words} {threads}: {found:#?} {known:#?}"))?;
    }
    let other = fingerprints(&many("", "period 100 ms; delay 70 ms"), &["-j1"])?;
    expect(other != known, || "a delay changes nothing".to_string())
}

fn everything_that_may_be_given_drives() -> Outcome {
    for gives in ["acceleration", "pedals", "speed", "speed_plan"] {
        let more = format!("gives {gives}; period 70 ms; delay 110 ms; settles within 1 s");
        let json = fingerprints(&each_once(&format!("gives={gives}"), &more), &[])?;
        let rows = fingerprints(&each_once(&format!("gives={gives} encoding=f64 at_once=4"), &more), &[])?;
        expect(json == rows, || format!("{gives}: {json:#?} {rows:#?}"))?;
    }
    Ok(())
}

fn who_steers_does_so_through_every_wire() -> Outcome {
    for gives in ["acceleration", "pedals", "speed_plan"] {
        let more = format!("gives {gives}; period 70 ms; delay 110 ms; settles within 1 s");
        let found = |words: &str| fingerprints(&each_once(&format!("gives={gives} {words}"), &more), &[]);
        let (straight, json) = (found("")?, found("kind=steers")?);
        let rows = found("kind=steers encoding=f64 at_once=4")?;
        expect(json == rows, || format!("{gives}: {json:#?} {rows:#?}"))?;
        let differ = json.iter().zip(&straight).all(|(one, other)| one.0 == other.0 && one.1 != other.1);
        expect(differ, || format!("{gives}: nobody steers in {json:#?}"))?;
    }
    for encoding in ["json", "f64"] {
        let folder = in_folder(&scenario(&format!("kind=steers_sharply encoding={encoding}"), ""));
        let said = run(folder.path(), &["meet.scn", "--allow-run", "--no-progress"]);
        expect_all(&said, 100, &["a curvature of 10.5 1/m, outside -10 .. 10 1/m"])?;
    }
    Ok(())
}

fn two_vehicles_and_perception() -> Outcome {
    let two = |words: &str| {
        many(words, "period 100 ms").replace("  pedestrian walker", "  vehicle other { controller own; speed 20 km/h; start 60 m before crossing; sees { range: 40 m, position_noise: 0.2 m } }\n  pedestrian walker")
    };
    let json = fingerprints(&two("at_once=2"), &[])?;
    expect(json == fingerprints(&two("at_once=16 encoding=f64"), &["-j2"])?, || format!("{json:#?}"))?;
    // One run of it takes two slots.
    let folder = in_folder(&two("at_once=1"));
    expect_all(
        &run(folder.path(), &["meet.scn", "--allow-run"]),
        100,
        &["more of its vehicles are in one run"],
    )
}

/// What a program does, its kind of fault, and words that are said of it.
const MISBEHAVIOURS: [(&str, &str, &str); 20] = [
    ("answers_twice", "garbage", "it said more than it was asked for"),
    ("answers_again", "garbage", "it said more than it was asked for"),
    ("crash", "exited", "it ended with exit code 1"),
    ("abort", "exited", "it was ended by signal 6 (SIGABRT)"),
    ("segfault", "exited", "it was ended by signal 11 (SIGSEGV)"),
    ("ignores_sigterm", "timeout", "no answer within 1 s"),
    ("exit_0", "exited", "it ended with exit code 0"),
    ("hang", "timeout", "no answer within 1 s"),
    ("garbage", "garbage", "`what is this?` is no"),
    ("too_few", "garbage", "it answered for 0 runs, asked for 1"),
    ("endless", "garbage", "a line of more than 1 MiB that begins with `aaaa"),
    ("grandchild", "exited", "it ended with exit code 5"),
    ("nan", "bad_value", "`acceleration` is null, which is no number"),
    ("huge", "bad_value", "an acceleration of 51 m/s²"),
    ("refuses", "refused", "lane is None"),
    ("refuses_to_open", "refused", "no such weights"),
    ("fills_stdout", "garbage", "it said more than it was asked for"),
    ("fills_stderr", "timeout", "no answer within 1 s"),
    ("never_reads", "timeout", "no answer within 1 s"),
    (
        "crash_together at_once=2",
        "only_together",
        "with many runs at once it failed (exited), with each alone it did not",
    ),
];

fn a_misbehaviour_is_an_error_in_every_report(kind: &str, fault: &str, words: &str) -> Outcome {
    let text = scenario(&format!("kind={kind}"), "answers within 1 s");
    let text = text.replace("later in [0 s, 0.2 s]", "later in [0 s]");
    let text = match kind {
        // More than a pipe holds, so that not even the request goes out.
        "never_reads" => {
            let weights = |number: usize| format!("parameter weights{number} = \"{}\"\n  ", "w".repeat(4000));
            let weights: String = (0..20).map(weights).collect();
            text.replace("answers within 1 s", &format!("{weights}starts within 1 s"))
        }
        _ if fault == "only_together" => text.replace("  expect {", "  repeat 2\n  expect {"),
        _ => text,
    };
    let folder = in_folder(&text);
    let files = ["junit", "json", "tap", "html"];
    let options: Vec<_> = files.iter().map(|kind| format!("--{kind}=report.{kind}")).collect();
    let mut arguments = vec!["meet.scn", "--no-progress", "--github", "--allow-run", "-j1"];
    arguments.extend(options.iter().map(String::as_str));
    let said = run(folder.path(), &arguments);
    let what = format!("{fault}: ");
    let replay = "scenario-runner replay 'meet/meet/later=0s/rep=1' meet.scn --seed 1";
    let log = PathBuf::from(".scenario-runner/controllers/own-");
    let all = ["`av` cannot decide", &what, words, replay, &*log.to_string_lossy()];
    expect_all(&said, 100, &all)?;
    let mut shown = format!("{}\n", said.text);
    for kind in files {
        let report = fs::read_to_string(folder.path().join(format!("report.{kind}")))?;
        let plain = [("&#39;", "'"), ("&apos;", "'"), ("&#x27;", "'"), ("&#x2f;", "/"), ("&lt;", "<")]
            .iter()
            .fold(report.clone(), |text, (escaped, letter)| text.replace(escaped, letter));
        for word in ["cannot decide", &what, replay] {
            expect(plain.contains(word), || format!("{kind} does not say {word}:\n{plain}"))?;
        }
        shown += &format!("=== {kind} ===\n{}\n", gist(kind, &report)?);
    }
    let (junit, json) = ("type=\"controller-", "\"kind\": \"");
    for (report, word) in [("junit", format!("{junit}{fault}\"")), ("json", format!("{json}{fault}\""))] {
        let report = fs::read_to_string(folder.path().join(format!("report.{report}")))?;
        expect(report.contains(&word), || format!("{word} is not in {report}"))?;
    }
    let declared =
        format!("::error file=meet.scn,line=1,col=12,endColumn=15,title=controller own%3A {fault}::");
    expect_all(&said, 100, &[&declared])?;
    if kind == "crash" {
        // As it is indented.
        expect_all(
            &said,
            100,
            &["Traceback: lane is None", "  |   File \"av.py\", line 3, in step\n  |     lane.width"],
        )?;
    }
    // What an endless line and a grandchild leave of a log depends on when they are ended.
    let kind = kind.split(' ').next().unwrap_or_default();
    insta::assert_snapshot!(format!("misbehaviour_{kind}"), redacted(&shown));
    Ok(())
}

/// What a report says of the trial.
fn gist(kind: &str, report: &str) -> Result<String, Failed> {
    Ok(match kind {
        "json" => {
            let json: serde_json::Value = serde_json::from_str(report)?;
            let trial = &json["suites"][0]["trials"][0];
            let names = ["key", "verdict", "message", "faults", "runs"];
            let said: serde_json::Map<_, _> =
                names.iter().map(|name| (name.to_string(), trial[name].clone())).collect();
            serde_json::to_string_pretty(&said)?
        }
        "html" => {
            let begin = report.find("<details class=\"failure\"").ok_or("no failure")?;
            let end = report[begin..].find("</details>").ok_or("no end")?;
            report[begin..begin + end].to_string()
        }
        _ => report.to_string(),
    })
}

/// Without what is another one every time: times, places and versions.
fn redacted(text: &str) -> String {
    let own = std::env::current_exe().unwrap().display().to_string();
    let rules = [
        (r#"\[ *[0-9.]+ ?m?s\]"#, "[time]"),
        (r#"[0-9]+(\.[0-9]+)? m?s elapsed"#, "[time] elapsed"),
        (r#"\bin [0-9.]+ m?s\b"#, "in [time]"),
        (r#"time="[0-9.]+""#, "time=\"[time]\""),
        (r#"timestamp="[^"]+""#, "timestamp=\"[time]\""),
        (r#"duration_ms: [0-9]+"#, "duration_ms: [time]"),
        (r#"[0-9.]+ (µs|ms|s) \((median|99 %|worst)\)"#, "[time] ($2)"),
        (r#"; [^;]* took longer than .*? on this machine"#, ""),
        (r#"\n *<property name="[a-z_]+" value="undefined"/>"#, ""),
        (r#""fingerprint": "[^"]+""#, "\"fingerprint\": \"[bits]\""),
    ];
    let text = text.replace(&own, "[program]").replace(env!("CARGO_PKG_VERSION"), "[version]");
    rules.iter().fold(text, |text, (rule, by)| {
        regex_lite::Regex::new(rule).unwrap().replace_all(&text, *by).into_owned()
    })
}

/// A child that does not read leaves the pipe full: the request does not even go out.
fn what_stops_reading_is_a_timeout() -> Outcome {
    let text = scenario("kind=hang at_once=512", "answers within 10 ms")
        .replace("later in [0 s, 0.2 s]", "later in 0 s .. 51.1 s step 0.1 s")
        .replace("expect {", "horizon 2 s\n  expect {");
    let folder = in_folder(&text);
    let said = run(folder.path(), &["meet.scn", "--allow-run", "-j1", "--no-progress", "--tap=out.tap"]);
    expect_all(&said, 100, &["512 could not be run", "timeout: no answer within 0.01 s", "given up"])
}

fn a_trial_with_faults_finishes_its_other_runs() -> Outcome {
    let text = |words: &str| {
        scenario(words, "period 100 ms")
            .replace("later in [0 s, 0.2 s]", "later in [0 s, 0.3 s]")
            .replace("  expect {", "  repeat 16\n  expect {")
    };
    let mut known = None;
    for (words, threads) in [("", "-j1"), ("at_once=12", "-j1"), ("at_once=7 encoding=f64", "-j3")] {
        let folder = in_folder(&text(&format!("kind=refuses_some {words}")));
        let said = run(
            folder.path(),
            &["meet.scn", "--allow-run", "--no-progress", threads, "--json=out.json", "--csv=out.csv"],
        );
        expect_all(&said, 100, &["of 16 runs ended in a fault (refused)", "refused: lane is None"])?;
        let json: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(folder.path().join("out.json"))?)?;
        let mut shown = Vec::new();
        for trial in json["suites"][0]["trials"].as_array().unwrap() {
            let (faults, runs) = (trial["faults"].as_array().unwrap(), trial["runs"].as_array().unwrap());
            expect(!faults.is_empty() && faults.len() + runs.len() == 16, || trial.to_string())?;
            expect(trial["verdict"] == "error", || trial["verdict"].to_string())?;
            expect(trial.get("findings").is_none(), || "it was judged".to_string())?;
            let bits = runs.iter().map(|run| (run["key"].to_string(), run["fingerprint"].to_string()));
            let failed = faults.iter().map(|one| (one["run"].to_string(), one["fault"]["time"].to_string()));
            shown.extend(bits.chain(failed));
        }
        let known = known.get_or_insert_with(|| shown.clone());
        expect(*known == shown, || format!("{words} {threads}: {shown:#?}"))?;
        // What is read back says the same.
        let read = |path: &str| run(folder.path(), &["report", path, "--json=again.json"]);
        let again = read("out.json");
        let same = fs::read(folder.path().join("out.json"))?
            == fs::read(folder.path().join("again.json")).unwrap_or_default();
        expect(same, || format!("{again:?}"))?;
        let csv = fs::read_to_string(folder.path().join("out.csv"))?;
        let count = |word: &str| csv.lines().filter(|line| line.contains(word)).count();
        expect(count(",error") + count(",finished") == 32, || csv.clone())?;
    }
    // One failure is enough for `--max-fail`.
    let folder = in_folder(&text("kind=refuses_some"));
    let said = run(folder.path(), &["meet.scn", "--allow-run", "--no-progress", "-j1", "--max-fail=1"]);
    expect_all(&said, 100, &["--max-fail"])
}

fn a_fault_in_a_block_names_the_values() -> Outcome {
    let search = "search worst {\n  in meet\n  over later in 0 s .. 2 s\n  minimise min_distance\n  budget 6 evaluations, 3 random first\n}\n";
    let tune = "tune best {\n  on meet\n  over av.controller.gap in 5 m .. 20 m\n  minimise mean(max_deceleration)\n  budget 6 evaluations, 3 random first\n}\n";
    let evaluate = "evaluate both {\n  on meet\n  with default, { av.controller.gap: 20 m } as wide\n  measure mean(time_lost)\n}\n";
    for (kind, command, block, values) in [
        ("", "search worst", search, ""),
        ("", "tune best", tune, ""),
        ("", "evaluate both", evaluate, ""),
        ("crash", "search worst", search, "evaluated: later = "),
        ("crash", "tune best", tune, "evaluated: what the scenarios declare"),
        ("crash", "evaluate both", evaluate, "both/default/case=1"),
    ] {
        let words = if kind.is_empty() { String::new() } else { format!("kind={kind}") };
        let folder = in_folder(&(scenario(&words, "period 100 ms") + block));
        let name = command.split(' ').next_back().unwrap();
        let said = run(folder.path(), &["meet.scn", name, "--allow-run", "--no-progress", "--junit=out.xml"]);
        if kind.is_empty() {
            expect_all(&said, 0, &[])?;
        } else {
            expect_all(&said, 100, &[values, "exited: it ended with exit code 1"])?;
            let junit = fs::read_to_string(folder.path().join("out.xml"))?;
            expect(junit.contains("type=\"controller-exited\""), || junit.clone())?;
        }
    }
    Ok(())
}

/// Three starts in a row without a finished run are too many; three in a thousand runs are not.
fn what_crashes_now_and_then_is_not_given_up() -> Outcome {
    let text = scenario("kind=crash_some", "period 100 ms")
        .replace("later in [0 s, 0.2 s]", "later in 0 s .. 2.9 s step 0.1 s")
        .replace("  expect {", "  horizon 3 s\n  repeat 4\n  expect {");
    for threads in ["-j1", "-j3"] {
        let folder = in_folder(&text);
        let said =
            run(folder.path(), &["meet.scn", "--allow-run", "--no-progress", threads, "--json=out.json"]);
        expect(!said.text.contains("given up"), || said.text.clone())?;
        let json: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(folder.path().join("out.json"))?)?;
        let trials = json["suites"][0]["trials"].as_array().unwrap();
        let of =
            |name: &str| trials.iter().map(|one| one[name].as_array().map_or(0, Vec::len)).sum::<usize>();
        let (faults, runs) = (of("faults"), of("runs"));
        expect(faults > 6 && faults + runs == 120, || format!("{faults} faults, {runs} runs"))?;
    }
    Ok(())
}

fn a_slow_program_does_not_outlast_a_time_limit() -> Outcome {
    // Its answers to one run take 20 s.
    let folder = in_folder(&scenario("kind=slow", "period 100 ms"));
    fs::write(
        folder.path().join("slow.suite"),
        "suite slow {\n  scenarios \"meet.scn\"\n  time_limit 0.5 s per case\n}\n",
    )?;
    let said = run(folder.path(), &["slow.suite", "--allow-run", "--no-progress", "--json=out.json"]);
    expect_all(&said, 100, &["time limit of 0.5 s exceeded after 0 of 1 runs"])?;
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(folder.path().join("out.json"))?)?;
    let trials = json["suites"][0]["trials"].as_array().unwrap();
    let finished: usize = trials.iter().map(|trial| trial["runs"].as_array().map_or(0, Vec::len)).sum();
    expect(trials.len() == 2 && finished == 0, || format!("{finished} runs finished: {trials:#?}"))
}

fn what_floods_its_log_and_prints_first_runs() -> Outcome {
    for kind in ["flood", "prints_first"] {
        let known = fingerprints(&scenario("", "period 100 ms"), &[])?;
        let found = fingerprints(&scenario(&format!("kind={kind}"), "period 100 ms"), &[])?;
        expect(found == known, || format!("{kind}: {found:?}"))?;
    }
    Ok(())
}

fn what_does_not_start_is_said_before_anything_runs() -> Outcome {
    for (kind, code, words) in [
        ("silent", "E1107", "it said nothing within 0.2 s"),
        ("chatter", "E1107", "it printed more than 100 lines"),
        ("ends_at_once", "E1107", "it wrote: no such weights: v3.onnx"),
        ("wrong_version", "E1107", "it speaks protocol 2"),
        ("narrow", "E1108", "the program takes 0 .. 20 m for `gap`, the file 1 .. 30 m"),
    ] {
        let limit = if kind == "silent" { "starts within 0.2 s" } else { "" };
        let folder = in_folder(&scenario(&format!("kind={kind}"), limit));
        let said = run(folder.path(), &["meet.scn", "--allow-run"]);
        expect_all(&said, 3, &[code, words])?;
        expect(!said.text.contains("Starting"), || said.text.clone())?;
        let place = if kind == "narrow" { "meet.scn:4" } else { "meet.scn:1" };
        expect_all(&said, 3, &[place])?;
    }
    let missing = "controller own { command \"no_such_program_here\" }\n";
    let text = scenario("", "");
    let folder = in_folder(&format!("{missing}{}", &text[text.find("\nscenario").unwrap()..]));
    expect_all(&run(folder.path(), &["meet.scn", "--allow-run"]), 3, &["E1106", "not found on PATH"])?;
    let folder = in_folder(&scenario("kind=knows_more", ""));
    expect_all(
        &run(folder.path(), &["meet.scn", "--allow-run"]),
        0,
        &["W1101", "also has `horizon` (5 .. 80)"],
    )
}

fn declared_controllers_are_listed_with_their_file() -> Outcome {
    let folder = in_folder(&scenario("touch=ran", ""));
    for arguments in [&["models", "own", "meet.scn"][..], &["models", "meet.scn"]] {
        let said = run(folder.path(), arguments);
        expect_all(&said, 0, &["own", "own is declared in meet.scn:1 and runs ", "touch=ran"])?;
    }
    expect_all(&run(folder.path(), &["models", "own", "meet.scn"]), 0, &["gap", "5 m (1 m .. 30 m)"])?;
    expect_all(&run(folder.path(), &["models", "owm", "meet.scn"]), 2, &["nearest name is `own`"])?;
    expect_all(&run(folder.path(), &["models", "own"]), 2, &["nothing is called `own`"])?;
    expect_all(&run(folder.path(), &["models", "own", "no.scn"]), 3, &["no.scn"])?;
    expect(!folder.path().join("ran").exists(), || "it was started".to_string())
}

/// A shrunk case names the declaration from where it lies, so that it runs there, with the same permission.
fn a_shrunk_case_finds_its_controller_from_another_folder() -> Outcome {
    let folder = in_folder(&scenario("", "").replace("<= 9 m/s^2", "<= 1 m/s^2"));
    let path = folder.path();
    fs::create_dir_all(path.join("out/deep"))?;
    expect_all(&run(path, &["allow", "meet.scn"]), 0, &[])?;
    let key = "meet/meet/later=0s/rep=1";
    let to = ["shrink", key, "meet.scn", "--no-progress", "--output"];
    expect_all(&run(path, &[&to[..], &["out/deep/small.scn"]].concat()), 0, &["wrote out/deep/small.scn"])?;
    let written = fs::read_to_string(path.join("out/deep/small.scn"))?;
    expect(written.contains("use \"../../meet.scn\""), || written.clone())?;
    expect_all(&run(path, &["out/deep/small.scn"]), 100, &["FAIL"])?;
    expect_all(&run(path, &[&to[..], &["small.scn"]].concat()), 0, &["wrote small.scn"])?;
    let written = fs::read_to_string(path.join("small.scn"))?;
    expect(written.contains("use \"meet.scn\""), || written.clone())?;
    expect_all(&run(&path.join("out/deep"), &["small.scn"]), 3, &["E1105"])
}

/// What a program calls itself stands in a baseline; a gate says what it is now, and no case is another one for that.
fn a_gate_names_both_versions() -> Outcome {
    let folder = in_folder(&scenario("version=2026.2", "period 100 ms"));
    let path = folder.path();
    let gate = "suite gated {\n  scenarios \"meet.scn\"\n  gate same { baseline \"base.json\"; no metric worse by more than 50 % with 95 % confidence }\n}\n";
    fs::write(path.join("gated.suite"), gate)?;
    let save = ["baseline", "save", "gated.suite", "--out", "base.json", "--allow-run"];
    expect_all(&run(path, &save), 0, &[])?;
    let baseline = fs::read_to_string(path.join("base.json"))?;
    expect(baseline.contains("\"programs\": {\"own\":\"tested 2026.2\"}"), || baseline.clone())?;
    expect_all(&run(path, &["baseline", "show", "base.json"]), 0, &["controller own: tested 2026.2"])?;
    // The same words on the command line, another program behind them: its version is in a file of its own.
    let said = run(path, &["gated.suite", "--allow-run", "--no-progress"]);
    expect(said.code == Some(0) && !said.text.contains("tested: own"), || format!("{said:?}"))?;
    fs::write(path.join("version"), "2026.3")?;
    let said = run(path, &["gated.suite", "--allow-run", "--no-progress"]);
    expect_all(&said, 0, &["tested: own: tested 2026.2 -> tested 2026.3"])?;
    // Of the same name and version, and yet another program, or the same asked at other times.
    fs::remove_file(path.join("version"))?;
    for (words, more, now) in [
        ("version=2026.2 kind=gentle", "period 100 ms", " kind=gentle"),
        ("version=2026.2", "period 200 ms", "every 0.2 s"),
    ] {
        fs::write(path.join("meet.scn"), scenario(words, more))?;
        let said = run(path, &["gated.suite", "--allow-run", "--no-progress"]);
        expect(said.text.contains("tested: own runs: ") && said.text.contains(now), || format!("{said:?}"))?;
    }
    // So it is where the suite puts it in another's place, whoever stood there when the baseline was recorded.
    let instead = gate.replace("  gate", "  test own as av\n  gate");
    fs::write(path.join("gated.suite"), &instead)?;
    let said = run(path, &["gated.suite", "--allow-run", "--no-progress"]);
    expect_all(&said, 3, &["this file knows no controller `own`"])?;
    let instead = format!("use \"meet.scn\"\n{instead}");
    fs::write(path.join("gated.suite"), instead)?;
    fs::write(
        path.join("meet.scn"),
        scenario("version=2026.2", "period 100 ms").replace("controller own;", "controller carla_behavior;"),
    )?;
    let said = run(path, &["gated.suite", "--allow-run", "--no-progress"]);
    expect(said.code == Some(0) && !said.text.contains("tested: "), || format!("{said:?}"))?;
    fs::write(
        path.join("meet.scn"),
        scenario("version=2026.2", "period 200 ms").replace("controller own;", "controller carla_behavior;"),
    )?;
    let said = run(path, &["gated.suite", "--allow-run", "--no-progress"]);
    expect(said.text.contains("tested: own runs: "), || format!("{said:?}"))
}

/// However many processes a program starts: they end with it, and the runner goes on.
#[cfg(target_os = "linux")]
fn what_forks_without_end_is_ended_with_all_its_processes() -> Outcome {
    let folder = in_folder(
        &scenario("kind=forks", "answers within 2 s").replace("later in [0 s, 0.2 s]", "later in [0 s]"),
    );
    let said = run(folder.path(), &["meet.scn", "--allow-run", "--no-progress"]);
    expect_all(&said, 100, &["timeout: no answer within 2 s", "processes and still forking"])?;
    let own = folder.path().canonicalize()?;
    let begun = Instant::now();
    while !processes_in(&own).is_empty() && begun.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(20));
    }
    expect(processes_in(&own).is_empty(), || format!("{:?} are left", processes_in(&own)))
}

fn of_many_only_those_are_blamed_that_fail_alone() -> Outcome {
    let text = |words: &str| {
        scenario(words, "period 100 ms")
            .replace("vary later in [0 s, 0.2 s]", "vary later in 0 s .. 3.1 s step 0.1 s")
    };
    for kind in ["crash_some", "refuses_some"] {
        let verdicts = |at_once: u32| -> Result<Vec<String>, Failed> {
            let folder = in_folder(&text(&format!("kind={kind} at_once={at_once}")));
            let said =
                run(folder.path(), &["meet.scn", "--allow-run", "--no-progress", "-j1", "--tap=out.tap"]);
            expect(said.code == Some(100), || said.text.clone())?;
            let tap = fs::read_to_string(folder.path().join("out.tap"))?;
            let lines = tap.lines().filter(|line| line.starts_with("ok") || line.starts_with("not ok"));
            Ok(lines.map(|line| line.split(" # ").next().unwrap_or_default().to_string()).collect())
        };
        let alone = verdicts(1)?;
        let failed = alone.iter().filter(|line| line.starts_with("not ok")).count();
        expect((1..16).contains(&failed), || format!("{kind}: {failed} failed: {alone:#?}"))?;
        expect(verdicts(32)? == alone, || format!("{kind}: {alone:#?}"))?;
    }
    let folder = in_folder(&text("kind=crash_together at_once=8"));
    let said = run(folder.path(), &["meet.scn", "--allow-run", "-j1"]);
    expect_all(
        &said,
        100,
        &["only_together: with many runs at once it failed (exited), with each alone it did not"],
    )
}

fn what_always_fails_is_given_up() -> Outcome {
    let text = scenario("kind=crash", "").replace("[0 s, 0.2 s]", "0 s .. 2 s step 0.1 s");
    let folder = in_folder(&text);
    let said = run(folder.path(), &["meet.scn", "--allow-run", "-j1"]);
    expect_all(&said, 100, &["given up: 3 processes ended one after the other", "21 could not be run"])
}

fn tune_finds_the_best_of_a_program() -> Outcome {
    let text = scenario("kind=tuned at_once=16", "period 100 ms")
        + "tune best {\n  on meet\n  over av.controller.gap in 5 m .. 20 m\n  minimise mean(max_deceleration)\n  budget 24 evaluations, 8 random first\n}\n";
    let folder = in_folder(&text);
    let arguments = ["tune", "best", "meet.scn", "--allow-run", "--no-progress", "--save=best.scn"];
    let said = run(folder.path(), &arguments);
    expect_all(&said, 0, &[])?;
    let saved = fs::read_to_string(folder.path().join("best.scn"))?;
    let gap = saved.split("av_controller_gap = ").nth(1).and_then(|rest| rest.split_whitespace().next());
    let gap: f64 = gap.unwrap_or_default().parse().map_err(|_| saved.clone())?;
    expect((gap - 12.5).abs() < 1.0, || format!("{gap} m\n{saved}"))
}

#[cfg(unix)]
fn nothing_is_left_of_a_program_when_the_runner_is_killed() -> Outcome {
    let allowed = ["meet.scn", "--allow-run", "--no-progress"];
    is_gone_with(|folder| runner(folder, &allowed))?;
    // Tests of a project are such a runner, too.
    is_gone_with(|folder| {
        let mut tests = runner(folder, &[]);
        tests.env(ROLE, "supervised_tests").env("SCENARIO_RUNNER_ALLOW_RUN", "own");
        tests
    })
}

/// A program that does not answer is ended with who asked it.
#[cfg(unix)]
fn is_gone_with(runner: impl Fn(&Path) -> Command) -> Outcome {
    let folder = in_folder(&scenario("kind=hang", "answers within 600 s"));
    let mut started = runner(folder.path()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
    let own = folder.path().canonicalize()?;
    let there = || processes_in(&own);
    let wait = |until: &dyn Fn(&[u32]) -> bool| {
        let begun = Instant::now();
        while !until(&there()) && begun.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(20));
        }
        until(&there())
    };
    // The runner, a supervisor and the program.
    let began = wait(&|all| all.len() >= 3);
    let before = there();
    started.kill()?;
    started.wait()?;
    expect(began, || format!("it did not begin: {before:?}"))?;
    let gone = wait(&<[u32]>::is_empty);
    expect(gone, || format!("{:?} of {before:?} are left", there()))
}

/// The processes that stand in a folder.
#[cfg(unix)]
fn processes_in(folder: &Path) -> Vec<u32> {
    let all = fs::read_dir("/proc").into_iter().flatten().filter_map(|entry| {
        let entry = entry.ok()?;
        let id = entry.file_name().to_str()?.parse().ok()?;
        (fs::read_link(entry.path().join("cwd")).ok()? == folder).then_some(id)
    });
    all.collect()
}

fn main() -> ExitCode {
    match std::env::var(ROLE).as_deref() {
        Ok("child") => child::run(),
        Ok("middle") => parent::middle(),
        Ok("runner") => return cli::main(&standard()),
        Ok("tests") => return second_runs::project(),
        Ok("supervised_tests") => return scenario_runner::testing::run(&["meet.scn"], &standard()),
        _ => {}
    }
    let misbehaviours = MISBEHAVIOURS.iter().map(|(kind, fault, words)| {
        Trial::test(
            format!(
                "a_misbehaviour_is_an_error_in_every_report::{}",
                kind.split(' ').next().unwrap_or_default()
            ),
            move || a_misbehaviour_is_an_error_in_every_report(kind, fault, words),
        )
    });
    macro_rules! tests {
        ($($name:ident),* $(,)?) => { vec![$(Trial::test(stringify!($name), $name)),*] };
    }
    let mut trials = tests![
        every_wire_and_batch_gives_the_same_bits,
        everything_that_may_be_given_drives,
        who_steers_does_so_through_every_wire,
        two_vehicles_and_perception,
        what_floods_its_log_and_prints_first_runs,
        what_stops_reading_is_a_timeout,
        a_trial_with_faults_finishes_its_other_runs,
        a_fault_in_a_block_names_the_values,
        what_crashes_now_and_then_is_not_given_up,
        a_program_that_dies_in_one_of_many_runs_leaves_no_number,
        a_slow_program_does_not_outlast_a_time_limit,
        what_goes_by_the_clock_is_not_deterministic,
        what_is_deterministic_is_not_warned_of,
        a_recorded_failure_of_chance_is_kept,
        what_does_not_start_is_said_before_anything_runs,
        declared_controllers_are_listed_with_their_file,
        a_shrunk_case_finds_its_controller_from_another_folder,
        a_gate_names_both_versions,
        nothing_runs_that_is_not_allowed,
        what_is_allowed_runs_until_it_is_another,
        of_many_only_those_are_blamed_that_fail_alone,
        what_always_fails_is_given_up,
        tune_finds_the_best_of_a_program,
    ];
    trials.extend(misbehaviours);
    {
        use instead::*;
        trials.extend(tests![
            what_is_put_in_place_is_as_written_by_hand,
            blocks_are_about_what_is_put_in_place,
            what_replaces_nothing_is_an_error,
            what_replaces_only_some_is_said,
            every_report_says_what_was_replaced,
            what_is_repeated_is_driven_by_the_same,
            a_gate_compares_no_other_system,
        ]);
    }
    {
        use second_runs::*;
        trials.extend(tests![
            a_baseline_by_chance_says_so,
            what_is_deterministic_is_compared_as_ever,
            what_is_made_up_for_a_gate_is_made_twice,
            blocks_by_chance_are_warned_of,
            tests_of_a_project_are_warned,
        ]);
    }
    {
        use parent::*;
        trials.extend(tests![
            a_parent_decides_as_a_child,
            what_a_parent_must_not_is_an_error,
            a_parent_that_draws_is_told_of,
            a_parent_serves_what_is_driven_by_it,
        ]);
        #[cfg(unix)]
        trials.extend(tests![an_interrupted_runner_says_goodbye]);
        #[cfg(target_os = "linux")]
        trials.extend(tests![a_runner_ends_with_its_parent]);
    }
    #[cfg(feature = "wasm")]
    {
        use modules::*;
        trials.extend(tests![
            a_module_decides_as_its_native_twin,
            what_a_module_must_not_is_an_error_of_the_run,
            what_is_no_module_is_said_before_anything_runs,
        ]);
    }
    #[cfg(feature = "fmu")]
    {
        use fmus::*;
        trials.extend(tests![
            a_unit_decides_as_its_native_twin,
            a_unit_steers_as_its_native_twin,
            instances_share_nothing,
            who_shares_a_request_with_a_failing_run_steps_once,
            what_a_unit_prints_is_log,
            units_are_converted_as_they_are_said,
            what_cannot_be_wired_is_said_before_anything_runs,
            inputs_that_nobody_tells_are_named,
            parameters_are_those_of_the_unit,
            what_is_no_unit_is_said_before_anything_runs,
            a_unit_needs_permission_for_its_content,
            tests_of_a_project_run_units,
        ]);
        #[cfg(unix)]
        trials.extend(tests![what_was_unpacked_is_gone]);
        // It waits longest, so that the others should not have to wait for it.
        trials.splice(0..0, tests![what_a_unit_must_not_is_an_error_of_the_run]);
    }
    #[cfg(target_os = "linux")]
    trials.extend(tests![
        nothing_is_left_of_a_program_when_the_runner_is_killed,
        what_forks_without_end_is_ended_with_all_its_processes,
    ]);
    let mut arguments = Arguments::from_args();
    // Most of the time they wait for programs that do nothing.
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    arguments.test_threads.get_or_insert(2 * cores);
    libtest_mimic::run(&arguments, trials).exit_code()
}
