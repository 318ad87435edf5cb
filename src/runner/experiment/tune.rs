//! `tune`: controller parameters that are best on a set of cases, under constraints that hold in every run.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::context::{BlockProgress, Context};
use super::earlier::EarlierResults;
use super::error::ExperimentError;
use super::overrides;
use super::rounds::{EvaluateRound, Optimisation, optimise};
use super::search::{self, definition};
use numbers::random::derive_seed;
use optimise::{self, Evaluation, Fitted, Margin, ObjectiveValue, Optimiser, Proposal};
use results::{BeforeAndAfter, Candidate, Outcome, SavedCase, TuneResult, Violations};
use scenario::{Case, Goal, Objective, SearchRange, ShownIn, Target, Tune, Value};

/// Cases of a candidate that may run ahead of the search for a violation. What comes after one is not counted, so that this
/// number changes nothing but the time it takes.
const AHEAD: usize = 8;

/// Runs one tune to its end. `results` holds the searches that its cases come from.
///
/// # Errors
/// Whatever keeps it from a result; that no candidate is feasible is a result.
pub fn run_tune(
    context: &Context,
    tune: &Tune,
    results: &EarlierResults,
    progress: &dyn BlockProgress,
) -> Result<TuneResult, ExperimentError> {
    let cases = context.case_set(&tune.on, &tune.name, results)?;
    let looked_at = tune.objectives.iter().map(|objective| objective.aggregate.metric());
    let constrained = tune.constraints.iter().map(|constraint| &constraint.metric);
    let evaluating = context.reading_only(looked_at.chain(constrained));
    let under = Under { context, evaluating, tune, cases, progress, done: AtomicUsize::new(0) };
    under.run()
}

/// One tune under way.
struct Under<'a> {
    context: &'a Context<'a>,
    /// For the evaluations, of which nothing but objectives and constraints is kept: what is shown is run again.
    evaluating: Context<'a>,
    tune: &'a Tune,
    cases: Vec<SavedCase>,
    progress: &'a dyn BlockProgress,
    done: AtomicUsize,
}

impl EvaluateRound for Under<'_> {
    fn cases(&self, _: usize, proposal: &Proposal) -> Result<Vec<Case>, ExperimentError> {
        self.runs_with(&overrides::settings(&self.tune.over, &proposal.point), false)
    }

    fn values(&self, proposal: &Proposal) -> String {
        overrides::in_words(&self.tune.over, &proposal.point)
    }

    /// Algorithm 1 of the founding paper: the cases one after the other, and the first violation ends the candidate.
    fn is_enough(&self, outcomes: &[Outcome]) -> bool {
        let ends_early = self.tune.early_stop && !self.tune.constraints.is_empty();
        ends_early && outcomes.last().is_some_and(|last| self.violated(std::slice::from_ref(last)))
    }

    fn ahead(&self) -> usize {
        if self.tune.early_stop { AHEAD } else { usize::MAX }
    }

    fn evaluation(&self, _: &[Case], outcomes: &[Outcome], abandoned: bool) -> Evaluation {
        let objective = |objective: &Objective| {
            let (value, noise_variance) =
                self.evaluating.objective(&objective.aggregate, objective.direction, outcomes);
            // Of a part of the set an objective says nothing.
            let value = value.filter(|_| !abandoned);
            ObjectiveValue { value, noise_variance: noise_variance.filter(|_| value.is_some()) }
        };
        let margin =
            |constraint| Margin { value: self.evaluating.margin(constraint, outcomes), censored: abandoned };
        Evaluation {
            objectives: self.tune.objectives.iter().map(objective).collect(),
            margins: self.tune.constraints.iter().map(margin).collect(),
            repetitions: 1,
            left_out: 0,
        }
    }

    fn evaluated(&self, evaluation: &Evaluation) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let best = evaluation.objectives[0].value.filter(|_| is_feasible(evaluation));
        self.progress.evaluated(done, self.tune.budget.evaluations as usize, best);
    }
}

