//! `scenario-runner FILES`: runs suites, reports every trial, writes the reports that were asked for.

use std::collections::HashMap;
use std::env;
use std::fs;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use clap::{Args, ValueEnum};
use libtest_mimic::{Arguments, ColorSetting, Failed};
use rayon::prelude::*;

use super::Exit;
use super::load::{self, Loaded};
use super::progress::Progress;
use super::record::record;
use crate::judge::{Verdict, judge};
use crate::plan::Trial;
use crate::report::{
    Chosen, Recording, SuiteIdentity, SuiteReport, TrialReport, TrialState, annotations, choose_runs,
    render_failure, render_tables, step_summary, to_html, to_json, to_junit, to_tap, write_trace,
};
use crate::run::{FreeFlows, Outcome, Requests, RunError, Stop, Unwatched, run_case, run_trial};
use crate::scenario::Case;
use crate::sim::Trace;

#[derive(Debug, Args)]
pub struct RunArguments {
    /// Suites (.suite) and scenarios (.scn, .yaml) to run; any other word selects trials whose name contains it.
    #[arg(required = true, value_name = "FILE|FILTER")]
    words: Vec<String>,

    /// The filter is the whole name of a trial.
    #[arg(long)]
    exact: bool,

    /// Leave out trials whose name contains this; may be repeated.
    #[arg(long, value_name = "FILTER")]
    skip: Vec<String>,

    /// Print the names of the trials and run nothing.
    #[arg(long)]
    list: bool,

    /// Number of trials that run side by side [default: one per core]. Results do not depend on it.
    #[arg(long, value_name = "N")]
    test_threads: Option<usize>,

    /// Replaces the seed of every suite.
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,

    /// Write a JUnit XML report.
    #[arg(long, value_name = "PATH")]
    junit: Option<PathBuf>,

    /// Write all results as JSON.
    #[arg(long, value_name = "PATH")]
    json: Option<PathBuf>,

    /// Write a TAP 14 report.
    #[arg(long, value_name = "PATH")]
    tap: Option<PathBuf>,

    /// Print GitHub annotations and append to the step's summary [default: in GitHub Actions only].
    #[arg(long)]
    github: bool,

    /// Write one HTML file with tables, charts and animations of the worst runs.
    #[arg(long, value_name = "PATH")]
    html: Option<PathBuf>,

    /// Write the course of every run as CSV into this folder.
    #[arg(long, value_name = "DIR")]
    trace: Option<PathBuf>,

    /// Never draw a progress bar.
    #[arg(long)]
    no_progress: bool,

