//! From a checked suite to its trials and cases: variations, individuals, repetitions and seeds.

mod check;
mod individuals;
mod overlap;
mod sampling;
mod setup;
mod standalone;
mod variation;

use std::collections::{BTreeMap, HashSet};
use std::ops::Deref;
use std::sync::Arc;

use thiserror::Error;

use crate::numbers::random::derive_seed;
use crate::scenario::{
    Assignment, Case, Criterion, Expression, Individual, Origin, Rounds, RunBudget, Scenario, Suite, Trial,
    Value,
};

pub use individuals::{label as people_label, select as select_people};
pub use standalone::standalone;
use variation::Combinations;
pub use variation::expand as combinations;

/// Everything that a suite asks to run.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub suite: String,
    pub seed: u64,
    /// What was set on the command line: `av.speed=40km/h`.
    pub set: Vec<String>,
    /// Wall-clock limit per trial in s.
    pub time_limit: Option<f64>,
    pub trials: Vec<PlannedTrial>,
    /// Digests of everybody in the populations, by the names of their files.
    pub populations: BTreeMap<String, String>,
}

/// A trial with its runs.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedTrial {
    pub trial: Arc<Trial>,
    /// One per individual and repetition; never empty. Where runs are added until the criteria are decided, all that there
    /// may be, in that order.
    pub cases: Vec<Case>,
}

impl Deref for PlannedTrial {
    type Target = Trial;

    fn deref(&self) -> &Trial {
        &self.trial
    }
}

/// Why a suite cannot be planned; found only once variations have their values.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{message}{}", case.as_ref().map(|case| format!(", in {case}")).unwrap_or_default())]
pub struct PlanError {
    pub message: String,
    pub hint: Option<String>,
    /// The run or trial whose values are at fault, where it is one's alone.
    pub case: Option<String>,
    pub origin: Box<Origin>,
}

impl PlanError {
    pub fn new(origin: &Origin, message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None, case: None, origin: Box::new(origin.clone()) }
    }

    /// What was found wrong is so in this run or trial.
    pub fn in_case(self, key: &str) -> Self {
        Self { case: self.case.or_else(|| Some(key.to_string())), ..self }
    }

    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}

/// The values of a trial's variations.
pub type Variables = BTreeMap<String, Value>;

/// More runs than this in one suite are taken for a mistake.
const MOST_RUNS: usize = 10_000_000;

/// Lists every run of a suite. All errors are returned, not only the first.
pub fn plan(suite: &Suite) -> Result<Plan, Vec<PlanError>> {
    let mut trials = Vec::new();
    let mut errors = Vec::new();
    for scenario in &suite.scenarios {
        match plan_scenario(suite, scenario) {
            Ok(more) => trials.extend(more),
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
            trials,
            populations,
        })
    } else {
        Err(errors)
    }
}

/// A trial before its runs are worked out: what it is called, how many runs it has, what is asked of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    pub key: String,
    pub variation: Vec<Assignment>,
    /// All that there may be.
    pub runs: usize,
    /// As [`Trial::rounds`].
    pub rounds: Option<Rounds>,
    /// As [`Trial::criteria`].
    pub criteria: Vec<Criterion>,
}

/// The trials of one scenario in a suite, without working out their worlds.
pub fn outline(suite: &Suite, scenario: &Scenario) -> Result<Vec<Outline>, PlanError> {
    outline_with(suite, scenario, select_people(suite.seed, scenario)?.len())
}

