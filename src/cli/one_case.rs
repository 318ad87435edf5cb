//! From a run's key to its case: what commands about a single run begin with.

use std::fs;

use clap::Args;

use super::Exit;
use super::load;
use super::programs::ProgramArguments;
use super::set::SetArguments;
use report::console::stderr;
use report::{case_values, count};
use results::Requests;
use runner::corpus;
use runner::experiment::searched_case;
use runner::plan::{PlannedTrial, plan_scenario};
use runner::project::{PlannedSuite, Project};
use runner::run::BatchError;
use runner::session::{UnitKind, Work, units};
use scenario::registry::Registry;
use scenario::{Case, Criterion, Scenario, Search};

#[derive(Debug, Args)]
pub struct KeyArguments {
    /// The run's key, as reports give it: `zebra/carla_walker/tta=6s/rep=2`.
    pub key: String,

    /// The suite or scenario it belongs to [default: the files in suites/ whose name is the key's first part].
    #[arg(value_name = "FILE")]
    files: Vec<String>,

    /// Replaces the seed of the suite.
    #[arg(long, value_name = "SEED")]
    pub seed: Option<u64>,

    #[command(flatten)]
    pub programs: ProgramArguments,
}

#[derive(Debug, Args)]
pub struct CaseArguments {
    #[command(flatten)]
    pub run: KeyArguments,

    #[command(flatten)]
    set: SetArguments,
}

/// The run that was asked for.
pub struct FoundCase<'a> {
    pub suite: &'a PlannedSuite,
    pub case: Case,
    /// What is asked of its trial, with constant bounds.
    pub criteria: Vec<Criterion>,
}

impl FoundCase<'_> {
    /// All that is measured by default, and what is asked of its suite.
    pub fn requests(&self, registry: &Registry) -> Requests {
        let mut requests = Requests::defaults(registry);
        self.suite.plan.trials().for_each(|trial| requests.include(&trial.criteria));
        requests.include(&self.criteria);
        requests
    }

    /// What the run has of its own, in the units that it is written in, and what was set.
    pub fn values(&self) -> Vec<(String, String)> {
        values(self.suite, &self.case)
    }
}

/// What a run of a suite has of its own, in the units that it is written in, and what was set.
pub fn values(suite: &PlannedSuite, case: &Case) -> Vec<(String, String)> {
    let suite = &suite.suite;
    let scenario = suite.scenarios.iter().find(|scenario| scenario.name == case.scenario);
    let mut values = scenario.map_or_else(Vec::new, |scenario| case_values(case, scenario));
    values.extend(suite.set.iter().map(|set| ("set".to_string(), set.clone())));
    values
}

impl CaseArguments {
    /// The suites in which the run is to be found; what is wrong goes to stderr. `command` is what was asked for.
    pub fn load(&self, command: &str, registry: &Registry) -> Result<Project, Exit> {
        let files = self.run.files(command)?;
        load::load_all(&files.iter().collect::<Vec<_>>(), self.run.seed, &self.set, false, registry)
    }

    /// The run of that key; if there is none, says so on stderr.
    pub fn find<'a>(&self, suites: &'a [PlannedSuite]) -> Result<FoundCase<'a>, Exit> {
        self.run.find(suites)
    }
}

impl KeyArguments {
    /// The files in which the run is to be found; if none is known, says so on stderr. `command` is what was asked for.
    pub fn files(&self, command: &str) -> Result<Vec<String>, Exit> {
        match &self.files[..] {
            [] => match default_file(&self.key) {
                Some(file) => Ok(vec![file]),
                None => {
                    writeln!(
                        stderr(),
                        "error: no file is named, and there is no suite for `{}` in suites/",
                        self.key
                    );
                    writeln!(
                        stderr(),
                        "help: name it, as in `scenario-runner {command} KEY suites/zebra.suite`"
                    );
                    Err(Exit::Usage)
                }
            },
            files => Ok(files.to_vec()),
        }
    }

