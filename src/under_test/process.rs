//! One process of a program: started, greeted, asked and ended.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value as Json, json};

use super::fault::{FaultKind, ProgramFault, one_line, quoted};
use super::hello::{self, Encoding, Hello};
use super::log::ProgramLog;
use super::lookup;
use super::start::{StartError, StartProblem};
use super::supervise::BY_SIGNAL;
use super::watchdog::{Watchdog, Watched};
use super::wire::{self, Answered, DueDecision, Opened, Reply};
use scenario::DeclaredProgram;
use sim::Mode;

/// Lines that a program may print before its hello.
const MOST_LINES_BEFORE_HELLO: usize = 100;

/// In which a program that is told goodbye ends by itself.
const TIME_TO_EXIT: Duration = Duration::from_secs(2);

/// In which a program finds under which name it is tested, and so that it is.
const NAME: &str = "SCENARIO_RUNNER_CONTROLLER";

/// What numeric libraries and interpreters find unless a declaration says otherwise: the same run is the same run, and as
/// many processes as there are threads do not each want all of them.
const ENVIRONMENT: [(&str, &str); 7] = [
    ("PYTHONHASHSEED", "0"),
    ("PYTHONUNBUFFERED", "1"),
    ("OMP_NUM_THREADS", "1"),
    ("OPENBLAS_NUM_THREADS", "1"),
    ("MKL_NUM_THREADS", "1"),
    ("NUMEXPR_NUM_THREADS", "1"),
    ("VECLIB_MAXIMUM_THREADS", "1"),
];

/// A process that has said hello.
pub struct Process {
    program: Arc<DeclaredProgram>,
    hello: Hello,
    modes: Vec<Mode>,
    /// Nothing once it is told goodbye.
    stdin: Option<ChildStdin>,
    stdout: BufReader<ChildStdout>,
    watched: Arc<Watched>,
    log: Arc<ProgramLog>,
    is_supervised: bool,
    has_ended: bool,
    request: Vec<u8>,
    answer: Vec<u8>,
}

/// What keeps a process from being asked again: of all that it was asked for, nothing came.
pub type Failed = ProgramFault;

impl Process {
    /// Starts the program and waits for its hello.
    ///
    /// # Errors
    /// If it cannot be started, or does not say hello as it must.
    pub fn start(
        program: &Arc<DeclaredProgram>,
        watchdog: &Watchdog,
        supervisor: Option<&Path>,
        log: ProgramLog,
    ) -> Result<Self, StartError> {
        let executable = lookup::executable(program)?;
        let cannot = |error: io::Error| {
            let message = format!("`{}` cannot be started: {error}", program.command[0]);
            StartError::new(StartProblem::CannotStart, program, message, "try the command by hand")
        };
        let declared = program.environment.iter().map(|(name, value)| (name.as_str(), value.as_str()));
        let environment = ENVIRONMENT.into_iter().chain([(NAME, program.name.as_str())]).chain(declared);
        let mut command = match supervisor {
            Some(supervisor) => {
                let mut command = Command::new(supervisor);
                command.args(["supervise", &std::process::id().to_string()]);
                // It is the program's, not that of what supervises it.
                environment.for_each(|(name, value)| _ = command.arg(format!("--set={name}={value}")));
                command.arg("--").arg(&executable);
                command
            }
            None => {
                let mut command = Command::new(&executable);
                command.envs(environment);
                command
            }
        };
        command
            .args(&program.command[1..])
            .current_dir(lookup::folder(program))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(cannot)?;
        let (stdin, stdout, stderr) = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let watched = watchdog.watch(child).map_err(cannot)?;
        let log = Arc::new(log);
        if let Some(stderr) = stderr {
            let log = log.clone();
            let reading = thread::Builder::new().name(format!("log of {}", program.name));
            if let Err(error) = reading.spawn(move || log.drain(stderr)) {
                watched.end_and_wait();
                return Err(cannot(error));
            }
        }
        let mut process = Self {
            program: program.clone(),
            hello: Hello {
                name: None,
                version: None,
                encoding: Encoding::Json,
                runs_at_once: 1,
                modes: Vec::new(),
                parameters: None,
                gives: None,
            },
            modes: Vec::new(),
            stdin,
            stdout: BufReader::with_capacity(1 << 16, stdout.expect("it is piped")),
            watched,
            log,
            is_supervised: supervisor.is_some(),
            has_ended: false,
            request: Vec::new(),
            answer: Vec::new(),
        };
        process.exchange_hello()?;
        Ok(process)
    }

