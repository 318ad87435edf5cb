//! How what was selected is run and shown, whoever selected it.

use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};

use super::estimate_tries;
use super::remember::{LastRun, Learning};
use super::seeds::TriedSeeds;
use crate::cli::programs::{ProgramArguments, VerifyArguments};
use crate::cli::progress::shows_progress;
use crate::cli::set::SetArguments;
use crate::cli::{number, store};
use report::console::{Output, stderr, stdout};
use report::{Live, StatusLevel, Terminal, render_controllers, render_gates, render_ratings};
use results::{Reporter, Results};
use runner::project::Project;
use runner::run::{Executor, Stop};
use runner::session::{RunWatch, Selection, Session, Units};

/// Of every command that runs what is selected.
#[derive(Debug, Args)]
pub struct ConductArguments {
    /// Number of threads, at most 1024 [default: one per core]. Trials and blocks run side by side; threads to spare share the runs of a
    /// trial. Results do not depend on it.
    #[arg(long, short = 'j', visible_alias = "jobs", value_name = "N", value_parser = number::threads())]
    pub test_threads: Option<usize>,

    /// Begin nothing more after so many failures (`all`: never mind). What could not be decided is no failure.
    #[arg(long, value_name = "N|all", default_value = "all")]
    max_fail: MaxFail,

    /// Begin nothing more after the first failure: `--max-fail 1`.
    #[arg(long, conflicts_with = "max_fail")]
    fail_fast: bool,

    /// Replaces the seed of every suite.
    #[arg(long, value_name = "SEED")]
    pub seed: Option<u64>,

    #[command(flatten)]
    pub set: SetArguments,

    #[command(flatten)]
    pub programs: ProgramArguments,

    #[command(flatten)]
    verify: VerifyArguments,

    /// Where a search or tune that is cut off leaves its journal, from which the same command goes on.
    #[arg(long, value_name = "DIR", default_value = store::JOURNAL)]
    pub journal: PathBuf,

    #[command(flatten)]
    pub shown: ShownArguments,
}

/// How gates are judged and what is shown, whoever made the runs.
#[derive(Debug, Args)]
pub struct ShownArguments {
    /// Leave trials that a gate's baseline lacks out of the comparison, instead of refusing to judge the gate.
    #[arg(long)]
    baseline_lenient: bool,

    /// Which trials and blocks get a line of their own.
    #[arg(long, value_enum, default_value_t = ShownLevel(StatusLevel::Pass))]
    status_level: ShownLevel,

    /// Never show what is under way; it never is in CI or where standard error is no terminal.
    #[arg(long)]
    no_progress: bool,

    /// When to use colours.
    #[arg(long, value_enum, default_value_t = Colour::Auto)]
    pub color: Colour,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Colour {
    Auto,
    Always,
    Never,
}

impl Colour {
    /// Whether to colour what goes to `stream`.
    pub fn wanted(self, stream: Output) -> bool {
        match self {
            Self::Auto => stream.takes_colour(),
            Self::Always => true,
            Self::Never => false,
        }
    }
}

/// After how many failures nothing more begins; `None` for never.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct MaxFail(Option<usize>);

impl FromStr for MaxFail {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            _ if text == "all" => Ok(Self(None)),
            Ok(number) if number > 0 => Ok(Self(Some(number))),
            _ => Err("it is a number from 1, or `all`".to_string()),
        }
    }
}

/// A level, as it is called on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ShownLevel(StatusLevel);

impl ValueEnum for ShownLevel {
    fn value_variants<'a>() -> &'a [Self] {
        use StatusLevel::{All, Dot, Fail, None, Pass, Skip, Slow};
        &[Self(None), Self(Dot), Self(Fail), Self(Slow), Self(Pass), Self(Skip), Self(All)]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (name, help) = match self.0 {
            StatusLevel::None => ("none", "No lines, only failures and the summary at the end"),
            StatusLevel::Dot => (
                "dot",
                "No lines, but a character each: `.` passed, `F` failed, `?` inconclusive, `E` could not be run, `T` time limit, `i` \
                 interrupted, `s` skipped, `-` not judged",
            ),
            StatusLevel::Fail => ("fail", "Those that did not pass"),
            StatusLevel::Slow => ("slow", "And, once a minute, those that take long"),
            StatusLevel::Pass => ("pass", "And those that passed"),
            StatusLevel::Skip => ("skip", "And those that were not run, with the reason"),
            StatusLevel::All => ("all", "And each when it begins"),
        };
        Some(PossibleValue::new(name).help(help))
    }
}

