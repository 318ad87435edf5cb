//! How far everything is that there is to do, and each unit that is under way, and how long it may still take.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::costs::Costs;
use super::pilots::{Pilots, UnderWay};
use super::sparkline::sparkline;
use super::time_left::TimeLeft;
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
    /// Trials and runs that failed before that have begun.
    pub begun: usize,
    /// What runs cost.
    pub costs: Costs,
    /// What runs took that were made before their trials began.
    pub pilots: Pilots,
}

impl Tally {
    /// One more run of a unit is done, which is under way or has yet to begin.
    pub fn run_done(&mut self, unit: usize, running: Option<&mut Running>, elapsed: Duration) {
        self.runs_done += 1;
        let cost = self.costs.run_done(elapsed);
        if let Some(running) = running {
            self.pilots.begin(unit);
            running.run_done(cost);
        }
    }

    /// A unit is no more under way.
    pub fn over(&mut self, unit: usize, running: &Running, elapsed: Duration) {
        let cost = running.cost();
        self.pilots.over(unit, running.runs_done, cost);
        if let Some(cost) = cost {
            self.costs.trial_over(elapsed, cost);
        }
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
    pub fn left(&self, running: &BTreeMap<usize, Running>, elapsed: Duration) -> Option<TimeLeft> {
        let Workload { runs, certain_runs, blocks, .. } = self.outline;
        let blocks_left = blocks - self.blocks_done.min(blocks);
        let left = (certain_runs.saturating_sub(self.runs_done), runs.saturating_sub(self.runs_done));
        let mut parts: Vec<TimeLeft> = Vec::new();
        if left.1 > 0 {
            parts.push(self.runs_left(running, elapsed, left)?);
        }
        let blocks: Vec<TimeLeft> =
            running.values().filter_map(|one| one.left(one.begun.elapsed())).collect();
        // Of a block that has not begun, or of which nothing is known yet, nobody knows how long it takes.
        let is_known = blocks.len() >= blocks_left;
        parts.extend(blocks);
        let least = parts.iter().map(|one| one.least).max_by(f64::total_cmp)?;
        let most = parts.iter().map(|one| one.most).reduce(|one, other| Some(one?.max(other?)))?;
        Some(TimeLeft { least, most: most.filter(|_| is_known) })
    }

    /// How long `left` runs take, at least and at most: those of trials under way at what their runs cost, those of others at what trials cost
    /// so far.
    fn runs_left(
        &self,
        running: &BTreeMap<usize, Running>,
        elapsed: Duration,
        (least, most): (usize, usize),
    ) -> Option<TimeLeft> {
        if self.runs_done == 0 || elapsed.as_secs_f64() < PATIENCE {
            return None;
        }
        let known: Vec<(usize, f64)> =
            running.values().filter_map(|one| Some((one.runs_left(), one.cost()?))).collect();
        let known_runs: usize = known.iter().map(|(runs, _)| runs).sum();
        let known_time: f64 = known.iter().map(|(runs, cost)| *runs as f64 * cost).sum();
        let trials = (self.outline.trials + self.outline.recorded).saturating_sub(self.begun)
            + running.values().filter(|one| one.runs > 0 && one.cost().is_none()).count();
        if !self.pilots.is_empty() {
            return self.left_by_pilots(running, trials, (least, most));
        }
        let costs: Vec<f64> = known.iter().map(|(_, cost)| *cost).collect();
        // Where it is open how many there are, it may be those under way that end.
        let open = most.saturating_sub(least);
        let (certain, possible) = (known_runs.saturating_sub(open), most.saturating_sub(known_runs));
        let own = TimeLeft {
            least: known_time * certain as f64 / known_runs.max(1) as f64,
            most: Some(known_time),
        };
        if possible == 0 {
            return Some(own);
        }
        let others = least.saturating_sub(known_runs).min(possible);
        let unbegun = self.costs.unbegun(elapsed, &costs, trials, (others, possible));
        Some(TimeLeft { least: own.least + unbegun.least, most: unbegun.most.map(|most| known_time + most) })
    }

    /// The same where pilot runs were made; so many `trials` have yet to begin.
    fn left_by_pilots(
        &self,
        running: &BTreeMap<usize, Running>,
        trials: usize,
        (least, most): (usize, usize),
    ) -> Option<TimeLeft> {
        let under_way = running.iter().filter_map(|(unit, one)| {
            Some(UnderWay { unit: *unit, done: one.runs_done, left: one.runs_left(), cost: one.cost()? })
        });
        let under_way: Vec<UnderWay> = under_way.collect();
        let known = under_way.iter().map(|one| one.left).sum::<usize>() + self.pilots.runs_ahead();
        let others = trials.saturating_sub(self.pilots.trials_ahead());
        let left = self.pilots.left(&under_way, others, most.saturating_sub(known))?;
        // Where it is open how many there are, it may be any that end.
        Some(TimeLeft { least: left.least * least as f64 / most as f64, ..left })
    }
}

/// A unit under way.
#[derive(Debug)]
pub(super) struct Running {
    pub key: String,
    pub begun: Instant,
    pub runs: usize,
    pub runs_done: usize,
    /// Pilot runs, which are not among those.
    made_before: usize,
    pub evaluations: Option<Evaluations>,
    /// The best value after each evaluation; of many, after every second one, and so on.
    best: Vec<f64>,
    /// How often it was called slow.
    pub slow: u32,
    /// How fast evaluations come, or runs in the time that was counted towards it.
    pace: Pace,
    /// That time, s.
    spent: f64,
}

impl Running {
    pub fn new(key: &str, runs: usize) -> Self {
        let begun = Instant::now();
        Self {
            key: key.to_string(),
            begun,
            runs,
            runs_done: 0,
            made_before: 0,
            evaluations: None,
            best: Vec::new(),
            slow: 0,
            pace: Pace::default(),
            spent: 0.0,
        }
    }

