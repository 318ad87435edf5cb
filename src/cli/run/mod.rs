//! `scenario-runner FILES`: runs suites, reports every trial and block, writes the reports that were asked for.

pub mod conduct;
pub mod estimate_tries;
pub mod hints;
mod listed;
pub mod output;
pub mod parent;
pub mod partition;
mod remember;
mod seeds;
pub mod select;
pub mod targets;
mod tries;
pub mod watch;
mod wire;

use std::collections::BTreeSet;
use std::env;
use std::path::{Path, PathBuf};

use clap::{Args, Command, ValueEnum};

use super::interrupt::stop_on_interrupt;
use super::one_case::known_alone;
use super::{Exit, filter, load, measured, store};
use lang::filter::Show;
use report::console::stderr;
use results::{Overall, Results};
use runner::session::{self, RunWatch, Selection};
use scenario::registry::Registry;

use self::conduct::{ConductArguments, ConductOrders, Conducted};
use self::listed::{ListFormat, list};
use self::parent::ServedByParent;
pub use self::remember::LastRun;

#[derive(Debug, Args)]
pub struct RunArguments {
    /// Suites (.suite) and scenarios (.scn, .yaml) to run; any other word selects trials and blocks whose name contains it.
    #[arg(value_name = "FILE|FILTER")]
    words: Vec<String>,

    #[command(flatten)]
    select: select::SelectArguments,

    /// Print the names of the trials and blocks and run nothing.
    #[arg(long)]
    list: bool,

    /// How `--list` is written: to be read, or for other programs (docs/running.md).
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = ListFormat::Text, requires = "list")]
    format: ListFormat,

    /// What it means when nothing is selected.
    #[arg(long, value_enum, default_value_t = NoTests::Fail)]
    no_tests: NoTests,

    #[command(flatten)]
    conduct: ConductArguments,

    /// Whoever started this program decides for this declared controller: requests go to standard output, answers come from standard input,
    /// and what else is said goes to standard error. Its own command is not run and needs no permission.
    #[arg(long, value_name = "NAME", conflicts_with = "list")]
    serve_by_parent: Option<String>,

    #[command(flatten)]
    remember: remember::RememberArguments,

    #[command(flatten)]
    output: output::OutputArguments,

    /// What does not count as passed, though by itself it does.
    #[arg(long, value_enum, value_name = "WHAT")]
    deny: Vec<Deny>,

    /// Write the course of every run as CSV into this folder.
    #[arg(long, value_name = "DIR")]
    trace: Option<PathBuf>,

    /// What `--trace` writes of everybody: with `full` also how far along the road from the crossing, how far beside the centre line
    /// of lane 0, and where they face.
    #[arg(long, value_enum, value_name = "COLUMNS", default_value_t = watch::Columns::Plain, requires = "trace")]
    trace_columns: watch::Columns,

    /// Write what a program is asked and what it says into this file, of the first selected run in which one decides; `try --wire` asks
    /// it again.
    #[arg(long, value_name = "PATH")]
    record_wire: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum NoTests {
    /// An error.
    Fail,
    /// A warning.
    Warn,
    /// Nothing.
    Pass,
}

/// What a build may not rest on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Deny {
    /// Criteria that passed without being put to the test, of which every report warns: the exit code is 102.
    Untested,
}

