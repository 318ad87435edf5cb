//! What a suite that may be somebody else's is allowed to have written: baselines in its own project, in the place of none
//! but its own.

use std::path::{Path, PathBuf};

use super::Exit;
use report::console::stderr;
use results::judge::baseline::{Baseline, BaselineError};

/// Whether the baseline at `path`, which the suite in `file` names, lies in its project; if not, says so on stderr.
///
/// The project is what Git has around the suite; without Git it is the suite's folder, or the one that holds it if it is
/// called `suites`. The folder in which the program runs belongs to it if the suite lies in there.
pub fn holds(file: &str, path: &Path) -> Result<(), Exit> {
    let folder = Path::new(file).parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let (Ok(folder), Some(target)) = (folder.canonicalize(), resolved(path)) else {
        return Err(outside(path, None));
    };
    let own = if folder.ends_with("suites") { folder.parent().unwrap_or(&folder) } else { &folder };
    let versioned = folder.ancestors().find(|folder| folder.join(".git").exists());
    let current = std::env::current_dir().ok().filter(|current| folder.starts_with(current));
    let is_in = |root: &Path| target.starts_with(root);
    let is_named_so = target.extension().is_some_and(|ending| ending == "json");
    let is_held = is_in(own) || versioned.is_some_and(is_in) || current.as_deref().is_some_and(is_in);
    if is_held && is_named_so { Ok(()) } else { Err(outside(path, Some(&target))) }
}

fn outside(path: &Path, target: Option<&Path>) -> Exit {
    let leads = target.filter(|target| *target != path);
    let leads = leads.map_or_else(String::new, |target| format!(" (that is {})", target.display()));
    writeln!(
        stderr(),
        "error: the suite names the baseline {}{leads}, which is no .json file in its project",
        path.display()
    );
    writeln!(stderr(), "help: `--out PATH` writes it where you say");
    Exit::Output
}

/// The path without links. Of what is not there yet, the folder that is there decides; a link that leads nowhere has no
/// place.
fn resolved(path: &Path) -> Option<PathBuf> {
    if let Ok(real) = path.canonicalize() {
        return Some(real);
    }
    if path.is_symlink() {
        return None;
    }
    let name = path.file_name()?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some(resolved(folder)?.join(name))
}

/// Whether what is at `path` is nothing, no regular file, or a baseline of this suite; if not, says so on stderr.
pub fn may_be_replaced(path: &Path, suite: &str) -> Result<(), Exit> {
    if path.exists() && !path.is_file() {
        return Ok(());
    }
    let what = match Baseline::read(path) {
        Ok(baseline) if baseline.suite == suite => return Ok(()),
        Ok(baseline) => format!("is the baseline of the suite `{}`, not of `{suite}`", baseline.suite),
        Err(BaselineError::Missing { .. }) => return Ok(()),
        Err(BaselineError::OtherLayout { found, .. }) => format!("is a baseline of another layout, {found}"),
        Err(BaselineError::Malformed { .. }) => "is no baseline, or a damaged one".to_string(),
        Err(error) => format!("may be no baseline: {error}"),
    };
    writeln!(stderr(), "error: {} {what}; it is not replaced", path.display());
    writeln!(stderr(), "help: `--force` replaces it, `--out PATH` writes elsewhere");
    Err(Exit::Output)
}
