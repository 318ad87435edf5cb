//! Populations and models in the street in which people chose a gap in two streams of cars, run by run as the scenario file has it.

mod facts;
mod shares;
mod walk;

use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

use thiserror::Error;

use crate::project::{Problems, Project, ProjectOptions};
use crate::run::{BatchError, Executor, RunBatch, Stop, Wanted};
use files::{Files, Memory, ReadError};
use lang::{Override, quoted};
use results::{ChosenGaps, FittedTo, GapChooser, GapCondition, PeopleAtGaps};
use scenario::population::{Population, PopulationError, SHIPPED_MODEL, shipped};
use scenario::registry::Registry;
use scenario::{Case, Settings};
use shares::{PersonsWalks, chosen_gaps};
use walk::{GapMetrics, LOOKED_AT};

pub use facts::{FactsError, read_people_at_gaps};

/// Name of the street's file in the keys of runs.
const STREET: &str = "crosscdr.scn";
const RUNS: &str = "gap_choice.scn";

/// Words that only the provenance of a population fitted to the people of the experiment has.
const THESE_PEOPLE: [&str; 3] = ["crosscdr", "10.1109/iv55152.2023.10186635", "sprenger"];

/// What the walker of the file lacks, which is of the model that populations are of. Its body is the published one.
const OWN_MODEL: &str = "size 0.8 m x 0.8 m";

/// The walker of another model: going cannot be inhibited there, so it stands until the first car has passed.
fn waits(model: &str) -> String {
    format!("model {model}\n    looks for look + 2.3 s")
}

/// Smallest difference between two gaps, s.
const SAME: f64 = 1e-6;

/// A population or a model to be put into the street.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PopulationOrModel {
    /// Of a population: a name that ships, or a file.
    Population(String),
    /// A pedestrian model with its defaults.
    Model(String),
}

