//! Replacing what a file holds without replacing the file, where its folder takes no other or it is mounted by itself.
//!
//! Whoever is killed in between leaves a file that is neither old nor new; therefore a copy of the old one is kept beside
//! it, or in the program's own folder, until the new one is whole.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::folder::sync_folder;
use super::temporary::beside;

/// Where copies go if the file's own folder takes none.
const FOLDER: &str = ".scenario-runner";

/// Copies that killed processes have left, beyond which something is wrong.
const MOST_COPIES: usize = 100;

/// Makes `content` what `target` holds.
///
/// # Errors
/// If that is not possible. Then it holds again what it held, or the error says where that is.
pub(super) fn replace(target: &Path, content: &mut dyn Read) -> io::Result<()> {
    let mut file = OpenOptions::new().read(true).write(true).open(target)?;
    let copy = match file.metadata()?.len() {
        0 => None,
        _ => Some(copy(target, &mut file)?),
    };
    let written = put(&mut file, content);
    let Some(copy) = copy else { return written };
    let Err(error) = written else {
        // Left behind, it would say that something went wrong.
        return fs::remove_file(copy);
    };
    match File::open(&copy).and_then(|mut old| put(&mut file, &mut old)) {
        Ok(()) => {
            let _ = fs::remove_file(copy);
            Err(error)
        }
        Err(_) => {
            let kept = copy.display();
            Err(io::Error::new(error.kind(), format!("{error}; what it held before is in {kept}")))
        }
    }
}

fn put(file: &mut File, content: &mut dyn Read) -> io::Result<()> {
    file.seek(SeekFrom::Start(0))?;
    let length = io::copy(content, file)?;
    file.set_len(length)?;
    file.sync_all()
}

/// A whole copy under a name that nothing has yet.
fn copy(target: &Path, file: &mut File) -> io::Result<PathBuf> {
    let (path, mut copy) = vacant(target).map_err(|error| {
        let why =
            format!("it can only be written in place, and no copy of it can be kept meanwhile: {error}");
        io::Error::new(error.kind(), why)
    })?;
    file.seek(SeekFrom::Start(0))?;
    let copied = io::copy(file, &mut copy).and_then(|_| copy.flush()).and_then(|()| copy.sync_all());
    if let Err(error) = copied {
        let _ = fs::remove_file(&path);
        return Err(error);
    }
    sync_folder(&path);
    Ok(path)
}

fn vacant(target: &Path) -> io::Result<(PathBuf, File)> {
    let own = Path::new(FOLDER).join(target.file_name().unwrap_or_default());
    numbered(target)
        .or_else(|error| fs::create_dir_all(FOLDER).and_then(|()| numbered(&own)).map_err(|_| error))
}

fn numbered(target: &Path) -> io::Result<(PathBuf, File)> {
    for number in 1..=MOST_COPIES {
        let path = beside(target, &format!("old{number}"));
        match private().open(&path) {
            Ok(file) => return Ok((path, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    let kept = beside(target, "old1");
    let why = format!("{MOST_COPIES} are there already, from processes that were killed: {}", kept.display());
    Err(io::Error::new(io::ErrorKind::AlreadyExists, why))
}

/// Nobody but its owner reads a copy: the original may be as private.
fn private() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options
}
