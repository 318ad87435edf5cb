//! The journal: one line of JSON for each evaluation, flushed, so that a killed run resumes and ends with the same bits.
//!
//! Resuming replays: the optimiser asks anew, and what the journal holds is told instead of evaluated. The first line is the
//! run's definition; a last line cut short by a kill is dropped.

use super::{Definition, Error, Evaluation, Optimiser, Point, Proposal};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// One evaluation in the journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Entry {
    id: u64,
    point: Point,
    evaluation: Evaluation,
}

/// The first line: what the evaluations belong to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Header {
    journal: u32,
    /// Points asked for at once: part of what determines the proposals.
    batch: usize,
    definition: Definition,
}

const VERSION: u32 = 1;

/// An append-only record of one run's evaluations.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    recorded: BTreeMap<u64, Entry>,
}

impl Journal {
    /// Opens the journal of a run, or starts it when there is none; `batch` is how many points the run asks for at once.
    ///
    /// # Errors
    /// [`Error::JournalFile`] when it cannot be read or written; [`Error::JournalContent`] when it belongs to another definition
    /// or a line before the last one is damaged.
    pub fn open(path: &Path, definition: &Definition, batch: usize) -> Result<Self, Error> {
        let failed = |source| Error::JournalFile { path: path.display().to_string(), source };
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(failed)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed)?;
        let mut journal = Journal { path: path.to_owned(), file, recorded: BTreeMap::new() };
        let header = Header { journal: VERSION, batch, definition: definition.clone() };
        let header_text = serde_json::to_vec(&header).map_err(|error| failed(error.into()))?;
        // What follows the last line break was being written when the run was killed.
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
        let mut lines = bytes[..whole].split(|&byte| byte == b'\n').enumerate();
        let other = "it does not belong to this definition and batch size; delete it or restore them";
        if whole == 0 && !header_text.starts_with(&bytes) {
            return Err(journal.damaged(1, other.to_owned()));
        }
        if let Some((_, line)) = lines.next().filter(|_| whole > 0)
            && journal.parse::<Header>(1, line)? != header
        {
            return Err(journal.damaged(1, other.to_owned()));
        }
        for (index, line) in lines.filter(|(_, line)| !line.is_empty()) {
            let entry: Entry = journal.parse(index + 1, line)?;
            if journal.recorded.contains_key(&entry.id) {
                return Err(journal.damaged(index + 1, format!("evaluation {} is recorded twice", entry.id)));
            }
            journal.recorded.insert(entry.id, entry);
        }
        // Only now, when the file is known to be this run's journal, is it changed.
        journal.file.set_len(whole as u64).map_err(failed)?;
        journal.file.seek(SeekFrom::End(0)).map_err(failed)?;
        if whole == 0 {
            journal.write(&header)?;
        }
        Ok(journal)
    }

    /// Number of evaluations it holds.
    pub fn len(&self) -> usize {
        self.recorded.len()
    }

    /// Does it hold none?
    pub fn is_empty(&self) -> bool {
        self.recorded.is_empty()
    }

    /// What was recorded for a proposal, if anything.
    ///
    /// # Errors
    /// [`Error::JournalContent`] when it was recorded for another point.
    pub fn recorded(&self, proposal: &Proposal) -> Result<Option<&Evaluation>, Error> {
        match self.recorded.get(&proposal.id) {
            Some(entry) if entry.point != proposal.point => Err(self.damaged(
                2 + self.recorded.range(..entry.id).count(),
                format!("evaluation {} is recorded for another point than is now proposed", entry.id),
            )),
            found => Ok(found.map(|entry| &entry.evaluation)),
        }
    }

    /// Appends an evaluation and flushes it to the operating system.
    ///
    /// # Errors
    /// [`Error::JournalFile`] when it cannot be written.
    pub fn record(&mut self, proposal: &Proposal, evaluation: &Evaluation) -> Result<(), Error> {
        let Proposal { id, point, .. } = proposal.clone();
        let entry = Entry { id, point, evaluation: evaluation.clone() };
        self.write(&entry)?;
        self.recorded.insert(id, entry);
        Ok(())
    }

    fn write(&mut self, line: &impl Serialize) -> Result<(), Error> {
        let write = |file: &mut File| {
            let mut text = serde_json::to_vec(line)?;
            text.push(b'\n');
            file.write_all(&text)?;
            file.flush()
        };
        write(&mut self.file)
            .map_err(|source| Error::JournalFile { path: self.path.display().to_string(), source })
    }

    fn parse<T: for<'de> Deserialize<'de>>(&self, line: usize, text: &[u8]) -> Result<T, Error> {
        serde_json::from_slice(text).map_err(|error| self.damaged(line, error.to_string()))
    }

    fn damaged(&self, line: usize, reason: String) -> Error {
        Error::JournalContent { path: self.path.display().to_string(), line, reason }
    }
}

/// Runs an optimiser to its end: asks for `batch` points at a time, evaluates them in parallel on rayon's current pool and
/// records each as it is done. Evaluations the journal holds already are not repeated.
///
/// # Errors
/// The journal's and those of [`Optimiser::tell`].
pub fn run(
    optimiser: &mut Optimiser,
    batch: usize,
    journal: Option<&mut Journal>,
    evaluate: impl Fn(&Proposal) -> Evaluation + Sync,
) -> Result<(), Error> {
    try_run(optimiser, batch, journal, |proposal| Ok(evaluate(proposal)))
}

/// As [`run`], but evaluations may fail. One that does ends the run and is not recorded: a later run tries it again.
///
/// # Errors
/// The first of `evaluate` in the order of the proposals, and those of [`run`].
pub fn try_run<E: From<Error> + Send>(
    optimiser: &mut Optimiser,
    batch: usize,
    journal: Option<&mut Journal>,
    evaluate: impl Fn(&Proposal) -> Result<Evaluation, E> + Sync,
) -> Result<(), E> {
    let journal = journal.map(Mutex::new);
    loop {
        let proposals = optimiser.ask(batch.max(1));
        if proposals.is_empty() {
            return Ok(());
        }
        let evaluate_or_recall = |proposal: &Proposal| {
            let lock = || {
                journal.as_ref().map(|journal| journal.lock().unwrap_or_else(|broken| broken.into_inner()))
            };
            if let Some(journal) = lock()
                && let Some(evaluation) = journal.recorded(proposal)?
            {
                return Ok(evaluation.clone());
            }
            // NaN has no JSON: record what `tell` will make of it, so that a resumed run is told the same.
            let evaluation = evaluate(proposal)?.checked(optimiser.definition())?;
            if let Some(mut journal) = lock() {
                journal.record(proposal, &evaluation)?;
            }
            Ok(evaluation)
        };
        let evaluations: Vec<Result<Evaluation, E>> = proposals.par_iter().map(evaluate_or_recall).collect();
        for (proposal, evaluation) in proposals.iter().zip(evaluations) {
            optimiser.tell(proposal.id, evaluation?)?;
        }
    }
}
