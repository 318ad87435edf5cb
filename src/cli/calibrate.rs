//! `scenario-runner calibrate NAME FILE`: the `calibrate` block of a file. Without them: retains the parameter sets of the COMMOTIONS
//! model that meet criteria, or with `--mix` joins populations.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::experiment::{self, ExperimentArguments};
use super::programs::{ProgramArguments, VerifyArguments};
use super::progress::bar;
use super::run::output::BlockOutputArguments;
use super::set::SetArguments;
use super::{Exit, number, store};
use files::Disk;
use models::calibrate::{
    Calibration, CalibrationJournal, Candidates, Design, DrawnParameter, ParameterRange, Report, Request,
    calibrate, published_candidates, published_criteria, published_grid, read_criteria,
};
use models::pedestrian::commotions::model::commotions;
use models::pedestrian::commotions::{Variant, VariantError};
use report::console::{stderr, stdout};
use scenario::population::{MixturePart, Population, PopulationError, shipped};
use scenario::registry::Registry;

#[derive(Debug, Args)]
pub struct CalibrateArguments {
    /// The `calibrate` block that weighs candidates until they do what people did. Without a block, parameter sets of the
    /// COMMOTIONS model are retained that meet criteria, and the options below from `--variant` on say which.
    #[arg(requires = "file", conflicts_with_all = BY_CRITERIA)]
    name: Option<String>,

    /// The suite or scenario file that declares it.
    file: Option<String>,

    #[command(flatten)]
    set: SetArguments,

    #[command(flatten)]
    programs: ProgramArguments,

    #[command(flatten)]
    verify: VerifyArguments,

    /// Of a block: write everything that was found as JSON.
    #[arg(long, value_name = "PATH", requires = "name")]
    json: Option<PathBuf>,

    /// Of a block: draw people, candidates and the population.
    #[arg(long, value_name = "PATH", requires = "name")]
    svg: Option<PathBuf>,

    /// Of a block: write 20 populations for persons who are drawn again, into this folder.
    #[arg(long, value_name = "DIR", requires = "name")]
    resampled: Option<PathBuf>,

    /// Join populations to one: everybody of each file, or of one that ships, with equal shares or, such as `germany.json=0.4`, with these.
    /// Nobody is run. Repeated for each of them.
    #[arg(long, value_name = "FILE[=SHARE]", value_parser = parse_mixed, conflicts_with_all = BY_CRITERIA, conflicts_with = "name")]
    mix: Vec<Mixed>,

    /// Variant of the model: the published name.
    #[arg(long, default_value = "oVAoBEvoAIoEAoSNvoPF")]
    variant: String,

    /// Judge the parameter sets in this population file (.json or .csv) instead of a design.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["design", "count", "range", "base"])]
    candidates: Option<PathBuf>,

    /// How candidates are taken from the ranges of the parameters.
    #[arg(long, value_enum, default_value_t = Designs::FromGrid)]
    design: Designs,

    /// How many candidates; a whole grid needs no number.
    #[arg(long, value_name = "N", default_value_t = 5000, value_parser = number::some())]
    count: usize,

    /// Of `--design published`: keep only the first so many of them. They stand in random order, so that a study that was planned for
    /// more may stop earlier.
    #[arg(long, value_name = "N", value_parser = number::some())]
    first: Option<usize>,

    /// Range of a parameter, such as `T_delta=10..100` or with the levels of its grid `T_delta=10..100:10`.
    /// Without it the published grid. May be repeated.
    #[arg(long, value_name = "NAME=LOW..HIGH[:LEVELS]", value_parser = parse_range)]
    range: Vec<ParameterRange>,

    /// Gives every candidate a value of another parameter, in equally likely strata of a distribution in SI units, such as
    /// `"ped_free_speed=truncated_normal(1.34, 0.26, 0.5, 2.2)"`. May be repeated.
    #[arg(long, value_name = "NAME=DISTRIBUTION(…)")]
    draw: Vec<DrawnParameter>,

    /// Cross the design with the parameter sets in this population file, which give some of the parameters.
    #[arg(long, value_name = "FILE")]
    base: Option<PathBuf>,

    /// The variant whose parameter sets are taken from a base with several.
    #[arg(long, value_name = "VARIANT", requires = "base")]
    base_variant: Option<String>,

