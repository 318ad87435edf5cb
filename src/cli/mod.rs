//! The command line: one file a subcommand.

mod allow;
mod baseline;
mod bug;
mod calibrate;
mod check;
mod compare;
mod convert;
mod diff;
mod exec;
mod exit;
mod experiment;
mod explain;
mod filter;
mod format;
mod help;
mod init;
mod interrupt;
mod list;
pub(crate) mod load;
mod lsp;
mod measured;
mod merge;
mod models;
mod number;
mod on_engine;
mod one_case;
mod parameters;
mod plan;
mod planned;
mod program_files;
mod programs;
mod progress;
mod project;
mod replay;
mod report;
mod run;
pub(crate) mod set;
mod shrink;
mod shrunk;
mod sketch;
mod store;
mod try_program;
mod validate;
mod validate_crosscdr;
mod validate_population;
mod watch;
mod why;

#[cfg(not(feature = "fmu"))]
use std::path::Path;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

pub use bug::guarded;
pub use exit::Exit;

use ::report::console::{stderr, stdout};
use runner::run::note_places;
use scenario::registry::Registry;
use under_test::supervise_if_asked;

/// Tests automated-vehicle controllers against pedestrians who behave like people.
///
/// Reads suites (.suite) and scenarios (.scn), simulates every case and judges it by the criteria that the files
/// state. Every result can be repeated: the same file and seed give the same numbers, bit for bit.
#[derive(Debug, Parser)]
#[command(
    name = "scenario-runner",
    version,
    args_conflicts_with_subcommands = true,
    disable_help_subcommand = true,
    subcommand_negates_reqs = true,
    after_long_help = exit::HELP
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: run::RunArguments,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Write a commented starter project that runs: scenarios, suites, CI.
    Init(init::InitArguments),
    /// Run suites and scenarios; the default when no command is named.
    Run(Box<run::RunArguments>),
    /// Run suites, and again whatever a change of their files concerns.
    Watch(Box<watch::WatchArguments>),
    /// Look for errors in suites and scenarios without running anything.
    Check(check::CheckArguments),
    /// Bring scenario files into the one style.
    Fmt(format::FormatArguments),
    /// Turn a scenario file into YAML or back, on standard output.
    Convert(convert::ConvertArguments),
    /// Serve editors: findings, hover, completion, definitions, formatting.
    Lsp(lsp::LspArguments),
    /// Explain the code of an error or warning, or the language of filter expressions.
    Explain(explain::ExplainArguments),
    /// Show the scenarios and blocks of suites with their tags and how much they run.
    List(list::ListArguments),
    /// Show the pedestrian models, controllers, vehicle dynamics and metrics there are.
    Models(models::ModelsArguments),
    /// Run a `search` block: find the plausible cases that are worst.
    Search(experiment::ExperimentArguments),
    /// Run a `tune` block: find the controller parameters that are best on a set of cases.
    Tune(experiment::ExperimentArguments),
    /// Run an `estimate` block: how probable a rare event is, as a bound that holds without assumptions and as an estimate.
    Estimate(experiment::ExperimentArguments),
    /// Write down what there is to be run, in units that many machines share.
    Plan(Box<plan::PlanArguments>),
    /// Make the runs of a share of a plan, and write down what came of each. Nothing is judged.
    Exec(exec::ExecArguments),
    /// Judge the results of a plan that many machines have made, and write the reports of one.
    Merge(Box<merge::MergeArguments>),
    /// Make reports of results that a run wrote with `--json`.
    Report(report::ReportArguments),
    /// Record, show and compare what the runs of a suite came to, as files to commit.
    Baseline(baseline::BaselineArguments),
    /// Is a candidate worse than a base, beyond what is tolerated and beyond doubt?
    Compare(compare::CompareArguments),
    /// Run a `calibrate` block: weigh candidates until they do what people did. Without one, retain the parameter sets of the
    /// COMMOTIONS model that behave as criteria demand.
    Calibrate(Box<calibrate::CalibrateArguments>),
    /// Compare models with published numbers, with full counts.
    Validate(validate::ValidateArguments),
    /// Run exactly one case again and print what happened when.
    Replay(replay::ReplayArguments),
    /// Tell the story of one run, and what would have come of it had something gone otherwise.
    Why(why::WhyArguments),
    /// Make one run with two controllers or two values, and tell where the two part.
    Diff(Box<diff::DiffArguments>),
    /// Draw a scenario from above, before it runs or at moments of its run.
    Sketch(sketch::SketchArguments),
    /// Write a failing run as a small scenario file of its own, moved towards nominal values.
    Shrink(shrink::ShrinkArguments),
    /// Let the programs of controllers that files declare run.
    Allow(allow::AllowArguments),
    /// Find out whether a program keeps to the protocol, or ask it again what it was asked in a run.
    Try(try_program::TryArguments),
    /// Loads a functional mock-up unit, and is asked for decisions.
    #[command(hide = true)]
    FmuHost { plan: PathBuf },
    /// Show the help of a command, or `help filter` for the language of filter expressions.
    Help(help::HelpArguments),
}

