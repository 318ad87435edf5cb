//! The atomic writer: whoever looks, at whatever moment, sees the old file or the new one, whole.
//!
//! A temporary file beside the target is written, synced and renamed. Links are followed, not replaced; pipes, devices and
//! descriptors are written directly; where nothing can be renamed, [`super::in_place`] keeps a copy. Permissions and owner
//! of the old file stay; other attributes, such as access control lists, do not.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::destination::{Destination, destination};
use super::folder::{make_folder, sync_folder};
use super::in_place::replace;
use super::temporary::Temporary;

/// Writes a whole file, making the folders it is to be in. What was there stays until all is written.
///
/// # Errors
/// If it cannot be written: then it is as it was before.
pub fn write(path: &Path, content: impl AsRef<[u8]>) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(content.as_ref())?;
    file.commit()
}

/// As [`write()`], but never replaces a file.
///
/// # Errors
/// [`io::ErrorKind::AlreadyExists`] if there is something.
pub fn create_new(path: &Path, content: impl AsRef<[u8]>) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(content.as_ref())?;
    file.commit_new()
}

/// Whether what is written to `path` ends up, all links followed, in a file whose name ends in one of `endings`.
///
/// # Errors
/// If it does not, or if that cannot be known.
pub fn check_target(path: &Path, endings: &[&str]) -> io::Result<()> {
    if let Destination::File(target) = destination(path)?
        && let Some(ending) = target.extension().and_then(|ending| ending.to_str())
        && endings.contains(&ending)
    {
        return Ok(());
    }
    Err(io::Error::new(
        io::ErrorKind::InvalidInput,
        format!("it leads to something that does not end in .{}", endings.join(", .")),
    ))
}

/// Removes a file, if there is one.
///
/// # Errors
/// If it is there and stays.
pub fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

/// A file that is being written, and that nobody sees before [`WholeFile::commit`]. Dropped without it, nothing has
/// happened.
pub struct WholeFile {
    pub(super) route: Route,
}

pub(super) enum Route {
    /// Renamed when it is whole.
    Beside { temporary: Temporary, target: PathBuf },
    /// Kept in memory, for a target that can only be written in place.
    InPlace { content: Vec<u8>, target: PathBuf },
    /// Sent as it comes.
    Direct(Box<dyn Write + Send>),
}

impl WholeFile {
    /// Begins to write a file, making the folders it is to be in.
    ///
    /// # Errors
    /// If it could not be written in the end either.
    #[allow(
        clippy::disallowed_methods,
        reason = "whoever writes a report to a standard stream is told what fails"
    )]
    pub fn create(path: &Path) -> io::Result<Self> {
        let target = match destination(path)? {
            Destination::File(target) => target,
            Destination::Stream(path) => return Ok(Self { route: Route::Direct(stream(&path)?) }),
            Destination::StandardOutput => return Ok(Self { route: Route::Direct(Box::new(io::stdout())) }),
            Destination::StandardError => return Ok(Self { route: Route::Direct(Box::new(io::stderr())) }),
        };
        if let Some(folder) = target.parent() {
            make_folder(folder)?;
        }
        let Some(old) = existing(&target)? else {
            let temporary = Temporary::beside(&target)?;
            return Ok(Self { route: Route::Beside { temporary, target } });
        };
        // Its other names are to go on naming it.
        if names(&old) > 1 {
            return Ok(Self { route: Route::InPlace { content: Vec::new(), target } });
        }
        match Temporary::beside(&target) {
            Ok(temporary) if takes_after(&temporary, &old) => {
                Ok(Self { route: Route::Beside { temporary, target } })
            }
            Err(error) if !is_forbidden(&error) => Err(error),
            _ => Ok(Self { route: Route::InPlace { content: Vec::new(), target } }),
        }
    }

    /// Puts it in the place of what was there.
    ///
    /// # Errors
    /// If that is not possible: then what was there still is.
    pub fn commit(self) -> io::Result<()> {
        self.commit_open().map(drop)
    }

    /// As [`Self::commit`]; the file stays open, and locked since before it had its name, if it could be renamed.
    pub(super) fn commit_open(self) -> io::Result<Option<File>> {
        let (mut temporary, target) = match self.route {
            Route::Direct(mut out) => return out.flush().map(|()| None),
            Route::InPlace { content, target } => return replace(&target, &mut &content[..]).map(|()| None),
            Route::Beside { temporary, target } => (temporary, target),
        };
        let file = finished(&mut temporary)?;
        file.sync_all()?;
        let renamed = settle(temporary, &target)?;
        sync_folder(&target);
        Ok(renamed.then_some(file))
    }

    /// Gives it its name, if nobody has that yet.
    pub(super) fn commit_new(self) -> io::Result<()> {
        let (mut temporary, target) = match self.route {
            Route::Direct(mut out) => return out.flush(),
            Route::InPlace { .. } => return Err(io::ErrorKind::AlreadyExists.into()),
            Route::Beside { temporary, target } => (temporary, target),
        };
        // Open until the end, as long as the name is to stay its own.
        let file = finished(&mut temporary)?;
        file.sync_all()?;
        match fs::hard_link(temporary.path(), &target) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Err(error),
            // Not every file system has links.
            Err(_) if target.symlink_metadata().is_err() => drop(settle(temporary, &target)?),
            Err(_) => return Err(io::ErrorKind::AlreadyExists.into()),
        }
        drop(file);
        sync_folder(&target);
        Ok(())
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.route {
            Route::Direct(out) => out.write(bytes),
            Route::InPlace { content, .. } => content.write(bytes),
            Route::Beside { temporary, .. } => opened(temporary)?.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.route {
            Route::Direct(out) => out.flush(),
            Route::InPlace { .. } => Ok(()),
            Route::Beside { temporary, .. } => opened(temporary)?.flush(),
        }
    }
}

