//! Suites as tests of a Rust project: every trial, block, rating and gate is a test of `cargo test`.
//!
//! In the project's `Cargo.toml`:
//!
//! ```toml
//! [dev-dependencies]
//! scenario-runner = "0.1"
//!
//! [[test]]
//! name = "suites"
//! harness = false
//! ```
//!
//! and in its `tests/suites.rs`:
//!
//! ```no_run
//! fn main() -> std::process::ExitCode {
//!     scenario_runner::testing::run(&["suites/*.suite"], &scenario_runner::models::standard())
//! }
//! ```
//!
//! Then `cargo test --test suites tta=6s` runs what has `tta=6s` in its name, and so on, as with any other test.
//!
//! Functional mock-up units are loaded by a process of this very program: whatever `main` does before is done there as well.
//!
//! [`Suites`] says more: which of the files are tests and whose fingerprints are held.

mod fingerprints;

use std::collections::HashSet;
use std::env;
use std::path::Path;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

use libtest_mimic::{Arguments, Failed, Trial};
use thiserror::Error;

use files::Disk;
use files::escape::terminal_line;
use fingerprints::{compare, lines, path, recording};
use lang::Style;
use report::console::stderr;
use report::{explain, render_gate_report, render_rating};
use results::{RatingReport, Skip, Standing, Verdict};
use runner::project::{Project, ProjectOptions};
use runner::run::{Executor, Threads, VerifyRuns};
use runner::session::{OnDemand, gate_key};
use scenario::registry::Registry;
use scenario::{Gate, Rating};
#[cfg(feature = "fmu")]
use under_test::fmu_host;
use under_test::{Allowed, Permission, ProcessPool, supervise_if_asked};

/// Why there are no tests.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TestingError {
    /// A pattern is not one that files can be matched with.
    #[error("`{pattern}` is no pattern of files: {reason}")]
    Pattern {
        /// The pattern.
        pattern: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A pattern matches no file.
    #[error("no file is called `{0}`; paths are relative to the folder of the package")]
    NoFile(String),
    /// A file of that name was asked for and not loaded.
    #[error("`{0}` was not loaded, so that it has no tests")]
    NotLoaded(String),
    /// The errors are on standard error.
    #[error("a suite or scenario has errors")]
    Invalid,
}

/// Runs every unit and judges every rating and gate of the suites and scenarios that the glob patterns name, as the program's arguments say: they are those
/// of `cargo test`. The exit code is 101 if something did not pass or could not be loaded.
///
/// Call it before anything else: this program is started once more beside each program that decides, and ends that if these tests are gone,
/// however they went.
pub fn run(patterns: &[&str], registry: &Registry) -> ExitCode {
    if let Some(ended) = supervise_if_asked() {
        return ended;
    }
    conclude(Suites::open(patterns, registry, &[], true).and_then(|suites| suites.tests(patterns)))
}

/// Runs tests as the program's arguments say. The exit code is 101 if one failed or there are none for a reason.
pub fn conclude(trials: Result<Vec<Trial>, TestingError>) -> ExitCode {
    let arguments = Arguments::from_args();
    match trials {
        Ok(trials) => libtest_mimic::run(&arguments, trials).exit_code(),
        Err(error) => {
            writeln!(stderr(), "error: {error}");
            ExitCode::from(101)
        }
    }
}

/// The units, ratings and gates as tests, to be run together with others.
///
/// A block runs what it needs, whether that is selected or not, and at most once; a rating and a gate run their suite's trials. What
/// could not be decided fails.
///
/// # Errors
/// If a pattern names no file or a file has errors.
pub fn trials(patterns: &[&str], registry: &Registry) -> Result<Vec<Trial>, TestingError> {
    Suites::load(patterns, registry)?.tests(patterns)
}

/// Suites and scenarios, each of whose units is run at most once however many tests ask for it.
pub struct Suites(Arc<Tested>);

