//! What is known of the runs of a unit while it is made, which several workers may do at the same time.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::result_files::ResultFiles;
use super::unit_journal::{HeardRun, OtherJournals, Resumed, UnitJournal};
use crate::run::{Disagreement, RunDigest, RunResults, Sharing, Stop, StoredRun};
use files::{Disk, Files};

/// What others have made is looked at that often, and more often before what may be another's is made.
const LOOK: Duration = Duration::from_millis(50);
const LOOK_NOW: Duration = Duration::from_millis(2);

/// Whether it pays to join another worker is asked after so many runs, and is no longer hoped for after so long without one.
const RUNS_TO_PAY: usize = 64;
const TIME_TO_PAY: Duration = Duration::from_secs(60);

/// A worker that joins leaves if it makes less than that part of what would be its share first: one of so many.
const LEAST_SHARE: usize = 4;

/// Why a unit is not made to its end here.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NotEnded {
    /// Another worker has written its results.
    Elsewhere,
    /// It was joined, and that does not pay.
    Left,
    /// Two workers have made a run and disagree.
    Disagreed(String),
}

/// Whoever else may make the unit.
pub struct SharedWith<'u> {
    /// Where its results will be, in which nobody looks where they cannot be read.
    pub results: Option<PathBuf>,
    /// Whether others have begun it, and this worker could do without.
    pub is_joined: bool,
    /// Whether this worker makes nothing besides.
    pub is_idle: &'u (dyn Fn() -> bool + Sync),
}

/// Results in memory, which note what is asked for and hear of what others make.
pub struct UnitRuns<'u> {
    runs: Mutex<HashMap<RunDigest, KnownRun>>,
    asked: Mutex<Vec<RunDigest>>,
    journal: Option<Mutex<UnitJournal>>,
    /// Of the units that it builds on.
    needed: Option<ResultFiles>,
    counts: Mutex<RunCounts>,
    notices: Mutex<Vec<String>>,
    /// Where it is shared.
    looking: Option<Mutex<Looking<'u>>>,
    ended: Mutex<Option<NotEnded>>,
    /// Of the unit alone.
    stop: Stop,
}

struct KnownRun {
    stored: StoredRun,
    is_own: bool,
}

/// Where runs came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RunCounts {
    /// From journals that were there.
    pub resumed: usize,
    /// Made here.
    pub made: usize,
    /// From others, meanwhile.
    pub heard: usize,
    /// Of those that were made here, by others as well.
    pub twice: usize,
}

impl RunCounts {
    pub fn add(&mut self, other: Self) {
        self.resumed += other.resumed;
        self.made += other.made;
        self.heard += other.heard;
        self.twice += other.twice;
    }
}

