//! Models that a world makes other ones than were published: what every report and baseline names.

use std::sync::Arc;

use crate::plan::{NearestStart, PlannedTrial, nearest_starts, too_near_words};
use scenario::{Case, Departure, ModelSetup, Origin, Registered, Scenario, World};

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

/// What is to be warned of in a trial, each thing once: `` `walker`: `dt` of `commotions` is … ``, and pedestrians that cannot
/// wait where they set out.
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

/// Every place from which a pedestrian sets out too near to a lane for waiting.
fn without_room(worlds: &[Arc<World>]) -> impl Iterator<Item = String> {
    nearest_starts(worlds.iter().map(|world| &**world)).into_iter().map(
        |NearestStart { found, world, times }| {
            let words = too_near_words(&worlds[world], &found);
            match times == worlds.len() {
                true => words,
                false => format!("in {times} of {} worlds looked at {words}", worlds.len()),
            }
        },
    )
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