fn outline_with(suite: &Suite, scenario: &Scenario, people: usize) -> Result<Vec<Outline>, PlanError> {
    let mut variations = Combinations::new(suite.seed, scenario, Variables::new())?;
    let rounds = scenario.runs.as_ref().map(|budget| rounds(scenario, budget, people)).transpose()?;
    let runs = rounds.map_or(people.saturating_mul(scenario.repeat as usize), |rounds| rounds.most);
    let all = variations.count().saturating_mul(runs);
    if all > MOST_RUNS {
        let message = format!("scenario `{}` asks for {all} runs, more than {MOST_RUNS}", scenario.name);
        return Err(
            PlanError::new(&scenario.origin, message).with_hint("vary fewer values or repeat less often")
        );
    }
    let mut keys = HashSet::new();
    (0..variations.count())
        .map(|index| {
            let variation = variations.get(index)?;
            let mut key = format!("{}/{}", suite.name, scenario.name);
            for assignment in &variation {
                key.push_str(&format!("/{}={}", assignment.name, assignment.label));
            }
            if !keys.insert(key.clone()) {
                let message = format!("scenario `{}` has two trials named `{key}`", scenario.name);
                return Err(PlanError::new(&scenario.origin, message).with_hint("list every value once"));
            }
            let criteria = criteria(scenario, &variables(&variation)).map_err(|error| error.in_case(&key))?;
            Ok(Outline { key, variation, runs, rounds, criteria })
        })
        .collect()
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

/// The trials of one scenario in a suite.
pub fn plan_scenario(suite: &Suite, scenario: &Scenario) -> Result<Vec<PlannedTrial>, PlanError> {
    trials(suite, scenario, true)
}

/// A few runs of a scenario that show what can be wrong with all of them: the first person in every combination of
/// variations (or the first 10,000), everybody in the first combination, nothing repeated.
pub fn probe_scenario(suite: &Suite, scenario: &Scenario) -> Result<Vec<PlannedTrial>, PlanError> {
    trials(suite, scenario, false)
}

/// More combinations than this are not tried out before a run.
const MOST_PROBES: usize = 10_000;

fn trials(suite: &Suite, scenario: &Scenario, whole: bool) -> Result<Vec<PlannedTrial>, PlanError> {
    let people = select_people(suite.seed, scenario)?;
    let most = if whole { usize::MAX } else { MOST_PROBES };
    let trial = |(index, Outline { key, variation, runs, rounds, criteria })| {
        let repetitions = if whole { (runs / people.len()) as u32 } else { 1 };
        let people = if whole || index == 0 { &people[..] } else { &people[..1] };
        let variables = variables(&variation);
        let worlds = people
            .iter()
            .map(|person| {
                let world = setup::world(scenario, &variables, person);
                world.map(Arc::new).map_err(|error| error.in_case(&format!("{key}{}", people_label(person))))
            })
            .collect::<Result<Vec<_>, PlanError>>()?;
        let case = |who: usize, repetition: u32| {
            let key = format!("{key}{}/rep={repetition}", people_label(&people[who]));
            Case {
                seed: match scenario.seed {
                    Some(seed) if repetition == 1 => seed,
                    own => derive_seed(own.unwrap_or(suite.seed), &key),
                },
                key,
                scenario: scenario.name.clone(),
                variation: variation.clone(),
                individuals: people[who].clone(),
                repetition,
                world: worlds[who].clone(),
            }
        };
        let everybody = 0..people.len();
        let order: Vec<(usize, u32)> = match rounds {
            Some(_) => (1..=repetitions)
                .flat_map(|repetition| everybody.clone().map(move |who| (who, repetition)))
                .collect(),
            None => {
                everybody.flat_map(|who| (1..=repetitions).map(move |repetition| (who, repetition))).collect()
            }
        };
        let cases: Vec<Case> = order.into_iter().map(|(who, repetition)| case(who, repetition)).collect();
        let trial = Arc::new(Trial {
            scenario: scenario.name.clone(),
            doc: scenario.doc.clone(),
            tags: scenario.tags.clone(),
            runs: cases.len(),
            first_run: cases.first().map(|case| case.key.clone()).unwrap_or_default(),
            rounds: rounds.filter(|_| whole),
            criteria,
            declared: scenario.criteria.len(),
            key,
            variation,
            origin: scenario.origin.clone(),
        });
        Ok(PlannedTrial { trial, cases })
    };
    outline_with(suite, scenario, people.len())?.into_iter().take(most).enumerate().map(trial).collect()
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
        let failed = |error: crate::scenario::EvaluationError| {
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
