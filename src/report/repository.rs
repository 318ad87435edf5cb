//! Where files lie in their repository: paths by which GitHub, GitLab and their like find them.

use std::cell::RefCell;
use std::collections::HashMap;
use std::env;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// The repository around a folder, or the folder itself where there is none.
#[derive(Debug)]
pub struct Repository {
    root: PathBuf,
    /// What paths are relative to.
    here: PathBuf,
    /// Paths that were asked for.
    known: RefCell<HashMap<String, String>>,
}

impl Repository {
    /// Around the current folder.
    pub fn here() -> Self {
        Self::around(&env::current_dir().unwrap_or_else(|_| PathBuf::from(".")))
    }

    /// The repository that `folder` is in; where it is in none, the folder itself.
    pub fn around(folder: &Path) -> Self {
        let here = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
        // In a worktree `.git` is a file.
        let root =
            here.ancestors().find(|folder| folder.join(".git").exists()).unwrap_or(&here).to_path_buf();
        Self { root, here, known: RefCell::default() }
    }

    /// A file, as the user or a suite names it, from the root of the repository on, with `/` between folders. What lies
    /// elsewhere stays as it is named.
    pub fn path(&self, file: &str) -> String {
        if let Some(path) = self.known.borrow().get(file) {
            return path.clone();
        }
        let whole = self.here.join(file);
        // A file that is not there any more, or never was one, such as standard input.
        let whole = fs::canonicalize(&whole).unwrap_or_else(|_| straightened(&whole));
        let path = match whole.strip_prefix(&self.root) {
            Ok(inside) => {
                let parts: Vec<_> = inside.iter().map(|part| part.to_string_lossy()).collect();
                parts.join("/")
            }
            Err(_) => file.to_string(),
        };
        self.known.borrow_mut().insert(file.to_string(), path.clone());
        path
    }
}

/// A path without `.` and `..`.
fn straightened(path: &Path) -> PathBuf {
    let mut straight = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(straight.pop()),
            part => straight.push(part),
        }
    }
    straight
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_those_from_the_root_on() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir_all(at("repo/av/suites")).unwrap();
        fs::create_dir_all(at("repo/av/scenarios")).unwrap();
        fs::create_dir(at("repo/.git")).unwrap();
        fs::write(at("repo/av/scenarios/a.scn"), "").unwrap();
        fs::write(at("outside.scn"), "").unwrap();
        let repository = Repository::around(&at("repo/av/suites"));
        assert_eq!(repository.path("../scenarios/a.scn"), "av/scenarios/a.scn");
        assert_eq!(repository.path("../suites/./gone.suite"), "av/suites/gone.suite");
        assert_eq!(repository.path(&at("repo/av/scenarios/a.scn").to_string_lossy()), "av/scenarios/a.scn");
        // The second time, too.
        assert_eq!(repository.path("../scenarios/a.scn"), "av/scenarios/a.scn");
        assert_eq!(repository.path("../../../outside.scn"), "../../../outside.scn");
        fs::remove_dir(at("repo/.git")).unwrap();
        let nowhere = Repository::around(&at("repo/av"));
        assert_eq!(nowhere.path("suites/../scenarios/a.scn"), "scenarios/a.scn");
    }
}
