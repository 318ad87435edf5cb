//! `estimate`: how probable an event is in a scenario that draws. A method says at which points runs are wanted, runs are made there, and
//! what they weigh is what the points would be drawn with over what they were drawn with.
//!
//! What is drawn is perturbed; the noise inside of models is not: every run has noise of its own, named by its number. Splitting takes the
//! noise along from run to run, or has it drawn anew.

mod compared;
mod conclude;
mod judged;
mod record;
mod sampled;
mod scored_run;

use super::context::{BlockProgress, Context};
use super::error::ExperimentError;
use crate::plan::{self, Cases, PlanError};
use crate::run::MeasuredMetrics;
use conclude::conclude;
use numbers::random::derive_seed;
use numbers::rare::{
    CrudeSampling, ImportanceSampling, RareAxis, RareOutcome, RarePoint, RareSampling, RareScale, RareSpace,
    SplittingSampling,
};
use rayon::prelude::*;
use record::EstimateRecord;
use results::judge::{Seen, cut_off_runs, has_encounter};
use results::{EstimateResult, Outcome, Requests};
use sampled::{Sampled, Told};
use scenario::{Case, Estimate, EstimateMethod, Scenario, Worst};
use scored_run::{ScoredEncounter, ScoredRun};

/// Runs that are made, kept and told together.
const TOGETHER: usize = 2000;

/// Estimates the probability of an event.
///
/// # Errors
/// Where the scenario cannot be planned, or a run cannot be made: what is missing would be missing in the probability.
pub fn run_estimate(
    context: &Context,
    block: &Estimate,
    progress: &dyn BlockProgress,
) -> Result<EstimateResult, ExperimentError> {
    let failed = |what: String| ExperimentError::Estimate(what);
    let scenario = as_often(context.scenario(&block.scenario)?, block.encounters());
    let cases = one_trial(context, &scenario)?;
    let space = space(&cases);
    let compared = match &block.compared_with {
        Some(with) => {
            let with = as_often(context.scenario(with)?, block.encounters());
            let others = one_trial(context, &with)?.with_chance_of(&scenario.name);
            if others.axes() != cases.axes() || others.axis_weights() != cases.axis_weights() {
                return Err(failed(format!("`{}` and `{}` do not draw the same", scenario.name, with.name)));
            }
            Some((with, others))
        }
        None => None,
    };
    let seed = derive_seed(context.suite.seed, &format!("estimate/{}", block.name));
    let budget = block.encounters() as usize;
    let (mut method, scale): (Box<dyn RareSampling>, RareScale) = match block.method {
        EstimateMethod::Importance => {
            (Box::new(ImportanceSampling::new(space.clone(), budget, seed)), RareScale::Logarithmic)
        }
        EstimateMethod::Splitting => {
            (Box::new(SplittingSampling::new(space.clone(), budget, seed)), RareScale::Logarithmic)
        }
        EstimateMethod::Crude => {
            (Box::new(CrudeSampling::new(space.clone(), budget, seed)), RareScale::Exact)
        }
    };
    let with = compared.as_ref().map(|(with, _)| with);
    let inputs = (block, context.suite.seed, &scenario, with);
    let mut record = EstimateRecord::open(context.journals.as_deref(), &block.name, &inputs)
        .map_err(|error| failed(format!("its journal: {error}")))?;
    context.tell(record.notice.as_deref());
    let mut requests = Requests::default();
    requests.add(&block.event.metric);
    block.score.iter().for_each(|score| requests.add(score));
    let others = compared.as_ref().map(|(_, others)| others);
    let runs = Runs { context, block, cases: &cases, others, measured: MeasuredMetrics::new(requests) };

    // Each encounter is one run of one scenario, or one of each of two.
    let of_each = if others.is_some() { 2 } else { 1 };
    let all = of_each * method.budget();
    let mut told = Told::default();
    while let Some(round) = context.executor.think(|| method.ask()) {
        let mut seen: Vec<ScoredEncounter> = Vec::with_capacity(round.points.len());
        for points in round.points.chunks(TOGETHER) {
            let first = told.encounters() + seen.len();
            let known = record.known(first, points.len()).cloned();
            let made = match known {
                Some(known) => known,
                None => {
                    let made = runs.make(first, points)?;
                    record.add(first, &made).map_err(|error| failed(format!("its journal: {error}")))?;
                    made
                }
            };
            seen.extend(made);
            let done = of_each * (told.encounters() + seen.len());
            let sampled =
                Sampled { cases: &cases, others, space: &space, method: method.as_ref(), scale, told: &told };
            match sampled.so_far() {
                Some((value, within)) => progress.evaluated_within(done, all, value, within),
                None => progress.evaluated(done, all, None),
            }
        }
        told.add(round.is_pilot, &seen);
        let outcomes: Vec<RareOutcome> = seen.into_iter().map(ScoredEncounter::outcome).collect();
        context.executor.think(|| method.tell(&outcomes));
    }
    let sampled =
        Sampled { cases: &cases, others, space: &space, method: method.as_ref(), scale, told: &told };
    let result = conclude(context, block, &sampled)?;
    record.remove();
    Ok(result)
}

