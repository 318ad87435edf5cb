//! The journal: one record for each evaluation, so that a killed run resumes and ends with the same bits.
//!
//! Resuming replays: the optimiser asks anew, and what the journal holds is told instead of evaluated.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::Mutex;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Definition, Error, Evaluation, Optimiser, Point, Proposal};
use files::{LARGEST_RECORD, Lines, Log, LogError, LogFormat, ReadError};

const FORMAT: LogFormat = LogFormat { name: "scenario-runner journal of evaluations", version: 2 };

/// One evaluation in the journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Entry {
    id: u64,
    point: Point,
    evaluation: Evaluation,
}

/// What the evaluations belong to. A larger budget goes on from where a smaller one ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Subject {
    /// Points asked for at once: part of what determines the proposals.
    batch: usize,
    /// Without its budget.
    definition: Definition,
}

/// The first line of a journal of version 0.1, which had no checksums.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct OldHeader {
    journal: u32,
    batch: usize,
    definition: Definition,
}

/// An append-only record of one run's evaluations.
#[derive(Debug)]
pub struct Journal {
    log: Log,
    recorded: BTreeMap<u64, Entry>,
    notice: Option<String>,
}

impl Journal {
    /// Opens the journal of a run, or starts it when there is none; `batch` is how many points the run asks for at once.
    ///
    /// # Errors
    /// [`Error::Journal`] when it cannot be read or written, is in use, damaged, or belongs to something else;
    /// [`Error::JournalContent`] when what it holds makes no sense.
    pub fn open(path: &Path, definition: &Definition, batch: usize) -> Result<Self, Error> {
        let subject = Subject { batch, definition: definition.without_budget() };
        let (log, records, notice) = match Log::open(path, FORMAT, &subject) {
            Ok((log, found)) => (log, found.records, found.notice),
            Err(error @ LogError::NotALog { .. }) => {
                let records = old_records(path, &subject, error)?;
                let log = Log::create(path, FORMAT, &subject, &records)?;
                let notice = format!(
                    "{} is from version 0.1 and has no checksums; it is taken over as it is",
                    path.display()
                );
                (log, records, Some(notice))
            }
            Err(error) => return Err(error.into()),
        };
        let mut journal = Journal { log, recorded: BTreeMap::new(), notice };
        for (index, record) in records.iter().enumerate() {
            let line = index + 2;
            let entry: Entry =
                serde_json::from_str(record).map_err(|error| journal.damaged(line, error.to_string()))?;
            if journal.recorded.contains_key(&entry.id) {
                return Err(journal.damaged(line, format!("evaluation {} is recorded twice", entry.id)));
            }
            journal.recorded.insert(entry.id, entry);
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

    /// What to tell whoever resumes from it.
    pub fn notice(&self) -> Option<&str> {
        self.notice.as_deref()
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

    /// Appends an evaluation and hands it to the operating system.
    ///
    /// # Errors
    /// [`Error::Journal`] when it cannot be written.
    pub fn record(&mut self, proposal: &Proposal, evaluation: &Evaluation) -> Result<(), Error> {
        let Proposal { id, point, .. } = proposal.clone();
        let entry = Entry { id, point, evaluation: evaluation.clone() };
        self.log.append(&entry)?;
        self.recorded.insert(id, entry);
        Ok(())
    }

    /// It is not needed any more.
    ///
    /// # Errors
    /// When it is there and stays.
    pub fn remove(self) -> io::Result<()> {
        self.log.remove()
    }

    fn damaged(&self, line: usize, reason: String) -> Error {
        Error::JournalContent { path: self.log.path().display().to_string(), line, reason }
    }
}

/// The records of a journal of version 0.1; `otherwise` if it is none of this subject's. A last line without a line break
/// was being written when the run was killed.
fn old_records(path: &Path, subject: &Subject, otherwise: LogError) -> Result<Vec<String>, Error> {
    let failed = |error: ReadError| LogError::Read { path: path.to_owned(), error };
    let mut lines = Lines::open(path, LARGEST_RECORD).map_err(failed)?;
    let mut header = None;
    let mut records = Vec::new();
    while let Some(line) = lines.next_line().map_err(failed)? {
        let Some(line) = line.strip_suffix(b"\n") else { break };
        if header.is_none() {
            let Ok(first) = serde_json::from_slice::<OldHeader>(line) else { return Err(otherwise.into()) };
            let definition = first.definition.without_budget();
            if (first.journal, first.batch, &definition) != (1, subject.batch, &subject.definition) {
                return Err(LogError::OtherSubject {
                    path: path.to_owned(),
                    expected: FORMAT.name,
                    difference: "its definition or batch size is another one".to_string(),
                }
                .into());
            }
            header = Some(first);
        } else if !line.is_empty() {
            let number = records.len() + 2;
            let damaged = |error: serde_json::Error| Error::JournalContent {
                path: path.display().to_string(),
                line: number,
                reason: error.to_string(),
            };
            // As this version writes it, lest what is not understood is carried on.
            let entry: Entry = serde_json::from_slice(line).map_err(damaged)?;
            records.push(serde_json::to_string(&entry).map_err(damaged)?);
        }
    }
    if header.is_some() { Ok(records) } else { Err(otherwise.into()) }
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
            let evaluation = evaluate(proposal).checked(optimiser.definition())?;
            if let Some(mut journal) = lock() {
                journal.record(proposal, &evaluation)?;
            }
            Ok(evaluation)
        };
        let evaluations: Vec<Result<Evaluation, Error>> =
            proposals.par_iter().map(evaluate_or_recall).collect();
        for (proposal, evaluation) in proposals.iter().zip(evaluations) {
            optimiser.tell(proposal.id, evaluation?)?;
        }
    }
}
