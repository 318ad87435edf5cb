//! The runs of a share of the batches of a manifest, each batch a file of results.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::batch_file::{self, AskedProgram, ResultsHeader};
use super::error::ShardError;
use super::manifest::{ManifestReader, ManifestUnit, UnitBatch};
use super::planned_unit::Planner;
use super::result_files::ResultFiles;
use super::slices::{SliceRuns, TrialSlice, run_slices};
use super::unit_journal::{JournalSubject, UnitJournal, remove_journals};
use super::unit_runs::{NotEnded, RunCounts, SharedWith, UnitRuns};
use super::whole_units::WholeUnit;
use crate::run::{Executor, FirstRuns, Panicked, Stop, VerifyRuns};
use crate::session::{UnitKind, with_needs};
use files::{Disk, Files};

/// What is to be run, by whom and where the results go.
pub struct Execution<'e> {
    /// Of the project that the manifest was made of.
    pub planner: &'e Planner<'e>,
    /// Of this build.
    pub manifest: &'e ManifestReader,
    /// Makes the runs.
    pub executor: &'e dyn Executor,
    /// Which runs in which programs decide are made twice.
    pub verify: VerifyRuns,
    /// Where the files of results are.
    pub folder: &'e Path,
    /// Whether a batch belongs to this share, by its number and digest.
    pub mine: &'e (dyn Fn(usize, &str) -> bool + Sync),
    /// Whether batches that are there are taken as they are, though a program may have been another one when they were made.
    pub reuse: bool,
    /// What the canary run came to here.
    pub canary: &'e str,
    /// What this worker is called, such as `host.123`: no other one at the same folder is called so.
    pub worker: &'e str,
    /// Whether it may help, once its share is made, with units that others are at.
    pub joins: &'e (dyn Fn() -> bool + Sync),
    /// Ends it after what is under way.
    pub stop: &'e Stop,
}

/// What became of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BatchProgress<'p> {
    /// It was there.
    Skipped,
    /// What was there is cut off or damaged, which is said in words: it is made again.
    Damaged(&'p str),
    /// Another worker is at it, whom this one helps from now on.
    Joined,
    /// Another worker has written its results, though this one has made so many runs of it.
    MadeElsewhere(usize),
    /// It was joined, which did not pay: this worker has made so many runs of it.
    Left(usize),
    /// Its results are there now.
    Made {
        /// How many runs it is.
        runs: usize,
        /// How many were made here, those among them that were not needed in the end.
        own: usize,
        /// Wall time.
        took: Duration,
        /// The trials that took longer than their `time_limit`, which is their result.
        over_limit: &'p [&'p str],
        /// Where they are.
        path: &'p Path,
    },
}

/// What was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Executed {
    /// Files that were written.
    pub made: usize,
    /// Files that were there.
    pub skipped: usize,
    /// Runs of these files.
    pub runs: usize,
    /// Of them and of what they build on, runs that a worker has left that did not come to its end.
    pub resumed: usize,
    /// And runs that others made meanwhile.
    pub heard: usize,
    /// Files of other shares, on which others were at work, that it helped with.
    pub joined: usize,
    /// Runs that it made of these, and of files that others have written before it did.
    pub shared: usize,
}

