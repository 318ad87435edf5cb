//! How usual the encounters of a search are, as its scenario declares them to be drawn: values, and people by the population that they
//! are of.

use std::collections::BTreeSet;

use crate::plan::{self, PlanError, Variables};
use numbers::distributions::{Tail, combined_tail};
use scenario::population::{HUMANS, Plausibility, SHIPPED_MODEL};
use scenario::{
    Case, DeclaredPedestrian, Part, PedestrianSetup, PopulationShare, Scenario, Search, Settings, Target,
};

/// What is known of how the encounters of a search are distributed.
pub struct PlausibleEncounters {
    scenario: Scenario,
    people: Vec<KnownPerson>,
    /// What the search chooses of encounters that nothing says the distribution of.
    undeclared: Vec<String>,
    /// Whether an evaluation is of several people in turn, whom its runs do not share.
    together: bool,
}

/// A pedestrian who is of a population, or of whom the search varies what a population says.
struct KnownPerson {
    name: String,
    /// Somebody else in every run.
    is_drawn: bool,
    /// Of the population that they are drawn from; else they are held against `humans`.
    own: Option<Option<Plausibility>>,
    /// Parameters that the scenario says by something that is drawn, which counts for itself.
    drawn_settings: Vec<String>,
    /// What the search varies of them.
    varied: Vec<String>,
}

/// What of an encounter counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartsCounted {
    /// All of it: of a single run.
    Whole,
    /// What the runs of an evaluation share; what each draws for itself is left to the mean over them.
    Shared,
}

/// How usual an encounter is.
#[derive(Debug, Clone, PartialEq)]
pub struct EncounterPlausibility {
    /// The share of all encounters that are no more usual.
    pub share: f64,
    /// The same of what it is made of, by name.
    pub parts: Vec<(String, f64)>,
}

impl PlausibleEncounters {
    /// Of the search in `scenario`, which has the people of the search, `together` if each evaluation is of several of them in turn. `None`
    /// where nothing says how usual any encounter is.
    ///
    /// # Errors
    /// If a population cannot be read.
    pub fn of(search: &Search, scenario: &Scenario, together: bool) -> Result<Option<Self>, PlanError> {
        let drawn: BTreeSet<&str> =
            scenario.draws.iter().flat_map(|draw| &draw.names).map(String::as_str).collect();
        let mut people = Vec::new();
        for person in &scenario.pedestrians {
            people.extend(known_person(search, person, &drawn)?);
        }
        let is_known = |target: &Target| match target {
            Target::Variation(name) => drawn.contains(name.as_str()),
            Target::Setting { road_user, part: Part::Model, .. } => {
                let mut who = scenario.pedestrians.iter().filter(|one| one.is(road_user));
                who.all(|one| people.iter().any(|known: &KnownPerson| known.name == one.name))
            }
            // What is tested, and not what it meets.
            Target::Setting { .. } => true,
        };
        let unknown = search.over.iter().filter(|range| !is_known(&range.target));
        let undeclared = unknown.map(|range| range.target.to_string()).collect();
        let is_anything = !scenario.draws.is_empty() || !people.is_empty();
        Ok(is_anything.then(|| Self { scenario: scenario.clone(), people, undeclared, together }))
    }

    /// The names of what counts, in order.
    pub fn parts(&self) -> Vec<String> {
        let draws = self.scenario.draws.iter().map(|draw| draw.names.join(", "));
        draws.chain(self.people.iter().map(|one| one.name.clone())).collect()
    }

    /// What the search chooses of encounters though nothing says how it is distributed.
    pub fn undeclared(&self) -> &[String] {
        &self.undeclared
    }

