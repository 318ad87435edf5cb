//! The courses of the runs that reports draw.

use std::collections::HashMap;
use std::collections::HashSet;

use super::shared::Runner;
use crate::run::{BatchError, RunBatch, Stop, Wanted, WentDifferently, went_differently};
use results::{Chosen, Outcome, Recording, SuiteReport, choose_runs};
use scenario::{Case, Criterion};

/// The courses of the runs to draw: they are run again. What comes out differently is another run than was judged, and is not drawn; where a
/// program may have decided otherwise, `notices` says so.
pub fn courses(
    runner: &Runner,
    reports: &[SuiteReport],
    notices: &mut Vec<String>,
) -> Result<Vec<(Chosen, Recording)>, String> {
    let chosen: Vec<Chosen> = reports.iter().flat_map(choose_runs).collect();
    let wanted: HashSet<&str> = chosen.iter().map(|chosen| chosen.key.as_str()).collect();
    let outcomes: HashMap<&str, (Case, &Outcome, &[Criterion])> = reports
        .iter()
        .zip(runner.suites())
        .flat_map(|(report, suite)| suite.plan.trials().zip(&report.trials))
        .flat_map(|(planned, trial)| {
            let outcomes = trial.outcomes.iter().enumerate();
            let chosen = outcomes.filter(|(_, outcome)| wanted.contains(outcome.key.as_str()));
            let criteria = &trial.trial.criteria[..];
            chosen
                .map(|(index, outcome)| (outcome.key.as_str(), (planned.cases.get(index), outcome, criteria)))
                .collect::<Vec<_>>()
        })
        .collect();
    let mut recordings = Vec::with_capacity(chosen.len());
    let (mut differs, mut made) = (None, 0);
    let case = |index: usize| outcomes[chosen[index].key.as_str()].0.clone();
    // Also of a session that was interrupted: what there is of it is drawn.
    let batch = RunBatch { stop: &Stop::default(), ..runner.batch() };
    let ended = batch.each(chosen.len(), Wanted::Details, case, |case, ran| {
        let chosen = &chosen[made];
        made += 1;
        let (_, outcome, criteria) = &outcomes[chosen.key.as_str()];
        if ran.outcome.fingerprint == outcome.fingerprint {
            let recording = Recording::new(&case, &ran.trace, ran.events).with(ran.details.as_deref());
            return recordings.push((chosen.clone(), recording.about(criteria, &batch.measured.requests)));
        }
        let not_drawn = |why: &str| {
            format!("{} is not drawn: it came out differently when it was repeated{why}", case.key)
        };
        match went_differently(&case) {
            WentDifferently::Bug(reason) => differs = differs.take().or(Some(reason)),
            WentDifferently::Program(reason) => notices.push(format!("{}\n  {reason}", not_drawn(""))),
            WentDifferently::Known => notices.push(not_drawn(", as its controller says of itself")),
        }
    });
    match (differs, ended) {
        (Some(reason), _) => Err(reason),
        (None, Err(BatchError::Run { error, .. })) if error.run_fault("").is_some() => {
            notices
                .push(format!("not all runs are drawn: one ended in a fault when it was repeated: {error}"));
            Ok(recordings)
        }
        (None, Err(BatchError::Run { error, .. })) => Err(error.to_string()),
        (None, Err(error)) => Err(error.to_string()),
        (None, Ok(())) => Ok(recordings),
    }
}
