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
    let each = plan.runs().min((most / plan.len()).max(1));
    let all = plan.len().saturating_mul(each).min(most);
    let runs = (0..all).map(|run| plan.trial(run % plan.len()).cases.get(run / plan.len()));
    Ok(runs.filter(|case| case.impossible.is_none()).collect())
}
