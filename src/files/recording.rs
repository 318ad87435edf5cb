//! The disk, with a memory of what was asked of it and answered: whether it would still answer so.
//!
//! What is remembered of a file is a digest of the bytes that were handed out, not of what stands there a moment later. So nothing that
//! changes is missed, whenever it changes: while it is read, while what was read is made use of, or at the same second and size.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use sha2::{Digest, Sha256};

use super::read::{ReadError, read_bytes};
use super::source::{Disk, Files, PatternError};

/// Files up to this size are read again to see whether they changed; of larger ones what the system says of them is looked at first, bytes.
const SMALL: u64 = 1 << 20;

/// No more of a file that somebody else reads is looked at, bytes.
const LARGEST_BESIDES: u64 = 1 << 30;

/// So many paths of a pattern are looked at, more than a suite may have.
const MOST_MATCHES: usize = 32_768;

/// The file system, which remembers what it was asked. Clones share what they remember.
#[derive(Debug, Clone, Default)]
pub struct RecordingDisk(Arc<Mutex<BTreeMap<Question, Noted>>>);

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Question {
    Read {
        path: PathBuf,
        endings: Vec<String>,
        most: u64,
    },
    /// Of a file that somebody else reads.
    Besides(PathBuf),
    Identity(PathBuf),
    IsFile(PathBuf),
    IsFolder(PathBuf),
    Matching(String),
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Answer {
    Bytes([u8; 32]),
    /// In words, why there is none.
    Failed(String),
    Path(PathBuf),
    Is(bool),
    Paths(Vec<PathBuf>),
}

#[derive(Debug, Clone)]
struct Noted {
    /// `None` where it was not always the same.
    answer: Option<Answer>,
    stamp: Option<Stamp>,
}

/// What the system says of a file, which changes with it as far as its clock can tell.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Stamp {
    length: u64,
    modified: Option<SystemTime>,
    inode: (u64, i64, i64),
}

impl Stamp {
    fn of(path: &Path) -> Option<Self> {
        let metadata = path.metadata().ok()?;
        let (length, modified) = (metadata.len(), metadata.modified().ok());
        Some(Self { length, modified, inode: inode(&metadata) })
    }
}

/// Which file it is, and when anything of it was changed.
#[cfg(unix)]
fn inode(metadata: &Metadata) -> (u64, i64, i64) {
    use std::os::unix::fs::MetadataExt;
    (metadata.ino(), metadata.ctime(), metadata.ctime_nsec())
}

#[cfg(not(unix))]
fn inode(_metadata: &Metadata) -> (u64, i64, i64) {
    (0, 0, 0)
}

impl Question {
    /// What the disk says to it now.
    fn ask(&self) -> Answer {
        match self {
            Self::Read { path, endings, most } => {
                let endings: Vec<&str> = endings.iter().map(String::as_str).collect();
                read_answer(&Disk.read(path, &endings, *most))
            }
            Self::Besides(path) => read_answer(&read_bytes(path, LARGEST_BESIDES)),
            Self::Identity(path) => Answer::Path(Disk.identity(path)),
            Self::IsFile(path) => Answer::Is(Disk.is_file(path)),
            Self::IsFolder(path) => Answer::Is(Disk.is_folder(path)),
            Self::Matching(pattern) => match Disk.matching(pattern) {
                Ok(paths) => Answer::Paths(paths.take(MOST_MATCHES).collect()),
                Err(error) => Answer::Failed(error.to_string()),
            },
        }
    }

    /// The file whose bytes it asks for.
    fn read(&self) -> Option<&Path> {
        match self {
            Self::Read { path, .. } | Self::Besides(path) => Some(path),
            Self::Identity(_) | Self::IsFile(_) | Self::IsFolder(_) | Self::Matching(_) => None,
        }
    }

    /// What it is about.
    fn path(&self) -> PathBuf {
        match self {
            Self::Read { path, .. }
            | Self::Besides(path)
            | Self::Identity(path)
            | Self::IsFile(path)
            | Self::IsFolder(path) => path.clone(),
            Self::Matching(pattern) => pattern.into(),
        }
    }
}

fn read_answer(read: &Result<Vec<u8>, ReadError>) -> Answer {
    match read {
        Ok(bytes) => Answer::Bytes(Sha256::digest(bytes).into()),
        Err(error) => Answer::Failed(error.to_string()),
    }
}

impl RecordingDisk {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<Question, Noted>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Remembers an answer; `stamp` is from before it was asked for.
    fn note(&self, question: Question, answer: Answer, stamp: Option<Stamp>) {
        let mut noted = self.lock();
        let known = noted.entry(question).or_insert_with(|| Noted { answer: Some(answer.clone()), stamp });
        if known.answer.as_ref() != Some(&answer) {
            known.answer = None;
        }
    }

