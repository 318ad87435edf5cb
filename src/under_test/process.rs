//! One process of a program, or one instance of a module: greeted, asked and ended.

use std::mem;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Value as Json, json};

use super::child::Child;
#[cfg(feature = "fmu")]
use super::co_simulation;
#[cfg(feature = "wasm")]
use super::guest::Guest;
use super::hello::{self, Encoding, Hello};
use super::log::ProgramLog;
#[cfg(not(feature = "wasm"))]
use super::no_guest::NoGuest as Guest;
use super::parent::Parent;
use super::quote::{log_line, quoted};
use super::start::{StartError, StartProblem};
use super::strict_json;
use super::watchdog::Watchdog;
use super::wire::{self, Answered, DueDecision, MoreTables, Opened, Reply};
use scenario::{DeclaredProgram, FaultKind, ProgramFault, ProgramKind};
use sim::Mode;

/// In which a parent takes note that it is not asked any more.
const TIME_FOR_GOODBYE: Duration = Duration::from_secs(2);

/// A process, or an instance of a module, that has said hello.
pub struct Process {
    program: Arc<DeclaredProgram>,
    hello: Hello,
    modes: Vec<Mode>,
    channel: Channel,
    has_ended: bool,
    /// Why it is not asked any more, if it failed.
    fault: Option<ProgramFault>,
    request: Vec<u8>,
    answer: Vec<u8>,
    /// What it has loaded, which is gone after it.
    #[cfg(feature = "fmu")]
    _fmu: Option<co_simulation::UnpackedFmu>,
}

/// Programs of ours that stand between the runner and others.
#[derive(Clone, Copy)]
pub struct OwnExecutables<'a> {
    /// Ends a process whose runner is gone.
    pub supervisor: Option<&'a Path>,
    /// Loads functional mock-up units.
    pub fmu_host: Option<&'a Path>,
}

