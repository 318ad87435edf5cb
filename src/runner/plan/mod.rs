//! From a checked suite to its trials and cases: variations, individuals, repetitions and seeds.

mod check;
mod individuals;
mod lazily;
mod meeting;
mod overlap;
mod sampling;
mod setup;
mod standalone;
mod variation;

use std::collections::BTreeMap;
use std::sync::Arc;

use thiserror::Error;

use scenario::{
    Assignment, Case, Criterion, Expression, Individual, Origin, Rounds, RunBudget, Scenario, Suite, Value,
};

pub use individuals::{label as people_label, select as select_people};
pub use lazily::{Cases, PlannedTrial, ScenarioPlan, plan_scenario};
pub(crate) use lazily::{Outline, outline, probe_scenario};
pub use standalone::standalone;
pub(crate) use variation::expand as combinations;

/// Everything that a suite asks to run. Its trials and their runs are worked out when somebody asks for them, and not kept: there
/// may be millions.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The suite's name.
    pub suite: String,
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

/// Why a suite cannot be planned; found only once variations have their values.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{message}{}", case.as_ref().map(|case| format!(", in {case}")).unwrap_or_default())]
pub struct PlanError {
    /// What is wrong, in a sentence without a full stop.
    pub message: String,
    /// What to do about it, if that is known.
    pub hint: Option<String>,
    /// The run or trial whose values are at fault, where it is one's alone.
    pub case: Option<String>,
    /// Where what is wrong is declared.
    pub origin: Box<Origin>,
}

impl PlanError {
    /// An error at a place, of no run in particular.
    pub fn new(origin: &Origin, message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None, case: None, origin: Box::new(origin.clone()) }
    }

    /// What was found wrong is so in this run or trial.
    pub fn in_case(self, key: &str) -> Self {
        Self { case: self.case.or_else(|| Some(key.to_string())), ..self }
    }

    /// With what to do about it.
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}

/// The values of a trial's variations.
pub type Variables = BTreeMap<String, Value>;

/// Plans every run of a suite, and finds that each is possible. All errors are returned, not only the first.
pub fn plan(suite: &Suite) -> Result<Plan, Vec<PlanError>> {
    let mut scenarios = Vec::new();
    let mut errors = Vec::new();
    for scenario in &suite.scenarios {
        match plan_scenario(suite, scenario) {
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

/// Whole rounds: at least as many runs as asked for, and not more than may be.
fn rounds(scenario: &Scenario, budget: &RunBudget, people: usize) -> Result<Rounds, PlanError> {
    let (least, most) = (budget.least as usize, budget.most as usize);
    let most = most / people * people;
    let least = least.div_ceil(people) * people;
    if most < least {
        let message = format!(
            "`runs {} .. {}` hold no whole round of the {people} individuals of scenario `{}`",
            budget.least, budget.most, scenario.name
        );
        let enough = (budget.least as usize).div_ceil(people) * people;
        return Err(PlanError::new(&budget.origin, message).with_hint(format!(
            "everybody walks once a round: say at least `runs {} .. {enough}`",
            budget.least
        )));
    }
    Ok(Rounds { size: people, least, most })
}

/// One run of a scenario in which these variations have their values and these people walk.
pub fn concrete_case(
    scenario: &Scenario,
    key: String,
    variation: Vec<Assignment>,
    individuals: Vec<Individual>,
    repetition: u32,
    seed: u64,
) -> Result<Case, PlanError> {
    let world = setup::world(scenario, &variables(&variation), &individuals);
    let world = Arc::new(world.map_err(|error| error.in_case(&key))?);
    Ok(Case { key, scenario: scenario.name.clone(), variation, individuals, repetition, seed, world })
}

/// The values of variations by name.
pub fn variables(variation: &[Assignment]) -> Variables {
    variation.iter().map(|assignment| (assignment.name.clone(), assignment.value.clone())).collect()
}

/// The criteria that apply where `variables` hold, with their bounds evaluated.
///
/// # Errors
/// If a bound cannot be evaluated.
pub fn criteria(scenario: &Scenario, variables: &Variables) -> Result<Vec<Criterion>, PlanError> {
    let mut applying = Vec::new();
    for criterion in &scenario.criteria {
        let failed = |error: scenario::EvaluationError| {
            PlanError::new(&criterion.origin, format!("in `{}`: {error}", criterion.text))
        };
        let mut applies = true;
        for condition in &criterion.when {
            applies &= condition.holds(variables).map_err(failed)?;
        }
        if applies {
            let mut criterion = criterion.clone();
            // The last step may end beyond the horizon.
            let longest = scenario.horizon + scenario.step;
            criterion.reach.limits = {
                let reference = criterion.claim.metric();
                reference.known().and_then(|metric| metric.limits(&reference.settings, longest))
            };
            for bound in criterion.claim.bounds_mut() {
                *bound = Expression::Constant(bound.evaluate(variables).map_err(failed)?);
            }
            applying.push(criterion);
        }
    }
    Ok(applying)
}
