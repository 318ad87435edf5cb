//! The runs of a search: which people it is for, what an evaluation runs, and how such a run is made again by its name.

use super::error::ExperimentError;
use super::overrides;
use crate::plan;
use numbers::random::derive_seed;
use optimise::{Coordinate, Range};
use scenario::{Assignment, Case, DeclaredPedestrian, Individual, Scenario, Search, Suite};

/// Runs with fresh seeds that tell how much of a best value was luck.
pub const FRESH_RUNS: u32 = 20;

/// What stands before the values of a point in the name of a run of an evaluation, by which it can be made again.
const AT_POINT: &str = "/at=";

/// People who are all in every evaluation, each of them one or several pedestrians.
pub type SearchedPeople = Vec<Vec<Individual>>;

/// A search with the scenario that it is of.
pub struct Searched<'a> {
    suite: &'a Suite,
    search: &'a Search,
    /// With the people of the search.
    pub scenario: Scenario,
}

impl<'a> Searched<'a> {
    pub fn new(suite: &'a Suite, search: &'a Search, declared: &Scenario) -> Self {
        Self { suite, search, scenario: with_individuals(declared, search) }
    }

    /// Everybody by themselves, or all together.
    pub fn groups(&self) -> Result<Vec<SearchedPeople>, ExperimentError> {
        let people = plan::select_people(self.suite.seed, &self.scenario)?;
        Ok(match self.search.together {
            true => vec![people],
            false => people.into_iter().map(|group| vec![group]).collect(),
        })
    }

    /// The beginning of the keys of a group's runs.
    pub fn name(&self, group: &[Vec<Individual>]) -> String {
        let label = if self.search.together { String::new() } else { plan::people_label(&group[0]) };
        format!("{}/{}{label}", self.suite.key_name(), self.search.name)
    }

    /// The cases of one evaluation: everybody, in every variation that is not searched, `runs` times.
    pub fn cases(
        &self,
        key: &str,
        group: &[Vec<Individual>],
        point: &[Coordinate],
        runs: u32,
    ) -> Result<Vec<Case>, ExperimentError> {
        let scenario = self.at(point)?;
        let fixed = overrides::assignments(&self.search.over, point);
        let mut cases = Vec::new();
        let seed = self.suite.seed;
        for combination in plan::combinations(seed, &scenario, plan::variables(&fixed))? {
            let variation: Vec<Assignment> = [fixed.clone(), combination].concat();
            let labels: String = variation
                .iter()
                .map(|assignment| format!("/{}={}", assignment.name, assignment.label))
                .collect();
            for people in group {
                let people_label =
                    if self.search.together { plan::people_label(people) } else { String::new() };
                for run in 1..=runs {
                    let key = format!("{key}{labels}{people_label}/rep={run}");
                    let seed = derive_seed(self.suite.seed, self.suite.own_key(&key));
                    let people = people.clone();
                    cases.push(plan::concrete_case(&scenario, key, variation.clone(), people, run, seed)?);
                }
            }
        }
        Ok(cases)
    }

    /// An evaluation with fresh seeds: that of a single run in the same encounter, whatever it drew; of several runs, as far as they share it.
    pub fn same_encounter(
        &self,
        key: &str,
        group: &SearchedPeople,
        point: &[Coordinate],
        cases: &[Case],
    ) -> Result<Vec<Case>, ExperimentError> {
        let key = format!("{key}/fresh");
        let [case] = cases else { return self.cases(&key, group, point, FRESH_RUNS) };
        let scenario = self.at(point)?;
        let variation: Vec<Assignment> = case.variation.iter().cloned().chain(case.drawn_values()).collect();
        let again = (1..=FRESH_RUNS).map(|run| {
            let key = format!("{key}/rep={run}");
            let seed = derive_seed(self.suite.seed, self.suite.own_key(&key));
            let (variation, people) = (variation.clone(), case.individuals.clone());
            Ok(plan::concrete_case(&scenario, key, variation, people, run, seed)?)
        });
        again.collect()
    }