impl Suites {
    /// Loads, checks and plans whatever the patterns name, which may name what is in `registry`; a file that several of them name is there once.
    ///
    /// # Errors
    /// If a pattern names no file or a file has errors.
    pub fn load(patterns: &[&str], registry: &Registry) -> Result<Self, TestingError> {
        Self::load_allowing(patterns, registry, &[])
    }

    /// As [`Self::load`]; the programs of declared controllers of these names may run, besides those that the user or the
    /// environment allows. Unlike with [`run`], they are ended with these tests only if these are not ended from one moment to the next.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn load_allowing(
        patterns: &[&str],
        registry: &Registry,
        programs: &[&str],
    ) -> Result<Self, TestingError> {
        Self::open(patterns, registry, programs, false)
    }

    fn open(
        patterns: &[&str],
        registry: &Registry,
        programs: &[&str],
        is_supervisor: bool,
    ) -> Result<Self, TestingError> {
        #[cfg(feature = "fmu")]
        be_fmu_host();
        let files = files(patterns)?;
        let opened = Project::open_all(&files, &ProjectOptions::default(), registry, &Disk);
        let notices = opened.as_ref().map_or_else(|problems| &problems.0[..], Project::notices);
        notices.iter().for_each(|notice| stderr().styled(&notice.render(Style::default())));
        let project = opened.map_err(|_| TestingError::Invalid)?;
        // Tests own what they need and live as long as the process.
        Ok(Self(Arc::new(Tested::new(Box::leak(Box::new(project)), programs, is_supervisor))))
    }

    /// Which of the runs in which programs decide are made a second time, alone in another process, to see whether they come out the same: the
    /// first of each scenario and every 200th unless this says otherwise. What did not is W1102 on standard error, and in the message of a
    /// test that fails; by itself it fails none. Second runs count nowhere.
    ///
    /// # Panics
    /// If there are tests of them already.
    pub fn verify_runs(self, verify: VerifyRuns) -> Self {
        let tested = Arc::into_inner(self.0).expect("no test has been made of them");
        Self(Arc::new(Tested { session: tested.session.verify_runs(verify), ..tested }))
    }

    /// The units, ratings and gates of the files that the patterns name, as [`trials`] gives them.
    ///
    /// # Errors
    /// If a pattern names no file that was loaded.
    pub fn tests(&self, patterns: &[&str]) -> Result<Vec<Trial>, TestingError> {
        let chosen = self.chosen(patterns)?;
        let units =
            self.0.session.units().iter().enumerate().filter(|(_, unit)| chosen.contains(&unit.suite)).map(
                |(index, unit)| {
                    let tested = Arc::clone(&self.0);
                    Trial::test(unit.key.to_string(), move || tested.judge(index))
                },
            );
        let gates = chosen.iter().flat_map(|&suite| {
            let suite_of = &self.0.project.suites()[suite].suite;
            suite_of.gates.iter().map(move |gate| {
                let tested = Arc::clone(&self.0);
                Trial::test(gate_key(&suite_of.name, gate), move || tested.judge_gate(suite, gate))
            })
        });
        let ratings = chosen.iter().flat_map(|&suite| {
            let suite_of = &self.0.project.suites()[suite].suite;
            suite_of.ratings.iter().map(move |rating| {
                let tested = Arc::clone(&self.0);
                let key = RatingReport::key_of(&suite_of.name, rating);
                Trial::test(key, move || tested.judge_rating(suite, rating))
            })
        });
        Ok(units.chain(ratings).chain(gates).collect())
    }

    /// A test for each of the files that the patterns name: every bit of what it runs is as in the file that is kept for
    /// it in `folder`, by target. `FINGERPRINTS=overwrite` records them. A target without such a folder has its tests
    /// ignored: nothing is known of it.
    ///
    /// # Errors
    /// If a pattern names no file that was loaded.
    pub fn fingerprints(&self, patterns: &[&str], folder: &Path) -> Result<Vec<Trial>, TestingError> {
        let test = |suite: usize| {
            let tested = Arc::clone(&self.0);
            let file = &self.0.project.suites()[suite].file;
            let kept = path(folder, file);
            let unknown = !recording() && kept.parent().is_none_or(|folder| !folder.exists());
            Trial::test(format!("fingerprints of {file}"), move || tested.compare_fingerprints(suite, &kept))
                .with_ignored_flag(unknown)
        };
        Ok(self.chosen(patterns)?.into_iter().map(test).collect())
    }

    /// Indices of the suites that the patterns name, in the order in which they were loaded.
    fn chosen(&self, patterns: &[&str]) -> Result<Vec<usize>, TestingError> {
        let wanted = files(patterns)?;
        let suites = self.0.project.suites();
        if let Some(unknown) = wanted.iter().find(|file| suites.iter().all(|suite| suite.file != **file)) {
            return Err(TestingError::NotLoaded(unknown.clone()));
        }
        Ok((0..suites.len()).filter(|index| wanted.contains(&suites[*index].file)).collect())
    }
}

