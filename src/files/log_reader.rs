//! What an appending log looks like, and reading one, record by record.
//!
//! Each line is a JSON object whose last member is a checksum of everything before it, of the first line, and of the
//! line's place: a flipped bit, a record that is missing, doubled, exchanged or from another log is found. The first line
//! is the header. What a killed process leaves unfinished is the last line, and is cut; everything else is refused.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::read::{Lines, ReadError};

/// Longer records are neither written nor read, bytes.
pub const LARGEST_RECORD: u64 = 16 << 20;

/// A kind of log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LogFormat {
    /// Such as `scenario-runner search journal`.
    pub name: &'static str,
    /// Raised when a reader would have to change.
    pub version: u32,
}

/// The first line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// [`LogFormat::name`].
    pub log: String,
    /// [`LogFormat::version`].
    pub version: u32,
    /// What the records belong to.
    pub of: serde_json::Value,
}

/// Why a log cannot be used. All but the first leave it as it is.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LogError {
    /// The system refuses to open, write or lock it.
    #[error("{}: {error}", path.display())]
    Io {
        /// The log.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// It cannot be read, or is larger than may be read.
    #[error("{}: {error}", path.display())]
    Read {
        /// The log.
        path: PathBuf,
        /// What is wrong.
        error: ReadError,
    },
    /// Another process appends to it.
    #[error("{} is in use by another process; let that one finish, or name another file", path.display())]
    InUse {
        /// The log.
        path: PathBuf,
    },
    /// Its first line is no header of a log, or of one of another kind.
    #[error("{} is no {expected}; name another file, or move it away", path.display())]
    NotALog {
        /// The file.
        path: PathBuf,
        /// The kind of log that was asked for, in words.
        expected: &'static str,
    },
    /// It was written by a version with another layout.
    #[error("{} is a {expected} of version {found}, but this version of scenario-runner reads {known}; finish with the version that wrote it, or delete it", path.display())]
    OtherVersion {
        /// The log.
        path: PathBuf,
        /// The kind of log that was asked for, in words.
        expected: &'static str,
        /// The layout that it states.
        found: u32,
        /// The layout that is read here.
        known: u32,
    },
    /// It belongs to another subject, such as another suite or seed.
    #[error("{} is the {expected} of something else: {difference}; delete it, or name another file", path.display())]
    OtherSubject {
        /// The log.
        path: PathBuf,
        /// The kind of log, in words.
        expected: &'static str,
        /// What differs, in words.
        difference: String,
    },
    /// A record that is not the last is cut off, or its checksum is not that of its text.
    #[error("{}, line {line}: {reason}; restore it, or delete it and begin anew", path.display())]
    Damaged {
        /// The log.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong with it, in words.
        reason: String,
    },
    /// A record that is to be written would not be read again.
    #[error("{}: a record of {length} bytes is longer than a record may be", path.display())]
    RecordTooLong {
        /// The log.
        path: PathBuf,
        /// In bytes.
        length: usize,
    },
}

/// The checksum's member, at the end of a line.
const MEMBER: &str = ",\"crc\":\"";
/// Of `,"crc":"01234567"}`.
const ENDING: usize = MEMBER.len() + 8 + 2;

/// The line of a record, a JSON object with at least one member, with its line break. `seed` is the checksum of the
/// header, 0 for the header itself; `place` counts from 0, the header.
pub(super) fn line(seed: u32, place: u64, record: &str) -> String {
    let body = record.strip_suffix('}').expect("a record is an object");
    debug_assert!(body.len() > 1 && !body.contains('\n'), "with a member, on one line: {record}");
    format!("{body}{MEMBER}{:08x}\"}}\n", checksum(seed, place, body.as_bytes()))
}

/// The record in a line, if that is whole.
pub(super) fn record(seed: u32, place: u64, line: &[u8]) -> Option<String> {
    let line = line.strip_suffix(b"\n")?;
    let (body, ending) = line.split_at_checked(line.len().checked_sub(ENDING)?)?;
    let digits = ending.strip_prefix(MEMBER.as_bytes())?.strip_suffix(b"\"}")?;
    let known = format!("{:08x}", checksum(seed, place, body));
    (known.as_bytes() == digits).then(|| String::from_utf8(body.to_vec()).ok().map(|body| body + "}"))?
}

/// The checksum that a line states.
pub(super) fn stated(line: &str) -> u32 {
    let digits = line.trim_end().strip_suffix("\"}").and_then(|line| line.get(line.len() - 8..));
    digits.and_then(|digits| u32::from_str_radix(digits, 16).ok()).unwrap_or(0)
}

