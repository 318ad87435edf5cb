//! The journal of an estimate: what became of its runs, so that one that is cut off goes on.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::super::journal_file::journal_file;
use super::scored_run::{ScoredEncounter, ScoredRun};
use files::{Log, LogError, LogFormat};

const FORMAT: LogFormat = LogFormat { name: "scenario-runner journal of an estimate", version: 2 };

/// Runs one after the other.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    /// The number of the first, from 0.
    first: usize,
    runs: Vec<ScoredRun>,
    /// In the same encounters, of the scenario that it is compared with.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    others: Vec<ScoredRun>,
}

impl Entry {
    fn new(first: usize, encounters: &[ScoredEncounter]) -> Self {
        let runs = encounters.iter().map(|one| one.own).collect();
        Self { first, runs, others: encounters.iter().filter_map(|one| one.other).collect() }
    }

    fn encounters(self) -> Vec<ScoredEncounter> {
        let mut others = self.others.into_iter();
        self.runs.into_iter().map(|own| ScoredEncounter { own, other: others.next() }).collect()
    }
}

/// What is known so far, in a file if there is a folder for it.
pub struct EstimateRecord {
    known: BTreeMap<usize, Vec<ScoredEncounter>>,
    log: Option<Log>,
    pub notice: Option<String>,
}

impl EstimateRecord {
    /// `inputs` is everything that decides what becomes of runs; it and the version are part of the file's name.
    pub fn open(folder: Option<&Path>, name: &str, inputs: &impl Serialize) -> Result<Self, LogError> {
        let Some(folder) = folder else {
            return Ok(Self { known: BTreeMap::new(), log: None, notice: None });
        };
        let decisive = (inputs, env!("CARGO_PKG_VERSION"));
        let (path, hash) = journal_file(folder, name, &decisive)?;
        let (log, found) = Log::open(&path, FORMAT, &hash)?;
        let entries = found.records.iter().filter_map(|record| serde_json::from_str::<Entry>(record).ok());
        let known = entries.map(|entry| (entry.first, entry.encounters())).collect();
        Ok(Self { known, log: Some(log), notice: found.notice })
    }

    /// The runs from that number on, if so many are known; others are made again.
    pub fn known(&self, first: usize, count: usize) -> Option<&Vec<ScoredEncounter>> {
        self.known.get(&first).filter(|runs| runs.len() == count)
    }

    pub fn add(&mut self, first: usize, encounters: &[ScoredEncounter]) -> Result<(), LogError> {
        match &mut self.log {
            Some(log) => log.append(&Entry::new(first, encounters)),
            None => Ok(()),
        }
    }

    /// The result is in the caller's hands.
    pub fn remove(self) {
        if let Some(log) = self.log {
            // Left behind, it costs only space.
            let _ = log.remove();
        }
    }
}