    fn exchange_hello(&mut self) -> Result<(), StartError> {
        let limit = Duration::from_secs_f64(self.program.starts_within);
        let mut own_hello = hello::own_hello(&self.program).to_string();
        own_hello.push('\n');
        self.watched.set_deadline(Some(Instant::now() + limit));
        let said = self.write(own_hello.as_bytes()).and_then(|()| self.read_hello());
        self.watched.set_deadline(None);
        match said {
            Ok(Ok(hello)) => {
                self.modes = hello.modes.iter().map(|word| Mode::from(word.clone())).collect();
                self.hello = hello;
                Ok(())
            }
            Ok(Err(message)) => Err(self.no_hello(message)),
            Err(error) => {
                let fault = self.broken(&error, limit);
                let message = match fault.kind {
                    FaultKind::Timeout => format!("it said nothing within {} s", self.program.starts_within),
                    _ => fault.message,
                };
                Err(self.no_hello(message))
            }
        }
    }

    fn no_hello(&mut self, message: String) -> StartError {
        self.end();
        let program = &self.program;
        let message = format!("`{}` does not say hello: {message}", program.name);
        let hint = "the program reads a line that begins with `{\"hello\"` and answers with one: see docs/under_test.md";
        let lines = self.log.last_lines(true);
        let notes = lines.iter().map(|line| format!("it wrote: {}", one_line(line))).collect();
        StartError::new(StartProblem::NoHello, program, message, hint).with_notes(notes)
    }

    /// The hello, or what is wrong with what was said instead.
    fn read_hello(&mut self) -> io::Result<Result<Hello, String>> {
        for _ in 0..=MOST_LINES_BEFORE_HELLO {
            if let Err(message) = self.read_line()? {
                return Ok(Err(message));
            }
            if self.answer.starts_with(b"{\"hello\"") {
                return Ok(hello::read(&String::from_utf8_lossy(&self.answer)));
            }
            self.log.add(&self.answer);
        }
        Ok(Err(format!(
            "it printed more than {MOST_LINES_BEFORE_HELLO} lines, the last of them {}",
            quoted(&self.answer)
        )))
    }

    /// What it is a process of.
    pub fn program(&self) -> &Arc<DeclaredProgram> {
        &self.program
    }

    /// What it said of itself.
    pub fn hello(&self) -> &Hello {
        &self.hello
    }

    /// Whether it cannot be asked any more.
    pub fn has_ended(&self) -> bool {
        self.has_ended
    }

    /// Prepares runs; gives the slots of those that the program refuses, each with its reason.
    ///
    /// # Errors
    /// If it does not answer as it must. The process is then gone.
    pub fn open(&mut self, runs: &[Opened]) -> Result<Vec<(usize, ProgramFault)>, Failed> {
        let limit = Duration::from_secs_f64(self.program.starts_within);
        self.say(&wire::open(runs));
        self.exchange(limit)?;
        let text = if self.hello.encoding == Encoding::F64 {
            self.answer.get(4..).unwrap_or(&[])
        } else {
            &self.answer
        };
        let value: Option<Json> = serde_json::from_slice(text).ok();
        let ready = value.as_ref().and_then(|value| {
            let slots = value.get("ready")?.as_array()?;
            let slots: Vec<usize> =
                slots.iter().map(|slot| slot.as_u64().map(|slot| slot as usize)).collect::<Option<_>>()?;
            let failed = if value.get("failed").is_some() { wire::refused(value)? } else { Vec::new() };
            Some((slots, failed))
        });
        let is_whole = |(ready, failed): &(Vec<usize>, Vec<(usize, String)>)| {
            runs.iter()
                .all(|run| ready.contains(&run.slot) != failed.iter().any(|(slot, _)| *slot == run.slot))
        };
        match ready.filter(is_whole) {
            Some((_, failed)) => Ok(failed
                .into_iter()
                .map(|(slot, message)| (slot, self.with_log(ProgramFault::new(FaultKind::Refused, message))))
                .collect()),
            None => {
                let fault = ProgramFault::new(
                    FaultKind::Garbage,
                    format!("{} does not say which runs are ready", quoted(text)),
                );
                Err(self.gone(fault))
            }
        }
    }

