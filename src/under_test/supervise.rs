//! A small process between the runner and a program, which ends the program and all of its group if the runner is gone,
//! however it went.

use std::env;
use std::process::{Command, ExitCode};

/// The first word of the command line of such a process.
pub const SUPERVISE: &str = "supervise";

/// Supervises a program if this process was started for that (see [`ProcessPool::supervised_by`](super::ProcessPool::supervised_by)), and then
/// gives how that ended. `main` calls it before it does anything else.
pub fn supervise_if_asked() -> Option<ExitCode> {
    let mut words = env::args_os().skip(1);
    if words.next()? != SUPERVISE {
        return None;
    }
    let words: Vec<String> = words.map(|word| word.into_string().ok()).collect::<Option<_>>()?;
    let (runner, words) = words.split_first()?;
    let ahead = words.iter().position(|word| word == "--")?;
    let set = words[..ahead].iter().map(|word| word.strip_prefix("--set=").map(str::to_string));
    Some(supervise(runner.parse().ok()?, &set.collect::<Option<Vec<_>>>()?, &words[ahead + 1..]))
}

/// Starts the command, with these `NAME=VALUE` in its environment, and gives back how it ended. `runner` is the number of the process that started this one: once that is
/// gone, the whole group is ended, this process included.
#[cfg(unix)]
fn supervise(runner: u32, environment: &[String], command: &[String]) -> ExitCode {
    use std::os::unix::process::{ExitStatusExt, parent_id};
    use std::thread;
    use std::time::Duration;

    use rustix::process::{Resource, Rlimit, Signal, getpid, kill_process_group, setrlimit};

    let Some((program, arguments)) = command.split_first() else { return ExitCode::from(CANNOT_START) };
    let look = move || {
        while parent_id() == runner {
            thread::sleep(Duration::from_millis(100));
        }
        // It leads its group.
        let _ = kill_process_group(getpid(), Signal::KILL);
    };
    // A crash is told of by its signal; what a program had in memory is not to fill the disk. All other limits are the runner's.
    let _ = setrlimit(Resource::Core, Rlimit { current: Some(0), maximum: Some(0) });
    if thread::Builder::new().spawn(look).is_err() {
        return ExitCode::from(CANNOT_START);
    }
    let status = Command::new(program)
        .args(arguments)
        .envs(pairs(environment))
        .spawn()
        .and_then(|mut child| child.wait());
    match status {
        Ok(status) => match (status.code(), status.signal()) {
            (Some(code), _) => ExitCode::from(code.to_le_bytes()[0]),
            (None, Some(signal)) => ExitCode::from(BY_SIGNAL.wrapping_add(signal.to_le_bytes()[0])),
            (None, None) => ExitCode::from(CANNOT_START),
        },
        Err(_) => ExitCode::from(CANNOT_START),
    }
}

/// Starts the command and gives back how it ended.
#[cfg(not(unix))]
fn supervise(_runner: u32, environment: &[String], command: &[String]) -> ExitCode {
    let Some((program, arguments)) = command.split_first() else { return ExitCode::from(CANNOT_START) };
    let status = Command::new(program)
        .args(arguments)
        .envs(pairs(environment))
        .spawn()
        .and_then(|mut child| child.wait());
    let code = status.ok().and_then(|status| status.code());
    code.map_or(ExitCode::from(CANNOT_START), |code| ExitCode::from(code.to_le_bytes()[0]))
}

fn pairs(environment: &[String]) -> impl Iterator<Item = (&str, &str)> {
    environment.iter().filter_map(|pair| pair.split_once('='))
}

/// As shells say it.
const CANNOT_START: u8 = 127;

/// A program that a signal ended has this code and the signal's number, as shells say it.
pub const BY_SIGNAL: u8 = 128;