    /// Remembers what is in a file that somebody else reads, such as a program that is started.
    pub fn besides(&self, path: &Path) {
        let (question, stamp) = (Question::Besides(path.to_path_buf()), Stamp::of(path));
        let answer = question.ask();
        self.note(question, answer, stamp);
    }

    /// What would be answered otherwise now than it was: paths, and patterns of paths. Nothing that is remembered changes.
    pub fn changed(&self) -> BTreeSet<PathBuf> {
        // Asked without the lock, so that whoever reads meanwhile need not wait.
        let noted = self.lock().clone();
        let differs = |(question, Noted { answer, stamp }): &(Question, Noted)| {
            let Some(answer) = answer else { return true };
            let now = question.read().and_then(Stamp::of);
            let is_same = now.is_some() && now == *stamp && now.is_some_and(|now| now.length > SMALL);
            !is_same && question.ask() != *answer
        };
        noted.into_iter().filter(differs).map(|(question, _)| question.path()).collect()
    }

    /// Whether whatever both were asked was answered alike.
    pub fn agrees_with(&self, other: &Self) -> bool {
        let own = self.lock().clone();
        let other = other.lock();
        own.iter().all(|(question, noted)| {
            other.get(question).is_none_or(|other| other.answer == noted.answer && noted.answer.is_some())
        })
    }

    /// The files that were read or were to be read.
    pub fn files(&self) -> BTreeSet<PathBuf> {
        self.lock().keys().filter_map(|question| Some(question.read()?.to_path_buf())).collect()
    }

    /// The folders in which something could change that would change an answer, as far as they are there.
    pub fn folders(&self) -> BTreeSet<PathBuf> {
        let noted = self.lock();
        let mut folders = BTreeSet::new();
        for question in noted.keys() {
            let path = question.path();
            // A link may lead elsewhere, and what it leads to is what changes.
            for place in [Some(path.clone()), path.canonicalize().ok()].into_iter().flatten() {
                let above = place.ancestors().skip(1).map(|above| match above.as_os_str().is_empty() {
                    true => Path::new("."),
                    false => above,
                });
                folders.extend(above.filter(|above| above.is_dir()).take(1).map(Path::to_path_buf));
            }
        }
        for (_, Noted { answer, .. }) in noted.iter() {
            let Some(Answer::Paths(paths)) = answer else { continue };
            let parents = paths.iter().filter_map(|path| path.parent());
            folders.extend(parents.filter(|parent| !parent.as_os_str().is_empty()).map(Path::to_path_buf));
        }
        folders
    }
}

impl Files for RecordingDisk {
    fn read(&self, path: &Path, endings: &[&str], most: u64) -> Result<Vec<u8>, ReadError> {
        let stamp = Stamp::of(path);
        let read = Disk.read(path, endings, most);
        let endings = endings.iter().map(ToString::to_string).collect();
        self.note(Question::Read { path: path.to_path_buf(), endings, most }, read_answer(&read), stamp);
        read
    }

    fn identity(&self, path: &Path) -> PathBuf {
        let identity = Disk.identity(path);
        self.note(Question::Identity(path.to_path_buf()), Answer::Path(identity.clone()), None);
        identity
    }

    fn is_file(&self, path: &Path) -> bool {
        let is = Disk.is_file(path);
        self.note(Question::IsFile(path.to_path_buf()), Answer::Is(is), None);
        is
    }

    fn is_folder(&self, path: &Path) -> bool {
        let is = Disk.is_folder(path);
        self.note(Question::IsFolder(path.to_path_buf()), Answer::Is(is), None);
        is
    }