    /// The run of that key: one of the plan, or a recorded one by the key of its unit. If there is none, says so on
    /// stderr.
    pub fn find<'a>(&self, suites: &'a [PlannedSuite]) -> Result<FoundCase<'a>, Exit> {
        if let Some(found) = look_for(&self.key, suites) {
            return found;
        }
        // As it is called where others of its suite's name are run.
        if let Some(found) = known_alone(&self.key, suites).and_then(|key| look_for(&key, suites)) {
            return found;
        }
        let key = &self.key;
        writeln!(stderr(), "error: no run is called `{key}`");
        let mut trials = suites.iter().flat_map(|suite| suite.plan.trials());
        if let Some(trial) = trials.find(|trial| trial.key == *key) {
            let runs = count(trial.cases.len(), "run");
            writeln!(stderr(), "help: it is a trial of {runs}; name one, such as `{}`", trial.cases.key(0));
            return Err(Exit::NothingSelected);
        }
        let similarity = |known: &str| (strsim::normalized_levenshtein(known, key) * 1e6) as u64;
        let trials = suites.iter().flat_map(|suite| suite.plan.trials());
        let keys = trials
            .flat_map(|trial| (0..trial.cases.len()).map(|run| trial.cases.key(run)).collect::<Vec<_>>());
        let nearest = keys.max_by_key(|known| similarity(known));
        if let Some(nearest) = nearest {
            writeln!(stderr(), "help: the nearest name is `{nearest}`");
        }
        Err(Exit::NothingSelected)
    }
}

/// A key that was made where others had the name of its suite, as it is among these.
pub fn known_alone(key: &str, suites: &[PlannedSuite]) -> Option<String> {
    suites
        .iter()
        .filter(|suite| suite.suite.apart.is_empty())
        .find_map(|suite| suite.key_alone(key).map(str::to_string))
}

/// The run of that key; `None` if there is none. An error is one of a run that cannot be made any more, of which stderr was told.
pub fn look_for<'a>(key: &str, suites: &'a [PlannedSuite]) -> Option<Result<FoundCase<'a>, Exit>> {
    let units = units(suites);
    let recorded = (0..units.len()).filter(|unit| matches!(units.kind(*unit), UnitKind::Recorded));
    for unit in recorded.map(|unit| units.get(unit)).filter(|unit| unit.key == key) {
        if let Work::Recorded(recorded) = &unit.work {
            let suite = &suites[unit.suite];
            let revived = corpus::revive(recorded, &suite.suite)
                .and_then(|case| Ok((case, corpus::criteria(recorded, &suite.suite)?)));
            return Some(match revived {
                Ok((case, criteria)) => {
                    Ok(FoundCase { suite, case: Case { key: key.to_string(), ..case }, criteria })
                }
                Err(stale) => {
                    writeln!(stderr(), "error: `{key}` cannot be run any more: {stale}");
                    Err(Exit::NothingSelected)
                }
            });
        }
    }
    let trials = || suites.iter().flat_map(|suite| suite.plan.trials().map(move |one| (suite, one)));
    let named = |(suite, trial): (&'a PlannedSuite, PlannedTrial)| {
        let case = trial.cases.named(key)?;
        Some(FoundCase { suite, case, criteria: trial.criteria.to_vec() })
    };
    if let Some(found) = trials().find_map(named) {
        return Some(Ok(found));
    }
    // A scenario that only an estimate is of has no trials of its own.
    let mut supporting =
        suites.iter().flat_map(|suite| suite.suite.supporting.iter().map(move |one| (suite, one)));
    let of = |(suite, scenario): (&'a PlannedSuite, &'a Scenario)| {
        let plan = plan_scenario(&suite.suite, scenario).ok()?;
        plan.trials().find_map(|trial| named((suite, trial)))
    };
    if let Some(found) = key.contains("/u=").then(|| supporting.find_map(of)).flatten() {
        return Some(Ok(found));
    }
    // A run of an evaluation of a search, which no trial has.
    let searched = |suite: &'a PlannedSuite| Some((suite, searched_case(&suite.suite, key)?));
    let (suite, case) = suites.iter().find_map(searched)?;
    let of_it = |search: &&Search| {
        let name = format!("{}/{}/", suite.suite.key_name(), search.name);
        key.starts_with(&name)
    };
    let criteria = suite.suite.searches.iter().find(of_it).map(|search| search.expect.clone());
    Some(Ok(FoundCase { suite, case, criteria: criteria.unwrap_or_default() }))
}

/// Says on stderr why a run has no outcome; how the program ends then.
pub fn could_not_run(error: &BatchError) -> Exit {
    writeln!(stderr(), "error: {error}");
    let error = match error {
        BatchError::Run { error, .. } => error,
        BatchError::Stopped => return Exit::Interrupted,
        _ => return Exit::Failed,
    };
    if !error.had_begun() {
        return Exit::Scenario;
    }
    if let Some(hint) = error.hint() {
        writeln!(stderr(), "help: {hint}");
    }
    Exit::Failed
}

fn default_file(key: &str) -> Option<String> {
    let path = format!("suites/{}.suite", key.split('/').next()?);
    fs::exists(&path).ok()?.then_some(path)
}
