//! `scenario-runner search NAME FILE` and `tune NAME FILE`: one block of a suite, with what it builds on.

use std::fs;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::{Exit, load};
use crate::experiment::{
    Block, BlockResult, CaseFile, ExperimentError, Laboratory, Need, Progress, Results, SearchResult,
    run_search, run_tune,
};
use crate::report::{render_search, render_tune, tuned_parameters};
use crate::scenario::{Search, Suite};

#[derive(Debug, Args)]
pub struct ExperimentArguments {
    /// The block's name.
    name: String,

    /// The suite or scenario file that declares it.
    file: String,

    /// Replaces the seed of the suite.
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,

    /// Write the result for use elsewhere: a search its kept cases, a tune its parameters as definitions to `use`.
    #[arg(long, value_name = "PATH")]
    save: Option<PathBuf>,

    /// Write everything that was found as JSON.
    #[arg(long, value_name = "PATH")]
    json: Option<PathBuf>,

    /// Where a run that is cut off leaves its journal, from which the same command goes on.
    #[arg(long, value_name = "DIR", default_value = ".scenario-runner/journal")]
    journal: PathBuf,

    /// Never draw a progress bar.
    #[arg(long)]
    no_progress: bool,
}

/// Runs a `search` block.
pub fn search(arguments: &ExperimentArguments) -> Exit {
    run(arguments, |suite, laboratory| {
        let block = named(&suite.searches, &arguments.name, "search", |search| &search.name)?;
        let result = searched(arguments, laboratory, block)?;
        print!("{}", render_search(&result));
        save(arguments.save.as_deref(), || CaseFile::write(&result.kept))?;
        save(arguments.json.as_deref(), || json(&result))
    })
}

/// Runs a `tune` block, after the search that it builds on.
pub fn tune(arguments: &ExperimentArguments) -> Exit {
    run(arguments, |suite, laboratory| {
        let block = named(&suite.tunes, &arguments.name, "tune", |tune| &tune.name)?;
        let mut results = Results::default();
        for need in Block::Tune(block).needs() {
            let Need::Block(name) = need else { continue };
            let search = named(&suite.searches, &name, "search", |search| &search.name)?;
            let result = searched(arguments, laboratory, search)?;
            print!("{}", render_search(&result));
            println!();
            results.blocks.insert(name, BlockResult::Search(result));
        }
        let bar = Bar::new(&format!("tune {}", block.name), !arguments.no_progress);
        let result = run_tune(laboratory, block, &results, &bar);
        bar.finish();
        let result = result?;
        print!("{}", render_tune(&result));
        save(arguments.save.as_deref(), || tuned_parameters(&result, block))?;
        save(arguments.json.as_deref(), || json(&result))?;
        if result.chosen.is_none() && result.pareto.is_empty() {
            Err(Failure::NothingFeasible)
        } else {
            Ok(())
        }
    })
}

/// Why a command does not succeed.
enum Failure {
    Unknown {
        kind: &'static str,
        name: String,
        known: Vec<String>,
    },
    Experiment(ExperimentError),
    Write {
        path: PathBuf,
        error: io::Error,
    },
    /// Said by the report already.
    NothingFeasible,
}

impl From<ExperimentError> for Failure {
    fn from(error: ExperimentError) -> Self {
        Self::Experiment(error)
    }
}

fn run(
    arguments: &ExperimentArguments,
    work: impl FnOnce(&Suite, &Laboratory) -> Result<(), Failure>,
) -> Exit {
    let colour = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    let Ok(mut suite) = load::read(&arguments.file, colour) else { return Exit::Scenario };
    suite.seed = arguments.seed.unwrap_or(suite.seed);
    let laboratory = Laboratory::new(&suite, Some(arguments.journal.clone()));
    match work(&suite, &laboratory) {
        Ok(()) => Exit::Success,
        Err(Failure::NothingFeasible) => Exit::Failed,
        Err(Failure::Unknown { kind, name, known }) => {
            eprintln!("error: {} has no {kind} called `{name}`", arguments.file);
            if known.is_empty() {
                eprintln!("help: it declares none");
            } else {
                eprintln!("help: it declares {}", known.join(", "));
            }
            Exit::Usage
        }
        Err(Failure::Experiment(error)) => {
            eprintln!("error: {error}");
            if let ExperimentError::EmptySet(name) = &error {
                eprintln!("help: `{name}` kept no case; loosen its `keep`, or search longer");
            }
            Exit::Scenario
        }
        Err(Failure::Write { path, error }) => {
            eprintln!("error: cannot write {}: {error}", path.display());
            Exit::Output
        }
    }
}

fn named<'a, T>(
    blocks: &'a [T],
    name: &str,
    kind: &'static str,
    name_of: impl Fn(&T) -> &String,
) -> Result<&'a T, Failure> {
    blocks.iter().find(|block| name_of(block) == name).ok_or_else(|| Failure::Unknown {
        kind,
        name: name.to_string(),
        known: blocks.iter().map(|block| format!("`{}`", name_of(block))).collect(),
    })
}

fn searched(
    arguments: &ExperimentArguments,
    laboratory: &Laboratory,
    search: &Search,
) -> Result<SearchResult, Failure> {
    let bar = Bar::new(&format!("search {}", search.name), !arguments.no_progress);
    let result = run_search(laboratory, search, &bar);
    bar.finish();
    Ok(result?)
}

fn json(result: &impl serde::Serialize) -> String {
    serde_json::to_string_pretty(result).expect("plain data serialises") + "\n"
}

fn save(path: Option<&Path>, content: impl FnOnce() -> String) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    let folder = path.parent().map_or(Ok(()), fs::create_dir_all);
    folder
        .and_then(|()| fs::write(path, content()))
        .map_err(|error| Failure::Write { path: path.to_owned(), error })
}

/// Evaluations done, the best so far and the time that is left, on the terminal.
struct Bar {
    bar: ProgressBar,
    best: Mutex<Option<f64>>,
}

const STYLE: &str = "{prefix} {human_pos} of {human_len} [{wide_bar}] {msg} {eta} left";

impl Bar {
    fn new(name: &str, wanted: bool) -> Self {
        let drawn = wanted && io::stderr().is_terminal();
        let target = if drawn { ProgressDrawTarget::stderr_with_hz(5) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(None, target).with_prefix(name.to_string());
        let style = ProgressStyle::with_template(STYLE).expect("the template is valid");
        Self { bar: bar.with_style(style.progress_chars("=> ")), best: Mutex::new(None) }
    }

    fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn evaluated(&self, done: usize, all: usize, value: Option<f64>) {
        self.bar.set_length(all as u64);
        self.bar.set_position(done as u64);
        if let (Some(value), Ok(mut best)) = (value, self.best.lock())
            && best.is_none_or(|known| value < known)
        {
            *best = Some(value);
            self.bar.set_message(format!("lowest {value:.3},"));
        }
    }
}
