//! The processes of programs: as many as may run at once, in use by whoever makes runs and kept for the next.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::answer_times::AnswerClock;
use super::log::ProgramLog;
use super::parent::Parent;
use super::permission::Permission;
use super::process::{OwnExecutables, Process};
use super::start::{StartError, StartProblem};
use super::watchdog::Watchdog;
use super::wire_record::WireRecord;
use scenario::DeclaredProgram;
use scenario::{FaultKind, ProgramFault};

/// Processes of a program in a row that ended before a run did, after which it is given up; so many for each that there is.
const MOST_FAILED_PROCESSES: u32 = 3;

/// Where the processes of programs are.
pub struct ProcessPool {
    permission: Permission,
    /// How many processes a program has at once, unless it wants fewer.
    threads: usize,
    logs: Option<PathBuf>,
    supervisor: Option<PathBuf>,
    fmu_host: Option<PathBuf>,
    record: Option<WireRecord>,
    /// The controller that whoever started this process decides for, and the streams until they are in use.
    parent: Option<(String, Mutex<Option<Parent>>)>,
    watchdog: Watchdog,
    programs: Mutex<HashMap<String, ProgramProcesses>>,
    released: Condvar,
}

/// The processes of one program.
#[derive(Default)]
struct ProgramProcesses {
    idle: Vec<Process>,
    /// In use, or being started.
    in_use: usize,
    /// The most of them that were in use side by side since a run came to its end.
    side_by_side: usize,
    /// How many were started.
    started: usize,
    /// Processes that ended since a run came to its end.
    failed: u32,
    given_up: Option<ProgramFault>,
    /// Names and versions that its processes have said, of which there should be one.
    titles: Vec<String>,
    program: Option<Arc<DeclaredProgram>>,
    answers: AnswerClock,
}

impl ProgramProcesses {
    fn use_another(&mut self) {
        self.in_use += 1;
        self.side_by_side = self.side_by_side.max(self.in_use);
    }
}

/// What a program was used for.
pub struct ProgramUse {
    /// As it is declared.
    pub program: Arc<DeclaredProgram>,
    /// Name and version as it says them; several if it was changed meanwhile.
    pub title: String,
    /// How long its answers took.
    pub answers: AnswerClock,
}

impl ProcessPool {
    /// One that starts what it may, at most so many processes of a program at once.
    pub fn new(permission: Permission, threads: usize) -> Self {
        Self {
            permission,
            threads: threads.max(1),
            logs: None,
            supervisor: None,
            fmu_host: None,
            record: None,
            parent: None,
            watchdog: Watchdog::default(),
            programs: Mutex::default(),
            released: Condvar::new(),
        }
    }

    /// The same, which keeps what programs write in files of this folder.
    pub fn logs(self, folder: impl Into<PathBuf>) -> Self {
        Self { logs: Some(folder.into()), ..self }
    }

    /// The same, with this executable (ours: see [`supervise_if_asked`](super::supervise_if_asked)) between it and each program, so that nothing is
    /// left of a program even if this process is ended from one moment to the next.
    pub fn supervised_by(self, executable: impl Into<PathBuf>) -> Self {
        Self { supervisor: Some(executable.into()), ..self }
    }

    /// The same, with this executable (ours: see [`fmu_host`](super::fmu_host)) as the process of functional mock-up units. Without one
    /// they cannot be started.
    pub fn fmu_host(self, executable: impl Into<PathBuf>) -> Self {
        Self { fmu_host: Some(executable.into()), ..self }
    }

    /// The same, which writes down what is said in one run.
    pub fn recording(self, record: WireRecord) -> Self {
        Self { record: Some(record), ..self }
    }

    /// The same, in which whoever started this process decides for that controller, and no program is started for it. Who started both ends
    /// has allowed it.
    pub fn served_by_parent(self, controller: impl Into<String>, parent: Parent) -> Self {
        Self { parent: Some((controller.into(), Mutex::new(Some(parent)))), ..self }
    }

    /// The streams to the parent, if it decides for this program.
    fn parent_of(&self, program: &DeclaredProgram) -> Option<&Mutex<Option<Parent>>> {
        self.parent.as_ref().filter(|(name, _)| *name == program.name).map(|(_, parent)| parent)
    }