/// What is to be run, with what.
pub struct ConductOrders<'o> {
    pub project: &'o Project,
    pub units: &'o Units<'o>,
    pub selection: Selection,
    pub executor: &'o dyn Executor,
    pub stop: &'o Stop,
    /// Who is given the course of every run.
    pub watch: Option<&'o RunWatch<'o>>,
    /// Whether the results are to have the courses of runs that reports draw.
    pub courses: bool,
    pub every_trial: bool,
    /// Who hears what happens besides the terminal, and sees every metric of runs.
    pub besides: Option<&'o mut dyn Reporter>,
    /// Whether what was stopped is to be run again, so that nobody has to be told, and what it did not come to is not remembered.
    pub is_repeated: bool,
    /// Whether all runs were made before: then nothing is gone on from but their results, and of what was stopped nothing is told or
    /// remembered.
    pub is_merged: bool,
}

/// What came of it.
pub struct Conducted {
    pub results: Results,
    /// What could not be done, in words.
    pub complaints: Vec<String>,
    pub notices: Vec<String>,
}

impl ConductArguments {
    /// Of a command that shows results of runs that were made before.
    pub fn of_results(
        test_threads: Option<usize>,
        programs: ProgramArguments,
        verify: VerifyArguments,
        shown: ShownArguments,
    ) -> Self {
        Self {
            test_threads,
            max_fail: MaxFail(None),
            fail_fast: false,
            seed: None,
            set: SetArguments::default(),
            programs,
            verify,
            journal: store::JOURNAL.into(),
            shown,
        }
    }

    /// After how many failures nothing more begins.
    pub fn max_failures(&self) -> Option<usize> {
        if self.fail_fast { Some(1) } else { self.max_fail.0 }
    }

    /// Runs it, shows on the terminal what happens and what came of it, and remembers that for next time.
    pub fn conduct(&self, orders: ConductOrders, last: &mut LastRun) -> Conducted {
        let ConductOrders {
            project,
            units,
            selection,
            executor,
            stop,
            watch,
            courses,
            every_trial,
            besides,
            is_repeated,
            is_merged,
        } = orders;
        let mut tried = TriedSeeds::read().unwrap_or_else(|error| {
            writeln!(
                stderr(),
                "warning: which seeds were tried before cannot be read, and is forgotten: {error}"
            );
            TriedSeeds::default()
        });
        let mut session = Session::new(project)
            .executor(executor)
            .every_metric(is_merged || besides.is_some())
            .timeless(is_merged)
            .stopped_by(stop)
            .verify_runs(self.verify.runs())
            .after_seeds(tried.earlier(project.suites()))
            .lenient_gates(self.shown.baseline_lenient)
            .courses(courses)
            .every_trial(every_trial);
        if let Some(watch) = watch {
            session = session.watched_by(watch);
        }
        if !is_merged {
            session = session.journals(&self.journal);
        }
        let colour = self.shown.color.wanted(stdout());
        let live = shows_progress(self.shown.no_progress).then(Live::new);
        session =
            session.pilot_runs(!is_merged && live.is_some() && self.shown.status_level.0 != StatusLevel::Dot);
        let terminal = Terminal::new(self.shown.status_level.0, colour, live);
        // A shorter life of its own.
        let besides = besides.map(|one| one as &mut dyn Reporter);
        // What results that are not those of the plan come to is nothing to be told.
        let repeated = (is_repeated || is_merged).then_some(stop);
        let mut learning = Learning { terminal, units, last, repeated, besides };
        let mut complaints = Vec::new();
        let mut results = session.run_units(units, &selection, &mut learning).unwrap_or_else(|error| {
            complaints.push(error.to_string());
            error.results()
        });
        let notices = session.notices();
        if (is_repeated || is_merged) && stop.is_requested() {
            if is_repeated {
                // What failed by then comes first next time.
                let _ = last.write();
            }
            return Conducted { results, complaints: Vec::new(), notices };
        }
        for told in estimate_tries::note(&mut results.suites) {
            writeln!(stderr(), "warning: {told}");
        }
        let reports = &results.suites;
        stdout().styled(&render_controllers(reports, colour));
        stdout().styled(&render_ratings(reports, colour));
        stdout().styled(&render_gates(reports, colour));
        last.learn_gates(reports);
        tried.learn(reports);
        if let Err(error) = tried.write() {
            writeln!(stderr(), "warning: cannot remember which seeds were tried: {error}");
        }
        if let Err(error) = last.write() {
            writeln!(stderr(), "warning: cannot remember what failed: {error}");
        }
        Conducted { results, complaints, notices }
    }
}
