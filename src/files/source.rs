//! Where texts are read from: the disk, memory, or both.

use std::collections::BTreeMap;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glob::{MatchOptions, Pattern};

pub use glob::PatternError;

use super::read::{LARGEST, ReadError, check_kind, check_name, read_bytes, text};

/// Files that can be read, by path. Nothing is written through it.
pub trait Files: fmt::Debug + Send + Sync {
    /// The bytes of the file at `path`, at most `most` of them. Its name, and that of what its links lead to, ends in one
    /// of `endings`, such as `csv`.
    ///
    /// # Errors
    /// [`ReadError`]; [`ReadError::OtherKind`] before anything is read.
    fn read(&self, path: &Path, endings: &[&str], most: u64) -> Result<Vec<u8>, ReadError>;

    /// What tells whether two paths are the same file.
    fn identity(&self, path: &Path) -> PathBuf;

    /// Whether there is a file at `path`.
    fn is_file(&self, path: &Path) -> bool;

    /// Whether there is a folder at `path`.
    fn is_folder(&self, path: &Path) -> bool;

    /// The files and folders whose paths match `pattern`, which knows `*`, `**`, `?` and `[abc]`. They are looked for as they are
    /// taken, so that whoever has enough need not wait for all.
    ///
    /// # Errors
    /// If it is no pattern.
    fn matching<'a>(&'a self, pattern: &str) -> Result<Box<dyn Iterator<Item = PathBuf> + 'a>, PatternError>;

    /// The names in a folder, to say which is near one that is not there; none if they cannot be known.
    fn names(&self, folder: &Path) -> Vec<String>;

    /// As [`Self::read`], for text of at most [`LARGEST`] bytes.
    ///
    /// # Errors
    /// As [`Self::read`], and [`ReadError::NotUtf8`].
    fn read_text(&self, path: &Path, endings: &[&str]) -> Result<String, ReadError> {
        text(self.read(path, endings, LARGEST)?)
    }
}

/// The file system: regular files of bounded size.
#[derive(Debug, Clone, Copy, Default)]
pub struct Disk;

impl Files for Disk {
    fn read(&self, path: &Path, endings: &[&str], most: u64) -> Result<Vec<u8>, ReadError> {
        check_kind(path, endings)?;
        read_bytes(path, most)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        path.canonicalize().or_else(|_| std::path::absolute(path)).unwrap_or_else(|_| path.to_path_buf())
    }

    fn is_file(&self, path: &Path) -> bool {
        path.is_file()
    }

    fn is_folder(&self, path: &Path) -> bool {
        path.is_dir()
    }

    fn matching<'a>(&'a self, pattern: &str) -> Result<Box<dyn Iterator<Item = PathBuf> + 'a>, PatternError> {
        Ok(Box::new(glob::glob(pattern)?.filter_map(Result::ok)))
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let entries = std::fs::read_dir(folder).into_iter().flatten();
        entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect()
    }
}

/// Texts by path, for tests and for programs that make theirs: there is nothing else.
#[derive(Debug, Clone, Default)]
pub struct Memory(BTreeMap<PathBuf, Arc<str>>);

impl Memory {
    /// With one text more, or another in its place.
    pub fn with(mut self, path: impl Into<PathBuf>, text: impl Into<Arc<str>>) -> Self {
        self.0.insert(path.into(), text.into());
        self
    }
}

impl Files for Memory {
    fn read(&self, path: &Path, endings: &[&str], most: u64) -> Result<Vec<u8>, ReadError> {
        check_name(path, endings)?;
        let missing = || ReadError::Io(io::Error::new(io::ErrorKind::NotFound, "there is no such text"));
        bounded(self.0.get(path).ok_or_else(missing)?, most)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        path.to_path_buf()
    }

    fn is_file(&self, path: &Path) -> bool {
        self.0.contains_key(path)
    }

    fn is_folder(&self, path: &Path) -> bool {
        self.0.keys().any(|file| file != path && file.starts_with(path))
    }

