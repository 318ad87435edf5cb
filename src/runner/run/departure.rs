//! Models that a world makes other ones than were published: what every report and baseline names.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::plan::{PlannedTrial, too_near_words};
use scenario::{Case, Departure, ModelSetup, Origin, Registered, Scenario, World};
use sim::{TooNear, too_near};

/// A road user whose model is another one than was published.
#[derive(Debug, Clone, PartialEq)]
pub struct Departing {
    /// Such as `walker`.
    pub who: String,
    pub departure: Departure,
    /// The first run in which it is.
    pub case: String,
    /// Of the model.
    pub origin: Origin,
}

/// Each of a world's, with the road user's name.
fn of_world(world: &World) -> Vec<(&str, Departure)> {
    let people = world.pedestrians.iter().flat_map(|person| {
        of_model(&person.model).into_iter().map(|departure| (person.name.as_str(), departure))
    });
    let cars = world.vehicles.iter().flat_map(|car| {
        of_model(&car.controller).into_iter().map(|departure| (car.name.as_str(), departure))
    });
    people.chain(cars).collect()
}

fn of_model<T: Registered>(setup: &ModelSetup<T>) -> Vec<Departure> {
    let declaration = setup.model.declaration();
    declaration.map(|declaration| declaration.departures(&setup.settings)).unwrap_or_default()
}

/// What is to be warned of in a trial, each thing once: `` `walker`: `dt` of `commotions` is … ``, and people who cannot wait where they set
/// out.
pub fn departures(trial: &PlannedTrial) -> Vec<String> {
    let mut said = Vec::new();
    let worlds = trial.cases.worlds();
    for world in &worlds {
        for (who, departure) in of_world(world) {
            let text = format!("`{who}`: {departure}");
            if !said.contains(&text) {
                said.push(text);
            }
        }
    }
    said.extend(without_room(&worlds));
    said
}

/// Every place from which people set out too near to a lane for waiting, of each the nearest.
fn without_room(worlds: &[Arc<World>]) -> Vec<String> {
    let mut nearest: BTreeMap<(usize, usize), (TooNear, &World, usize)> = BTreeMap::new();
    for world in worlds {
        for found in too_near(world) {
            let known = nearest.entry((found.pedestrian, found.refuge)).or_insert((found, world, 0));
            known.2 += 1;
            if found.missing() > known.0.missing() {
                (known.0, known.1) = (found, world);
            }
        }
    }
    let words = |(found, world, times): &(TooNear, &World, usize)| match *times == worlds.len() {
        true => too_near_words(world, found),
        false => format!("in {times} of {} worlds looked at {}", worlds.len(), too_near_words(world, found)),
    };
    nearest.values().map(words).collect()
}

/// Adds what departs in a case of a scenario to what was `found` in others, each thing once.
pub fn note_departing(scenario: &Scenario, case: &Case, found: &mut Vec<Departing>) {
    for (who, departure) in of_world(&case.world) {
        if found.iter().any(|known| known.who == who && known.departure == departure) {
            continue;
        }
        found.push(Departing {
            who: who.to_string(),
            departure,
            case: case.key.clone(),
            origin: model_origin(scenario, who).clone(),
        });
    }
}

/// Where the model of somebody is said.
pub fn model_origin<'a>(scenario: &'a Scenario, who: &str) -> &'a Origin {
    let cars = scenario.vehicles.iter().map(|car| (&car.name, &car.controller.origin));
    let people = scenario.pedestrians.iter().map(|person| (&person.name, &person.model.origin));
    cars.chain(people).find(|(name, _)| *name == who).map_or(&scenario.origin, |(_, origin)| origin)
}