    /// JSON file of the criteria; without it the published ones, which `--print-criteria` shows.
    #[arg(long, value_name = "FILE")]
    criteria: Option<PathBuf>,

    /// Judge nobody: every candidate is written, such as for a `calibrate` block to weigh.
    #[arg(long, conflicts_with_all = ["criteria", "print_criteria"])]
    no_criteria: bool,

    /// Print the criteria that would be applied as JSON, and do nothing.
    #[arg(long)]
    print_criteria: bool,

    /// Runs of each meeting.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    repetitions: u32,

    /// Decides the candidates of a random design and the noise of every run [default: 1, and of a block that of its suite].
    #[arg(long)]
    seed: Option<u64>,

    /// Write the population that comes of it to this file (.json).
    #[arg(long, value_name = "FILE", required_unless_present_any = ["print_criteria", "name"])]
    out: Option<PathBuf>,

    /// Keep results in this file, and go on from those already in it; of a block: in this folder, and in `.scenario-runner` if
    /// not said.
    #[arg(long, value_name = "FILE")]
    journal: Option<PathBuf>,

    /// Number of threads, at most 1024 [default: one per core]. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = number::threads())]
    threads: Option<usize>,

    /// Never draw a progress bar.
    #[arg(long)]
    no_progress: bool,
}