/// What a first line says, and its checksum.
pub(super) fn header(path: &Path, format: LogFormat, line: &[u8]) -> Result<(Header, u32), LogError> {
    let text = String::from_utf8_lossy(line);
    // Before the checksum: another version may have another one.
    let header = serde_json::from_str::<Header>(&text).ok().filter(|header| header.log == format.name);
    let header = header.ok_or_else(|| not_a_log(path, format))?;
    if header.version != format.version {
        return Err(LogError::OtherVersion {
            path: path.to_owned(),
            expected: format.name,
            found: header.version,
            known: format.version,
        });
    }
    match record(0, 0, line) {
        Some(_) => Ok((header, stated(&text))),
        None => Err(LogError::Damaged {
            path: path.to_owned(),
            line: 1,
            reason: "its checksum is wrong".to_string(),
        }),
    }
}

fn not_a_log(path: &Path, format: LogFormat) -> LogError {
    LogError::NotALog { path: path.to_owned(), expected: format.name }
}

fn checksum(seed: u32, place: u64, body: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&seed.to_le_bytes());
    hasher.update(&place.to_le_bytes());
    hasher.update(body);
    hasher.finalize()
}

/// A log that is read from its beginning to its end, in bounded memory.
#[derive(Debug)]
pub struct LogReader {
    path: PathBuf,
    lines: Lines,
    header: Header,
    seed: u32,
    /// Lines read.
    place: u64,
    /// Bytes of them.
    whole: u64,
    cut: Option<u64>,
}

impl LogReader {
    /// Opens a log for reading.
    ///
    /// # Errors
    /// If it is none of that format, or its header is damaged.
    pub fn open(path: &Path, format: LogFormat) -> Result<Self, LogError> {
        let lines = Lines::open(path, LARGEST_RECORD);
        let lines = lines.map_err(|error| LogError::Read { path: path.to_owned(), error })?;
        Self::begin(path, format, lines)
    }

    pub(super) fn of(path: &Path, format: LogFormat, file: File) -> Result<Self, LogError> {
        Self::begin(path, format, Lines::of(file, LARGEST_RECORD))
    }

    fn begin(path: &Path, format: LogFormat, mut lines: Lines) -> Result<Self, LogError> {
        let first = match lines.next_line() {
            Ok(line) => line.unwrap_or_default().to_vec(),
            Err(ReadError::TooLarge { .. }) => return Err(not_a_log(path, format)),
            Err(error) => return Err(LogError::Read { path: path.to_owned(), error }),
        };
        let (header, seed) = header(path, format, &first)?;
        let whole = first.len() as u64;
        Ok(Self { path: path.to_owned(), lines, header, seed, place: 1, whole, cut: None })
    }

    /// What it says of itself.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The next record, a JSON object; `None` at the end, also at one that was cut off.
    ///
    /// # Errors
    /// [`LogError::Damaged`] if something is wrong that a killed process does not leave.
    pub fn next_record(&mut self) -> Result<Option<String>, LogError> {
        if self.cut.is_some() {
            return Ok(None);
        }
        let read_error = |path: &Path, error| LogError::Read { path: path.to_owned(), error };
        let line_number = self.place as usize + 1;
        let damaged = |path: &Path, reason: &str| LogError::Damaged {
            path: path.to_owned(),
            line: line_number,
            reason: reason.to_string(),
        };
        let (found, length) = match self.lines.next_line() {
            Ok(None) => return Ok(None),
            Ok(Some(line)) => (record(self.seed, self.place, line), line.len() as u64),
            Err(ReadError::TooLarge { .. }) => {
                return Err(damaged(&self.path, "it is longer than a record may be"));
            }
            Err(error) => return Err(read_error(&self.path, error)),
        };
        if let Some(record) = found {
            self.place += 1;
            self.whole += length;
            return Ok(Some(record));
        }
        match self.lines.next_line() {
            Ok(None) => {
                self.cut = Some(length);
                Ok(None)
            }
            Ok(Some(_)) | Err(ReadError::TooLarge { .. }) => {
                Err(damaged(&self.path, "its checksum is wrong, or it does not belong at this place"))
            }
            Err(error) => Err(read_error(&self.path, error)),
        }
    }

    /// Once the end is reached: bytes of an unfinished last record, which are not to be used; `None` if all is whole.
    pub fn cut(&self) -> Option<u64> {
        self.cut
    }

    /// Records and bytes that are whole, the header among them.
    pub(super) fn position(&self) -> (u32, u64, u64) {
        (self.seed, self.place, self.whole)
    }

    /// What to tell whoever uses it.
    pub fn notice(&self) -> Option<String> {
        self.cut.map(|bytes| {
            format!(
                "{}: the last record was cut off while it was written ({bytes} bytes); it is left out",
                self.path.display()
            )
        })
    }
}
