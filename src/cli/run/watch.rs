//! `--trace`: the course of every run in a file of its own.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use clap::ValueEnum;

use files::{Batch, WholeFile};
use report::{TraceColumns, write_trace_with};
use scenario::Case;
use sim::Trace;

/// What is written of everybody.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Columns {
    /// Time, place, velocity, acceleration, mode and events.
    Plain,
    /// With `s_m`, `d_m` and `heading_rad`.
    Full,
}

impl From<Columns> for TraceColumns {
    fn from(columns: Columns) -> Self {
        match columns {
            Columns::Plain => Self::Plain,
            Columns::Full => Self::Full,
        }
    }
}

/// A folder for the courses of runs.
pub struct Traces<'a> {
    folder: &'a Path,
    columns: Columns,
    files: Batch,
    complaints: Mutex<Vec<String>>,
}

impl<'a> Traces<'a> {
    pub fn new(folder: &'a Path, columns: Columns) -> Self {
        Self { folder, columns, files: Batch::default(), complaints: Mutex::default() }
    }

    pub fn save(&self, case: &Case, trace: &Trace) {
        let path = self.folder.join(format!("{}.csv", case.key.replace('/', "__")));
        let written = WholeFile::create(&path).and_then(|mut file| {
            write_trace_with(&case.world, trace, self.columns.into(), &mut file)?;
            self.files.add(file)
        });
        if let Err(error) = written {
            let complaint = format!("cannot write {}: {error}", path.display());
            self.complaints.lock().unwrap_or_else(PoisonError::into_inner).push(complaint);
        }
    }

    /// Puts all files in their places, and says what could not be written.
    pub fn finish(&self) -> Vec<String> {
        let mut complaints =
            std::mem::take(&mut *self.complaints.lock().unwrap_or_else(PoisonError::into_inner));
        let failed = self.files.finish().into_iter();
        complaints.extend(failed.map(|(path, error)| format!("cannot write {}: {error}", path.display())));
        complaints
    }
}
