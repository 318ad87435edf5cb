//! What the terminal shows: a line per unit, failures when they happen, tables and a summary at the end.

mod costs;
mod lines;
mod live;
#[cfg(test)]
mod pilot_tests;
mod pilots;
mod progress;
mod sparkline;
mod status;
mod summary;
mod time_left;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anstyle::Style;

use super::failure::explain;
use super::wording::{remark, trial_warnings};
use crate::console::{Output, stdout};
use results::{
    CutBy, Event, Reporter, Results, Standing, Stopping, SuiteIdentity, UnitReport, Verdict, Workload,
};

use lines::{Bad, Lines};
pub use live::Live;
use progress::{Running, Tally};
pub use status::StatusLevel;

/// Tells people what happens.
pub struct Terminal {
    /// `None` for nowhere.
    out: Option<Output>,
    level: StatusLevel,
    live: Option<Live>,
    /// What takes the place of `live` once all units are over.
    after: Option<Live>,
    lines: Lines,
    begun: Instant,
    looked: Instant,
    tally: Tally,
    running: BTreeMap<usize, Running>,
    /// What did not pass, in order.
    bad: Vec<Bad>,
    /// What is said when all units are done.
    later: Vec<String>,
}

/// How often it is looked whether something has to be redrawn or is slow.
const LOOK: Duration = Duration::from_millis(100);
/// Every time that a unit has taken as long as this it is called slow.
const SLOW: Duration = Duration::from_secs(60);

impl Terminal {
    /// Writes to standard output; `live` draws what is under way in between.
    pub fn new(level: StatusLevel, colour: bool, live: Option<Live>) -> Self {
        Self::to(Some(stdout()), level, colour, live)
    }

    /// Writes nothing; `live` draws what is under way.
    pub fn quiet(live: Option<Live>) -> Self {
        Self::to(None, StatusLevel::None, false, live)
    }

    fn to(out: Option<Output>, level: StatusLevel, colour: bool, live: Option<Live>) -> Self {
        let now = Instant::now();
        Self {
            out,
            level,
            // A row that is not full has no line of its own yet, above which something else could change.
            live: live.filter(|_| level != StatusLevel::Dot),
            after: None,
            lines: Lines::new(colour),
            begun: now,
            looked: now,
            tally: Tally::default(),
            running: BTreeMap::new(),
            bad: Vec::new(),
            later: Vec::new(),
        }
    }

    /// What it shows of a session that is over: a line a unit, what did not pass, tables and the summary.
    pub fn tell_results(&mut self, results: &Results) {
        for suite in &results.suites {
            let recorded = suite.recorded.iter().cloned().map(UnitReport::Recorded);
            let trials = suite.trials.iter().cloned().map(UnitReport::Trial);
            let blocks = suite.blocks.iter().cloned().map(UnitReport::Block);
            for (unit, report) in recorded.chain(trials).chain(blocks).enumerate() {
                self.finish(unit, &suite.identity, &report);
            }
        }
        // Suites of a session are run side by side.
        let elapsed = results.suites.iter().map(|suite| suite.wall_time).max().unwrap_or_default();
        self.lines.end(&self.bad, &results.suites, &results.requests, elapsed);
        self.write();
    }

    /// Draws nothing more of what is under way, and tells nothing of how it ends.
    pub fn give_up(&mut self) {
        if let Some(live) = self.live.take() {
            live.clear();
        }
        self.lines.end_row();
        self.write();
    }

    fn begin(&mut self, outline: &Workload) {
        self.begun = Instant::now();
        self.tally.outline = outline.clone();
        if self.level > StatusLevel::None {
            let line =
                status::line("Starting", status::GOOD, None, &summary::starting(outline), self.lines.colour);
            self.lines.say(&line);
        }
    }