/// The runs of a scenario, of which there is one trial with one group of people.
fn one_trial(context: &Context, scenario: &Scenario) -> Result<Cases, ExperimentError> {
    let failed = |what: String| ExperimentError::Estimate(what);
    let name = &scenario.name;
    let plan = plan::plan_scenario(context.suite, scenario)?;
    if plan.len() != 1 {
        return Err(failed(format!("`{name}` has {} trials, and a probability is of one", plan.len())));
    }
    let cases = plan.trial(0).cases;
    if cases.len() != scenario.repeat as usize {
        return Err(failed(format!("`{name}` has several groups of people, and a probability is of one")));
    }
    if !cases.are_drawn() {
        return Err(failed(format!("`{name}` draws nothing")));
    }
    Ok(cases)
}

/// The scenario with as many runs as there may be: a trial of it, whose first runs are those that it has by itself.
fn as_often(scenario: &Scenario, runs: u32) -> Scenario {
    Scenario { repeat: runs, runs: None, ..scenario.clone() }
}

fn space(cases: &Cases) -> RareSpace {
    let axis = |weights: Option<Vec<f64>>| weights.map_or(RareAxis::Continuous, RareAxis::Categories);
    RareSpace::new(cases.axis_weights().into_iter().map(axis).collect())
}

/// Makes the runs at points.
struct Runs<'a> {
    context: &'a Context<'a>,
    block: &'a Estimate,
    cases: &'a Cases,
    /// Of the scenario that it is compared with.
    others: Option<&'a Cases>,
    measured: std::sync::Arc<MeasuredMetrics>,
}

impl Runs<'_> {
    /// `first` is the number of the first.
    fn make(&self, first: usize, points: &[RarePoint]) -> Result<Vec<ScoredEncounter>, ExperimentError> {
        let both = [Some(self.cases), self.others];
        let scenarios = || both.into_iter().flatten();
        let plan = |one: &RarePoint| -> Result<Option<Vec<Case>>, PlanError> {
            scenarios().map(|cases| cases.at_drawn(one.chance, &one.point)).collect()
        };
        let planned =
            self.context.executor.think(|| points.par_iter().map(plan).collect::<Vec<Result<_, _>>>());
        let planned = planned.into_iter().collect::<Result<Vec<_>, _>>()?;
        let cases: Vec<Case> = planned.iter().flatten().flatten().cloned().collect();
        let number = first * scenarios().count();
        let mut outcomes = self.context.run_leaving_out(&self.measured, number, &cases)?.into_iter();
        let mut next = || outcomes.next().expect("one for every case").map(|outcome| self.seen(&outcome));
        let all = |run: ScoredRun| ScoredEncounter { own: run, other: self.others.map(|_| run) };
        let encounter = |cases: &Option<Vec<Case>>| match cases {
            Some(_) => match (next(), self.others.map(|_| next())) {
                (Some(own), None) => ScoredEncounter { own, other: None },
                (Some(own), Some(Some(other))) => ScoredEncounter { own, other: Some(other) },
                (None, _) | (_, Some(None)) => all(ScoredRun::LEFT_OUT),
            },
            // Nobody draws it: it is no part of what the probability is of.
            None => all(ScoredRun::NOBODY),
        };
        Ok(planned.iter().map(encounter).collect())
    }

    fn seen(&self, outcome: &Outcome) -> ScoredRun {
        let requests = &self.measured.requests;
        let of = |metric| requests.index(metric).map(|index| Seen::of(outcome, index));
        let event = of(&self.block.event.metric).expect("it is measured");
        // Where it cannot be said it counts against what is claimed.
        let (may, must) = (event.holds(&self.block.event, true), event.holds(&self.block.event, false));
        let score = self.block.score.as_ref().and_then(|score| {
            let value = of(score)?.so_far().filter(|value| value.is_finite())?;
            let worst = score.known().map(|metric| metric.worst);
            Some(if worst == Some(Worst::Largest) { -value } else { value })
        });
        let cut_off = !may && cut_off_runs(&self.block.event.metric, [outcome]) > 0;
        let encounter = has_encounter(&self.block.event, outcome, requests);
        ScoredRun { event: may, undecided: may && !must, cut_off, encounter, left_out: false, score }
    }
}
