//! The runs of a share of the batches of a manifest, each batch a file of results.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::batch_file::{self, AskedProgram, ResultsHeader};
use super::error::ShardError;
use super::manifest::{Batches, ManifestReader, ManifestUnit, UnitBatch};
use super::planned_unit::Planner;
use super::result_files::ResultFiles;
use super::slices::{SliceRuns, TrialSlice, run_slices};
use super::unit_journal::{Resumed, UnitJournal};
use super::whole_units::{KnownRuns, WholeUnit};
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
    /// Its results are there now.
    Made {
        /// How many runs it is.
        runs: usize,
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
        let (numbers, levels) = (self.numbers()?, self.levels());
        let highest = levels.values().copied().max().unwrap_or(0);
        let mut executed = Executed::default();
        // What others build on is there before them, if it is of this share.
        for level in 0..=highest {
            let level_of = |unit: &ManifestUnit| levels.get(&unit.unit).copied().unwrap_or(0);
            let is_next = |batch: &UnitBatch| batch.units.iter().map(level_of).max() == Some(level);
            let share = Share {
                of: self,
                numbers: &numbers,
                is_next: &is_next,
                batches: Mutex::new(self.manifest.batches()?),
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
        Ok(executed)
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

struct Share<'s, 'e> {
    of: &'s Execution<'e>,
    numbers: &'s HashMap<usize, usize>,
    /// Whether all that a batch builds on comes before.
    is_next: &'s (dyn Fn(&UnitBatch) -> bool + Sync),
    batches: Mutex<Batches>,
    state: Mutex<State>,
}

/// A batch that was made and is not written yet.
struct MadeBatch {
    /// Of each unit.
    results: Vec<SliceRuns>,
    /// The units that took longer than the `time_limit` of their trial.
    over_limit: Vec<usize>,
    journals: Vec<UnitJournal>,
    /// Runs that came from journals.
    resumed: usize,
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
                Ok(batch) => match Panicked::catch(|| self.batch(&batch, told)) {
                    Ok(ended) => ended,
                    Err(panicked) => Err(ShardError::OtherFiles { message: panicked.to_string() }),
                },
                Err(error) => Err(error),
            };
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            match ended {
                Ok(None) => state.executed.skipped += 1,
                Ok(Some((runs, resumed))) => {
                    state.executed.made += 1;
                    state.executed.runs += runs;
                    state.executed.resumed += resumed;
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

    /// How many runs there are now, and how many a worker before has left; `None` if the results were there.
    fn batch(
        &self,
        batch: &UnitBatch,
        told: &(dyn Fn(&UnitBatch, BatchProgress) + Sync),
    ) -> Result<Option<(usize, usize)>, ShardError> {
        let Execution { manifest, folder, canary, .. } = self.of;
        let path = batch.path(folder);
        if Disk.is_file(&path) && self.of.reuse {
            match batch_file::read(&path, batch, manifest.header(), |_, _| ()) {
                Ok(_) => {
                    told(batch, BatchProgress::Skipped);
                    return Ok(None);
                }
                // What another one made is not overwritten: somebody has mixed up two folders, or two machines differ.
                Err(error @ (ShardError::OtherBuild { .. } | ShardError::OtherCanary { .. })) => {
                    return Err(error);
                }
                Err(error) => told(batch, BatchProgress::Damaged(&error.to_string())),
            }
        }
        let begun = Instant::now();
        let MadeBatch { results, over_limit, journals, resumed } = self.results(batch, told)?;
        let header =
            ResultsHeader::new(&batch.id, manifest.header().build.clone(), canary, self.of.programs());
        let written = batch_file::write(&path, &header, batch, &results);
        if let Err(error) = written {
            // Another worker may have written the same meanwhile.
            if batch_file::read(&path, batch, manifest.header(), |_, _| ()).is_err() {
                return Err(ShardError::NotWritten { path, message: error.to_string() });
            }
        }
        journals.into_iter().for_each(UnitJournal::remove);
        let runs = results.iter().map(Vec::len).sum();
        let over_limit: Vec<&str> = over_limit.iter().map(|place| &*batch.units[*place].name).collect();
        told(
            batch,
            BatchProgress::Made { runs, took: begun.elapsed(), over_limit: &over_limit, path: &path },
        );
        Ok(Some((runs, resumed)))
    }

    /// What came of the runs of each unit.
    fn results(
        &self,
        batch: &UnitBatch,
        told: &(dyn Fn(&UnitBatch, BatchProgress) + Sync),
    ) -> Result<MadeBatch, ShardError> {
        let Execution { planner, executor, verify, stop, .. } = *self.of;
        let mut made = MadeBatch {
            results: vec![SliceRuns::new(); batch.units.len()],
            over_limit: Vec::new(),
            journals: Vec::new(),
            resumed: 0,
        };
        let mut slices = Vec::new();
        for (place, unit) in batch.units.iter().enumerate() {
            self.check(unit)?;
            let number = self.numbers.get(&unit.unit).copied();
            match unit.runs {
                Some((first, runs)) => {
                    let number = number.map(|number| number + first);
                    slices.push(TrialSlice { place, unit: unit.unit, first, runs, number });
                }
                None => {
                    let known = self.known(unit);
                    if let Some(why) = &known.resumed.notice {
                        told(batch, BatchProgress::Damaged(why));
                    }
                    made.resumed += known.resumed.runs.len();
                    let group = unit.group;
                    let whole = WholeUnit { planner, executor, unit: unit.unit, group, verify, number };
                    let whole = whole.run(known, stop)?;
                    made.results[place] = whole.runs;
                    made.journals.push(whole.journal);
                    made.over_limit.extend(whole.is_over_limit.then_some(place));
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
        Ok(made)
    }

    /// What is known of the runs of a unit, and of those of the units that it builds on. Nothing where a program may be another one by now.
    fn known(&self, unit: &ManifestUnit) -> KnownRuns {
        let Execution { planner, manifest, folder, canary, reuse, .. } = *self.of;
        if !reuse {
            return KnownRuns::default();
        }
        let (units, of) = (planner.units, unit.unit);
        // How long it takes is known of who makes all of it.
        let is_timed = !units.is_block(of) && planner.time_limit(of).is_some();
        let resumed = match is_timed {
            true => Resumed::default(),
            false => UnitJournal::open(folder, &unit.id, &manifest.header().build, canary),
        };
        let builds = !units.needs(of).is_empty();
        let needed = builds.then(|| {
            let mut wanted = vec![false; units.len()];
            wanted[of] = true;
            let wanted = with_needs(units, wanted);
            ResultFiles::of_units(folder, manifest, |one| one != of && wanted.get(one) == Some(&true))
        });
        KnownRuns { resumed, needed: needed.flatten() }
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
