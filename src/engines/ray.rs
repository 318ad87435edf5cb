//! Ray: a child process in Python, `python -m scenario_runner_av.ray`, is given tasks as lines and tells of them as lines.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::client::{end_group, has_ended, start};
use super::error::EngineError;
use super::task::{EndedTask, Engine, EngineEvent, Ledger, Task, TaskEnd};

/// The version that is spoken with, and that the extra `ray` of the package installs.
pub const RAY_VERSION: &str = "2.60.0";

/// Raised when lines mean something else.
const PROTOCOL: u32 = 1;

/// How soon a wish to stop is heard.
const TICK: Duration = Duration::from_millis(100);

/// In which the bridge ends its tasks and what it has started of Ray.
const TIME_TO_EXIT: Duration = Duration::from_secs(30);

/// In which what it has written to its standard error before it ended is read.
const TIME_TO_TELL: Duration = Duration::from_secs(1);

/// A line of the bridge has at most so many bytes.
const LONGEST_LINE: u64 = 1 << 20;

/// Lines of its standard error that an error quotes, and how many bytes of it are kept.
const LAST_LINES: usize = 12;
const TAIL: usize = 16 << 10;

/// The cluster that `RAY_ADDRESS` names, or one of its own on this machine alone.
#[derive(Debug, Clone)]
pub struct Ray {
    /// The Python that has Ray and `scenario_runner_av`.
    pub python: OsString,
}

/// A task as the bridge is told of it.
#[derive(Serialize)]
struct AskedTask<'a> {
    id: &'a str,
    argv: &'a [String],
    out: String,
    cpus: u32,
    resources: &'a BTreeMap<String, f64>,
}

/// A line of the bridge.
#[derive(Debug, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
enum BridgeLine {
    Ready { ready: String, ray: String, protocol: u32 },
    Missing { missing: String },
    Wrong { wrong: String },
    Notice { notice: String },
    Ended { id: String, rc: i32, node: String, s: f64 },
    Lost { id: String, lost: String },
}

impl Engine for Ray {
    fn run(
        &self,
        tasks: &[Task],
        stop: &dyn Fn() -> bool,
        told: &mut dyn FnMut(EngineEvent),
    ) -> Result<Vec<EndedTask>, EngineError> {
        let mut ledger = Ledger::new(tasks)?;
        let mut bridge = Bridge::start(&self.python, tasks)?;
        let heard = bridge.until_all_ended(&mut ledger, stop, told);
        drop(bridge);
        heard?;
        ledger.finish()
    }
}

/// The child process.
struct Bridge {
    /// Nothing once somebody has waited for it.
    child: Option<Child>,
    lines: Receiver<io::Result<Vec<u8>>>,
    /// While it is held, the bridge's standard input stays open: it takes its end for that of its driver.
    asking: Option<Sender<()>>,
    tail: Arc<Mutex<Vec<u8>>>,
    keeping: Option<JoinHandle<()>>,
    python: String,
}

impl Bridge {
    fn start(python: &OsString, tasks: &[Task]) -> Result<Self, EngineError> {
        let name = python.to_string_lossy().into_owned();
        let mut asked = Vec::new();
        for task in tasks {
            let out = task.out.to_string_lossy().into_owned();
            let Task { id, argv, cpus, resources, .. } = task;
            let line = serde_json::to_string(&AskedTask { id, argv, out, cpus: *cpus, resources })
                .map_err(|error| EngineError::Refused(format!("the task `{id}`: {error}")))?;
            asked.extend_from_slice(line.as_bytes());
            asked.push(b'\n');
        }
        let mut command = Command::new(python);
        command.args(["-u", "-m", "scenario_runner_av.ray"]);
        let mut child = start(command.stdin(Stdio::piped()), INSTALL)?;
        let (asking, until) = mpsc::channel();
        let (telling, lines) = mpsc::channel();
        let tail = Arc::default();
        if let Some(stdin) = child.stdin.take() {
            thread::spawn(move || ask(stdin, &asked, &until));
        }
        if let Some(stdout) = child.stdout.take() {
            thread::spawn(move || hear(stdout, &telling));
        }
        let keeping = child.stderr.take().map(|stderr| {
            let tail = Arc::clone(&tail);
            thread::spawn(move || keep(stderr, &tail))
        });
        Ok(Self { child: Some(child), lines, asking: Some(asking), tail, keeping, python: name })
    }