/// Runs what is named; `program` is the whole command line, whose commands somebody may have meant.
pub fn run(arguments: RunArguments, registry: &Registry, program: &Command) -> Exit {
    let served = match arguments.serve_by_parent.as_deref().map(ServedByParent::take).transpose() {
        Ok(served) => served,
        Err(exit) => return exit,
    };
    let (files, filters): (Vec<_>, Vec<_>) =
        arguments.words.iter().partition(|word| load::names_a_file(word));
    if arguments.words.is_empty() {
        return hints::project();
    }
    let command = arguments.words.first().and_then(|word| hints::command(word, program));
    if (files.is_empty() || filters.len() > 1)
        && let Some(near) = &command
    {
        writeln!(stderr(), "error: there is no command `{}`", arguments.words[0]);
        writeln!(stderr(), "help: did you mean `{near}`?");
        return Exit::Usage;
    }
    if files.is_empty() {
        writeln!(stderr(), "error: no suite or scenario is named");
        writeln!(stderr(), "help: name a file, as in `scenario-runner suites/zebra.suite`");
        return Exit::Usage;
    }
    if let Err(exit) = hints::one_filter(&filters) {
        return exit;
    }
    let colour = arguments.conduct.shown.color.wanted(stderr());
    let expressions = match arguments.select.subjects.expressions.read(colour) {
        Ok(expressions) => expressions,
        Err(exit) => return exit,
    };
    let project =
        match load::load_all(&files, arguments.conduct.seed, &arguments.conduct.set, colour, registry) {
            Ok(project) => project,
            Err(exit) => return exit,
        };
    let suites = project.suites();
    let baselines: BTreeSet<&str> =
        suites.iter().flat_map(|suite| &suite.suite.gates).map(|gate| gate.baseline.as_str()).collect();
    let mut written = arguments.output.files();
    written.extend(arguments.record_wire.as_deref().map(|path| ("--record-wire", path)));
    if let Err(complaint) = targets::check(&written, &targets::read_by(suites)) {
        writeln!(stderr(), "error: {complaint}");
        writeln!(stderr(), "help: name another file; nothing was run, and nothing was written");
        return Exit::Usage;
    }
    if let Some(Err(exit)) = served.as_ref().map(|served| served.check(&written)) {
        return exit;
    }
    baselines.into_iter().for_each(|path| measured::warn_of_unchecked(Path::new(path)));
    let units = session::units(suites);
    let mut last = LastRun::read();
    let each = |show: &mut Show| {
        units.iter().for_each(|unit| select::with_subject(suites, &unit, &mut *show));
    };
    filter::warn(&expressions, &each, colour);
    let said = filters.first().map(|filter| filter.as_str());
    let alone = said.and_then(|word| known_alone(word, suites));
    let word = alone.as_deref().or(said);
    let subjects = (&arguments.select.subjects, arguments.select.partition);
    let select = |failed: Option<&BTreeSet<String>>| {
        select::select(suites, &units, &expressions, word, subjects, failed)
    };
    let mut asked = select(arguments.select.last_failed.then(|| last.failed_units(suites, &units)).as_ref());
    if arguments.select.last_failed && !asked.contains(&true) {
        asked = select(None);
        if asked.contains(&true) {
            let why = if last.is_damaged {
                "what failed when it was last run cannot be read, or is damaged"
            } else {
                "nothing of this is known to have failed when it was last run"
            };
            writeln!(stderr(), "note: {why}: all of it is run");
        }
    }
    let chosen = session::with_needs(&units, asked);
    if !chosen.contains(&true) {
        let keys: Vec<String> = units.keys().collect();
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        let hints = hints::selection(
            word,
            arguments.select.subjects.exact,
            command.filter(|_| word == Some(&arguments.words[0])),
            &keys,
        );
        return nothing_selected(arguments.no_tests, word, &hints);
    }
    if arguments.list {
        return list(arguments.format, suites, &units, &chosen);
    }
    if let Some(folder) = &arguments.trace
        && let Err(error) = files::make_folder(folder)
    {
        writeln!(stderr(), "error: cannot create the folder {}: {error}", folder.display());
        return Exit::Output;
    }
    let record = match arguments.record_wire.as_ref().map(|_| wire::record(&units, &chosen)).transpose() {
        Ok(record) => record,
        Err(exit) => return exit,
    };
    let watch = served.as_ref().map(ServedByParent::watch);
    let own = suites.iter().map(|one| &one.suite);
    let conduct = &arguments.conduct;
    let threads = conduct.programs.threads_with(conduct.test_threads, own, record, served);
    let (threads, processes) = match threads {
        Ok(threads) => threads,
        Err(exit) => return exit,
    };
    let stop = stop_on_interrupt();
    watch.into_iter().for_each(|parent| parent.end_with(&stop));
    if let Err(exit) = store::prepare(&conduct.journal) {
        return exit;
    }
    let watcher =
        arguments.trace.as_deref().map(|folder| watch::Traces::new(folder, arguments.trace_columns));
    let watch = watcher.as_ref().map(|traces| |case: &_, trace: &_| traces.save(case, trace));
    let mut lines = match arguments.output.begin_lines(&units, &chosen, in_github_actions()) {
        Ok(lines) => lines,
        Err(complaint) => {
            writeln!(stderr(), "error: {complaint}");
            return Exit::Output;
        }
    };
    let orders = ConductOrders {
        project: &project,
        units: &units,
        selection: Selection::marked(chosen).until_failures(conduct.max_failures()),
        executor: &threads,
        stop: &stop,
        watch: watch.as_ref().map(|watch| watch as &RunWatch),
        courses: arguments.output.draw_runs(),
        every_trial: arguments.output.need_every_trial(in_github_actions()),
        besides: lines.as_mut().map(output::WrittenLines::reporter),
        is_repeated: false,
        is_merged: false,
    };
    let Conducted { mut results, mut complaints, notices } = conduct.conduct(orders, &mut last);
    results.denies_untested = arguments.deny.contains(&Deny::Untested);
    let reports = &results.suites;
    complaints.extend(watcher.as_ref().map(watch::Traces::finish).unwrap_or_default());
    complaints.extend(lines.and_then(output::WrittenLines::end));
    complaints.extend(output::write(&arguments.output, &results, in_github_actions()));
    complaints.extend(wire::write(arguments.record_wire.as_deref(), processes.as_deref()));
    complaints.extend(remember::failures(&arguments.remember, suites, reports, &results.requests));
    for notice in &notices {
        writeln!(stderr(), "note: {notice}");
    }
    for complaint in &complaints {
        writeln!(stderr(), "error: {complaint}");
    }
    if stop.is_requested() {
        Exit::Interrupted
    } else if !complaints.is_empty() {
        Exit::Output
    } else {
        let unasked =
            arguments.serve_by_parent.as_deref().and_then(|name| parent::was_not_asked(name, reports));
        if let Some(unasked) = unasked.filter(|_| results.overall() == Overall::Passed) {
            writeln!(stderr(), "error: {unasked}");
            return Exit::NothingSelected;
        }
        judged(&results)
    }
}

