//! The journal of a calibration: one line per judged candidate, so that it can be resumed.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use thiserror::Error;

use super::retention::Verdict;

/// Results so far, kept in a file.
#[derive(Debug)]
pub struct Journal {
    file: PathBuf,
    known: BTreeMap<usize, Verdict>,
    out: Mutex<File>,
}

/// What is wrong with a journal.
#[derive(Debug, Error)]
pub enum JournalError {
    /// It cannot be read or written.
    #[error("journal {}: {error}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
    /// It is the journal of something else.
    #[error("{} is the journal of another calibration; remove it, or name another", file.display())]
    OtherCalibration {
        /// The file.
        file: PathBuf,
    },
    /// A line makes no sense.
    #[error("{}, line {line}: `{found}` is no result; expected a candidate's number and `retained` or the number of the criterion it failed", file.display())]
    BadLine {
        /// The file.
        file: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What stands there.
        found: String,
    },
}

impl Journal {
    /// Opens the journal of the calibration that `fingerprint` identifies, or starts it.
    ///
    /// A last line that was cut off while being written is dropped.
    ///
    /// # Errors
    /// If the file cannot be used, or belongs to another calibration.
    pub fn open(file: &Path, fingerprint: &str) -> Result<Self, JournalError> {
        let failed = |error| JournalError::Io { file: file.to_owned(), error };
        let mut known = BTreeMap::new();
        let mut whole_length = 0;
        if file.exists() {
            let mut reader = BufReader::new(File::open(file).map_err(failed)?);
            let mut text = String::new();
            for line in 1.. {
                text.clear();
                let length = reader.read_line(&mut text).map_err(failed)?;
                if length == 0 || !text.ends_with('\n') {
                    break;
                }
                whole_length += length as u64;
                if line == 1 {
                    if text.trim_end() != fingerprint {
                        return Err(JournalError::OtherCalibration { file: file.to_owned() });
                    }
                    continue;
                }
                let (number, verdict) = parse(&text).ok_or_else(|| JournalError::BadLine {
                    file: file.to_owned(),
                    line,
                    found: text.trim_end().to_owned(),
                })?;
                known.insert(number, verdict);
            }
        }
        let mut out = OpenOptions::new().create(true).append(true).open(file).map_err(failed)?;
        out.set_len(whole_length).map_err(failed)?;
        if whole_length == 0 {
            writeln!(out, "{fingerprint}").map_err(failed)?;
        }
        Ok(Self { file: file.to_owned(), known, out: Mutex::new(out) })
    }

    /// What is known of a candidate.
    pub fn verdict(&self, number: usize) -> Option<Verdict> {
        self.known.get(&number).copied()
    }

    /// Adds a result.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn add(&self, number: usize, verdict: Verdict) -> Result<(), JournalError> {
        let line = match verdict {
            Verdict::Retained => format!("{number} retained\n"),
            Verdict::Failed(criterion) => format!("{number} {criterion}\n"),
        };
        let mut out = self.out.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        out.write_all(line.as_bytes()).map_err(|error| JournalError::Io { file: self.file.clone(), error })
    }
}

fn parse(line: &str) -> Option<(usize, Verdict)> {
    let (number, verdict) = line.trim_end().split_once(' ')?;
    let verdict = match verdict {
        "retained" => Verdict::Retained,
        criterion => Verdict::Failed(criterion.parse().ok()?),
    };
    Some((number.parse().ok()?, verdict))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_journal_goes_on_where_it_was_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("journal");
        let journal = Journal::open(&file, "calibration 1").unwrap();
        journal.add(3, Verdict::Retained).unwrap();
        journal.add(1, Verdict::Failed(2)).unwrap();
        drop(journal);
        // Cut off in the middle of a line.
        fs::write(&file, fs::read_to_string(&file).unwrap() + "7 ret").unwrap();
        let journal = Journal::open(&file, "calibration 1").unwrap();
        assert_eq!(journal.verdict(3), Some(Verdict::Retained));
        assert_eq!(journal.verdict(1), Some(Verdict::Failed(2)));
        assert_eq!(journal.verdict(7), None);
        journal.add(7, Verdict::Failed(0)).unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), "calibration 1\n3 retained\n1 2\n7 0\n");
    }

    #[test]
    fn another_calibration_and_bad_lines_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("journal");
        fs::write(&file, "calibration 1\nseven\n").unwrap();
        let error = |fingerprint| Journal::open(&file, fingerprint).unwrap_err().to_string();
        assert!(error("calibration 2").contains("another calibration"));
        assert!(error("calibration 1").contains("line 2: `seven` is no result"));
    }
}
