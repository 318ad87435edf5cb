//! Who is next: runs go to the executor, all in one round; blocks are under way on threads of their own, which ask it for
//! runs a round at a time.

use std::any::Any;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{self, RecvTimeoutError, SyncSender};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use super::earlier::Usable;
use super::looks::Looked;
use super::reporting::{Message, Off, Reporting};
use super::schedule::UnitSchedule;
use super::shared::Runner;
use super::unit::{UnitKind, Units};
use super::unit_run::UnitRun;
use crate::experiment::{BlockProgress, EarlierResults};
use crate::run::{Done, Job, JobPlace, Remembered, Sequence, Sequences, Stop, run_sequences};
use results::{Event, Reporter, Stopping, SuiteReport, UnitReport, Workload};

/// What is to be run, and how.
#[derive(Clone, Copy)]
pub struct Orders<'o> {
    /// Whether each unit is to run; see [`super::with_needs`].
    pub chosen: &'o [bool],
    /// Whether each unit begins before those that do not; may be shorter.
    pub first: &'o [bool],
    /// After so many failures nothing more begins.
    pub max_failures: Option<usize>,
    /// Whether every trial is held in the reports; gates hold those of their suites all the same.
    pub every_trial: bool,
    /// Where runs are kept that are made before their trials begin, such as those that sequential gates look at: the executor of the runner.
    /// Without it there are none.
    pub memory: Option<&'o Remembered<'o>>,
    /// Whether gates leave out trials that their baseline lacks, instead of refusing to compare.
    pub lenient: bool,
    /// Whether a few runs of each trial are made before all others, so that the reporter knows what runs take. That needs `memory`, too.
    pub pilot: bool,
}

/// How often time is told when nothing happens.
const TICK: Duration = Duration::from_millis(100);

/// So many messages may wait to be told before whoever has another one has to wait.
const MOST_MESSAGES: usize = 4096;

impl<'a> Runner<'a> {
    /// Runs the chosen units and returns the report of every suite, which names all of its units: those that were not run
    /// are skipped with the reason.
    pub fn run(&self, units: &Units<'a>, orders: &Orders, reporter: &mut dyn Reporter) -> Vec<SuiteReport> {
        let (started, begun) = (SystemTime::now(), Instant::now());
        reporter.tell(&Event::Begun(&outline(units, orders.chosen)));
        let looked = orders.memory.map_or_else(Looked::default, |memory| {
            self.look(units, orders.chosen, orders.max_failures, (memory, orders.lenient), reporter)
        });
        let mut chosen = orders.chosen.to_vec();
        looked.called_off.iter().for_each(|(unit, _)| chosen[*unit] = false);
        let pilots =
            orders.memory.filter(|_| orders.pilot).map(|memory| self.pilot(units, &chosen, memory, reporter));
        let mut reporting = Reporting::new(self, units, orders.every_trial, reporter).after(&looked.told);
        let mut told = looked.told;
        told.extend(pilots.into_iter().flatten());
        let coordinator = Coordinator::new(self, units, &Orders { chosen: &chosen, ..*orders }, told);
        reporting.called_off(looked.called_off);
        let blocks = (0..units.len()).filter(|unit| units.is_block(*unit)).count();
        thread::scope(|scope| {
            // Should this thread panic, the others must not go on behind it.
            let _end = StopOnPanic(self.stop());
            let (sender, receiver) = mpsc::sync_channel(MOST_MESSAGES);
            for driver in 0..self.executor().parallelism().min(1 + blocks) {
                let (coordinator, sender) = (&coordinator, sender.clone());
                let begun =
                    thread::Builder::new().spawn_scoped(scope, move || coordinator.drive_or_stop(&sender));
                match begun {
                    Ok(_) => {}
                    Err(error) if driver == 0 => panic!("no thread can be started: {error}"),
                    // As many as the system gives: results do not depend on how many there are.
                    Err(_) => break,
                }
            }
            drop(sender);
            let mut pace = MessagePace::default();
            loop {
                match receiver.recv_timeout(TICK) {
                    Ok(message) => {
                        reporting.hear(message);
                        let more = receiver.try_iter().map(|message| reporting.hear(message)).count();
                        pace.heard(1 + more);
                    }
                    Err(RecvTimeoutError::Timeout) => reporting.tell(&Event::Tick),
                    Err(RecvTimeoutError::Disconnected) => break,
                }
                if self.stop().is_requested() {
                    reporting.interrupted(coordinator.call_off());
                }
                reporting.flush();
            }
        });
        if let Some(panic) = coordinator.panicked() {
            resume_unwind(panic);
        }
        if self.stop().is_requested() {
            reporting.interrupted(coordinator.call_off());
        }
        let mut reports = reporting.conclude(started, begun.elapsed());
        for (suite, gates) in looked.gates {
            reports[suite].gates = gates;
        }
        reports
    }
}

/// Where messages come faster than this, s, they are waited for a bunch at a time: to wake a thread for each takes longer than to hear it.
const FAST: Duration = Duration::from_micros(100);
/// So many tell how fast they come.
const COUNTED: usize = 64;
/// How long a bunch is waited for. Fewer come meanwhile than may wait to be heard.
const BUNCH: Duration = Duration::from_millis(1);

