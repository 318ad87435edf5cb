//! Variations: the combinations of values that a scenario is run for.

use super::{PlanError, Variables, sampling};
use crate::numbers::random::derive_seed;
use crate::scenario::{Assignment, DistributionError, Samples, Scenario, Variation};

/// Per run of a variation the values of its names.
type Rows = Vec<Vec<Assignment>>;

/// The combinations of a scenario's variations, made one by one.
pub struct Combinations<'a> {
    scenario: &'a Scenario,
    /// What a variation may depend on though the scenario does not vary it (any more).
    given: Variables,
    /// The last varies fastest.
    variations: Vec<Varying<'a>>,
}

/// One variation.
enum Varying<'a> {
    Rows(Rows),
    /// Draws that depend on the variations before: those for the combination of them that was asked for last, which is that of
    /// the next one as well, until all of its draws have been had.
    Drawn {
        seed: u64,
        names: &'a [String],
        samples: &'a Samples,
        known: Option<(usize, Rows)>,
    },
}

impl Varying<'_> {
    fn count(&self) -> usize {
        match self {
            Self::Rows(rows) => rows.len(),
            Self::Drawn { samples, .. } => samples.count as usize,
        }
    }
}

impl<'a> Combinations<'a> {
    /// `seed` is the suite's.
    ///
    /// # Errors
    /// If nothing can be drawn from a distribution.
    pub fn new(seed: u64, scenario: &'a Scenario, given: Variables) -> Result<Self, PlanError> {
        let varying = |variation: &'a Variation| match variation {
            Variation::Grid { names, rows } => {
                let value = |(name, varied): (&String, &crate::scenario::VariedValue)| Assignment {
                    name: name.clone(),
                    label: varied.label.clone(),
                    value: varied.value.clone(),
                };
                let row = |row: &Vec<_>| names.iter().zip(row).map(value).collect();
                Ok(Varying::Rows(rows.iter().map(row).collect()))
            }
            Variation::Sampled { names, samples } => {
                let seed = derive_seed(seed, &format!("{}/{}", scenario.name, names.join("+")));
                if variation.depends_on().iter().all(|name| names.iter().any(|own| own == name)) {
                    let rows = sampling::draw(seed, names, samples, &given);
                    return rows.map(Varying::Rows).map_err(|error| refused(scenario, error));
                }
                Ok(Varying::Drawn { seed, names, samples, known: None })
            }
        };
        let variations = scenario.variations.iter().map(varying).collect::<Result<_, _>>()?;
        Ok(Self { scenario, given, variations })
    }

    /// At most [`usize::MAX`]; one empty combination without any variation.
    pub fn count(&self) -> usize {
        self.variations.iter().fold(1, |count, variation| count.saturating_mul(variation.count()))
    }

    /// The combination of that index below [`Self::count`].
    ///
    /// # Errors
    /// If nothing can be drawn from a distribution with the values that it depends on.
    pub fn get(&mut self, index: usize) -> Result<Vec<Assignment>, PlanError> {
        let mut rest = self.count();
        let depends = self.variations.iter().any(|one| matches!(one, Varying::Drawn { .. }));
        let mut known = if depends { self.given.clone() } else { Variables::new() };
        let mut combination: Vec<Assignment> = Vec::new();
        for variation in &mut self.variations {
            let before = index / rest;
            rest /= variation.count();
            let row = index / rest % variation.count();
            let values = match variation {
                Varying::Rows(rows) => &rows[row],
                Varying::Drawn { seed, names, samples, known: drawn } => {
                    if drawn.as_ref().is_none_or(|(of, _)| *of != before) {
                        let rows = sampling::draw(*seed, names, samples, &known);
                        *drawn = Some((before, rows.map_err(|error| refused(self.scenario, error))?));
                    }
                    &drawn.as_ref().expect("it was drawn just now").1[row]
                }
            };
            if depends {
                known.extend(values.iter().map(|one| (one.name.clone(), one.value.clone())));
            }
            combination.extend(values.iter().cloned());
        }
        Ok(combination)
    }
}

fn refused(scenario: &Scenario, (name, error): (String, DistributionError)) -> PlanError {
    let origin = scenario.written.get(&name).map_or(&scenario.origin, |written| &written.origin);
    PlanError::new(origin, format!("`{name}` cannot be drawn: {error}"))
        .with_hint("let its numbers fit for all values of what they depend on")
}

/// Every combination of the scenario's variations, the last varying fastest. One empty combination without any. `given` are values
/// of what the scenario does not vary, though a variation may depend on it.
///
/// # Errors
/// If nothing can be drawn from a distribution.
pub fn expand(seed: u64, scenario: &Scenario, given: Variables) -> Result<Vec<Vec<Assignment>>, PlanError> {
    let mut combinations = Combinations::new(seed, scenario, given)?;
    (0..combinations.count()).map(|index| combinations.get(index)).collect()
}
