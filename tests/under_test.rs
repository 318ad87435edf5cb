//! Users' own controllers: programs that decide, and all that programs do which they must not.
//!
//! The programs under test are this one, and so is the runner: `TESTS_UNDER_TEST` says which it is.

#[path = "under_test/child.rs"]
mod child;
#[cfg(feature = "wasm")]
#[path = "under_test/modules.rs"]
mod modules;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use libtest_mimic::{Arguments, Failed, Trial};
use models::standard;
use scenario_runner::cli;

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
  expect {{ max_deceleration <= 9 m/s^2 }}
}}
",
        own.display()
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
        .env_remove("SCENARIO_RUNNER_ALLOW_RUN");
    command
}

fn run(folder: &Path, arguments: &[&str]) -> Said {
    let output = runner(folder, arguments).output().unwrap();
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
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
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(folder.path().join("out.json"))?)?;
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

fn every_wire_and_batch_gives_the_same_bits() -> Outcome {
    let known = fingerprints(&many("", "period 100 ms"), &["-j1"])?;
    for words in ["at_once=1 encoding=f64", "at_once=8", "at_once=5 encoding=f64", "at_once=64 encoding=f64"]
    {
        for threads in ["-j1", "-j3"] {
            let found = fingerprints(&many(words, "period 100 ms"), &[threads])?;
            expect(found == known, || format!("{words} {threads}: {found:#?} {known:#?}"))?;
        }
    }
    let other = fingerprints(&many("", "period 100 ms; delay 70 ms"), &["-j1"])?;
    expect(other != known, || "a delay changes nothing".to_string())
}

fn everything_that_may_be_given_drives() -> Outcome {
    for gives in ["acceleration", "pedals", "speed", "speed_plan"] {
        let more = format!("gives {gives}; period 70 ms; delay 110 ms; settles within 1 s");
        let json = fingerprints(&many(&format!("gives={gives}"), &more), &[])?;
        let rows = fingerprints(&many(&format!("gives={gives} encoding=f64 at_once=7"), &more), &[])?;
        expect(json == rows, || format!("{gives}: {json:#?} {rows:#?}"))?;
    }
    Ok(())
}

