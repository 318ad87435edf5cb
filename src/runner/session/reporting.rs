//! What happens, told to a reporter in order and kept for the reports of the suites.

use std::collections::HashMap;
use std::time::{Duration, SystemTime};

use super::shared::Runner;
use super::unit::{Unit, Work};
use results::{
    BlockReport, CutBy, Evaluations, Event, Program, RecordedReport, Reporter, Skip, Standing, Stopping,
    SuiteReport, TrialReport, UnitReport,
};
use scenario::{Block, Goal};

/// What is told while units run.
pub enum Message {
    Begun(usize),
    RunDone(usize),
    Evaluated { unit: usize, done: usize, all: usize, value: Option<f64> },
    Finished { unit: usize, report: UnitReport, off: Vec<(usize, Off)> },
    Stopping(Stopping),
}

/// Why a unit will not be run.
pub enum Off {
    /// It needs that unit, which came to nothing.
    Need(usize),
    Stopping(Stopping),
}

/// Hears what is told, keeps what came of each unit and tells it on.
pub struct Reporting<'t, 'a> {
    runner: &'t Runner<'a>,
    units: &'t [Unit<'a>],
    reporter: &'t mut dyn Reporter,
    slots: Vec<Option<UnitReport>>,
    best: HashMap<usize, f64>,
    interrupted: bool,
}

impl<'t, 'a> Reporting<'t, 'a> {
    pub fn new(runner: &'t Runner<'a>, units: &'t [Unit<'a>], reporter: &'t mut dyn Reporter) -> Self {
        let slots = units.iter().map(|_| None).collect();
        Self { runner, units, reporter, slots, best: HashMap::new(), interrupted: false }
    }

    pub fn tell(&mut self, event: &Event) {
        self.reporter.tell(event);
    }

    pub fn hear(&mut self, message: Message) {
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
        let suite = self.runner.identity(self.units[unit].suite);
        self.reporter.tell(&Event::Finished { unit, suite: &suite, report: &report });
        self.slots[unit] = Some(report);
    }

    fn skipped(&mut self, unit: usize, reason: Skip) {
        self.finished(unit, self.runner.skipped(&self.units[unit], reason));
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

    pub fn flush(&mut self) {
        self.reporter.flush();
    }

    /// Somebody wishes to stop, so that these units will not be run.
    pub fn interrupted(&mut self, called_off: Vec<usize>) {
        if !std::mem::replace(&mut self.interrupted, true) {
            self.tell(&Event::Stopping(Stopping::Interrupted));
        }
        for unit in called_off {
            let reason = self.reason(&Off::Stopping(Stopping::Interrupted));
            self.skipped(unit, reason);
        }
    }

    /// The reports of all suites, at the end.
    pub fn conclude(mut self, started: SystemTime, elapsed: Duration) -> Vec<SuiteReport> {
        let mut slots = std::mem::take(&mut self.slots);
        let (runner, units) = (self.runner, self.units);
        let reports: Vec<_> = (0..runner.suites().len())
            .map(|suite| suite_report(runner, units, &mut slots, suite, started, elapsed))
            .collect();
        self.tell(&Event::Ended { reports: &reports, requests: runner.requests(), elapsed });
        self.flush();
        reports
    }
}

/// All units of a suite; those without a report were not chosen.
fn suite_report<'a>(
    runner: &Runner<'a>,
    units: &[Unit<'a>],
    slots: &mut [Option<UnitReport>],
    suite: usize,
    started: SystemTime,
    wall_time: Duration,
) -> SuiteReport {
    let identity = runner.identity(suite);
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
        match slot.take().unwrap_or_else(|| runner.skipped(unit, Skip::NotSelected)) {
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