    /// Asks for decisions; what came of each, and in which wall time all of it.
    ///
    /// # Errors
    /// If it does not answer as it must. The process is then gone.
    pub fn decide(&mut self, asked: &[DueDecision]) -> Result<(Vec<Answered>, Duration), Failed> {
        let begun = Instant::now();
        let mut answers: Vec<Option<Answered>> = vec![None; asked.len()];
        let mut left: Vec<usize> = (0..asked.len()).collect();
        while !left.is_empty() {
            let some: Vec<DueDecision> = left.iter().map(|index| asked[*index]).collect();
            match self.ask(&some)? {
                Reply::Decided(decided) => {
                    for (index, answer) in left.drain(..).zip(decided) {
                        answers[index] = Some(answer.map_err(|fault| self.with_log(fault)));
                    }
                }
                Reply::Refused(slots) => {
                    let before = left.len();
                    left.retain(|index| {
                        let Some((_, message)) = slots.iter().find(|(slot, _)| *slot == asked[*index].slot)
                        else {
                            return true;
                        };
                        let fault = ProgramFault::new(FaultKind::Refused, message.clone());
                        answers[*index] = Some(Err(self.with_log(fault)));
                        false
                    });
                    if left.len() == before {
                        let fault = ProgramFault::new(
                            FaultKind::Garbage,
                            "it refused runs for which it was not asked".to_string(),
                        );
                        return Err(self.gone(fault));
                    }
                }
            }
        }
        Ok((answers.into_iter().map(|one| one.expect("every run was answered")).collect(), begun.elapsed()))
    }

    fn ask(&mut self, asked: &[DueDecision]) -> Result<Reply, Failed> {
        let limit = Duration::from_secs_f64(self.program.answers_within * asked.len() as f64);
        match self.hello.encoding {
            Encoding::Json => self.say(&wire::step(asked)),
            Encoding::F64 => wire::step_frame(asked, &mut self.request),
        }
        self.exchange(limit)?;
        let gives = self.program.gives;
        let reply = match self.hello.encoding {
            Encoding::Json => wire::read_line(&self.answer, gives, asked),
            Encoding::F64 => wire::read_frame(&self.answer, gives, asked, &self.modes),
        };
        reply.map_err(|fault| self.gone(fault))
    }

    /// Tells it that runs are over, each with the word for how.
    ///
    /// # Errors
    /// If it does not read any more. The process is then gone.
    pub fn close(&mut self, runs: &[(usize, &str)]) -> Result<(), Failed> {
        let limit = Duration::from_secs_f64(self.program.answers_within * runs.len() as f64);
        let closed: Vec<Json> =
            runs.iter().map(|(slot, reason)| json!({"slot": slot, "reason": reason})).collect();
        self.say(&json!({ "close": closed }));
        self.watched.set_deadline(Some(Instant::now() + limit));
        let written = self.send();
        self.watched.set_deadline(None);
        written.map_err(|error| self.broken(&error, limit))
    }

    /// Makes a text the next request.
    fn say(&mut self, value: &Json) {
        let text = value.to_string();
        match self.hello.encoding {
            Encoding::F64 => wire::text_frame(&text, &mut self.request),
            Encoding::Json => {
                self.request.clear();
                self.request.extend_from_slice(text.as_bytes());
                self.request.push(b'\n');
            }
        }
    }

    /// Sends the request and reads what is answered, in time.
    fn exchange(&mut self, limit: Duration) -> Result<(), Failed> {
        self.watched.set_deadline(Some(Instant::now() + limit));
        let read = self.send().and_then(|()| match self.hello.encoding {
            Encoding::Json => self.read_line(),
            Encoding::F64 => self.read_frame(),
        });
        self.watched.set_deadline(None);
        match read {
            Ok(Ok(())) => Ok(()),
            Ok(Err(message)) => {
                let fault = ProgramFault::new(FaultKind::Garbage, message);
                Err(self.gone(fault))
            }
            Err(error) => Err(self.broken(&error, limit)),
        }
    }

