//! Exit codes: a published promise, so that scripts can tell why a run ended.

use std::process::ExitCode;

/// How the program ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Everything passed.
    Success = 0,
    /// The command line cannot be understood or a file cannot be read.
    Usage = 2,
    /// A scenario or suite has errors.
    Scenario = 3,
    /// No trial or block was selected.
    NothingSelected = 4,
    /// `fmt --check` found a file that is not in the one style.
    Unformatted = 5,
    /// A verdict failed, or something could not be run.
    Failed = 100,
    /// No verdict failed, but one could not be decided with the runs there were, or there is none at all, or a criterion passed
    /// untested and that is denied.
    Inconclusive = 102,
    /// A baseline is missing, or may not be compared with.
    Baseline = 103,
    /// Something is worse than the baseline by more than is tolerated. Not 101, with which Rust's panics end.
    Regressed = 104,
    /// Somebody pressed Ctrl-C before everything was run.
    Interrupted = 105,
    /// A report could not be written, or what was to be said: the device is full, not merely the reader gone.
    Output = 110,
    /// scenario-runner panicked outside of all runs: a bug of ours.
    Bug = 120,
}

/// Shown below `--help`.
pub const HELP: &str = "\
Exit codes:
    0  everything passed
    2  the command line cannot be understood
    3  a scenario or suite cannot be read or has errors
    4  no trial or block was selected
    5  `fmt --check` found a file that is not in the one style
  100  a verdict failed, or something could not be run
  102  no verdict failed, but one is inconclusive, or nothing was judged,
       or with `--deny untested` a criterion passed untested
  103  a baseline is missing or may not be compared with
  104  something is worse than the baseline
  105  interrupted: what was finished is reported
  110  a report could not be written
  120  a bug in this program: please report it

Examples:
  scenario-runner init                                   write a project to begin with
  scenario-runner suites/zebra.suite                     run a suite
  scenario-runner suites/zebra.suite tta=6s              only the trials whose name contains `tta=6s`
  scenario-runner suites/*.suite -E 'tag(paper)'         what an expression selects: `help filter`
  scenario-runner suites/zebra.suite --fail-fast         until the first failure
  scenario-runner suites/zebra.suite --last-failed       only what did not pass last time
  scenario-runner watch suites/zebra.suite               and again whatever a change concerns
  scenario-runner suites/zebra.suite --junit junit.xml   and write a report for CI
  scenario-runner report results.json --html page.html   a report later, of what --json wrote
  scenario-runner shrink KEY suites/zebra.suite          a failing run as a small scenario of its own
  scenario-runner models carla_behavior                  all about one controller
  scenario-runner check scenarios/zebra/*.scn            look for errors without running";

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::Path;

    use super::*;

    const ALL: [Exit; 12] = [
        Exit::Success,
        Exit::Usage,
        Exit::Scenario,
        Exit::NothingSelected,
        Exit::Unformatted,
        Exit::Failed,
        Exit::Inconclusive,
        Exit::Baseline,
        Exit::Regressed,
        Exit::Interrupted,
        Exit::Output,
        Exit::Bug,
    ];

    #[test]
    fn every_code_means_one_thing_everywhere() {
        let codes: BTreeSet<u8> = ALL.iter().map(|exit| *exit as u8).collect();
        assert_eq!(codes.len(), ALL.len());
        // Rust's panics and failing `cargo test`s; shells take 126 and above.
        assert!(!codes.contains(&101) && !codes.contains(&1) && codes.iter().all(|code| *code < 126));
        let table = |file: &str| -> BTreeSet<u8> {
            let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap();
            text.lines().filter_map(|line| line.strip_prefix("| ")?.split_once(' ')?.0.parse().ok()).collect()
        };
        assert_eq!(table("README.md"), codes);
        assert_eq!(table("docs/running.md"), codes);
        let help = HELP.lines().filter(|line| line.starts_with("  ") && !line.contains("scenario-runner "));
        let help: BTreeSet<u8> =
            help.filter_map(|line| line.trim_start().split_once(' ')?.0.parse().ok()).collect();
        assert_eq!(help, codes);
    }
}
