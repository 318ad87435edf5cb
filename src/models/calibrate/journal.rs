//! The journal of a calibration: one record per judged candidate, so that it can be resumed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::criteria::RetentionVerdict;
use files::{LARGEST_RECORD, Lines, Log, LogError, LogFormat, ReadError};

const FORMAT: LogFormat = LogFormat { name: "scenario-runner journal of a calibration", version: 2 };

/// Results so far, kept in a file.
#[derive(Debug)]
pub struct CalibrationJournal {
    known: BTreeMap<usize, RetentionVerdict>,
    log: Mutex<Log>,
    notice: Option<String>,
}

/// A judged candidate.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Judged {
    candidate: usize,
    /// The number of the criterion that it failed; retained without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    failed: Option<usize>,
}

/// What is wrong with a journal.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JournalError {
    /// It cannot be read or written, is in use, damaged, or the journal of something else.
    #[error("journal {0}")]
    Log(#[from] LogError),
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

impl CalibrationJournal {
    /// Opens the journal of the calibration that `fingerprint` identifies, or starts it.
    ///
    /// A last record that was cut off while being written is left out.
    ///
    /// # Errors
    /// If the file cannot be used, or belongs to another calibration.
    pub fn open(file: &Path, fingerprint: &str) -> Result<Self, JournalError> {
        let (log, records, notice) = match Log::open(file, FORMAT, &fingerprint) {
            Ok((log, found)) => (log, found.records, found.notice),
            Err(error @ LogError::NotALog { .. }) => {
                let records = old_records(file, fingerprint, error)?;
                let notice = format!(
                    "{} is from version 0.1 and has no checksums; it is taken over as it is",
                    file.display()
                );
                (Log::create(file, FORMAT, &fingerprint, &records)?, records, Some(notice))
            }
            Err(error) => return Err(error.into()),
        };
        let mut known = BTreeMap::new();
        for (index, record) in records.iter().enumerate() {
            let judged: Judged = serde_json::from_str(record).map_err(|_| JournalError::BadLine {
                file: file.to_owned(),
                line: index + 2,
                found: record.clone(),
            })?;
            known.insert(
                judged.candidate,
                judged.failed.map_or(RetentionVerdict::Retained, RetentionVerdict::Failed),
            );
        }
        Ok(Self { known, log: Mutex::new(log), notice })
    }

    /// What is known of a candidate.
    pub fn verdict(&self, number: usize) -> Option<RetentionVerdict> {
        self.known.get(&number).copied()
    }

    /// What to tell whoever goes on with it.
    pub fn notice(&self) -> Option<&str> {
        self.notice.as_deref()
    }

    /// Adds a result.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn add(&self, number: usize, verdict: RetentionVerdict) -> Result<(), JournalError> {
        let failed = match verdict {
            RetentionVerdict::Retained => None,
            RetentionVerdict::Failed(criterion) => Some(criterion),
        };
        let mut log = self.log.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        Ok(log.append(&Judged { candidate: number, failed })?)
    }
}

/// The records of a journal of version 0.1: the fingerprint in the first line, then lines such as `7 retained` or `7 2`.
/// `otherwise` if it is none.
fn old_records(file: &Path, fingerprint: &str, otherwise: LogError) -> Result<Vec<String>, JournalError> {
    let failed = |error: ReadError| LogError::Read { path: file.to_owned(), error };
    let mut lines = Lines::open(file, LARGEST_RECORD).map_err(failed)?;
    let mut records = Vec::new();
    for number in 1.. {
        let Some(line) = lines.next_line().map_err(failed)? else { break };
        let text = String::from_utf8_lossy(line).into_owned();
        let Some(text) = text.strip_suffix('\n') else { break };
        if number == 1 {
            if !text.starts_with("calibration ") {
                return Err(otherwise.into());
            }
            if text != fingerprint {
                let (path, expected) = (file.to_owned(), FORMAT.name);
                let difference = format!("it begins with `{text}`, not `{fingerprint}`");
                return Err(LogError::OtherSubject { path, expected, difference }.into());
            }
            continue;
        }
        let judged = old_record(text).ok_or_else(|| JournalError::BadLine {
            file: file.to_owned(),
            line: number,
            found: text.to_owned(),
        })?;
        records.push(serde_json::to_string(&judged).expect("plain data serialises"));
    }
    Ok(records)
}

