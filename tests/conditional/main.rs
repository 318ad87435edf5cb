//! Tests that need more than a machine with Rust: data that are shared, or a user who may mount. Where that is missing they
//! are counted as ignored, never as passed.

mod bind_mount;
mod commotions_reference;
mod crosscdr;
mod hiker;
mod retention;
#[path = "../support/mod.rs"]
mod support;
#[cfg(unix)]
mod watch_keys;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};

/// The file `name` of the shared folder: `../shared`, or what `SCENARIO_RUNNER_SHARED` says.
///
/// `None` after saying so if it is not there.
fn shared(name: &str) -> Option<PathBuf> {
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
type Test = (&'static str, fn(&Path));

/// Tests on a file; without it they are ignored.
fn with(file: Option<&Path>, tests: &[Test]) -> Vec<Trial> {
    let trial = |&(name, test): &Test| {
        let file = file.map(Path::to_path_buf);
        let missing = file.is_none();
        let run = move || {
            test(&file.ok_or("the file that it needs is missing")?);
            Ok(())
        };
        Trial::test(name, run).with_ignored_flag(missing)
    };
    tests.iter().map(trial).collect()
}

fn main() -> ExitCode {
    let mut tests = vec![
        bind_mount::tests(),
        commotions_reference::tests(),
        crosscdr::tests(),
        hiker::tests(),
        retention::tests(),
    ];
    #[cfg(unix)]
    tests.push(watch_keys::tests());
    libtest_mimic::run(&Arguments::from_args(), tests.into_iter().flatten().collect()).exit_code()
}