    /// When to use colours.
    #[arg(long, value_enum, default_value_t = Colour::Auto)]
    color: Colour,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Colour {
    Auto,
    Always,
    Never,
}

impl Colour {
    /// Whether to colour what goes to `stream`.
    pub fn wanted(self, stream: &impl IsTerminal) -> bool {
        match self {
            Self::Auto => {
                stream.is_terminal() && env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
            }
            Self::Always => true,
            Self::Never => false,
        }
    }
}

pub fn run(arguments: RunArguments) -> Exit {
    let (files, filters): (Vec<_>, Vec<_>) =
        arguments.words.iter().partition(|word| load::names_a_file(word));
    if files.is_empty() {
        eprintln!("error: no suite or scenario is named");
        eprintln!("help: name a file, as in `scenario-runner suites/zebra.suite`");
        return Exit::Usage;
    }
    if filters.len() > 1 {
        let filters: Vec<_> = filters.iter().map(|filter| format!("`{filter}`")).collect();
        eprintln!("error: more than one filter: {}", filters.join(", "));
        eprintln!(
            "help: files end in .suite, .scn or .yaml; give one filter, and use --skip to leave trials out"
        );
        return Exit::Usage;
    }
    let colour = arguments.color.wanted(&io::stderr());
    let loaded = match load::load_all(&files, arguments.seed, colour) {
        Ok(loaded) => loaded,
        Err(exit) => return exit,
    };
    if let Some(folder) = &arguments.trace
        && let Err(error) = fs::create_dir_all(folder)
    {
        eprintln!("error: cannot create the folder {}: {error}", folder.display());
        return Exit::Output;
    }
    let filter = filters.first().map(|filter| filter.to_string());
    let session = Arc::new(Session::new(loaded, filter, arguments));
    if session.selected().is_empty() {
        eprintln!("error: no trial is selected");
        eprintln!("help: `--list` shows the names of all trials");
        return Exit::NothingSelected;
    }
    session.run()
}

/// One invocation's worth of trials and what they share.
struct Session {
    arguments: RunArguments,
    loaded: Vec<Loaded>,
    filter: Option<String>,
    requests: Requests,
    free_flows: FreeFlows,
    progress: Progress,
    /// Per suite and trial, in the order of the plans; empty until the trial has run.
    finished: Vec<Vec<Mutex<Option<Finished>>>>,
    /// What could not be written.
    complaints: Mutex<Vec<String>>,
    started: SystemTime,
    begun: Instant,
}

/// What became of a trial.
struct Finished {
    outcomes: Vec<Outcome>,
    state: TrialState,
    wall_time: Duration,
}

impl Session {
    fn new(loaded: Vec<Loaded>, filter: Option<String>, arguments: RunArguments) -> Self {
        let mut requests = Requests::defaults();
        loaded
            .iter()
            .flat_map(|suite| &suite.plan.trials)
            .for_each(|trial| requests.include(&trial.criteria));
        let nothing = |suite: &Loaded| suite.plan.trials.iter().map(|_| Mutex::new(None)).collect();
        let mut session = Self {
            finished: loaded.iter().map(nothing).collect(),
            requests,
            free_flows: FreeFlows::default(),
            progress: Progress::new(0, false),
            complaints: Mutex::default(),
            started: SystemTime::now(),
            begun: Instant::now(),
            arguments,
            loaded,
            filter,
        };
        let runs =
            session.selected().into_iter().map(|(suite, trial)| session.trial(suite, trial).cases.len());
        let runs = runs.sum::<usize>() as u64;
        session.progress = Progress::new(runs, !session.arguments.no_progress && io::stderr().is_terminal());
        session
    }

    fn trial(&self, suite: usize, trial: usize) -> &Trial {
        &self.loaded[suite].plan.trials[trial]
    }

    /// Indices of the suites and trials that the filters leave.
    fn selected(&self) -> Vec<(usize, usize)> {
        let matches = |key: &str, filter: &String| {
            if self.arguments.exact { key == filter } else { key.contains(filter.as_str()) }
        };
        let wanted = |key: &str| {
            self.filter.as_ref().is_none_or(|filter| matches(key, filter))
                && !self.arguments.skip.iter().any(|skip| matches(key, skip))
        };
        let all = self.loaded.iter().enumerate().flat_map(|(suite, loaded)| {
            loaded.plan.trials.iter().enumerate().map(move |(index, trial)| (suite, index, trial))
        });
        all.filter(|(_, _, trial)| wanted(&trial.key)).map(|(suite, index, _)| (suite, index)).collect()
    }

