//! A file of results: what came of the runs of a batch of units, and who made them.

use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::error::ShardError;
use super::manifest::{ManifestHeader, PlannedProgram, UnitBatch};
use super::sealed::{SealedReader, SealedWriter, parse, parse_first, wrong};
use super::slices::SliceRuns;
use crate::run::Build;
use crate::run::{RunDigest, StoredRun};
use files::{base64, from_base64};

const FORMAT: &str = "scenario-runner results";

const VERSION: u32 = 1;

/// The first line. No host, no time and no attempt is in it: equal runs are equal files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResultsHeader {
    format: String,
    version: u32,
    batch: String,
    build: Build,
    canary: String,
    /// With what each calls itself.
    pub programs: Vec<AskedProgram>,
}

/// A program that decided in runs.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AskedProgram {
    pub name: String,
    pub file: String,
    /// Of its declaration and its files.
    pub digest: String,
    pub title: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct UnitLine {
    unit: String,
    runs: usize,
}

/// Neither has a letter that JSON escapes.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RunLine<'l> {
    run: &'l str,
    result: &'l str,
}

impl ResultsHeader {
    pub fn new(batch: &str, build: Build, canary: &str, programs: Vec<AskedProgram>) -> Self {
        let (format, version) = (FORMAT.to_string(), VERSION);
        Self { format, version, batch: batch.to_string(), build, canary: canary.to_string(), programs }
    }
}

/// Writes one; `results` are in the order of the batch's units.
pub fn write(
    path: &Path,
    header: &ResultsHeader,
    batch: &UnitBatch,
    results: &[SliceRuns],
) -> io::Result<()> {
    let mut file = SealedWriter::create(path)?;
    file.line(header)?;
    for (unit, runs) in batch.units.iter().zip(results) {
        file.line(&UnitLine { unit: unit.id.clone(), runs: runs.len() })?;
        for (run, stored) in runs {
            file.line(&RunLine { run: &run.to_string(), result: &base64(&stored.to_bytes()) })?;
        }
    }
    file.finish().map(drop)
}

/// Where a run's line is, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LinePlace {
    pub place: u64,
    pub length: u32,
}

/// Reads all of one, and tells of each run and where it is; returns the first line once all is found to be as it must be.
///
/// # Errors
/// If it is of another build or machine, or not what the batch says.
pub fn read(
    path: &Path,
    batch: &UnitBatch,
    manifest: &ManifestHeader,
    mut told: impl FnMut(RunDigest, LinePlace),
) -> Result<ResultsHeader, ShardError> {
    let mut lines = SealedReader::open(path)?;
    let header = header(path, &mut lines, batch, manifest)?;
    let ends = || wrong(path, "it has not all units of its batch");
    for unit in &batch.units {
        let Ok(line) = lines.next_line()? else { return Err(ends()) };
        let said: UnitLine = parse(path, line.text)?;
        if said.unit != unit.id {
            let message = format!(
                "it has results of the unit {}, where {} ({}) should be",
                said.unit, unit.id, unit.name
            );
            return Err(wrong(path, message));
        }
        for _ in 0..said.runs {
            let Ok(line) = lines.next_line()? else { return Err(ends()) };
            let at = LinePlace { place: line.place, length: line.text.len() as u32 };
            let RunLine { run, .. } = parse(path, line.text)?;
            told(run.parse().map_err(|()| wrong(path, format!("`{run}` is no digest of a run")))?, at);
        }
    }
    match lines.next_line()? {
        Err(_) => Ok(header),
        Ok(_) => Err(wrong(path, "it has more than the units of its batch")),
    }
}

fn header(
    path: &Path,
    lines: &mut SealedReader,
    batch: &UnitBatch,
    manifest: &ManifestHeader,
) -> Result<ResultsHeader, ShardError> {
    let words = ("it has no results of scenario-runner", "its results are");
    let header: ResultsHeader = parse_first(lines, (FORMAT, VERSION), words)?;
    if header.build != manifest.build {
        let (found, here) = (Box::new(header.build), Box::new(manifest.build.clone()));
        return Err(ShardError::OtherBuild { path: path.to_path_buf(), found, here });
    }
    if header.batch != batch.id {
        return Err(wrong(
            path,
            format!("it has results of the batch {}, and is called like another", header.batch),
        ));
    }
    if header.canary != manifest.canary {
        return Err(ShardError::OtherCanary { path: path.to_path_buf() });
    }
    let digest = |name: &str, file: &str| {
        let is_it = |one: &&PlannedProgram| one.name == name && one.file == file;
        manifest.programs.iter().find(is_it).map(|one| one.digest.clone())
    };
    for asked in &header.programs {
        if digest(&asked.name, &asked.file).as_ref() != Some(&asked.digest) {
            let message = format!("the program of `{}` was another one than the manifest is of", asked.name);
            return Err(wrong(path, message));
        }
    }
    Ok(header)
}

/// What came of the run of a line; `None` if the line means something else.
pub fn stored(line: &[u8], run: &RunDigest) -> Option<StoredRun> {
    let line: RunLine = serde_json::from_slice(line).ok()?;
    let bytes = from_base64(line.result).filter(|_| line.run.parse() == Ok(*run))?;
    StoredRun::from_bytes(&bytes).ok()
}