impl Execution<'_> {
    /// Makes all batches of the share that are not there, and tells `told` of each.
    ///
    /// # Errors
    /// The first that could not be made or written; those before it are there.
    pub fn run(&self, told: &(dyn Fn(&UnitBatch, BatchProgress) + Sync)) -> Result<Executed, ShardError> {
        if self.manifest.header().canary != self.canary {
            return Err(ShardError::OtherCanary { path: self.manifest.path().to_path_buf() });
        }
        let begun = Instant::now();
        let (numbers, levels) = (self.numbers()?, self.levels());
        let highest = levels.values().copied().max().unwrap_or(0);
        let mut executed = Executed::default();
        let busy = AtomicUsize::new(0);
        // What others build on is there before them, if it is of this share.
        for level in 0..=highest {
            let level_of = |unit: &ManifestUnit| levels.get(&unit.unit).copied().unwrap_or(0);
            let is_next = |batch: &UnitBatch| batch.units.iter().map(level_of).max() == Some(level);
            if level > 0 {
                let is_own = |batch: &UnitBatch| (self.mine)(batch.number, &batch.id) && is_next(batch);
                self.join_needed(&is_own, &numbers, &mut executed, told)?;
            }
            let share = Share {
                of: self,
                numbers: &numbers,
                is_next: &is_next,
                busy: &busy,
                batches: Mutex::new(self.in_order()?),
                state: Mutex::new(State { executed, failed: None }),
            };
            thread::scope(|scope| {
                for _ in 1..self.executor.parallelism() {
                    // As many as the system gives: the results do not depend on how many there are.
                    let _ = thread::Builder::new().spawn_scoped(scope, || share.drive(told));
                }
                share.drive(told);
            });
            let state = share.state.into_inner().unwrap_or_else(PoisonError::into_inner);
            match state.failed {
                Some(error) => return Err(error),
                None if self.stop.is_requested() => return Err(ShardError::Stopped),
                None => executed = state.executed,
            }
        }
        self.join_any(begun, &numbers, &mut executed, told)?;
        Ok(executed)
    }

    /// All batches, those first in which others may join while the rest is made.
    fn in_order(&self) -> Result<BatchIterator, ShardError> {
        if !self.planner.has_undecided() {
            return Ok(Box::new(self.manifest.batches()?));
        }
        let first = self.manifest.batches()?.filter(|batch| batch.as_ref().map_or(true, is_undecided));
        let rest = self.manifest.batches()?.filter(|batch| !batch.as_ref().map_or(true, is_undecided));
        Ok(Box::new(first.chain(rest)))
    }

    /// Makes a batch of another one's share, on which that is at work.
    pub(super) fn join(
        &self,
        numbers: &HashMap<usize, usize>,
        batch: &UnitBatch,
        told: &(dyn Fn(&UnitBatch, BatchProgress) + Sync),
    ) -> Result<BatchEnd, ShardError> {
        let share = Share {
            of: self,
            numbers,
            is_next: &|_| true,
            busy: &AtomicUsize::new(0),
            batches: Mutex::new(Box::new(std::iter::empty())),
            state: Mutex::default(),
        };
        share.caught(batch, true, told)
    }

    /// Of each unit that is no trial, how many others it builds on that build on each other.
    fn levels(&self) -> HashMap<usize, usize> {
        let units = self.planner.units;
        let mut levels = HashMap::new();
        for unit in units.others() {
            let of = |need: &usize| 1 + levels.get(need).copied().unwrap_or(0);
            let level = units.needs(unit).iter().map(of).max().unwrap_or(0);
            levels.insert(unit, level);
        }
        levels
    }

    /// Of each unit that is a trial in whose suite programs decide, how many runs of its scenario come before it in the session. A session
    /// makes some runs twice by that.
    fn numbers(&self) -> Result<HashMap<usize, usize>, ShardError> {
        let suites = self.planner.project.suites();
        let mut numbers = HashMap::new();
        if suites.iter().all(|one| one.suite.controllers.is_empty()) {
            return Ok(numbers);
        }
        let mut trials = BTreeSet::new();
        for batch in self.manifest.batches()? {
            let units = batch?.units.into_iter().map(|one| one.unit);
            trials.extend(units.filter(|unit| *unit < self.planner.units.len()));
        }
        let mut before: HashMap<(usize, String), usize> = HashMap::new();
        for unit in trials {
            let UnitKind::Trial { scenario, .. } = self.planner.units.kind(unit) else { continue };
            let own = (self.planner.units.suite(unit), scenario.scenario().name.clone());
            let number = before.entry(own).or_default();
            numbers.insert(unit, *number);
            *number += scenario.runs();
        }
        Ok(numbers)
    }

    /// What the programs that were asked call themselves.
    fn programs(&self) -> Vec<AskedProgram> {
        let planned = &self.manifest.header().programs;
        let uses = self.executor.program_uses();
        let mut asked: Vec<AskedProgram> = planned
            .iter()
            .filter_map(|one| {
                let is_it = |used: &&under_test::ProgramUse| {
                    used.program.name == one.name && used.program.file == one.file
                };
                let title = uses.iter().find(is_it)?.title.clone();
                let (name, file, digest) = (one.name.clone(), one.file.clone(), one.digest.clone());
                Some(AskedProgram { name, file, digest, title })
            })
            .collect();
        asked.sort();
        asked
    }
}

