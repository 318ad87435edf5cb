//! A worker whose share is made helps with units that others are at. Whether somebody is at one is told by its journals, which grow: where nobody else
//! writes into the folder there are none, and no clock of another machine is asked.

use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::{Hash, Hasher};
use std::thread;
use std::time::{Duration, Instant};

use super::error::ShardError;
use super::execute::{BatchEnd, BatchProgress, Executed, Execution, is_undecided};
use super::manifest::UnitBatch;
use super::unit_journal::{LONGEST_PAUSE, journal_lengths};
use crate::session::with_needs;
use files::{Disk, Files};

/// After something that it helped with, a worker waits for so long for what comes next.
const LULL: Duration = Duration::from_secs(1);
/// Workers that are started together begin their journals within so long.
const TOGETHER: Duration = Duration::from_millis(500);
/// They are looked at that often.
const PAUSE: Duration = Duration::from_millis(50);

type Lengths = BTreeMap<String, (u64, usize)>;

impl Execution<'_> {
    /// Helps with all that others are at, as a worker that began at that time.
    pub(super) fn join_any(
        &self,
        begun: Instant,
        numbers: &HashMap<usize, usize>,
        executed: &mut Executed,
        told: &(dyn Fn(&UnitBatch, BatchProgress) + Sync),
    ) -> Result<(), ShardError> {
        let lull = if self.planner.has_undecided() { TOGETHER } else { Duration::ZERO };
        self.join_others(&|_| true, lull.saturating_sub(begun.elapsed()), numbers, executed, told)
    }

    /// Helps with one batch after the other of those that are `wanted`, until for a `lull` there is none that somebody is at.
    fn join_others(
        &self,
        wanted: &dyn Fn(&UnitBatch) -> bool,
        mut lull: Duration,
        numbers: &HashMap<usize, usize>,
        executed: &mut Executed,
        told: &(dyn Fn(&UnitBatch, BatchProgress) + Sync),
    ) -> Result<(), ShardError> {
        let mut left = HashSet::new();
        while self.reuse && (self.joins)() {
            let is_candidate = |batch: &UnitBatch| !left.contains(&batch.id) && wanted(batch);
            let Some(batch) = self.begun_elsewhere(&is_candidate, lull)? else { return Ok(()) };
            lull = LULL;
            told(&batch, BatchProgress::Joined);
            executed.joined += 1;
            let end = self.join(numbers, &batch, told)?;
            executed.shared += match end {
                BatchEnd::There => 0,
                BatchEnd::Made(_, counts) | BatchEnd::Elsewhere(counts) | BatchEnd::Left(counts) => {
                    counts.made
                }
            };
            if matches!(end, BatchEnd::Left(_)) {
                left.insert(batch.id);
            }
        }
        Ok(())
    }

    /// Helps with what those batches build on and others are at, rather than making it besides.
    pub(super) fn join_needed(
        &self,
        of: &dyn Fn(&UnitBatch) -> bool,
        numbers: &HashMap<usize, usize>,
        executed: &mut Executed,
        told: &(dyn Fn(&UnitBatch, BatchProgress) + Sync),
    ) -> Result<(), ShardError> {
        let units = self.planner.units;
        let (mut own, mut needing) = (HashSet::new(), vec![false; units.len()]);
        for batch in self.manifest.batches()? {
            let batch = batch?;
            if of(&batch) && !Disk.is_file(&batch.path(self.folder)) {
                batch.units.iter().filter(|unit| unit.unit < units.len()).for_each(|unit| {
                    needing[unit.unit] = true;
                });
                own.insert(batch.id);
            }
        }
        let needed = with_needs(units, needing);
        let is_needed = |batch: &UnitBatch| {
            !own.contains(&batch.id) && batch.units.iter().any(|unit| needed.get(unit.unit) == Some(&true))
        };
        if own.is_empty() {
            return Ok(());
        }
        self.join_others(&is_needed, Duration::ZERO, numbers, executed, told)
    }

    /// A batch that has no results and of which a unit has a journal that grows: the one with the fewest workers.
    fn begun_elsewhere(
        &self,
        is_candidate: &dyn Fn(&UnitBatch) -> bool,
        lull: Duration,
    ) -> Result<Option<UnitBatch>, ShardError> {
        let begun = Instant::now();
        loop {
            let before = journal_lengths(self.folder);
            // Without a journal no manifest is read again.
            let has_journal =
                |batch: &UnitBatch| batch.units.iter().any(|unit| before.contains_key(&unit.id));
            let is_begun = |batch: &UnitBatch| has_journal(batch) && is_candidate(batch);
            let candidates = if before.is_empty() { Vec::new() } else { self.left(&is_begun)? };
            if !candidates.is_empty() {
                return self.growing(candidates, &before);
            }
            if begun.elapsed() >= lull || self.left(is_candidate)?.is_empty() {
                return Ok(None);
            }
            self.pause()?;
        }
    }

    fn growing(
        &self,
        mut candidates: Vec<UnitBatch>,
        before: &Lengths,
    ) -> Result<Option<UnitBatch>, ShardError> {
        let begun = Instant::now();
        while !candidates.is_empty() && begun.elapsed() < LONGEST_PAUSE {
            self.pause()?;
            let now = journal_lengths(self.folder);
            candidates.retain(|batch| !Disk.is_file(&batch.path(self.folder)));
            let growing = candidates.iter().filter(|batch| grows(batch, before, &now));
            if let Some(batch) = growing.min_by_key(|batch| (workers(batch, &now), self.spread(batch))) {
                return Ok(Some(batch.clone()));
            }
        }
        Ok(None)
    }

    fn pause(&self) -> Result<(), ShardError> {
        thread::sleep(PAUSE);
        if self.stop.is_requested() { Err(ShardError::Stopped) } else { Ok(()) }
    }

    /// Candidates that come in rounds and have no results.
    fn left(&self, is_candidate: &dyn Fn(&UnitBatch) -> bool) -> Result<Vec<UnitBatch>, ShardError> {
        let is_left = |batch: &UnitBatch| {
            is_undecided(batch) && is_candidate(batch) && !Disk.is_file(&batch.path(self.folder))
        };
        self.manifest.batches()?.filter(|batch| batch.as_ref().map_or(true, is_left)).collect()
    }

    /// So that not all workers join at the same place.
    fn spread(&self, batch: &UnitBatch) -> u64 {
        let mut hasher = DefaultHasher::new();
        (self.worker, &batch.id).hash(&mut hasher);
        hasher.finish()
    }
}

fn grows(batch: &UnitBatch, before: &Lengths, now: &Lengths) -> bool {
    let length = |lengths: &Lengths, unit: &str| lengths.get(unit).map_or(0, |known| known.0);
    batch.units.iter().any(|unit| length(now, &unit.id) > length(before, &unit.id))
}

fn workers(batch: &UnitBatch, now: &Lengths) -> usize {
    batch.units.iter().filter_map(|unit| now.get(&unit.id)).map(|known| known.1).max().unwrap_or(0)
}
