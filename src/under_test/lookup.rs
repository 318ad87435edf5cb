//! Where a program is: its first word on PATH, or below its folder.

use std::env;
use std::path::{Path, PathBuf};

use super::start::{StartError, StartProblem};
use scenario::DeclaredProgram;

/// More than the file of a functional mock-up unit may have, bytes.
const LARGEST_FMU: u64 = 1 << 30;

/// Where the file is that declares a program.
pub fn beside(program: &DeclaredProgram) -> &Path {
    Path::new(&program.file).parent().unwrap_or(Path::new(""))
}

/// Where a program is started.
pub fn folder(program: &DeclaredProgram) -> PathBuf {
    let folder = beside(program).join(&program.folder);
    if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder }
}

/// What is in the file of a functional mock-up unit.
///
/// # Errors
/// If it cannot be read.
pub fn fmu(program: &DeclaredProgram, file: &str) -> Result<Vec<u8>, StartError> {
    let path = beside(program).join(file);
    files::read_bytes(&path, LARGEST_FMU).map_err(|error| {
        let message = format!("`{file}`: {} cannot be read: {error}", path.display());
        let hint = "`fmu` is relative to the file that says it";
        StartError::new(StartProblem::CannotStart, program, message, hint)
    })
}

/// The file that is started by the first word of a command.
///
/// # Errors
/// If it is not there, or nothing that could be started.
pub fn executable(program: &DeclaredProgram, word: &str) -> Result<PathBuf, StartError> {
    let folder = folder(program);
    let cannot =
        |message: String, hint: &str| StartError::new(StartProblem::CannotStart, program, message, hint);
    if !folder.is_dir() {
        let message = format!("`{}` is started in {}, which is no folder", program.name, folder.display());
        return Err(cannot(message, "`folder` is relative to the file that says it"));
    }
    if word.contains(['/', std::path::MAIN_SEPARATOR]) {
        let path = folder.join(word);
        if !path.is_file() {
            return Err(cannot(
                format!("`{word}`: there is no file {}", path.display()),
                "a command with a separator is looked up relative to `folder`",
            ));
        }
        if !may_be_executed(&path) {
            return Err(cannot(
                format!("`{word}`: {} may not be executed", path.display()),
                "make it executable, or name what runs it first: `command \"python3\", \"my_av.py\"`",
            ));
        }
        // Whoever starts it stands in the folder.
        return Ok(std::path::absolute(&path).unwrap_or(path));
    }
    let own = program.environment.iter().find(|(name, _)| name == "PATH").map(|(_, value)| value.into());
    let places = own.or_else(|| env::var_os("PATH")).unwrap_or_default();
    let endings: &[&str] = if cfg!(windows) { &["", ".exe", ".bat", ".cmd"] } else { &[""] };
    env::split_paths(&places)
        .flat_map(|place| endings.iter().map(move |ending| place.join(format!("{word}{ending}"))))
        .find(|path| path.is_file() && may_be_executed(path))
        .map(|path| std::path::absolute(&path).unwrap_or(path))
        .ok_or_else(|| {
            cannot(
                format!("`{word}`: not found on PATH"),
                "a file beside the scenarios needs a separator: `command \"./my_av\"`",
            )
        })
}

#[cfg(unix)]
fn may_be_executed(path: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    path.metadata().is_ok_and(|metadata| metadata.permissions().mode() & 0o111 != 0)
}

#[cfg(not(unix))]
fn may_be_executed(_path: &Path) -> bool {
    true
}
