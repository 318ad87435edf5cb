//! `try`: what authors find out about their programs, and runs that are asked again from what was written down.
//!
//! The programs are this one, and so is the runner: `TESTS_UNDER_TEST` says which it is.

#[path = "under_test/child.rs"]
mod child;

use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode};

use libtest_mimic::{Arguments, Failed, Trial};
use models::standard;
use scenario_runner::cli;

const ROLE: &str = "TESTS_UNDER_TEST";

type Outcome = Result<(), Failed>;

fn declaration(words: &str, more: &str) -> String {
    let own = std::env::current_exe().unwrap();
    let words: String = words.split_whitespace().map(|word| format!(", \"{word}\"")).collect();
    format!(
        "controller own {{
  command \"{}\"{words}
  environment \"{ROLE}=child\"
  period 100 ms
  parameter gap = 5 m in 1 m .. 30 m
  {more}
}}
",
        own.display()
    )
}

fn meeting(words: &str, more: &str) -> String {
    declaration(words, more)
        + "
scenario meet {
  road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
  vehicle av { controller own; speed 30 km/h; start 40 m before crossing; sees { range: 60 m, position_noise: 0.1 m } }
  pedestrian walker { model scripted; start 2 m from kerb; appears at later }
  vary later in 0 s .. 2 s step 0.2 s
  repeat 2
  finish 20 m
  expect { max_deceleration <= 20 m/s^2 }
}
"
}

/// What was said on both streams, and the exit code.
struct Said {
    code: Option<i32>,
    text: String,
}

fn run(folder: &Path, arguments: &[&str]) -> Said {
    let output = Command::new(std::env::current_exe().unwrap())
        .args(arguments)
        .current_dir(folder)
        .env(ROLE, "runner")
        .env("NO_COLOR", "1")
        .env("XDG_CONFIG_HOME", folder.join("config"))
        .env_remove("SCENARIO_RUNNER_ALLOW_RUN")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    Said { code: output.status.code(), text }
}

fn with_file(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("own.scn"), text).unwrap();
    folder
}