    fn finish(&mut self, unit: usize, suite: &SuiteIdentity, report: &UnitReport) {
        if let Some(running) = self.running.remove(&unit) {
            self.tally.over(unit, &running, self.begun.elapsed());
        }
        self.tally.finish(report);
        let standing = report.standing();
        self.tally.failures += usize::from(standing.is_failure());
        let said = format!("{}{}", report.key(), remark(report));
        let line = status::unit_line(standing, report.wall_time(), &said, self.lines.colour);
        let shown = self.level >= status::level(standing, report.skip());
        if shown {
            self.lines.say(&line);
        }
        if self.level == StatusLevel::Dot {
            let outline = &self.tally.outline;
            let all = outline.recorded + outline.trials + outline.blocks;
            self.lines.mark(status::mark(standing), self.tally.units_done, all);
        }
        if let UnitReport::Trial(trial) = report
            && self.level > StatusLevel::None
        {
            for warning in trial_warnings(trial) {
                let said = format!("{}: {warning}", report.key());
                let line = status::line("WARN", status::DOUBTFUL, None, &said, self.lines.colour);
                match self.level {
                    StatusLevel::Dot => self.later.push(line),
                    _ => self.lines.say(&line),
                }
            }
        }
        // What a gate ended is told with the gate.
        let is_told = matches!(
            standing,
            Standing::Skipped
                | Standing::NotJudged
                | Standing::Found
                | Standing::Judged(Verdict::Passed)
                | Standing::NotFinished(CutBy::GateFailed)
        );
        if !is_told {
            let text = explain(suite, report, self.lines.colour);
            // Of what somebody interrupted the line says all there is.
            let silent = standing == Standing::NotFinished(CutBy::Interrupted);
            let shown = shown.then(|| {
                if silent {
                    return self.lines.count;
                }
                self.lines.gap();
                self.lines.say(&format!("{}\n", text.trim_end()));
                self.lines.count
            });
            self.bad.push(Bad { key: report.key().to_string(), line, text, shown });
        }
    }

    fn stop(&mut self, stopping: Stopping) {
        let said = match stopping {
            Stopping::MaxFail(_) => format!("{stopping}; what has begun comes to its end"),
            Stopping::GateFailed => format!("{stopping}; what is left of its suite is not run"),
            Stopping::Interrupted => "no more runs begin; interrupt again to stop at once".to_string(),
        };
        let line = status::line("Stopping", status::DOUBTFUL, None, &said, self.lines.colour);
        self.lines.say(&line);
    }

    /// Calls slow what is, once a minute.
    fn look_for_slow(&mut self) {
        if self.level < StatusLevel::Slow {
            return;
        }
        let mut lines = Vec::new();
        for running in self.running.values_mut() {
            let elapsed = running.begun.elapsed();
            let times = (elapsed.as_secs_f64() / SLOW.as_secs_f64()) as u32;
            if times > running.slow {
                running.slow = times;
                let said = format!("{}{}", running.key, running.progress());
                lines.push(status::slow_line(SLOW * times, &said, self.lines.colour));
            }
        }
        lines.iter().for_each(|line| self.lines.say(line));
    }

    fn write(&mut self) {
        if self.lines.text.is_empty() {
            return;
        }
        let text = std::mem::take(&mut self.lines.text);
        let Some(out) = self.out else { return };
        let write = || {
            out.styled(&text);
            out.flush();
        };
        match &self.live {
            Some(live) => live.aside(write),
            None => write(),
        }
    }
}

impl Reporter for Terminal {
    fn tell(&mut self, event: &Event) {
        match event {
            Event::Begun(outline) => self.begin(outline),
            Event::UnitBegun { unit, key, runs } => {
                if self.level == StatusLevel::All {
                    let line = status::line("BEGIN", Style::new(), None, key, self.lines.colour);
                    self.lines.say(&line);
                }
                // Blocks have no runs of their own.
                self.tally.begun += usize::from(*runs > 0);
                let made = self.tally.pilots.of(*unit);
                self.running.insert(*unit, Running::new(key, *runs).after(made));
            }
            Event::PilotRun { unit, runs, took } => self.tally.pilots.made(*unit, *runs, *took),
            Event::RunDone { unit } => {
                self.tally.run_done(*unit, self.running.get_mut(unit), self.begun.elapsed());
            }
            Event::Evaluated { unit, evaluations } => {
                if let Some(running) = self.running.get_mut(unit) {
                    running.evaluated(*evaluations, running.begun.elapsed());
                }
            }
            Event::Finished { unit, suite, report, .. } => self.finish(*unit, suite, report),
            Event::Stopping(stopping) => self.stop(*stopping),
            Event::Tick => {}
            Event::Ended { reports, requests, elapsed } => {
                if let Some(live) = self.live.take() {
                    live.clear();
                    self.after = Some(Live::new());
                }
                self.lines.end_row();
                std::mem::take(&mut self.later).iter().for_each(|line| self.lines.say(line));
                self.lines.end(&self.bad, reports, requests, *elapsed);
            }
            Event::Judging(Some(what)) => {
                if let Some(after) = &self.after {
                    after.say(what);
                }
            }
            Event::Judging(None) => {
                if let Some(after) = self.after.take() {
                    after.clear();
                    self.after = Some(Live::new());
                }
            }
        }
    }

    fn flush(&mut self) {
        if self.looked.elapsed() >= LOOK {
            self.looked = Instant::now();
            self.look_for_slow();
            if let Some(live) = &self.live {
                live.draw(self.begun.elapsed(), || {
                    live::panel(&self.tally, &self.running, self.begun.elapsed())
                });
            }
        }
        self.write();
    }
}
