//! `scenario-runner shrink KEY`: a failing run as a small scenario file of its own.

use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::Exit;
use super::interrupt::stop_on_interrupt;
use super::one_case::{CaseArguments, FoundCase, could_not_run};
use super::progress::shows_progress;
use super::shrunk::{SHRUNK_BY, render_shrunk, shrunk_file};
use files::escape::shell_path;
use files::{self, Disk, Lines, Overlay};
use report::console::{stderr, stdout};
use report::run_words;
use results::judge::{PerRun, per_run};
use results::{Outcome, Requests, SuiteIdentity};
use runner::plan;
use runner::run::{BatchError, MeasuredMetrics, RunBatch, Stop, Threads, Wanted};
use runner::shrink::{KnobPlace, Shrunk, shrink as shrink_case, unmoved};
use scenario::Case;
use scenario::registry::Registry;

/// A failing run as a small scenario file of its own
///
/// Moves a failing run towards what its scenario declares, as far as it still fails: values of variations towards the
/// middle of what they are drawn from, the parameters of people towards the defaults of their model, one at a time; and
/// leaves out road users that the failure does not need. The seed stays. What remains far from nominal is what the
/// failure is about.
///
/// The result is a scenario file that stands alone and fails the same criterion when it is run. Comments in it tell
/// where it comes from and what was moved how far.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  scenario-runner shrink zebra/late/tta=6s/individual=17/rep=2       of suites/zebra.suite
  scenario-runner shrink walk/walk/rep=3 walk.scn -o near_miss.scn   into that file
  scenario-runner shrink KEY --criterion pet                         with respect to the criterion about `pet`
  scenario-runner shrink KEY --as-is                                 without moving anything

Exit codes: 0 written, 4 no such run or it fails nothing, 105 interrupted (what was reached is written)")]
pub struct ShrinkArguments {
    #[command(flatten)]
    case: CaseArguments,

    /// The criterion that it is to fail, or a part of its words [default: the first that the run speaks against].
    #[arg(long, value_name = "WORDS")]
    criterion: Option<String>,

    /// Where to write the scenario [default: its name with `_shrunk.scn`, in the current folder].
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,

    /// Replace the file if it exists and an earlier `shrink` wrote it.
    #[arg(long)]
    force: bool,

    /// Write the run as it is, without moving anything.
    #[arg(long)]
    as_is: bool,

    /// Never show how far it is; it never is in CI or where standard error is no terminal.
    #[arg(long)]
    no_progress: bool,
}

pub fn shrink(arguments: &ShrinkArguments, registry: &Registry) -> Exit {
    let result = arguments.case.load("shrink", registry).and_then(|project| {
        let found = arguments.case.find(project.suites())?;
        // Each run decides which is next.
        let threads = arguments.case.run.programs.threads(Some(1), [&found.suite.suite])?;
        let criterion = choose(arguments, &found, registry, &threads)?;
        shrink_found(arguments, &found, &criterion, registry, &threads)
    });
    result.unwrap_or_else(|exit| exit)
}

