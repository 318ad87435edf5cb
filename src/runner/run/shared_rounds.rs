//! Runs of a round that several workers make at the same time, each with all of the round before it: a worker begins with its own part, and makes
//! of the others' what they have not come to yet. Nobody claims anything, so that nobody is waited for who is gone.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::job::{Job, JobPlace};
use super::run_digest::RunDigest;
use super::stored_run::StoredRun;

/// Runs that are made before somebody looks again at what others have made take about as long.
const BETWEEN_LOOKS: Duration = Duration::from_millis(50);

/// However short runs are, no more than so many are made between two looks, and so many wait for their turn.
const MOST_BETWEEN: usize = 64;
const MOST_WAITING: usize = 1024;

/// Runs that take less are made rather than waited for.
const LONG: Duration = Duration::from_millis(10);

/// Of all time, so much may be waited in vain: one part of so many.
const IN_VAIN: u32 = 20;

/// Who makes the same runs at the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sharing {
    /// How many workers there are, this one among them.
    pub workers: usize,
    /// Which of them this one is, from 0.
    pub place: usize,
    /// How many results others were heard to have made up to now.
    pub heard: u64,
    /// Whether this one has nothing else to do.
    pub may_wait: bool,
}

impl Sharing {
    /// Nobody else.
    pub const ALONE: Self = Self { workers: 1, place: 0, heard: 0, may_wait: false };

    /// Whose part of the round a run is.
    fn owner(&self, place: JobPlace) -> usize {
        (place.sequence + place.run) % self.workers
    }
}

/// A run of which no result is known, or of which more is wanted than is `known`.
pub(super) struct AbsentRun {
    pub job: Job,
    pub run: RunDigest,
    pub known: Option<StoredRun>,
}

/// Which of the runs that wait is next, by its place among them.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Turn {
    Own(usize),
    /// Another worker's, which that has not come to.
    Others(usize),
    /// Another worker's, which that is likely to be making.
    Begun(usize),
    Nobody,
}

/// Runs of a round that are absent as far as is known.
#[derive(Default)]
pub(super) struct Waiting {
    pub runs: Vec<AbsentRun>,
    /// [`Sharing::heard`] when they were last looked up.
    pub heard: u64,
    /// How many were given away to be made.
    pub given: usize,
    /// Since when there is nothing left to do but to wait.
    pub since: Option<Instant>,
}

impl Waiting {
    /// How many of them there should be for every worker to find some: one where there is one.
    pub fn most(sharing: &Sharing, threads: usize, run: Duration) -> usize {
        if sharing.workers == 1 {
            return 1;
        }
        let between = BETWEEN_LOOKS.as_nanos() / run.as_nanos().max(1);
        let between = usize::try_from(between).unwrap_or(usize::MAX).clamp(1, MOST_BETWEEN);
        (sharing.workers * threads * 2 * between).min(MOST_WAITING)
    }

    pub fn turn(&self, sharing: &Sharing, threads: usize) -> Turn {
        turn(self.runs.iter().map(|one| one.job.place), sharing, threads)
    }
}

fn turn(places: impl Iterator<Item = JobPlace>, sharing: &Sharing, threads: usize) -> Turn {
    let mut before = vec![0; sharing.workers];
    let (mut begun, mut left) = (Vec::new(), Vec::new());
    for (at, place) in places.enumerate() {
        let owner = sharing.owner(place);
        if owner == sharing.place {
            return Turn::Own(at);
        }
        before[owner] += 1;
        if before[owner] > threads { left.push(at) } else { begun.push(at) }
    }
    // From the end, where their owners come last, and several workers not at the same place.
    let from_end = |some: &[usize]| some.len().checked_sub(1 + sharing.place % some.len().div_ceil(2).max(1));
    match (from_end(&left), from_end(&begun)) {
        (Some(at), _) => Turn::Others(left[at]),
        (None, Some(at)) => Turn::Begun(begun[at]),
        (None, None) => Turn::Nobody,
    }
}

/// How long runs take here, and how long others were waited for in vain.
#[derive(Debug)]
pub(super) struct Pace {
    begun: Instant,
    run: AtomicU64,
    in_vain: AtomicU64,
}

impl Pace {
    pub fn new() -> Self {
        Self { begun: Instant::now(), run: AtomicU64::new(0), in_vain: AtomicU64::new(0) }
    }

