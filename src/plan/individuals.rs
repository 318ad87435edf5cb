//! Which individuals of a population a scenario is run with.

use super::PlanError;
use crate::scenario::{Individual, Scenario};

/// The groups of people that the scenario is run with; one empty group when nobody is an individual.
pub fn select(_seed: u64, scenario: &Scenario) -> Result<Vec<Vec<Individual>>, PlanError> {
    let declared = scenario.pedestrians.iter().find_map(|pedestrian| pedestrian.individuals.as_ref());
    match declared {
        None => Ok(vec![Vec::new()]),
        Some(individuals) => Err(PlanError::new(&individuals.origin, "individuals are not available yet")),
    }
}

/// The part of a case's key that names its people: empty without, `/individual=17` with one.
pub fn label(people: &[Individual]) -> String {
    match people {
        [] => String::new(),
        [only] => format!("/individual={}", only.number),
        several => {
            let names: Vec<_> = several.iter().map(|p| format!("{}={}", p.pedestrian, p.number)).collect();
            format!("/{}", names.join("+"))
        }
    }
}