fn two_vehicles_and_perception() -> Outcome {
    let two = |words: &str| {
        many(words, "").replace("  pedestrian walker", "  vehicle other { controller own; speed 20 km/h; start 60 m before crossing; sees { range: 40 m, position_noise: 0.2 m } }\n  pedestrian walker")
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
const MISBEHAVIOURS: [(&str, &str, &str); 12] = [
    ("crash", "exited", "it ended with exit code 1"),
    ("abort", "exited", "it was ended by signal 6 (SIGABRT)"),
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
];

fn a_misbehaviour_is_an_error_in_every_report(kind: &str, fault: &str, words: &str) -> Outcome {
    let text = scenario(&format!("kind={kind}"), "answers within 1 s");
    let text = text.replace("later in [0 s, 0.2 s]", "later in [0 s]");
    let folder = in_folder(&text);
    let files = ["junit", "json", "tap", "html"];
    let options: Vec<_> = files.iter().map(|kind| format!("--{kind}=report.{kind}")).collect();
    let mut arguments = vec!["meet.scn", "--no-progress", "--github", "--allow-run"];
    arguments.extend(options.iter().map(String::as_str));
    let said = run(folder.path(), &arguments);
    let what = format!("{fault}: ");
    let replay = "scenario-runner replay 'meet/meet/later=0s/rep=1' meet.scn --seed 1";
    let log = PathBuf::from(".scenario-runner/controllers/own-");
    let all = ["`av` cannot decide", &what, words, replay, &*log.to_string_lossy()];
    expect_all(&said, 100, &all)?;
    for kind in files {
        let report = fs::read_to_string(folder.path().join(format!("report.{kind}")))?;
        let report = [("&#39;", "'"), ("&apos;", "'"), ("&#x27;", "'"), ("&#x2f;", "/"), ("&lt;", "<")]
            .iter()
            .fold(report, |text, (escaped, letter)| text.replace(escaped, letter));
        for word in ["cannot decide", &what, replay] {
            expect(report.contains(word), || format!("{kind} does not say {word}:\n{report}"))?;
        }
    }
    if kind == "crash" {
        expect_all(&said, 100, &["Traceback: lane is None"])?;
    }
    Ok(())
}

fn what_floods_its_log_and_prints_first_runs() -> Outcome {
    for kind in ["flood", "prints_first"] {
        let known = fingerprints(&scenario("", ""), &[])?;
        let found = fingerprints(&scenario(&format!("kind={kind}"), ""), &[])?;
        expect(found == known, || format!("{kind}: {found:?}"))?;
    }
    Ok(())
}

fn what_goes_by_the_clock_is_not_deterministic() -> Outcome {
    let failing = |more: &str| scenario("kind=clock", more).replace("<= 9 m/s^2", "<= 0.001 m/s^2");
    let folder = in_folder(&failing(""));
    let differs = ["W1102", "`own` is not deterministic"];
    let said = run(folder.path(), &["meet.scn", "--allow-run", "--no-progress", "--html=page.html"]);
    expect_all(&said, 110, &differs)?;
    let key = "meet/meet/later=0s/rep=1";
    expect_all(&run(folder.path(), &["replay", key, "meet.scn", "--allow-run"]), 100, &differs)?;
    let folder = in_folder(&failing("nondeterministic"));
    let said = run(folder.path(), &["meet.scn", "--allow-run", "--no-progress", "--html=page.html"]);
    expect_all(&said, 100, &["FAIL"])?;
    let said = run(folder.path(), &["replay", key, "meet.scn", "--allow-run"]);
    expect_all(&said, 0, &["not the same, as its controller says of itself"])
}

fn what_does_not_start_is_said_before_anything_runs() -> Outcome {
    for (kind, code, words) in [
        ("silent", "E1107", "it said nothing within 1 s"),
        ("chatter", "E1107", "it printed more than 100 lines"),
        ("ends_at_once", "E1107", "it wrote: no such weights: v3.onnx"),
        ("wrong_version", "E1107", "it speaks protocol 2"),
        ("narrow", "E1108", "the program takes 0 .. 20 m for `gap`, the file 1 .. 30 m"),
    ] {
        let folder = in_folder(&scenario(&format!("kind={kind}"), "starts within 1 s"));
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

fn nothing_runs_that_is_not_allowed() -> Outcome {
    let folder = in_folder(&scenario("touch=ran", ""));
    let (path, ran) = (folder.path(), folder.path().join("ran"));
    for arguments in [
        &["check", "meet.scn"][..],
        &["list", "meet.scn"],
        &["fmt", "--check", "meet.scn"],
        &["convert", "meet.scn"],
        &["models", "own", "meet.scn"],
        &["meet.scn", "--list"],
        &["allow", "meet.scn"],
        &["allow", "--revoke", "meet.scn"],
    ] {
        let said = run(path, arguments);
        expect(!ran.exists(), || format!("{arguments:?} ran it: {}", said.text))?;
    }
    for arguments in [
        &["meet.scn"][..],
        &["meet.scn", "--allow-run=other"],
        &["replay", "meet/meet/later=0s/rep=1", "meet.scn"],
        &["baseline", "save", "meet.scn"],
        &["compare", "meet.scn", "meet.scn"],
    ] {
        let said = run(path, arguments);
        expect_all(&said, 3, &["E1105", "`own` wants to run", "scenario-runner allow meet.scn"])?;
        expect(!ran.exists(), || format!("{arguments:?} ran it: {}", said.text))?;
    }
    expect_all(&run(path, &["meet.scn", "--allow-run=own"]), 0, &[])?;
    expect(ran.exists(), || "it did not run".to_string())
}

fn what_is_allowed_runs_until_it_is_another() -> Outcome {
    let folder = in_folder(&scenario("touch=ran", ""));
    let path = folder.path();
    expect_all(&run(path, &["allow", "meet.scn"]), 0, &["own (meet.scn:1) may run", "\"touch=ran\""])?;
    expect_all(&run(path, &["meet.scn"]), 0, &[])?;
    expect_all(&run(path, &["allow", "--list"]), 0, &["own ", "meet.scn"])?;
    // Limits and parameters need no new permission, what runs does.
    fs::write(path.join("meet.scn"), scenario("touch=ran", "answers within 5 s"))?;
    expect_all(&run(path, &["meet.scn"]), 0, &[])?;
    fs::write(path.join("meet.scn"), scenario("touch=other", ""))?;
    expect_all(&run(path, &["meet.scn"]), 3, &["E1105"])?;
    fs::write(path.join("meet.scn"), scenario("touch=ran", ""))?;
    // Of another place it is another file.
    fs::create_dir(path.join("copy"))?;
    fs::copy(path.join("meet.scn"), path.join("copy/meet.scn"))?;
    expect_all(&run(path, &["copy/meet.scn"]), 3, &["E1105"])?;
    // A project cannot allow itself.
    let said = runner(path, &["meet.scn"])
        .env("XDG_CONFIG_HOME", "config")
        .env("HOME", path.join("home"))
        .output()?;
    expect(said.status.code() == Some(3), || String::from_utf8_lossy(&said.stderr).into_owned())?;
    let said = runner(path, &["copy/meet.scn"]).env("SCENARIO_RUNNER_ALLOW_RUN", "other, own").output()?;
    expect(said.status.code() == Some(0), || String::from_utf8_lossy(&said.stderr).into_owned())?;
    expect_all(&run(path, &["allow", "--revoke", "meet.scn"]), 0, &["took back 1"])?;
    expect_all(&run(path, &["meet.scn"]), 3, &["E1105"])?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(path.join("meet.scn"), fs::Permissions::from_mode(0o646))?;
        expect_all(&run(path, &["allow", "meet.scn"]), 2, &["everybody may write"])?;
    }
    Ok(())
}

fn of_many_only_those_are_blamed_that_fail_alone() -> Outcome {
    let text = |words: &str| {
        scenario(words, "").replace("vary later in [0 s, 0.2 s]", "vary later in 0 s .. 3.1 s step 0.1 s")
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
    let text = scenario("kind=tuned at_once=16", "")
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
    let folder = in_folder(&scenario("kind=hang", "answers within 600 s"));
    let mut started = runner(folder.path(), &["meet.scn", "--allow-run", "--no-progress"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
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
        Ok("runner") => return cli::main(&standard()),
        _ => {}
    }
    let misbehaviours = MISBEHAVIOURS.iter().map(|(kind, fault, words)| {
        Trial::test(format!("a_misbehaviour_is_an_error_in_every_report::{kind}"), move || {
            a_misbehaviour_is_an_error_in_every_report(kind, fault, words)
        })
    });
    macro_rules! tests {
        ($($name:ident),* $(,)?) => { vec![$(Trial::test(stringify!($name), $name)),*] };
    }
    let mut trials = tests![
        every_wire_and_batch_gives_the_same_bits,
        everything_that_may_be_given_drives,
        two_vehicles_and_perception,
        what_floods_its_log_and_prints_first_runs,
        what_goes_by_the_clock_is_not_deterministic,
        what_does_not_start_is_said_before_anything_runs,
        nothing_runs_that_is_not_allowed,
        what_is_allowed_runs_until_it_is_another,
        of_many_only_those_are_blamed_that_fail_alone,
        what_always_fails_is_given_up,
        tune_finds_the_best_of_a_program,
    ];
    trials.extend(misbehaviours);
    #[cfg(feature = "wasm")]
    {
        use modules::*;
        trials.extend(tests![
            a_module_decides_as_its_native_twin,
            what_a_module_must_not_is_an_error_of_the_run,
            what_is_no_module_is_said_before_anything_runs,
        ]);
    }
    #[cfg(target_os = "linux")]
    trials.extend(tests![nothing_is_left_of_a_program_when_the_runner_is_killed]);
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}