/// Why it is not known what a population or a model does in the street.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum GapChoiceError {
    /// The file of a population cannot be read.
    #[error("cannot read the population {file}: {error}")]
    Read {
        /// The file.
        file: String,
        /// Why not.
        error: ReadError,
    },
    /// It is not a population, or is one of another model.
    #[error(transparent)]
    Population(#[from] PopulationError),
    /// There is no such model.
    #[error("there is no pedestrian model called `{name}`{}", nearest.as_ref().map_or_else(String::new, |near| format!("; did you mean `{near}`?")))]
    UnknownModel {
        /// What was asked for.
        name: String,
        /// The nearest name that there is.
        nearest: Option<String>,
    },
    /// The time to look is not a time.
    #[error("`{look}` is no time to look: {reason}")]
    Look {
        /// What was asked for.
        look: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The scenario cannot be run with it.
    #[error("{name} cannot be put into the street\n{problems}")]
    Problems {
        /// The population or the model.
        name: String,
        /// What is wrong.
        problems: Box<Problems>,
    },
    /// The scenario file is not that of the experiment.
    #[error("{0}")]
    Street(String),
    /// A run could not be made.
    #[error(transparent)]
    Batch(#[from] BatchError),
}

/// The street, the people who crossed it, and how many runs are made.
pub struct GapStudy<'a> {
    /// What people did.
    pub people: &'a PeopleAtGaps,
    /// The text of the scenario file: definitions `alone`, `risky` and `safe`, a stream `near`, a pedestrian `walker` and a `let look`.
    pub street: &'a str,
    /// What scenarios may name.
    pub registry: &'a Registry,
    /// Where populations are read.
    pub files: &'a dyn Files,
    /// Makes the runs.
    pub executor: &'a dyn Executor,
    /// Looked at before every run.
    pub stop: &'a Stop,
    /// How many persons of a population, at least 1; all if it has fewer. Of a model, which is one person, how many runs in every condition.
    pub members: usize,
    /// Runs of each person of a population in every condition, at least 1.
    pub repetitions: u32,
    /// Decides which persons are drawn, and the noise of every run.
    pub seed: u64,
}

/// A population or a model as the scenario says it.
struct Walker {
    /// What stands in the block of the pedestrian.
    block: String,
    /// The file of a population, with its text.
    file: Option<(String, String)>,
    digest: Option<String>,
    fitted: FittedTo,
    persons: usize,
    runs: u32,
    is_fixed: bool,
}

/// A population or a model with its planned runs.
pub struct PlannedChooser {
    name: String,
    walker: Walker,
    /// `None` for a model that does not react to cars.
    project: Option<Project>,
}

impl GapStudy<'_> {
    /// Reads a population or a model, and plans its runs in all conditions after a time to look such as `1 s`; nothing runs.
    ///
    /// # Errors
    /// [`GapChoiceError`], but for what only runs show.
    pub fn plan(&self, subject: &PopulationOrModel, look: &str) -> Result<PlannedChooser, GapChoiceError> {
        let walker = self.walker(subject)?;
        let name = named(subject, look);
        let project = match walker.is_fixed {
            true => None,
            false => Some(self.project(&name, &walker, look)?),
        };
        Ok(PlannedChooser { name, walker, project })
    }

    /// Makes the planned runs; calls `progress` with how many runs of how many are done.
    ///
    /// # Errors
    /// [`GapChoiceError`].
    pub fn run(
        &self,
        planned: PlannedChooser,
        progress: impl Fn(usize, usize) + Send + Sync,
    ) -> Result<GapChooser, GapChoiceError> {
        let PlannedChooser { name, walker, project } = planned;
        let chosen = project.map(|project| self.chosen(&project, progress)).transpose()?;
        let Walker { digest, fitted, persons, runs, .. } = walker;
        Ok(GapChooser { name, digest, fitted, persons, runs, chosen })
    }

    fn walker(&self, subject: &PopulationOrModel) -> Result<Walker, GapChoiceError> {
        let models = self.registry.pedestrians();
        let find = |name: &str| {
            models.get(name).ok_or_else(|| GapChoiceError::UnknownModel {
                name: name.to_string(),
                nearest: models.nearest(name),
            })
        };
        let (members, runs) = (self.members, self.repetitions);
        match subject {
            PopulationOrModel::Model(name) => {
                let model = find(name)?;
                let defaults = model.declaration.fill_in(&Settings::default());
                Ok(Walker {
                    block: if name == SHIPPED_MODEL { OWN_MODEL.to_string() } else { waits(name) },
                    file: None,
                    digest: None,
                    fitted: FittedTo::Others,
                    persons: 1,
                    runs: u32::try_from(members).unwrap_or(u32::MAX),
                    is_fixed: defaults.is_ok_and(|settings| (model.is_fixed)(&settings)),
                })
            }
            PopulationOrModel::Population(name) => {
                let is_shipped = shipped().any(|one| one == name);
                let text = match is_shipped {
                    true => None,
                    false => Some(
                        self.files
                            .read_text(Path::new(name), &["csv", "json"])
                            .map_err(|error| GapChoiceError::Read { file: name.clone(), error })?,
                    ),
                };
                let declaration = &find(SHIPPED_MODEL)?.declaration;
                let people = Population::parse(name, text.as_deref().map(Ok), declaration, None)?;
                let persons = members.min(people.len());
                let of = if is_shipped { name.clone() } else { quoted(name) };
                Ok(Walker {
                    block: format!("{OWN_MODEL}\n    individuals {persons} of {of}"),
                    file: text.map(|text| (name.clone(), text)),
                    digest: Some(people.digest()),
                    fitted: fitted_to(&people, is_shipped),
                    persons,
                    runs,
                    is_fixed: false,
                })
            }
        }
    }

    /// The scenarios of the runs, read, checked and planned.
    fn project(&self, name: &str, walker: &Walker, look: &str) -> Result<Project, GapChoiceError> {
        let scenario = |of: &str| {
            format!(
                "scenario {of}_gap : {of} {{\n  pedestrian walker {{\n    {}\n  }}\n  end on collision\n  repeat {}\n  expect {{ no collision }}\n}}\n",
                walker.block, walker.runs
            )
        };
        let text = ["alone", "risky", "safe"].map(scenario).concat();
        let files =
            Memory::default().with(STREET, self.street).with(RUNS, format!("use {}\n{text}", quoted(STREET)));
        let files = match &walker.file {
            Some((name, text)) => files.with(name.as_str(), text.as_str()),
            None => files,
        };
        let set = Override::from_str(&format!("look={look}"))
            .map_err(|reason| GapChoiceError::Look { look: look.to_string(), reason })?;
        let options = ProjectOptions::default().seed(self.seed).set([set]);
        Project::open_all([RUNS], &options, self.registry, &files).map_err(|problems| {
            GapChoiceError::Problems { name: name.to_string(), problems: Box::new(problems) }
        })
    }

    fn chosen(
        &self,
        project: &Project,
        progress: impl Fn(usize, usize) + Send + Sync,
    ) -> Result<ChosenGaps, GapChoiceError> {
        let metrics = GapMetrics::of(self.registry).map_err(GapChoiceError::Street)?;
        let trials: Vec<_> = project.suites().iter().flat_map(|suite| suite.plan.trials()).collect();
        let all: usize = trials.iter().map(|trial| trial.cases.len()).sum();
        let mut walks: Vec<Option<Vec<PersonsWalks>>> = vec![None; self.people.conditions.len()];
        let mut done = 0;
        for trial in &trials {
            let first = trial.cases.first();
            let place = self.condition(&first)?;
            let mut cases = trial.cases.iter();
            let mut persons: BTreeMap<u32, PersonsWalks> = BTreeMap::new();
            let mut failed = None;
            let batch = RunBatch { executor: self.executor, measured: &metrics.measured, stop: self.stop };
            let next = |_| cases.next().expect("there are as many as were counted");
            batch.each(trial.cases.len(), Wanted::Outcome, next, |case, ran| {
                match metrics.walk(&case, &ran.outcome) {
                    Ok(walk) => persons.entry(person(&case)).or_default().push(walk),
                    Err(reason) => failed = failed.take().or(Some(reason)),
                }
                done += 1;
                progress(done, all);
            })?;
            if let Some(reason) = failed {
                return Err(GapChoiceError::Street(reason));
            }
            if walks[place].replace(persons.into_values().collect()).is_some() {
                return Err(GapChoiceError::Street(format!("{}: the gap is looked at twice", first.key)));
            }
        }
        let conditions = self.people.conditions.iter().zip(walks);
        let walks = conditions.map(|(condition, walks)| {
            let missing =
                || format!("{STREET} has no gap of {} s after gaps of {} s", condition.gap, condition.before);
            walks.ok_or_else(|| GapChoiceError::Street(missing()))
        });
        Ok(chosen_gaps(self.people, &walks.collect::<Result<Vec<_>, _>>()?))
    }

    /// The place of the condition that a run is of, by the gaps of its own cars.
    fn condition(&self, case: &Case) -> Result<usize, GapChoiceError> {
        let near = case.world.streams.iter().find(|stream| stream.name == walk::NEAR);
        let gaps: Vec<f64> = near.map_or_else(Vec::new, |near| {
            near.arrivals.windows(2).take(LOOKED_AT).map(|pair| pair[1] - pair[0]).collect()
        });
        let is_it = |condition: &GapCondition| {
            let expected =
                |number: usize| if number + 1 < LOOKED_AT { condition.before } else { condition.gap };
            gaps.len() == LOOKED_AT
                && gaps.iter().enumerate().all(|(number, gap)| (gap - expected(number)).abs() < SAME)
        };
        let place = self.people.conditions.iter().position(is_it);
        place.ok_or_else(|| {
            GapChoiceError::Street(format!("{}: no people were observed at gaps of {gaps:?} s", case.key))
        })
    }
}

