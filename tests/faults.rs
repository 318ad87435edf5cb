//! A controller that cannot decide: its run is an error that names run, vehicle and moment and says how to see it again, in
//! every report and from every command, never a pass and never a failure.
//!
//! The program under test is this one: asked for by [`PROGRAM`], it is the command line with a controller more.

use std::fs;
use std::path::Path;
use std::process::{Command as Process, ExitCode};

use libtest_mimic::{Arguments, Failed, Trial};
use models::standard;
use scenario::registry::Registry;
use scenario::{Chance, CommandKind, ControllerModel, Declaration, Dimension, Parameter};
use scenario_runner::cli;
use sim::{Command, Controller, ControllerError, Observation, Schedule};

const PROGRAM: &str = "TESTS_FAULTS_PROGRAM";

/// Keeps its speed until it cannot decide any more.
struct Frail {
    /// s
    from: f64,
    /// Whether that is in this run.
    here: bool,
}

impl Controller for Frail {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.1)
    }

    fn settling_time(&self) -> f64 {
        1.0
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        if self.here && seen.time >= self.from - 1e-9 {
            return Err(ControllerError::with_hint("lane is None", "give it a map"));
        }
        Ok(Command::Acceleration(0.0))
    }
}

fn registry() -> Registry {
    let time = "When it cannot decide any more.";
    let declaration = Declaration::new("frail", "Cannot decide from some time on.")
        .source("a test")
        .number("from", Dimension::TIME, 1000.0, (-10.0, 1000.0), time)
        .with(Parameter::flag(
            "alone",
            false,
            "Whether that is where nobody is, or where somebody is.",
            "a test",
        ));
    let frail = ControllerModel::new(declaration, CommandKind::Acceleration, |context| {
        let (from, alone) = (context.settings.number("from"), context.settings.flag("alone"));
        Ok(Box::new(Frail { from, here: context.world.pedestrians.is_empty() == alone }))
    });
    standard().with_controller(frail.chance(Chance::Never)).expect("a controller more")
}

/// A scenario in which the controller has these settings, and blocks beside it.
fn scenario(settings: &str, blocks: &str) -> String {
    format!(
        "scenario meet {{
  road {{
    lane_width 4 m
    speed_limit 30 km/h
    crossing zebra
  }}
  vehicle av {{
    controller frail {{ {settings} }}
    speed 30 km/h
    start 50 m before crossing
  }}
  pedestrian walker {{
    model scripted
    start 2 m from kerb
    appears at delay
  }}
  vary delay in [0 s, 0.2 s]
  expect {{ max_deceleration <= 9 m/s^2 }}
}}
{blocks}"
    )
}

/// What the program said, on both streams, and its exit code.
struct Said {
    code: Option<i32>,
    text: String,
}

fn program(folder: &Path, arguments: &[&str]) -> Result<Said, Failed> {
    let output = Process::new(std::env::current_exe()?)
        .args(arguments)
        .current_dir(folder)
        .env(PROGRAM, "1")
        .env("NO_COLOR", "1")
        .output()?;
    let text = [output.stdout, output.stderr].concat();
    Ok(Said { code: output.status.code(), text: String::from_utf8(text)? })
}

fn expect(holds: bool, otherwise: impl FnOnce() -> String) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(otherwise().into()) }
}

fn expect_all(text: &str, words: &[&str]) -> Result<(), Failed> {
    let missing: Vec<_> = words.iter().filter(|word| !text.contains(**word)).collect();
    expect(missing.is_empty(), || format!("{missing:?} missing in\n{text}"))
}

fn in_folder(text: &str, test: impl FnOnce(&Path) -> Result<(), Failed>) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    fs::write(folder.path().join("meet.scn"), text)?;
    test(folder.path())
}

const KEY: &str = "meet/meet/delay=0s/rep=1";
const WHAT: &str = "`av` cannot decide at 1 s: lane is None";
const REPLAY: &str = "scenario-runner replay 'meet/meet/delay=0s/rep=1' meet.scn --seed 1";

