//! The courses of the runs that reports draw.

use std::collections::HashMap;
use std::collections::HashSet;

use super::shared::Runner;
use crate::run::{BatchError, RunBatch, Stop, Wanted, went_differently};
use results::{Chosen, Outcome, Recording, SuiteReport, choose_runs};
use scenario::Case;

/// The courses of the runs to draw: they are run again.
pub fn courses(runner: &Runner, reports: &[SuiteReport]) -> Result<Vec<(Chosen, Recording)>, String> {
    let chosen: Vec<Chosen> = reports.iter().flat_map(choose_runs).collect();
    let wanted: HashSet<&str> = chosen.iter().map(|chosen| chosen.key.as_str()).collect();
    let outcomes: HashMap<&str, (Case, &Outcome)> = reports
        .iter()
        .zip(runner.suites())
        .flat_map(|(report, suite)| suite.plan.trials().zip(&report.trials))
        .flat_map(|(planned, trial)| {
            let outcomes = trial.outcomes.iter().enumerate();
            let chosen = outcomes.filter(|(_, outcome)| wanted.contains(outcome.key.as_str()));
            chosen
                .map(|(index, outcome)| (outcome.key.as_str(), (planned.cases.get(index), outcome)))
                .collect::<Vec<_>>()
        })
        .collect();
    let mut recordings = Vec::with_capacity(chosen.len());
    let mut differs = None;
    let case = |index: usize| outcomes[chosen[index].key.as_str()].0.clone();
    // Also of a session that was interrupted: what there is of it is drawn.
    let batch = RunBatch { stop: &Stop::default(), ..runner.batch() };
    let made = batch.each(chosen.len(), Wanted::TraceAndEvents, case, |case, ran| {
        let chosen = &chosen[recordings.len()];
        if ran.outcome.fingerprint != outcomes[chosen.key.as_str()].1.fingerprint {
            differs = differs.take().or_else(|| went_differently(&case));
        }
        recordings.push((chosen.clone(), Recording::new(&case, &ran.trace, ran.events)));
    });
    match (differs, made) {
        (Some(reason), _) => Err(reason),
        (None, Err(BatchError::Run { error, .. })) => Err(error.to_string()),
        (None, Err(error)) => Err(error.to_string()),
        (None, Ok(())) => Ok(recordings),
    }
}
