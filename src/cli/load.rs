//! Files to projects: what every command that runs something begins with.

use std::path::Path;

use super::Exit;
use super::set::SetArguments;
use files::Disk;
use lang::Style;
use report::console::stderr;
use runner::project::{Notice, Problems, Project, ProjectOptions};
use scenario::registry::Registry;

/// Whether a word of the command line is meant as a file.
pub fn names_a_file(word: &str) -> bool {
    let extension = Path::new(word).extension().and_then(|extension| extension.to_str());
    matches!(extension, Some("suite" | "scn" | "yaml" | "yml"))
}

/// Loads, checks and plans every file; all that there is to say of all files goes to stderr.
pub fn load_all(
    files: &[&String],
    seed: Option<u64>,
    set: &SetArguments,
    colour: bool,
    registry: &Registry,
) -> Result<Project, Exit> {
    match open_all(files, seed, set, registry)? {
        Ok(project) => {
            show(project.notices().iter().cloned(), colour);
            Ok(project)
        }
        Err(problems) => {
            show(problems.0, colour);
            Err(Exit::Scenario)
        }
    }
}

/// Loads, checks and plans every file, or finds all that is wrong with them; neither says anything. That something is set twice goes to
/// stderr.
pub fn open_all<P: AsRef<Path>>(
    files: impl IntoIterator<Item = P>,
    seed: Option<u64>,
    set: &SetArguments,
    registry: &Registry,
) -> Result<Result<Project, Problems>, Exit> {
    Ok(Project::open_all(files, &options(seed, set)?, registry, &Disk))
}

/// What is otherwise than in the files. That something is set twice goes to stderr.
pub fn options(seed: Option<u64>, set: &SetArguments) -> Result<ProjectOptions, Exit> {
    let options = set.options().map_err(|name| {
        writeln!(stderr(), "error: `{name}` is set twice");
        writeln!(stderr(), "help: leave out one of the two");
        Exit::Usage
    })?;
    Ok(options.seed(seed))
}

/// Says on stderr what there is to say.
pub fn show(notices: impl IntoIterator<Item = Notice>, colour: bool) {
    for notice in notices {
        stderr().styled(&notice.render(Style { colour }));
    }
}
