//! `estimate`: how probable an event is in a scenario that draws. A method says at which points runs are wanted, runs are made there, and
//! what they weigh is what the points would be drawn with over what they were drawn with.
//!
//! What is drawn is perturbed; the noise inside of models is not: every run has noise of its own, named by its number. Splitting takes the
//! noise along from run to run, or has it drawn anew.

mod conclude;
mod record;
mod scored_run;

use super::context::{BlockProgress, Context};
use super::error::ExperimentError;
use crate::plan::{self, Cases};
use crate::run::MeasuredMetrics;
use conclude::{Told, conclude};
use numbers::random::derive_seed;
use numbers::rare::{
    CrudeSampling, ImportanceSampling, RareAxis, RareEstimate, RareOutcome, RarePoint, RareSampling,
    RareScale, RareSpace, SplittingSampling,
};
use rayon::prelude::*;
use record::EstimateRecord;
use results::judge::Seen;
use results::{EstimateResult, Outcome, Requests};
use scenario::{Case, Estimate, EstimateMethod, Scenario, Worst};
use scored_run::ScoredRun;

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
    let scenario = as_often(context.scenario(&block.scenario)?, block.budget);
    let failed = |what: String| ExperimentError::Estimate(what);
    let plan = plan::plan_scenario(context.suite, &scenario)?;
    if plan.len() != 1 {
        return Err(failed(format!(
            "`{}` has {} trials, and a probability is of one",
            scenario.name,
            plan.len()
        )));
    }
    let cases = plan.trial(0).cases;
    if cases.len() != block.budget as usize {
        return Err(failed(format!(
            "`{}` has several groups of people, and a probability is of one",
            scenario.name
        )));
    }
    let space = space(&cases);
    if space.dimensions() == 0 {
        return Err(failed(format!("`{}` draws nothing", scenario.name)));
    }
    let seed = derive_seed(context.suite.seed, &format!("estimate/{}", block.name));
    let budget = block.budget as usize;
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
    let inputs = (block, context.suite.seed, &scenario);
    let mut record = EstimateRecord::open(context.journals.as_deref(), &block.name, &inputs)
        .map_err(|error| failed(format!("its journal: {error}")))?;
    context.tell(record.notice.as_deref());
    let mut requests = Requests::default();
    requests.add(&block.event.metric);
    block.score.iter().for_each(|score| requests.add(score));
    let runs = Runs { context, block, cases: &cases, measured: MeasuredMetrics::new(requests) };

    let all = method.budget();
    let mut told = Told::default();
    while let Some(round) = context.executor.think(|| method.ask()) {
        let mut seen: Vec<ScoredRun> = Vec::with_capacity(round.points.len());
        for points in round.points.chunks(TOGETHER) {
            let first = told.runs + seen.len();
            let known = record.known(first, points.len()).cloned();
            let made = match known {
                Some(known) => known,
                None => {
                    let made = runs.make(first, points)?;
                    record
                        .add(first, made.clone())
                        .map_err(|error| failed(format!("its journal: {error}")))?;
                    made
                }
            };
            seen.extend(made);
            let so_far = estimate_so_far(&space, method.as_ref(), scale);
            match so_far {
                Some((value, within)) => {
                    progress.evaluated_within(told.runs + seen.len(), all, value, within);
                }
                None => progress.evaluated(told.runs + seen.len(), all, None),
            }
        }
        told.add(round.is_pilot, &seen);
        let outcomes: Vec<RareOutcome> = seen.into_iter().map(ScoredRun::outcome).collect();
        context.executor.think(|| method.tell(&outcomes));
    }
    let result = conclude(context, block, &cases, &space, method.as_ref(), scale, &told)?;
    record.remove();
    Ok(result)
}

/// The estimate of the replicates that there are, and where it lies at 95 %, once there are several.
fn estimate_so_far(
    space: &RareSpace,
    method: &dyn RareSampling,
    scale: RareScale,
) -> Option<(f64, (f64, f64))> {
    if method.replicates().len() < 2 {
        return None;
    }
    let so_far = RareEstimate::of(space, method.replicates(), scale);
    let interval = so_far.interval(0.95);
    Some((so_far.value, (interval.low, interval.high)))
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
    measured: std::sync::Arc<MeasuredMetrics>,
}

impl Runs<'_> {
    /// `first` is the number of the first.
    fn make(&self, first: usize, points: &[RarePoint]) -> Result<Vec<ScoredRun>, ExperimentError> {
        let plan = |one: &RarePoint| self.cases.at_drawn(one.chance, &one.point);
        let planned = self
            .context
            .executor
            .think(|| points.par_iter().map(plan).collect::<Vec<Result<Option<Case>, _>>>());
        let planned = planned.into_iter().collect::<Result<Vec<_>, _>>()?;
        let cases: Vec<Case> = planned.iter().flatten().cloned().collect();
        let mut outcomes = self.context.run_reading(&self.measured, first, &cases)?.into_iter();
        let seen = |case: &Option<Case>| match case {
            Some(_) => self.seen(&outcomes.next().expect("one for every case")),
            // Nobody draws it: it is no part of what the probability is of.
            None => ScoredRun { event: false, undecided: false, score: None },
        };
        Ok(planned.iter().map(seen).collect())
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
        ScoredRun { event: may, undecided: may && !must, score }
    }
}