/// A population of a mixture, and what part of it they are.
#[derive(Debug, Clone)]
struct Mixed {
    population: String,
    share: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Designs {
    /// Every combination of the levels.
    Grid,
    /// Different combinations of the levels, drawn at random.
    FromGrid,
    /// Log-uniform and independent.
    LogUniform,
    /// A Latin hypercube on log scales.
    LatinHypercube,
    /// The candidates of the published fit of the default variant, as far as the individuals in `--base` show them; with a `--range` of
    /// another parameter, in strata of it.
    Published,
}

/// Why nothing was calibrated.
#[derive(Debug, thiserror::Error)]
enum CalibrateError {
    #[error(transparent)]
    Variant(#[from] VariantError),
    #[error(transparent)]
    Population(#[from] PopulationError),
    #[error(transparent)]
    Criteria(#[from] models::calibrate::CriteriaError),
    #[error(transparent)]
    Candidates(#[from] models::calibrate::CandidateError),
    #[error(transparent)]
    Journal(#[from] models::calibrate::JournalError),
    #[error(transparent)]
    Calibrate(#[from] models::calibrate::CalibrateError),
    #[error("`--design published` needs the published individuals: `--base commotions_individuals.json`")]
    NoBase,
    #[error(transparent)]
    Published(#[from] models::calibrate::PublishedError),
    #[error(transparent)]
    Mixture(#[from] scenario::population::MixtureError),
    #[error("cannot start {threads} threads: {error}")]
    Threads { threads: usize, error: rayon::ThreadPoolBuildError },
    #[error("cannot write {}: {error}", file.display())]
    Write { file: PathBuf, error: std::io::Error },
    #[error("cannot say as JSON what was retained: {0}")]
    Json(#[from] serde_json::Error),
}

/// What a block says by itself.
const BY_CRITERIA: [&str; 11] = [
    "variant",
    "candidates",
    "design",
    "count",
    "range",
    "draw",
    "base",
    "criteria",
    "no_criteria",
    "print_criteria",
    "repetitions",
];

pub fn run(arguments: &CalibrateArguments, registry: &Registry) -> Exit {
    if let (Some(name), Some(file)) = (&arguments.name, &arguments.file) {
        let block = ExperimentArguments {
            name: name.clone(),
            file: file.clone(),
            seed: arguments.seed,
            set: arguments.set.clone(),
            programs: arguments.programs.clone(),
            verify: arguments.verify,
            save: arguments.out.clone(),
            json: arguments.json.clone(),
            output: BlockOutputArguments::default(),
            journal: arguments.journal.clone().unwrap_or_else(|| PathBuf::from(store::JOURNAL)),
            no_progress: arguments.no_progress,
            plots: experiment::Plots {
                svg: arguments.svg.clone(),
                resampled: arguments.resampled.clone(),
                threads: arguments.threads,
            },
        };
        return experiment::calibrate(&block, registry);
    }
    let done = if arguments.mix.is_empty() { try_run(arguments) } else { mix(arguments) };
    match done {
        Ok(exit) => exit,
        Err(error) => {
            writeln!(stderr(), "error: {error}");
            match error {
                CalibrateError::Write { .. } | CalibrateError::Json(_) => Exit::Output,
                _ => Exit::Usage,
            }
        }
    }
}

fn try_run(arguments: &CalibrateArguments) -> Result<Exit, CalibrateError> {
    let criteria = match &arguments.criteria {
        None if arguments.no_criteria => Vec::new(),
        Some(file) => read_criteria(file)?,
        None => published_criteria(),
    };
    if arguments.print_criteria {
        stdout().verbatim(&(serde_json::to_string_pretty(&criteria)? + "\n"));
        return Ok(Exit::Success);
    }
    let Some(out) = &arguments.out else { return Ok(Exit::Usage) };
    let variant: Variant = arguments.variant.parse()?;
    let (candidates, mut design) = candidates(arguments, &variant)?;
    let seed = arguments.seed.unwrap_or(1);
    let mut candidates = candidates.with_draws(&arguments.draw, seed, &commotions().declaration)?;
    for drawn in &arguments.draw {
        design.push_str(&format!(", {drawn}"));
    }
    let is_published = matches!(arguments.design, Designs::Published);
    let first = arguments.first.filter(|first| is_published && *first < candidates.rows.len());
    if let Some(first) = first {
        candidates.rows.truncate(first);
        design.push_str(&format!(", the first {first} of them"));
    }
    let calibration = Calibration { variant, criteria, repetitions: arguments.repetitions, seed };
    let request = Request { calibration, candidates, design };
    let journal = arguments
        .journal
        .as_ref()
        .map(|file| CalibrationJournal::open(file, &request.fingerprint()))
        .transpose()?;
    if let Some(notice) = journal.as_ref().and_then(CalibrationJournal::notice) {
        writeln!(stderr(), "note: {notice}");
    }
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()
            .map_err(|error| CalibrateError::Threads { threads, error })?;
    }
    let template = "{human_pos} of {human_len} candidates [{wide_bar}] {per_sec}, {eta} left";
    let bar = bar(!arguments.no_progress, template, request.candidates.rows.len() as u64);
    let report = calibrate(&request, journal.as_ref(), || bar.inc(1))?;
    bar.finish_and_clear();
    write!(stdout(), "{}", summary(&request, &report));
    if report.retained.is_empty() {
        writeln!(stderr(), "error: nobody met all criteria; nothing is written");
        return Ok(Exit::Failed);
    }
    let text = report.population(&request).to_json()?;
    files::write(out, text).map_err(|error| CalibrateError::Write { file: out.clone(), error })?;
    writeln!(stdout(), "wrote {}", out.display());
    Ok(Exit::Success)
}

/// Joins populations, and writes what comes of it.
fn mix(arguments: &CalibrateArguments) -> Result<Exit, CalibrateError> {
    let Some(out) = &arguments.out else { return Ok(Exit::Usage) };
    let model = commotions().declaration;
    let read = |mixed: &Mixed| -> Result<MixturePart, CalibrateError> {
        let Mixed { population: name, share } = mixed;
        let population = if shipped().any(|known| known == name) {
            Population::parse(name, None, &model, None)?
        } else {
            Population::read(Path::new(name), &model, None, &Disk)?
        };
        let name =
            Path::new(name).file_name().map_or_else(|| name.clone(), |name| name.to_string_lossy().into());
        Ok(MixturePart { name, population, share: *share })
    };
    let parts = arguments.mix.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let mixture = Population::mixture(&parts)?;
    files::write(out, mixture.to_json()?)
        .map_err(|error| CalibrateError::Write { file: out.clone(), error })?;
    writeln!(stdout(), "{}", mixture.source);
    writeln!(stdout(), "wrote {}, digest {}", out.display(), mixture.digest());
    Ok(Exit::Success)
}

/// The candidates, and in words where they come from.
fn candidates(
    arguments: &CalibrateArguments,
    variant: &Variant,
) -> Result<(Candidates, String), CalibrateError> {
    let read = |file: &PathBuf, variant: Option<&str>| {
        Population::read(file, &commotions().declaration, variant, &Disk)
            .map(|population| Candidates { names: population.parameters, rows: population.individuals })
    };
    let name = |file: &PathBuf| {
        file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    };
    if matches!(arguments.design, Designs::Published) {
        return published(arguments);
    }
    if let Some(file) = &arguments.candidates {
        return Ok((read(file, Some(&variant.to_string()))?, name(file)));
    }
    let base = match &arguments.base {
        Some(file) => read(file, arguments.base_variant.as_deref())?,
        None => Candidates::nothing_given(),
    };
    let mut ranges = published_grid(variant);
    for range in &arguments.range {
        match ranges.iter_mut().find(|published| published.name == range.name) {
            Some(published) => *published = range.clone(),
            None => ranges.push(range.clone()),
        }
    }
    let count = arguments.count;
    let design = match arguments.design {
        Designs::Grid => Design::Grid,
        Designs::FromGrid => Design::FromGrid(count),
        Designs::LogUniform => Design::LogUniform(count),
        Designs::LatinHypercube | Designs::Published => Design::LatinHypercube(count),
    };
    let candidates =
        Candidates::design(&base, &ranges, design, arguments.seed.unwrap_or(1), &commotions().declaration)?;
    let varied = ranges.iter().filter(|range| !base.names.contains(&range.name.to_string()));
    let varied: Vec<String> = varied.map(|r| format!("{} {}..{}", r.name, r.low, r.high)).collect();
    let mut words = format!("{design} over {}", varied.join(", "));
    if let Some(file) = &arguments.base {
        words.push_str(&format!(", crossed with {} of {}", base.names.join(", "), name(file)));
    }
    Ok((candidates, words))
}

/// Those of the published fit, with more parameters where ranges are given.
fn published(arguments: &CalibrateArguments) -> Result<(Candidates, String), CalibrateError> {
    let file = arguments.base.as_ref().ok_or(CalibrateError::NoBase)?;
    let seed = arguments.seed.unwrap_or(1);
    let found = published_candidates(file, arguments.count, seed)?;
    let found = found.with_ranges(&arguments.range, seed, &commotions().declaration)?;
    let mut words = format!("{} of the published fit", found.rows.len());
    for ParameterRange { name, low, high, .. } in &arguments.range {
        words.push_str(&format!(", {name} in strata over {low}..{high}"));
    }
    Ok((found, words))
}

fn summary(request: &Request, report: &Report) -> String {
    let total = request.candidates.rows.len();
    let mut text = format!("{total} candidates of {}\n", request.calibration.variant);
    for (criterion, failed) in request.calibration.criteria.iter().zip(&report.failed) {
        text.push_str(&format!("{failed:>8} failed: {}\n", criterion.name));
    }
    let retained = report.retained.len();
    let share = 100.0 * retained as f64 / total as f64;
    text.push_str(&format!("{retained:>8} retained ({share:.1} %)\n"));
    text
}

fn parse_mixed(text: &str) -> Result<Mixed, String> {
    let Some((population, share)) = text.rsplit_once('=') else {
        return Ok(Mixed { population: text.to_string(), share: None });
    };
    let share = share.trim().parse().map_err(|_| {
        format!("`{share}` is no share; write it like germany.json=0.4, or leave it out where all are equal")
    })?;
    Ok(Mixed { population: population.to_string(), share: Some(share) })
}

fn parse_range(text: &str) -> Result<ParameterRange, String> {
    let expected = || format!("`{text}` is no range; write it like T_delta=10..100 or T_delta=10..100:10");
    let (name, range) = text.split_once('=').ok_or_else(expected)?;
    let (range, levels) = match range.split_once(':') {
        Some((range, levels)) => (range, levels.trim().parse().map_err(|_| expected())?),
        None => (range, 10),
    };
    let (low, high) = range.split_once("..").ok_or_else(expected)?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| expected());
    let name = name.trim();
    let declaration = commotions().declaration;
    let parameter = declaration.parameter(name);
    let name = parameter.ok_or_else(|| format!("the model has no parameter `{name}`"))?.name.clone();
    Ok(ParameterRange { name, low: number(low)?, high: number(high)?, levels })
}
