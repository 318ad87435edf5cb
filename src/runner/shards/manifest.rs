//! The manifest: what there is to be run, a unit a line, in the order of their digests. It is written once and never changed.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::ShardError;
use super::planned_unit::{PlannedUnit, UnitPart};
use super::sealed::{SealedReader, SealedWriter, digest_of, parse, parse_first, wrong};
use crate::run::Build;
use crate::session::Units;
use scenario::TextDigest;

const FORMAT: &str = "scenario-runner manifest";

/// Of the file; what another one means is not guessed.
const VERSION: u32 = 1;

/// So much estimated work is one file of results, s.
const BATCH: f64 = 1.0;

/// More units than this are not one file of results, however little they take.
const LARGEST_BATCH: usize = 10_000;

/// The first line: what all units have in common.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManifestHeader {
    format: String,
    version: u32,
    /// Who makes the runs.
    pub build: Build,
    /// The suites and scenarios, as they were named.
    pub files: Vec<String>,
    /// In the place of the seed of every suite.
    pub seed: Option<u64>,
    /// What was set from outside, as in [`scenario::Suite::set`].
    pub set: Vec<String>,
    /// Which runs in which programs decide are made twice: `none`, `some` or `all`.
    pub verify_runs: String,
    /// What the files were when it was written.
    pub texts: Vec<TextDigest>,
    /// The programs that decide.
    pub programs: Vec<PlannedProgram>,
    /// What the canary run comes to.
    pub canary: String,
    /// How many units follow.
    pub units: usize,
    /// How long all of them may take on one core, s.
    pub seconds: f64,
}

/// A program that decides in runs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedProgram {
    /// By which scenarios name it.
    pub name: String,
    /// That declares it.
    pub file: String,
    /// Of its declaration and of the files that it names, hexadecimal.
    pub digest: String,
}

/// A unit of the manifest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManifestUnit {
    /// SHA-256 of all that decides its runs, hexadecimal.
    pub id: String,
    /// Which unit of the session it is, or is of.
    pub unit: usize,
    /// The first of its runs and how many they are; `None` for a unit whose runs are decided as they come.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub runs: Option<(usize, usize)>,
    /// Of a search that is shared out, for which of its groups of people, counted from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<usize>,
    /// How long it may take on one core, s.
    pub seconds: f64,
    /// In the session.
    pub name: String,
}

impl ManifestHeader {
    /// Of this build.
    pub fn new(build: Build, canary: String) -> Self {
        Self {
            format: FORMAT.to_string(),
            version: VERSION,
            build,
            files: Vec::new(),
            seed: None,
            set: Vec::new(),
            verify_runs: "some".to_string(),
            texts: Vec::new(),
            programs: Vec::new(),
            canary,
            units: 0,
            seconds: 0.0,
        }
    }
}

/// What is in a manifest that was written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrittenManifest {
    /// How many units.
    pub units: usize,
    /// In so many batches.
    pub batches: usize,
    /// How long all of them may take on one core, s.
    pub seconds: f64,
}

/// Writes a manifest of units, which come in any order.
///
/// # Errors
/// If the file cannot be written.
pub fn write_manifest(
    path: &Path,
    header: ManifestHeader,
    mut planned: Vec<PlannedUnit>,
    units: &Units,
) -> std::io::Result<WrittenManifest> {
    planned.sort_unstable_by_key(|one| (one.id, one.unit, one.part));
    let seconds = rounded(planned.iter().map(|one| f64::from(one.seconds)).sum());
    let mut file = SealedWriter::create(path)?;
    file.line(&ManifestHeader { units: planned.len(), seconds, ..header })?;
    let (mut batches, mut filling) = (0, Filling::default());
    for one in &planned {
        let (runs, group) = match one.part {
            UnitPart::Runs { first, runs } => (Some((first as usize, runs as usize)), None),
            UnitPart::Group(group) => (None, Some(group as usize)),
            UnitPart::Whole => (None, None),
        };
        let unit = ManifestUnit {
            id: one.id.to_string(),
            unit: one.unit as usize,
            runs,
            group,
            seconds: rounded(f64::from(one.seconds)),
            name: units.key(one.unit as usize),
        };
        batches += usize::from(filling.begins(&unit));
        file.line(&unit)?;
    }
    file.finish()?;
    Ok(WrittenManifest { units: planned.len(), batches, seconds })
}

/// A batch that takes units, until it is full.
#[derive(Debug, Default)]
struct Filling {
    units: usize,
    seconds: f64,
}

