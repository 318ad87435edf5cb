//! The bounded reader: regular files of a size that a person could have meant, or standard input as far.
//!
//! A pipe or a device might never end; a file from somebody else might be anything, under whatever name.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Larger files are not read whole, bytes.
pub const LARGEST: u64 = 64 << 20;

/// Why a file is not read. The path is not named: whoever asked for it says what it is to them.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// It is not there, or the system does not give it.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// It might never end.
    #[error("it is {found}, and a regular file was expected")]
    NotRegular {
        /// Such as `a named pipe`.
        found: &'static str,
    },
    /// It is larger than [`LARGEST`], or than whoever asked takes.
    #[error("it has more than {} MiB", most >> 20)]
    TooLarge {
        /// Bytes.
        most: u64,
    },
    /// It is no text.
    #[error("it is not UTF-8 text: byte {} is 0x{:02x}", valid.len(), invalid)]
    NotUtf8 {
        /// What could be read.
        valid: String,
        /// The byte after it.
        invalid: u8,
    },
    /// It is, or its links lead to, another kind of file. Nothing of what it holds was read.
    #[error("{}only files that end in {allowed} are read here", leading(leads_to))]
    OtherKind {
        /// What its links lead to.
        leads_to: Option<PathBuf>,
        /// Such as `.csv or .json`.
        allowed: String,
    },
}

fn leading(path: &Option<PathBuf>) -> String {
    path.as_ref().map_or_else(String::new, |path| format!("it leads to {}, and ", path.display()))
}

impl ReadError {
    /// Whether there is no such file.
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::Io(error) if error.kind() == io::ErrorKind::NotFound)
    }
}

/// A file's bytes, if there are at most `most`.
///
/// # Errors
/// [`ReadError`].
pub fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>, ReadError> {
    let file = open(path)?;
    // What the system says is checked first, since that costs nothing, and not believed, since it need not be true.
    if file.metadata()?.len() > most {
        return Err(ReadError::TooLarge { most });
    }
    limited(file, most)
}

/// A file's text, of at most [`LARGEST`] bytes.
///
/// # Errors
/// [`ReadError`].
pub fn read_text(path: &Path) -> Result<String, ReadError> {
    text(read_bytes(path, LARGEST)?)
}

/// As [`read_text`], for a file that may come from somebody else: its name has to end in one of `endings`, such as
/// `csv`, and so does the name of what its links lead to.
///
/// # Errors
/// [`ReadError::OtherKind`] before anything is read, and as [`read_text`].
pub fn read_kind(path: &Path, endings: &[&str]) -> Result<String, ReadError> {
    check_kind(path, endings)?;
    read_text(path)
}

/// Whether a path, and what its links lead to, ends in one of `endings`.
///
/// # Errors
/// [`ReadError::OtherKind`] if not, [`ReadError::Io`] if it is not there.
pub fn check_kind(path: &Path, endings: &[&str]) -> Result<(), ReadError> {
    check_name(path, endings)?;
    let real = path.canonicalize()?;
    if is_of_kind(&real, endings) { Ok(()) } else { Err(other_kind(Some(real), endings)) }
}

/// Whether a path ends in one of `endings`.
///
/// # Errors
/// [`ReadError::OtherKind`] if not.
pub(super) fn check_name(path: &Path, endings: &[&str]) -> Result<(), ReadError> {
    if is_of_kind(path, endings) { Ok(()) } else { Err(other_kind(None, endings)) }
}

fn is_of_kind(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| endings.contains(&ending))
}

fn other_kind(leads_to: Option<PathBuf>, endings: &[&str]) -> ReadError {
    let dotted: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
    let allowed = match &dotted[..] {
        [most @ .., last] if !most.is_empty() => format!("{} or {last}", most.join(", ")),
        all => all.concat(),
    };
    ReadError::OtherKind { leads_to, allowed }
}

/// What stands on standard input, of at most [`LARGEST`] bytes.
///
/// # Errors
/// [`ReadError`].
pub fn read_standard_input() -> Result<String, ReadError> {
    text(limited(io::stdin().lock(), LARGEST)?)
}

fn limited(from: impl Read, most: u64) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    from.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(ReadError::TooLarge { most }) } else { Ok(bytes) }
}

pub(super) fn text(bytes: Vec<u8>) -> Result<String, ReadError> {
    String::from_utf8(bytes).map_err(|error| {
        let (valid, bytes) = (error.utf8_error().valid_up_to(), error.as_bytes());
        ReadError::NotUtf8 {
            valid: String::from_utf8_lossy(&bytes[..valid]).into_owned(),
            invalid: bytes[valid],
        }
    })
}

/// A file opened for reading, if it is a regular one.
pub(super) fn open(path: &Path) -> Result<File, ReadError> {
    regular(&path.metadata()?)?;
    let file = without_waiting().open(path)?;
    // It may have become something else in between; then opening has not waited for it at least.
    regular(&file.metadata()?)?;
    Ok(file)
}

#[cfg(unix)]
fn without_waiting() -> OpenOptions {
    use std::os::unix::fs::OpenOptionsExt;
    let mut options = OpenOptions::new();
    options.read(true).custom_flags(rustix::fs::OFlags::NONBLOCK.bits() as i32);
    options
}

#[cfg(not(unix))]
fn without_waiting() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.read(true);
    options
}

pub(super) fn regular(metadata: &Metadata) -> Result<(), ReadError> {
    if metadata.is_file() { Ok(()) } else { Err(ReadError::NotRegular { found: kind(metadata) }) }
}

#[cfg(unix)]
fn kind(metadata: &Metadata) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    let kind = metadata.file_type();
    match () {
        () if kind.is_dir() => "a folder",
        () if kind.is_fifo() => "a named pipe",
        () if kind.is_char_device() || kind.is_block_device() => "a device",
        () if kind.is_socket() => "a socket",
        () => "something else",
    }
}

#[cfg(not(unix))]
fn kind(metadata: &Metadata) -> &'static str {
    if metadata.is_dir() { "a folder" } else { "something else" }
}

/// The lines of a file of any length, each of bounded length: for logs, results and manifests.
#[derive(Debug)]
pub struct Lines {
    reader: BufReader<File>,
    most: u64,
    line: Vec<u8>,
}

impl Lines {
    /// Of a regular file, with at most `most` bytes a line.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn open(path: &Path, most: u64) -> Result<Self, ReadError> {
        Ok(Self::of(open(path)?, most))
    }

    pub(super) fn of(file: File, most: u64) -> Self {
        Self { reader: BufReader::new(file), most, line: Vec::new() }
    }

    /// The next line, with its line break unless it is a last one without; `None` at the end.
    ///
    /// # Errors
    /// [`ReadError::TooLarge`] if it is longer than a line may be.
    pub fn next_line(&mut self) -> Result<Option<&[u8]>, ReadError> {
        self.line.clear();
        self.reader.by_ref().take(self.most + 1).read_until(b'\n', &mut self.line)?;
        if self.line.len() as u64 > self.most {
            return Err(ReadError::TooLarge { most: self.most });
        }
        Ok(Some(self.line.as_slice()).filter(|line| !line.is_empty()))
    }
}
