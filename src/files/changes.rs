//! Being told that something in a folder may have changed, as far as the system tells.

use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;

use notify::event::EventKind;
use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher};

/// Tells that something in one of its folders may have changed. Not every system tells of every change (network file systems tell of none
/// that was made elsewhere), so whoever has to know looks from time to time all the same.
pub struct Changes {
    watcher: RecommendedWatcher,
    folders: BTreeSet<PathBuf>,
}

impl Changes {
    /// With no folder yet. `told` is called on a thread of its own.
    ///
    /// # Errors
    /// In words, if the system does not tell.
    pub fn new(told: impl Fn() + Send + 'static) -> Result<Self, String> {
        let heard = move |event: notify::Result<Event>| {
            // Files that are read, which may be by this program, do not change.
            if !event.is_ok_and(|event| matches!(event.kind, EventKind::Access(_))) {
                told();
            }
        };
        let watcher = notify::recommended_watcher(heard).map_err(|error| error.to_string())?;
        Ok(Self { watcher, folders: BTreeSet::new() })
    }

    /// Tells of these folders from now on, and of no others; not of what lies in folders below them.
    ///
    /// # Errors
    /// In words, of the first that it cannot tell of; it tells of the others all the same.
    pub fn of(&mut self, folders: BTreeSet<PathBuf>) -> Result<(), String> {
        for gone in self.folders.difference(&folders) {
            // One that was removed is forgotten by the system as well.
            let _ = self.watcher.unwatch(gone);
        }
        let mut failed = Ok(());
        let mut told: BTreeSet<PathBuf> = self.folders.intersection(&folders).cloned().collect();
        for folder in folders {
            if told.contains(&folder) {
                continue;
            }
            match self.watcher.watch(&folder, RecursiveMode::NonRecursive) {
                Ok(()) => _ = told.insert(folder),
                Err(error) if failed.is_ok() => failed = Err(format!("{}: {error}", folder.display())),
                Err(_) => {}
            }
        }
        self.folders = told;
        failed
    }
}

impl fmt::Debug for Changes {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Changes").field("folders", &self.folders).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::mpsc;
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_file_that_is_written_replaced_or_removed_is_told_of() {
        let folder = tempfile::tempdir().unwrap();
        let (sender, receiver) = mpsc::channel();
        let mut changes = Changes::new(move || _ = sender.send(())).unwrap();
        let told = |what: &str| {
            receiver.recv_timeout(Duration::from_secs(30)).unwrap_or_else(|_| panic!("{what}"));
            while receiver.recv_timeout(Duration::from_millis(300)).is_ok() {}
        };
        changes.of(BTreeSet::from([folder.path().to_path_buf()])).unwrap();
        fs::write(folder.path().join("a"), "one").unwrap();
        told("made");
        fs::write(folder.path().join("a"), "two").unwrap();
        told("written");
        fs::read(folder.path().join("a")).unwrap();
        assert!(receiver.recv_timeout(Duration::from_millis(300)).is_err(), "reading changes nothing");
        fs::write(folder.path().join("b"), "three").unwrap();
        told("another one");
        fs::rename(folder.path().join("b"), folder.path().join("a")).unwrap();
        told("replaced");
        fs::remove_file(folder.path().join("a")).unwrap();
        told("removed");
        changes.of(BTreeSet::new()).unwrap();
        fs::write(folder.path().join("a"), "one").unwrap();
        assert!(receiver.recv_timeout(Duration::from_millis(300)).is_err(), "it is not looked at any more");
    }

    #[test]
    fn a_folder_that_is_not_there_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let mut changes = Changes::new(|| {}).unwrap();
        let folders = [folder.path().join("none"), folder.path().to_path_buf()];
        let said = changes.of(BTreeSet::from(folders)).unwrap_err();
        assert!(said.contains("none"), "{said}");
        assert_eq!(changes.folders.len(), 1);
    }
}