fn files(patterns: &[&str]) -> Result<Vec<String>, TestingError> {
    let mut files = Vec::new();
    for pattern in patterns {
        let failed = |reason: String| TestingError::Pattern { pattern: pattern.to_string(), reason };
        let found = glob::glob(pattern).map_err(|error| failed(error.to_string()))?;
        let mut any = false;
        for path in found {
            let path = path.map_err(|error| failed(error.to_string()))?;
            let path = Path::new(&path).to_string_lossy().into_owned();
            any = true;
            if !files.contains(&path) {
                files.push(path);
            }
        }
        if !any {
            return Err(TestingError::NoFile(pattern.to_string()));
        }
    }
    Ok(files)
}

/// As the hidden command of the program is called.
#[cfg(feature = "fmu")]
const FMU_HOST: &str = "fmu-host";

/// Has a process that was started to load a functional mock-up unit do that, and end with it: it is this very program once more.
#[cfg(feature = "fmu")]
fn be_fmu_host() {
    let mut words = env::args_os().skip(1);
    if words.next().is_some_and(|word| word == FMU_HOST)
        && let (Some(plan), None) = (words.next(), words.next())
    {
        let ended = fmu_host(Path::new(&plan));
        std::process::exit(i32::from(ended != ExitCode::SUCCESS));
    }
}

/// What tests share.
struct Tested {
    project: &'static Project,
    session: OnDemand<'static>,
    /// What was warned of already.
    warned: Mutex<HashSet<(usize, String)>>,
}

impl Tested {
    fn new(project: &'static Project, programs: &[&str], is_supervisor: bool) -> Self {
        let threads = Threads::all();
        let mut permission = Permission::default().of_environment().named(programs.iter().copied());
        if let Ok(allowed) = Allowed::place().and_then(Allowed::read) {
            permission = permission.listed(&allowed);
        }
        // What may not be run is an error of each test that needs it.
        let pool = ProcessPool::new(permission, threads.parallelism());
        let pool = match env::current_exe() {
            Ok(own) if is_supervisor && cfg!(unix) => pool.fmu_host(&own).supervised_by(own),
            Ok(own) => pool.fmu_host(own),
            Err(_) => pool,
        };
        let threads = Box::leak(Box::new(threads.with_processes(Arc::new(pool))));
        Self { project, session: OnDemand::new(project, threads), warned: Mutex::default() }
    }

    /// Says which programs of a suite were seen not to be deterministic, each once, and gives it for the message of a test.
    fn nondeterminism(&self, suite: usize) -> String {
        let file = &self.project.suites()[suite].file;
        let mut all = String::new();
        for controller in self.session.controllers(suite) {
            let Some(warning) = controller.nondeterminism() else { continue };
            let line = format!("warning: {}: {}", terminal_line(file), terminal_line(&warning));
            all.push_str(&format!("\n{line}"));
            let mut warned = self.warned.lock().unwrap_or_else(PoisonError::into_inner);
            if warned.insert((suite, controller.name)) {
                writeln!(stderr(), "{line}");
            }
        }
        all
    }