/// The criterion that was asked for, if the run speaks against it; else the first such, those that one run decides before
/// those about many.
fn choose(
    arguments: &ShrinkArguments,
    found: &FoundCase,
    registry: &Registry,
    threads: &Threads,
) -> Result<PerRun, Exit> {
    let key = &arguments.case.run.key;
    let mut criteria: Vec<PerRun> = found.criteria.iter().filter_map(per_run).collect();
    if let Some(words) = &arguments.criterion {
        criteria.retain(|one| one.criterion.text.contains(words));
        if criteria.is_empty() {
            writeln!(stderr(), "error: no criterion of `{key}` has `{words}` in its words");
            let all: Vec<_> = found.criteria.iter().map(|one| format!("`{}`", one.text)).collect();
            writeln!(stderr(), "help: there are {}", all.join(", "));
            return Err(Exit::Usage);
        }
    }
    let mut requests = Requests::defaults(registry);
    requests.include(&found.criteria);
    let outcome = run(&found.case, &requests, threads)?;
    let holds = |one: &PerRun| one.standing(&outcome, &requests).holds;
    let (held, mut failed): (Vec<_>, Vec<_>) = criteria.into_iter().partition(holds);
    failed.sort_by_key(|one| !one.decisive);
    if failed.is_empty() {
        writeln!(stderr(), "error: `{key}` fails nothing, so there is nothing to shrink");
        for one in &held {
            let text = &one.criterion.text;
            writeln!(stderr(), "  `{text}` holds: {}", run_words(one, &outcome, &requests));
        }
        writeln!(stderr(), "help: reports name the runs that speak against a criterion");
        return Err(Exit::NothingSelected);
    }
    let chosen = failed.remove(0);
    if !failed.is_empty() {
        let others: Vec<_> = failed.iter().map(|one| format!("`{}`", one.criterion.text)).collect();
        writeln!(stderr(), "note: it also speaks against {}; `--criterion` chooses", others.join(", "));
    }
    Ok(chosen)
}