/// How fast messages come.
struct MessagePace {
    since: Instant,
    heard: usize,
    is_fast: bool,
}

impl Default for MessagePace {
    fn default() -> Self {
        Self { since: Instant::now(), heard: 0, is_fast: false }
    }
}

impl MessagePace {
    /// So many more were heard; waits where many come.
    fn heard(&mut self, more: usize) {
        self.heard += more;
        if self.heard >= COUNTED {
            let is_fast = self.since.elapsed() < FAST * self.heard as u32;
            *self = Self { is_fast, ..Self::default() };
        }
        if self.is_fast {
            thread::sleep(BUNCH);
        }
    }
}

fn outline(units: &Units, chosen: &[bool]) -> Workload {
    let mut outline = Workload {
        suites: 0,
        left_out: chosen.iter().filter(|chosen| !**chosen).count(),
        ..Workload::default()
    };
    let mut last = None;
    for (unit, _) in chosen.iter().enumerate().filter(|(_, chosen)| **chosen) {
        match units.kind(unit) {
            UnitKind::Recorded => outline.recorded += 1,
            UnitKind::Trial { scenario, .. } => {
                outline.trials += 1;
                outline.runs += scenario.runs();
                outline.certain_runs += scenario.certain_runs();
            }
            UnitKind::Block(_) => outline.blocks += 1,
        }
        let suite = units.suite(unit);
        outline.suites += usize::from(last != Some(suite));
        last = Some(suite);
    }
    outline
}

/// Wishes to stop when it is dropped by a panic.
struct StopOnPanic<'s>(&'s Stop);

impl Drop for StopOnPanic<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.request();
        }
    }
}

/// What a driver does next.
enum Task {
    /// Whatever units are made of runs, as long as they are next.
    Runs,
    Block(usize),
}

/// What is under way, and what is next.
struct Coordinator<'c, 'a> {
    runner: &'c Runner<'a>,
    units: &'c Units<'a>,
    /// Whether some chosen block needs the unit.
    needed: Vec<bool>,
    max_failures: Option<usize>,
    /// How many runs of a unit were told to be done before it began.
    told: HashMap<usize, usize>,
    state: Mutex<State>,
    /// Told when a unit may have become ready, or there is nothing more to wait for.
    changed: Condvar,
}

struct State {
    schedule: UnitSchedule,
    /// Whether a driver sees to the units that are made of runs: one is enough, since the executor makes them side by side.
    running: bool,
    failures: usize,
    /// Results that blocks need.
    kept: HashMap<usize, Arc<Usable>>,
    /// What a driver panicked with, outside of its units: a bug of ours.
    panicked: Option<Box<dyn Any + Send>>,
}

