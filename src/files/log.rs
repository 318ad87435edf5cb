//! The appending log: records that are kept as they come, by one process at a time, and survive its end at any moment.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::destination::{Destination, destination};
use super::folder::make_folder;
use super::log_reader::{Header, LARGEST_RECORD, LogError, LogFormat, LogReader, line, stated};
use super::temporary::is_at;
use super::whole::{WholeFile, remove};

/// A log that is being written, locked as long as it is open.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    out: Out,
    /// Checksum of the header.
    seed: u32,
    /// Lines so far.
    place: u64,
    /// Bytes of them.
    whole: u64,
    /// Something went wrong that could not be undone: nothing more is added.
    broken: bool,
}

#[derive(Debug)]
enum Out {
    File(File),
    /// A pipe or a device, which keeps nothing.
    Stream(File),
}

/// What a log held when it was opened.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct LogContents {
    /// The records, each a JSON object.
    pub records: Vec<String>,
    /// What to tell the user, such as that the last record was cut off.
    pub notice: Option<String>,
}

impl Log {
    /// Opens the log at `path` to go on with it, or starts it, making the folders it is to be in. `of` is what it belongs
    /// to.
    ///
    /// # Errors
    /// If another process has it, if it is another log or damaged, or if it cannot be written.
    pub fn open(
        path: &Path,
        format: LogFormat,
        of: &impl Serialize,
    ) -> Result<(Self, LogContents), LogError> {
        let failed = |error| LogError::Io { path: path.to_owned(), error };
        if let Some(folder) = path.parent() {
            make_folder(folder).map_err(failed)?;
        }
        let mut file = locked(path)?;
        let header = header(format, of);
        let expected = line(0, 0, &header);
        let mut begun = Vec::new();
        let length = file.metadata().map_err(failed)?.len();
        if length < expected.len() as u64 {
            file.read_to_end(&mut begun).map_err(failed)?;
            // One that was cut off in its first line, or that has not begun.
            if expected.as_bytes().starts_with(&begun) {
                let mut log = Self::at(path, Out::File(file), 0, 0, 0);
                log.begin(&expected)?;
                return Ok((log, LogContents::default()));
            }
            file.seek(SeekFrom::Start(0)).map_err(failed)?;
        }
        let mut reader = LogReader::of(path, format, file.try_clone().map_err(failed)?)?;
        let wanted: Header = serde_json::from_str(&header).expect("it was just written");
        if reader.header().of != wanted.of {
            let difference = difference(&wanted.of, &reader.header().of);
            return Err(LogError::OtherSubject { path: path.to_owned(), expected: format.name, difference });
        }
        let mut records = Vec::new();
        while let Some(record) = reader.next_record()? {
            records.push(record);
        }
        let notice = reader.notice();
        let (seed, place, whole) = reader.position();
        drop(reader);
        // Only now, when it is known to be the right one, is it changed.
        file.set_len(whole).map_err(failed)?;
        file.seek(SeekFrom::Start(whole)).map_err(failed)?;
        Ok((Self::at(path, Out::File(file), seed, place, whole), LogContents { records, notice }))
    }

    /// Starts a log with `records` in the place of whatever is at `path`, at once: there is no moment without the one or
    /// the other. Pipes and devices are written directly.
    ///
    /// # Errors
    /// If another process has it, or if it cannot be written.
    pub fn create(
        path: &Path,
        format: LogFormat,
        of: &impl Serialize,
        records: &[String],
    ) -> Result<Self, LogError> {
        let failed = |error| LogError::Io { path: path.to_owned(), error };
        let header = line(0, 0, &header(format, of));
        let target = match destination(path).map_err(failed)? {
            Destination::File(target) => target,
            Destination::Stream(_) | Destination::StandardOutput | Destination::StandardError => {
                let out = OpenOptions::new().append(true).open(path).map_err(failed)?;
                let mut log = Self::at(path, Out::Stream(out), 0, 0, 0);
                log.begin(&header)?;
                records.iter().try_for_each(|record| log.append_text(record))?;
                return Ok(log);
            }
        };
        let mut new = WholeFile::create(&target).map_err(failed)?;
        // Whoever is writing the old one keeps it. Asked only now: this process alone may replace it.
        let old = target.exists().then(|| locked(&target)).transpose()?;
        let seed = stated(&header);
        let lines = (1..).zip(records).map(|(place, record)| line(seed, place, record));
        let text: String = std::iter::once(header).chain(lines).collect();
        let file = match new.write_all(text.as_bytes()).and_then(|()| new.commit_open()).map_err(failed)? {
            Some(file) => file,
            None => {
                drop(old);
                let mut file = locked(&target)?;
                file.seek(SeekFrom::End(0)).map_err(failed)?;
                file
            }
        };
        Ok(Self::at(path, Out::File(file), seed, 1 + records.len() as u64, text.len() as u64))
    }

