//! `scenario-runner search NAME FILE` and `tune NAME FILE`: one block of a suite, with what it builds on.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;

use super::interrupt::stop_on_interrupt;
use super::programs::{ProgramArguments, VerifyArguments};
use super::progress::shows_progress;
use super::run::estimate_tries;
use super::run::output::{self, BlockOutputArguments};
use super::run::targets;
use super::set::SetArguments;
use super::{Exit, load, store};
use files::escape::{shell_path, shell_word};
use report::console::{stderr, stdout};
use report::{Live, Terminal, draw_calibration, render_block, render_controllers, tuned_parameters};
use results::{BlockReport, BlockResult, BlockState, CalibrateResult, Verdict, set_options};
use runner::experiment::{CaseFile, ParameterFile};
use runner::session::{self, Selection, Session, UnitKind, Units};
use scenario::registry::Registry;
use scenario::{Block, Suite};

/// Files that only a calibration writes, and threads, which only its command is told.
#[derive(Debug, Clone, Default)]
pub struct Plots {
    pub svg: Option<PathBuf>,
    pub resampled: Option<PathBuf>,
    pub threads: Option<usize>,
}

#[derive(Debug, Args)]
pub struct ExperimentArguments {
    /// The block's name.
    pub(super) name: String,

    /// The suite or scenario file that declares it.
    pub(super) file: String,

    /// Replaces the seed of the suite.
    #[arg(long, value_name = "SEED")]
    pub(super) seed: Option<u64>,

    #[command(flatten)]
    pub(super) set: SetArguments,

    #[command(flatten)]
    pub(super) programs: ProgramArguments,

    #[command(flatten)]
    pub(super) verify: VerifyArguments,

    /// Write the result for use elsewhere: a search its kept cases, a tune its parameters. Under a name that ends in `.json`
    /// an `evaluate` block takes them as a condition (`with "tuned.json"`), under another they are definitions that a
    /// scenario can `use`, such as `av_controller_braking_distance`. `compare --parameters` takes both.
    #[arg(long, value_name = "PATH")]
    pub(super) save: Option<PathBuf>,

    /// Write everything that was found as JSON.
    #[arg(long, value_name = "PATH")]
    pub(super) json: Option<PathBuf>,

    #[command(flatten)]
    pub(super) output: BlockOutputArguments,

    /// Where a run that is cut off leaves its journal, from which the same command goes on.
    #[arg(long, value_name = "DIR", default_value = store::JOURNAL)]
    pub(super) journal: PathBuf,

    /// Never show how far it is; it never is in CI or where standard error is no terminal.
    #[arg(long)]
    pub(super) no_progress: bool,

    /// Of a calibration: where its plot is written, and populations of persons drawn again.
    #[arg(skip)]
    pub(super) plots: Plots,
}

/// Runs a `search` block.
pub fn search(arguments: &ExperimentArguments, registry: &Registry) -> Exit {
    run(arguments, "search", registry)
}

/// Runs a `tune` block, after what it builds on.
pub fn tune(arguments: &ExperimentArguments, registry: &Registry) -> Exit {
    run(arguments, "tune", registry)
}

/// Runs an `estimate` block.
pub fn estimate(arguments: &ExperimentArguments, registry: &Registry) -> Exit {
    run(arguments, "estimate", registry)
}

/// Runs a `calibrate` block.
pub fn calibrate(arguments: &ExperimentArguments, registry: &Registry) -> Exit {
    run(arguments, "calibrate", registry)
}