/// Parses the arguments of this process, does what they ask and says how it went. Scenarios may name what is in
/// `registry`.
pub fn main(registry: &Registry) -> ExitCode {
    note_places();
    if let Some(ended) = supervise_if_asked() {
        return ended;
    }
    let parsed = Cli::try_parse();
    if let Ok(Cli { command: Some(Command::FmuHost { plan }), .. }) = &parsed {
        return fmu_host(plan);
    }
    let exit = guarded(|| parsed.map_or_else(|error| misunderstood(&error), |cli| obey(cli, registry)));
    all_said(exit).into()
}

#[cfg(feature = "fmu")]
use under_test::fmu_host;

/// There is nothing that could load one.
#[cfg(not(feature = "fmu"))]
fn fmu_host(_plan: &Path) -> ExitCode {
    Exit::Usage.into()
}

/// Shows the help that was asked for, or what is wrong with the arguments.
fn misunderstood(error: &clap::Error) -> Exit {
    let stream = if error.use_stderr() { stderr() } else { stdout() };
    let text = error.render();
    stream.styled(&if stream.takes_colour() { text.ansi().to_string() } else { text.to_string() });
    if error.use_stderr() { Exit::Usage } else { Exit::Success }
}

/// The exit code that was earned, unless something was to be said and could not be written. That nobody read it to its end
/// changes nothing.
fn all_said(exit: Exit) -> Exit {
    let mut exit = exit;
    for (stream, name) in [(stdout(), "standard output"), (stderr(), "standard error")] {
        stream.flush();
        if let Some(trouble) = stream.trouble() {
            writeln!(stderr(), "error: cannot write to {name}: {trouble}");
            exit = Exit::Output;
        }
    }
    exit
}

fn obey(cli: Cli, registry: &Registry) -> Exit {
    match cli.command {
        None => run::run(cli.run, registry, &Cli::command()),
        Some(Command::Init(arguments)) => init::init(&arguments),
        Some(Command::Run(arguments)) => run::run(*arguments, registry, &Cli::command()),
        Some(Command::Watch(arguments)) => watch::watch(&arguments, registry),
        Some(Command::Check(arguments)) => check::check(&arguments, registry),
        Some(Command::Fmt(arguments)) => format::format(&arguments),
        Some(Command::Convert(arguments)) => convert::convert(&arguments),
        Some(Command::Lsp(arguments)) => lsp::lsp(&arguments, registry),
        Some(Command::Explain(arguments)) => explain::explain(&arguments),
        Some(Command::List(arguments)) => list::list(&arguments, registry),
        Some(Command::Models(arguments)) => models::models(&arguments, registry),
        Some(Command::Search(arguments)) => experiment::search(&arguments, registry),
        Some(Command::Tune(arguments)) => experiment::tune(&arguments, registry),
        Some(Command::Estimate(arguments)) => experiment::estimate(&arguments, registry),
        Some(Command::Plan(arguments)) => plan::plan(*arguments, registry),
        Some(Command::Exec(arguments)) => exec::exec(&arguments, registry),
        Some(Command::Merge(arguments)) => merge::merge(*arguments, registry),
        Some(Command::Report(arguments)) => report::report(&arguments, registry),
        Some(Command::Baseline(arguments)) => baseline::baseline(&arguments, registry),
        Some(Command::Compare(arguments)) => compare::compare(&arguments, registry),
        Some(Command::Calibrate(arguments)) => calibrate::run(&arguments, registry),
        Some(Command::Validate(arguments)) => validate::run(&arguments, registry),
        Some(Command::Replay(arguments)) => replay::replay(&arguments, registry),
        Some(Command::Why(arguments)) => why::why(&arguments, registry),
        Some(Command::Diff(arguments)) => diff::diff(&arguments, registry),
        Some(Command::Sketch(arguments)) => sketch::sketch(&arguments, registry),
        Some(Command::Shrink(arguments)) => shrink::shrink(&arguments, registry),
        Some(Command::Allow(arguments)) => allow::allow(&arguments, registry),
        Some(Command::Try(arguments)) => try_program::try_program(&arguments, registry),
        Some(Command::FmuHost { .. }) => Exit::Usage,
        Some(Command::Help(arguments)) => help::help(&arguments, Cli::command()),
    }
}