    fn matching<'a>(&'a self, pattern: &str) -> Result<Box<dyn Iterator<Item = PathBuf> + 'a>, PatternError> {
        let options = MatchOptions { require_literal_separator: true, ..MatchOptions::new() };
        let pattern = Pattern::new(&straightened(pattern))?;
        let matches = move |path: &&PathBuf| pattern.matches_path_with(path, options);
        Ok(Box::new(self.0.keys().filter(matches).cloned()))
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        let inside = self.0.keys().filter(|path| path.parent() == Some(folder));
        inside.filter_map(|path| Some(path.file_name()?.to_str()?.to_string())).collect()
    }
}

/// Other files, in which texts stand for some of them: what is being edited and was not saved.
#[derive(Debug)]
pub struct Overlay<'a> {
    under: &'a dyn Files,
    /// By what tells their files from others.
    texts: BTreeMap<PathBuf, &'a str>,
}

impl<'a> Overlay<'a> {
    /// `text` stands for the file at `path`.
    pub fn new(under: &'a dyn Files, path: &Path, text: &'a str) -> Self {
        Self::of(under).with(path, text)
    }

    /// Other files as they are.
    pub fn of(under: &'a dyn Files) -> Self {
        Self { under, texts: BTreeMap::new() }
    }

    /// The same, with `text` for the file at `path`.
    pub fn with(mut self, path: &Path, text: &'a str) -> Self {
        self.texts.insert(self.under.identity(path), text);
        self
    }
}

impl Files for Overlay<'_> {
    fn read(&self, path: &Path, endings: &[&str], most: u64) -> Result<Vec<u8>, ReadError> {
        match self.texts.get(&self.under.identity(path)) {
            Some(text) => bounded(text, most),
            None => self.under.read(path, endings, most),
        }
    }

    fn identity(&self, path: &Path) -> PathBuf {
        self.under.identity(path)
    }

    fn is_file(&self, path: &Path) -> bool {
        self.under.is_file(path)
    }

    fn is_folder(&self, path: &Path) -> bool {
        self.under.is_folder(path)
    }

    fn matching<'b>(&'b self, pattern: &str) -> Result<Box<dyn Iterator<Item = PathBuf> + 'b>, PatternError> {
        self.under.matching(pattern)
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        self.under.names(folder)
    }
}

/// Without `.` and without `..` after a name: in memory there are no links.
fn straightened(pattern: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in pattern.split('/') {
        match (part, parts.last()) {
            (".", _) => {}
            ("..", Some(&last)) if !matches!(last, "" | "..") => _ = parts.pop(),
            _ => parts.push(part),
        }
    }
    parts.join("/")
}

fn bounded(text: &str, most: u64) -> Result<Vec<u8>, ReadError> {
    if text.len() as u64 > most { Err(ReadError::TooLarge { most }) } else { Ok(text.as_bytes().to_vec()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_keeps_the_same_promises_as_the_disk() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a.csv"), "x\n1\n").unwrap();
        std::fs::write(at("a.txt"), "no").unwrap();
        let memory = Memory::default().with(at("a.csv"), "x\n1\n").with(at("a.txt"), "no");
        let overlay = Overlay::new(&Disk, &at("a.csv"), "x\n1\n");
        for files in [&Disk as &dyn Files, &memory, &overlay] {
            assert_eq!(files.read_text(&at("a.csv"), &["csv"]).unwrap(), "x\n1\n");
            let error = |name: &str, most| files.read(&at(name), &["csv"], most).unwrap_err();
            assert!(matches!(error("a.txt", 9), ReadError::OtherKind { .. }));
            assert!(matches!(error("a.csv", 3), ReadError::TooLarge { most: 3 }));
            assert!(error("b.csv", 9).is_missing());
            let mut names = files.names(folder.path());
            names.sort();
            assert_eq!(names, ["a.csv", "a.txt"]);
            assert_eq!(files.identity(&at("a.csv")), files.identity(&at("a.csv")));
        }
    }

    #[test]
    fn an_overlay_stands_for_its_file_under_every_name_of_it() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a.csv"), "saved").unwrap();
        std::fs::write(at("b.csv"), "other").unwrap();
        let overlay = Overlay::new(&Disk, &at("a.csv"), "edited");
        assert_eq!(overlay.read_text(&at("./a.csv"), &["csv"]).unwrap(), "edited");
        assert_eq!(overlay.read_text(&at("b.csv"), &["csv"]).unwrap(), "other");
    }
}
