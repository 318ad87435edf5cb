//! Where reports go: to no file that is read, and no two of them to one.

use std::path::{Path, PathBuf};

use runner::project::PlannedSuite;

/// The endings of files that people write.
const WRITTEN_BY_HAND: [&str; 4] = ["scn", "suite", "yaml", "yml"];

/// The baselines and populations that suites read.
pub fn read_by(suites: &[PlannedSuite]) -> Vec<&str> {
    let gates = suites.iter().flat_map(|suite| &suite.suite.gates);
    let scenarios = suites.iter().flat_map(|suite| &suite.suite.scenarios);
    let people = scenarios.flat_map(|one| &one.pedestrians).filter_map(|one| one.individuals.as_ref());
    gates.map(|gate| gate.baseline.as_str()).chain(people.map(|people| people.population.as_str())).collect()
}

/// Looks at where each option's report is to go, before anything runs. `read` are the other files that the session reads.
///
/// # Errors
/// A report would replace a scenario, a suite or one of `read`, or another report; in words, with the options.
pub fn check(reports: &[(&str, &Path)], read: &[&str]) -> Result<(), String> {
    let read: Vec<PathBuf> = read.iter().map(|path| target(Path::new(path))).collect();
    let mut known: Vec<(&str, PathBuf)> = Vec::new();
    for (option, path) in reports {
        let target = target(path);
        // Devices and pipes keep nothing.
        if target.exists() && !target.is_file() {
            continue;
        }
        let shown = path.display();
        let ending = target.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        if target.exists() && WRITTEN_BY_HAND.contains(&ending) {
            return Err(format!("`{option} {shown}` would replace a scenario or suite"));
        }
        if read.contains(&target) {
            return Err(format!("`{option} {shown}` would replace a file that this run reads"));
        }
        if let Some((other, _)) = known.iter().find(|(_, known)| *known == target) {
            return Err(format!("`{other}` and `{option}` would both be written to {shown}"));
        }
        known.push((option, target));
    }
    Ok(())
}

/// The file that a path stands for, links followed; also of one that is not there yet.
fn target(path: &Path) -> PathBuf {
    if let Ok(whole) = path.canonicalize() {
        return whole;
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    }
}