    fn run(self: Arc<Self>) -> Exit {
        let arguments = Arguments {
            list: self.arguments.list,
            test_threads: self.arguments.test_threads,
            color: Some(match self.arguments.color {
                Colour::Auto => ColorSetting::Auto,
                Colour::Always => ColorSetting::Always,
                Colour::Never => ColorSetting::Never,
            }),
            ..Arguments::default()
        };
        let selected = self.selected();
        let trials = selected.iter().map(|&(suite, trial)| {
            let session = Arc::clone(&self);
            let key = self.trial(suite, trial).key.clone();
            libtest_mimic::Trial::test(key, move || session.run_one(suite, trial))
        });
        let conclusion = libtest_mimic::run(&arguments, trials.collect());
        if self.arguments.list {
            return Exit::Success;
        }
        let reports: Vec<_> = (0..self.loaded.len()).map(|suite| self.report(suite)).collect();
        self.write_reports(&reports);
        self.print_summary(&reports);
        let complaints = self.complaints.lock().unwrap_or_else(PoisonError::into_inner);
        for complaint in complaints.iter() {
            eprintln!("error: {complaint}");
        }
        if !complaints.is_empty() {
            return Exit::Output;
        }
        let ran = |trial: &&TrialReport| !trial.skipped();
        let verdicts =
            || reports.iter().flat_map(|report| &report.trials).filter(ran).map(TrialReport::verdict);
        if verdicts().any(|verdict| verdict == Some(Verdict::Failed)) || conclusion.has_failed() {
            let undecided = |verdict| matches!(verdict, Some(Verdict::Inconclusive | Verdict::Passed));
            if verdicts().all(undecided) { Exit::Inconclusive } else { Exit::Failed }
        } else {
            Exit::Success
        }
    }

    /// Runs and judges one trial; an error holds what the terminal is to show.
    fn run_one(&self, suite: usize, index: usize) -> Result<(), Failed> {
        let trial = self.trial(suite, index);
        let begun = Instant::now();
        let limit = self.loaded[suite].plan.time_limit.map(Duration::from_secs_f64);
        let (outcomes, state) = match run_trial(trial, limit, &Stop::default(), |case| self.run_case(case)) {
            Ok(outcomes) => {
                let judged = judge(&trial.criteria, &outcomes, &self.requests);
                (outcomes, TrialState::Judged(judged))
            }
            Err(error) => (Vec::new(), TrialState::Errored(error.to_string())),
        };
        let passed = matches!(&state, TrialState::Judged(judged) if judged.verdict == Verdict::Passed);
        let finished = Finished { outcomes, state: state.clone(), wall_time: begun.elapsed() };
        *self.slot(suite, index) = Some(finished);
        self.progress.trial_done();
        if passed {
            return Ok(());
        }
        let colour = self.arguments.color.wanted(&io::stdout());
        Err(render_failure(&self.identity(suite), &state, colour).into())
    }

    fn run_case(&self, case: &Case) -> Result<Outcome, RunError> {
        let outcome = match &self.arguments.trace {
            None => run_case(case, &self.requests, &self.free_flows, &mut Unwatched)?,
            Some(folder) => {
                let mut trace = Trace::default();
                let outcome = run_case(case, &self.requests, &self.free_flows, &mut trace)?;
                if let Err(error) = save_trace(folder, case, &trace) {
                    self.complain(format!("cannot write a trace into {}: {error}", folder.display()));
                }
                outcome
            }
        };
        self.progress.run_done();
        Ok(outcome)
    }

    fn slot(&self, suite: usize, trial: usize) -> std::sync::MutexGuard<'_, Option<Finished>> {
        self.finished[suite][trial].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// All trials of a suite; those that have not run are skipped ones.
    fn report(&self, suite: usize) -> SuiteReport<'_> {
        let loaded = &self.loaded[suite];
        let trials = loaded.plan.trials.iter().enumerate().map(|(index, trial)| {
            let (outcomes, state, wall_time) = match self.slot(suite, index).as_ref() {
                Some(finished) => (finished.outcomes.clone(), finished.state.clone(), finished.wall_time),
                None => (Vec::new(), TrialState::Skipped("not selected".into()), Duration::ZERO),
            };
            TrialReport { trial, outcomes, state, wall_time }
        });
        SuiteReport {
            identity: self.identity(suite),
            started: self.started,
            wall_time: self.begun.elapsed(),
            trials: trials.collect(),
            blocks: Vec::new(),
        }
    }