    /// After so many pilot runs.
    pub fn after(self, made_before: usize) -> Self {
        Self { made_before, ..self }
    }

    /// One more run is done, at this cost, s.
    fn run_done(&mut self, cost: f64) {
        self.runs_done += 1;
        self.spent += cost;
        self.pace.note(Duration::from_secs_f64(self.spent), self.runs_done);
    }

    fn runs_left(&self) -> usize {
        self.runs.saturating_sub(self.runs_done + self.made_before)
    }

    /// What a run of it costs, if one is done, s.
    fn cost(&self) -> Option<f64> {
        (self.runs_done > 0).then(|| self.pace.cost(self.spent, self.runs_done))
    }

    /// A block has got further, so long after it began.
    pub fn evaluated(&mut self, evaluations: Evaluations, elapsed: Duration) {
        self.pace.note(elapsed, evaluations.done);
        self.best.extend(evaluations.best);
        if self.best.len() > 2 * NOTES {
            self.best = self.best.iter().skip(1).step_by(2).copied().collect();
        }
        self.evaluations = Some(evaluations);
    }

    /// How long a block still takes. It may end before it has used up what it may, and later evaluations take longer than early ones.
    fn left(&self, elapsed: Duration) -> Option<TimeLeft> {
        let Evaluations { done, all, .. } = self.evaluations?;
        self.pace.between(elapsed, all.saturating_sub(done))
    }

    /// How its best value went, or its estimate, to be appended; nothing while there is nothing to see.
    pub fn course(&self) -> String {
        let line = sparkline(&self.best, COURSE);
        if line.is_empty() { line } else { format!(" {line}") }
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
            None if self.runs > 1 => format!(": {} of {} runs", self.runs_done + self.made_before, self.runs),
            None => String::new(),
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
/// Columns of how a best value went.
const COURSE: usize = 12;
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
        Some(self.rates_of(elapsed, done))
    }

    fn rates_of(&self, elapsed: f64, done: usize) -> Rates {
        let before = self.notes.partition_point(|(time, _)| *time <= elapsed / 2.0);
        let (from, done_then) = before.checked_sub(1).map_or((0.0, 0), |note| self.notes[note]);
        let late_done = done.saturating_sub(done_then);
        Rates { whole: done as f64 / elapsed, late: late_done as f64 / (elapsed - from), late_done }
    }

    /// What was done at the last note.
    fn done(&self) -> usize {
        self.notes.last().map_or(0, |(_, done)| *done)
    }

