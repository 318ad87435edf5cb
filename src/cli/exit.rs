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
    /// Something is worse than the baseline by more than is tolerated.
    Regressed = 101,
    /// No verdict failed, but one could not be decided with the runs there were.
    Inconclusive = 102,
    /// A baseline is missing, or may not be compared with.
    Baseline = 103,
    /// Somebody pressed Ctrl-C before everything was run.
    Interrupted = 105,
    /// A report could not be written.
    Output = 110,
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
  101  something is worse than the baseline
  102  no verdict failed, but one is inconclusive
  103  a baseline is missing or may not be compared with
  105  interrupted: what was finished is reported
  110  a report could not be written

Examples:
  scenario-runner init                                   write a project to begin with
  scenario-runner suites/zebra.suite                     run a suite
  scenario-runner suites/zebra.suite tta=6s              only the trials whose name contains `tta=6s`
  scenario-runner suites/*.suite -E 'tag(paper)'         what an expression selects: `help filter`
  scenario-runner suites/zebra.suite --fail-fast         until the first failure
  scenario-runner suites/zebra.suite --last-failed       only what did not pass last time
  scenario-runner suites/zebra.suite --junit junit.xml   and write a report for CI
  scenario-runner shrink KEY suites/zebra.suite          a failing run as a small scenario of its own
  scenario-runner models carla_behavior                  all about one controller
  scenario-runner check scenarios/zebra/*.scn            look for errors without running";

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}
