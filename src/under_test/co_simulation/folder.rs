//! Folders in which units are unpacked: gone with whoever made them or, where he was ended from one moment to the next, with the next
//! that is made.
//!
//! Its owner holds a lock on a file in it, which the system takes from him when he ends, however that happens. A folder gets its name
//! only once that is locked, so that nobody takes one that is just being made for one that was left.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Of folders that are being made.
const NEW: &str = "scenario-runner-new-";
/// Of those that are in use, or were left.
#[cfg(unix)]
const IN_USE: &str = "scenario-runner-fmu-";
const LOCK: &str = "owner.lock";

/// A folder of our own for as long as this is there.
pub struct OwnFolder {
    path: PathBuf,
    _lock: File,
}

impl OwnFolder {
    /// A new one in this folder, into which only its user may look. What others have left there is removed (on Unix).
    ///
    /// # Errors
    /// If it cannot be made.
    #[expect(clippy::disallowed_methods, reason = "a file that is locked and never written")]
    pub fn new(place: &Path) -> io::Result<Self> {
        let made = tempfile::Builder::new().prefix(NEW).tempdir_in(place)?;
        let lock = File::create_new(made.path().join(LOCK))?;
        lock.try_lock().map_err(|error| match error {
            TryLockError::Error(error) => error,
            TryLockError::WouldBlock => io::ErrorKind::WouldBlock.into(),
        })?;
        // Elsewhere a folder cannot be renamed in which a file is open.
        #[cfg(unix)]
        let made = {
            let name = made.path().file_name().and_then(|name| name.to_str()).unwrap_or_default();
            let named = place.join(name.replacen(NEW, IN_USE, 1));
            rename(made.path(), &named)?;
            sweep(place, &named);
            // Under its first name it is gone already.
            let _ = made.keep();
            named
        };
        #[cfg(not(unix))]
        let made = made.keep();
        Ok(Self { path: made, _lock: lock })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for OwnFolder {
    fn drop(&mut self) {
        remove(&self.path);
    }
}

#[cfg(unix)]
#[expect(clippy::disallowed_methods, reason = "a folder of nobody's results, which nobody else knows yet")]
fn rename(from: &Path, to: &Path) -> io::Result<()> {
    fs::rename(from, to)
}

#[expect(
    clippy::disallowed_methods,
    reason = "a folder of nobody's results; what cannot be removed now is swept by the next"
)]
fn remove(folder: &Path) {
    let _ = fs::remove_dir_all(folder);
}

/// Removes folders of the same user whose owners are gone.
#[cfg(unix)]
#[expect(clippy::disallowed_methods, reason = "a file that is locked and never read")]
fn sweep(place: &Path, own: &Path) {
    use std::os::unix::fs::MetadataExt;
    let user =
        |path: &Path| fs::symlink_metadata(path).ok().filter(fs::Metadata::is_dir).map(|known| known.uid());
    let Ok(entries) = fs::read_dir(place) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        let is_one = entry.file_name().to_str().is_some_and(|name| name.starts_with(IN_USE));
        if !is_one || path == own || user(&path) != user(own) {
            continue;
        }
        // Whose owner is there, that is locked. One without it is not ours.
        if let Ok(lock) = File::open(path.join(LOCK))
            && lock.try_lock().is_ok()
        {
            remove(&path);
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn what_was_left_is_swept_and_what_is_in_use_is_not() {
        let place = tempfile::tempdir().unwrap();
        let living = OwnFolder::new(place.path()).unwrap();
        // As an owner leaves it who is ended from one moment to the next.
        let left = OwnFolder::new(place.path()).unwrap();
        let left_path = left.path().to_owned();
        let lock = left._lock.try_clone().unwrap();
        std::mem::forget(left);
        std::fs::write(left_path.join("library.so"), "code").unwrap();
        // Others' folders, though they are called alike.
        let other = place.path().join("scenario-runner-fmu-other");
        std::fs::create_dir(&other).unwrap();
        let being_made = place.path().join("scenario-runner-new-other");
        std::fs::create_dir(&being_made).unwrap();
        std::fs::write(being_made.join(LOCK), "").unwrap();
        // It is locked still, by whoever has it.
        drop(OwnFolder::new(place.path()).unwrap());
        assert!(left_path.exists());
        lock.unlock().unwrap();
        drop(OwnFolder::new(place.path()).unwrap());
        assert!(!left_path.exists());
        assert!(living.path().join(LOCK).exists() && other.exists() && being_made.exists());
        let path = living.path().to_owned();
        drop(living);
        assert!(!path.exists());
    }
}
