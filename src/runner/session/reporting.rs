//! What happens, told to a reporter in order and kept for the reports of the suites.

use std::collections::{BTreeMap, HashMap};
use std::time::{Duration, SystemTime};

use super::shared::Runner;
use super::tested_programs::tested_controllers;
use super::trials::KeptTrials;
use super::unit::{UnitKind, Units, Work};
use crate::plan::people_used;
use results::{
    Cut, CutBy, Evaluations, Event, Program, Reporter, Skip, Standing, Stopping, SuiteReport, UnitReport,
};
use scenario::{Block, Goal, Suite};

/// What is told while units run.
pub enum Message {
    Begun(usize),
    RunDone(usize),
    Evaluated { unit: usize, done: usize, all: usize, value: Option<f64>, within: Option<(f64, f64)> },
    Finished { unit: usize, report: Box<UnitReport>, off: Vec<(usize, Off)> },
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
    units: &'t Units<'a>,
    reporter: &'t mut dyn Reporter,
    /// One per suite.
    trials: Vec<KeptTrials<'a>>,
    /// All other units.
    others: BTreeMap<usize, UnitReport>,
    best: HashMap<usize, f64>,
    interrupted: bool,
    /// How many runs of a unit were made before it began.
    made_before: HashMap<usize, usize>,
}

/// Whether what is judged at the end looks at each trial of a suite.
fn needs_every_trial(suite: &Suite) -> bool {
    !suite.gates.is_empty() || !suite.ratings.is_empty()
}

impl<'t, 'a> Reporting<'t, 'a> {
    /// Keeps `every` trial, or of suites whose gates and ratings do not need each of them what a summary needs.
    pub fn new(
        runner: &'t Runner<'a>,
        units: &'t Units<'a>,
        every: bool,
        reporter: &'t mut dyn Reporter,
    ) -> Self {
        let suites = runner.suites().iter();
        let trials = suites.map(|one| KeptTrials::new(&one.plan, every || needs_every_trial(&one.suite)));
        Self {
            runner,
            units,
            reporter,
            trials: trials.collect(),
            others: BTreeMap::new(),
            best: HashMap::new(),
            interrupted: false,
            made_before: HashMap::new(),
        }
    }

    /// With units of which so many runs were made before they began.
    pub fn after(self, made: &HashMap<usize, usize>) -> Self {
        Self { made_before: made.clone(), ..self }
    }

    pub fn tell(&mut self, event: &Event) {
        self.reporter.tell(event);
    }