impl Filling {
    /// Takes a unit; whether it is the first of a batch, as it has no room in the one before.
    fn begins(&mut self, unit: &ManifestUnit) -> bool {
        let is_full = self.seconds + unit.seconds > BATCH || self.units >= LARGEST_BATCH;
        let begins = self.units == 0 || is_full;
        if begins {
            *self = Self::default();
        }
        self.units += 1;
        self.seconds += unit.seconds;
        begins
    }
}

/// To a microsecond, so that a line is short.
fn rounded(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}

/// A manifest that was found whole, read again a batch at a time.
#[derive(Debug, Clone)]
pub struct ManifestReader {
    path: PathBuf,
    header: ManifestHeader,
    digest: String,
}

impl ManifestReader {
    /// Reads all of it once.
    ///
    /// # Errors
    /// If it is no manifest, of another version or not whole.
    pub fn open(path: &Path) -> Result<Self, ShardError> {
        let mut lines = SealedReader::open(path)?;
        let header = header(&mut lines)?;
        let mut units = 0;
        let digest = loop {
            match lines.next_line()? {
                Ok(_) => units += 1,
                Err(digest) => break digest,
            }
        };
        if units != header.units {
            return Err(wrong(
                path,
                format!("it says that there are {} units, and has {units}", header.units),
            ));
        }
        Ok(Self { path: path.to_path_buf(), header, digest })
    }

    /// Refuses a manifest of another build.
    ///
    /// # Errors
    /// If `here` is not what it is of.
    pub fn check_build(&self, here: &Build) -> Result<(), ShardError> {
        if self.header.build == *here {
            return Ok(());
        }
        let (found, here) = (Box::new(self.header.build.clone()), Box::new(here.clone()));
        Err(ShardError::OtherBuild { path: self.path.clone(), found, here })
    }

    /// Its first line.
    pub fn header(&self) -> &ManifestHeader {
        &self.header
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its units in batches of about a second, in its order.
    ///
    /// # Errors
    /// If it cannot be read any more.
    pub fn batches(&self) -> Result<Batches, ShardError> {
        let mut lines = SealedReader::open(&self.path)?;
        if header(&mut lines)? != self.header {
            return Err(wrong(&self.path, "it was changed meanwhile"));
        }
        Ok(Batches { lines, next: None, number: 0, is_over: false, digest: self.digest.clone() })
    }
}

fn header(lines: &mut SealedReader) -> Result<ManifestHeader, ShardError> {
    parse_first(lines, (FORMAT, VERSION), ("it is no manifest of scenario-runner", "it is a manifest"))
}

/// Consecutive units whose results are one file.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitBatch {
    /// Counted from 0.
    pub number: usize,
    /// SHA-256 over the units' digests, hexadecimal.
    pub id: String,
    /// Never empty.
    pub units: Vec<ManifestUnit>,
}

impl UnitBatch {
    /// Where its results are, in a folder.
    pub fn path(&self, folder: &Path) -> PathBuf {
        folder.join(&self.id[..2]).join(format!("{}.jsonl", self.id))
    }
}

/// The batches of a manifest.
pub struct Batches {
    lines: SealedReader,
    next: Option<ManifestUnit>,
    number: usize,
    is_over: bool,
    digest: String,
}

impl Batches {
    fn unit(&mut self) -> Result<Option<ManifestUnit>, ShardError> {
        if let Some(unit) = self.next.take() {
            return Ok(Some(unit));
        }
        if self.is_over {
            return Ok(None);
        }
        let path = self.lines.path().to_path_buf();
        match self.lines.next_line()? {
            Ok(line) => parse(&path, line.text).map(Some),
            Err(digest) => {
                self.is_over = true;
                if digest == self.digest { Ok(None) } else { Err(wrong(&path, "it was changed meanwhile")) }
            }
        }
    }

    fn batch(&mut self) -> Result<Option<UnitBatch>, ShardError> {
        let (mut units, mut filling): (Vec<ManifestUnit>, Filling) = Default::default();
        while let Some(unit) = self.unit()? {
            if filling.begins(&unit) && !units.is_empty() {
                self.next = Some(unit);
                break;
            }
            units.push(unit);
        }
        if units.is_empty() {
            return Ok(None);
        }
        let number = self.number;
        self.number += 1;
        Ok(Some(UnitBatch { number, id: digest_of(units.iter().map(|unit| &unit.id)), units }))
    }
}

impl Iterator for Batches {
    type Item = Result<UnitBatch, ShardError>;

    fn next(&mut self) -> Option<Self::Item> {
        let batch = self.batch().transpose();
        // After what is wrong there is nothing.
        self.is_over |= matches!(batch, Some(Err(_)));
        batch
    }
}