    /// The share of all encounters that are no more usual than a case. `None` where that cannot be said: of somebody of whom the population
    /// says nothing, or where what an evaluation shares hangs on what each of its runs draws.
    pub fn of_case(&self, case: &Case, counted: PartsCounted) -> Option<EncounterPlausibility> {
        let mut values: Variables = plan::variables(&case.variation);
        let given: BTreeSet<String> = values.keys().cloned().collect();
        for one in &case.drawn {
            values.entry(one.name.clone()).or_insert_with(|| one.value.clone());
        }
        let mut parts: Vec<(String, Tail)> = Vec::new();
        for draw in &self.scenario.draws {
            let is_given = draw.names.iter().any(|name| given.contains(name));
            if counted == PartsCounted::Shared {
                if !is_given {
                    continue;
                }
                let drawn = |name: &&str| {
                    !given.contains(*name)
                        && self.scenario.draws.iter().any(|one| one.names.iter().any(|own| own == name))
                };
                let own = draw.names.iter().map(String::as_str);
                if draw.depends_on().into_iter().chain(own).any(|name| drawn(&name)) {
                    return None;
                }
            }
            parts.push((draw.names.join(", "), draw.tail(&values).ok()?));
        }
        for known in &self.people {
            if counted == PartsCounted::Shared && (known.is_drawn || self.together) {
                if known.varied.is_empty() {
                    continue;
                }
                return None;
            }
            let setup = case.world.pedestrians.iter().find(|one| one.name == known.name)?;
            parts.push((known.name.clone(), Tail::of_density(known.tail(setup, case)?)));
        }
        let tails: Vec<Tail> = parts.iter().map(|one| one.1.clone()).collect();
        let share = combined_tail(&tails)?;
        Some(EncounterPlausibility {
            share,
            parts: parts.into_iter().map(|(name, tail)| (name, tail.share)).collect(),
        })
    }
}

/// Indices of the points that no other beats in both: none that is at least as usual is worse. The worst first; of equal ones the first.
/// Points are (badness, plausibility).
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    // The worst first, of those the most usual.
    order.sort_by(|one, other| {
        let ((bad, usual), (other_bad, other_usual)) = (points[*one], points[*other]);
        other_bad.total_cmp(&bad).then(other_usual.total_cmp(&usual)).then(one.cmp(other))
    });
    let mut most_usual = f64::NEG_INFINITY;
    order.retain(|index| {
        let is_more_usual = points[*index].1 > most_usual;
        most_usual = most_usual.max(points[*index].1);
        is_more_usual
    });
    order
}

/// The pedestrian, if a population says how usual they are.
fn known_person(
    search: &Search,
    person: &DeclaredPedestrian,
    drawn: &BTreeSet<&str>,
) -> Result<Option<KnownPerson>, PlanError> {
    let of_person = |target: &Target| match target {
        Target::Setting { road_user, part: Part::Model, parameter } if person.is(road_user) => {
            Some(parameter.clone())
        }
        _ => None,
    };
    let varied: Vec<String> = search.over.iter().filter_map(|range| of_person(&range.target)).collect();
    let is_shipped = person.model.all().iter().all(|model| model.name() == SHIPPED_MODEL);
    if person.individuals.is_none() && (varied.is_empty() || !is_shipped) {
        return Ok(None);
    }
    let of = person.individuals.as_ref().filter(|one| one.selection == PopulationShare::Drawn);
    let own = match of {
        Some(individuals) => Some(plan::plausibility_of(person, individuals)?),
        None => None,
    };
    let by_draws = person.model.settings.iter().filter(|(name, value)| {
        !varied.contains(name) && value.variables().iter().any(|name| drawn.contains(name))
    });
    Ok(Some(KnownPerson {
        name: person.name.clone(),
        is_drawn: of.is_some(),
        own,
        drawn_settings: by_draws.map(|(name, _)| name.clone()).collect(),
        varied,
    }))
}

impl KnownPerson {
    fn tail(&self, setup: &PedestrianSetup, case: &Case) -> Option<f64> {
        let model = &setup.model.model.known()?.declaration;
        let individual = case.individuals.iter().find(|one| one.pedestrian == self.name);
        let mut settings: Settings = setup.model.settings.clone();
        for name in &self.drawn_settings {
            match individual.and_then(|one| one.parameters.get(name)) {
                Some(value) => settings.0.insert(name.clone(), value.clone()),
                None => settings.0.remove(name),
            };
        }
        match &self.own {
            Some(own) => own.as_ref()?.tail(model, &settings),
            None => Plausibility::of_shipped(HUMANS, model)?.tail(model, &settings),
        }
    }
}
