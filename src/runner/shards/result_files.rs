//! The results of all units of a manifest, in files that many machines have written: found whole before anything is made of them, and read a
//! run at a time, by where each is.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::batch_file::{self, AskedProgram, LinePlace};
use super::error::ShardError;
use super::manifest::{ManifestHeader, ManifestReader, ManifestUnit, UnitBatch};
use super::sealed::wrong;
use crate::run::{RunDigest, RunResults, StoredRun};
use crate::session::Units;
use files::{Disk, Files, Places};

/// So many files are open at once.
const MOST_OPEN: usize = 256;

/// Missing batches of which units are named.
const MOST_NAMED: usize = 5;

/// Where every run is. A run needs 48 bytes of memory, whatever came of it.
pub struct ResultFiles {
    paths: Vec<PathBuf>,
    /// In the order of their digests.
    runs: Vec<RunPlace>,
    open: Mutex<HashMap<u32, Places>>,
    titles: BTreeMap<(String, String), String>,
}

#[derive(Debug, Clone, Copy)]
struct RunPlace {
    run: RunDigest,
    file: u32,
    at: LinePlace,
}

/// Files that were read, in the order of their batches.
#[derive(Default)]
struct Reading {
    paths: Vec<PathBuf>,
    runs: Vec<RunPlace>,
    titles: BTreeMap<(String, String), BTreeSet<String>>,
}

impl Reading {
    /// Adds what the file of a batch says.
    fn add(&mut self, ReadBatch { path, runs, programs }: ReadBatch) {
        let file = self.paths.len() as u32;
        self.runs.extend(runs.into_iter().map(|(run, at)| RunPlace { run, file, at }));
        for asked in programs {
            self.titles.entry((asked.name, asked.file)).or_default().insert(asked.title);
        }
        self.paths.push(path);
    }

    fn end(self) -> Result<ResultFiles, ShardError> {
        let Self { paths, mut runs, titles } = self;
        runs.sort_unstable_by_key(|one| (one.run, one.file, one.at.place));
        // Several, if it was changed meanwhile, as a session on one machine has it.
        let title = |titles: BTreeSet<String>| titles.into_iter().collect::<Vec<_>>().join(" / ");
        let titles = titles.into_iter().map(|(program, all)| (program, title(all))).collect();
        let all = ResultFiles { paths, runs, open: Mutex::default(), titles };
        all.check_duplicates()?;
        Ok(all)
    }
}

/// What the file of a batch says.
struct ReadBatch {
    path: PathBuf,
    runs: Vec<(RunDigest, LinePlace)>,
    programs: Vec<AskedProgram>,
}

impl ReadBatch {
    /// `None` if there is no file of the batch.
    fn of(folder: &Path, batch: &UnitBatch, manifest: &ManifestHeader) -> Result<Option<Self>, ShardError> {
        let path = batch.path(folder);
        if !Disk.is_file(&path) {
            return Ok(None);
        }
        let mut runs = Vec::new();
        let header = batch_file::read(&path, batch, manifest, |run, at| runs.push((run, at)))?;
        Ok(Some(Self { path, runs, programs: header.programs }))
    }
}

/// Looks at the `wanted` batches of a manifest side by side, and tells of each in its order.
fn look_at<T: Send>(
    manifest: &ManifestReader,
    wanted: impl Fn(&UnitBatch) -> bool,
    look: impl Fn(&UnitBatch) -> Result<T, ShardError> + Sync,
    mut told: impl FnMut(UnitBatch, T),
) -> Result<(), ShardError> {
    let mut batches = manifest.batches()?.filter(|batch| batch.as_ref().map_or(true, &wanted));
    loop {
        // So few that of a large manifest little is held.
        let some: Vec<UnitBatch> =
            batches.by_ref().take(2 * rayon::current_num_threads()).collect::<Result<_, _>>()?;
        if some.is_empty() {
            return Ok(());
        }
        let seen: Vec<_> = some.par_iter().map(&look).collect();
        for (batch, seen) in some.into_iter().zip(seen) {
            told(batch, seen?);
        }
    }
}

/// Batches of which there is no file.
#[derive(Default)]
struct Missing {
    batches: Vec<usize>,
    units: usize,
    names: Vec<String>,
}

impl ResultFiles {
    /// Reads all of them once. `command` makes what is missing.
    ///
    /// # Errors
    /// If any is missing, cut off, of another build, machine or manifest, or if two say different things of one run.
    pub fn open(folder: &Path, manifest: &ManifestReader, command: &str) -> Result<Self, ShardError> {
        let (mut reading, mut missing) = (Reading::default(), Missing::default());
        let mut expected: HashSet<String> = HashSet::new();
        let look = |batch: &UnitBatch| ReadBatch::of(folder, batch, manifest.header());
        let told = |batch: UnitBatch, read: Option<ReadBatch>| {
            match read {
                Some(read) => reading.add(read),
                None => missing.add(&batch),
            }
            expected.insert(batch.id);
        };
        look_at(manifest, |_| true, look, told)?;
        foreign(folder, &expected)?;
        missing.check(folder, command)?;
        reading.end()
    }