fn run(arguments: &ExperimentArguments, kind: &'static str, registry: &Registry) -> Exit {
    let colour = stderr().takes_colour();
    let project = match load::load_all(&[&arguments.file], arguments.seed, &arguments.set, colour, registry) {
        Ok(project) => project,
        Err(exit) => return exit,
    };
    let suites = project.suites();
    let output = arguments.output.of_session();
    let mut written = output.files();
    written.extend(arguments.json.as_deref().map(|path| ("--json", path)));
    if let Err(complaint) = targets::check(&written, &targets::read_by(suites)) {
        writeln!(stderr(), "error: {complaint}");
        writeln!(stderr(), "help: name another file; nothing was run, and nothing was written");
        return Exit::Usage;
    }
    let units = session::units(suites);
    let Some(wanted) = (0..units.len()).find(|unit| is_called(units.kind(*unit), kind, &arguments.name))
    else {
        return unknown(arguments, &units, kind);
    };
    let asked = (0..units.len()).map(|unit| unit == wanted).collect();
    let stop = stop_on_interrupt();
    if let Err(exit) = store::prepare(&arguments.journal) {
        return exit;
    }
    let threads =
        match arguments.programs.threads(arguments.plots.threads, suites.iter().map(|one| &one.suite)) {
            Ok(threads) => threads,
            Err(exit) => return exit,
        };
    let session = Session::new(&project)
        .executor(threads)
        .journals(&arguments.journal)
        .stopped_by(&stop)
        .verify_runs(arguments.verify.runs())
        .courses(output.draw_runs())
        .every_trial(output.need_every_trial(false));
    let mut watcher = Terminal::quiet(shows_progress(arguments.no_progress).then(Live::new));
    let mut complaints = Vec::new();
    let mut results =
        session.run_units(&units, &Selection::marked(asked), &mut watcher).unwrap_or_else(|error| {
            complaints.push(error.to_string());
            error.results()
        });
    estimate_tries::note(&mut results.suites);
    let reports = &results.suites;
    let done = reports.iter().flat_map(|report| &report.blocks);
    let shown: Vec<_> = done.clone().filter_map(BlockReport::result).map(render_block).collect();
    write!(stdout(), "{}", shown.join("\n"));
    stderr().styled(&render_controllers(reports, colour));
    complaints.extend(output::write(&output, &results, false));
    for complaint in &complaints {
        writeln!(stderr(), "error: {complaint}");
    }
    if stop.is_requested() {
        let folder = arguments.journal.display();
        writeln!(stderr(), "interrupted: what was evaluated is kept in {folder}");
        let seed = arguments.seed.map(|seed| format!(" --seed {seed}")).unwrap_or_default();
        let journal = if arguments.journal == Path::new(store::JOURNAL) {
            String::new()
        } else {
            format!(" --journal {}", shell_word(&arguments.journal.to_string_lossy()))
        };
        let options = seed + &set_options(&suites[0].suite.set) + &journal;
        writeln!(
            stderr(),
            "help: `scenario-runner {kind} {} {}{options}` goes on from there",
            arguments.name,
            shell_path(&arguments.file)
        );
        return Exit::Interrupted;
    }
    if let Some(error) = done.clone().find_map(error) {
        writeln!(stderr(), "error: {error}");
        // What a program did is no error of the file.
        return if done.clone().any(has_faults) { Exit::Failed } else { Exit::Scenario };
    }
    let key = units.key(wanted);
    let Some((block, result)) = done.filter(|one| one.key == key).find_map(|one| {
        let result = one.result()?;
        Some((&one.block, result))
    }) else {
        // What it needs failed, and said so above.
        return Exit::Failed;
    };
    let file = arguments
        .save
        .as_deref()
        .map(|path| (path, file(path, &suites[units.suite(wanted)].suite, block, result)));
    if let Some((path, None)) = &file {
        writeln!(stderr(), "warning: nothing was chosen, so {} is not written", path.display());
    }
    let written = file.and_then(|(path, content)| Some((path, content?)));
    let all = arguments.json.as_deref().map(|path| (path, json(result)));
    let plots = match result {
        BlockResult::Calibrate(calibrated) => calibration_files(&arguments.plots, calibrated),
        _ => Vec::new(),
    };
    let saved = written
        .into_iter()
        .chain(all)
        .try_for_each(|(path, content)| save(path, &content))
        .and_then(|()| plots.iter().try_for_each(|(path, content)| save(path, content)));
    if let Err((path, error)) = saved {
        writeln!(stderr(), "error: cannot write {}: {error}", path.display());
        return Exit::Output;
    }
    if !complaints.is_empty() {
        return Exit::Output;
    }
    if let Some(why) = result.failure() {
        let failed = result.verdict() == Some(Verdict::Failed);
        writeln!(stderr(), "{}: {why}", if failed { "failed" } else { "inconclusive" });
    }
    match result.verdict() {
        None | Some(Verdict::Passed) => Exit::Success,
        Some(Verdict::Inconclusive) => Exit::Inconclusive,
        Some(Verdict::Failed) => Exit::Failed,
    }
}

