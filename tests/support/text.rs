//! Scenarios as texts: what they come to, the run of the first, and what is measured of it.

use files::Memory;
use models::standard;
use results::Requests;
use runner::plan::plan;
use runner::run::{FreeFlows, Unwatched, run_case};
use scenario::{Case, Suite};
use sim::StopReason;

/// What a text says, or what is wrong with it.
pub fn checked(text: &str) -> Result<Suite, String> {
    let files = Memory::default().with("text.scn", text);
    lang::load("text.scn".as_ref(), &standard(), &files)
        .map(|loaded| loaded.suite)
        .map_err(|failure| format!("{:?}", failure.diagnostics))
}

/// What a text says that is right.
pub fn loaded(text: &str) -> Suite {
    checked(text).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

/// The first run of the first trial of a text, or what keeps it from being planned.
pub fn planned(text: &str) -> Result<Case, String> {
    let suite = checked(text)?;
    let plan = plan(&suite).map_err(|errors| format!("{:?}", errors[0]))?;
    Ok(plan.trial(0).cases.first())
}

/// The first run of the first trial of a text that is right.
pub fn case(text: &str) -> Case {
    planned(text).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

/// What came of a run.
#[derive(Debug, PartialEq)]
pub struct Measured {
    /// What was measured, by the names of metrics.
    pub values: Vec<(String, Option<f64>)>,
    /// Of all its bits.
    pub fingerprint: u64,
    /// Why it ended and when, s.
    pub ending: (StopReason, f64),
}

impl Measured {
    /// The value of the metric of that name.
    pub fn of(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("{name} is no metric")).1
    }
}

/// Everything that is measured by default of the run of a text.
pub fn measured(text: &str) -> Measured {
    let requests = Requests::defaults(&standard());
    let outcome = run_case(&case(text), &requests, &FreeFlows::default(), &mut Unwatched)
        .unwrap_or_else(|error| panic!("{text}\n{error}"));
    let names = requests.iter().map(|request| request.metric.name().to_string());
    Measured {
        values: names.zip(outcome.metrics.iter().copied()).collect(),
        fingerprint: outcome.fingerprint,
        ending: (outcome.ending.reason, outcome.ending.time),
    }
}

/// One metric of the run of a text.
pub fn of(text: &str, name: &str) -> Option<f64> {
    measured(text).of(name)
}
