//! Why an experiment has no result.

use std::path::PathBuf;

use thiserror::Error;

use crate::plan::PlanError;
use crate::run::RunError;
use results::RunFault;

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
    /// Nobody can be weighed, or nobody does what people did.
    #[error("{reason}")]
    Calibration {
        /// What is wrong, with numbers.
        reason: String,
        /// What to do about it.
        hint: Option<String>,
    },
    /// A probability cannot be estimated.
    #[error("{0}")]
    Estimate(String),
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
    /// With what `try` sets, a tuned parameter still has no value, or not the same one in all cases.
    #[error("`try` of {0} leaves a tuned parameter without one value for all cases")]
    PartialTry(String),
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
    /// The same error of a run, which says what was evaluated.
    pub(super) fn evaluating(self, what: impl FnOnce() -> String) -> Self {
        match self {
            Self::Run { key, error, .. } => Self::Run { values: what(), key, error },
            other => other,
        }
    }

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
            Self::PartialTry(_) => Some("set every parameter of `over` in it".to_string()),
            Self::Plan(error) => error.hint.clone(),
            Self::Calibration { hint, .. } => hint.clone(),
            _ => None,
        }
    }
}
