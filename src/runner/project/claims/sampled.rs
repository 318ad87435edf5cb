//! Runs that stand for all runs of the scenarios in which pedestrians look, or start where they may have to wait.

use crate::plan;
use scenario::{Case, DeclaredMayGo, DeclaredPedestrian, LookEffect, Scenario, Suite};

/// So many drawn runs of a scenario are looked at, at most.
const MOST_DRAWN: usize = 400;

/// A scenario with runs that stand for all of its runs.
pub struct SampledScenario<'s> {
    pub scenario: &'s Scenario,
    pub runs: Vec<Case>,
}

/// The scenarios with a pedestrian that looks, believes what it has seen, or cannot wait everywhere. What cannot be planned is left to planning.
pub fn sample(suite: &Suite) -> Vec<SampledScenario<'_>> {
    let is_concerned = |person: &DeclaredPedestrian| {
        let mut models = person.model.all().iter().filter_map(|model| model.known());
        let looks = person.may_go != DeclaredMayGo::AtOnce;
        looks || models.any(|model| model.keeps_off.is_some() || model.look == LookEffect::Counts)
    };
    let scenarios = suite.scenarios.iter().filter(|one| one.pedestrians.iter().any(is_concerned));
    let sampled = scenarios.filter_map(|scenario| {
        Some(SampledScenario { scenario, runs: plan::sample_scenario(suite, scenario, MOST_DRAWN).ok()? })
    });
    sampled.collect()
}
