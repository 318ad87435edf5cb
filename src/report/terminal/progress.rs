//! How far everything is that there is to do, and each unit that is under way, and how long it may still take.

use std::time::{Duration, Instant};

use indicatif::HumanDuration;

use results::{Evaluations, UnitReport, Workload};

/// What there is to do and what is done.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub outline: Workload,
    pub units_done: usize,
    pub runs_done: usize,
    pub failures: usize,
    /// Blocks that are over.
    pub blocks_done: usize,
    /// How fast runs come.
    pub pace: Pace,
}

impl Tally {
    /// One more run is done.
    pub fn run_done(&mut self, elapsed: Duration) {
        self.runs_done += 1;
        self.pace.note(elapsed, self.runs_done);
    }

    /// A unit is over: what it did not take of its runs will not come any more.
    pub fn finish(&mut self, report: &UnitReport) {
        self.units_done += 1;
        match report {
            UnitReport::Trial(trial) => {
                let is_whole =
                    trial.skip().is_none() && trial.error().is_none() && trial.stopping().is_none();
                let missing = if is_whole { 0 } else { trial.trial.runs.saturating_sub(trial.made()) };
                let taken = trial.trial.runs - missing;
                self.outline.runs -= missing;
                // Those that it had for certain are now those that it took.
                self.outline.certain_runs =
                    (self.outline.certain_runs + taken).saturating_sub(trial.trial.certain_runs());
            }
            UnitReport::Block(_) => self.blocks_done += 1,
            UnitReport::Recorded(_) => {}
        }
    }

    /// How long everything still takes, as far as that can be said.
    pub fn left<'r>(
        &self,
        running: impl Iterator<Item = &'r Running>,
        elapsed: Duration,
    ) -> Option<TimeLeft> {
        let Workload { runs, certain_runs, blocks, .. } = self.outline;
        let blocks_left = blocks - self.blocks_done.min(blocks);
        let left = (certain_runs.saturating_sub(self.runs_done), runs.saturating_sub(self.runs_done));
        let mut parts: Vec<TimeLeft> = Vec::new();
        if left.1 > 0 {
            parts.push(self.pace.left(elapsed, left)?);
        }
        let blocks: Vec<TimeLeft> = running.filter_map(|one| one.left(one.begun.elapsed())).collect();
        // Of a block that has not begun, or of which nothing is known yet, nobody knows how long it takes.
        let is_known = blocks.len() >= blocks_left;
        parts.extend(blocks);
        let least = parts.iter().map(|one| one.least).max_by(f64::total_cmp)?;
        let most = parts.iter().map(|one| one.most).reduce(|one, other| Some(one?.max(other?)))?;
        Some(TimeLeft { least, most: most.filter(|_| is_known) })
    }
}

/// A unit under way.
#[derive(Debug)]
pub(super) struct Running {
    pub key: String,
    pub begun: Instant,
    pub runs: usize,
    pub runs_done: usize,
    pub evaluations: Option<Evaluations>,
    /// How often it was called slow.
    pub slow: u32,
    /// How fast evaluations come.
    pace: Pace,
}

impl Running {
    pub fn new(key: &str, runs: usize) -> Self {
        let begun = Instant::now();
        Self {
            key: key.to_string(),
            begun,
            runs,
            runs_done: 0,
            evaluations: None,
            slow: 0,
            pace: Pace::default(),
        }
    }

    /// A block has got further, so long after it began.
    pub fn evaluated(&mut self, evaluations: Evaluations, elapsed: Duration) {
        self.pace.note(elapsed, evaluations.done);
        self.evaluations = Some(evaluations);
    }

    /// How long a block still takes. It may end before it has used up what it may, and later evaluations take longer than early ones.
    fn left(&self, elapsed: Duration) -> Option<TimeLeft> {
        let Evaluations { done, all, .. } = self.evaluations?;
        self.pace.between(elapsed, all.saturating_sub(done))
    }

    /// How far it is, to be appended to its key.
    pub fn progress(&self) -> String {
        let left = self.left(self.begun.elapsed()).map_or_else(String::new, TimeLeft::in_words);
        match self.evaluations {
            Some(Evaluations { done, all, best: Some(value), within: Some((low, high)) }) => {
                let [value, low, high] = [value, low, high].map(|one| scenario::significant(one, 2));
                format!(": {done} of {all} runs, so far {value} [{low}, {high}]{left}")
            }
            Some(Evaluations { done, all, best, .. }) => {
                let best = best.map(|best| format!(", best {}", scenario::significant(best, 4)));
                format!(": {done} of {all} evaluations{}{left}", best.unwrap_or_default())
            }
            None if self.runs > 1 => format!(": {} of {} runs", self.runs_done, self.runs),
            None => String::new(),
        }
    }
}

