//! Variations: the grid of values that a scenario is run for.

use super::PlanError;
use crate::scenario::{Assignment, Scenario, Variation};

/// Every combination of the scenario's variations, the last varying fastest. One empty combination without any.
pub fn expand(_seed: u64, scenario: &Scenario) -> Result<Vec<Vec<Assignment>>, PlanError> {
    let mut combinations = vec![Vec::new()];
    for variation in &scenario.variations {
        let rows = rows(scenario, variation)?;
        let mut longer = Vec::with_capacity(combinations.len().saturating_mul(rows.len()));
        for combination in &combinations {
            longer.extend(rows.iter().map(|row| [combination.as_slice(), row].concat()));
        }
        combinations = longer;
    }
    Ok(combinations)
}

fn rows(scenario: &Scenario, variation: &Variation) -> Result<Vec<Vec<Assignment>>, PlanError> {
    match variation {
        Variation::Grid { names, rows } => Ok(rows
            .iter()
            .map(|row| {
                names
                    .iter()
                    .zip(row)
                    .map(|(name, varied)| Assignment {
                        name: name.clone(),
                        label: varied.label.clone(),
                        value: varied.value.clone(),
                    })
                    .collect()
            })
            .collect()),
        Variation::Sampled { names, .. } => {
            let message = format!("sampled variation of {} is not available yet", names.join(", "));
            Err(PlanError::new(&scenario.origin, message))
        }
    }
}