    fn until_all_ended(
        &mut self,
        ledger: &mut Ledger,
        stop: &dyn Fn() -> bool,
        told: &mut dyn FnMut(EngineEvent),
    ) -> Result<(), EngineError> {
        let mut is_ready = false;
        while !(is_ready && ledger.is_complete()) {
            if stop() {
                return Err(EngineError::Stopped);
            }
            let line = match self.lines.recv_timeout(TICK) {
                Ok(line) => line.map_err(|error| EngineError::Failed(format!("its lines: {error}")))?,
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => return Err(self.gone()),
            };
            let event = match read(&line)? {
                BridgeLine::Ready { ready, ray, protocol } => {
                    check(&ray, protocol)?;
                    is_ready = true;
                    EngineEvent::Ready(ready)
                }
                BridgeLine::Missing { missing } => return Err(EngineError::Missing(missing)),
                BridgeLine::Wrong { wrong } => return Err(EngineError::Failed(wrong)),
                BridgeLine::Notice { notice } => EngineEvent::Notice(notice),
                BridgeLine::Ended { id, rc, node, s } => {
                    let ended = EndedTask { id, end: TaskEnd::Exited(rc), node, seconds: s };
                    EngineEvent::Ended(ledger.note(ended)?.clone())
                }
                BridgeLine::Lost { id, lost } => {
                    let ended = EndedTask { id, end: TaskEnd::Lost(lost), node: String::new(), seconds: 0.0 };
                    EngineEvent::Ended(ledger.note(ended)?.clone())
                }
            };
            told(event);
        }
        Ok(())
    }

    /// Why it ended though it had more to tell.
    fn gone(&mut self) -> EngineError {
        let status = self.end();
        // What it has started may hold its standard error.
        let until = Instant::now() + TIME_TO_TELL;
        while self.keeping.as_ref().is_some_and(|keeping| !keeping.is_finished()) && Instant::now() < until {
            thread::sleep(Duration::from_millis(10));
        }
        let tail = self.tail.lock().unwrap_or_else(PoisonError::into_inner);
        let text = String::from_utf8_lossy(&tail).into_owned();
        if text.contains("No module named scenario_runner_av")
            || text.contains("No module named 'scenario_runner_av'")
        {
            return EngineError::Missing(format!(
                "`{}` has no module scenario_runner_av: {INSTALL}",
                self.python
            ));
        }
        let how = status.map_or("is gone".to_string(), |status| format!("ended: {status}"));
        let lines: Vec<&str> = text.lines().collect();
        let last = lines[lines.len().saturating_sub(LAST_LINES)..].join("\n");
        EngineError::Failed(format!("the bridge to Ray {how}\n{last}"))
    }

    /// Lets it end its tasks and what it has started, and ends it if it stays: Ray ends the tasks of a driver that is gone.
    fn end(&mut self) -> Option<ExitStatus> {
        self.asking = None;
        let mut child = self.child.take()?;
        let until = Instant::now() + TIME_TO_EXIT;
        while !has_ended(&mut child) && Instant::now() < until {
            thread::sleep(Duration::from_millis(10));
        }
        end_group(&mut child)
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.end();
    }
}

const INSTALL: &str =
    "run `pip install 'scenario-runner-av[ray]'` for it, or name another Python by SCENARIO_RUNNER_PYTHON";

fn check(ray: &str, protocol: u32) -> Result<(), EngineError> {
    if protocol != PROTOCOL {
        return Err(EngineError::Missing(format!(
            "the Python package scenario-runner-av speaks protocol {protocol}, and this program {PROTOCOL}: install the version that belongs to it"
        )));
    }
    if ray != RAY_VERSION {
        return Err(EngineError::Missing(format!(
            "Ray {ray} is installed, and {RAY_VERSION} is needed: {INSTALL}"
        )));
    }
    Ok(())
}

fn read(line: &[u8]) -> Result<BridgeLine, EngineError> {
    serde_json::from_slice(line).map_err(|_| {
        let text = String::from_utf8_lossy(&line[..line.len().min(200)]).into_owned();
        EngineError::Failed(format!("the bridge to Ray said what cannot be read: {text:?}"))
    })
}

/// Says what is asked, and keeps the stream open until nobody asks any more.
fn ask(mut stdin: ChildStdin, asked: &[u8], until: &Receiver<()>) {
    // One that is gone is noticed by whoever hears it.
    let _ = stdin.write_all(asked).and_then(|()| stdin.flush());
    let _ = until.recv();
}

fn hear(stdout: ChildStdout, telling: &Sender<io::Result<Vec<u8>>>) {
    let mut stdout = BufReader::new(stdout);
    loop {
        let mut line = Vec::new();
        let read = (&mut stdout).take(LONGEST_LINE).read_until(b'\n', &mut line);
        let said = match read {
            Ok(0) => return,
            // What was cut off is not taken for a line.
            Ok(_) if line.last() != Some(&b'\n') => Err(io::ErrorKind::InvalidData.into()),
            Ok(_) => Ok(line),
            Err(error) => Err(error),
        };
        let is_last = said.is_err();
        if telling.send(said).is_err() || is_last {
            return;
        }
    }
}