fn is_called(unit: UnitKind, kind: &str, name: &str) -> bool {
    matches!(unit, UnitKind::Block(block) if block.kind() == kind && block.name() == name)
}

fn unknown(arguments: &ExperimentArguments, units: &Units, kind: &str) -> Exit {
    writeln!(stderr(), "error: {} has no {kind} called `{}`", arguments.file, arguments.name);
    let known: Vec<_> = units
        .others()
        .filter_map(|unit| match units.kind(unit) {
            UnitKind::Block(block) if block.kind() == kind => Some(format!("`{}`", block.name())),
            _ => None,
        })
        .collect();
    if known.is_empty() {
        writeln!(stderr(), "help: it declares none");
    } else {
        writeln!(stderr(), "help: it declares {}", known.join(", "));
    }
    Exit::Usage
}

fn error(report: &BlockReport) -> Option<String> {
    match &report.state {
        BlockState::Errored(error) => {
            Some(format!("{} {}: {error}", report.block.kind(), report.block.name()))
        }
        BlockState::Finished(_) | BlockState::NotFinished(_) | BlockState::Skipped(_) => None,
    }
}

fn has_faults(report: &BlockReport) -> bool {
    matches!(&report.state, BlockState::Errored(error) if !error.faults.is_empty())
}

/// The result as others use it; `None` if a tune chose nothing.
fn file(path: &Path, suite: &Suite, block: &Block, result: &BlockResult) -> Option<String> {
    let is_json = path.extension().is_some_and(|extension| extension == "json");
    match (block, result) {
        (Block::Tune(tune), BlockResult::Tune(tuned)) => {
            let chosen = ParameterFile::of(suite, tune, tuned)?;
            Some(if is_json { chosen.write() } else { tuned_parameters(tuned, tune) })
        }
        (_, BlockResult::Search(search)) => Some(CaseFile::write(&search.kept)),
        (_, BlockResult::Calibrate(calibrated)) => calibrated.population().to_json().ok(),
        _ => Some(json(result)),
    }
}

/// The plot of a calibration, and its populations for persons drawn again, where they are wanted.
fn calibration_files(plots: &Plots, calibrated: &CalibrateResult) -> Vec<(PathBuf, String)> {
    let plot = plots.svg.iter().map(|path| (path.clone(), draw_calibration(calibrated)));
    let again = plots.resampled.iter().flat_map(|folder| {
        (0..calibrated.resampled.len()).filter_map(move |number| {
            let population = calibrated.resampled_population(number)?.to_json().ok()?;
            Some((folder.join(format!("{}_{:02}.json", calibrated.name, number + 1)), population))
        })
    });
    plot.chain(again).collect()
}

/// Everything that was found, without the kind's name around it.
fn json(result: &BlockResult) -> String {
    let text = match result {
        BlockResult::Search(search) => serde_json::to_string_pretty(search),
        BlockResult::Tune(tune) => serde_json::to_string_pretty(tune),
        BlockResult::Evaluate(evaluate) => serde_json::to_string_pretty(evaluate),
        BlockResult::Calibrate(calibrate) => serde_json::to_string_pretty(calibrate),
        BlockResult::Estimate(estimate) => serde_json::to_string_pretty(estimate),
        BlockResult::Statement(statement) => serde_json::to_string_pretty(statement),
    };
    text.expect("plain data serialises") + "\n"
}

fn save(path: &Path, content: &str) -> Result<(), (PathBuf, io::Error)> {
    files::write(path, content).map_err(|error| (path.to_owned(), error))
}
