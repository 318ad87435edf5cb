//! What keeps a search from running, found before its first evaluation: ranges with values that a scenario cannot have.

use super::{overrides, searched};
use crate::plan::{self, PlanError};
use crate::run::{Obstacle, Stage};
use optimise::Space;
use scenario::{Case, Individual, Scenario, Search, Suite};

/// Plans a run at both ends of each range of every search, all other values where a run is possible, and if that is so for each,
/// where the ends of several come together.
pub fn rehearse_searches(suite: &Suite) -> Vec<Obstacle> {
    suite.searches.iter().flat_map(|search| rehearse(suite, search).unwrap_or_default()).collect()
}

/// Runs at the middle and at the ends of what a search can try, where they are possible.
pub fn search_ends(suite: &Suite, search: &Search) -> Vec<Case> {
    let runs = || {
        let declared = suite.scenarios.iter().find(|scenario| scenario.name == search.scenario)?;
        let scenario = searched::with_individuals(declared, search);
        let people = plan::select_people(suite.seed, &scenario).ok()?.into_iter().next()?;
        let space = overrides::space(&search.over).ok()?;
        let dimensions = search.over.len();
        let points = std::iter::once(vec![0.5; dimensions]).chain(corners(dimensions));
        let run = |point: Vec<f64>| attempt(suite, &scenario, search, &people, &space, &point).ok().flatten();
        Some(points.filter_map(run).collect())
    };
    runs().unwrap_or_default()
}

/// `None` where something else is wrong, which is found elsewhere.
fn rehearse(suite: &Suite, search: &Search) -> Option<Vec<Obstacle>> {
    let declared = suite.scenarios.iter().find(|scenario| scenario.name == search.scenario)?;
    let scenario = searched::with_individuals(declared, search);
    let people = plan::select_people(suite.seed, &scenario).ok()?.into_iter().next()?;
    let space = overrides::space(&search.over).ok()?;
    let fails = |point: &[f64]| attempt(suite, &scenario, search, &people, &space, point).err();
    let dimensions = search.over.len();
    let obstacle = |error: PlanError, origin| Obstacle {
        stage: Stage::Planning,
        message: error.message,
        hint: error.hint,
        met: error.case.map(|case| (case, 1)),
        origin,
    };
    let middle = vec![0.5; dimensions];
    let somewhere = [middle.clone(), vec![0.0; dimensions], vec![1.0; dimensions]];
    let Some(possible) = somewhere.into_iter().find(|point| fails(point).is_none()) else {
        // Unless the scenario cannot be planned with its own values either.
        plan::probe_scenario(suite, declared).ok()?;
        return fails(&middle).map(|error| vec![obstacle(error, search.origin.clone())]);
    };
    let mut obstacles = Vec::new();
    for (index, range) in search.over.iter().enumerate() {
        let at = |end: f64| {
            let mut point = possible.clone();
            point[index] = end;
            fails(&point)
        };
        let error = at(0.0).or_else(|| at(1.0));
        obstacles.extend(error.map(|error| obstacle(error, range.origin.clone())));
    }
    if obstacles.is_empty() {
        let error = corners(dimensions).find_map(|corner| fails(&corner));
        obstacles.extend(error.map(|error| obstacle(error, search.origin.clone())));
    }
    Some(obstacles)
}

/// Every combination of low and high ends, or of many ranges the low and the high ends of all.
fn corners(dimensions: usize) -> impl Iterator<Item = Vec<f64>> {
    const MOST_COMBINED: usize = 6;
    let combined = dimensions <= MOST_COMBINED;
    let count: usize = if combined { 1 << dimensions } else { 2 };
    (0..count).map(move |corner| {
        let is_high = |dimension: usize| (corner >> if combined { dimension } else { 0 }) & 1 == 1;
        (0..dimensions).map(|dimension| f64::from(u8::from(is_high(dimension)))).collect()
    })
}

/// Plans the first run at a point of the unit cube; `None` where the search itself is wrong.
fn attempt(
    suite: &Suite,
    scenario: &Scenario,
    search: &Search,
    people: &[Individual],
    space: &Space,
    unit: &[f64],
) -> Result<Option<Case>, PlanError> {
    let point = space.point(unit);
    let mut scenario = overrides::without_variations(scenario, &search.over);
    // That there is such a setting was checked with the search.
    if overrides::apply(&mut scenario, &overrides::settings(&search.over, &point)).is_err() {
        return Ok(None);
    }
    let fixed = overrides::assignments(&search.over, &point);
    let combinations = plan::combinations(suite.seed, &scenario, plan::variables(&fixed))?;
    let Some(combination) = combinations.into_iter().next() else { return Ok(None) };
    let variation = [fixed, combination].concat();
    let shown = search.over.iter().zip(&point).map(|(range, value)| {
        let name = &range.target;
        let shown = value.number().map(|number| range.shown_in().show(number).replace(' ', ""));
        format!("/{name}={}", shown.unwrap_or_else(|| value.to_string()))
    });
    let key = format!("{}/{}{}", suite.key_name(), search.name, shown.collect::<String>());
    plan::concrete_case(&scenario, key, variation, people.to_vec(), 1, suite.seed).map(Some)
}
