//! Programs of an engine on this machine, in groups of their own: Ctrl-C at a terminal is not theirs to hear.

use std::io::{self, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use super::error::EngineError;

/// What the clients of an engine take at most; they have limits of their own that are shorter.
const LONGEST: Duration = Duration::from_secs(120);

/// What one of them says is read as far, bytes.
const MOST: u64 = 64 << 20;

/// What a command said.
#[derive(Debug)]
pub struct ClientOutput {
    pub is_success: bool,
    pub stdout: String,
    pub stderr: String,
}

/// Ends the group of a child that nobody has waited for, since its number may be another's then; how that ended.
pub fn end_group(child: &mut Child) -> Option<ExitStatus> {
    #[cfg(unix)]
    if let Some(leader) = i32::try_from(child.id()).ok().and_then(rustix::process::Pid::from_raw) {
        // There may be nobody left in it.
        let _ = rustix::process::kill_process_group(leader, rustix::process::Signal::KILL);
    }
    let _ = child.kill();
    child.wait().ok()
}

/// Whether it has ended; it keeps its number, which is that of its group.
#[cfg(unix)]
pub fn has_ended(child: &mut Child) -> bool {
    use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
    let Some(id) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) else { return true };
    let look = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    !matches!(waitid(WaitId::Pid(id), look), Ok(None))
}

#[cfg(not(unix))]
pub fn has_ended(child: &mut Child) -> bool {
    !matches!(child.try_wait(), Ok(None))
}

/// Starts one in a group of its own, whose standard streams are heard; `install` says what to do where there is none.
pub fn start(command: &mut Command, install: &str) -> Result<Child, EngineError> {
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    command.spawn().map_err(|error| {
        let name = command.get_program().to_string_lossy();
        match error.kind() {
            io::ErrorKind::NotFound => EngineError::Missing(format!("there is no `{name}` here: {install}")),
            _ => EngineError::Failed(format!("`{name}`: {error}")),
        }
    })
}

/// Runs a client to its end.
///
/// # Errors
/// [`EngineError::Missing`] with `install` if there is no such program; [`EngineError::Failed`] if it does not end.
pub fn ask(command: &mut Command, install: &str) -> Result<ClientOutput, EngineError> {
    let name = command.get_program().to_string_lossy().into_owned();
    let failed = |error: io::Error| EngineError::Failed(format!("`{name}`: {error}"));
    let mut child = start(command.stdin(Stdio::null()), install)?;
    let stdout = read(child.stdout.take());
    let stderr = read(child.stderr.take());
    let until = Instant::now() + LONGEST;
    let status = loop {
        match child.try_wait().map_err(failed)? {
            Some(status) => break status,
            None if Instant::now() >= until => {
                end_group(&mut child);
                return Err(EngineError::Failed(format!(
                    "`{name}` said nothing within {} s",
                    LONGEST.as_secs()
                )));
            }
            None => thread::sleep(Duration::from_millis(5)),
        }
    };
    let said = |reading: thread::JoinHandle<String>| reading.join().unwrap_or_default();
    Ok(ClientOutput { is_success: status.success(), stdout: said(stdout), stderr: said(stderr) })
}

fn read(stream: Option<impl Read + Send + 'static>) -> thread::JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        // What was read before it failed is all there is.
        let _ = stream.map(|stream| stream.take(MOST).read_to_end(&mut bytes));
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_installed_is_named_with_what_to_install() {
        let error = ask(&mut Command::new("no-such-client"), "install the client").unwrap_err();
        assert_eq!(error.to_string(), "there is no `no-such-client` here: install the client");
    }

    #[test]
    fn both_streams_and_the_end_are_told() {
        let said = ask(Command::new("sh").args(["-c", "echo a; echo b >&2; exit 3"]), "").unwrap();
        assert_eq!((said.stdout.as_str(), said.stderr.as_str(), said.is_success), ("a\n", "b\n", false));
    }
}
