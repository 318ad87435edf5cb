//! `scenario-runner validate`: the models against what is published, with full counts.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::validate_crosscdr::{self, CrosscdrArguments};
use super::validate_population::{self, SomeMembers};
use super::{Exit, number};
use models::calibrate::{
    Calibration, PUBLISHED_SHARE, Request, calibrate, published_candidates, published_criteria,
};
use models::pedestrian::commotions::Variant;
use models::pedestrian::commotions::held_back::{HeldBackScenario, HikerPersons, held_back};
use models::pedestrian::commotions::hiker::{AS_PUBLISHED, HikerComparison, HikerReference, LOOKING};
use models::pedestrian::commotions::meeting::Waiting;
use report::console::{stderr, stdout};
use scenario::population::HUMANS;
use scenario::registry::Registry;

#[derive(Debug, Args)]
pub struct ValidateArguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// The COMMOTIONS pedestrian in the 24 scenarios of the HIKER crossing experiment.
    Hiker {
        /// The reference numbers, `hiker_reference.json`.
        reference: PathBuf,
        /// Runs of each individual in each scenario.
        #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=10_000))]
        repetitions: u32,
        /// Decides the noise of every run.
        #[arg(long, default_value_t = 20_261_121)]
        seed: u64,
        /// Puts this population beside the people of the experiment instead: a name that ships, or a file.
        #[arg(long, value_name = "POPULATION", requires = "persons")]
        population: Option<String>,
        /// What each person did, `hiker_persons.json`.
        #[arg(long, value_name = "FILE", requires = "population")]
        persons: Option<PathBuf>,
        /// How many of the population, evenly spaced in it.
        #[arg(long, value_name = "N", default_value_t = 1000, value_parser = number::some())]
        members: usize,
        /// They stand and look until the first car has passed, instead of entering being worth nothing until then, as published.
        #[arg(long, requires = "population")]
        looking: bool,
    },
    /// A population in the ten conditions of the encounter that people were observed in, under noise of your choice.
    Encounter {
        /// What people did, `human_crossing.csv`.
        observations: PathBuf,
        /// A name that ships, or a file.
        #[arg(long, value_name = "POPULATION", default_value = HUMANS)]
        population: String,
        /// How many of the population, evenly spaced in it.
        #[arg(long, value_name = "N", default_value_t = 1000, value_parser = number::some())]
        members: usize,
        /// Runs of each in every condition.
        #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(2..=10_000))]
        repetitions: u32,
        /// Decides the noise of every run; several seeds are several columns.
        #[arg(long, value_name = "SEED", default_values_t = [1, 2, 3])]
        seed: Vec<u64>,
    },
    /// What one population for both laboratories costs: candidates in the encounter and in HIKER, and weights that do what people did in the
    /// one, in the other, and in both.
    Laboratories {
        /// The reference numbers of HIKER, `hiker_reference.json`.
        reference: PathBuf,
        /// What each person of HIKER did, `hiker_persons.json`.
        #[arg(long, value_name = "FILE")]
        persons: PathBuf,
        /// What people did in the encounter, `human_crossing.csv`.
        #[arg(long, value_name = "FILE")]
        observations: PathBuf,
        /// Who is weighed, a population.
        #[arg(long, value_name = "POPULATION")]
        candidates: String,
        /// How many of them, evenly spaced in the file.
        #[arg(long, value_name = "N", default_value_t = 1000, value_parser = number::some())]
        count: usize,
        /// Runs of each candidate in every condition, and as many of fresh noise.
        #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=10_000))]
        repetitions: u32,
        /// Decides the noise of every run.
        #[arg(long, default_value_t = 20_261_121)]
        seed: u64,
    },
    /// Populations and models in the street in which people chose a gap in two streams of cars, beside what people did there.
    Crosscdr(CrosscdrArguments),
    /// The share of the published candidates of the default COMMOTIONS variant that calibration retains.
    Retention {
        /// The published individuals, `commotions_individuals.json`.
        individuals: PathBuf,
        /// How many candidates are drawn at random; more than there are means all.
        #[arg(long, value_name = "N", default_value_t = 5000, value_parser = number::some())]
        candidates: usize,
        /// Decides the draw and the noise of every run.
        #[arg(long, default_value_t = 20_261_121)]
        seed: u64,
    },
}

pub fn run(arguments: &ValidateArguments, registry: &Registry) -> Exit {
    let result = match &arguments.what {
        What::Hiker { reference, repetitions, seed, population, persons, members, looking } => {
            match population.as_deref().zip(persons.as_deref()) {
                Some((population, persons)) => {
                    let runs = (*members, (*repetitions).max(2), *seed);
                    let waiting = if *looking { LOOKING } else { AS_PUBLISHED };
                    people_of_hiker(reference, population, persons, runs, waiting)
                }
                None => hiker(reference, *repetitions, *seed),
            }
        }
        What::Encounter { observations, population, members, repetitions, seed } => {
            validate_population::encounter(observations, population, *members, *repetitions, seed)
        }
        What::Laboratories { reference, persons, observations, candidates, count, repetitions, seed } => {
            let who = (candidates.as_str(), *count);
            validate_population::laboratories(reference, persons, observations, who, (*repetitions, *seed))
        }
        What::Crosscdr(arguments) => return validate_crosscdr::run(arguments, registry),
        What::Retention { individuals, candidates, seed } => retention(individuals, *candidates, *seed),
    };
    result.unwrap_or_else(|error| {
        writeln!(stderr(), "error: {error}");
        Exit::Usage
    })
}

