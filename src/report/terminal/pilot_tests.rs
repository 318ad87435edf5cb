//! Sessions with pilot runs on a clock that is made up: what is said of the time that is left, against what it came to.

use std::collections::BTreeMap;
use std::time::Duration;

use super::progress::{Running, Tally};
use super::time_left::TimeLeft;
use numbers::random::Stream;
use results::Workload;

/// As a session makes them.
const PILOT_RUNS: usize = 64;
const PILOT_TIME: f64 = 1.5;

/// A session with trials of runs that take so long each, s.
struct Timed {
    trials: Vec<Vec<f64>>,
    threads: usize,
}

/// What happens when, s.
enum Happens {
    Pilot { unit: usize, took: f64 },
    Begins(usize),
    RunDone(usize),
    Over(usize),
}

impl Timed {
    /// Trials of these `means`, whose runs scatter by a share of that.
    fn new(means: &[f64], runs: usize, scatter: f64, threads: usize, stream: &mut Stream) -> Self {
        let mut run = |mean: &f64| mean * (1.0 + scatter * 1.7 * (2.0 * stream.uniform() - 1.0));
        let trials = means.iter().map(|mean| (0..runs).map(|_| run(mean)).collect()).collect();
        Self { trials, threads }
    }

    /// Everything in the order of time, and when all is over.
    fn happens(&self) -> (Vec<(f64, Happens)>, f64) {
        let mut events = Vec::new();
        let mut time = 0.0;
        let mut made = vec![0; self.trials.len()];
        'pilots: for round in 0..PILOT_RUNS {
            let all: Vec<usize> =
                (0..self.trials.len()).filter(|unit| self.trials[*unit].len() > round).collect();
            for some in all.chunks(self.threads) {
                if time > PILOT_TIME {
                    break 'pilots;
                }
                time += some.iter().map(|unit| self.trials[*unit][round]).fold(0.0, f64::max);
                for unit in some {
                    made[*unit] += 1;
                    events.push((time, Happens::Pilot { unit: *unit, took: self.trials[*unit][round] }));
                }
            }
        }
        let mut free = vec![time; self.threads];
        for (unit, runs) in self.trials.iter().enumerate() {
            let mut last = 0.0_f64;
            for (index, took) in runs.iter().enumerate().skip(made[unit]) {
                let worker =
                    (0..self.threads).min_by(|one, other| free[*one].total_cmp(&free[*other])).unwrap();
                if index == made[unit] {
                    events.push((free[worker], Happens::Begins(unit)));
                }
                free[worker] += took;
                last = last.max(free[worker]);
                events.push((free[worker], Happens::RunDone(unit)));
            }
            events.push((last, Happens::Over(unit)));
        }
        events.sort_by(|one, other| one.0.total_cmp(&other.0));
        (events, free.iter().copied().fold(0.0, f64::max))
    }

    /// What is said is left after so long, and what was left in truth.
    fn asked(&self, asked: f64) -> Option<(TimeLeft, f64)> {
        let (events, end) = self.happens();
        let runs = self.trials.iter().map(Vec::len).sum();
        let outline = Workload { trials: self.trials.len(), runs, certain_runs: runs, ..Workload::default() };
        let mut tally = Tally { outline, ..Tally::default() };
        let mut running: BTreeMap<usize, Running> = BTreeMap::new();
        for (time, event) in events.iter().filter(|(time, _)| *time <= asked) {
            let now = Duration::from_secs_f64(*time);
            match event {
                Happens::Pilot { unit, took } => {
                    tally.pilots.made(*unit, self.trials[*unit].len(), Duration::from_secs_f64(*took));
                    tally.run_done(*unit, None, now);
                }
                Happens::Begins(unit) => {
                    tally.begun += 1;
                    let made = tally.pilots.of(*unit);
                    running.insert(*unit, Running::new("a", self.trials[*unit].len()).after(made));
                }
                Happens::RunDone(unit) => tally.run_done(*unit, running.get_mut(unit), now),
                Happens::Over(unit) => {
                    if let Some(one) = running.remove(unit) {
                        tally.over(*unit, &one, now);
                    }
                }
            }
        }
        if asked >= end {
            return None;
        }
        Some((tally.left(&running, Duration::from_secs_f64(asked))?, end - asked))
    }
}

/// What was said of many sessions.
#[derive(Debug, Default)]
struct Score {
    /// One time: within 30 % of the truth, or not.
    right: usize,
    wrong: usize,
    /// A range, or the least: with the truth in it, or not.
    held: usize,
    missed: usize,
    /// Of those, without an upper end.
    open: usize,
}

impl Score {
    fn note(&mut self, (said, truth): (TimeLeft, f64)) {
        // What is nearly over is not looked at: a second is no matter.
        if truth < 2.0 {
            return;
        }
        let is_near = (said.middle() - truth).abs() <= 0.3 * truth;
        let holds = said.least <= truth && said.most.is_none_or(|most| most >= truth);
        match (said.is_one(), is_near, holds) {
            (true, true, _) => self.right += 1,
            (true, false, _) => self.wrong += 1,
            (false, _, true) => self.held += 1,
            (false, _, false) => self.missed += 1,
        }
        self.open += usize::from(said.most.is_none());
    }

    fn all(&self) -> usize {
        self.right + self.wrong + self.held + self.missed
    }
}

/// Sessions of this many trials whose costs differ up to 1 : 50, in any order, asked after 10, 20, … s.
fn score(trials: usize, runs: usize, scatter: f64, threads: usize) -> Score {
    let mut stream = Stream::seeded(7);
    let mut score = Score::default();
    for _ in 0..60 {
        // About a minute in all.
        let mut means: Vec<f64> = (0..trials).map(|_| libm::pow(50.0, stream.uniform())).collect();
        let all: f64 = means.iter().sum::<f64>() * runs as f64 / threads as f64;
        means.iter_mut().for_each(|mean| *mean *= 60.0 / all);
        let session = Timed::new(&means, runs, scatter, threads, &mut stream);
        for asked in [10.0, 20.0, 30.0, 40.0, 50.0] {
            session.asked(asked).into_iter().for_each(|one| score.note(one));
        }
    }
    score
}

#[test]
fn one_time_is_right_within_30_per_cent_and_ranges_hold_the_truth() {
    for (trials, runs) in [(6, 60), (6, 500), (20, 100), (200, 20), (1000, 10)] {
        for scatter in [0.1, 0.5] {
            for threads in [1, 2] {
                let score = score(trials, runs, scatter, threads);
                let what =
                    format!("{trials} trials of {runs} runs ± {scatter}, {threads} threads: {score:?}");
                assert!(score.wrong * 20 <= score.all(), "{what}");
                assert!(score.missed * 10 <= score.all(), "{what}");
                // Where runs of a trial hardly scatter, or there are many, it is mostly one time.
                assert!(
                    scatter > 0.2 || runs == 60 || runs == 20 || score.right * 4 > 3 * score.all(),
                    "{what}"
                );
                assert!(score.open * 20 <= score.all(), "{what}");
            }
        }
    }
}
