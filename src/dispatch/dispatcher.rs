//! Workers run units, or help with the runs of a trial, and one thread tells what happens, in order.

use std::any::Any;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use super::kept::Kept;
use super::schedule::Schedule;
use super::unit::{Unit, Work};
use super::workshop::Workshop;
use crate::experiment::{EarlierResults, Progress};
use crate::results::{
    BlockReport, CutBy, Evaluations, Event, Outline, Program, RecordedReport, Reporter, Skip, Standing,
    Stopping, SuiteReport, TrialReport, UnitReport,
};
use crate::run::{SharedTrial, Stop};
use crate::scenario::{Block, Goal};

/// What is to be run, and how.
#[derive(Debug, Clone, Copy)]
pub struct Orders<'o> {
    /// Whether each unit is to run; see [`super::with_needs`].
    pub chosen: &'o [bool],
    /// Units that begin before all others.
    pub first: &'o [usize],
    /// Workers, at least one.
    pub threads: usize,
    /// After so many failures nothing more begins.
    pub max_failures: Option<usize>,
}

/// How often time is told when nothing happens.
const TICK: Duration = Duration::from_millis(100);

/// Runs the chosen units and returns the report of every suite, which names all of its units: those that were not run
/// are skipped with the reason.
pub fn dispatch<'a>(
    workshop: &Workshop<'a>,
    units: &[Unit<'a>],
    orders: &Orders,
    reporter: &mut dyn Reporter,
) -> Vec<SuiteReport> {
    let (started, begun) = (SystemTime::now(), Instant::now());
    reporter.tell(&Event::Begun(&outline(units, orders.chosen)));
    let floor = Floor::new(workshop, units, orders);
    let mut teller = Teller::new(workshop, units, reporter);
    thread::scope(|scope| {
        // Should this thread panic, the workers must not go on behind it.
        let _end = StopOnPanic(workshop.stop());
        let (sender, receiver) = mpsc::channel();
        for worker in 0..orders.threads.max(1) {
            let (floor, sender) = (&floor, sender.clone());
            let begun = thread::Builder::new().spawn_scoped(scope, move || floor.work_or_stop(&sender));
            match begun {
                Ok(_) => {}
                Err(error) if worker == 0 => panic!("no thread can be started: {error}"),
                // As many as the system gives: results do not depend on how many there are.
                Err(_) => break,
            }
        }
        drop(sender);
        loop {
            match receiver.recv_timeout(TICK) {
                Ok(message) => {
                    teller.hear(message);
                    receiver.try_iter().for_each(|message| teller.hear(message));
                }
                Err(RecvTimeoutError::Timeout) => teller.tell(&Event::Tick),
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if workshop.stop().is_requested() {
                teller.interrupted(&floor);
            }
            teller.reporter.flush();
        }
    });
    if let Some(panic) = floor.panicked() {
        resume_unwind(panic);
    }
    if workshop.stop().is_requested() {
        teller.interrupted(&floor);
    }
    let elapsed = begun.elapsed();
    let mut slots = std::mem::take(&mut teller.slots);
    let reports: Vec<_> = (0..workshop.suites().len())
        .map(|suite| suite_report(workshop, units, &mut slots, suite, started, elapsed))
        .collect();
    let requests = workshop.requests();
    reporter.tell(&Event::Ended { reports: &reports, requests, elapsed });
    reporter.flush();
    reports
}

fn outline(units: &[Unit], chosen: &[bool]) -> Outline {
    let mut outline = Outline {
        suites: 0,
        left_out: chosen.iter().filter(|chosen| !**chosen).count(),
        ..Outline::default()
    };
    let mut last = None;
    for (unit, _) in units.iter().zip(chosen).filter(|(_, chosen)| **chosen) {
        match &unit.work {
            Work::Recorded(_) => outline.recorded += 1,
            Work::Trial(trial) => {
                outline.trials += 1;
                outline.runs += unit.runs();
                outline.certain_runs += trial.certain_runs();
            }
            Work::Block(_) => outline.blocks += 1,
        }
        outline.suites += usize::from(last != Some(unit.suite));
        last = Some(unit.suite);
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

/// What workers tell.
enum Message {
    Begun(usize),
    RunDone(usize),
    Evaluated { unit: usize, done: usize, all: usize, value: Option<f64> },
    Finished { unit: usize, report: UnitReport, off: Vec<(usize, Off)> },
    Stopping(Stopping),
}

/// Why a unit will not be run.
enum Off {
    /// It needs that unit, which came to nothing.
    Need(usize),
    Stopping(Stopping),
}

/// What a worker does next.
enum Job<'a> {
    Unit(usize),
    /// One case, by its index, of a trial that another worker has begun.
    Case {
        suite: usize,
        trial: Arc<SharedTrial<'a>>,
        index: usize,
    },
}

/// Where the workers are.
struct Floor<'w, 'a> {
    workshop: &'w Workshop<'a>,
    units: &'w [Unit<'a>],
    /// Whether some chosen block needs the unit.
    needed: Vec<bool>,
    max_failures: Option<usize>,
    state: Mutex<State<'a>>,
    /// Told when a unit may have become ready, a case may be begun, or there is nothing more to wait for.
    changed: Condvar,
}

struct State<'a> {
    schedule: Schedule,
    /// Trials under way, with the index of their suite.
    trials: Vec<(usize, Arc<SharedTrial<'a>>)>,
    failures: usize,
    /// Results that blocks need.
    kept: Vec<Option<Arc<Kept>>>,
    /// What a worker panicked with, outside of its units: a bug of ours.
    panicked: Option<Box<dyn Any + Send>>,
}

impl<'w, 'a> Floor<'w, 'a> {
    fn new(workshop: &'w Workshop<'a>, units: &'w [Unit<'a>], orders: &Orders) -> Self {
        let mut needed = vec![false; units.len()];
        for (unit, _) in units.iter().zip(orders.chosen).filter(|(_, chosen)| **chosen) {
            unit.needs.iter().for_each(|need| needed[*need] = true);
        }
        let needs: Vec<&[usize]> = units.iter().map(|unit| unit.needs.as_slice()).collect();
        let schedule = Schedule::new(&needs, orders.chosen, orders.first);
        let kept = units.iter().map(|_| None).collect();
        Self {
            workshop,
            units,
            needed,
            max_failures: orders.max_failures,
            state: Mutex::new(State { schedule, trials: Vec::new(), failures: 0, kept, panicked: None }),
            changed: Condvar::new(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State<'a>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One worker, and should it panic, nobody waits for what it will not do any more.
    fn work_or_stop(&self, sender: &Sender<Message>) {
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| self.work(sender))) {
            self.workshop.stop().request();
            self.wake(|state| state.panicked = Some(panic));
        }
    }

    fn panicked(&self) -> Option<Box<dyn Any + Send>> {
        self.lock().panicked.take()
    }

    /// One worker: unit after unit until there is none left. Where it would have to wait for one, it helps with the cases
    /// of trials under way.
    fn work(&self, sender: &Sender<Message>) {
        // The receiver lives as long as the workers do.
        let send = |message| drop(sender.send(message));
        while let Some(job) = self.next() {
            let unit = match job {
                Job::Unit(unit) => unit,
                Job::Case { suite, trial, index } => {
                    self.workshop.help(suite, &trial, index);
                    continue;
                }
            };
            send(Message::Begun(unit));
            let report = self.run(unit, sender);
            let (off, stopping) = self.end(unit, &report);
            send(Message::Finished { unit, report, off });
            if let Some(stopping) = stopping {
                send(Message::Stopping(stopping));
            }
        }
    }

    /// What is to be done next, waited for if need be; `None` when there will be nothing.
    fn next(&self) -> Option<Job<'a>> {
        let mut state = self.lock();
        loop {
            if self.workshop.stop().is_requested() {
                return None;
            }
            if let Some(unit) = state.schedule.begin() {
                return Some(Job::Unit(unit));
            }
            for (suite, trial) in &state.trials {
                if let Some(index) = trial.begin() {
                    return Some(Job::Case { suite: *suite, trial: trial.clone(), index });
                }
            }
            if state.schedule.is_over() {
                return None;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Tells the workers that have nothing to do that there may be something.
    fn wake(&self, change: impl FnOnce(&mut State<'a>)) {
        change(&mut self.lock());
        self.changed.notify_all();
    }

    fn run(&self, index: usize, sender: &Sender<Message>) -> UnitReport {
        let unit = &self.units[index];
        match &unit.work {
            Work::Recorded(recorded) => {
                UnitReport::Recorded(self.workshop.recorded(unit.suite, &unit.key, recorded))
            }
            Work::Trial(trial) => {
                let shared = Arc::new(SharedTrial::new(trial));
                self.wake(|state| state.trials.push((unit.suite, shared.clone())));
                let done = || {
                    drop(sender.send(Message::RunDone(index)));
                    // What was taken in makes room for another run.
                    self.wake(|_| ());
                };
                let report = self.workshop.trial(unit.suite, &shared, &done);
                self.lock().trials.retain(|(_, other)| !Arc::ptr_eq(other, &shared));
                UnitReport::Trial(report)
            }
            Work::Block(block) => {
                let relay = Relay { unit: index, sender: sender.clone() };
                UnitReport::Block(self.workshop.block(unit.suite, block, &self.results(unit), &relay))
            }
        }
    }

    /// What the unit needs, out of what was kept.
    fn results(&self, unit: &Unit) -> EarlierResults {
        let kept: Vec<_> = {
            let state = self.lock();
            unit.needs.iter().filter_map(|need| state.kept[*need].clone()).collect()
        };
        Kept::gather(kept)
    }

    /// Books a unit that is done: which units are called off with it, and whether that was one failure too many.
    fn end(&self, unit: usize, report: &UnitReport) -> (Vec<(usize, Off)>, Option<Stopping>) {
        let kept = if self.needed[unit] { Kept::of(&self.units[unit].work, report) } else { None };
        let mut state = self.lock();
        let off = state.schedule.end(unit, kept.is_some());
        state.kept[unit] = kept.map(Arc::new);
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
        self.changed.notify_all();
        (off, stopping)
    }

    fn call_off(&self) -> Vec<usize> {
        let mut rest = Vec::new();
        self.wake(|state| rest = state.schedule.call_off());
        rest
    }
}

/// Sends on what a block says about itself.
struct Relay {
    unit: usize,
    sender: Sender<Message>,
}

impl Progress for Relay {
    fn evaluated(&self, done: usize, all: usize, value: Option<f64>) {
        drop(self.sender.send(Message::Evaluated { unit: self.unit, done, all, value }));
    }
}

/// Hears what workers say, keeps what came of each unit and tells it on.
struct Teller<'t, 'a> {
    workshop: &'t Workshop<'a>,
    units: &'t [Unit<'a>],
    reporter: &'t mut dyn Reporter,
    slots: Vec<Option<UnitReport>>,
    best: HashMap<usize, f64>,
    interrupted: bool,
}

impl<'t, 'a> Teller<'t, 'a> {
    fn new(workshop: &'t Workshop<'a>, units: &'t [Unit<'a>], reporter: &'t mut dyn Reporter) -> Self {
        let slots = units.iter().map(|_| None).collect();
        Self { workshop, units, reporter, slots, best: HashMap::new(), interrupted: false }
    }

    fn tell(&mut self, event: &Event) {
        self.reporter.tell(event);
    }

    fn hear(&mut self, message: Message) {
        match message {
            Message::Begun(unit) => {
                let (key, runs) = (&*self.units[unit].key, self.units[unit].runs());
                self.reporter.tell(&Event::UnitBegun { unit, key, runs });
            }
            Message::RunDone(unit) => self.tell(&Event::RunDone { unit }),
            Message::Evaluated { unit, done, all, value } => {
                let best = self.best(unit, value);
                self.tell(&Event::Evaluated { unit, evaluations: Evaluations { done, all, best } });
            }
            Message::Finished { unit, report, off } => {
                self.finished(unit, report);
                for (unit, off) in off {
                    let reason = self.reason(&off);
                    self.skipped(unit, reason);
                }
            }
            Message::Stopping(stopping) => self.tell(&Event::Stopping(stopping)),
        }
    }

    /// The best value of a block's objective so far.
    fn best(&mut self, unit: usize, value: Option<f64>) -> Option<f64> {
        let goal = match &self.units[unit].work {
            Work::Block(block) => match &**block {
                Block::Search(search) => Some(search.objective.direction),
                Block::Tune(tune) => tune.objectives.first().map(|objective| objective.direction),
                Block::Evaluate(_) | Block::Statement(_) => None,
            },
            Work::Trial(_) | Work::Recorded(_) => None,
        }?;
        if let Some(value) = value {
            let best = self.best.entry(unit).or_insert(value);
            *best = match goal {
                Goal::Minimise => best.min(value),
                Goal::Maximise => best.max(value),
            };
        }
        self.best.get(&unit).copied()
    }

    fn finished(&mut self, unit: usize, report: UnitReport) {
        let suite = self.workshop.identity(self.units[unit].suite);
        self.reporter.tell(&Event::Finished { unit, suite: &suite, report: &report });
        self.slots[unit] = Some(report);
    }

    fn skipped(&mut self, unit: usize, reason: Skip) {
        self.finished(unit, self.workshop.skipped(&self.units[unit], reason));
    }

    fn reason(&self, off: &Off) -> Skip {
        match off {
            Off::Stopping(stopping) => Skip::Stopped(*stopping),
            Off::Need(need) => {
                let standing = self.slots[*need].as_ref().map_or(Standing::Skipped, UnitReport::standing);
                Skip::needs(&self.units[*need].key, standing)
            }
        }
    }

    /// Somebody wishes to stop: said once, and nothing more begins.
    fn interrupted(&mut self, floor: &Floor) {
        if !std::mem::replace(&mut self.interrupted, true) {
            self.tell(&Event::Stopping(Stopping::Interrupted));
        }
        for unit in floor.call_off() {
            let reason = self.reason(&Off::Stopping(Stopping::Interrupted));
            self.skipped(unit, reason);
        }
    }
}

/// All units of a suite; those without a report were not chosen.
fn suite_report<'a>(
    workshop: &Workshop<'a>,
    units: &[Unit<'a>],
    slots: &mut [Option<UnitReport>],
    suite: usize,
    started: SystemTime,
    wall_time: Duration,
) -> SuiteReport {
    let identity = workshop.identity(suite);
    let mut report = SuiteReport {
        identity,
        program: Program::this(),
        started,
        wall_time,
        recorded: Vec::new(),
        trials: Vec::new(),
        blocks: Vec::new(),
        gates: Vec::new(),
        interrupted: false,
    };
    for (unit, slot) in units.iter().zip(slots).filter(|(unit, _)| unit.suite == suite) {
        match slot.take().unwrap_or_else(|| workshop.skipped(unit, Skip::NotSelected)) {
            UnitReport::Recorded(recorded) => report.recorded.push(recorded),
            UnitReport::Trial(trial) => report.trials.push(trial),
            UnitReport::Block(block) => report.blocks.push(block),
        }
    }
    let skips = report.trials.iter().filter_map(TrialReport::skip);
    let skips = skips.chain(report.blocks.iter().filter_map(BlockReport::skip));
    let mut skips = skips.chain(report.recorded.iter().filter_map(RecordedReport::skip));
    report.interrupted = skips.any(|skip| *skip == Skip::Stopped(Stopping::Interrupted))
        || report.standings().any(|one| one == Standing::NotFinished(CutBy::Interrupted));
    report
}
