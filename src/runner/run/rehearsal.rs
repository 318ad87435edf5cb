//! What keeps a checked suite from running, found before its first run: planning, and building the road users.

use std::collections::HashMap;

use rayon::prelude::*;

use super::build::{RunError, road_users};
use super::departure::{Departing, model_origin, note_departing};
use crate::plan::{self, Plan, PlanError, PlannedTrial, ScenarioPlan};
use lang::Code;
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

/// What a few runs of every scenario show before any is made.
#[derive(Debug, Default)]
pub struct Rehearsal {
    /// Every one once, at the model that refuses.
    pub obstacles: Vec<Obstacle>,
    /// Models that are others than were published.
    pub departing: Vec<Departing>,
}

/// Plans a few runs of every scenario (as [`plan::probe_scenario`] does) and builds the road users of each.
pub fn rehearse(suite: &Suite) -> Rehearsal {
    let of_scenario = |scenario| match plan::probe_scenario(suite, scenario) {
        Ok(trials) => Rehearsal::of(scenario, trials.iter().flat_map(|trial| trial.cases.iter())),
        Err(PlanError { message, hint, case, origin }) => {
            let met = case.map(|key| (key, 1));
            let obstacle = Obstacle { stage: Stage::Planning, message, hint, met, origin: *origin };
            Rehearsal { obstacles: vec![obstacle], departing: Vec::new() }
        }
    };
    suite.scenarios.par_iter().map(of_scenario).collect::<Vec<_>>().into_iter().collect()
}

/// The same of trials that are planned already: of the first run of each, and everybody's in the first.
pub fn rehearse_trials(plan: &Plan) -> Rehearsal {
    let of_scenario = |planned: &ScenarioPlan| {
        let first: Vec<Case> = planned.trials().take(1).flat_map(|trial| everybody(&trial)).collect();
        let others = planned.trials().skip(1).map(|trial| trial.cases.first());
        Rehearsal::of(planned.scenario(), first.into_iter().chain(others))
    };
    plan.scenarios().par_iter().map(of_scenario).collect::<Vec<_>>().into_iter().collect()
}

impl FromIterator<Rehearsal> for Rehearsal {
    fn from_iter<I: IntoIterator<Item = Rehearsal>>(each: I) -> Self {
        let mut all = Self::default();
        for Self { obstacles, departing } in each {
            all.obstacles.extend(obstacles);
            all.departing.extend(departing);
        }
        all
    }
}

/// The first run of everybody.
fn everybody(trial: &PlannedTrial) -> Vec<Case> {
    trial.cases.iter().filter(|case| case.repetition == 1).collect()
}

impl Rehearsal {
    fn of(scenario: &Scenario, cases: impl Iterator<Item = Case>) -> Self {
        let mut found = Self::default();
        let mut known: HashMap<String, usize> = HashMap::new();
        for case in cases {
            note_departing(scenario, &case, &mut found.departing);
            let Err(error) = road_users(&case.world, case.seed) else { continue };
            let message = error.told(scenario);
            if let Some((_, times)) =
                known.get(&message).and_then(|index| found.obstacles[*index].met.as_mut())
            {
                *times += 1;
                continue;
            }
            known.insert(message.clone(), found.obstacles.len());
            found.obstacles.push(Obstacle {
                stage: Stage::Building,
                message,
                hint: error.hint().map(str::to_string),
                met: Some((case.key.clone(), 1)),
                origin: place(scenario, &error).clone(),
            });
        }
        found
    }
}

/// Where the model is said that refuses.
fn place<'a>(scenario: &'a Scenario, error: &RunError) -> &'a Origin {
    let RunError::Model { who, .. } = error else { return &scenario.origin };
    model_origin(scenario, who)
}

impl Obstacle {
    /// The code of what it is.
    pub fn code(&self) -> Code {
        match self.stage {
            Stage::Planning => Code::CannotBePlanned,
            Stage::Building => Code::CannotBeBuilt,
        }
    }

    /// Which runs meet it, in words.
    pub fn note(&self) -> Option<String> {
        self.met.as_ref().map(|(key, times)| match times {
            1 => format!("in {key}"),
            2 => format!("in {key} and one more"),
            _ => format!("in {key} and {} more", times - 1),
        })
    }
}
