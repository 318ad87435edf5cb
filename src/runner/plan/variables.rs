//! The values of a trial's variations, and the criteria that apply where they hold.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::error::PlanError;
use scenario::{Assignment, Criterion, EvaluationError, Expression, Origin, Scenario, Value};

/// The values of a trial's variations.
pub type Variables = BTreeMap<String, Value>;

/// The values of variations by name.
pub fn variables(variation: &[Assignment]) -> Variables {
    variation.iter().map(|assignment| (assignment.name.clone(), assignment.value.clone())).collect()
}

/// The criteria of every trial of a scenario; `None` if they depend on what it varies.
pub fn criteria_of_all(scenario: &Scenario) -> Option<Arc<[Criterion]>> {
    let depends = |one: &Criterion| {
        !one.when.is_empty() || one.claim.bounds().iter().any(|bound| !bound.variables().is_empty())
    };
    let is_same = !scenario.criteria.iter().any(depends);
    is_same.then(|| criteria(scenario, &Variables::new()).ok()).flatten()
}

/// The criteria that apply where `variables` hold, with their bounds evaluated.
///
/// # Errors
/// If a bound cannot be evaluated.
pub fn criteria(scenario: &Scenario, variables: &Variables) -> Result<Arc<[Criterion]>, PlanError> {
    let mut applying = Vec::new();
    for criterion in &scenario.criteria {
        let failed = |error: EvaluationError| {
            PlanError::new(&criterion.origin, format!("in `{}`: {error}", criterion.text))
        };
        let mut applies = true;
        for condition in &criterion.when {
            applies &= condition.holds(variables).map_err(failed)?;
        }
        if applies {
            let mut criterion = criterion.clone();
            criterion.reach.drawn_people = scenario.draws_people();
            // The last step may end beyond the horizon.
            let longest = scenario.horizon + scenario.step;
            criterion.reach.limits = {
                let reference = criterion.claim.metric();
                reference.known().and_then(|metric| metric.limits(&reference.settings, longest))
            };
            for bound in criterion.claim.bounds_mut() {
                *bound = Expression::Constant(bound.evaluate(variables).map_err(failed)?);
            }
            applying.push(criterion);
        }
    }
    Ok(applying.into())
}

/// The number of an expression of a place in the file, where these hold.
pub(super) fn number(
    expression: &Expression,
    variables: &Variables,
    origin: &Origin,
) -> Result<f64, PlanError> {
    expression.evaluate_number(variables).map_err(|error| PlanError::new(origin, error.to_string()))
}