    /// Where what is said in one run is written down.
    pub fn record(&self) -> Option<&WireRecord> {
        self.record.as_ref()
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<String, ProgramProcesses>> {
        self.programs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts a program that is not running yet, and keeps it for its first run; what it says of itself.
    ///
    /// # Errors
    /// If it may not be started, or does not start.
    pub fn prepare(&self, program: &Arc<DeclaredProgram>) -> Result<Prepared, StartError> {
        let process = self.start(program)?;
        let prepared = Prepared { hello: process.hello().clone() };
        let mut programs = self.lock();
        let processes = programs.entry(key(program)).or_default();
        processes.idle.push(process);
        Ok(prepared)
    }

    /// Starts a process besides those that are in use.
    ///
    /// # Errors
    /// If it may not be started, or does not start.
    pub fn start(&self, program: &Arc<DeclaredProgram>) -> Result<Process, StartError> {
        let parent = self.parent_of(program);
        if parent.is_none() {
            self.permission.check(program)?;
        }
        let number = {
            let mut programs = self.lock();
            let processes = programs.entry(key(program)).or_default();
            processes.started += 1;
            processes.started
        };
        let log = self.logs.as_ref().map(|folder| folder.join(format!("{}-{number}.log", program.name)));
        let process = match parent.map(|parent| parent.lock().unwrap_or_else(PoisonError::into_inner).take())
        {
            Some(Some(parent)) => Process::of_parent(program, parent)?,
            Some(None) => {
                let (message, hint) =
                    ("the parent is not asked a second time", "start it and this program anew");
                return Err(StartError::new(StartProblem::CannotStart, program, message, hint));
            }
            None => {
                let own = OwnExecutables {
                    supervisor: self.supervisor.as_deref(),
                    fmu_host: self.fmu_host.as_deref(),
                };
                Process::start(program, &self.watchdog, own, ProgramLog::new(log))?
            }
        };
        let title = process.hello().title();
        let mut programs = self.lock();
        let processes = programs.entry(key(program)).or_default();
        processes.program.get_or_insert_with(|| program.clone());
        if !title.is_empty() && !processes.titles.contains(&title) {
            processes.titles.push(title);
        }
        drop(programs);
        Ok(process)
    }

    /// What each of the programs was used for, in the order of their names.
    pub fn uses(&self) -> Vec<ProgramUse> {
        let programs = self.lock();
        let each = programs.values().filter_map(|processes| {
            let program = processes.program.clone()?;
            Some(ProgramUse {
                program,
                title: processes.titles.join(" / "),
                answers: processes.answers.clone(),
            })
        });
        let mut uses: Vec<ProgramUse> = each.collect();
        uses.sort_by(|one, other| {
            (&one.program.name, &one.program.file).cmp(&(&other.program.name, &other.program.file))
        });
        uses
    }

    /// A process of each of these programs, which are in the order of their names; waits until there is one.
    ///
    /// # Errors
    /// If one of them cannot be started or has been given up.
    pub fn acquire(
        &self,
        programs: &[Arc<DeclaredProgram>],
    ) -> Result<AcquiredProcesses<'_>, (usize, ProgramFault)> {
        let mut processes = AcquiredProcesses { pool: self, members: Vec::with_capacity(programs.len()) };
        for (index, program) in programs.iter().enumerate() {
            let process = self.acquire_one(program).map_err(|fault| (index, fault))?;
            processes.members.push(Member {
                program: program.clone(),
                answers: AnswerClock::default(),
                process: Some(process),
            });
        }
        Ok(processes)
    }

    /// A process of a program; waits until one may be had.
    fn acquire_one(&self, program: &Arc<DeclaredProgram>) -> Result<Process, ProgramFault> {
        let most = match self.parent_of(program) {
            Some(_) => 1,
            None => program.processes.map_or(self.threads, |most| self.threads.min(most as usize)).max(1),
        };
        let key = key(program);
        let mut programs = self.lock();
        loop {
            let processes = programs.entry(key.clone()).or_default();
            if let Some(fault) = &processes.given_up {
                return Err(fault.clone());
            }
            if let Some(process) = processes.idle.pop() {
                processes.use_another();
                return Ok(process);
            }
            if processes.in_use < most {
                processes.use_another();
                break;
            }
            programs = self.released.wait(programs).unwrap_or_else(PoisonError::into_inner);
        }
        drop(programs);
        let started = self.start_or_give_up(program);
        if started.is_err() {
            self.release(program, None);
        }
        started
    }

    /// Starts a process. A program that does not say hello counts as one that has ended; what cannot be started at all is not tried
    /// again.
    fn start_or_give_up(&self, program: &Arc<DeclaredProgram>) -> Result<Process, ProgramFault> {
        loop {
            let given_up = self.lock().get(&key(program)).and_then(|processes| processes.given_up.clone());
            if let Some(fault) = given_up {
                return Err(fault);
            }
            let error = match self.start(program) {
                Ok(process) => return Ok(process),
                Err(error) => error,
            };
            let is_over = error.problem != StartProblem::NoHello || self.note_failed(program).is_err();
            if is_over {
                let fault = ProgramFault {
                    log_tail: error.notes,
                    ..ProgramFault::new(FaultKind::Exited, error.message)
                };
                self.lock().entry(key(program)).or_default().given_up = Some(fault.clone());
                return Err(fault);
            }
        }
    }

    /// Takes note of a process that has ended.
    fn note_failed(&self, program: &DeclaredProgram) -> Result<(), ProgramFault> {
        let mut programs = self.lock();
        let processes = programs.entry(key(program)).or_default();
        processes.failed += 1;
        let most = MOST_FAILED_PROCESSES
            * u32::try_from(processes.side_by_side.max(1)).unwrap_or(u32::MAX / MOST_FAILED_PROCESSES);
        if processes.failed >= most && processes.given_up.is_none() {
            let message = format!(
                "given up: {} processes ended one after the other before a run did",
                processes.failed
            );
            processes.given_up = Some(ProgramFault::new(FaultKind::Exited, message));
        }
        processes.given_up.clone().map_or(Ok(()), Err)
    }

    fn release(&self, program: &DeclaredProgram, process: Option<Process>) {
        let mut programs = self.lock();
        let processes = programs.entry(key(program)).or_default();
        processes.in_use -= 1;
        let lost = process.as_ref().and_then(Process::lost_parent).map(not_asked_again);
        processes.given_up = lost.or(processes.given_up.take());
        let ended = match process {
            Some(process) if !process.has_ended() => {
                processes.idle.push(process);
                None
            }
            other => other,
        };
        drop(programs);
        self.released.notify_all();
        if ended.is_some() {
            // What that means is said when the next one is wanted.
            let _ = self.note_failed(program);
        }
    }
}

/// What becomes of all runs in which a parent was to decide that is not asked any more.
fn not_asked_again(fault: &ProgramFault) -> ProgramFault {
    ProgramFault { message: format!("the parent is not asked any more: {}", fault.message), ..fault.clone() }
}

/// What tells a program from others, though they have one name.
fn key(program: &DeclaredProgram) -> String {
    format!("{}\0{}\0{}", program.name, program.file, program.identity())
}

/// A program that has said hello.
pub struct Prepared {
    /// What it said.
    pub hello: super::Hello,
}

/// A process of each of some programs, which goes back to its pool.
pub struct AcquiredProcesses<'y> {
    pool: &'y ProcessPool,
    members: Vec<Member>,
}

