//! A file as a baseline: read if it is one, run if it is a suite.

use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::one_case::could_not_run;
use super::programs::{ProgramArguments, VerifyArguments};
use super::set::SetArguments;
use super::{Exit, load};
use files::escape::terminal_line;
use report::console::stderr;
use results::judge::baseline::Baseline;
use results::{Requests, TestedController, record_command};
use runner::baseline::{program_titles, record};
use runner::plan::{self, Plan};
use runner::project::plan_notices;
use runner::run::{BatchError, FirstRuns, MeasuredMetrics, RunBatch, Stop};
use runner::session::{nondeterministic, second_runs, tested_controllers};
use scenario::registry::Registry;
use scenario::{Gate, Suite};

/// Whether a file holds a baseline and not a suite.
pub fn is_baseline(file: &str) -> bool {
    !load::names_a_file(file)
}

/// A suite that is to be run for its numbers; what is wrong with it goes to stderr.
pub fn load_suite(
    file: &str,
    seed: Option<u64>,
    set: &SetArguments,
    registry: &Registry,
) -> Result<Suite, Exit> {
    let colour = stderr().takes_colour();
    let project = load::load_all(&[&file.to_string()], seed, set, colour, registry)?;
    Ok(project.suites()[0].suite.clone())
}

/// Adds the metrics that a gate's rules name.
pub fn include_gate(requests: &mut Requests, gate: &Gate) {
    gate.rules.iter().filter_map(|rule| rule.metric.as_ref()).for_each(|metric| requests.add(metric));
}

/// Runs every case of a suite; `title` stands before the progress bar.
///
/// # Errors
/// [`Exit::Interrupted`], of which nothing is said yet; of everything else stderr has been told.
pub fn run_suite(
    suite: &Suite,
    requests: &Requests,
    title: &str,
    stop: &Stop,
    programs: &ProgramArguments,
    verify: VerifyArguments,
) -> Result<Baseline, Exit> {
    let threads = programs.threads(None, [suite])?;
    let plan = plan::plan(suite).map_err(|errors| {
        load::show(plan_notices(errors), false);
        Exit::Scenario
    })?;
    let measured = MeasuredMetrics::new(requests.clone());
    let batch = RunBatch { executor: &threads, measured: &measured, stop };
    let first_runs = FirstRuns::new(verify.runs());
    let baseline = run_plan(&plan, batch, title, &first_runs)?;
    let mut controllers = tested_controllers(suite);
    second_runs(batch, &first_runs, &mut controllers);
    if stop.is_requested() {
        return Err(Exit::Interrupted);
    }
    let warnings = controllers.iter().filter_map(TestedController::nondeterminism);
    warnings.for_each(|warning| writeln!(stderr(), "warning: {}", terminal_line(&warning)));
    let (programs, nondeterministic) =
        (program_titles(&threads, suite), nondeterministic(suite, &controllers));
    Ok(Baseline { programs, nondeterministic, ..baseline })
}

fn run_plan(plan: &Plan, batch: RunBatch, title: &str, first_runs: &FirstRuns) -> Result<Baseline, Exit> {
    let runs = plan.scenarios().iter().map(|one| one.len() * one.runs()).sum::<usize>();
    let bar = bar(title, runs as u64);
    let mut trials = Vec::with_capacity(plan.len());
    let made = plan.trials().try_for_each(|trial| {
        let number = first_runs.number(&trial.scenario, trial.cases.len());
        let outcomes = batch.outcomes_keeping(first_runs, number, trial.cases.iter(), || bar.inc(1))?;
        trials.push((trial, outcomes));
        Ok(())
    });
    bar.finish_and_clear();
    made.map_err(|error| match error {
        BatchError::Stopped => Exit::Interrupted,
        error => could_not_run(&error),
    })?;
    let trials: Vec<_> = trials.iter().map(|(trial, outcomes)| (trial, &outcomes[..])).collect();
    Ok(record(plan, &trials, &batch.measured.requests))
}

fn bar(title: &str, runs: u64) -> ProgressBar {
    const STYLE: &str = "{prefix} {human_pos} of {human_len} runs [{wide_bar}] {per_sec}, {eta} left";
    let target = if stderr().is_terminal() {
        ProgressDrawTarget::stderr_with_hz(5)
    } else {
        ProgressDrawTarget::hidden()
    };
    let style = ProgressStyle::with_template(STYLE).expect("the template is valid").progress_chars("=> ");
    ProgressBar::with_draw_target(Some(runs), target).with_prefix(title.to_string()).with_style(style)
}

/// Says on stderr if a baseline is from before there were checksums.
pub fn warn_of_unchecked(path: &Path) {
    if Baseline::is_unchecked(path) {
        writeln!(
            stderr(),
            "note: {} is from version 0.1 and has no checksums; `baseline save` renews it",
            path.display()
        );
    }
}

/// Reads a baseline, or says on stderr why it cannot be read.
pub fn read_baseline(path: &Path, registry: &Registry) -> Result<Baseline, Exit> {
    warn_of_unchecked(path);
    let read = Baseline::read(path).map(|baseline| baseline.resolved(registry));
    read.map_err(|error| {
        writeln!(stderr(), "error: {error}");
        writeln!(stderr(), "help: {}", error.hint(&record_command("SUITE", &[], path)));
        Exit::Baseline
    })
}

/// Writes a file, making the folders it is to be in.
pub fn save(path: &Path, text: &str) -> Result<(), Exit> {
    files::write(path, text).map_err(|error| {
        writeln!(stderr(), "error: cannot write {}: {error}", path.display());
        Exit::Output
    })
}

/// Where a suite's baseline lies: in every file that its gates name, or without gates in `baselines/` beside the suite, or
/// beside its folder if that is called `suites`.
pub fn default_paths(file: &str, suite: &Suite) -> Vec<PathBuf> {
    let mut named: Vec<&str> = suite.gates.iter().map(|gate| gate.baseline.as_str()).collect();
    named.sort_unstable();
    named.dedup();
    if !named.is_empty() {
        return named.into_iter().map(PathBuf::from).collect();
    }
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let folder = if folder.ends_with("suites") { folder.parent().unwrap_or(folder) } else { folder };
    vec![folder.join("baselines").join(format!("{}.json", suite.name))]
}
