//! The folder for what the program remembers between sessions and nobody commits.

use std::fs;
use std::io;
use std::path::Path;

/// In the folder in which the program runs.
pub const FOLDER: &str = ".scenario-runner";

/// Makes it, and has Git leave it alone.
pub fn make() -> io::Result<()> {
    fs::create_dir_all(FOLDER)?;
    let ignore = Path::new(FOLDER).join(".gitignore");
    if fs::exists(&ignore)? { Ok(()) } else { fs::write(ignore, "*\n") }
}

/// Before something is written to `path`: makes the folder if that is in it. If that fails, so will the writing, with
/// more to say about it.
pub fn prepare(path: &Path) {
    if path.starts_with(FOLDER) {
        let _ = make();
    }
}