/// Number of the person in the population; 1 for a model.
fn person(case: &Case) -> u32 {
    case.individuals.first().map_or(1, |person| person.number)
}

fn named(subject: &PopulationOrModel, look: &str) -> String {
    let name = match subject {
        PopulationOrModel::Population(name) => Path::new(name)
            .file_stem()
            .map_or_else(|| name.clone(), |stem| stem.to_string_lossy().into_owned()),
        PopulationOrModel::Model(name) => name.clone(),
    };
    if is_nothing(look) { name } else { format!("{name}, looks for {look}") }
}

/// Whether a time to look is 0 in whatever unit.
fn is_nothing(look: &str) -> bool {
    let number = look.trim_end_matches(|letter: char| letter.is_ascii_alphabetic() || letter == ' ');
    number.parse::<f64>() == Ok(0.0)
}

/// What the provenance of a population says of the people that it was fitted to.
fn fitted_to(population: &Population, is_shipped: bool) -> FittedTo {
    let said = serde_json::to_string(&population.provenance).unwrap_or_default();
    let said = format!("{} {said}", population.source).to_lowercase();
    if THESE_PEOPLE.iter().any(|word| said.contains(word)) {
        return FittedTo::ThesePeople;
    }
    if is_shipped {
        return FittedTo::Others;
    }
    match population.provenance.get("observations") {
        Some(observations) => FittedTo::Unknown(format!(
            "it was fitted to {observations}, and it is not known here whose these are"
        )),
        None if population.provenance.contains_key("criteria") => FittedTo::Unknown(
            "it was retained by criteria, and it is not known here what these rest on".to_string(),
        ),
        None => FittedTo::Unknown("it does not say what it was fitted to".to_string()),
    }
}

#[cfg(test)]
mod tests;
