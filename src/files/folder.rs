//! Folders: made with those that they are in, and on the disk before what is named in them counts as written.

use std::fs::{self, File};
use std::io;
use std::path::Path;

/// Makes a folder and those it is to be in.
///
/// # Errors
/// If it cannot be made, or is something else.
pub fn make_folder(path: &Path) -> io::Result<()> {
    if path.as_os_str().is_empty() { Ok(()) } else { fs::create_dir_all(path) }
}

/// Renaming lasts only once the folder is on the disk too. Not every system lets folders be synced.
pub(super) fn sync_folder(target: &Path) {
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}