impl Under<'_> {
    fn run(&self) -> Result<TuneResult, ExperimentError> {
        let (suite, tune) = (self.context.suite, self.tune);
        let name = format!("{}/{}", suite.name, tune.name);
        let goals = tune.objectives.iter().map(|objective| objective.direction).collect();
        let space = overrides::space(&tune.over)?;
        let seed = derive_seed(suite.seed, &name);
        let definition = definition(space, &tune.budget, goals, tune.constraints.len(), seed);
        let batch = tune.budget.batch as usize;
        let inputs = (suite.seed, &suite.scenarios, &suite.supporting, tune, &self.cases);
        let optimisation = Optimisation::begin(self.context, &name, &inputs, definition, batch)?;
        let mut only = [optimisation];
        optimise(&self.evaluating, &mut only, self)?;
        let result = self.conclude(&only[0].optimiser)?;
        let [optimisation] = only;
        optimisation.into_record().remove();
        Ok(result)
    }

    fn violated(&self, outcomes: &[Outcome]) -> bool {
        let margin = |constraint| self.evaluating.margin(constraint, outcomes);
        self.tune.constraints.iter().any(|one| margin(one).is_none_or(|margin| margin < 0.0))
    }

    /// The candidate with which the fewest runs violate a constraint; of several the one with the best first objective,
    /// then the earliest. Every candidate is run once more, because nothing else needs its single runs.
    fn fewest_violations<'o>(
        &self,
        optimiser: &'o Optimiser,
    ) -> Result<Option<(&'o optimise::EvaluatedPoint, Violations)>, ExperimentError> {
        let worth = |trial: &optimise::EvaluatedPoint| {
            let value = trial.evaluation.objectives[0].value.unwrap_or(f64::INFINITY);
            match self.tune.objectives[0].direction {
                Goal::Maximise if value.is_finite() => -value,
                _ => value,
            }
        };
        let mut fewest: Option<(&optimise::EvaluatedPoint, Violations)> = None;
        for trial in optimiser.trials() {
            let settings = overrides::settings(&self.tune.over, &trial.point);
            let outcomes = self.evaluating.run_all(1, &self.runs_with(&settings, false)?)?;
            let runs = outcomes.iter().filter(|outcome| self.violated(std::slice::from_ref(outcome))).count();
            let is_less = |(best, least): &(&optimise::EvaluatedPoint, Violations)| {
                runs.cmp(&least.runs).then(worth(trial).total_cmp(&worth(best))).is_lt()
            };
            if fewest.as_ref().is_none_or(is_less) {
                fewest = Some((trial, Violations { runs, of: outcomes.len() }));
            }
        }
        Ok(fewest)
    }

    /// The set's cases with these settings: under the same seeds for every candidate, or `again` under others.
    fn runs_with(&self, settings: &[(Target, Value)], again: bool) -> Result<Vec<Case>, ExperimentError> {
        let suite = self.context.suite;
        let mut cases = Vec::with_capacity(self.cases.len() * self.tune.fresh.max(1) as usize);
        for (index, saved) in self.cases.iter().enumerate() {
            let key = format!("{}/{}/case={}", suite.name, self.tune.name, index + 1);
            for run in 1..=self.tune.fresh.max(1) {
                let (key, named) = match self.tune.fresh {
                    0 => (key.clone(), again.then(|| format!("{key}/fresh"))),
                    _ if again => (format!("{key}/fresh={run}"), Some(format!("{key}/again={run}"))),
                    _ => (format!("{key}/fresh={run}"), Some(format!("{key}/fresh={run}"))),
                };
                let seed = named.map(|name| derive_seed(suite.seed, &name));
                cases.push(self.context.revive(saved, settings, key, seed)?);
            }
        }
        Ok(cases)
    }

    fn conclude(&self, optimiser: &Optimiser) -> Result<TuneResult, ExperimentError> {
        let tune = self.tune;
        let candidate = |trial: &optimise::EvaluatedPoint| Candidate {
            point: trial.point.clone(),
            objectives: trial.evaluation.objectives.iter().map(|one| one.value).collect(),
            margins: trial.evaluation.margins.iter().map(|one| one.value).collect(),
            feasible: trial.is_feasible(),
        };
        // The predicted best among what was seen to be feasible; where no surrogate can be fitted, the observed best.
        let fitted = optimiser.fitted().ok();
        let predicted = fitted.as_ref().and_then(Fitted::best_predicted);
        let chosen = predicted
            .and_then(|one| optimiser.trials().iter().find(|trial| trial.id == one.id && trial.is_feasible()))
            .or_else(|| optimiser.best_observed());
        let fallback = match chosen {
            None if tune.otherwise_fewest_violations => self.fewest_violations(optimiser)?,
            _ => None,
        };
        let (fallback, violations) = fallback.unzip();
        let chosen = chosen.or(fallback);
        let mut slices = Vec::new();
        let mut comparison = None;
        if let Some(best) = chosen {
            slices = search::slices(fitted.as_ref(), &best.point);
            if tune.compare_with_default {
                comparison = Some(self.compare(&overrides::settings(&tune.over, &best.point))?);
            }
        }
        let written =
            || tune.constraints.iter().enumerate().map(|(index, one)| (one, tune.constraint_in(index)));
        let constraints = || written().map(|(one, unit)| one.text(unit)).collect();
        let objective_in = |one: &Objective| ShownIn::new(one.notation, &one.aggregate.unit());
        Ok(TuneResult {
            name: tune.name.clone(),
            objectives: tune.objectives.iter().map(|objective| objective.text.clone()).collect(),
            constraints: constraints(),
            cases: self.cases.len(),
            fresh: tune.fresh,
            parameters: tune.over.iter().map(|range| range.target.to_string()).collect(),
            shown_in: tune.over.iter().map(SearchRange::shown_in).collect(),
            objectives_in: tune.objectives.iter().map(objective_in).collect(),
            margins_in: written().map(|(one, unit)| ShownIn::new(unit, &one.metric.unit())).collect(),
            chosen: chosen.map(candidate),
            violations,
            pareto: if tune.objectives.len() > 1 {
                optimiser.pareto_front().into_iter().map(candidate).collect()
            } else {
                Vec::new()
            },
            evaluations: optimiser.trials().iter().map(candidate).collect(),
            stop: optimiser.stop_reason(),
            slices,
            comparison,
        })
    }

    fn compare(&self, chosen: &[(Target, Value)]) -> Result<BeforeAndAfter, ExperimentError> {
        let outcomes = |settings: &[(Target, Value)], fresh| {
            let cases = self.runs_with(settings, fresh)?;
            self.context.run_all(1, &cases)
        };
        let after_fresh = outcomes(chosen, true)?;
        let keeps =
            |constraint| self.context.margin(constraint, &after_fresh).is_some_and(|margin| margin >= 0.0);
        Ok(BeforeAndAfter {
            shown_in: self.context.summaries_in(),
            before: self.context.summaries(&outcomes(&[], false)?),
            after: self.context.summaries(&outcomes(chosen, false)?),
            before_fresh: self.context.summaries(&outcomes(&[], true)?),
            feasible_fresh: self.tune.constraints.iter().all(keeps),
            after_fresh: self.context.summaries(&after_fresh),
        })
    }
}

fn is_feasible(evaluation: &Evaluation) -> bool {
    evaluation.margins.iter().all(|margin| margin.value.is_some_and(|value| value >= 0.0))
}