/// How long something still takes, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeLeft {
    pub least: f64,
    /// `None` where nobody knows.
    pub most: Option<f64>,
}

impl TimeLeft {
    /// To be appended: `, 9 seconds left`, `, 2 minutes to 5 minutes left`.
    pub fn in_words(self) -> String {
        let words =
            |seconds: f64| HumanDuration(Duration::from_secs_f64(seconds.clamp(0.0, 1e9))).to_string();
        let least = words(self.least);
        match self.most.map(words) {
            None => format!(", more than {least} left"),
            Some(most) if most == least => format!(", {least} left"),
            Some(most) => format!(", {least} to {most} left"),
        }
    }
}

/// When how much was done: how fast it goes. It knows no clock.
#[derive(Debug, Default)]
pub(super) struct Pace {
    /// Times (s) with what was done by then, both rising.
    notes: Vec<(f64, usize)>,
}

/// So many notes are kept: of more, every second one.
const NOTES: usize = 256;
/// Nothing is said of what is left before, s.
const PATIENCE: f64 = 1.0;
/// So much has to be done of late before the pace is that of late alone.
const ENOUGH: usize = 4;

/// How much is done in a second.
struct Rates {
    /// Since the beginning.
    whole: f64,
    /// In the later half of the time.
    late: f64,
    /// How much was done in that.
    late_done: usize,
}

impl Pace {
    /// So much was done by then.
    pub fn note(&mut self, elapsed: Duration, done: usize) {
        let elapsed = elapsed.as_secs_f64();
        // Notes that are nearer to each other than a part of the time so far say nothing more.
        if self.notes.last().is_some_and(|(last, _)| elapsed - last < elapsed / NOTES as f64) {
            return;
        }
        self.notes.push((elapsed, done));
        if self.notes.len() > 2 * NOTES {
            let mut number = 0;
            self.notes.retain(|_| {
                number += 1;
                number % 2 == 0
            });
        }
    }

    /// How fast it went until now, with `done` done.
    fn rates(&self, elapsed: Duration, done: usize) -> Option<Rates> {
        let elapsed = elapsed.as_secs_f64();
        if done == 0 || elapsed < PATIENCE {
            return None;
        }
        let before = self.notes.partition_point(|(time, _)| *time <= elapsed / 2.0);
        let (from, done_then) = before.checked_sub(1).map_or((0.0, 0), |note| self.notes[note]);
        let late_done = done.saturating_sub(done_then);
        Some(Rates { whole: done as f64 / elapsed, late: late_done as f64 / (elapsed - from), late_done })
    }

    /// What was done at the last note.
    fn done(&self) -> usize {
        self.notes.last().map_or(0, |(_, done)| *done)
    }

    /// How long it takes until at least and at most so much `left` is done, at the pace of late: what came before, such as starting
    /// programs or warming up, does not come again.
    pub fn left(&self, elapsed: Duration, (least, most): (usize, usize)) -> Option<TimeLeft> {
        let Rates { whole, late, late_done } = self.rates(elapsed, self.done())?;
        let pace = if late_done >= ENOUGH { late } else { whole };
        (most > 0).then(|| TimeLeft { least: least as f64 / pace, most: Some(most as f64 / pace) })
    }

