//! A few runs of a scenario that stand for all.

use super::error::PlanError;
use super::lazily::{ScenarioPlan, probe_scenario};
use scenario::{Case, Scenario, Suite};

/// Runs of a scenario that stand for all: the first person in every combination of variations (or the first 10,000), or where runs draw
/// up to `most` of them, spread over all combinations.
///
/// # Errors
/// The first thing that is not possible.
pub fn sample_scenario(suite: &Suite, scenario: &Scenario, most: usize) -> Result<Vec<Case>, PlanError> {
    let probed = probe_scenario(suite, scenario)?;
    if !scenario.is_drawn() {
        return Ok(probed.iter().map(|trial| trial.cases.first()).collect());
    }
    let plan = ScenarioPlan::new(suite, scenario)?;
    let trials = plan.len().min(most).max(1);
    let runs = plan.runs().min((most / trials).max(1));
    let case = |run: usize| plan.trial((run % trials) * plan.len() / trials).cases.get(run / trials);
    Ok((0..trials * runs).map(case).filter(|case| case.impossible.is_none()).collect())
}