/// Whether a batch holds units that decide themselves which runs they make.
pub(super) fn is_undecided(batch: &UnitBatch) -> bool {
    batch.units.iter().any(|unit| unit.runs.is_none())
}

type BatchIterator = Box<dyn Iterator<Item = Result<UnitBatch, ShardError>> + Send>;

struct Share<'s, 'e> {
    of: &'s Execution<'e>,
    numbers: &'s HashMap<usize, usize>,
    /// Whether all that a batch builds on comes before.
    is_next: &'s (dyn Fn(&UnitBatch) -> bool + Sync),
    /// How many batches are being made.
    busy: &'s AtomicUsize,
    batches: Mutex<BatchIterator>,
    state: Mutex<State>,
}

/// A batch that was made and is not written yet.
struct MadeBatch {
    /// Of each unit.
    results: Vec<SliceRuns>,
    /// The units that took longer than the `time_limit` of their trial.
    over_limit: Vec<usize>,
    counts: RunCounts,
}

/// How it went with a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BatchEnd {
    /// Its results were there.
    There,
    /// Its results are there now, so many runs.
    Made(usize, RunCounts),
    /// Another one has written them.
    Elsewhere(RunCounts),
    /// It is left to others.
    Left(RunCounts),
}

/// A batch that is being made.
struct Busy<'b>(&'b AtomicUsize);

impl<'b> Busy<'b> {
    fn begin(busy: &'b AtomicUsize) -> Self {
        busy.fetch_add(1, Ordering::Relaxed);
        Self(busy)
    }
}

impl Drop for Busy<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

#[derive(Default)]
struct State {
    executed: Executed,
    failed: Option<ShardError>,
}

impl Share<'_, '_> {
    fn drive(&self, told: &(dyn Fn(&UnitBatch, BatchProgress) + Sync)) {
        while let Some(batch) = self.next() {
            let ended = match batch {
                Ok(batch) => self.caught(&batch, false, told),
                Err(error) => Err(error),
            };
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            match ended {
                Ok(BatchEnd::There) => state.executed.skipped += 1,
                Ok(BatchEnd::Elsewhere(counts) | BatchEnd::Left(counts)) => {
                    state.executed.skipped += 1;
                    state.executed.shared += counts.made;
                }
                Ok(BatchEnd::Made(runs, counts)) => {
                    state.executed.made += 1;
                    state.executed.runs += runs;
                    state.executed.resumed += counts.resumed;
                    state.executed.heard += counts.heard;
                }
                Err(error) => {
                    // What others say then is that they were stopped.
                    if !matches!(error, ShardError::Stopped) {
                        state.failed.get_or_insert(error);
                    }
                    self.of.stop.request();
                }
            }
        }
    }

    fn next(&self) -> Option<Result<UnitBatch, ShardError>> {
        let mut batches = self.batches.lock().unwrap_or_else(PoisonError::into_inner);
        if self.of.stop.is_requested() {
            return None;
        }
        let is_own = |batch: &UnitBatch| (self.of.mine)(batch.number, &batch.id) && (self.is_next)(batch);
        batches.find(|batch| batch.as_ref().map_or(true, is_own))
    }

    /// A batch, of which a panic is an error.
    fn caught(
        &self,
        batch: &UnitBatch,
        is_joined: bool,
        told: &(dyn Fn(&UnitBatch, BatchProgress) + Sync),
    ) -> Result<BatchEnd, ShardError> {
        let ended = Panicked::catch(|| self.batch(batch, is_joined, told));
        ended.unwrap_or_else(|panicked| Err(ShardError::OtherFiles { message: panicked.to_string() }))
    }