    /// What one costs of late, where enough was done of late, s: what came before, such as starting programs or warming up, does not come
    /// again. `done` were done in `spent` s.
    fn cost(&self, spent: f64, done: usize) -> f64 {
        let Rates { whole, late, late_done } = self.rates_of(spent, done);
        1.0 / if late_done >= ENOUGH { late } else { whole }
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

    /// Trials of runs that take so long each (s), one after the other; what is left is asked after the first `asked` s. With what it took in
    /// truth.
    fn asked(trials: &[Vec<f64>], asked: f64) -> (Option<TimeLeft>, f64) {
        let runs = trials.iter().map(Vec::len).sum();
        let outline = Workload { trials: trials.len(), runs, certain_runs: runs, ..Workload::default() };
        let mut tally = Tally { outline, ..Tally::default() };
        let (mut time, mut under_way) = (0.0, BTreeMap::new());
        'all: for (unit, runs) in trials.iter().enumerate() {
            tally.begun += 1;
            let mut running = Running::new("a", runs.len());
            for run in runs {
                if time + run > asked {
                    under_way.insert(unit, running);
                    break 'all;
                }
                time += run;
                tally.run_done(unit, Some(&mut running), Duration::from_secs_f64(time));
            }
            tally.over(unit, &running, Duration::from_secs_f64(time));
        }
        let said = tally.left(&under_way, Duration::from_secs_f64(asked));
        (said, trials.iter().flatten().sum::<f64>() - asked)
    }

    /// One time, within 30 % of the truth.
    fn is_right(trials: &[Vec<f64>], at: f64) {
        let (said, truth) = asked(trials, at);
        let said = said.expect("something is said");
        assert!(said.is_one(), "at {at} s: {said:?}, in truth {truth} s");
        let error = (said.middle() - truth).abs() / truth;
        assert!(error < 0.3, "at {at} s: {said:?}, in truth {truth} s");
    }

    /// A range, or what it takes at least, with the truth in it.
    fn holds(trials: &[Vec<f64>], at: f64) {
        let (said, truth) = asked(trials, at);
        let said = said.expect("something is said");
        let holds = said.least <= truth && said.most.is_none_or(|most| most >= truth);
        assert!(holds, "at {at} s: {said:?}, in truth {truth} s");
    }

    fn of_one_trial(runs: Vec<f64>) -> Vec<Vec<f64>> {
        vec![runs]
    }

    #[test]
    fn a_steady_pace_is_found() {
        let trials = of_one_trial(vec![0.05; 2000]);
        for at in [2.0, 10.0, 50.0, 90.0] {
            is_right(&trials, at);
        }
        // Slow ones, few of which are done after ten seconds.
        is_right(&of_one_trial(vec![3.0; 40]), 10.0);
        // Many trials of one run.
        let trials = vec![vec![0.05]; 2000];
        for at in [2.0, 10.0, 50.0, 90.0] {
            is_right(&trials, at);
        }
    }

    /// Six seconds pass before the first run is done.
    #[test]
    fn a_slow_start_is_forgotten() {
        let trials = of_one_trial([6.0].into_iter().chain(vec![0.02; 3000]).collect());
        for at in [13.0, 20.0, 40.0, 60.0] {
            is_right(&trials, at);
        }
        let (said, truth) = asked(&trials, 8.0);
        assert!(said.unwrap().least > truth, "until then it is thought to take longer, not shorter");
    }

    #[test]
    fn uneven_runs_are_taken_together() {
        let uneven: Vec<f64> = (0..4000).map(|unit| if unit % 7 == 0 { 0.1 } else { 0.005 }).collect();
        for at in [10.0, 30.0, 50.0] {
            is_right(&of_one_trial(uneven.clone()), at);
            is_right(&uneven.iter().map(|run| vec![*run]).collect::<Vec<_>>(), at);
        }
        // Runs that become dearer: what is said follows.
        let dearer: Vec<f64> = vec![0.01; 1000].into_iter().chain(vec![0.05; 1500]).collect();
        for at in [35.0, 60.0] {
            is_right(&of_one_trial(dearer.clone()), at);
            is_right(&dearer.iter().map(|run| vec![*run]).collect::<Vec<_>>(), at);
        }
    }