fn shrink_found(
    arguments: &ShrinkArguments,
    found: &FoundCase,
    criterion: &PerRun,
    registry: &Registry,
    threads: &Threads,
) -> Result<Exit, Exit> {
    let FoundCase { suite, case, .. } = found;
    let declared = suite.suite.scenarios.iter().find(|scenario| scenario.name == case.scenario);
    let scenario = declared.expect("a case belongs to a scenario of its suite").clone();
    let path = match &arguments.output {
        Some(path) => path.clone(),
        None => PathBuf::from(format!("{}_shrunk.scn", scenario.name)),
    };
    may_be_written(&path, arguments.force)?;
    let place = KnobPlace {
        scenario,
        variation: case.variation.iter().cloned().chain(case.drawn_values()).collect(),
        individuals: case.individuals.clone(),
        key: case.key.clone(),
        seed: case.seed,
    };
    let shrunk = if arguments.as_is {
        unmoved(place, criterion, registry, threads)
    } else {
        let stop = stop_on_interrupt();
        let bar = progress_bar(shows_progress(arguments.no_progress));
        let told = |runs: usize, what: &str| bar.set_message(format!("{runs} runs, moving {what}"));
        let shrunk = shrink_case(place, criterion, registry, threads, &stop, &mut { told });
        bar.finish_and_clear();
        shrunk
    };
    let shrunk = shrunk.map_err(|error| {
        writeln!(stderr(), "error: {}: {error}", case.key);
        Exit::Scenario
    })?;
    let identity = SuiteIdentity {
        suite: suite.plan.suite.clone(),
        file: suite.file.clone(),
        seed: suite.plan.seed,
        set: suite.suite.set.clone(),
        tested: suite.suite.tested.clone(),
        earlier_seeds: Vec::new(),
        texts: Vec::new(),
    };
    let folder = path.parent().filter(|one| !one.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let text = shrunk_file(&shrunk, criterion, &identity, folder).map_err(|error| {
        writeln!(stderr(), "error: {}: {error}", case.key);
        Exit::Scenario
    })?;
    verify(&text, &shrunk, &path, registry, threads)?;
    // It may have come there while the case was shrinking.
    may_be_written(&path, arguments.force)?;
    let written = if path.exists() { files::write(&path, &text) } else { files::create_new(&path, &text) };
    written.map_err(|error| {
        writeln!(stderr(), "error: cannot write {}: {error}", path.display());
        Exit::Output
    })?;
    write!(stdout(), "{}", render_shrunk(&shrunk, criterion));
    if !arguments.as_is && shrunk.moves.is_empty() {
        writeln!(stdout(), "Nothing to move: whatever may vary is nominal already.");
    }
    let again = shell_path(&path.to_string_lossy());
    writeln!(stdout(), "wrote {}; run it: scenario-runner {again}", path.display());
    Ok(if shrunk.stopped { Exit::Interrupted } else { Exit::Success })
}

/// Whether the result may go there: into a new file, a pipe or a device, or with `force` into what shrinking wrote before.
/// If not, says so on stderr.
fn may_be_written(path: &Path, force: bool) -> Result<(), Exit> {
    let is_device = path.exists() && !path.is_file();
    if !is_device && path.extension().is_none_or(|ending| ending != "scn") {
        writeln!(stderr(), "error: {} does not end in `.scn`, as scenario files do", path.display());
        return Err(Exit::Usage);
    }
    if !path.is_file() && (!path.is_symlink() || path.exists()) {
        return Ok(());
    }
    if !is_own(path) {
        writeln!(stderr(), "error: {} exists already, and `shrink` did not write it", path.display());
        writeln!(stderr(), "help: `--output PATH` writes elsewhere");
        return Err(Exit::Output);
    }
    if !force {
        writeln!(stderr(), "error: {} exists already", path.display());
        writeln!(stderr(), "help: `--force` replaces it, `--output PATH` writes elsewhere");
        return Err(Exit::Output);
    }
    Ok(())
}

/// Whether the first lines of a file say that it is a result of shrinking.
fn is_own(path: &Path) -> bool {
    const LONGEST_LINE: u64 = 1 << 16;
    let Ok(mut lines) = Lines::open(path, LONGEST_LINE) else { return false };
    let mut next = || lines.next_line().ok().flatten().map(|line| String::from_utf8_lossy(line).into_owned());
    let (first, second) = (next().unwrap_or_default(), next().unwrap_or_default());
    first.starts_with("# The run `") && second.starts_with(&format!("# {SHRUNK_BY}"))
}

fn progress_bar(shown: bool) -> ProgressBar {
    let target = if shown { ProgressDrawTarget::stderr_with_hz(10) } else { ProgressDrawTarget::hidden() };
    let style =
        ProgressStyle::with_template("   Shrinking [{elapsed}] {msg}").expect("the template is valid");
    ProgressBar::with_draw_target(None, target).with_style(style)
}

fn run(case: &Case, requests: &Requests, threads: &Threads) -> Result<Outcome, Exit> {
    outcome(case, requests, threads).map_err(|error| could_not_run(&error))
}

fn outcome(case: &Case, requests: &Requests, threads: &Threads) -> Result<Outcome, BatchError> {
    let (measured, stop) = (MeasuredMetrics::new(requests.clone()), Stop::default());
    let batch = RunBatch { executor: threads, measured: &measured, stop: &stop };
    batch.one(case, Wanted::Outcome).map(|ran| ran.outcome)
}

/// Reads the file again and runs it: it has to be the same run.
fn verify(
    text: &str,
    shrunk: &Shrunk,
    path: &Path,
    registry: &Registry,
    threads: &Threads,
) -> Result<(), Exit> {
    let again = || -> Result<Outcome, String> {
        // A device has no ending that says what is in it.
        let named = if path.exists() && !path.is_file() { Path::new("shrunk.scn") } else { path };
        let loaded = lang::load(named, registry, &Overlay::new(&Disk, named, text))
            .map_err(|failure| failure.render(lang::Style::default()))?;
        let scenario = loaded.suite.scenarios.first().ok_or("it has no scenario")?;
        let planned = plan::plan_scenario(&loaded.suite, scenario).map_err(|error| error.to_string())?;
        let case = planned.trials().next().map(|trial| trial.cases.first()).ok_or("it has no run")?;
        outcome(&case, &shrunk.requests, threads).map_err(|error| match error {
            BatchError::Run { error, .. } => error.to_string(),
            error => error.to_string(),
        })
    };
    let why = match again() {
        Ok(outcome)
            if outcome.fingerprint == shrunk.outcome.fingerprint
                && outcome.metrics == shrunk.outcome.metrics =>
        {
            return Ok(());
        }
        Ok(_) => "its run is another one".to_string(),
        Err(why) => why,
    };
    writeln!(stderr(), "error: the file that was to be written does not say the same: {why}");
    writeln!(stderr(), "help: please report this, with this command and its files");
    Err(Exit::Failed)
}
