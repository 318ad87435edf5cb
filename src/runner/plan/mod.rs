//! From a checked suite to its trials and cases: variations, individuals, repetitions and seeds.

mod arrival;
mod check;
mod drawable;
mod draws;
mod error;
mod individuals;
mod junctions;
mod lazily;
mod meeting;
mod overlap;
mod places;
mod sample;
mod sampling;
mod setup;
mod standalone;
mod streams;
mod too_near;
mod unobserved;
mod variables;
mod variation;

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;
use scenario::{Assignment, Case, Individual, Scenario, Suite};

pub use arrival::past_arrival_words;
pub(crate) use check::LOOKS_TOO_LONG;
pub use draws::DrawAxis;
use draws::RunDraws;
pub use error::PlanError;
pub(crate) use individuals::plausibility_of;
pub use individuals::{label as people_label, select as select_people};
pub use lazily::{Cases, PlannedTrial, ScenarioPlan, plan_scenario};
pub(crate) use lazily::{Outline, cut_off_draws, outline, probe_scenario};
pub(crate) use sample::sample_scenario;
pub use standalone::standalone;
pub(crate) use too_near::{NearestStart, nearest_starts, to_a_millimetre, too_near_words};
pub(crate) use unobserved::people_used;
pub use variables::{Variables, criteria, variables};
pub(crate) use variation::expand as combinations;

/// Everything that a suite asks to run. Its trials and their runs are worked out when somebody asks for them, and not kept: there
/// may be millions.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The suite's name.
    pub suite: String,
    /// As [`Suite::apart`].
    pub apart: String,
    /// What the seed of every run is derived from.
    pub seed: u64,
    /// What was set on the command line: `av.speed=40km/h`.
    pub set: Vec<String>,
    /// Wall-clock limit per trial in s.
    pub time_limit: Option<f64>,
    /// Digests of everybody in the populations, by the names of their files.
    pub populations: BTreeMap<String, String>,
    scenarios: Vec<ScenarioPlan>,
}

impl Plan {
    /// How many trials there are.
    pub fn len(&self) -> usize {
        self.scenarios.iter().map(ScenarioPlan::len).sum()
    }

    /// Whether nothing is to be run.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Every trial, scenario after scenario.
    pub fn trials(&self) -> impl Iterator<Item = PlannedTrial> {
        self.scenarios.iter().flat_map(ScenarioPlan::trials)
    }

    /// The trial with this index below [`Self::len`].
    pub fn trial(&self, index: usize) -> PlannedTrial {
        let mut rest = index;
        for scenario in &self.scenarios {
            if rest < scenario.len() {
                return scenario.trial(rest);
            }
            rest -= scenario.len();
        }
        panic!("there is no trial {index} of {}", self.len());
    }

    /// What is planned of each scenario.
    pub fn scenarios(&self) -> &[ScenarioPlan] {
        &self.scenarios
    }
}

/// Plans every run of a suite, and finds that each is possible. All errors are returned, not only the first.
pub fn plan(suite: &Suite) -> Result<Plan, Vec<PlanError>> {
    let mut scenarios = Vec::new();
    let mut errors = Vec::new();
    let planned = suite.scenarios.par_iter().map(|scenario| plan_scenario(suite, scenario));
    for one in planned.collect::<Vec<_>>() {
        match one {
            Ok(one) => scenarios.push(one),
            Err(error) => errors.push(error),
        }
    }
    let populations = individuals::populations(suite).unwrap_or_else(|error| {
        // Unless that is why the scenario could not be planned.
        if errors.is_empty() {
            errors.push(error);
        }
        BTreeMap::new()
    });
    if errors.is_empty() {
        Ok(Plan {
            suite: suite.name.clone(),
            apart: suite.apart.clone(),
            seed: suite.seed,
            set: suite.set.clone(),
            time_limit: suite.time_limit,
            scenarios,
            populations,
        })
    } else {
        Err(errors)
    }
}

/// One run of a scenario in which these variations have their values and these people walk. What the scenario draws besides comes from
/// the run's seed; a draw that has a value among the variations is not drawn.
pub fn concrete_case(
    scenario: &Scenario,
    key: String,
    variation: Vec<Assignment>,
    individuals: Vec<Individual>,
    repetition: u32,
    seed: u64,
) -> Result<Case, PlanError> {
    let values = variables(&variation);
    let (drawn, individuals, world) = match RunDraws::of(scenario, &values, &individuals)? {
        Some(draws) => {
            let run =
                draws.run(scenario, &values, &individuals, seed).map_err(|error| error.in_case(&key))?;
            (run.1.drawn, run.1.individuals, run.1.world)
        }
        None => {
            let world = setup::world(scenario, &values, &individuals)
                .and_then(|world| arrival::check_arrivals(scenario, &world).map(|()| world))
                .map_err(|error| error.in_case(&key))?;
            (Vec::new(), individuals, Arc::new(world))
        }
    };
    let scenario = scenario.name.clone();
    Ok(Case { key, scenario, variation, drawn, impossible: None, individuals, repetition, seed, world })
}
