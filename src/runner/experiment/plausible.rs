//! How usual the people of a search's cases are: where they stand in the population of people who do what people did.

use scenario::population::{HUMANS, Plausibility};
use scenario::{Case, Part, PedestrianSetup, Scenario, Search, Target};

/// The people of a search of whom it can be said.
pub struct PlausiblePeople {
    /// By name: those who are of a population, or of whom the search varies a parameter.
    who: Vec<String>,
}

impl PlausiblePeople {
    pub fn of(search: &Search, scenario: &Scenario) -> Self {
        let is_varied = |name: &str| {
            search.over.iter().any(|range| match &range.target {
                Target::Setting { road_user, part: Part::Model, .. } => road_user == name,
                _ => false,
            })
        };
        let people = scenario.pedestrians.iter();
        let who = people.filter(|one| one.individuals.is_some() || is_varied(&one.name));
        Self { who: who.map(|one| one.name.clone()).collect() }
    }

    /// Of the least usual of them in a case, 0 to 1; `None` where nothing is known of any.
    pub fn of_case(&self, case: &Case) -> Option<f64> {
        let people = case.world.pedestrians.iter().filter(|one| self.who.contains(&one.name));
        let tail = |one: &PedestrianSetup| {
            let model = &one.model.model.known()?.declaration;
            Plausibility::of_shipped(HUMANS, model)?.tail(model, &one.model.settings)
        };
        people.filter_map(tail).reduce(f64::min)
    }
}