    /// The scenario with what is set at a point, and without the variations that it gives values to.
    fn at(&self, point: &[Coordinate]) -> Result<Scenario, ExperimentError> {
        let mut scenario = overrides::without_variations(&self.scenario, &self.search.over);
        overrides::apply(&mut scenario, &overrides::settings(&self.search.over, point))?;
        Ok(scenario)
    }
}

/// How many groups of people a search is for, each of which is searched for by itself; 1 where that is not known.
pub fn searched_groups(suite: &Suite, search: &Search) -> usize {
    let mut scenarios = suite.scenarios.iter().chain(&suite.supporting);
    let declared = scenarios.find(|scenario| scenario.name == search.scenario);
    let groups = declared.and_then(|declared| Searched::new(suite, search, declared).groups().ok());
    groups.map_or(1, |groups| groups.len())
}

/// The name of a run of an evaluation with the values that it is of.
pub fn named_at(key: &str, point: &[Coordinate]) -> String {
    let values: Vec<String> = point.iter().map(ToString::to_string).collect();
    format!("{key}{AT_POINT}{}", values.join(","))
}

/// The run of an evaluation of a search of the suite by the name that results give it: `zebra/closest/evaluation=12/gap=3s/rep=1/at=3`.
pub fn searched_case(suite: &Suite, name: &str) -> Option<Case> {
    let (key, values) = name.rsplit_once(AT_POINT)?;
    let values: Vec<&str> = values.split(',').collect();
    suite.searches.iter().find_map(|search| {
        let scenarios = || suite.scenarios.iter().chain(&suite.supporting);
        let declared = scenarios().find(|scenario| scenario.name == search.scenario)?;
        let searched = Searched::new(suite, search, declared);
        let point = point(search, &values)?;
        let (beginning, rest) = key.split_once("/evaluation=")?;
        let evaluation = rest.split('/').next()?;
        let groups = searched.groups().ok()?;
        let group = groups.iter().find(|group| searched.name(group) == beginning)?;
        let evaluation = format!("{beginning}/evaluation={evaluation}");
        let cases = searched.cases(&evaluation, group, &point, search.runs).ok()?;
        let case = cases.into_iter().find(|case| case.key == key)?;
        Some(Case { key: name.to_string(), ..case })
    })
}

/// Values of what a search is over; `None` of others.
fn point(search: &Search, values: &[&str]) -> Option<Vec<Coordinate>> {
    if values.len() != search.over.len() {
        return None;
    }
    let each = search.over.iter().zip(values);
    let value = each.map(|(range, text)| match overrides::dimension(range).range {
        Range::Real { low, high } | Range::Log { low, high } => {
            let number: f64 = text.parse().ok()?;
            (low..=high).contains(&number).then_some(Coordinate::Real(number))
        }
        Range::Integer { low, high } => {
            let number: i64 = text.parse().ok()?;
            (low..=high).contains(&number).then_some(Coordinate::Integer(number))
        }
        Range::Categorical { choices } => {
            choices.iter().any(|one| one == text).then(|| Coordinate::Category((*text).to_string()))
        }
    });
    value.collect()
}

/// The scenario with the people whom the search says.
pub fn with_individuals(scenario: &Scenario, search: &Search) -> Scenario {
    let mut scenario = scenario.clone();
    if let Some(individuals) = &search.individuals {
        for pedestrian in scenario.pedestrians.iter_mut().filter(|one| one.individuals.is_some()) {
            pedestrian.individuals = Some(individuals.clone());
        }
        if scenario.pedestrians.iter().all(|one| one.individuals.is_none())
            && let Some(person) = likely_individual(&scenario.pedestrians)
        {
            let group = person.group.as_ref().map(|membership| membership.group.clone());
            let name = group.unwrap_or_else(|| person.name.clone());
            for one in scenario.pedestrians.iter_mut().filter(|one| one.is(&name)) {
                one.individuals = Some(individuals.clone());
            }
        }
    }
    scenario
}

/// The first pedestrian whose model takes individuals, or the first if none does.
fn likely_individual(people: &[DeclaredPedestrian]) -> Option<&DeclaredPedestrian> {
    let takes = |one: &&DeclaredPedestrian| {
        one.model.all().iter().all(|model| model.entry().is_some_and(|model| model.takes_individuals))
    };
    people.iter().find(takes).or(people.first())
}