    pub fn hear(&mut self, message: Message) {
        match message {
            Message::Begun(unit) => {
                let (key, runs) = (&*self.units.key(unit), self.units.runs(unit));
                self.reporter.tell(&Event::UnitBegun { unit, key, runs });
            }
            Message::RunDone(unit) => self.tell(&Event::RunDone { unit }),
            Message::Evaluated { unit, done, all, value, within } => {
                let best = self.best(unit, value);
                self.tell(&Event::Evaluated { unit, evaluations: Evaluations { done, all, best, within } });
            }
            Message::Finished { unit, report, off } => {
                self.finished(unit, *report);
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
        let goal = match self.units.kind(unit) {
            UnitKind::Block(block) => match &**block {
                Block::Search(search) => Some(search.objective.direction),
                Block::Tune(tune) => tune.objectives.first().map(|objective| objective.direction),
                Block::Evaluate(_) | Block::Calibrate(_) | Block::Statement(_) => None,
                // Not the best, but the estimate so far.
                Block::Estimate(_) => return value,
            },
            UnitKind::Trial { .. } | UnitKind::Recorded => None,
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
        let suite = self.units.suite(unit);
        let identity = self.runner.identity(suite);
        let requests = self.runner.requests();
        self.reporter.tell(&Event::Finished { unit, suite: &identity, report: &report, requests });
        match (report, self.units.kind(unit)) {
            (UnitReport::Trial(trial), UnitKind::Trial { place, .. }) => {
                self.trials[suite].take(place, trial)
            }
            (report, _) => {
                self.others.insert(unit, report);
            }
        }
    }

    fn skipped(&mut self, unit: usize, reason: Skip) {
        self.finished(unit, self.runner.skipped(&self.units.get(unit), reason));
    }

    fn reason(&self, off: &Off) -> Skip {
        match off {
            Off::Stopping(stopping) => Skip::Stopped(*stopping),
            Off::Need(need) => {
                let standing = match self.units.kind(*need) {
                    UnitKind::Trial { place, .. } => self.trials[self.units.suite(*need)].standing(place),
                    _ => self.others.get(need).map_or(Standing::Skipped, UnitReport::standing),
                };
                Skip::needs(&self.units.key(*need), standing)
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
            let made = self.made_before.get(&unit).copied().unwrap_or(0);
            match self.units.get(unit).work {
                Work::Trial(trial) if made > 0 => {
                    let cut = Cut::Trial { finished: made, runs: trial.cases.len() };
                    self.finished(unit, Runner::cut_off(&trial, Vec::new(), cut));
                }
                _ => {
                    let reason = self.reason(&Off::Stopping(Stopping::Interrupted));
                    self.skipped(unit, reason);
                }
            }
        }
    }

    /// A gate has failed before all runs were made, so that these units will not be run, or no further.
    pub fn called_off(&mut self, units: Vec<(usize, Option<UnitReport>)>) {
        if !units.is_empty() {
            self.tell(&Event::Stopping(Stopping::GateFailed));
        }
        for (unit, report) in units {
            match report {
                Some(report) => self.finished(unit, report),
                None => {
                    let reason = self.reason(&Off::Stopping(Stopping::GateFailed));
                    self.skipped(unit, reason);
                }
            }
        }
    }

    /// The reports of all suites, at the end.
    pub fn conclude(mut self, started: SystemTime, elapsed: Duration) -> Vec<SuiteReport> {
        let runner = self.runner;
        let kept = std::mem::take(&mut self.trials);
        let mut reports: Vec<_> = kept
            .into_iter()
            .enumerate()
            .map(|(suite, trials)| self.suite_report(suite, trials, started, elapsed))
            .collect();
        for unit in self.units.others() {
            let report = &mut reports[self.units.suite(unit)];
            let what = self.others.remove(&unit);
            match what.unwrap_or_else(|| runner.skipped(&self.units.get(unit), Skip::NotSelected)) {
                UnitReport::Recorded(recorded) => report.recorded.push(recorded),
                UnitReport::Trial(trial) => report.trials.push(trial),
                UnitReport::Block(block) => report.blocks.push(block),
            }
        }
        for report in &mut reports {
            let interrupted = report.skips().any(|skip| *skip == Skip::Stopped(Stopping::Interrupted))
                || report.standings().any(|one| one == Standing::NotFinished(CutBy::Interrupted));
            report.interrupted = interrupted;
        }
        self.tell(&Event::Ended { reports: &reports, requests: runner.requests(), elapsed });
        self.flush();
        reports
    }

    /// The trials of a suite; those without a report were not chosen.
    fn suite_report(
        &self,
        suite: usize,
        trials: KeptTrials<'a>,
        started: SystemTime,
        wall_time: Duration,
    ) -> SuiteReport {
        let skipped = |place| {
            let unit = self.units.of_trial(suite, place);
            match self.runner.skipped(&self.units.get(unit), Skip::NotSelected) {
                UnitReport::Trial(trial) => trial,
                UnitReport::Recorded(_) | UnitReport::Block(_) => unreachable!("it is a trial"),
            }
        };
        let (trials, summary) = trials.conclude(skipped);
        SuiteReport {
            identity: self.runner.identity(suite),
            program: Program::this(),
            started,
            wall_time,
            recorded: Vec::new(),
            trials,
            summary,
            blocks: Vec::new(),
            controllers: tested_controllers(&self.runner.suites()[suite].suite),
            people: people_used(
                &self.runner.suites()[suite].suite,
                &self.runner.suites()[suite].plan.populations,
            ),
            gates: Vec::new(),
            ratings: Vec::new(),
            interrupted: false,
        }
    }
}
