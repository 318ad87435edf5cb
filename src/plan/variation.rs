//! Variations: the combinations of values that a scenario is run for.

use super::{derive_seed, sampling};
use crate::scenario::{Assignment, Scenario, Variation};

/// Every combination of the scenario's variations, the last varying fastest. One empty combination without any.
pub fn expand(seed: u64, scenario: &Scenario) -> Vec<Vec<Assignment>> {
    let mut combinations = vec![Vec::new()];
    for variation in &scenario.variations {
        let rows = rows(seed, scenario, variation);
        let mut longer = Vec::with_capacity(combinations.len().saturating_mul(rows.len()));
        for combination in &combinations {
            longer.extend(rows.iter().map(|row| [combination.as_slice(), row].concat()));
        }
        combinations = longer;
    }
    combinations
}

fn rows(seed: u64, scenario: &Scenario, variation: &Variation) -> Vec<Vec<Assignment>> {
    match variation {
        Variation::Grid { names, rows } => rows
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
            .collect(),
        Variation::Sampled { names, samples } => sampling::draw(
            derive_seed(seed, &format!("{}/{}", scenario.name, names.join("+"))),
            names,
            samples,
        ),
    }
}