    fn judge(&self, index: usize) -> Result<(), Failed> {
        let report = self.session.report(index);
        let suite = self.session.units()[index].suite;
        let warning = self.nondeterminism(suite);
        match report.standing() {
            Standing::NotJudged | Standing::Found | Standing::Judged(Verdict::Passed) => Ok(()),
            Standing::Skipped => Err(report.skip().map(Skip::to_string).unwrap_or_default().into()),
            Standing::Judged(_) | Standing::NotFinished(_) | Standing::Errored => {
                Err((explain(&self.session.identity(suite), report, false) + &warning).into())
            }
        }
    }

    fn judge_gate(&self, suite: usize, gate: &Gate) -> Result<(), Failed> {
        let report = self.session.gate(suite, gate);
        let warning = self.nondeterminism(suite);
        match report.standing() {
            Standing::Judged(Verdict::Passed) => Ok(()),
            _ => Err((render_gate_report(&self.session.identity(suite), &report, false) + &warning).into()),
        }
    }

    /// A rating that expects nothing has nothing to fail.
    fn judge_rating(&self, suite: usize, rating: &Rating) -> Result<(), Failed> {
        let report = self.session.rating(suite, rating);
        let warning = self.nondeterminism(suite);
        match report.standing() {
            Standing::NotJudged | Standing::Judged(Verdict::Passed) => Ok(()),
            _ => Err((render_rating(&report, false) + &warning).into()),
        }
    }

    fn compare_fingerprints(&self, suite: usize, kept: &Path) -> Result<(), Failed> {
        let reports = self.session.reports(suite);
        let own = &self.project.suites()[suite].suite;
        let found = lines(own, reports, self.session.requests(), self.project.registry())?;
        Ok(compare(kept, &found)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::standard;

    fn failed(patterns: &[&str], filter: &str) -> (u64, u64) {
        let arguments = Arguments { filter: Some(filter.into()), quiet: true, ..Arguments::default() };
        let conclusion = libtest_mimic::run(&arguments, trials(patterns, &standard()).unwrap());
        (conclusion.num_passed, conclusion.num_failed)
    }

    #[test]
    fn every_unit_is_a_test() {
        assert_eq!(failed(&["suites/zebra.suite"], "scripted"), (4, 0));
        assert_eq!(failed(&["suites/zebra_unsafe.suite"], "stands_in_lane"), (0, 3));
    }

    #[test]
    fn a_block_runs_what_it_needs() {
        let folder = tempfile::tempdir().unwrap();
        let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/zebra/commotions_carla.scn");
        let over = "over av.controller.braking_distance in 4 m .. 25 m; minimise mean(time_lost)";
        let budget = "budget 2 evaluations, by random";
        let search = format!(
            "in commotions_carla; individuals 1 of standard; minimise pet; over tta in 6 s .. 18 s; {budget}"
        );
        let text = format!(
            "suite small {{ scenarios \"{}\" }}\n\
             search found {{ {search} }}\nsearch nobody {{ {search}; keep pet < 0 s }}\n\
             tune good {{ on found; {over}; {budget} }}\ntune bad {{ on nobody; {over}; {budget} }}\n",
            scenario.display()
        );
        let path = folder.path().join("small.suite");
        std::fs::write(&path, text).unwrap();
        assert_eq!(failed(&[&path.to_string_lossy()], "tune="), (1, 1));
    }

    #[test]
    fn what_cannot_be_loaded_is_said() {
        let error = |pattern: &str| trials(&[pattern], &standard()).map(|_| ()).unwrap_err().to_string();
        assert!(error("suites/none_*.suite").contains("no file is called `suites/none_*.suite`"));
        assert!(error("suites/[").contains("is no pattern"));
    }
}
