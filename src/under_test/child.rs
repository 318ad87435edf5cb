//! A program as a child process: started, written to and read from within its deadline, and ended with all that it has started.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use super::hello::Encoding;
use super::log::ProgramLog;
use super::lookup;
use super::quote::quoted;
use super::start::{StartError, StartProblem};
use super::supervise::{BY_SIGNAL, SUPERVISE};
use super::watchdog::{Watchdog, Watched};
use super::wire::{self, MOST_LINES_BEFORE_HELLO};
use scenario::DeclaredProgram;
use scenario::{FaultKind, ProgramFault};

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

/// A child process, with the pipes to it.
pub struct Child {
    /// Nothing once it is told goodbye.
    stdin: Option<ChildStdin>,
    stdout: BufReader<ChildStdout>,
    watched: Arc<Watched>,
    log: Arc<ProgramLog>,
    is_supervised: bool,
}

impl Child {
    /// Starts the command of a program.
    ///
    /// # Errors
    /// If it cannot be started.
    pub fn start(
        program: &DeclaredProgram,
        words: &[String],
        watchdog: &Watchdog,
        supervisor: Option<&Path>,
        log: ProgramLog,
    ) -> Result<Self, StartError> {
        let (first, rest) = words.split_first().map_or(("", words), |(first, rest)| (first.as_str(), rest));
        let executable = lookup::executable(program, first)?;
        let cannot = |error: io::Error| {
            let message = format!("`{first}` cannot be started: {error}");
            StartError::new(StartProblem::CannotStart, program, message, "try the command by hand")
        };
        let declared = program.environment.iter().map(|(name, value)| (name.as_str(), value.as_str()));
        let environment = ENVIRONMENT.into_iter().chain([(NAME, program.name.as_str())]).chain(declared);
        let mut command = match supervisor {
            Some(supervisor) => {
                let mut command = Command::new(supervisor);
                command.args([SUPERVISE, &std::process::id().to_string()]);
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
            .args(rest)
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
        Ok(Self {
            stdin,
            stdout: BufReader::with_capacity(1 << 16, stdout.expect("it is piped")),
            watched,
            log,
            is_supervised: supervisor.is_some(),
        })
    }

    /// Says hello, and gives what it says.
    ///
    /// # Errors
    /// If it does not say hello within that time, or ends.
    pub fn greet(&mut self, greeting: &str, limit: Duration) -> Result<String, ProgramFault> {
        let mut said = Vec::new();
        let hello = self.within(limit, |child| {
            child.write(format!("{greeting}\n").as_bytes())?;
            for _ in 0..=MOST_LINES_BEFORE_HELLO {
                if let Err(message) = child.read_line(&mut said)? {
                    return Ok(Err(message));
                }
                if said.starts_with(b"{\"hello\"") {
                    return Ok(Ok(String::from_utf8_lossy(&said).into_owned()));
                }
                child.log.add(&said);
            }
            let last = quoted(&said);
            Ok(Err(format!("it printed more than {MOST_LINES_BEFORE_HELLO} lines, the last of them {last}")))
        });
        hello.map_err(|fault| match fault.kind {
            FaultKind::Timeout => {
                ProgramFault { message: format!("it said nothing within {} s", limit.as_secs_f64()), ..fault }
            }
            _ => fault,
        })
    }

    /// Sends a request, and reads what is answered into `answer`: a line, or a frame without its length.
    ///
    /// # Errors
    /// If there is no answer within that time, or none that could be one.
    pub fn exchange(
        &mut self,
        request: &[u8],
        encoding: Encoding,
        limit: Duration,
        answer: &mut Vec<u8>,
    ) -> Result<(), ProgramFault> {
        if !self.stdout.buffer().is_empty() {
            return Err(wire::unasked(self.stdout.buffer()));
        }
        self.within(limit, |child| {
            child.write(request)?;
            match encoding {
                Encoding::Json => child.read_line(answer),
                Encoding::F64 => child.read_frame(answer),
            }
        })
    }

    /// Sends what is not answered.
    ///
    /// # Errors
    /// If it does not take it within that time.
    pub fn tell(&mut self, request: &[u8], limit: Duration) -> Result<(), ProgramFault> {
        self.within(limit, |child| child.write(request).map(Ok))
    }

    /// Says goodbye, and ends it if it stays; whether it went by itself.
    pub fn leave(&mut self, goodbye: &[u8]) -> bool {
        self.watched.set_deadline(Some(Instant::now() + TIME_TO_EXIT));
        // Who does not listen any more is ended all the same.
        let _ = self.write(goodbye);
        self.stdin = None;
        let went = self.watched.wait(TIME_TO_EXIT).is_some() && !self.watched.has_expired();
        self.end();
        went
    }

    /// Ends it and all that it has started.
    pub fn end(&mut self) {
        self.stdin = None;
        self.watched.end_and_wait();
    }

    /// What it wrote besides its answers.
    pub fn log(&self) -> &ProgramLog {
        &self.log
    }

    /// Does what it may not take longer for.
    fn within<T>(
        &mut self,
        limit: Duration,
        talk: impl FnOnce(&mut Self) -> io::Result<Result<T, String>>,
    ) -> Result<T, ProgramFault> {
        self.watched.set_deadline(Some(Instant::now() + limit));
        let said = talk(self);
        self.watched.set_deadline(None);
        match said {
            Ok(said) => said.map_err(|message| ProgramFault::new(FaultKind::Garbage, message)),
            Err(error) => Err(self.broken(&error, limit)),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let stdin = self.stdin.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        stdin.write_all(bytes)?;
        stdin.flush()
    }

    /// The next line, or what is wrong with it.
    fn read_line(&mut self, line: &mut Vec<u8>) -> io::Result<Result<(), String>> {
        line.clear();
        (&mut self.stdout).take(wire::LONGEST as u64 + 1).read_until(b'\n', line)?;
        if line.last() == Some(&b'\n') {
            return Ok(Ok(()));
        }
        if line.len() > wire::LONGEST {
            return Ok(Err(wire::too_long(line)));
        }
        Err(io::ErrorKind::UnexpectedEof.into())
    }

    /// The next frame without its length, or what is wrong with it.
    fn read_frame(&mut self, frame: &mut Vec<u8>) -> io::Result<Result<(), String>> {
        let mut length = [0; 4];
        self.stdout.read_exact(&mut length)?;
        let size = match wire::frame_size(length) {
            Ok(size) => size,
            Err(message) => return Ok(Err(message)),
        };
        frame.resize(size, 0);
        self.stdout.read_exact(frame)?;
        Ok(Ok(()))
    }

    /// The fault of a process that could not be written to or read from.
    fn broken(&mut self, error: &io::Error, limit: Duration) -> ProgramFault {
        if self.watched.has_expired() {
            return wire::late(limit);
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
        ProgramFault::new(FaultKind::Exited, message)
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
