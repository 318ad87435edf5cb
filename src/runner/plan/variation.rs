//! Variations: the combinations of values that a scenario is run for, each made when somebody asks for it.

use std::borrow::Cow;
use std::sync::{Arc, Mutex, PoisonError};

use super::error::PlanError;
use super::sampling::{self, Drawn};
use super::variables::Variables;
use numbers::random::derive_seed;
use scenario::{Assignment, DistributionError, Samples, Scenario, Variation, VariedValue};

/// The combinations of a scenario's variations.
#[derive(Debug)]
pub struct Combinations<'a> {
    scenario: Cow<'a, Scenario>,
    /// What a variation may depend on though the scenario does not vary it (any more).
    given: Variables,
    /// One per variation; the last varies fastest.
    draws: Vec<Draws>,
}

/// What of a variation is drawn.
#[derive(Debug)]
enum Draws {
    /// Nothing: its values are listed.
    None,
    /// All of its draws, which depend on nothing that varies.
    Once(Drawn),
    /// Draws that depend on the variations before: those for the combination of them that was asked for last, which is that of
    /// the next one as well, until all of its draws have been had.
    Each { seed: u64, last: Mutex<Option<(usize, Arc<Drawn>)>> },
}

impl<'a> Combinations<'a> {
    /// `seed` is the suite's.
    ///
    /// # Errors
    /// If nothing can be drawn from a distribution.
    pub fn new(seed: u64, scenario: Cow<'a, Scenario>, given: Variables) -> Result<Self, PlanError> {
        let draws = |variation: &Variation| match variation {
            Variation::Grid { .. } => Ok(Draws::None),
            Variation::Sampled { names, samples } => {
                let seed = derive_seed(seed, &format!("{}/{}", scenario.name, names.join("+")));
                if variation.depends_on().iter().all(|name| names.iter().any(|own| own == name)) {
                    let drawn = sampling::draw(seed, names, samples, &given);
                    return drawn.map(Draws::Once).map_err(|error| refused(&scenario, error));
                }
                Ok(Draws::Each { seed, last: Mutex::default() })
            }
        };
        let draws = scenario.variations.iter().map(draws).collect::<Result<_, _>>()?;
        Ok(Self { scenario, given, draws })
    }

    /// Whether each is worked out by itself; else those that follow each other share work.
    pub fn are_independent(&self) -> bool {
        self.draws.iter().all(|one| !matches!(one, Draws::Each { .. }))
    }

    /// Whose they are.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// At most [`usize::MAX`]; one empty combination without any variation.
    pub fn count(&self) -> usize {
        self.scenario.variations.iter().fold(1, |all, variation| all.saturating_mul(values(variation)))
    }

    /// The combination of that index below [`Self::count`].
    ///
    /// # Errors
    /// If nothing can be drawn from a distribution with the values that it depends on.
    pub fn get(&self, index: usize) -> Result<Vec<Assignment>, PlanError> {
        let mut rest = self.count();
        let depends = self.draws.iter().any(|one| matches!(one, Draws::Each { .. }));
        let mut known = if depends { self.given.clone() } else { Variables::new() };
        let mut combination: Vec<Assignment> = Vec::new();
        for (variation, draws) in self.scenario.variations.iter().zip(&self.draws) {
            let before = index / rest;
            rest /= values(variation);
            let row = index / rest % values(variation);
            let own = match (variation, draws) {
                (Variation::Grid { names, rows }, _) => {
                    let value = |(name, varied): (&String, &VariedValue)| Assignment {
                        name: name.clone(),
                        label: varied.label.clone(),
                        value: varied.value.clone(),
                    };
                    names.iter().zip(&rows[row]).map(value).collect()
                }
                (Variation::Sampled { names, samples }, Draws::Once(drawn)) => {
                    self.row(drawn, row, names, samples, &self.given)?
                }
                (Variation::Sampled { names, samples }, Draws::Each { seed, last }) => {
                    let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
                    let drawn = match &*last {
                        Some((of, drawn)) if *of == before => drawn.clone(),
                        _ => {
                            let drawn = sampling::draw(*seed, names, samples, &known);
                            let drawn = Arc::new(drawn.map_err(|error| refused(&self.scenario, error))?);
                            *last = Some((before, drawn.clone()));
                            drawn
                        }
                    };
                    drop(last);
                    self.row(&drawn, row, names, samples, &known)?
                }
                (Variation::Sampled { .. }, Draws::None) => Vec::new(),
            };
            if depends {
                known.extend(own.iter().map(|one| (one.name.clone(), one.value.clone())));
            }
            combination.extend(own);
        }
        Ok(combination)
    }

    fn row(
        &self,
        drawn: &Drawn,
        row: usize,
        names: &[String],
        samples: &Samples,
        known: &Variables,
    ) -> Result<Vec<Assignment>, PlanError> {
        drawn.row(row, names, samples, known).map_err(|error| refused(&self.scenario, error))
    }
}

/// How many values a variation has.
fn values(variation: &Variation) -> usize {
    match variation {
        Variation::Grid { rows, .. } => rows.len(),
        Variation::Sampled { samples, .. } => samples.count as usize,
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
    let combinations = Combinations::new(seed, Cow::Borrowed(scenario), given)?;
    (0..combinations.count()).map(|index| combinations.get(index)).collect()
}
