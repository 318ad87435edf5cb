//! `--trace`: the course of every run in a file of its own.

use std::fs;
use std::io;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use crate::report::write_trace;
use crate::scenario::Case;
use crate::sim::Trace;

/// A folder for the courses of runs.
pub struct Traces<'a> {
    folder: &'a Path,
    complaints: Mutex<Vec<String>>,
}

impl<'a> Traces<'a> {
    pub fn new(folder: &'a Path) -> Self {
        Self { folder, complaints: Mutex::default() }
    }

    pub fn save(&self, case: &Case, trace: &Trace) {
        let path = self.folder.join(format!("{}.csv", case.key.replace('/', "__")));
        let written = fs::File::create(&path)
            .and_then(|file| write_trace(&case.world, trace, io::BufWriter::new(file)));
        if let Err(error) = written {
            let complaint = format!("cannot write {}: {error}", path.display());
            self.complaints.lock().unwrap_or_else(PoisonError::into_inner).push(complaint);
        }
    }

    /// What could not be written.
    pub fn complaints(&self) -> Vec<String> {
        std::mem::take(&mut self.complaints.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