    /// Of the last runs; nothing before the first.
    pub fn run(&self) -> Duration {
        Duration::from_nanos(self.run.load(Ordering::Relaxed))
    }

    pub fn took(&self, run: Duration) {
        let (known, new) = (self.run(), nanoseconds(run));
        let run = if known.is_zero() { new } else { nanoseconds(known) / 4 * 3 + new / 4 };
        self.run.store(run, Ordering::Relaxed);
    }

    /// Whether a run that another worker is likely to be making may be waited for, `waited` being how long it already was: that is no loss while it takes
    /// less than to make it, and it takes less than half of that if both go on at the same pace.
    pub fn may_wait(&self, waited: Duration) -> bool {
        let run = self.run();
        let in_vain = Duration::from_nanos(self.in_vain.load(Ordering::Relaxed));
        run >= LONG && waited < run / 2 && (in_vain + waited) * IN_VAIN < self.begun.elapsed()
    }

    pub fn waited_in_vain(&self, waited: Duration) {
        self.in_vain.fetch_add(nanoseconds(waited), Ordering::Relaxed);
    }
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(runs: &[(usize, usize)]) -> Vec<JobPlace> {
        runs.iter().map(|(sequence, run)| JobPlace { sequence: *sequence, run: *run }).collect()
    }

    fn of(workers: usize, place: usize) -> Sharing {
        Sharing { workers, place, ..Sharing::ALONE }
    }

    #[test]
    fn every_worker_begins_with_a_part_of_its_own() {
        for round in [vec![(0, 0), (0, 1), (0, 2), (0, 3)], vec![(0, 0), (1, 0), (2, 0), (3, 0)]] {
            let round = places(&round);
            for place in 0..4 {
                assert_eq!(turn(round.iter().copied(), &of(4, place), 1), Turn::Own(place));
            }
            assert_eq!(turn(round.iter().copied(), &of(1, 0), 1), Turn::Own(0));
        }
    }

    #[test]
    fn what_others_have_not_come_to_is_taken_from_the_end() {
        let all = |place: usize, runs: usize, threads: usize| {
            let round = (0..runs).map(|run| JobPlace { sequence: 0, run: run * 2 + 1 - place });
            turn(round, &of(2, place), threads)
        };
        assert_eq!(all(0, 6, 1), Turn::Others(5));
        assert_eq!(all(1, 6, 1), Turn::Others(4), "not at the same place as the other");
        assert_eq!(all(0, 6, 5), Turn::Others(5));
        assert_eq!(all(0, 6, 6), Turn::Begun(5), "as many as it has threads are being made");
        assert_eq!(all(0, 1, 1), Turn::Begun(0));
        assert_eq!(all(0, 0, 1), Turn::Nobody);
        // Whatever is left, somebody makes it.
        for workers in 1..6 {
            for place in 0..workers {
                for runs in 1..9 {
                    let round = (0..runs).map(|run| JobPlace { sequence: run / 3, run: run % 3 });
                    assert_ne!(turn(round, &of(workers, place), 2), Turn::Nobody);
                }
            }
        }
    }

    #[test]
    fn one_by_itself_takes_no_run_before_its_turn() {
        let most = |workers, run| Waiting::most(&of(workers, 0), 2, Duration::from_micros(run));
        assert_eq!(most(1, 100), 1);
        assert_eq!(most(2, 1_000_000), 8);
        assert_eq!(most(2, 5_000), 80);
        assert_eq!(most(2, 0), 512);
        assert_eq!(most(40, 1), 1024);
    }

    #[test]
    fn waiting_in_vain_comes_to_an_end() {
        let pace = Pace { begun: Instant::now() - Duration::from_secs(20), ..Pace::new() };
        assert!(!pace.may_wait(Duration::ZERO), "nobody knows how long a run takes");
        pace.took(Duration::from_secs(1));
        assert!(pace.may_wait(Duration::from_millis(400)) && !pace.may_wait(Duration::from_millis(600)));
        pace.waited_in_vain(Duration::from_secs(2));
        assert!(!pace.may_wait(Duration::ZERO));
        let short = Pace { begun: Instant::now() - Duration::from_secs(20), ..Pace::new() };
        short.took(Duration::from_millis(1));
        assert!(!short.may_wait(Duration::ZERO));
    }
}