fn opened(temporary: &mut Temporary) -> io::Result<&mut BufWriter<File>> {
    temporary.out.as_mut().ok_or_else(|| io::Error::other("it is closed"))
}

/// Everything written and handed to the system; the file keeps its lock as long as it is open.
pub(super) fn finished(temporary: &mut Temporary) -> io::Result<File> {
    let out = temporary.out.take().ok_or_else(|| io::Error::other("it is closed"))?;
    out.into_inner().map_err(io::IntoInnerError::into_error)
}

/// Renames it; where the target cannot be renamed over, as a file that is mounted by itself, its content goes there.
/// Returns whether it was renamed.
pub(super) fn settle(mut temporary: Temporary, target: &Path) -> io::Result<bool> {
    match fs::rename(temporary.path(), target) {
        Ok(()) => {
            temporary.keep();
            Ok(true)
        }
        Err(error) if target.is_file() && is_in_the_way(&error) => {
            replace(target, &mut File::open(temporary.path())?).map(|()| false)
        }
        Err(error) => Err(error),
    }
}

/// What is known of the file that is there, which must be one that may be written.
fn existing(target: &Path) -> io::Result<Option<Metadata>> {
    match OpenOptions::new().write(true).open(target) {
        Ok(file) => file.metadata().map(Some),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// Appends, lest a file behind a descriptor loses what it has.
fn stream(path: &Path) -> io::Result<Box<dyn Write + Send>> {
    Ok(Box::new(BufWriter::new(OpenOptions::new().append(true).open(path)?)))
}

fn is_forbidden(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem)
}

fn is_in_the_way(error: &io::Error) -> bool {
    is_forbidden(error) || matches!(error.kind(), io::ErrorKind::ResourceBusy | io::ErrorKind::CrossesDevices)
}

#[cfg(unix)]
fn names(old: &Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::nlink(old)
}

#[cfg(not(unix))]
fn names(_: &Metadata) -> u64 {
    1
}

/// Gives the new file the owner, group and permissions of the old one; false if that is not possible.
#[cfg(unix)]
fn takes_after(temporary: &Temporary, old: &Metadata) -> bool {
    use std::os::unix::fs::{MetadataExt, fchown};
    let Some(file) = temporary.out.as_ref().map(BufWriter::get_ref) else { return false };
    let Ok(new) = file.metadata() else { return false };
    let owned = (new.uid(), new.gid()) == (old.uid(), old.gid())
        || fchown(file, Some(old.uid()), Some(old.gid())).is_ok();
    owned && (new.permissions() == old.permissions() || file.set_permissions(old.permissions()).is_ok())
}

#[cfg(not(unix))]
fn takes_after(temporary: &Temporary, old: &Metadata) -> bool {
    let file = temporary.out.as_ref().map(BufWriter::get_ref);
    file.is_some_and(|file| file.set_permissions(old.permissions()).is_ok())
}
