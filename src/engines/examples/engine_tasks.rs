//! Has the tasks of a file done on an engine, and prints a line for each event: what the judges of `tests/engines` run.
//!
//! `engine_tasks ENGINE FOLDER TASKS [SLURM_OPTION…]`, where every line of TASKS is a JSON list of words.

#![allow(clippy::disallowed_methods, clippy::print_stdout, reason = "it speaks to a script")]

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use scenario_runner_engines::{EndedTask, EngineError, EngineEvent, EngineOptions, TaskEnd, run_slices};

fn main() -> ExitCode {
    let stopped = Arc::new(AtomicBool::new(false));
    let wish = Arc::clone(&stopped);
    ctrlc::set_handler(move || wish.store(true, Ordering::Relaxed)).expect("signals are heard");
    match run(&|| stopped.load(Ordering::Relaxed)) {
        Ok(ended) => {
            let failed = ended.iter().filter(|task| task.end != TaskEnd::Exited(0)).count();
            println!("done {} failed {failed}", ended.len());
            ExitCode::SUCCESS
        }
        Err(EngineError::Stopped) => {
            println!("stopped");
            ExitCode::from(105)
        }
        Err(error) => {
            println!("error {error}");
            ExitCode::from(2)
        }
    }
}

fn run(stop: &dyn Fn() -> bool) -> Result<Vec<EndedTask>, EngineError> {
    let mut words = std::env::args().skip(1);
    let mut word = || words.next().expect("ENGINE FOLDER TASKS");
    let engine = word().parse()?;
    let mut options = EngineOptions::new(word());
    let text = std::fs::read_to_string(word()).expect("the tasks are read");
    let slices = text.lines().map(|line| serde_json::from_str(line).expect("a list of words")).collect();
    options.slurm_options = words.collect();
    if let Ok(resources) = std::env::var("TASK_RESOURCES") {
        options.resources = serde_json::from_str(&resources).expect("an object");
    }
    if let Ok(settle) = std::env::var("ENGINE_SETTLE") {
        options.settle = Duration::from_secs(settle.parse().expect("seconds"));
    }
    if let Some(python) = std::env::var_os("SCENARIO_RUNNER_PYTHON") {
        options.python = python;
    }
    run_slices(engine, slices, options, stop, &mut |event| match event {
        EngineEvent::Ready(what) => println!("ready {what}"),
        EngineEvent::Notice(what) => println!("notice {what}"),
        EngineEvent::Standing { waiting, running } => println!("standing {waiting} {running}"),
        EngineEvent::Ended(EndedTask { id, end: TaskEnd::Exited(code), node, seconds }) => {
            println!("ended {id} {code} {node} {seconds:.3}");
        }
        EngineEvent::Ended(EndedTask { id, end: TaskEnd::Lost(why), .. }) => println!("lost {id} {why}"),
    })
}
