//! The folders that an editor has open, and the scenario files in them: nothing else is looked for.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::document::path_of;
use files::{Disk, Files};

/// More files are not gone through for a name.
const MOST_FILES: usize = 2000;

/// More folders are not looked into.
const MOST_FOLDERS: usize = 2000;

const ENDINGS: [&str; 4] = ["scn", "suite", "yaml", "yml"];

/// What the editor has open.
#[derive(Debug, Default)]
pub struct Workspace {
    /// Without links.
    roots: Vec<PathBuf>,
    /// Results that it wants to see besides those that its own commands write, from a root.
    pub results: Vec<PathBuf>,
}

impl Workspace {
    /// As `initialize` says it; what it says otherwise than the protocol has it is not there.
    pub fn new(parameters: &Value) -> Self {
        let folders = parameters["workspaceFolders"].as_array();
        let named = folders.into_iter().flatten().filter_map(|folder| folder["uri"].as_str());
        let alone = parameters["rootUri"].as_str().filter(|_| folders.is_none());
        let paths = named.chain(alone).filter_map(|uri| path_of(&uri.parse().ok()?));
        let roots = paths.map(|path| Disk.identity(&path)).filter(|path| Disk.is_folder(path)).collect();
        let results = parameters["initializationOptions"]["results"].as_array();
        let results = results.into_iter().flatten().filter_map(Value::as_str).map(PathBuf::from).collect();
        Self { roots, results }
    }

    /// The folder that a file lies in, and its path from there.
    pub fn place(&self, path: &Path) -> Option<(&Path, PathBuf)> {
        let identity = Disk.identity(path);
        let root = self
            .roots
            .iter()
            .filter(|root| identity.starts_with(root))
            .max_by_key(|root| root.as_os_str().len())?;
        let below = identity.strip_prefix(root).ok()?.to_path_buf();
        Some((root, below))
    }

    /// Every scenario file and suite, and whether those are all: where no folder is open, those beside `path`.
    pub fn files(&self, path: &Path) -> (Vec<PathBuf>, bool) {
        let beside = path.parent().map(|folder| vec![(Disk.identity(folder), false)]);
        let mut folders: Vec<(PathBuf, bool)> = match self.roots.as_slice() {
            [] => beside.unwrap_or_default(),
            roots => roots.iter().map(|root| (root.clone(), true)).collect(),
        };
        let (mut files, mut seen) = (Vec::new(), 0);
        while let Some((folder, deep)) = folders.pop() {
            seen += 1;
            if seen > MOST_FOLDERS || files.len() > MOST_FILES {
                return (files, false);
            }
            let mut names = Disk.names(&folder);
            names.sort();
            for name in names {
                let inner = folder.join(&name);
                let kind =
                    Path::new(&name).extension().and_then(|ending| ending.to_str()).unwrap_or_default();
                if ENDINGS.contains(&kind) && Disk.is_file(&inner) {
                    files.push(inner);
                } else if deep && !is_left_out(&name) && Disk.is_folder(&inner) && !inner.is_symlink() {
                    folders.push((inner, deep));
                }
            }
        }
        files.sort();
        (files, true)
    }
}

/// Folders of tools.
fn is_left_out(name: &str) -> bool {
    name.starts_with('.') || matches!(name, "target" | "node_modules")
}
