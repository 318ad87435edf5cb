//! The journal of a calibration: what each candidate did in each condition, so that a run that is cut off goes on.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::super::journal_file::journal_file;
use files::{Log, LogError, LogFormat};

const FORMAT: LogFormat = LogFormat { name: "scenario-runner journal of weighed candidates", version: 1 };

/// In how many runs of a condition a candidate did it, and in how many that cannot be said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct HeldRuns {
    pub held: u32,
    pub undefined: u32,
    /// Runs that do not count.
    #[serde(default)]
    pub not_counted: u32,
    /// Runs of which nobody knows whether they count.
    #[serde(default)]
    pub unknown: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    /// 0: the runs that weights come from; 1: fresh noise.
    pass: u32,
    candidate: usize,
    done: Vec<HeldRuns>,
}

/// What is known so far, in a file if there is a folder for it.
pub struct HeldRecord {
    known: BTreeMap<(u32, usize), Vec<HeldRuns>>,
    log: Option<Log>,
    pub notice: Option<String>,
}

impl HeldRecord {
    /// `inputs` is everything that decides what candidates do; it and the version are part of the file's name.
    pub fn open(
        folder: Option<&Path>,
        name: &str,
        inputs: &impl Serialize,
        conditions: usize,
    ) -> Result<Self, LogError> {
        let Some(folder) = folder else {
            return Ok(Self { known: BTreeMap::new(), log: None, notice: None });
        };
        let decisive = (inputs, env!("CARGO_PKG_VERSION"));
        let (path, hash) = journal_file(folder, name, &decisive)?;
        let (log, found) = Log::open(&path, FORMAT, &hash)?;
        let mut known = BTreeMap::new();
        for record in &found.records {
            // One that is no entry, or of other conditions, is made again.
            if let Ok(entry) = serde_json::from_str::<Entry>(record)
                && entry.done.len() == conditions
            {
                known.insert((entry.pass, entry.candidate), entry.done);
            }
        }
        Ok(Self { known, log: Some(log), notice: found.notice })
    }

    pub fn known(&self, pass: u32, candidate: usize) -> Option<&Vec<HeldRuns>> {
        self.known.get(&(pass, candidate))
    }

    pub fn add(&mut self, pass: u32, candidate: usize, done: Vec<HeldRuns>) -> Result<(), LogError> {
        let entry = Entry { pass, candidate, done };
        if let Some(log) = &mut self.log {
            log.append(&entry)?;
        }
        self.known.insert((pass, candidate), entry.done);
        Ok(())
    }

    /// The result is in the caller's hands.
    pub fn remove(self) {
        if let Some(log) = self.log {
            // Left behind, it costs only space.
            let _ = log.remove();
        }
    }
}
