//! One case from start to outcome.

use super::build::{RunError, nobody_asked};
use super::case_run::RunningCase;
use super::free_flow::FreeFlows;
use super::panic::in_case;
use results::{Outcome, Requests};
use scenario::Case;
use sim::{GivenCommand, Observer, Progress, RunChange, Step};

/// Runs one case and reads the requested metrics off it. `watcher` sees every step and changes nothing.
///
/// A pure function of the case, but for the wall time it notes.
///
/// # Panics
/// With a [`Panicked`](super::Panicked) that names the case, if a model does.
pub fn run_case(
    case: &Case,
    requests: &Requests,
    free_flows: &FreeFlows,
    watcher: &mut dyn Observer,
) -> Result<Outcome, RunError> {
    in_case(&case.key, || run(case, (None, false), requests, free_flows, watcher)).map(|(outcome, _)| outcome)
}

/// As [`run_case`], where something goes otherwise or commands are noted; with what each vehicle was told if they are.
pub(super) fn run_changed(
    case: &Case,
    otherwise: (Option<&RunChange>, bool),
    requests: &Requests,
    free_flows: &FreeFlows,
    watcher: &mut dyn Observer,
) -> Result<(Outcome, Vec<Vec<GivenCommand>>), RunError> {
    in_case(&case.key, || run(case, otherwise, requests, free_flows, watcher))
}

fn run(
    case: &Case,
    (change, notes_commands): (Option<&RunChange>, bool),
    requests: &Requests,
    free_flows: &FreeFlows,
    watcher: &mut dyn Observer,
) -> Result<(Outcome, Vec<Vec<GivenCommand>>), RunError> {
    let flows = free_flows.of(&case.world)?;
    let mut run = RunningCase::start(case, requests, &flows)?.otherwise(change, notes_commands);
    let fault = match run.go_on(watcher) {
        Ok(Progress::Ended(_)) => return Ok(run.outcome(case)),
        Ok(Progress::Waits) => {
            let waiting = run.course().asked().next().map_or(0, |(vehicle, _)| vehicle);
            run.course().fault(waiting, nobody_asked())
        }
        Err(fault) => fault,
    };
    Err(RunError::of_fault(&case.world, fault, false))
}

/// Sees nothing: for runs of which only the outcome matters.
pub struct Unwatched;

impl Observer for Unwatched {
    fn observe(&mut self, _step: &Step) {}
}