/// How a program is reached.
enum Channel {
    Child(Child),
    Guest(Box<Guest>),
    Parent(Parent),
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
        own: OwnExecutables,
        log: ProgramLog,
    ) -> Result<Self, StartError> {
        let child = |words: &[String]| {
            Ok(Channel::Child(Child::start(program, words, watchdog, own.supervisor, log)?))
        };
        #[cfg(feature = "fmu")]
        let mut fmu = None;
        let (channel, encoding) = match &program.kind {
            ProgramKind::Command(words) => (child(words)?, Encoding::Json),
            ProgramKind::Wasm(file) => {
                (Channel::Guest(Box::new(Guest::start(program, file)?)), Encoding::F64)
            }
            #[cfg(feature = "fmu")]
            ProgramKind::Fmu(declared) => {
                let unpacked = fmu.insert(co_simulation::unpack(program, declared, own.fmu_host)?);
                (child(&unpacked.words)?, Encoding::Json)
            }
            #[cfg(not(feature = "fmu"))]
            ProgramKind::Fmu(declared) => {
                let message = format!("`{}`: this scenario-runner is built without FMUs", declared.file);
                let hint = "build it with the feature `fmu`";
                return Err(StartError::new(StartProblem::CannotStart, program, message, hint));
            }
        };
        let started = Self::greeted(program, channel, encoding);
        #[cfg(feature = "fmu")]
        let started = started.map(|mut process| {
            process._fmu = fmu;
            process
        });
        started
    }

    /// Takes whoever started this process for the program, and waits for its hello.
    ///
    /// # Errors
    /// If it does not say hello as it must.
    pub(super) fn of_parent(program: &Arc<DeclaredProgram>, parent: Parent) -> Result<Self, StartError> {
        Self::greeted(program, Channel::Parent(parent), Encoding::Json)
    }

    fn greeted(
        program: &Arc<DeclaredProgram>,
        channel: Channel,
        encoding: Encoding,
    ) -> Result<Self, StartError> {
        let hello = Hello {
            name: None,
            version: None,
            encoding,
            runs_at_once: 1,
            modes: Vec::new(),
            tables: MoreTables::default(),
            parameters: None,
            gives: None,
        };
        let mut process = Self {
            program: program.clone(),
            hello,
            modes: Vec::new(),
            channel,
            has_ended: false,
            fault: None,
            request: Vec::new(),
            answer: Vec::new(),
            #[cfg(feature = "fmu")]
            _fmu: None,
        };
        process.greet()?;
        Ok(process)
    }

    fn greet(&mut self) -> Result<(), StartError> {
        let greeting = hello::own_hello(&self.program);
        let limit = Duration::from_secs_f64(self.program.starts_within);
        let said = match &mut self.channel {
            Channel::Child(child) => child.greet(&greeting.to_string(), limit),
            Channel::Parent(parent) => parent.greet(&greeting.to_string(), limit),
            Channel::Guest(guest) => {
                wire::text_frame(&greeting.to_string(), &mut self.request);
                let told = guest.exchange(&self.request, 1, &mut self.answer);
                told.map(|()| String::from_utf8_lossy(self.answer.get(4..).unwrap_or(&[])).into_owned())
            }
        };
        let hello = said.map_err(|fault| self.no_hello(fault.message))?;
        let mut hello = hello::read(&hello).map_err(|message| self.no_hello(message))?;
        if let Channel::Guest(_) = self.channel {
            // It is given frames, whatever it says.
            hello.encoding = Encoding::F64;
        }
        self.modes = hello.modes.iter().map(|word| Mode::from(word.clone())).collect();
        self.hello = hello;
        Ok(())
    }

    fn no_hello(&mut self, message: String) -> StartError {
        self.end();
        let program = &self.program;
        let message = format!("`{}` does not say hello: {message}", program.name);
        let hint = match program.kind {
            ProgramKind::Fmu(_) => {
                "the process that loads the FMU ended: what its library needs is not there, or it crashed"
            }
            _ => {
                "the program reads a line that begins with `{\"hello\"` and answers with one: see docs/under_test.md"
            }
        };
        let lines = self.last_lines();
        let notes = lines.iter().map(|line| format!("it wrote: {line}")).collect();
        StartError::new(StartProblem::NoHello, program, message, hint).with_notes(notes)
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
        let slots: Vec<usize> = runs.iter().map(|run| run.slot).collect();
        self.open_as(&wire::open(runs), &slots)
    }

    /// As [`Self::open`], with what is said of the runs in these slots.
    pub(super) fn open_as(
        &mut self,
        said: &Json,
        slots: &[usize],
    ) -> Result<Vec<(usize, ProgramFault)>, Failed> {
        self.say(said);
        self.exchange(Duration::from_secs_f64(self.program.starts_within), slots.len())?;
        let (value, wrong) = match strict_json::read(self.text()) {
            Ok(value) => (Some(value), "does not say which runs are ready".to_string()),
            Err(wrong) => (None, wrong),
        };
        if let Some(fault) = value.as_ref().and_then(wire::last_refusal) {
            return Err(self.gone(fault));
        }
        let ready = value.as_ref().and_then(|value| {
            let slots = value.get("ready")?.as_array()?;
            let slots: Vec<usize> =
                slots.iter().map(|slot| slot.as_u64().map(|slot| slot as usize)).collect::<Option<_>>()?;
            let failed = if value.get("failed").is_some() { wire::refused(value)? } else { Vec::new() };
            Some((slots, failed))
        });
        let is_whole = |(ready, failed): &(Vec<usize>, Vec<(usize, String)>)| {
            slots.iter().all(|one| ready.contains(one) != failed.iter().any(|(slot, _)| slot == one))
        };
        match ready.filter(is_whole) {
            Some((_, failed)) => Ok(failed
                .into_iter()
                .map(|(slot, message)| (slot, self.with_log(ProgramFault::new(FaultKind::Refused, message))))
                .collect()),
            None => {
                let fault = ProgramFault::new(FaultKind::Garbage, format!("{} {wrong}", quoted(self.text())));
                Err(self.gone(fault))
            }
        }
    }

    /// Asks for nothing, and sees that nothing else is answered: what it said besides its answers until now would have been taken for
    /// one of them. A module inside this process has no way to say such.
    ///
    /// # Errors
    /// If it said more than it was asked for, or does not answer. The process is then gone.
    pub fn confirm(&mut self) -> Result<(), Failed> {
        if let Channel::Guest(_) = self.channel {
            return Ok(());
        }
        self.say(&wire::open(&[]));
        self.exchange(Duration::from_secs_f64(self.program.answers_within), 1)?;
        let value = strict_json::read(self.text()).ok();
        if let Some(fault) = value.as_ref().and_then(wire::last_refusal) {
            return Err(self.gone(fault));
        }
        let is_ready = |value: &Json| value.get("ready").and_then(Json::as_array).is_some_and(Vec::is_empty);
        if value.as_ref().is_some_and(is_ready) {
            return Ok(());
        }
        let fault = wire::unasked(self.text());
        Err(self.gone(fault))
    }

    /// What it answered to what is not a step.
    fn text(&self) -> &[u8] {
        match self.hello.encoding {
            Encoding::F64 => self.answer.get(4..).unwrap_or(&[]),
            Encoding::Json => &self.answer,
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
            Encoding::F64 => wire::step_frame(asked, self.hello.tables, &mut self.request),
        }
        self.exchange(limit, asked.len())?;
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
        let told = match &mut self.channel {
            Channel::Child(child) => child.tell(&self.request, limit),
            Channel::Guest(guest) => guest.tell(&self.request, runs.len()),
            Channel::Parent(parent) => parent.tell(&self.request, limit),
        };
        told.map_err(|fault| self.gone(fault))
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

    /// Sends the request about so many runs and reads what is answered, in time.
    fn exchange(&mut self, limit: Duration, runs: usize) -> Result<(), Failed> {
        let answered = match &mut self.channel {
            Channel::Child(child) => {
                child.exchange(&self.request, self.hello.encoding, limit, &mut self.answer)
            }
            Channel::Guest(guest) => guest.exchange(&self.request, runs, &mut self.answer),
            Channel::Parent(parent) => {
                parent.exchange(&self.request, self.hello.encoding, limit, &mut self.answer)
            }
        };
        answered.map_err(|fault| self.gone(fault))
    }

    /// A fault after which it is not asked any more.
    fn gone(&mut self, fault: ProgramFault) -> ProgramFault {
        self.end();
        let fault = self.with_log(fault);
        self.fault = Some(fault.clone());
        fault
    }

    /// If it is whoever started this process, why that is not asked any more.
    pub(super) fn lost_parent(&self) -> Option<&ProgramFault> {
        self.fault.as_ref().filter(|_| self.is_parent())
    }

    /// Whether it is whoever started this process, of which there is no other.
    pub(super) fn is_parent(&self) -> bool {
        matches!(self.channel, Channel::Parent(_))
    }

    fn with_log(&self, fault: ProgramFault) -> ProgramFault {
        let log = match &self.channel {
            Channel::Child(child) => child.log().path().map(|path| path.display().to_string()),
            Channel::Guest(_) | Channel::Parent(_) => None,
        };
        ProgramFault { log_tail: self.last_lines(), log, ..fault }
    }

    /// What it wrote last besides its answers; a module cannot write, and what a parent writes is not ours to read.
    fn last_lines(&self) -> Vec<String> {
        match &self.channel {
            Channel::Child(child) => {
                child.log().last_lines(self.has_ended).iter().map(|line| log_line(line)).collect()
            }
            Channel::Guest(_) | Channel::Parent(_) => Vec::new(),
        }
    }

    fn end(&mut self) {
        self.has_ended = true;
        if let Channel::Child(child) = &mut self.channel {
            child.end();
        }
    }
}

impl Process {
    /// Says goodbye, and ends it if it stays; whether it went by itself.
    pub(super) fn leave(&mut self) -> bool {
        if self.has_ended {
            return true;
        }
        self.has_ended = true;
        self.say(&json!({"bye": {}}));
        let goodbye = mem::take(&mut self.request);
        match &mut self.channel {
            Channel::Child(child) => child.leave(&goodbye),
            Channel::Guest(_) => true,
            // It goes on with whatever else it does.
            Channel::Parent(parent) => parent.tell(&goodbye, TIME_FOR_GOODBYE).is_ok(),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.leave();
    }
}