fn old_record(line: &str) -> Option<Judged> {
    let (candidate, verdict) = line.split_once(' ')?;
    let failed = match verdict {
        "retained" => None,
        criterion => Some(criterion.parse().ok()?),
    };
    Some(Judged { candidate: candidate.parse().ok()?, failed })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_journal_goes_on_where_it_was_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("journal");
        let journal = CalibrationJournal::open(&file, "calibration 1").unwrap();
        journal.add(3, RetentionVerdict::Retained).unwrap();
        journal.add(1, RetentionVerdict::Failed(2)).unwrap();
        drop(journal);
        // Cut off in the middle of a record.
        fs::write(&file, fs::read_to_string(&file).unwrap() + "{\"candidate\":7").unwrap();
        let journal = CalibrationJournal::open(&file, "calibration 1").unwrap();
        assert!(journal.notice().unwrap().contains("cut off"), "{:?}", journal.notice());
        assert_eq!(journal.verdict(3), Some(RetentionVerdict::Retained));
        assert_eq!(journal.verdict(1), Some(RetentionVerdict::Failed(2)));
        assert_eq!(journal.verdict(7), None);
        journal.add(7, RetentionVerdict::Failed(0)).unwrap();
        drop(journal);
        let journal = CalibrationJournal::open(&file, "calibration 1").unwrap();
        assert_eq!((journal.verdict(7), journal.notice()), (Some(RetentionVerdict::Failed(0)), None));
    }

    #[test]
    fn another_calibration_and_damaged_records_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("journal");
        let journal = CalibrationJournal::open(&file, "calibration 1").unwrap();
        journal.add(3, RetentionVerdict::Retained).unwrap();
        journal.add(1, RetentionVerdict::Failed(2)).unwrap();
        drop(journal);
        let error = |fingerprint| CalibrationJournal::open(&file, fingerprint).unwrap_err().to_string();
        assert!(error("calibration 2").contains("of something else"), "{}", error("calibration 2"));
        let flipped = fs::read_to_string(&file).unwrap().replacen("\"candidate\":3", "\"candidate\":2", 1);
        fs::write(&file, flipped).unwrap();
        assert!(
            error("calibration 1").contains("line 2: its checksum is wrong"),
            "{}",
            error("calibration 1")
        );
    }

    #[test]
    fn a_journal_of_version_0_1_is_taken_over_with_a_notice() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("journal");
        let fixture = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/formats/calibration_0.1.journal");
        fs::copy(fixture, &file).unwrap();
        assert!(
            CalibrationJournal::open(&file, "calibration 2")
                .unwrap_err()
                .to_string()
                .contains("of something else")
        );
        let journal = CalibrationJournal::open(&file, "calibration 1").unwrap();
        assert!(journal.notice().unwrap().contains("version 0.1"), "{:?}", journal.notice());
        let known = |journal: &CalibrationJournal| [3, 1, 7, 8].map(|number| journal.verdict(number));
        let expected = [
            Some(RetentionVerdict::Retained),
            Some(RetentionVerdict::Failed(2)),
            Some(RetentionVerdict::Failed(0)),
            None,
        ];
        assert_eq!(known(&journal), expected);
        drop(journal);
        let journal = CalibrationJournal::open(&file, "calibration 1").unwrap();
        assert_eq!((known(&journal), journal.notice()), (expected, None));
        drop(journal);

        fs::write(&file, "calibration 1\nseven\n").unwrap();
        let error = CalibrationJournal::open(&file, "calibration 1").unwrap_err().to_string();
        assert!(error.contains("line 2: `seven` is no result"), "{error}");
        fs::write(&file, "a poem\n").unwrap();
        assert!(
            CalibrationJournal::open(&file, "calibration 1")
                .unwrap_err()
                .to_string()
                .contains("is no scenario-runner")
        );
        assert_eq!(fs::read_to_string(&file).unwrap(), "a poem\n");
    }
}
