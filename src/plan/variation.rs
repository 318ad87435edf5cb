//! Variations: the combinations of values that a scenario is run for.

use super::{derive_seed, sampling};
use crate::scenario::{Assignment, Scenario, Variation};

/// The combinations of a scenario's variations, made one by one.
pub struct Combinations {
    /// Per variation the values of its names; the last varies fastest.
    rows: Vec<Vec<Vec<Assignment>>>,
}

impl Combinations {
    /// `seed` is the suite's.
    pub fn new(seed: u64, scenario: &Scenario) -> Self {
        Self { rows: scenario.variations.iter().map(|variation| rows(seed, scenario, variation)).collect() }
    }

    /// At most [`usize::MAX`]; one empty combination without any variation.
    pub fn count(&self) -> usize {
        self.rows.iter().fold(1, |count, rows| count.saturating_mul(rows.len()))
    }

    /// The combination of that index below [`Self::count`].
    pub fn get(&self, mut index: usize) -> Vec<Assignment> {
        let mut parts: Vec<&[Assignment]> = Vec::with_capacity(self.rows.len());
        for rows in self.rows.iter().rev() {
            parts.push(&rows[index % rows.len()]);
            index /= rows.len();
        }
        parts.into_iter().rev().flatten().cloned().collect()
    }
}

/// Every combination of the scenario's variations, the last varying fastest. One empty combination without any.
pub fn expand(seed: u64, scenario: &Scenario) -> Vec<Vec<Assignment>> {
    let combinations = Combinations::new(seed, scenario);
    (0..combinations.count()).map(|index| combinations.get(index)).collect()
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