    fn at(path: &Path, out: Out, seed: u32, place: u64, whole: u64) -> Self {
        Self { path: path.to_owned(), out, seed, place, whole, broken: false }
    }

    fn begin(&mut self, header: &str) -> Result<(), LogError> {
        self.seed = stated(header);
        if let Out::File(file) = &mut self.out {
            file.seek(SeekFrom::Start(0)).map_err(|error| self.failed(error))?;
        }
        self.add(header)
    }

    /// Adds a record, a JSON object with at least one member, and hands it to the operating system.
    ///
    /// # Errors
    /// If it cannot be written: then it is as if it had not been tried.
    pub fn append(&mut self, record: &impl Serialize) -> Result<(), LogError> {
        let text = serde_json::to_string(record).map_err(|error| self.failed(error.into()))?;
        self.append_text(&text)
    }

    fn append_text(&mut self, record: &str) -> Result<(), LogError> {
        self.add(&line(self.seed, self.place, record))
    }

    fn add(&mut self, line: &str) -> Result<(), LogError> {
        if line.len() as u64 > LARGEST_RECORD {
            return Err(LogError::RecordTooLong { path: self.path.clone(), length: line.len() });
        }
        if self.broken {
            return Err(self.failed(io::Error::other("nothing more is added after an error in writing it")));
        }
        let written = match &mut self.out {
            Out::Stream(out) => out.write_all(line.as_bytes()),
            Out::File(file) => file.write_all(line.as_bytes()).inspect_err(|_| {
                // Half a record may not stand before the next one.
                let undone =
                    file.set_len(self.whole).and_then(|()| file.seek(SeekFrom::Start(self.whole)).map(drop));
                self.broken = undone.is_err();
            }),
        };
        written.map_err(|error| self.failed(error))?;
        self.place += 1;
        self.whole += line.len() as u64;
        Ok(())
    }

    /// Waits until everything is on the disk.
    ///
    /// # Errors
    /// If that fails.
    pub fn sync(&self) -> Result<(), LogError> {
        match &self.out {
            Out::Stream(_) => Ok(()),
            Out::File(file) => file.sync_data().map_err(|error| self.failed(error)),
        }
    }

    /// Records so far, without the header.
    pub fn records(&self) -> u64 {
        self.place - 1
    }

    /// Where the log lies, as it was opened.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// It is not needed any more.
    ///
    /// # Errors
    /// If it is there and stays.
    pub fn remove(self) -> io::Result<()> {
        // While it is locked: nobody else has begun with it.
        remove(&self.path)
    }

    fn failed(&self, error: io::Error) -> LogError {
        LogError::Io { path: self.path.clone(), error }
    }
}

/// Adds text to a file of somebody else's, such as the summary of a step that GitHub collects.
///
/// # Errors
/// If it cannot be written.
pub fn append_text(path: &Path, text: &str) -> io::Result<()> {
    OpenOptions::new().create(true).append(true).open(path)?.write_all(text.as_bytes())
}

fn header(format: LogFormat, of: &impl Serialize) -> String {
    let of = serde_json::to_value(of).expect("plain data serialises");
    let header = Header { log: format.name.to_string(), version: format.version, of };
    serde_json::to_string(&header).expect("plain data serialises")
}

/// The file at `path`, made if it is not there, which no other process writes.
fn locked(path: &Path) -> Result<File, LogError> {
    let failed = |error| LogError::Io { path: path.to_owned(), error };
    if let Ok(metadata) = path.metadata() {
        let regular = super::read::regular(&metadata);
        regular.map_err(|error| LogError::Read { path: path.to_owned(), error })?;
    }
    loop {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => return Err(LogError::InUse { path: path.to_owned() }),
            // It was replaced or removed between opening and locking: that lock is on nothing.
            Ok(()) if !is_at(&file, path) => {}
            // Where there are no locks, nobody can be told apart.
            Ok(()) | Err(TryLockError::Error(_)) => return Ok(file),
        }
    }
}

/// The first member in which two descriptions differ.
fn difference(wanted: &serde_json::Value, found: &serde_json::Value) -> String {
    let (Some(ours), Some(theirs)) = (wanted.as_object(), found.as_object()) else {
        return format!("{found}, not {wanted}");
    };
    let mut names = ours.keys().chain(theirs.keys());
    let differing = names.find(|name| ours.get(*name) != theirs.get(*name));
    differing.map_or_else(String::new, |name| format!("`{name}` is another one"))
}
