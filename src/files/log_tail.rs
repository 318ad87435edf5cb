//! A log that another process may be writing, read as it grows.

use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::log_reader::{LARGEST_RECORD, LogError, LogFormat, header, record};
use super::read::{Lines, ReadError, open};

/// How far a log was read. Nothing is locked and nothing held open: whoever writes it may remove it at any moment.
#[derive(Debug)]
pub struct LogTail {
    path: PathBuf,
    format: LogFormat,
    of: serde_json::Value,
    /// Checksum of the header.
    seed: u32,
    /// Lines read.
    place: u64,
    /// Bytes of them.
    whole: u64,
}

impl LogTail {
    /// Of the log at `path`, of which nothing was read yet. `of` is what it has to belong to.
    pub fn new(path: &Path, format: LogFormat, of: &impl Serialize) -> Self {
        let of = serde_json::to_value(of).expect("plain data serialises");
        Self { path: path.to_owned(), format, of, seed: 0, place: 0, whole: 0 }
    }

    /// The records since it was read last. A last line that has no end yet is not read, and where there is no log, there are none.
    ///
    /// # Errors
    /// If it is another log or damaged: what of it was not read yet is not to be used.
    pub fn more(&mut self) -> Result<Vec<String>, LogError> {
        let path = self.path.clone();
        let unread = |error| LogError::Read { path: path.clone(), error };
        let mut file = match open(&self.path) {
            Ok(file) => file,
            Err(error) if error.is_missing() => return Ok(Vec::new()),
            Err(error) => return Err(unread(error)),
        };
        let length = file.metadata().map_err(|error| unread(error.into()))?.len();
        if length < self.whole {
            // Somebody has begun it anew.
            (self.seed, self.place, self.whole) = (0, 0, 0);
        }
        if length == self.whole {
            return Ok(Vec::new());
        }
        file.seek(SeekFrom::Start(self.whole)).map_err(|error| unread(error.into()))?;
        let mut lines = Lines::of(file, LARGEST_RECORD);
        let mut records = Vec::new();
        loop {
            let line = match lines.next_line() {
                Ok(line) => line.filter(|line| line.ends_with(b"\n")),
                Err(ReadError::TooLarge { .. }) => {
                    return Err(self.damaged("it is longer than a record may be"));
                }
                Err(error) => return Err(unread(error)),
            };
            let Some(line) = line else { return Ok(records) };
            match self.place {
                0 => self.begin(line)?,
                _ => records.push(record(self.seed, self.place, line).ok_or_else(|| {
                    self.damaged("its checksum is wrong, or it does not belong at this place")
                })?),
            }
            self.place += 1;
            self.whole += line.len() as u64;
        }
    }

    fn begin(&mut self, line: &[u8]) -> Result<(), LogError> {
        let (header, seed) = header(&self.path, self.format, line)?;
        if header.of != self.of {
            let (path, expected) = (self.path.clone(), self.format.name);
            return Err(LogError::OtherSubject { path, expected, difference: "another one wrote it".into() });
        }
        self.seed = seed;
        Ok(())
    }

    fn damaged(&self, reason: &str) -> LogError {
        let (path, line) = (self.path.clone(), self.place as usize + 1);
        LogError::Damaged { path, line, reason: reason.to_string() }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use serde_json::{Value, json};

    use super::*;
    use crate::Log;

    const RUNS: LogFormat = LogFormat { name: "log of tests", version: 3 };

    fn of() -> Value {
        json!({ "seed": 1 })
    }

    #[test]
    fn a_log_is_read_as_it_grows_and_never_half_a_record() {
        let folder = tempfile::tempdir().unwrap();
        let (whole, path) = (folder.path().join("whole"), folder.path().join("a.jsonl"));
        let (mut log, _) = Log::open(&whole, RUNS, &of()).unwrap();
        (0..4).for_each(|run| log.append(&json!({ "run": run })).unwrap());
        let bytes = fs::read(&whole).unwrap();
        let mut tail = LogTail::new(&path, RUNS, &of());
        assert!(tail.more().unwrap().is_empty(), "it is not there yet");
        // A byte at a time.
        let mut read = Vec::new();
        for end in 0..=bytes.len() {
            fs::write(&path, &bytes[..end]).unwrap();
            read.extend(tail.more().unwrap());
            let lines = bytes[..end].iter().filter(|byte| **byte == b'\n').count();
            assert_eq!(read.len(), lines.saturating_sub(1), "{end} bytes");
        }
        assert_eq!(read[3], r#"{"run":3}"#);
        // Begun anew, it is read from its beginning; removed, it says nothing.
        let ends = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(place, _)| place + 1);
        let second = ends.take(2).last().unwrap();
        fs::write(&path, &bytes[..second]).unwrap();
        assert_eq!(tail.more().unwrap().len(), 1);
        fs::remove_file(&path).unwrap();
        assert!(tail.more().unwrap().is_empty());
    }

    #[test]
    fn what_is_damaged_or_of_others_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jsonl");
        let (mut log, _) = Log::open(&path, RUNS, &of()).unwrap();
        let mut tail = LogTail::new(&path, RUNS, &of());
        log.append(&json!({ "run": 0 })).unwrap();
        assert_eq!(tail.more().unwrap().len(), 1);
        let known = fs::read(&path).unwrap().len();
        (1..3).for_each(|run| log.append(&json!({ "run": run })).unwrap());
        let good = fs::read(&path).unwrap();
        for place in known..good.len() {
            let mut bytes = good.clone();
            bytes[place] ^= 1;
            fs::write(&path, &bytes).unwrap();
            let mut tail = LogTail { path: path.clone(), of: of(), ..tail };
            // A last line that has lost its end is one that is not written yet.
            let read = tail.more();
            let is_end = place == good.len() - 1;
            assert!(matches!(read, Err(LogError::Damaged { .. })) != is_end, "{place}: {read:?}");
        }
        fs::write(&path, &good).unwrap();
        let error = |format, of| LogTail::new(&path, format, &of).more().unwrap_err();
        assert!(matches!(error(RUNS, json!({ "seed": 2 })), LogError::OtherSubject { .. }));
        assert!(matches!(error(LogFormat { version: 4, ..RUNS }, of()), LogError::OtherVersion { .. }));
        assert!(matches!(error(LogFormat { name: "other", ..RUNS }, of()), LogError::NotALog { .. }));
    }
}