    /// How long it takes until so much `left` is done, between the pace of all the time and that of late.
    pub fn between(&self, elapsed: Duration, left: usize) -> Option<TimeLeft> {
        let Rates { whole, late, .. } = self.rates(elapsed, self.done())?;
        let most = (late > 0.0).then(|| left as f64 / whole.min(late));
        (left > 0).then(|| TimeLeft { least: left as f64 / whole.max(late), most })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Units that take so long each (s), one after the other; what is left is asked after the first `asked` s. With what it took in truth.
    fn asked(units: &[f64], asked: f64) -> (Option<TimeLeft>, f64) {
        let (mut pace, mut time, mut done) = (Pace::default(), 0.0, 0);
        for unit in units {
            if time + unit > asked {
                break;
            }
            time += unit;
            done += 1;
            pace.note(Duration::from_secs_f64(time), done);
        }
        let left = units.len() - done;
        (pace.left(Duration::from_secs_f64(asked), (left, left)), units.iter().sum::<f64>() - asked)
    }

    fn is_right(units: &[f64], at: f64) {
        let (said, truth) = asked(units, at);
        let said = said.expect("something is said");
        assert_eq!(Some(said.least), said.most, "of a fixed number it is one time");
        let error = (said.least - truth).abs() / truth;
        assert!(error < 0.3, "at {at} s: {} s, in truth {truth} s", said.least);
    }

    #[test]
    fn a_steady_pace_is_found() {
        let units = vec![0.05; 2000];
        for at in [2.0, 10.0, 50.0, 90.0] {
            is_right(&units, at);
        }
        // Slow units, few of which are done after ten seconds.
        is_right(&[3.0; 40], 10.0);
    }

    /// Six seconds pass before the first run is done.
    #[test]
    fn a_slow_start_is_forgotten() {
        let units: Vec<f64> = [6.0].into_iter().chain(vec![0.02; 3000]).collect();
        for at in [13.0, 20.0, 40.0, 60.0] {
            is_right(&units, at);
        }
        let (said, truth) = asked(&units, 8.0);
        assert!(said.unwrap().least > truth, "until then it is thought to take longer, not shorter");
    }

    #[test]
    fn uneven_units_are_taken_together() {
        let units: Vec<f64> = (0..4000).map(|unit| if unit % 7 == 0 { 0.1 } else { 0.005 }).collect();
        for at in [10.0, 30.0, 50.0] {
            is_right(&units, at);
        }
        // Units that become dearer: what is said follows.
        let units: Vec<f64> = vec![0.01; 1000].into_iter().chain(vec![0.05; 1500]).collect();
        for at in [35.0, 60.0] {
            is_right(&units, at);
        }
    }

    #[test]
    fn what_is_left_is_not_guessed_from_nothing() {
        let pace = Pace::default();
        assert_eq!(pace.left(Duration::from_secs(9), (10, 10)), None);
        let mut pace = Pace::default();
        pace.note(Duration::from_millis(20), 5);
        assert_eq!(pace.left(Duration::from_millis(20), (5, 5)), None, "too early");
        assert_eq!(pace.left(Duration::from_secs(9), (0, 0)), None, "nothing is left");
        assert!(pace.left(Duration::from_secs(9), (5, 5)).is_some());
    }

    #[test]
    fn an_open_number_of_runs_takes_between_two_times() {
        let mut pace = Pace::default();
        (1..=100).for_each(|done| pace.note(Duration::from_millis(100 * done), done as usize));
        let said = pace.left(Duration::from_secs(10), (20, 300)).unwrap();
        assert!((said.least - 2.0).abs() < 0.1 && (said.most.unwrap() - 30.0).abs() < 1.0, "{said:?}");
        assert_eq!(said.in_words(), ", 2 seconds to 30 seconds left");
        // Those that there are for certain may all be done.
        assert_eq!(pace.left(Duration::from_secs(10), (0, 300)).unwrap().least, 0.0);
    }

    /// Later evaluations of a search take longer: what is left lies between both paces, and beyond where nothing comes any more.
    #[test]
    fn a_search_that_slows_down_takes_between_two_times() {
        let mut pace = Pace::default();
        let mut time = 0.0;
        for done in 1..=40 {
            time += 0.1 + 0.02 * done as f64;
            pace.note(Duration::from_secs_f64(time), done);
        }
        let truth: f64 = (41..=48).map(|done| 0.1 + 0.02 * f64::from(done)).sum();
        let said = pace.between(Duration::from_secs_f64(time), 8).unwrap();
        assert!(said.least < truth && said.least < said.most.unwrap(), "{said:?} {truth}");
        let stalled = pace.between(Duration::from_secs_f64(10.0 * time), 8).unwrap();
        assert!(stalled.most.is_none() && stalled.in_words().starts_with(", more than "), "{stalled:?}");
    }

    #[test]
    fn long_sessions_keep_few_notes() {
        let mut pace = Pace::default();
        (1..=1_000_000_usize).for_each(|done| pace.note(Duration::from_micros(100 * done as u64), done));
        assert!(pace.notes.len() <= 2 * NOTES, "{}", pace.notes.len());
        let said = pace.left(Duration::from_secs(100), (10_000, 10_000)).unwrap();
        assert!((said.least - 1.0).abs() < 0.05, "{said:?}");
    }
}