    fn batch(
        &self,
        batch: &UnitBatch,
        is_joined: bool,
        told: &(dyn Fn(&UnitBatch, BatchProgress) + Sync),
    ) -> Result<BatchEnd, ShardError> {
        let Execution { manifest, folder, canary, .. } = self.of;
        let path = batch.path(folder);
        let is_there = Disk.is_file(&path) && self.of.reuse;
        if is_there {
            match batch_file::read(&path, batch, manifest.header(), |_, _| ()) {
                Ok(_) => {
                    self.remove_journals(batch);
                    told(batch, BatchProgress::Skipped);
                    return Ok(BatchEnd::There);
                }
                // What another one made is not overwritten: somebody has mixed up two folders, or two machines differ.
                Err(error @ (ShardError::OtherBuild { .. } | ShardError::OtherCanary { .. })) => {
                    return Err(error);
                }
                Err(error) => told(batch, BatchProgress::Damaged(&error.to_string())),
            }
        }
        let begun = Instant::now();
        let watched = (!is_there).then_some(&*path);
        let (made, ended) = self.results(batch, is_joined, watched, told)?;
        let MadeBatch { results, over_limit, counts } = made;
        match ended {
            None => {}
            Some(NotEnded::Disagreed(message)) => return Err(ShardError::OtherFiles { message }),
            Some(NotEnded::Left) => {
                told(batch, BatchProgress::Left(counts.made));
                return Ok(BatchEnd::Left(counts));
            }
            Some(NotEnded::Elsewhere) => {
                told(batch, BatchProgress::MadeElsewhere(counts.made));
                // Unless they mean nothing: then it is made for good.
                return match self.batch(batch, is_joined, told)? {
                    BatchEnd::There => Ok(BatchEnd::Elsewhere(counts)),
                    other => Ok(other),
                };
            }
        }
        let header =
            ResultsHeader::new(&batch.id, manifest.header().build.clone(), canary, self.of.programs());
        let written = batch_file::write(&path, &header, batch, &results);
        if let Err(error) = written {
            // Another worker may have written the same meanwhile.
            if batch_file::read(&path, batch, manifest.header(), |_, _| ()).is_err() {
                return Err(ShardError::NotWritten { path, message: error.to_string() });
            }
        }
        self.remove_journals(batch);
        let runs = results.iter().map(Vec::len).sum();
        let over_limit: Vec<&str> = over_limit.iter().map(|place| &*batch.units[*place].name).collect();
        let (own, took) = (counts.made, begun.elapsed());
        told(batch, BatchProgress::Made { runs, own, took, over_limit: &over_limit, path: &path });
        Ok(BatchEnd::Made(runs, counts))
    }

    fn remove_journals(&self, batch: &UnitBatch) {
        let undecided = batch.units.iter().filter(|unit| unit.runs.is_none());
        undecided.for_each(|unit| remove_journals(self.of.folder, &unit.id));
    }