fn hiker(file: &Path, repetitions: u32, seed: u64) -> Result<Exit, Box<dyn std::error::Error>> {
    let comparisons = HikerReference::read(file)?.compare(file, 1, repetitions, seed)?;
    writeln!(stdout(), "crossed before the second car       | median start after the first car (s)");
    writeln!(stdout(), "scenario    runs   ours  ref.  s.e.  |   ours   ref.   diff.  s.e.");
    for comparison in &comparisons {
        writeln!(stdout(), "{}", row(comparison));
    }
    let agree = comparisons.iter().filter(|c| c.shares_agree() && c.medians_agree()).count();
    let gaps = comparisons.iter().filter(|c| c.medians_agree() && !c.medians_are_close()).count();
    writeln!(stdout(), "{agree} of {} scenarios agree", comparisons.len());
    if gaps > 0 {
        writeln!(
            stdout(),
            "* in {gaps} the starts fall into two groups of about the same size: the median lies anywhere between"
        );
    }
    Ok(if agree == comparisons.len() { Exit::Success } else { Exit::Failed })
}

/// A population beside the people of HIKER, whom no calibration of ours has seen: what it does, and how far that is off.
fn people_of_hiker(
    file: &Path,
    population: &str,
    persons: &Path,
    (members, repetitions, seed): (usize, u32, u64),
    waiting: Waiting,
) -> Result<Exit, Box<dyn std::error::Error>> {
    let (reference, persons) = (HikerReference::read(file)?, HikerPersons::read(persons)?);
    let SomeMembers { variant, people, digest, .. } = SomeMembers::read(population, members)?;
    let found = held_back(&reference, &persons, &variant, &people, (repetitions, seed), waiting);
    writeln!(stdout(), "{} of {population}, digest {digest}, {repetitions} times each", people.len(),);
    writeln!(
        stdout(),
        "crossed before the second car (%)      | spread (%)     | median initiation time (s)"
    );
    writeln!(stdout(), "scenario    people       {population:.9}  apart | people   here  | people   here");
    for one in &found {
        let second =
            |value: Option<f64>| value.map_or_else(|| "–".to_string(), |value| format!("{value:.2}"));
        writeln!(
            stdout(),
            "{:8} {:6.1} ± {:3.1} {:8.1}  {:+6.1}  | {:6.1} {:6.1}  | {:>6} {:>6}",
            one.scenario,
            100.0 * one.observed,
            100.0 * one.error,
            100.0 * one.share,
            100.0 * (one.share - one.observed),
            100.0 * one.observed_spread,
            100.0 * one.spread,
            second(one.observed_start),
            second(one.start),
        );
    }
    let rms = |of: &dyn Fn(&HeldBackScenario) -> Option<f64>| {
        let errors: Vec<f64> = found.iter().filter_map(of).collect();
        (errors.iter().map(|error| error * error).sum::<f64>() / errors.len().max(1) as f64).sqrt()
    };
    writeln!(
        stdout(),
        "root mean square error: shares {:.1} points, spread {:.1} points, initiation times {:.2} s",
        100.0 * rms(&|one| Some(one.share - one.observed)),
        100.0 * rms(&|one| Some(one.spread - one.observed_spread)),
        rms(&|one| Some(one.start? - one.observed_start?)),
    );
    Ok(Exit::Success)
}

fn row(c: &HikerComparison) -> String {
    let number = |value: Option<f64>| value.map_or_else(|| "–".to_string(), |value| format!("{value:.3}"));
    let errors = c.median_standard_errors();
    format!(
        "{:8} {:7}  {:.3} {:.3}  {:4.1}  | {:>6} {:>6} {:>7}  {:>4}{}{}",
        c.scenario,
        c.runs,
        c.crossed_before,
        c.reference_crossed_before,
        c.standard_errors(),
        number(c.median_start),
        number(c.reference_median_start),
        number(c.median_difference()),
        errors.map_or_else(|| "–".to_string(), |errors| format!("{errors:.1}")),
        if c.medians_are_close() { "" } else { " *" },
        if c.shares_agree() && c.medians_agree() { "" } else { "  DIFFERS" },
    )
}

fn retention(file: &Path, count: usize, seed: u64) -> Result<Exit, Box<dyn std::error::Error>> {
    let candidates = published_candidates(file, count, seed)?;
    let total = candidates.rows.len();
    let calibration =
        Calibration { variant: Variant::STANDARD, criteria: published_criteria(), repetitions: 5, seed };
    let request = Request { calibration, candidates, design: String::new() };
    let report = calibrate(&request, None, || ())?;
    for (criterion, failed) in request.calibration.criteria.iter().zip(&report.failed) {
        writeln!(stdout(), "{failed:>6} failed: {}", criterion.name);
    }
    let share = report.retained.len() as f64 / total as f64;
    writeln!(
        stdout(),
        "{:>6} of {total} candidates retained: {:.1} %; published {:.1} %",
        report.retained.len(),
        100.0 * share,
        100.0 * PUBLISHED_SHARE
    );
    Ok(if (share - PUBLISHED_SHARE).abs() <= 0.02 { Exit::Success } else { Exit::Failed })
}