    fn send(&mut self) -> io::Result<()> {
        let request = std::mem::take(&mut self.request);
        let written = self.write(&request);
        self.request = request;
        written
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let stdin = self.stdin.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        stdin.write_all(bytes)?;
        stdin.flush()
    }

    /// The next line, or what is wrong with it.
    fn read_line(&mut self) -> io::Result<Result<(), String>> {
        self.answer.clear();
        (&mut self.stdout).take(wire::LONGEST as u64 + 1).read_until(b'\n', &mut self.answer)?;
        if self.answer.last() == Some(&b'\n') {
            return Ok(Ok(()));
        }
        if self.answer.len() > wire::LONGEST {
            return Ok(Err(format!("a line of more than 1 MiB that begins with {}", quoted(&self.answer))));
        }
        Err(io::ErrorKind::UnexpectedEof.into())
    }

    /// The next frame without its length, or what is wrong with it.
    fn read_frame(&mut self) -> io::Result<Result<(), String>> {
        let mut length = [0; 4];
        self.stdout.read_exact(&mut length)?;
        let size = u32::from_le_bytes(length) as usize;
        if !(4..=wire::LONGEST).contains(&size) {
            return Ok(Err(format!("a frame of {size} bytes, which begins with {}", quoted(&length))));
        }
        self.answer.resize(size, 0);
        self.stdout.read_exact(&mut self.answer)?;
        Ok(Ok(()))
    }

    /// The fault of a process that could not be written to or read from.
    fn broken(&mut self, error: &io::Error, limit: Duration) -> ProgramFault {
        if self.watched.has_expired() {
            let seconds = limit.as_secs_f64();
            return self.gone(ProgramFault::new(FaultKind::Timeout, format!("no answer within {seconds} s")));
        }
        // What has closed its pipes is about to end.
        let ended = self.watched.wait(Duration::from_millis(500));
        let message = match (ended, error.kind()) {
            (Some(status), _) => self.how(status),
            (None, io::ErrorKind::UnexpectedEof | io::ErrorKind::BrokenPipe) => {
                "it closed its standard streams".to_string()
            }
            (None, _) => format!("it cannot be reached: {error}"),
        };
        self.gone(ProgramFault::new(FaultKind::Exited, message))
    }

    fn how(&self, status: ExitStatus) -> String {
        #[cfg(unix)]
        let signal = std::os::unix::process::ExitStatusExt::signal(&status);
        #[cfg(not(unix))]
        let signal: Option<i32> = None;
        let code = status.code();
        let supervised =
            code.filter(|code| self.is_supervised && (1..=64).contains(&(code - i32::from(BY_SIGNAL))));
        match (signal.or(supervised.map(|code| code - i32::from(BY_SIGNAL))), code) {
            (Some(signal), _) => format!("it was ended by signal {signal}{}", known(signal)),
            (None, Some(code)) => format!("it ended with exit code {code}"),
            (None, None) => "it ended".to_string(),
        }
    }

    /// A fault after which it is not asked any more.
    fn gone(&mut self, fault: ProgramFault) -> ProgramFault {
        self.end();
        self.with_log(fault)
    }

    fn with_log(&self, fault: ProgramFault) -> ProgramFault {
        let log_tail = self.log.last_lines(self.has_ended);
        ProgramFault { log_tail, log: self.log.path().map(Path::to_path_buf), ..fault }
    }

    fn end(&mut self) {
        self.has_ended = true;
        self.stdin = None;
        self.watched.end_and_wait();
    }
}

/// What a signal is called.
fn known(signal: i32) -> &'static str {
    match signal {
        4 => " (SIGILL)",
        6 => " (SIGABRT)",
        8 => " (SIGFPE)",
        9 => " (SIGKILL)",
        11 => " (SIGSEGV)",
        15 => " (SIGTERM)",
        _ => "",
    }
}

impl Drop for Process {
    /// Says goodbye, and ends it if it stays.
    fn drop(&mut self) {
        if !self.has_ended {
            self.say(&json!({"bye": {}}));
            self.watched.set_deadline(Some(Instant::now() + TIME_TO_EXIT));
            // Who does not listen any more is ended all the same.
            let _ = self.send();
            self.stdin = None;
            self.watched.wait(TIME_TO_EXIT);
            self.end();
        }
    }
}