/// The exit code for what everything that was selected came to. What says little by itself is said on stderr.
pub fn judged(results: &Results) -> Exit {
    let (overall, reports) = (results.overall(), &results.suites);
    if overall == Overall::NothingJudged {
        writeln!(stderr(), "warning: nothing was judged: no criterion applies to what was run");
        if reports.iter().any(|report| !report.ratings.is_empty()) {
            writeln!(
                stderr(),
                "help: a rating has a verdict if it says what the points must be: `expect {{ points >= 3 }}`"
            );
        }
    }
    let untested = if results.denies_untested { results.untested() } else { 0 };
    if untested > 0 {
        let units = if untested == 1 { "1 unit".to_string() } else { format!("{untested} units") };
        writeln!(
            stderr(),
            "error: in {units} criteria passed untested, which `--deny untested` does not count as passed"
        );
    }
    exit(overall)
}

/// Whether GitHub runs this.
pub fn in_github_actions() -> bool {
    env::var_os("GITHUB_ACTIONS").is_some_and(|value| value == "true")
}

/// The exit code for what a session came to.
pub fn exit(overall: Overall) -> Exit {
    match overall {
        Overall::Failed => Exit::Failed,
        Overall::Regressed => Exit::Regressed,
        Overall::NotComparable => Exit::Baseline,
        Overall::Inconclusive | Overall::NothingJudged => Exit::Inconclusive,
        Overall::Passed => Exit::Success,
    }
}

fn nothing_selected(no_tests: NoTests, word: Option<&str>, hints: &[String]) -> Exit {
    let (said, exit) = match no_tests {
        NoTests::Fail => ("error", Exit::NothingSelected),
        NoTests::Warn => ("warning", Exit::Success),
        NoTests::Pass => return Exit::Success,
    };
    match word {
        Some(word) => writeln!(stderr(), "{said}: no trial is selected by `{word}`"),
        None => writeln!(stderr(), "{said}: no trial is selected"),
    }
    hints.iter().for_each(|hint| writeln!(stderr(), "help: {hint}"));
    writeln!(stderr(), "help: `--list` shows the names of all trials and blocks");
    exit
}