    /// Those of the `wanted` units of the session; `None` if they are not all there and whole.
    pub fn of_units(
        folder: &Path,
        manifest: &ManifestReader,
        wanted: impl Fn(usize) -> bool,
    ) -> Option<Self> {
        let (mut reading, mut are_there) = (Reading::default(), true);
        let is_wanted = |batch: &UnitBatch| batch.units.iter().any(|unit| wanted(unit.unit));
        let look = |batch: &UnitBatch| ReadBatch::of(folder, batch, manifest.header());
        let told = |_, read| match read {
            Some(read) => reading.add(read),
            None => are_there = false,
        };
        look_at(manifest, is_wanted, look, told).ok().filter(|()| are_there)?;
        reading.end().ok()
    }

    /// What the program of a controller that a file declares called itself.
    pub fn title(&self, name: &str, file: &str) -> Option<&str> {
        self.titles.get(&(name.to_string(), file.to_string())).map(String::as_str)
    }

    /// A run of which there are two results has one, or one machine is not like the other.
    fn check_duplicates(&self) -> Result<(), ShardError> {
        for pair in self.runs.windows(2) {
            let [one, other] = pair else { continue };
            if one.run == other.run && self.line(one)? != self.line(other)? {
                let (one, other) = (&self.paths[one.file as usize], &self.paths[other.file as usize]);
                let message =
                    format!("it says something else of the run {} than {}", pair[0].run, one.display());
                return Err(wrong(other, message));
            }
        }
        Ok(())
    }

    fn line(&self, run: &RunPlace) -> Result<Vec<u8>, ShardError> {
        let path = &self.paths[run.file as usize];
        let unreadable =
            |error: files::ReadError| wrong(path, format!("it cannot be read any more: {error}"));
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        if open.len() >= MOST_OPEN && !open.contains_key(&run.file) {
            open.clear();
        }
        let file = match open.entry(run.file) {
            std::collections::hash_map::Entry::Occupied(known) => known.into_mut(),
            std::collections::hash_map::Entry::Vacant(free) => {
                free.insert(Places::open(path).map_err(unreadable)?)
            }
        };
        file.read(run.at.place, run.at.length as usize).map_err(unreadable)
    }
}

impl RunResults for ResultFiles {
    fn find(&self, run: &RunDigest) -> Result<Option<StoredRun>, String> {
        let first = self.runs.partition_point(|one| one.run < *run);
        let Some(place) = self.runs.get(first).filter(|one| one.run == *run) else { return Ok(None) };
        let line = self.line(place).map_err(|error| error.to_string())?;
        let path = self.paths[place.file as usize].display();
        batch_file::stored(&line, run).map(Some).ok_or_else(|| format!("{path}: its result means nothing"))
    }

    /// Nothing is written where results are read.
    fn keep(&self, _run: RunDigest, _stored: StoredRun) {}
}

impl Missing {
    fn add(&mut self, batch: &UnitBatch) {
        self.batches.push(batch.number);
        self.units += batch.units.len();
        let left = MOST_NAMED.saturating_sub(self.names.len());
        self.names.extend(batch.units.iter().take(left).map(|unit| unit.name.clone()));
    }

    fn check(self, folder: &Path, command: &str) -> Result<(), ShardError> {
        let Self { batches, units, names } = self;
        if batches.is_empty() {
            return Ok(());
        }
        let more = if units > names.len() { ", …" } else { "" };
        let count = |number: usize, what: &str| match number {
            1 => format!("1 {what}"),
            _ => format!("{number} {what}s"),
        };
        let message = format!(
            "{}: the results of {} are missing, of {}: {}{more}\n{command} makes them; on a network, files may be seen late",
            folder.display(),
            count(batches.len(), "batch").replace("batchs", "batches"),
            count(units, "unit"),
            names.join(", "),
        );
        Err(ShardError::Missing { message })
    }
}

/// Refuses files that look like results and are of no batch of the manifest.
fn foreign(folder: &Path, expected: &HashSet<String>) -> Result<(), ShardError> {
    let is_hex = |text: &str| text.bytes().all(|byte| byte.is_ascii_hexdigit());
    let folders = Disk.names(folder).into_iter().filter(|name| name.len() == 2 && is_hex(name));
    for name in folders {
        let inside = folder.join(&name);
        // What a worker that was killed has left half written begins with a dot.
        for file in Disk.names(&inside).into_iter().filter(|file| !file.starts_with('.')) {
            let is_expected =
                file.strip_suffix(".jsonl").is_some_and(|id| id.starts_with(&name) && expected.contains(id));
            if !is_expected {
                let message =
                    "it is of no batch of this manifest: another manifest's results are in this folder";
                return Err(wrong(&inside.join(file), message));
            }
        }
    }
    Ok(())
}

/// The names of what is chosen by a manifest, as marks of the units of a session.
///
/// # Errors
/// If the session has no such units, as its files have changed.
pub fn chosen(manifest: &ManifestReader, units: &Units) -> Result<Vec<bool>, ShardError> {
    let mut chosen = vec![false; units.len()];
    let is_other = |unit: &&ManifestUnit| unit.unit >= units.len() || units.key(unit.unit) != unit.name;
    let look = |batch: &UnitBatch| match batch.units.iter().find(is_other) {
        None => Ok(()),
        Some(ManifestUnit { name, .. }) => {
            let message = format!("there is no {name} any more: the files of the manifest have changed");
            Err(ShardError::OtherFiles { message })
        }
    };
    let told = |batch: UnitBatch, ()| batch.units.iter().for_each(|unit| chosen[unit.unit] = true);
    look_at(manifest, |_| true, look, told)?;
    Ok(chosen)
}