    fn identity(&self, suite: usize) -> SuiteIdentity<'_> {
        let loaded = &self.loaded[suite];
        SuiteIdentity { suite: &loaded.plan.suite, file: &loaded.file, seed: loaded.plan.seed }
    }

    fn complain(&self, complaint: String) {
        self.complaints.lock().unwrap_or_else(PoisonError::into_inner).push(complaint);
    }

    fn write_reports(&self, reports: &[SuiteReport]) {
        let write = |path: &Option<PathBuf>, content: &dyn Fn() -> Result<String, String>| {
            let Some(path) = path else { return };
            let written = content().and_then(|text| save(path, &text).map_err(|error| error.to_string()));
            if let Err(error) = written {
                self.complain(format!("cannot write {}: {error}", path.display()));
            }
        };
        write(&self.arguments.junit, &|| {
            to_junit(reports, &self.requests).map_err(|error| error.to_string())
        });
        write(&self.arguments.json, &|| Ok(to_json(reports, &self.requests)));
        write(&self.arguments.tap, &|| Ok(to_tap(reports)));
        write(&self.arguments.html, &|| self.html(reports));
        if self.arguments.github || env::var_os("GITHUB_ACTIONS").is_some_and(|value| value == "true") {
            self.tell_github(reports);
        }
    }

    /// Annotations go to stdout; the summary goes to the file that GitHub names.
    fn tell_github(&self, reports: &[SuiteReport]) {
        print!("{}", annotations(reports));
        let Some(path) = env::var_os("GITHUB_STEP_SUMMARY").filter(|path| !path.is_empty()) else { return };
        let summary = step_summary(reports, &self.requests);
        let opened = fs::OpenOptions::new().create(true).append(true).open(&path);
        if let Err(error) = opened.and_then(|mut file| file.write_all(summary.as_bytes())) {
            self.complain(format!("cannot write {}: {error}", Path::new(&path).display()));
        }
    }

    /// The HTML report, for which some runs are run again to record their course.
    fn html(&self, reports: &[SuiteReport]) -> Result<String, String> {
        let chosen: Vec<_> = reports.iter().flat_map(choose_runs).collect();
        let outcomes: HashMap<&str, (&Case, &Outcome)> = reports
            .iter()
            .flat_map(|report| &report.trials)
            .flat_map(|trial| trial.trial.cases.iter().zip(&trial.outcomes))
            .map(|(case, outcome)| (case.key.as_str(), (case, outcome)))
            .collect();
        let again = |chosen: Chosen| {
            let (case, outcome) = outcomes[chosen.key.as_str()];
            let recorded =
                record(case, &self.requests, &self.free_flows).map_err(|error| error.to_string())?;
            if recorded.outcome.fingerprint != outcome.fingerprint {
                return Err(format!(
                    "{} went differently when it was repeated: please report this",
                    case.key
                ));
            }
            Ok((chosen, Recording::new(case, &recorded.trace, recorded.events)))
        };
        let recordings: Vec<_> = chosen.into_par_iter().map(again).collect::<Result<_, String>>()?;
        Ok(to_html(reports, &self.requests, &recordings))
    }

    fn print_summary(&self, reports: &[SuiteReport]) {
        let colour = self.arguments.color.wanted(&io::stdout());
        let mut out = io::stdout().lock();
        for report in reports {
            let ran = report.trials.iter().filter(|trial| !trial.skipped()).count();
            if ran == 0 {
                continue;
            }
            let runs: usize = report.trials.iter().map(|trial| trial.outcomes.len()).sum();
            let identity = &report.identity;
            let line = format!(
                "{}: {ran} trials, {runs} runs, seed {}, {:.2} s",
                identity.suite,
                identity.seed,
                report.wall_time.as_secs_f64()
            );
            let tables = render_tables(report, &self.requests, colour);
            // A closed pipe is the reader's choice, not an error.
            let _ = writeln!(out, "{tables}\n{line}");
        }
    }
}

/// Writes a file, making the folders it is to be in.
fn save(path: &Path, text: &str) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(path, text)
}

fn save_trace(folder: &Path, case: &Case, trace: &Trace) -> io::Result<()> {
    let name = case.key.replace('/', "__");
    let file = fs::File::create(folder.join(format!("{name}.csv")))?;
    write_trace(&case.world, trace, io::BufWriter::new(file))
}