fn tried(words: &str, more: &str) -> Said {
    run(with_file(&declaration(words, more)).path(), &["try", "own.scn", "--allow-run"])
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

/// Without what differs from machine to machine.
fn stable(text: &str) -> String {
    let own = std::env::current_exe().unwrap().display().to_string();
    let text = text.replace(&own, "PROGRAM");
    let times = regex_lite::Regex::new(r"[0-9.]+ (s|ms|µs)\b").unwrap();
    let speed = regex_lite::Regex::new(r"[0-9]+ a second").unwrap();
    let is_timed = |line: &str| line.contains("an answer takes");
    let lines = text.lines().map(|line| match is_timed(line) {
        true => speed.replace_all(&times.replace_all(line, "TIME"), "N a second").into_owned(),
        false => line.to_string(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn what_keeps_to_the_protocol_passes() -> Outcome {
    for words in ["", "at_once=7", "encoding=f64 at_once=64", "gives=speed_plan encoding=f64"] {
        let more = if words.contains("speed_plan") { "gives speed_plan" } else { "" };
        let said = tried(words, more);
        expect_all(&said, 0, &["nothing is wrong", "10 scenes, 3 settings", "5 in 1 .. 30 m"])?;
    }
    insta::assert_snapshot!(
        "a_program_that_keeps_to_the_protocol",
        stable(&tried("encoding=f64 at_once=64", "").text)
    );
    Ok(())
}

/// What a program does, and how it is found out.
const MISDEEDS: [(&str, &str); 11] = [
    // This test waits longest, so it begins first.
    ("kind=stays", "it does not end within 2 s after `bye`"),
    ("kind=counts", "once more in the same process"),
    ("kind=by_slot at_once=8", "in another process, 8 runs at once"),
    ("kind=clock", "at first, and once more"),
    ("kind=crash_wide", "nobody is there, with `gap: 30.0`: exited: it ended with exit code 1"),
    ("kind=crash_together at_once=8", "8 runs at once: exited"),
    ("kind=nan", "bad_value"),
    ("kind=garbage", "nobody is there: garbage: `what is this?` is no JSON"),
    ("kind=refuses", "nobody is there: at 0.5 s refused: lane is None"),
    ("kind=refuses_to_open", "it does not open the run: refused: no such weights"),
    ("kind=hang", "nobody is there: timeout: no answer within 0.3 s"),
];

fn what_does_not_is_found_out(words: &str, found: &str) -> Outcome {
    let said = tried(words, "answers within 0.3 s");
    expect_all(&said, 100, &[found, "  wrong: "])?;
    expect(!said.text.contains("nothing is wrong"), || said.text.clone())
}

fn findings_read_well() -> Outcome {
    let texts = ["kind=counts", "kind=crash_wide", "kind=by_slot at_once=8"].map(|words| {
        let said = tried(words, "");
        format!("{words} (exit code {:?})\n{}\n", said.code, stable(&said.text))
    });
    insta::assert_snapshot!("findings", texts.join("\n"));
    Ok(())
}

fn what_is_known_to_differ_is_no_finding() -> Outcome {
    expect_all(&tried("kind=clock", "nondeterministic"), 0, &["nothing is wrong"])
}

fn file_and_program_stand_side_by_side() -> Outcome {
    let said = tried("kind=narrow", "");
    expect_all(
        &said,
        3,
        &["E1108", "takes 0 .. 20 m for `gap`, the file 1 .. 30 m", "gap        5 in 1 .. 30 m  0 .. 20 m"],
    )?;
    expect_all(&tried("kind=knows_more", ""), 0, &["W1101", "`horizon`"])?;
    expect_all(&tried("kind=ends_at_once", ""), 3, &["E1107", "no such weights: v3.onnx"])
}

fn it_has_to_be_allowed() -> Outcome {
    let folder = with_file(&declaration("touch=ran", ""));
    let ran = folder.path().join("ran");
    expect_all(&run(folder.path(), &["try", "own.scn"]), 3, &["E1105", "scenario-runner allow own.scn"])?;
    expect_all(
        &run(folder.path(), &["try", "own.scn", "other", "--allow-run"]),
        2,
        &["no controller `other`, but own"],
    )?;
    expect(!ran.exists(), || "it ran".to_string())?;
    expect_all(&run(folder.path(), &["allow", "own.scn"]), 0, &[])?;
    expect_all(&run(folder.path(), &["try", "own.scn", "own"]), 0, &["nothing is wrong"])?;
    expect(ran.exists(), || "it did not run".to_string())
}

fn recorded(words: &str, more: &str, arguments: &[&str]) -> Result<(tempfile::TempDir, Vec<u8>), Failed> {
    let folder = with_file(&meeting(words, more));
    let mut all = vec!["own.scn", "--allow-run", "--no-progress", "--record-wire=wire.jsonl"];
    all.extend(arguments);
    let said = run(folder.path(), &all);
    let wire =
        fs::read(folder.path().join("wire.jsonl")).map_err(|error| format!("{error}: {}", said.text))?;
    Ok((folder, wire))
}

fn what_is_written_down_is_of_one_run_however_it_was_made() -> Outcome {
    for gives in ["acceleration", "pedals", "speed", "speed_plan"] {
        let more = format!("gives {gives}");
        let (_, known) = recorded(&format!("gives={gives}"), &more, &["-j1"])?;
        let others =
            [("encoding=f64 at_once=16", "-j3"), ("encoding=f64 at_once=1", "-j2"), ("at_once=16", "-j1")];
        // Each kind of answer has rows of its own; batches and threads do not depend on the kind.
        let others = if gives == "acceleration" { &others[..] } else { &others[..1] };
        for (words, threads) in others {
            let (folder, wire) = recorded(&format!("{words} gives={gives}"), &more, &[threads])?;
            expect(wire == known, || format!("{gives} {words} {threads}"))?;
            let said = run(folder.path(), &["try", "own.scn", "--wire=wire.jsonl", "--allow-run"]);
            expect_all(&said, 0, &["av of own/meet/later=0s/rep=1: ", "decisions, the same again"])?;
        }
    }
    let (_, known) = recorded("at_once=16", "", &["-j2", "later=1s"])?;
    let text = String::from_utf8(known)?;
    let lines: Vec<&str> = text.lines().collect();
    let first: serde_json::Value = serde_json::from_str(lines[0])?;
    let run = first["run"].as_str().unwrap_or_default();
    expect(run == "own/meet/later=1s/rep=1" && first["controller"] == "own", || lines[0].to_string())?;
    let steps = lines.iter().filter(|line| line.starts_with("{\"step\"")).count();
    let is_whole = lines.last().is_some_and(|line| line.starts_with("{\"close\"")) && steps > 30;
    expect(is_whole && lines.len() == 2 * steps + 4, || text.clone())
}

fn the_first_answer_that_differs_is_shown() -> Outcome {
    let (folder, _) = recorded("", "", &[])?;
    fs::write(folder.path().join("own.scn"), meeting("kind=harder", ""))?;
    let said = run(folder.path(), &["try", "own.scn", "--wire=wire.jsonl", "--allow-run"]);
    insta::assert_snapshot!("the_first_answer_that_differs", said.text);
    expect_all(&said, 100, &["-3.05", "-3.5"])?;
    for (kind, words) in [
        ("crash", "exited: it ended with exit code 1"),
        ("refuses", "refused: lane is None"),
        ("nan", "bad_value"),
    ] {
        fs::write(folder.path().join("own.scn"), meeting(&format!("kind={kind}"), ""))?;
        let said = run(folder.path(), &["try", "own.scn", "--wire=wire.jsonl", "--allow-run"]);
        expect_all(&said, 100, &["the first answer that differs", words])?;
    }
    Ok(())
}

fn a_run_that_failed_is_written_down_up_to_there() -> Outcome {
    for kind in ["crash", "refuses", "garbage"] {
        let (folder, wire) = recorded(&format!("kind={kind} at_once=4"), "", &["-j1", "later=1s"])?;
        let text = String::from_utf8(wire)?;
        let last = text.lines().last().unwrap_or_default();
        expect(last.starts_with("{\"fault\"") || last.starts_with("{\"error\""), || {
            format!("{kind}: {last}")
        })?;
        let again = ["try", "own.scn", "--wire=wire.jsonl", "--allow-run"];
        expect_all(&run(folder.path(), &again), 0, &["the same again"])?;
        // Mended, it answers where it did not.
        fs::write(folder.path().join("own.scn"), meeting("", ""))?;
        expect_all(&run(folder.path(), &again), 100, &["before: no answer", "now:    {\"acceleration\""])?;
    }
    Ok(())
}

fn what_is_no_record_is_refused() -> Outcome {
    let folder = with_file(&meeting("", ""));
    let path = folder.path();
    for (text, words) in [
        ("{\"answer\":[]}\n", "line 1 is no beginning"),
        ("hello\n", "line 1 is no JSON"),
        ("{\"wire\":2}\n", "of layout 2"),
        ("{\"wire\":1,\"controller\":\"own\"}\n", "before a run is opened"),
        ("{\"wire\":1,\"controller\":\"own\"}\n{\"open\":[{}]}\n{\"step\":[{}]}\n", "line 3 is no scene"),
        ("{\"wire\":1,\"controller\":\"other\"}\n{\"open\":[{}]}\n", "is of no run of own"),
        ("", "is of no run of own"),
    ] {
        fs::write(path.join("wire.jsonl"), text)?;
        expect_all(&run(path, &["try", "own.scn", "--wire=wire.jsonl", "--allow-run"]), 2, &[words])?;
    }
    let built_in = meeting("", "").replace("controller own;", "controller idm_aeb;");
    fs::write(path.join("own.scn"), built_in)?;
    let said = run(path, &["own.scn", "--allow-run", "--record-wire=wire.jsonl"]);
    expect_all(&said, 2, &["no program decides in any trial that is selected"])?;
    let said = run(path, &["own.scn", "--allow-run", "--record-wire=own.scn"]);
    expect(said.code == Some(2) && fs::read_to_string(path.join("own.scn"))?.contains("scenario"), || {
        said.text
    })
}

fn main() -> ExitCode {
    match std::env::var(ROLE).as_deref() {
        Ok("child") => child::run(),
        Ok("runner") => return cli::main(&standard()),
        _ => {}
    }
    macro_rules! tests {
        ($($name:ident),* $(,)?) => { vec![$(Trial::test(stringify!($name), $name)),*] };
    }
    let misdeeds = MISDEEDS.iter().map(|(words, found)| {
        Trial::test(format!("what_does_not_is_found_out::{words}"), move || {
            what_does_not_is_found_out(words, found)
        })
    });
    let mut trials: Vec<Trial> = misdeeds.collect();
    trials.extend(tests![
        what_keeps_to_the_protocol_passes,
        findings_read_well,
        what_is_known_to_differ_is_no_finding,
        file_and_program_stand_side_by_side,
        it_has_to_be_allowed,
        what_is_written_down_is_of_one_run_however_it_was_made,
        the_first_answer_that_differs_is_shown,
        a_run_that_failed_is_written_down_up_to_there,
        what_is_no_record_is_refused,
    ]);
    let mut arguments = Arguments::from_args();
    // The tests wait for programs most of the time.
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    arguments.test_threads.get_or_insert(2 * cores);
    libtest_mimic::run(&arguments, trials).exit_code()
}
