//! Thousands of files at once: each atomic, all of them synced together.

use std::fs::File;
use std::io;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::folder::sync_folder;
use super::temporary::Temporary;
use super::whole::{Route, WholeFile, finished, settle};

/// Files that wait to be synced. What is killed before loses at most these, and never half of one.
const LARGEST_BATCH: usize = 4096;

/// Files that were written and wait for their names.
#[derive(Default)]
pub struct Batch {
    waiting: Mutex<Vec<(Temporary, PathBuf)>>,
    /// What went wrong so far.
    failures: Mutex<Vec<(PathBuf, io::Error)>>,
}

impl Batch {
    /// Takes a file over. It gets its name when the batch is full, or finished.
    ///
    /// # Errors
    /// If what is still in memory cannot be written.
    pub fn add(&self, file: WholeFile) -> io::Result<()> {
        let (mut temporary, target) = match file.route {
            Route::Beside { temporary, target } => (temporary, target),
            route => return WholeFile { route }.commit(),
        };
        // Closed, lest there are too many open ones.
        drop(finished(&mut temporary)?);
        let full = {
            let mut waiting = lock(&self.waiting);
            waiting.push((temporary, target));
            if waiting.len() < LARGEST_BATCH { Vec::new() } else { mem::take(&mut *waiting) }
        };
        self.settle(full);
        Ok(())
    }

    /// Gives all files their names, and says which could not get theirs.
    pub fn finish(&self) -> Vec<(PathBuf, io::Error)> {
        let waiting = mem::take(&mut *lock(&self.waiting));
        self.settle(waiting);
        mem::take(&mut *lock(&self.failures))
    }

    fn settle(&self, files: Vec<(Temporary, PathBuf)>) {
        let Some((first, _)) = files.first() else { return };
        let together = sync_all_at_once(first.path());
        let mut folders: Vec<PathBuf> = Vec::new();
        for (temporary, target) in files {
            let synced =
                if together { Ok(()) } else { File::open(temporary.path()).and_then(|file| file.sync_all()) };
            match synced.and_then(|()| settle(temporary, &target)) {
                Ok(_) if folders.iter().any(|known| Some(known.as_path()) == target.parent()) => {}
                Ok(_) => folders.extend(target.parent().map(Path::to_owned)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    let error = io::Error::other("another process was writing it at the same time");
                    lock(&self.failures).push((target, error));
                }
                Err(error) => lock(&self.failures).push((target, error)),
            }
        }
        folders.iter().for_each(|folder| sync_folder(&folder.join("any")));
    }
}

impl Drop for Batch {
    fn drop(&mut self) {
        self.finish();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Everything that the file system of `path` has not written yet; false where that cannot be asked for.
#[cfg(target_os = "linux")]
fn sync_all_at_once(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| rustix::fs::syncfs(file).is_ok())
}

#[cfg(not(target_os = "linux"))]
fn sync_all_at_once(_: &Path) -> bool {
    false
}
