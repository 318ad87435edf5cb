//! One run that failed, and the way back from it to a case.

use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::plan::{self, PlanError};
use numbers::random::digest_bits;
use results::{Outcome, Recorded};
use scenario::{Case, Criterion, PopulationShare, Suite, World};

/// Why a recorded run cannot be run any more.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Stale {
    /// Its scenario is gone, or has another name.
    #[error("there is no scenario `{0}` any more")]
    Scenario(String),
    /// One who walked in it is gone.
    #[error("the scenario has other people: `{pedestrian}` is no individual of `{population}` any more")]
    People {
        /// The pedestrian who they were, by name.
        pedestrian: String,
        /// Where they were drawn from.
        population: String,
    },
    /// Its values no longer go together.
    #[error("the scenario has changed: {0}")]
    Plan(#[from] PlanError),
    /// No criterion could fail.
    #[error("no criterion applies to it any more, so that nothing says whether it fails")]
    NothingClaimed,
}

/// The first eight bytes of SHA-256 over everything that decides a run: its world and its seed.
pub fn case_hash(case: &Case) -> u64 {
    let world = World { road: case.world.road.unnamed(), ..(*case.world).clone() };
    let text = serde_json::to_vec(&(&world, case.seed)).expect("plain data serialises");
    digest_bits(Sha256::new().chain_update(text))
}

/// What is kept of a run, and what it spoke against.
pub fn record(case: &Case, outcome: &Outcome, against: Vec<String>) -> Recorded {
    let person = |one: &scenario::Individual| (one.pedestrian.clone(), one.number, one.population.clone());
    Recorded {
        key: case.key.clone(),
        scenario: case.scenario.clone(),
        seed: case.seed,
        // With what was drawn, which is then no matter of a distribution that may have changed.
        variation: case.variation.iter().cloned().chain(case.drawn_values()).collect(),
        people: case.individuals.iter().map(person).collect(),
        case: case_hash(case),
        fingerprint: outcome.fingerprint,
        against,
    }
}

/// The case under its recorded key, with what the suite's scenario says today.
///
/// # Errors
/// If the scenario is gone or has changed too much.
pub fn revive(recorded: &Recorded, suite: &Suite) -> Result<Case, Stale> {
    let found = suite.scenarios.iter().find(|scenario| scenario.name == recorded.scenario);
    let mut scenario = found.ok_or_else(|| Stale::Scenario(recorded.scenario.clone()))?.clone();
    for (pedestrian, number, population) in &recorded.people {
        let individuals = scenario
            .pedestrians
            .iter_mut()
            .find(|one| one.name == *pedestrian)
            .and_then(|one| one.individuals.as_mut())
            .ok_or_else(|| other_people(pedestrian, population))?;
        individuals.selection = PopulationShare::Number(*number);
    }
    let people = plan::select_people(recorded.seed, &scenario)?.into_iter().next().unwrap_or_default();
    for (pedestrian, number, population) in &recorded.people {
        let is_it = |one: &scenario::Individual| {
            one.pedestrian == *pedestrian && one.number == *number && one.population == *population
        };
        if !people.iter().any(is_it) {
            return Err(other_people(pedestrian, population));
        }
    }
    let repetition =
        recorded.key.rsplit_once("/rep=").and_then(|(_, number)| number.parse().ok()).unwrap_or(1);
    let (key, variation) = (recorded.key.clone(), recorded.variation.clone());
    Ok(plan::concrete_case(&scenario, key, variation, people, repetition, recorded.seed)?)
}

/// What the suite demands of such a run.
///
/// # Errors
/// If the scenario is gone or has changed too much, or demands nothing any more.
pub fn criteria(recorded: &Recorded, suite: &Suite) -> Result<Vec<Criterion>, Stale> {
    let found = suite.scenarios.iter().find(|scenario| scenario.name == recorded.scenario);
    let scenario = found.ok_or_else(|| Stale::Scenario(recorded.scenario.clone()))?;
    let criteria = plan::criteria(scenario, &plan::variables(&recorded.variation))?;
    if criteria.is_empty() { Err(Stale::NothingClaimed) } else { Ok(criteria.to_vec()) }
}

fn other_people(pedestrian: &str, population: &str) -> Stale {
    Stale::People { pedestrian: pedestrian.to_string(), population: population.to_string() }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use files::Disk;
    use models::standard;
    use scenario::Body;

    #[test]
    fn what_a_box_is_called_is_no_part_of_a_case_and_where_it_stands_is() {
        let path =
            Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenarios/zebra/carla_walker.scn");
        let suite =
            lang::load(&path, &standard(), &Disk).unwrap_or_else(|_| panic!("it is a scenario")).suite;
        let mut case = plan::plan(&suite).unwrap().trial(0).cases.first();
        let mut hash = |name: &str, x: f64| {
            let body = Body { name: name.into(), x, y: -3.2, length: 4.5, width: 1.8, heading: 0.0 };
            Arc::make_mut(&mut case.world).road.boxes = vec![body];
            case_hash(&case)
        };
        let unnamed = hash("", -9.0);
        assert_eq!(hash("van", -9.0), unnamed);
        assert_ne!(hash("van", -9.5), unnamed);
    }
}