fn every_report_says_it() -> Result<(), Failed> {
    in_folder(&scenario("from: 1 s", ""), |folder| {
        let files = ["junit", "json", "tap", "html"];
        let options: Vec<_> = files.iter().map(|kind| format!("--{kind}=report.{kind}")).collect();
        let mut arguments = vec!["meet.scn", "--no-progress", "--github"];
        arguments.extend(options.iter().map(String::as_str));
        let said = program(folder, &arguments)?;
        expect(said.code == Some(100), || format!("{:?}\n{}", said.code, said.text))?;
        let words = [KEY, WHAT, "give it a map", REPLAY];
        expect_all(&said.text, &words)?;
        // What users of GitHub see is a line of commands.
        let annotation = said.text.lines().find(|line| line.starts_with("::error ")).unwrap_or_default();
        expect_all(annotation, &words)?;
        for kind in files {
            let report = fs::read_to_string(folder.join(format!("report.{kind}")))?;
            let report = [("&#39;", "'"), ("&apos;", "'"), ("&#x27;", "'"), ("&#x2f;", "/")]
                .iter()
                .fold(report, |text, (escaped, letter)| text.replace(escaped, letter));
            expect_all(&report, &[KEY, WHAT, "give it a map", REPLAY]).map_err(|failed| {
                Failed::from(format!("{kind}: {}", failed.message().unwrap_or_default()))
            })?;
        }
        let junit = fs::read_to_string(folder.join("report.junit"))?;
        expect(junit.contains("<error") && !junit.contains("<failure"), || junit.clone())?;
        expect_all(&junit, &[r#"tests="2" skipped="0" failures="0" errors="2""#])?;
        // Made later of the results alone, it is the same.
        let later = program(folder, &["report", "report.json", "--junit=later.junit"])?;
        expect(later.code == Some(100), || later.text.clone())?;
        expect(fs::read_to_string(folder.join("later.junit"))? == junit, || "another report".to_string())
    })
}

fn replay_says_it() -> Result<(), Failed> {
    in_folder(&scenario("from: 1 s", ""), |folder| {
        let said = program(folder, &["replay", KEY, "meet.scn", "--seed", "1"])?;
        expect(said.code == Some(100), || format!("{:?}\n{}", said.code, said.text))?;
        expect_all(&said.text, &[KEY, WHAT, "help: give it a map"])
    })
}

/// What the terminal says of a controller with these settings.
fn says(settings: &str, words: &[&str]) -> Result<(), Failed> {
    in_folder(&scenario(settings, ""), |folder| {
        let said = program(folder, &["meet.scn", "--no-progress"])?;
        expect(said.code == Some(100), || format!("{:?}\n{}", said.code, said.text))?;
        expect_all(&said.text, words)?;
        expect_all(&said.text, &["2 could not be run"])
    })
}

fn settling() -> Result<(), Failed> {
    says("from: -0.5 s", &[KEY, "`av` cannot decide 0.5 s before the start: lane is None", REPLAY])
}

fn free_flow() -> Result<(), Failed> {
    let what = "`av` cannot decide in free flow, without pedestrians, at 2 s: lane is None";
    says("from: 2 s, alone: true", &[KEY, what, REPLAY])
}

fn one_that_can_decide_passes() -> Result<(), Failed> {
    in_folder(&scenario("", ""), |folder| {
        let said = program(folder, &["meet.scn", "--no-progress"])?;
        expect(said.code == Some(0), || said.text)
    })
}

/// Blocks end as errors, with their exit code, and have no result.
fn blocks() -> Result<(), Failed> {
    let blocks = "
search worst {
  in meet
  minimise max_deceleration
  over av.controller.from in 1 s .. 2 s
  budget 4 evaluations, 2 random first
}

tune best {
  on meet
  over av.controller.from in 1 s .. 2 s
  minimise mean(max_deceleration)
  budget 4 evaluations, 2 random first
}

evaluate both {
  on meet
  with default, { av.controller.from: 1 s } as early
}
";
    in_folder(&scenario("", blocks), |folder| {
        let said =
            program(folder, &["meet.scn", "--no-progress", "--junit=junit.xml", "--json=results.json"])?;
        expect(said.code == Some(100), || format!("{:?}\n{}", said.code, said.text))?;
        expect_all(&said.text, &["3 could not be run", "2 passed"])?;
        let junit = fs::read_to_string(folder.join("junit.xml"))?;
        expect(junit.matches("<error").count() == 3 && !junit.contains("<failure"), || junit.clone())?;
        for text in [&said.text, &junit, &fs::read_to_string(folder.join("results.json"))?] {
            expect_all(text, &["meet/worst/evaluation=", "meet/best/case=", "meet/both/early/case="])?;
            expect_all(text, &["`av` cannot decide at 1", "lane is None", "give it a map"])?;
        }
        Ok(())
    })
}

/// No other command takes what there is for all there is.
fn other_commands() -> Result<(), Failed> {
    in_folder(&scenario("from: 1 s", ""), |folder| {
        for arguments in
            [&["shrink", KEY, "meet.scn"][..], &["baseline", "save", "meet.scn", "--out", "meet.baseline"]]
        {
            let said = program(folder, arguments)?;
            expect(!matches!(said.code, Some(0) | None), || said.text.clone())?;
            expect_all(&said.text, &[KEY, WHAT])?;
        }
        expect(!folder.join("meet.baseline").exists(), || "a baseline of half the runs".to_string())?;
        // It is no mistake of the file.
        let said = program(folder, &["check", "meet.scn"])?;
        expect(said.code == Some(0), || said.text)
    })
}

fn main() -> ExitCode {
    if std::env::var_os(PROGRAM).is_some() {
        return cli::main(&registry());
    }
    let tests = vec![
        Trial::test("every report says it", every_report_says_it),
        Trial::test("replay says it", replay_says_it),
        Trial::test("while settling", settling),
        Trial::test("only in free flow", free_flow),
        Trial::test("one that can decide passes", one_that_can_decide_passes),
        Trial::test("blocks end as errors", blocks),
        Trial::test("other commands fail", other_commands),
    ];
    libtest_mimic::run(&Arguments::from_args(), tests).exit_code()
}
