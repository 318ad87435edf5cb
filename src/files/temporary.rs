//! A file beside the one that it is to replace, under a name that the next writer finds.
//!
//! The name is fixed, so that what a killed process leaves behind does not pile up; a lock tells what is left behind from
//! what is being written.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

/// How often and how long to wait for another process that writes the same file; writing takes milliseconds.
const TRIES: usize = 100;
const PAUSE: Duration = Duration::from_millis(20);

/// Longer names may not fit once something is added to them.
const LONGEST_NAME: usize = 240;

/// A file that goes away unless it is kept.
#[derive(Debug)]
pub(super) struct Temporary {
    path: PathBuf,
    /// Open, and locked, until it is closed.
    pub out: Option<BufWriter<File>>,
    kept: bool,
}

impl Temporary {
    /// Makes one beside `target`, with the permissions and the owner of the file that is there.
    ///
    /// # Errors
    /// If the folder takes no files, or if another process is writing the same file and goes on doing so.
    pub fn beside(target: &Path) -> io::Result<Self> {
        let path = beside(target, "tmp");
        for _ in 0..TRIES {
            if let Some(file) = claim(&path, target)? {
                return Ok(Self { path, out: Some(BufWriter::new(file)), kept: false });
            }
            thread::sleep(PAUSE);
        }
        Err(io::Error::new(
            io::ErrorKind::ResourceBusy,
            "another process is writing it; let that one finish, or name another file",
        ))
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// It has become something else, and is not to be removed.
    pub fn keep(&mut self) {
        self.kept = true;
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.kept {
            // Removed before the lock goes: nobody else can have claimed the name in between.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// `zebra.json` becomes `.zebra.json.tmp`.
pub(super) fn beside(target: &Path, ending: &str) -> PathBuf {
    let name = target.file_name().unwrap_or_default();
    let mut hidden = OsString::from(".");
    if name.len() > LONGEST_NAME {
        let mut hasher = DefaultHasher::new();
        name.hash(&mut hasher);
        hidden.push(format!("{:016x}", hasher.finish()));
    } else {
        hidden.push(name);
    }
    hidden.push(".");
    hidden.push(ending);
    target.with_file_name(hidden)
}

/// The new, locked file at `path`; `None` while another process has it. What is there without a lock is left from one
/// that was killed, and goes.
fn claim(path: &Path, target: &Path) -> io::Result<Option<File>> {
    match creating(target).open(path) {
        Ok(file) => match file.try_lock() {
            // Somebody may have taken it for left behind between its making and its locking.
            _ if !is_at(&file, path) => Ok(None),
            Err(TryLockError::WouldBlock) => Ok(None),
            // Where there are no locks, that much has to do.
            Ok(()) | Err(TryLockError::Error(_)) => Ok(Some(file)),
        },
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            let left = match existing().open(path) {
                Ok(left) => left,
                // Gone in the meantime; or a link that somebody put there, which is not followed.
                Err(_) => {
                    if path.symlink_metadata().is_ok_and(|metadata| metadata.is_symlink()) {
                        fs::remove_file(path)?;
                    }
                    return Ok(None);
                }
            };
            if left.try_lock().is_ok() && is_at(&left, path) {
                fs::remove_file(path)?;
            }
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

#[cfg(unix)]
fn creating(target: &Path) -> OpenOptions {
    use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    if let Ok(old) = target.metadata() {
        // At no moment may more people read it than the old one.
        options.mode(old.permissions().mode() & 0o777);
    }
    options
}

#[cfg(not(unix))]
fn creating(_: &Path) -> OpenOptions {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    options
}

#[cfg(unix)]
fn existing() -> OpenOptions {
    use std::os::unix::fs::OpenOptionsExt;
    let mut options = OpenOptions::new();
    let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
    options.read(true).custom_flags(flags.bits() as i32);
    options
}

#[cfg(not(unix))]
fn existing() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.read(true);
    options
}

/// Whether `path` still names the open file.
#[cfg(unix)]
pub(super) fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let (Ok(open), Ok(named)) = (file.metadata(), path.metadata()) else { return false };
    open.dev() == named.dev() && open.ino() == named.ino()
}

#[cfg(not(unix))]
pub(super) fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}
