//! What the tests share: the place of the data they share with others, and a zebra to walk over.
#![allow(dead_code, reason = "every test uses what it needs")]

pub mod counting;
pub mod program;
pub mod street;
pub mod zebra;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};

/// The file `name` of the shared folder: `../shared`, or what `SCENARIO_RUNNER_SHARED` says.
///
/// `None` after saying so if it is not there.
pub fn shared(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("SCENARIO_RUNNER_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let file = folder.join(name);
    if !file.is_file() {
        eprintln!("SKIPPED: there is no file {} (set SCENARIO_RUNNER_SHARED)", file.display());
        return None;
    }
    Some(file)
}

/// A test by name, which is given the file that it needs.
pub type Test = (&'static str, fn(&Path));

/// Runs tests that need `file`; without it they are counted as ignored, never as passed. What they print is shown.
pub fn run_with(file: Option<PathBuf>, tests: &[Test]) -> ExitCode {
    let trial = |&(name, test): &Test| {
        let file = file.clone();
        let missing = file.is_none();
        let run = move || {
            test(&file.ok_or("the file that it needs is missing")?);
            Ok(())
        };
        Trial::test(name, run).with_ignored_flag(missing)
    };
    libtest_mimic::run(&Arguments::from_args(), tests.iter().map(trial).collect()).exit_code()
}
