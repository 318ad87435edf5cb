//! What the tests share: the place of the data they share with others, and a zebra to walk over.
#![allow(dead_code, reason = "every test uses what it needs")]

pub mod zebra;

use std::path::{Path, PathBuf};

/// The file `name` of the shared folder: `../shared`, or what `SCENARIO_RUNNER_SHARED` says.
///
/// `None` after saying so loudly if there is no such folder.
pub fn shared(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("SCENARIO_RUNNER_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    if !folder.is_dir() {
        eprintln!("SKIPPED: there is no folder {} (set SCENARIO_RUNNER_SHARED)", folder.display());
        return None;
    }
    Some(folder.join(name))
}
