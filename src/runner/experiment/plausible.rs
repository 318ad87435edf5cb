//! How usual the people of a search's cases are: where they stand in the population of people who do what people did.

use std::sync::OnceLock;

use scenario::population::{HUMANS, Plausibility, Population};
use scenario::{Case, Part, PedestrianModel, Scenario, Search, Settings, Target};

/// The people of a search of whom it can be said.
pub struct PlausiblePeople {
    /// By name: those who are of a population, or of whom the search varies a parameter.
    who: Vec<String>,
    /// Worked out when the first is asked for.
    humans: OnceLock<Option<Plausibility>>,
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
        Self { who: who.map(|one| one.name.clone()).collect(), humans: OnceLock::new() }
    }

    /// Of the least usual of them in a case, 0 to 1; `None` where nothing is known of any.
    pub fn of_case(&self, case: &Case) -> Option<f64> {
        let people = case.world.pedestrians.iter().filter(|one| self.who.contains(&one.name));
        people.filter_map(|one| self.tail(one.model.model.known()?, &one.model.settings)).reduce(f64::min)
    }

    fn tail(&self, model: &PedestrianModel, person: &Settings) -> Option<f64> {
        if self.humans.get().is_none() {
            // A model that knows no such people leaves them to the one that does.
            let humans = Population::parse(HUMANS, None, &model.declaration, None).ok()?;
            self.humans.get_or_init(|| Plausibility::of(&humans));
        }
        self.humans.get()?.as_ref()?.tail(&model.declaration, person)
    }
}
