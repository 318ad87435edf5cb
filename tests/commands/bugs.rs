//! Panics, as a user meets them: in a run they are an error of its trial, elsewhere a bug with an exit code of its own.

use std::path::Path;
use std::process::Command;

use files::Disk;
use models::standard;
use results::{Event, Reporter, Requests, TrialState, Unheard};
use runner::plan::plan;
use runner::project::PlannedSuite;
use runner::run::{FreeFlows, Threads, note_places, run_case};
use runner::session::{Orders, Runner, units};
use scenario_runner::cli::{Exit, guarded};
use sim::{Observer, Step};

/// Set for a process that is to panic, to what in.
const WHERE: &str = "SCENARIO_RUNNER_TEST_PANIC";

fn prepared() -> [PlannedSuite; 1] {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("suites/zebra_unsafe.suite");
    let suite = lang::load(&path, &standard(), &Disk)
        .unwrap_or_else(|_| panic!("{} is a suite", path.display()))
        .suite;
    let plan = plan(&suite).unwrap();
    [PlannedSuite { file: "zebra_unsafe.suite".into(), suite, plan, recorded: Vec::new() }]
}

/// Panics when the first unit has finished.
struct Startled;

impl Reporter for Startled {
    fn tell(&mut self, event: &Event) {
        assert!(!matches!(event, Event::Finished { .. }), "told too much");
    }
}

fn run_all(reporter: &mut dyn Reporter, session: &Runner) -> Vec<(String, TrialState)> {
    let units = units(session.suites());
    let chosen = vec![true; units.len()];
    let orders = Orders {
        chosen: &chosen,
        first: &[],
        max_failures: None,
        every_trial: true,
        memory: None,
        lenient: false,
        pilot: false,
    };
    let mut reports = session.run(&units, &orders, reporter);
    reports.remove(0).trials.into_iter().map(|one| (one.trial.key.clone(), one.state)).collect()
}

struct Panicking;

impl Observer for Panicking {
    fn observe(&mut self, _: &Step) {
        panic!("this step is one too many");
    }
}

/// What the process does that is to panic.
fn panicking(place: &str) -> Exit {
    let suites = prepared();
    match place {
        "nowhere" => return Exit::Regressed,
        "outside" => panic!("nobody expected this"),
        "run" => {
            let case = &suites[0].plan.trial(0).cases.first();
            drop(run_case(case, &Requests::defaults(&standard()), &FreeFlows::default(), &mut Panicking));
        }
        "reporter" => {
            let threads = Threads::new(2);
            drop(run_all(&mut Startled, &Runner::new(&suites, &threads, &standard())))
        }
        other => panic!("there is no place called {other}"),
    }
    Exit::Success
}

/// Not a test by itself: what the others start as a process of its own.
#[test]
fn child() {
    let Ok(place) = std::env::var(WHERE) else { return };
    note_places();
    std::process::exit(guarded(|| panicking(&place)) as i32)
}

/// Exit code and standard error of a process that panics there.
fn process(place: &str) -> (Option<i32>, String) {
    let this = std::env::current_exe().unwrap();
    let output = Command::new(this)
        .args(["--exact", "bugs::child", "--nocapture"])
        .env(WHERE, place)
        .env_remove("RUST_BACKTRACE")
        .output()
        .unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_panic_outside_of_runs_is_a_bug_with_a_code_of_its_own() {
    assert_eq!(process("nowhere").0, Some(104));
    let (code, text) = process("outside");
    assert_eq!(code, Some(120), "{text}");
    let version = env!("CARGO_PKG_VERSION");
    assert!(
        text.contains(&format!("error: scenario-runner {version} panicked at tests/commands/bugs.rs:")),
        "{text}"
    );
    assert!(text.contains("nobody expected this; this is a bug of scenario-runner"), "{text}");
    // The program's own words only, not those of the language's runtime.
    assert!(!text.contains("RUST_BACKTRACE"), "{text}");
}

#[test]
fn it_names_the_run_in_which_it_happened() {
    let (code, text) = process("run");
    assert_eq!(code, Some(120), "{text}");
    let key = &prepared()[0].plan.trial(0).cases.first().key;
    assert!(text.contains(&format!("error: {key}: scenario-runner ")), "{text}");
    assert!(text.contains("this step is one too many"), "{text}");
}

#[test]
fn a_panic_while_others_run_ends_the_program_instead_of_hanging() {
    let (code, text) = process("reporter");
    assert_eq!(code, Some(120), "{text}");
    assert!(text.contains("told too much"), "{text}");
}

#[test]
fn a_panic_in_a_trial_is_an_error_of_it_and_the_others_finish() {
    let suites = prepared();
    let broken = &suites[0].plan.trial(0).key.clone();
    let watch = |case: &scenario::Case, _: &_| {
        assert!(!case.key.starts_with(broken.as_str()), "watched too closely");
    };
    let threads = Threads::new(2);
    let session = Runner::new(&suites, &threads, &standard()).watched_by(&watch);
    for (key, state) in run_all(&mut Unheard, &session) {
        match state {
            TrialState::Errored(error) if key == *broken => {
                let message = error.message;
                assert!(message.starts_with(&format!("{key}: scenario-runner ")), "{message}");
                assert!(message.contains("watched too closely"), "{message}");
            }
            TrialState::Judged(_) if key != *broken => {}
            other => panic!("{key}: {other:?}"),
        }
    }
}
