//! What a path that is to be written leads to: a file, or something that takes bytes and keeps none.

use std::io;
use std::path::{Path, PathBuf};

/// Links followed in a row before they are taken for a circle, as Linux does.
const MOST_LINKS: usize = 40;

/// Where writing ends up.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Destination {
    /// A regular file or none yet, all links followed.
    File(PathBuf),
    /// A pipe, a device, a socket or an open descriptor: written directly.
    Stream(PathBuf),
    /// This process's standard output, by whatever name.
    StandardOutput,
    /// This process's standard error.
    StandardError,
}

/// Follows links to what is to be written.
///
/// # Errors
/// If it is a folder, names nothing, leads in a circle, or cannot be looked at.
pub(super) fn destination(path: &Path) -> io::Result<Destination> {
    let mut path = path.to_owned();
    for _ in 0..=MOST_LINKS {
        if path.file_name().is_none() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "it names no file"));
        }
        let metadata = match path.symlink_metadata() {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Destination::File(path)),
            other => other?,
        };
        // The links there are no paths: what they name may be gone, or be at another place than the descriptor.
        if let Some(number) = descriptor(&path) {
            return Ok(match number {
                1 => Destination::StandardOutput,
                2 => Destination::StandardError,
                _ => Destination::Stream(path),
            });
        }
        if metadata.is_symlink() {
            let target = path.read_link()?;
            path = path.parent().unwrap_or(Path::new("")).join(target);
        } else if metadata.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
        } else if metadata.is_file() {
            return Ok(Destination::File(path));
        } else {
            return Ok(Destination::Stream(path));
        }
    }
    Err(io::Error::new(io::ErrorKind::InvalidInput, "its links lead in a circle"))
}

/// The number of an open descriptor of this process, of which `/dev/fd/1` and `/proc/self/fd/1` are names.
fn descriptor(path: &Path) -> Option<u32> {
    let number = path.file_name()?.to_str()?.parse().ok()?;
    let folder = path.parent()?.canonicalize().ok()?;
    let own = [PathBuf::from("/dev/fd"), PathBuf::from(format!("/proc/{}/fd", std::process::id()))];
    own.contains(&folder).then_some(number)
}