struct Looking<'u> {
    with: SharedWith<'u>,
    others: OtherJournals,
    /// `None` before the first look, which is due at once: runs that others made before this worker came do not count against it.
    looked: Option<Instant>,
    standing: (usize, usize),
    /// What counts for whether joining pays, and since when.
    before: RunCounts,
    since: Instant,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'u> UnitRuns<'u> {
    /// With what journals hold, if there are any, and who else makes the unit, if it is shared. `stop` is for this unit alone.
    pub fn new(
        resumed: Option<Resumed>,
        needed: Option<ResultFiles>,
        with: Option<SharedWith<'u>>,
        stop: Stop,
    ) -> Self {
        let (journal, others, held) = match resumed {
            Some(Resumed { journal, others, held }) => (Some(Mutex::new(journal)), Some(others), held),
            None => Default::default(),
        };
        let looking = with.zip(others).map(|(with, others)| {
            let (before, since) = (RunCounts::default(), Instant::now());
            Mutex::new(Looking { with, others, looked: None, standing: (1, 0), before, since })
        });
        let all = Self {
            runs: Mutex::default(),
            asked: Mutex::default(),
            journal,
            needed,
            counts: Mutex::default(),
            notices: Mutex::new(held.notices),
            looking,
            ended: Mutex::default(),
            stop,
        };
        held.runs.into_iter().for_each(|run| all.hear(run));
        let mut counts = lock(&all.counts);
        *counts = RunCounts { resumed: counts.heard, ..RunCounts::default() };
        drop(counts);
        all
    }

    pub fn stop(&self) -> &Stop {
        &self.stop
    }

    pub fn ended(&self) -> Option<NotEnded> {
        lock(&self.ended).clone()
    }

    pub fn counts(&self) -> RunCounts {
        *lock(&self.counts)
    }

    /// What is wrong with journals, each once.
    pub fn notices(&self) -> Vec<String> {
        std::mem::take(&mut lock(&self.notices))
    }

    pub fn known(&self, run: &RunDigest) -> Option<StoredRun> {
        let own = lock(&self.runs).get(run).map(|known| known.stored.clone());
        // What cannot be read is made.
        own.or_else(|| self.needed.as_ref()?.find(run).ok()?)
    }

    /// The runs that were asked for since this was called last.
    pub fn asked(&self) -> Vec<RunDigest> {
        std::mem::take(&mut lock(&self.asked))
    }

    /// Has that in the place of what came of a run.
    pub fn put(&self, run: RunDigest, stored: StoredRun) {
        lock(&self.runs).insert(run, KnownRun { stored, is_own: true });
    }

    fn end(&self, why: NotEnded) {
        lock(&self.ended).get_or_insert(why);
        self.stop.request();
    }

    /// Takes in what another worker says of a run.
    fn hear(&self, HeardRun { run, stored, journal }: HeardRun) {
        let mut runs = lock(&self.runs);
        let mut counts = lock(&self.counts);
        match runs.entry(run) {
            Entry::Vacant(free) => {
                free.insert(KnownRun { stored, is_own: false });
                counts.heard += 1;
            }
            Entry::Occupied(known) => {
                counts.twice += usize::from(known.get().is_own);
                self.compare(&run, &known.get().stored, &stored, &journal.display().to_string());
            }
        }
    }

    /// Results of one run are one result, or one of the machines is not like the other.
    fn compare(&self, run: &RunDigest, known: &StoredRun, said: &StoredRun, journal: &str) {
        match known.against(said) {
            None => {}
            // Which of both it is is seen when the run is asked for.
            Some(Disagreement::OtherRun) => lock(&self.notices)
                .push(format!("{journal}: what it says of the run {run} is of another run, or another journal is wrong")),
            Some(Disagreement::OtherResult) => self.end(NotEnded::Disagreed(format!(
                "{journal}: it says something else of the run {run} than what it came to here: one of both machines computes otherwise; remove the journal of that"
            ))),
        }
    }

    fn look(&self, looking: &mut Looking, run: Duration) {
        looking.looked = Some(Instant::now());
        if looking.with.results.as_ref().is_some_and(|path| Disk.is_file(path)) {
            return self.end(NotEnded::Elsewhere);
        }
        let heard = looking.others.read();
        lock(&self.notices).extend(heard.notices);
        heard.runs.into_iter().for_each(|run| self.hear(run));
        looking.standing = looking.others.at_work(run);
        if looking.with.is_joined && !self.pays(looking) {
            self.end(NotEnded::Left);
        }
    }

    /// Whether this worker makes enough that the others have not made before.
    fn pays(&self, looking: &mut Looking) -> bool {
        let (now, before) = (self.counts(), looking.before);
        if now.made == 0 {
            // It replays what there is, of which it has yet to come to the end.
            looking.before = now;
            return looking.since.elapsed() < TIME_TO_PAY;
        }
        let (twice, heard) = (now.twice - before.twice, now.heard - before.heard);
        let first = (now.made - before.made).saturating_sub(twice);
        if first + twice + heard < RUNS_TO_PAY {
            return true;
        }
        looking.before = now;
        is_help(first, heard, looking.standing.0)
    }
}

/// Whether a worker that made so many runs before all others, and heard of so many of theirs, is a help.
fn is_help(first: usize, heard: usize, workers: usize) -> bool {
    first * LEAST_SHARE * workers >= first + heard
}

impl RunResults for UnitRuns<'_> {
    fn find(&self, run: &RunDigest) -> Result<Option<StoredRun>, String> {
        lock(&self.asked).push(*run);
        Ok(self.known(run))
    }

    fn holds(&self, run: &RunDigest) -> bool {
        lock(&self.runs).contains_key(run)
    }

    fn keep(&self, run: RunDigest, stored: StoredRun) {
        if let Some(journal) = &self.journal {
            lock(journal).record(&run, &stored);
        }
        let mut runs = lock(&self.runs);
        let mut counts = lock(&self.counts);
        counts.made += 1;
        if let Some(known) = runs.get(&run).filter(|known| !known.is_own) {
            counts.twice += 1;
            self.compare(&run, &known.stored, &stored, "a journal of another worker");
        }
        runs.insert(run, KnownRun { stored, is_own: true });
    }

    fn forget(&self, run: &RunDigest, key: &str) {
        lock(&self.runs).remove(run);
        lock(&self.notices).push(format!("a journal says of {key} what came of another run"));
    }

    fn sharing(&self, run: Duration, now: bool) -> Sharing {
        let Some(looking) = &self.looking else { return Sharing::ALONE };
        let mut looking = lock(looking);
        let pause = if now { LOOK_NOW } else { LOOK };
        let is_due = looking.looked.is_none_or(|looked| looked.elapsed() >= pause);
        if is_due && !self.stop.is_requested() {
            self.look(&mut looking, run);
        }
        let (workers, place) = looking.standing;
        Sharing { workers, place, heard: self.counts().heard as u64, may_wait: (looking.with.is_idle)() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_an_equal_part_is_a_help_and_less_is_none() {
        assert!(is_help(32, 32, 2) && is_help(8, 56, 2) && is_help(64, 0, 2));
        assert!(!is_help(7, 57, 2) && !is_help(0, 64, 2));
        assert!(is_help(4, 60, 4) && !is_help(3, 61, 4));
    }
}