    /// What came of the runs of each unit, unless it turned out not to be for this worker. Others may write them to the path that is `watched`.
    fn results(
        &self,
        batch: &UnitBatch,
        is_joined: bool,
        watched: Option<&Path>,
        told: &(dyn Fn(&UnitBatch, BatchProgress) + Sync),
    ) -> Result<(MadeBatch, Option<NotEnded>), ShardError> {
        let Execution { planner, executor, verify, stop, .. } = *self.of;
        let _busy = Busy::begin(self.busy);
        let is_idle = || self.busy.load(Ordering::Relaxed) == 1;
        let mut made = MadeBatch {
            results: vec![SliceRuns::new(); batch.units.len()],
            over_limit: Vec::new(),
            counts: RunCounts::default(),
        };
        let mut slices = Vec::new();
        for (place, unit) in batch.units.iter().enumerate() {
            self.check(unit)?;
            let number = self.numbers.get(&unit.unit).copied();
            match unit.runs {
                Some((first, runs)) => {
                    made.counts.made += runs;
                    let number = number.map(|number| number + first);
                    slices.push(TrialSlice { place, unit: unit.unit, first, runs, number });
                }
                None => {
                    let results = watched.map(Path::to_path_buf);
                    let known = self.known(unit, SharedWith { results, is_joined, is_idle: &is_idle });
                    known.notices().iter().for_each(|why| told(batch, BatchProgress::Damaged(why)));
                    let group = unit.group;
                    let whole = WholeUnit { planner, executor, unit: unit.unit, group, verify, number };
                    let whole = whole.run(&known, stop);
                    known.notices().iter().for_each(|why| told(batch, BatchProgress::Damaged(why)));
                    made.counts.add(known.counts());
                    match whole? {
                        Ok(whole) => {
                            made.results[place] = whole.runs;
                            made.over_limit.extend(whole.is_over_limit.then_some(place));
                        }
                        Err(why) => return Ok((made, Some(why))),
                    }
                }
            }
        }
        let first_runs = FirstRuns::new(verify);
        for slice in run_slices(planner, executor, &first_runs, slices, stop)? {
            if slice.id.to_string() != batch.units[slice.place].id {
                return Err(self.other_files(&batch.units[slice.place]));
            }
            made.results[slice.place] = slice.runs;
            made.over_limit.extend(slice.is_over_limit.then_some(slice.place));
        }
        Ok((made, None))
    }

    /// What is known of the runs of a unit, and of those of the units that it builds on. Nothing where a program may be another one by now, and nobody
    /// else is heard where one may decide otherwise in another run.
    fn known<'u>(&self, unit: &ManifestUnit, with: SharedWith<'u>) -> UnitRuns<'u> {
        let Execution { planner, manifest, folder, canary, reuse, worker, stop, .. } = *self.of;
        if !reuse {
            return UnitRuns::new(None, None, None, stop.part());
        }
        let (units, of) = (planner.units, unit.unit);
        // How long it takes is known of who makes all of it.
        let is_timed = !units.is_block(of) && planner.time_limit(of).is_some();
        let subject = JournalSubject { unit: &unit.id, build: &manifest.header().build, canary };
        let resumed = (!is_timed).then(|| UnitJournal::open(folder, subject, worker));
        let builds = !units.needs(of).is_empty();
        let needed = builds.then(|| {
            let mut wanted = vec![false; units.len()];
            wanted[of] = true;
            let wanted = with_needs(units, wanted);
            ResultFiles::of_units(folder, manifest, |one| one != of && wanted.get(one) == Some(&true))
        });
        let with = planner.digests.are_repeatable().then_some(with);
        UnitRuns::new(resumed, needed.flatten(), with, stop.part())
    }

    /// Whether a unit is what the manifest calls so.
    fn check(&self, unit: &ManifestUnit) -> Result<(), ShardError> {
        let (planner, of) = (self.of.planner, unit.unit);
        let is_named = of < planner.units.len() && planner.units.key(of) == unit.name;
        let has_runs = |(first, runs): (usize, usize)| {
            let (end, all) = (first.saturating_add(runs), planner.units.runs(of));
            let is_trial = matches!(planner.units.kind(of), UnitKind::Trial { .. });
            is_trial && runs > 0 && end <= all && (runs == all || planner.time_limit(of).is_none())
        };
        let has_group = |group: Option<usize>| match (group, planner.groups(of)) {
            (Some(group), Some(groups)) => group < groups,
            (None, groups) => groups.is_none(),
            (Some(_), None) => false,
        };
        let is_same = is_named
            && match unit.runs {
                Some(runs) => unit.group.is_none() && has_runs(runs),
                None => has_group(unit.group) && planner.whole(of, unit.group).id.to_string() == unit.id,
            };
        if is_same { Ok(()) } else { Err(self.other_files(unit)) }
    }

    fn other_files(&self, unit: &ManifestUnit) -> ShardError {
        let message = format!(
            "{} is another unit here than the manifest says: its files have changed since",
            unit.name
        );
        ShardError::OtherFiles { message }
    }
}
