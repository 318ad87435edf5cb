//! The folder for what the program remembers between sessions and nobody commits.
//!
//! It holds no links: a project from somebody else could have them lead anywhere.

use std::io;
use std::path::{Path, PathBuf};

use super::Exit;
use files::{self, ReadError};
use report::console::stderr;

/// In the folder in which the program runs.
pub const FOLDER: &str = ".scenario-runner";

/// Where searches and tunes keep what they have evaluated, unless told otherwise.
pub const JOURNAL: &str = ".scenario-runner/journal";

/// Before something is written to `path`: makes the folder if that is in it. If that fails, so will the writing, with
/// more to say about it; what leads elsewhere is refused.
pub fn prepare(path: &Path) -> Result<(), Exit> {
    if !path.starts_with(FOLDER) {
        return Ok(());
    }
    let _ = make();
    without_links(path).map_err(|error| {
        writeln!(stderr(), "error: {error}");
        Exit::Output
    })
}

/// Writes one of its files.
pub fn write(name: &str, text: &str) -> io::Result<()> {
    make()?;
    files::write(&at(name)?, text)
}

/// Reads one of its files.
pub fn read(name: &str) -> Result<String, ReadError> {
    files::read_text(&at(name)?)
}

/// Removes one of its files, if it is there.
pub fn remove(name: &str) -> io::Result<()> {
    files::remove(&at(name)?)
}

/// Makes it, and has Git leave it alone.
fn make() -> io::Result<()> {
    let ignore = at(".gitignore")?;
    if ignore.exists() { Ok(()) } else { files::write(&ignore, "*\n") }
}

fn at(name: &str) -> io::Result<PathBuf> {
    let path = Path::new(FOLDER).join(name);
    without_links(&path)?;
    Ok(path)
}

fn without_links(path: &Path) -> io::Result<()> {
    let own = path.ancestors().filter(|part| part.starts_with(FOLDER));
    match own.filter(|part| part.is_symlink()).last() {
        Some(link) => Err(io::Error::other(format!(
            "{} is a link, and {FOLDER} is to hold what the program itself put there; remove it",
            link.display()
        ))),
        None => Ok(()),
    }
}