    fn matching<'a>(&'a self, pattern: &str) -> Result<Box<dyn Iterator<Item = PathBuf> + 'a>, PatternError> {
        let paths: Vec<PathBuf> = Disk.matching(pattern)?.take(MOST_MATCHES).collect();
        self.note(Question::Matching(pattern.to_string()), Answer::Paths(paths.clone()), None);
        Ok(Box::new(paths.into_iter()))
    }

    /// Not remembered: it helps to say what is near a name that is not there, and nothing depends on it.
    fn names(&self, folder: &Path) -> Vec<String> {
        Disk.names(folder)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn names(paths: BTreeSet<PathBuf>) -> Vec<String> {
        paths.iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect()
    }

    /// A recording in which `a.scn` was read with this text.
    fn read(folder: &Path, text: &str) -> RecordingDisk {
        fs::write(folder.join("a.scn"), text).unwrap();
        let recording = RecordingDisk::default();
        assert_eq!(recording.read_text(&folder.join("a.scn"), &["scn"]).unwrap(), text);
        assert!(recording.changed().is_empty());
        recording
    }

    #[test]
    fn content_counts_and_not_the_clock() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.scn");
        let recording = read(folder.path(), "one");
        let modified = fs::metadata(&path).unwrap().modified().unwrap();
        fs::write(&path, "two").unwrap();
        fs::File::options().write(true).open(&path).unwrap().set_modified(modified).unwrap();
        assert_eq!(names(recording.changed()), ["a.scn"], "same size and time");
        fs::write(&path, "one").unwrap();
        assert!(recording.changed().is_empty(), "what was read stands there again");
    }

    #[test]
    fn replaced_removed_and_unreadable_files_are_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.scn");
        let recording = read(folder.path(), "one");
        fs::write(folder.path().join("new"), "two").unwrap();
        fs::rename(folder.path().join("new"), &path).unwrap();
        assert_eq!(names(recording.changed()), ["a.scn"]);
        fs::remove_file(&path).unwrap();
        assert_eq!(names(recording.changed()), ["a.scn"]);
        fs::create_dir(&path).unwrap();
        assert_eq!(names(recording.changed()), ["a.scn"]);
        fs::remove_dir(&path).unwrap();
        fs::write(&path, "one").unwrap();
        assert!(recording.changed().is_empty());
    }

    #[test]
    fn a_file_that_was_not_there_is_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let below = folder.path().join("later");
        let recording = RecordingDisk::default();
        assert!(recording.read(&below.join("a.csv"), &["csv"], 9).unwrap_err().is_missing());
        assert!(!recording.is_file(&below.join("b.csv")));
        assert!(recording.changed().is_empty());
        assert_eq!(names(recording.files()), ["a.csv"]);
        assert!(recording.folders().contains(folder.path()), "the nearest folder that is there");
        fs::create_dir(&below).unwrap();
        assert!(recording.changed().is_empty());
        fs::write(below.join("b.csv"), "x").unwrap();
        assert_eq!(names(recording.changed()), ["b.csv"]);
        fs::write(below.join("a.csv"), "x").unwrap();
        assert_eq!(names(recording.changed()), ["a.csv", "b.csv"]);
    }

    #[test]
    fn a_pattern_that_matches_something_else_is_changed() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.scn"), "").unwrap();
        let recording = RecordingDisk::default();
        let pattern = folder.path().join("*.scn").display().to_string();
        assert_eq!(recording.matching(&pattern).unwrap().count(), 1);
        fs::write(folder.path().join("b.txt"), "").unwrap();
        assert!(recording.changed().is_empty());
        fs::write(folder.path().join("b.scn"), "").unwrap();
        assert_eq!(names(recording.changed()), ["*.scn"]);
    }

    /// What was read first is stale, and so may be what was made of both.
    #[test]
    fn a_file_that_was_read_with_two_contents_stays_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.scn");
        let recording = read(folder.path(), "one");
        fs::write(&path, "two").unwrap();
        recording.read(&path, &["scn"], super::super::read::LARGEST).unwrap();
        assert_eq!(names(recording.changed()), ["a.scn"]);
        fs::write(&path, "one").unwrap();
        assert_eq!(names(recording.changed()), ["a.scn"]);
    }

    #[test]
    fn large_files_and_those_that_others_read_are_seen_to_change() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("program");
        let mut bytes = vec![7; 2 * SMALL as usize];
        fs::write(&path, &bytes).unwrap();
        let recording = RecordingDisk::default();
        recording.besides(&path);
        assert!(recording.changed().is_empty());
        bytes[5] = 8;
        std::thread::sleep(std::time::Duration::from_millis(20));
        fs::write(&path, &bytes).unwrap();
        assert_eq!(names(recording.changed()), ["program"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_that_leads_elsewhere_is_changed() {
        let folder = tempfile::tempdir().unwrap();
        let (link, elsewhere) = (folder.path().join("a.scn"), folder.path().join("below"));
        fs::create_dir(&elsewhere).unwrap();
        fs::write(elsewhere.join("one.scn"), "one").unwrap();
        fs::write(elsewhere.join("two.scn"), "two").unwrap();
        std::os::unix::fs::symlink(elsewhere.join("one.scn"), &link).unwrap();
        let recording = RecordingDisk::default();
        recording.read(&link, &["scn"], 9).unwrap();
        assert!(recording.folders().contains(&elsewhere.canonicalize().unwrap()));
        fs::remove_file(&link).unwrap();
        std::os::unix::fs::symlink(elsewhere.join("two.scn"), &link).unwrap();
        assert_eq!(names(recording.changed()), ["a.scn"]);
    }
}
