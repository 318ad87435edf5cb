//! The blocks of a suite that build on each other: `search`, `tune`, `evaluate` and `statement`.
//!
//! A search looks for the values at which a metric is worst, person by person; a tune looks for controller parameters
//! that are best on a set of cases under constraints; an evaluation compares sets of parameters on the same cases; a
//! statement holds what a source says against all that. Each is a function of the suite and its seed: what
//! makes the runs, and when, changes nothing.

mod block;
mod cases;
mod claim;
mod evaluate;
mod journal;
mod overrides;
mod parameters;
mod rehearsal;
mod rounds;
mod runs;
mod search;
mod statement;
#[cfg(test)]
mod tests;
mod tune;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use crate::plan::PlanError;
use crate::run::{Executor, FirstRuns, MeasuredMetrics, RunError, Stop, VerifyRuns};
use files::{Disk, Files};
use results::{Requests, RunFault};
use scenario::registry::Registry;
use scenario::{Scenario, Suite};
use thiserror::Error;

pub use block::{EarlierResults, Need, needs, run_block};
pub use cases::CaseFile;
use evaluate::run_evaluate;
pub use overrides::apply as apply_settings;
pub use parameters::ParameterFile;
pub(crate) use rehearsal::rehearse_searches;
pub use search::run_search;
use statement::run_statement;
use tune::run_tune;

/// What every experiment of a suite shares.
pub struct Context<'a> {
    /// The suite that it is in.
    pub suite: &'a Suite,
    /// What is read off every run.
    pub measured: Arc<MeasuredMetrics>,
    /// What makes the runs.
    pub executor: &'a dyn Executor,
    /// Where what blocks refer to is read: saved cases and parameters.
    pub files: Arc<dyn Files>,
    /// Where journals are kept; `None` keeps none.
    pub journals: Option<PathBuf>,
    /// Looked at before every run.
    pub stop: Stop,
    /// Which of the runs in which programs decide are made a second time.
    pub first_runs: FirstRuns,
    /// What to tell whoever runs it, such as that the end of a journal was cut off.
    pub notices: Mutex<Vec<String>>,
}

impl<'a> Context<'a> {
    /// With every metric that anything in the suite asks for.
    pub fn new(suite: &'a Suite, executor: &'a dyn Executor, registry: &Registry) -> Self {
        let mut requests = Requests::defaults(registry);
        suite.scenarios.iter().for_each(|scenario| requests.include(&scenario.criteria));
        for search in &suite.searches {
            requests.add(search.objective.aggregate.metric());
            search.keep.iter().for_each(|keep| requests.add(&keep.metric));
        }
        for tune in &suite.tunes {
            tune.objectives.iter().for_each(|objective| requests.add(objective.aggregate.metric()));
            tune.constraints.iter().for_each(|constraint| requests.add(&constraint.metric));
        }
        for evaluate in &suite.evaluates {
            evaluate.measures.iter().for_each(|measure| requests.add(measure.aggregate.metric()));
        }
        for statement in &suite.statements {
            statement::measured(statement).iter().for_each(|one| requests.add(one.aggregate.metric()));
        }
        let rules = suite.gates.iter().flat_map(|gate| &gate.rules);
        rules.filter_map(|rule| rule.metric.as_ref()).for_each(|metric| requests.add(metric));
        suite.ratings.iter().for_each(|rating| requests.add(&rating.measure));
        Self {
            suite,
            measured: MeasuredMetrics::new(requests),
            executor,
            files: Arc::new(Disk),
            journals: None,
            stop: Stop::default(),
            first_runs: FirstRuns::new(VerifyRuns::None),
            notices: Mutex::default(),
        }
    }

    fn tell(&self, notice: Option<&str>) {
        let mut notices = self.notices.lock().unwrap_or_else(PoisonError::into_inner);
        notices.extend(notice.map(str::to_string));
    }

    /// What is measured in every run, in the order of the outcomes' metrics.
    pub fn requests(&self) -> &Requests {
        &self.measured.requests
    }

    fn scenario(&self, name: &str) -> Result<&'a Scenario, ExperimentError> {
        self.suite
            .scenarios
            .iter()
            .chain(&self.suite.supporting)
            .find(|scenario| scenario.name == name)
            .ok_or_else(|| ExperimentError::UnknownScenario(name.to_string()))
    }
}

/// Told while an experiment runs, from several threads.
pub trait BlockProgress: Sync {
    /// `done` of `all` evaluations are finished; `best` is the best objective value so far, if there is one.
    fn evaluated(&self, done: usize, all: usize, best: Option<f64>);
}

/// Nobody watches.
pub struct Silent;

impl BlockProgress for Silent {
    fn evaluated(&self, _done: usize, _all: usize, _best: Option<f64>) {}
}

/// Why an experiment has no result.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// A block names a scenario that the suite has not.
    #[error("there is no scenario called `{0}`")]
    UnknownScenario(String),
    /// A block reads the result of another that has none, or runs that were not made.
    #[error("`{0}` has not been run, but is needed")]
    NotRun(String),
    /// What a tune or an evaluation sets is not in a scenario: the target, and the scenario's name.
    #[error("there is no `{0}` to set in the scenario `{1}`")]
    UnknownTarget(String, String),
    /// On somebody's wish. What was evaluated is in the journal.
    #[error("interrupted")]
    Stopped,
    /// A block would run no case; how the set is called.
    #[error("the set of cases `{0}` is empty")]
    EmptySet(String),
    /// A sample is larger than what it is drawn from: the scenario, its runs, and how many are asked for.
    #[error("`{0}` has {1} runs, and {2} are to be drawn of them")]
    TooFewCases(String, usize, usize),
    /// A file of cases cannot be read, or is none.
    #[error("cannot read the cases of {}: {reason}", path.display())]
    CaseFile {
        /// The file.
        path: PathBuf,
        /// What is wrong, in words.
        reason: String,
    },
    /// A file of parameters cannot be read, or is none.
    #[error("cannot read the parameters of {}: {reason}", path.display())]
    ParameterFile {
        /// The file.
        path: PathBuf,
        /// What is wrong, in words.
        reason: String,
    },
    /// A case that was chosen cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A run could not be made, or not to its end.
    #[error("{}{}", of_run(key, error), with_values(values))]
    Run {
        /// The values under evaluation, such as `av.controller.gap = 5m`; empty where none are looked for.
        values: String,
        /// The run's key.
        key: String,
        /// Why.
        error: Box<RunError>,
    },
    /// The optimiser refuses what it was asked, or its journal.
    #[error(transparent)]
    Optimise(#[from] optimise::Error),
}

/// What is wrong with a run, which is named if it had begun.
fn of_run(key: &str, error: &RunError) -> String {
    if error.had_begun() { format!("{key}: {error}") } else { error.to_string() }
}

/// What was tried when that happened.
fn with_values(values: &str) -> String {
    if values.is_empty() { String::new() } else { format!("\nevaluated: {values}") }
}

impl ExperimentError {
    /// The run that a program kept from its end, if that is what it is about.
    pub fn run_fault(&self) -> Option<RunFault> {
        match self {
            Self::Run { key, error, .. } => error.run_fault(key),
            _ => None,
        }
    }

    /// What to do about it, where that is known.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::EmptySet(name) => {
                Some(format!("`{name}` kept no case; loosen its `keep`, or search longer"))
            }
            Self::TooFewCases(name, ..) => Some(format!("draw fewer, or let `{name}` vary or repeat more")),
            Self::Run { error, .. } => error.hint().map(str::to_string),
            Self::Plan(error) => error.hint.clone(),
            _ => None,
        }
    }
}