impl<'c, 'a> Coordinator<'c, 'a> {
    fn new(
        runner: &'c Runner<'a>,
        units: &'c Units<'a>,
        orders: &Orders,
        told: HashMap<usize, usize>,
    ) -> Self {
        let mut needed = vec![false; units.len()];
        for (unit, _) in orders.chosen.iter().enumerate().filter(|(_, chosen)| **chosen) {
            units.needs(unit).iter().for_each(|need| needed[*need] = true);
        }
        let needs = |unit| units.needs(unit);
        let schedule = UnitSchedule::new(needs, orders.chosen).first(needs, orders.first);
        let kept = HashMap::new();
        let state = State { schedule, running: false, failures: 0, kept, panicked: None };
        let (max_failures, state) = (orders.max_failures, Mutex::new(state));
        Self { runner, units, needed, max_failures, told, state, changed: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells the drivers that have nothing to do that there may be something.
    fn wake(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.lock());
        self.changed.notify_all();
    }

    /// One driver, and should it panic, nobody waits for what it will not do any more.
    fn drive_or_stop(&self, sender: &SyncSender<Message>) {
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| self.drive(sender))) {
            self.runner.stop().request();
            self.wake(|state| state.panicked = Some(panic));
        }
    }

    fn panicked(&self) -> Option<Box<dyn Any + Send>> {
        self.lock().panicked.take()
    }

    /// One driver: whatever is next, until nothing is left.
    fn drive(&self, sender: &SyncSender<Message>) {
        while let Some(task) = self.next() {
            match task {
                Task::Runs => {
                    let mut units = RunUnits { coordinator: self, sender };
                    run_sequences(self.runner.executor(), &mut units, self.runner.stop());
                    self.wake(|state| state.running = false);
                }
                Task::Block(unit) => {
                    send(sender, Message::Begun(unit));
                    let UnitKind::Block(block) = self.units.kind(unit) else { continue };
                    let relay = Relay { unit, sender: sender.clone() };
                    let (suite, results) = (self.units.suite(unit), self.results(unit));
                    let report = self.runner.block(suite, block, &results, &relay);
                    self.end(unit, UnitReport::Block(report), sender);
                }
            }
        }
    }

    /// What is to be done next, waited for if need be; `None` when there will be nothing.
    fn next(&self) -> Option<Task> {
        let mut state = self.lock();
        loop {
            if self.runner.stop().is_requested() {
                return None;
            }
            match state.schedule.next() {
                Some(unit) if self.units.is_block(unit) => {
                    state.schedule.begin();
                    return Some(Task::Block(unit));
                }
                Some(_) if !state.running => {
                    state.running = true;
                    return Some(Task::Runs);
                }
                None if state.schedule.is_over() => return None,
                _ => {}
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Begins the next unit, if it is one that is made of runs.
    fn begin_runs(&self) -> Option<usize> {
        let mut state = self.lock();
        let next = state.schedule.next().filter(|next| !self.units.is_block(*next))?;
        state.schedule.begin();
        // A block may be next now.
        self.changed.notify_all();
        Some(next)
    }

    /// What the unit needs, out of what was kept.
    fn results(&self, unit: usize) -> EarlierResults {
        let kept: Vec<_> = {
            let state = self.lock();
            self.units.needs(unit).iter().filter_map(|need| state.kept.get(need).cloned()).collect()
        };
        Usable::gather(kept)
    }

    /// Books a unit that is done, with the units that are called off with it, and tells whether that was one failure too many.
    fn end(&self, unit: usize, report: UnitReport, sender: &SyncSender<Message>) {
        let kept = if self.needed[unit] { Usable::of(&self.units.get(unit).work, &report) } else { None };
        let mut state = self.lock();
        let off = state.schedule.end(unit, kept.is_some());
        state.kept.extend(kept.map(|kept| (unit, Arc::new(kept))));
        let mut off: Vec<_> = off.into_iter().map(|(unit, need)| (unit, Off::Need(need))).collect();
        let mut stopping = None;
        if report.standing().is_failure() {
            state.failures += 1;
            if let Some(most) = self.max_failures.filter(|most| state.failures == *most) {
                let rest = state.schedule.call_off();
                // The last one to fail may be the last one of all.
                stopping = (!rest.is_empty()).then_some(Stopping::MaxFail(most));
                off.extend(rest.into_iter().map(|unit| (unit, Off::Stopping(Stopping::MaxFail(most)))));
            }
        }
        drop(state);
        self.changed.notify_all();
        send(sender, Message::Finished { unit, report: Box::new(report), off });
        if let Some(stopping) = stopping {
            send(sender, Message::Stopping(stopping));
        }
    }

    fn call_off(&self) -> Vec<usize> {
        let mut rest = Vec::new();
        self.wake(|state| rest = state.schedule.call_off());
        rest
    }
}

/// Tells what happens. Who hears it is there as long as anybody tells, or has panicked.
fn send(sender: &SyncSender<Message>, message: Message) {
    drop(sender.send(message));
}

/// The units that are made of runs, in the order in which they are next.
struct RunUnits<'s, 'c, 'a> {
    coordinator: &'s Coordinator<'c, 'a>,
    sender: &'s SyncSender<Message>,
}

/// One of them, under way.
struct Under<'s, 'a> {
    unit: usize,
    run: UnitRun<'s, 'a>,
}

impl Sequence for Under<'_, '_> {
    fn runs(&self) -> usize {
        self.run.runs()
    }

    fn job(&mut self, place: JobPlace) -> Job {
        self.run.job(place)
    }

    fn take(&mut self, done: Done) -> std::ops::ControlFlow<()> {
        self.run.take(done)
    }

    fn between(&mut self, taken: usize) -> std::ops::ControlFlow<()> {
        self.run.between(taken)
    }
}

impl<'s, 'c, 'a> Sequences for RunUnits<'s, 'c, 'a> {
    type One = Under<'s, 'a>;

    fn open(&mut self) -> Option<Under<'s, 'a>> {
        let unit = self.coordinator.begin_runs()?;
        let sender = self.sender;
        send(sender, Message::Begun(unit));
        let mut told_before = self.coordinator.told.get(&unit).copied().unwrap_or(0);
        let told = Box::new(move || match told_before.checked_sub(1) {
            Some(left) => told_before = left,
            None => send(sender, Message::RunDone(unit)),
        });
        let run = self.coordinator.runner.begin(self.coordinator.units.get(unit), told);
        Some(Under { unit, run: run.expect("it is no block") })
    }

    fn close(&mut self, Under { unit, run }: Under<'s, 'a>, taken: usize) {
        self.coordinator.end(unit, run.report(taken), self.sender);
    }
}

/// Sends on what a block says about itself.
struct Relay {
    unit: usize,
    sender: SyncSender<Message>,
}

impl BlockProgress for Relay {
    fn evaluated(&self, done: usize, all: usize, value: Option<f64>) {
        send(&self.sender, Message::Evaluated { unit: self.unit, done, all, value, within: None });
    }

    fn evaluated_within(&self, done: usize, all: usize, value: f64, within: (f64, f64)) {
        let (value, within) = (Some(value), Some(within));
        send(&self.sender, Message::Evaluated { unit: self.unit, done, all, value, within });
    }
}
