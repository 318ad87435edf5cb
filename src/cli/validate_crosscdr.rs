//! `scenario-runner validate crosscdr`: people who chose a gap in two streams of cars, beside populations and models.

use std::path::PathBuf;

use clap::{ArgGroup, Args};

use super::interrupt::stop_on_interrupt;
use super::progress::{bar, shows_progress};
use super::run::targets;
use super::{Exit, number};
use files::{Disk, Files};
use report::console::{stderr, stdout};
use report::{draw_gap_choices, render_gap_choices};
use results::GapChoices;
use runner::gap_choice::{GapChoiceError, GapStudy, PopulationOrModel, read_people_at_gaps};
use runner::run::{BatchError, Threads};
use scenario::registry::Registry;

/// The street, which users can run by hand, too.
const STREET: &str = include_str!("../../scenarios/people/crosscdr.scn");

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("subjects").args(["population", "model"]).required(true).multiple(true)))]
#[command(after_help = "\
Examples:
  scenario-runner validate crosscdr crosscdr_fit.json --population humans --looking \"0 s\" --looking \"1 s\"
  scenario-runner validate crosscdr crosscdr_fit.json --population people.json --model carla_walker --svg gaps.svg

The street is the file scenarios/people/crosscdr.scn of the repository, which the program carries.")]
pub struct CrosscdrArguments {
    /// What people did, `crosscdr_fit.json`.
    facts: PathBuf,
    /// A population of the COMMOTIONS model: a name that ships, or a file. May be repeated.
    #[arg(long, value_name = "POPULATION")]
    population: Vec<String>,
    /// A pedestrian model with its defaults, as one person. May be repeated.
    #[arg(long, value_name = "MODEL")]
    model: Vec<String>,
    /// For how long they only look at first; they may go when the first car has passed, 2.3 s later. Several times are several columns.
    #[arg(long, value_name = "TIME", default_value = "0 s", allow_hyphen_values = true)]
    looking: Vec<String>,
    /// How many of each population, drawn by the seed; more than there are means all. Of a model, how many runs in every condition.
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = number::some())]
    members: usize,
    /// Runs of each member of a population in every condition.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    repetitions: u32,
    /// Decides which persons are drawn, and the noise of every run.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Draw the shares against the gap.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Number of threads, at most 1024 [default: one per core]. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = number::threads())]
    threads: Option<usize>,
    /// Never show how far it is; it never is in CI or where standard error is no terminal.
    #[arg(long)]
    no_progress: bool,
}

/// Errors of a comparison.
#[derive(Debug, thiserror::Error)]
enum CrosscdrError {
    #[error("cannot read {}: {error}", file.display())]
    Read { file: PathBuf, error: files::ReadError },
    #[error(transparent)]
    Facts(#[from] runner::gap_choice::FactsError),
    #[error(transparent)]
    Choice(#[from] GapChoiceError),
    #[error("{0}; nothing was run")]
    Target(String),
    #[error("cannot write {}: {error}", file.display())]
    Write { file: PathBuf, error: std::io::Error },
}

pub fn run(arguments: &CrosscdrArguments, registry: &Registry) -> Exit {
    match compare(arguments, registry) {
        Ok(()) => Exit::Success,
        Err(error) => {
            writeln!(stderr(), "error: {error}");
            match error {
                CrosscdrError::Write { .. } => Exit::Output,
                CrosscdrError::Choice(GapChoiceError::Batch(BatchError::Stopped)) => Exit::Interrupted,
                _ => Exit::Usage,
            }
        }
    }
}

fn compare(arguments: &CrosscdrArguments, registry: &Registry) -> Result<(), CrosscdrError> {
    let file = &arguments.facts;
    let text =
        Disk.read_text(file, &["json"]).map_err(|error| CrosscdrError::Read { file: file.clone(), error })?;
    let people = read_people_at_gaps(&file.display().to_string(), &text)?;
    let populations = arguments.population.iter().cloned().map(PopulationOrModel::Population);
    let subjects = populations.chain(arguments.model.iter().cloned().map(PopulationOrModel::Model));
    let facts = file.to_string_lossy();
    let read: Vec<&str> = arguments.population.iter().map(String::as_str).chain([&*facts]).collect();
    let written: Vec<_> = arguments.svg.iter().map(|path| ("--svg", path.as_path())).collect();
    targets::check(&written, &read).map_err(CrosscdrError::Target)?;
    let stop = stop_on_interrupt();
    let study = GapStudy {
        people: &people,
        street: STREET,
        registry,
        files: &Disk,
        executor: &arguments.threads.map_or_else(Threads::all, Threads::new),
        stop: &stop,
        members: arguments.members,
        repetitions: arguments.repetitions,
        seed: arguments.seed,
    };
    let mut planned = Vec::new();
    for subject in subjects {
        for look in &arguments.looking {
            planned.push(study.plan(&subject, look)?);
        }
    }
    let columns = planned.len();
    let mut choosers = Vec::new();
    for chooser in planned {
        let number = choosers.len() + 1;
        let template =
            format!("{number} of {columns}: {{human_pos}} of {{human_len}} runs [{{wide_bar}}] {{eta}} left");
        let bar = bar(shows_progress(arguments.no_progress), &template, 0);
        choosers.push(study.run(chooser, |done, all| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        })?);
        bar.finish_and_clear();
    }
    let choices = GapChoices { people, choosers };
    write!(stdout(), "{}", render_gap_choices(&choices));
    if let Some(file) = &arguments.svg {
        files::write(file, draw_gap_choices(&choices))
            .map_err(|error| CrosscdrError::Write { file: file.clone(), error })?;
    }
    Ok(())
}