fn keep(mut stderr: ChildStderr, tail: &Mutex<Vec<u8>>) {
    let mut buffer = [0; 4096];
    while let Ok(read @ 1..) = stderr.read(&mut buffer) {
        let mut tail = tail.lock().unwrap_or_else(PoisonError::into_inner);
        tail.extend_from_slice(&buffer[..read]);
        let too_much = tail.len().saturating_sub(TAIL);
        tail.drain(..too_much);
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::path::{Path, PathBuf};

    use super::*;

    fn tasks(ids: &[&str]) -> Vec<Task> {
        let task = |id: &&str| Task {
            id: (*id).to_string(),
            argv: vec!["/bin/true".to_string()],
            out: PathBuf::from("out"),
            cpus: 1,
            resources: BTreeMap::new(),
        };
        ids.iter().map(task).collect()
    }

    /// A shell script in place of Python.
    fn python(folder: &Path, script: &str) -> OsString {
        let path = folder.join("python");
        // Written by another process: one that this one starts meanwhile would hold a file that it has open, which could not be started then.
        let mut writing = Command::new("sh");
        writing
            .args(["-c", "printf '#!/bin/sh\\n%s\\n' \"$2\" >\"$1\" && chmod +x \"$1\"", "sh"])
            .arg(&path)
            .arg(script);
        assert!(writing.status().unwrap().success());
        path.into_os_string()
    }

    fn run(script: &str, ids: &[&str]) -> (Result<Vec<EndedTask>, EngineError>, Vec<EngineEvent>) {
        let folder = tempfile::tempdir().unwrap();
        let mut events = Vec::new();
        let ray = Ray { python: python(folder.path(), script) };
        let ran = ray.run(&tasks(ids), &|| false, &mut |event| events.push(event));
        (ran, events)
    }

    const READY: &str = r#"echo '{"ready":"Ray","ray":"2.60.0","protocol":1}'"#;

    #[test]
    fn tasks_are_told_of_as_lines() {
        let script = format!(
            r#"{READY}
read one; read two
echo '{{"notice":"a node went"}}'
echo '{{"id":"b","lost":"its worker ended four times"}}'
echo '{{"id":"a","rc":3,"node":"n","s":1.5}}'
cat"#
        );
        let (ran, events) = run(&script, &["a", "b"]);
        let ran = ran.unwrap();
        assert_eq!(ran[0].end, TaskEnd::Exited(3));
        assert_eq!(ran[1].end, TaskEnd::Lost("its worker ended four times".to_string()));
        assert_eq!(events.len(), 4);
    }

    #[test]
    fn a_bridge_that_ends_too_early_is_no_success() {
        let script = format!("{READY}\nread one\necho 'it is full' >&2\nexit 0");
        let message = run(&script, &["a"]).0.unwrap_err().to_string();
        assert!(message.contains("ended: exit status: 0") && message.contains("it is full"), "{message}");
    }

    #[test]
    fn what_cannot_be_read_is_no_success() {
        for line in [
            "hello",
            r#"{"id":"a","rc":0}"#,
            r#"{"id":"a","rc":0,"node":"n","s":1,"more":1}"#,
            r#"{"id":"b","rc":0,"node":"n","s":1}"#,
            r#"{"id":"a","rc":0.5,"node":"n","s":1}"#,
        ] {
            let script = format!("{READY}\necho '{line}'\ncat >/dev/null");
            assert!(run(&script, &["a"]).0.is_err(), "{line}");
        }
        let cut_off = format!("{READY}\nprintf '{{\"id\":\"a\",\"rc\":0,\"node\":\"n\",\"s\":1}}'");
        assert!(run(&cut_off, &["a"]).0.is_err());
    }

    #[test]
    fn other_versions_are_named_with_what_to_install() {
        let of =
            |ready: &str| run(&format!("echo '{ready}'; cat >/dev/null"), &["a"]).0.unwrap_err().to_string();
        let older = of(r#"{"ready":"Ray","ray":"2.9.0","protocol":1}"#);
        assert!(older.starts_with("Ray 2.9.0 is installed, and 2.60.0 is needed: run `pip"), "{older}");
        assert!(of(r#"{"ready":"Ray","ray":"2.60.0","protocol":2}"#).contains("speaks protocol 2"));
        let missing = of(r#"{"missing":"there is no Ray"}"#);
        assert_eq!(missing, "there is no Ray");
    }

    #[test]
    fn what_is_missing_is_named_with_what_to_install() {
        let ray = Ray { python: "/no/such/python".into() };
        let message = ray.run(&tasks(&["a"]), &|| false, &mut |_| ()).unwrap_err().to_string();
        assert!(message.starts_with("there is no `/no/such/python` here: run `pip"), "{message}");
        let script = "echo \"python: No module named scenario_runner_av.ray\" >&2; exit 1";
        let message = run(script, &["a"]).0.unwrap_err().to_string();
        assert!(message.contains("has no module scenario_runner_av: run"), "{message}");
    }

    #[test]
    fn what_is_stopped_is_told_by_the_end_of_its_input() {
        let folder = tempfile::tempdir().unwrap();
        let gone = folder.path().join("gone");
        let script = format!("{READY}\ncat >/dev/null\ntouch '{}'", gone.display());
        let ray = Ray { python: python(folder.path(), &script) };
        let ran = ray.run(&tasks(&["a"]), &|| true, &mut |_| ());
        assert!(matches!(ran, Err(EngineError::Stopped)), "{ran:?}");
        assert!(gone.exists());
    }
}