struct Member {
    program: Arc<DeclaredProgram>,
    answers: AnswerClock,
    process: Option<Process>,
}

impl<'p> AcquiredProcesses<'p> {
    /// Where what is said in the run of that key is written down, if it is.
    pub fn record_of(&self, run: &str) -> Option<&'p WireRecord> {
        self.pool.record.as_ref().filter(|record| run == record.run())
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.members.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.members.is_empty()
    }

    /// One of the programs.
    pub fn program(&self, index: usize) -> &Arc<DeclaredProgram> {
        &self.members[index].program
    }

    /// The process, started anew if the one before is gone.
    ///
    /// # Errors
    /// If it cannot be started, or has been given up.
    pub fn process(&mut self, index: usize) -> Result<&mut Process, ProgramFault> {
        let Member { program, process, .. } = &mut self.members[index];
        if process.as_ref().is_some_and(Process::has_ended) {
            if let Some(fault) = process.as_ref().and_then(Process::lost_parent) {
                return Err(not_asked_again(fault));
            }
            *process = None;
            self.pool.note_failed(program)?;
        }
        if process.is_none() {
            *process = Some(self.pool.start_or_give_up(program)?);
        }
        Ok(process.as_mut().expect("it was just started"))
    }

    /// Takes note of how long an answer took; see [`AnswerClock::note`].
    pub fn note_answer(&mut self, index: usize, time: Duration, runs: usize, late: usize) {
        self.members[index].answers.note(time, runs, late);
    }

    /// Has the next run begin with a process that has seen none; false if there is no other, since it is the parent.
    pub fn replace(&mut self, index: usize) -> bool {
        let member = &mut self.members[index];
        if member.process.as_ref().is_some_and(|process| !process.has_ended()) {
            if member.process.as_ref().is_some_and(Process::is_parent) {
                return false;
            }
            member.process = None;
        }
        true
    }

    /// Whether it is there and can be asked.
    pub fn is_there(&self, index: usize) -> bool {
        self.members[index].process.as_ref().is_some_and(|process| !process.has_ended())
    }

    /// How many runs all of them take at once.
    pub fn runs_at_once(&self) -> usize {
        let each = self.members.iter().filter_map(|member| member.process.as_ref());
        each.map(|process| process.hello().runs_at_once).min().unwrap_or(1)
    }

    /// A run of all of them came to its end.
    pub fn finished(&self) {
        let mut programs = self.pool.lock();
        for member in &self.members {
            let processes = programs.entry(key(&member.program)).or_default();
            (processes.failed, processes.side_by_side) = (0, processes.in_use);
        }
    }
}

impl Drop for AcquiredProcesses<'_> {
    fn drop(&mut self) {
        for Member { program, answers, process } in self.members.drain(..) {
            self.pool.lock().entry(key(&program)).or_default().answers.add(&answers);
            self.pool.release(&program, process);
        }
    }
}

#[cfg(test)]
pub mod tests {
    use scenario::{Answer, DeclaredProgram, Delay, Origin, ProgramKind};

    /// A program that is this command.
    pub fn program(command: &str) -> DeclaredProgram {
        DeclaredProgram {
            name: "own".into(),
            kind: ProgramKind::Command(command.split(' ').map(str::to_string).collect()),
            folder: String::new(),
            environment: Vec::new(),
            gives: Answer::Acceleration,
            period: None,
            delay: Delay::Fixed(0.0),
            settles: 0.0,
            starts_within: 30.0,
            answers_within: 10.0,
            processes: None,
            is_nondeterministic: false,
            file: "a.scn".into(),
            origin: Origin::default(),
            parameters: Vec::new(),
        }
    }
}
