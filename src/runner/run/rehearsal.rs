//! What keeps a checked suite from running, found before its first run: planning, and building the road users.

use std::collections::HashMap;

use super::build::{RunError, road_users};
use crate::plan::{self, Plan, PlanError, PlannedTrial, ScenarioPlan};
use scenario::{Case, Origin, Scenario, Suite};

/// Something that no run gets past.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    pub stage: Stage,
    pub message: String,
    pub hint: Option<String>,
    /// The first run or trial that meets it, such as `zebra/x/tta=6s/rep=1`, and how many of those tried meet it too;
    /// none where it is about the whole scenario.
    pub met: Option<(String, usize)>,
    pub origin: Origin,
}

/// Where in a suite's life an obstacle stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    Planning,
    Building,
}

/// Plans a few runs of every scenario (as [`plan::probe_scenario`] does) and builds the road users of each.
pub fn rehearse(suite: &Suite) -> Vec<Obstacle> {
    let mut obstacles = Vec::new();
    for scenario in &suite.scenarios {
        match plan::probe_scenario(suite, scenario) {
            Ok(trials) => {
                obstacles.extend(refusals(scenario, trials.iter().flat_map(|trial| trial.cases.iter())))
            }
            Err(PlanError { message, hint, case, origin }) => {
                let met = case.map(|key| (key, 1));
                obstacles.push(Obstacle { stage: Stage::Planning, message, hint, met, origin: *origin });
            }
        }
    }
    obstacles
}

/// What models refuse of trials that are planned already: in the first run of each, and everybody's in the first.
pub fn rehearse_trials(plan: &Plan) -> Vec<Obstacle> {
    let of_scenario = |planned: &ScenarioPlan| {
        let first: Vec<Case> = planned.trials().take(1).flat_map(|trial| everybody(&trial)).collect();
        let others = planned.trials().skip(1).map(|trial| trial.cases.first());
        refusals(planned.scenario(), first.into_iter().chain(others))
    };
    plan.scenarios().iter().flat_map(of_scenario).collect()
}

/// The first run of everybody.
fn everybody(trial: &PlannedTrial) -> Vec<Case> {
    trial.cases.iter().filter(|case| case.repetition == 1).collect()
}

/// Every refusal once, at the model that refuses.
fn refusals(scenario: &Scenario, cases: impl Iterator<Item = Case>) -> Vec<Obstacle> {
    let mut obstacles: Vec<Obstacle> = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    for case in cases {
        let Err(error) = road_users(&case.world, case.seed) else { continue };
        let message = error.told(scenario);
        if let Some((_, times)) = known.get(&message).and_then(|index| obstacles[*index].met.as_mut()) {
            *times += 1;
            continue;
        }
        known.insert(message.clone(), obstacles.len());
        obstacles.push(Obstacle {
            stage: Stage::Building,
            message,
            hint: error.hint().map(str::to_string),
            met: Some((case.key.clone(), 1)),
            origin: place(scenario, &error).clone(),
        });
    }
    obstacles
}

/// Where the model is said that refuses.
fn place<'a>(scenario: &'a Scenario, error: &RunError) -> &'a Origin {
    let RunError::Model { who, .. } = error else { return &scenario.origin };
    let cars = scenario.vehicles.iter().map(|car| (&car.name, &car.controller.origin));
    let walkers = scenario.pedestrians.iter().map(|walker| (&walker.name, &walker.model.origin));
    cars.chain(walkers).find(|(name, _)| *name == who).map_or(&scenario.origin, |(_, origin)| origin)
}

impl Obstacle {
    /// Which runs meet it, in words.
    pub fn note(&self) -> Option<String> {
        self.met.as_ref().map(|(key, times)| match times {
            1 => format!("in {key}"),
            2 => format!("in {key} and one more"),
            _ => format!("in {key} and {} more", times - 1),
        })
    }
}