    /// Six trials of very different cost, in any order: what is not known is not said as if it were.
    #[test]
    fn trials_that_have_yet_to_begin_may_cost_something_else() {
        let costs = [0.01, 0.02, 0.05, 0.3, 0.1, 0.002];
        for turn in 0..6 {
            for is_backwards in [false, true] {
                let mut costs = costs;
                costs.rotate_left(turn);
                if is_backwards {
                    costs.reverse();
                }
                let trials: Vec<Vec<f64>> = costs.iter().map(|cost| vec![*cost; 60]).collect();
                let all: f64 = trials.iter().flatten().sum();
                let (first, last) = (60.0 * costs[0], all - 60.0 * costs[5]);
                // In the first trial nothing is known of the others; in the last one everything.
                let (said, truth) = asked(&trials, 1.1_f64.max(0.5 * first));
                let said = said.unwrap();
                if first > 2.2 {
                    assert!(said.most.is_none() && said.least <= truth, "{said:?} {truth}");
                }
                if 60.0 * costs[5] > 2.0 {
                    is_right(&trials, last + 30.0 * costs[5]);
                }
            }
        }
        // Dearer ones come last, as they were measured; then two kinds, the first of them three times.
        let dearer: Vec<Vec<f64>> =
            [0.0017, 0.003, 0.0019, 0.0044, 0.0065, 0.0095].iter().map(|cost| vec![*cost; 1000]).collect();
        let kinds: Vec<Vec<f64>> =
            [0.0017, 0.02, 0.0019, 0.018, 0.002, 0.022].iter().map(|cost| vec![*cost; 500]).collect();
        for (trials, times) in [(&dearer, [2.0, 4.0, 6.0, 10.0]), (&kinds, [2.0, 9.0, 11.0, 12.0])] {
            for at in times {
                holds(trials, at);
                let (said, _) = asked(trials, at);
                assert!(!said.unwrap().is_one(), "{said:?}");
            }
        }
    }

    /// Of many trials that scatter the sum is known well, though none of them is.
    #[test]
    fn many_trials_that_scatter_come_to_one_time() {
        let costs = (0..400).map(|trial| 0.002 + 0.01 * f64::from((trial * 7919) % 100) / 100.0);
        let trials: Vec<Vec<f64>> = costs.map(|cost| vec![cost; 20]).collect();
        for at in [10.0, 20.0, 40.0] {
            is_right(&trials, at);
            holds(&trials, at);
        }
    }

    #[test]
    fn what_is_left_is_not_guessed_from_nothing() {
        let outline = |runs, certain_runs| Workload { trials: 1, runs, certain_runs, ..Workload::default() };
        let mut tally = Tally { outline: outline(15, 15), begun: 1, ..Tally::default() };
        let mut running = BTreeMap::from([(0, Running::new("a", 15))]);
        assert_eq!(tally.left(&running, Duration::from_secs(9)), None);
        (1..=5).for_each(|run| tally.run_done(0, running.get_mut(&0), Duration::from_millis(4 * run)));
        assert_eq!(tally.left(&running, Duration::from_millis(20)), None, "too early");
        assert!(tally.left(&running, Duration::from_secs(9)).is_some());
        tally.outline = outline(5, 5);
        assert_eq!(tally.left(&running, Duration::from_secs(9)), None, "nothing is left");
    }

    #[test]
    fn an_open_number_of_runs_takes_between_two_times() {
        let left = |runs, certain_runs| {
            let outline = Workload { trials: 1, runs, certain_runs, ..Workload::default() };
            let mut tally = Tally { outline, begun: 1, ..Tally::default() };
            let mut running = BTreeMap::from([(0, Running::new("a", runs))]);
            (1..=100)
                .for_each(|run| tally.run_done(0, running.get_mut(&0), Duration::from_millis(100 * run)));
            tally.left(&running, Duration::from_secs(10)).unwrap()
        };
        let said = left(400, 120);
        assert!((said.least - 2.0).abs() < 0.1 && (said.most.unwrap() - 30.0).abs() < 1.0, "{said:?}");
        assert_eq!(said.in_words(), ", 2 seconds to 30 seconds left");
        // Those that there are for certain may all be done.
        assert_eq!(left(400, 90).least, 0.0);
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
        assert!((pace.cost(100.0, 1_000_000) * 10_000.0 - 1.0).abs() < 0.05);
    }
}
