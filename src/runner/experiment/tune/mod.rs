//! `tune`: controller parameters that are best on a set of cases, under constraints that hold in every run.

mod candidates;
mod last_check;
mod under_way;

use std::sync::atomic::AtomicUsize;

use super::context::{BlockProgress, Context};
use super::earlier::EarlierResults;
use super::error::ExperimentError;
use super::overrides;
use super::rounds::{Optimisation, optimise};
use super::search::{self, definition, undecisive};
use candidates::{Evaluated, FirstCandidate};
use last_check::Choice;
use numbers::random::derive_seed;
use optimise::{Fitted, Optimiser, non_dominated};
use results::{BeforeAndAfter, SavedCase, TuneResult, UntestedConstraint, Violations};
use scenario::{Objective, Origin, SearchRange, ShownIn, Target, Tune, Value};
use under_way::{Kept, TuneUnderWay};

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
    let under = TuneUnderWay { context, evaluating, tune, cases, progress, done: AtomicUsize::new(0) };
    under.run()
}

/// What a tune answers with.
#[derive(Default)]
struct Answer {
    /// The index of the candidate that is chosen.
    chosen: Option<usize>,
    /// With two objectives: the indices of those that no other beats.
    front: Vec<usize>,
    /// By how much the first objective of what is chosen differs from that of the declared values, on fresh seeds.
    change: Option<f64>,
    /// Where what is chosen is not feasible: in how many runs it violates a constraint.
    violations: Option<Violations>,
    /// How what is chosen, or each of the front, keeps the constraints with fresh seeds; empty without constraints.
    fresh: Vec<Kept>,
}

impl TuneUnderWay<'_> {
    fn run(&self) -> Result<TuneResult, ExperimentError> {
        let (suite, tune) = (self.context.suite, self.tune);
        let name = format!("{}/{}", suite.key_name(), tune.name);
        let goals = tune.objectives.iter().map(|objective| objective.direction).collect();
        let space = overrides::space(&tune.over)?;
        let first = self.evaluate_first()?;
        let seed = derive_seed(suite.seed, suite.own_key(&name));
        let definition = definition(space, &tune.budget, goals, tune.constraints.len(), seed);
        let batch = tune.budget.batch as usize;
        let cases = self.cases.iter().map(|case| suite.own_key(&case.key));
        let cases: Vec<_> =
            cases.zip(&self.cases).map(|(key, case)| SavedCase { key: key.into(), ..case.clone() }).collect();
        let inputs = (suite.seed, &suite.scenarios, &suite.supporting, self.decisive(), cases);
        let mut optimisation = Optimisation::begin(self.context, &name, &inputs, definition, batch)?;
        let told = tell(&first, &mut optimisation.optimiser)?;
        let mut only = [optimisation];
        optimise(&self.evaluating, &mut only, self)?;
        let [optimisation] = only;
        let candidates = self.candidates(first, &told, &optimisation.optimiser);
        let result = self.conclude(&candidates, &optimisation.optimiser)?;
        // Its journal stays: a larger budget goes on from it.
        Ok(result)
    }

    /// What of the tune decides its evaluations, besides the definition of its optimiser.
    fn decisive(&self) -> Tune {
        Tune {
            doc: None,
            over: overrides::without_origins(&self.tune.over),
            budget: undecisive(&self.tune.budget),
            compare_with_default: false,
            origin: Origin::default(),
            ..self.tune.clone()
        }
    }

    /// The candidate with which the fewest runs violate a constraint; of several the one with the best first objective,
    /// then the earliest. Candidates that break no constraint have no value and are not asked. Every candidate is run once more, because
    /// nothing else needs its single runs.
    fn fewest_violations(
        &self,
        candidates: &[Evaluated],
    ) -> Result<Option<(usize, Violations)>, ExperimentError> {
        let direction = self.tune.objectives[0].direction;
        let worth = |index: usize| {
            let value = candidates[index].evaluation.objectives[0].value;
            value.map_or(f64::INFINITY, |value| direction.minimised(value))
        };
        let mut fewest: Option<(usize, Violations)> = None;
        let breaking = candidates.iter().enumerate().filter(|(_, one)| !one.evaluation.keeps_constraints());
        for (index, candidate) in breaking {
            let outcomes = self.evaluating.run_all(1, &self.runs_with(&candidate.settings, false)?)?;
            let violations = self.violations(&outcomes);
            let is_less = |(best, least): &(usize, Violations)| {
                violations.runs.cmp(&least.runs).then(worth(index).total_cmp(&worth(*best))).is_lt()
            };
            if fewest.as_ref().is_none_or(is_less) {
                fewest = Some((index, violations));
            }
        }
        Ok(fewest)
    }

    /// What to answer with.
    fn answer(&self, candidates: &[Evaluated], fitted: Option<&Fitted>) -> Result<Answer, ExperimentError> {
        let tune = self.tune;
        let is_constrained = !tune.constraints.is_empty();
        if tune.objectives.len() == 1
            && let Some(Choice { index, change, fresh }) = self.choose(candidates, fitted)?
        {
            let fresh = if is_constrained { vec![fresh] } else { Vec::new() };
            return Ok(Answer { chosen: Some(index), change, fresh, ..Answer::default() });
        }
        let front = if tune.objectives.len() > 1 { self.front(candidates) } else { Vec::new() };
        let is_open = front.is_empty() && tune.otherwise_fewest_violations;
        let fewest = if is_open { self.fewest_violations(candidates)? } else { None };
        let (chosen, violations) = fewest.unzip();
        let answers = chosen.iter().chain(&front).filter(|_| is_constrained);
        let fresh = answers.map(|index| self.kept_on_fresh(&candidates[*index])).collect::<Result<_, _>>()?;
        Ok(Answer { chosen, front, violations, fresh, change: None })
    }

    fn conclude(
        &self,
        candidates: &[Evaluated],
        optimiser: &Optimiser,
    ) -> Result<TuneResult, ExperimentError> {
        let tune = self.tune;
        let fitted = optimiser.fitted().ok();
        let Answer { chosen, front, change, violations, fresh } = self.answer(candidates, fitted.as_ref())?;
        let chosen = chosen.map(|index| &candidates[index]);
        let best = chosen.map(Evaluated::candidate);
        let slices = best.as_ref().map(|best| search::slices(fitted.as_ref(), &best.point));
        let comparison = match chosen.filter(|_| tune.compare_with_default) {
            Some(chosen) => Some(self.compare(&chosen.settings)?),
            None => None,
        };
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
            chosen: best,
            change,
            violations,
            pareto: front.iter().map(|index| candidates[*index].candidate()).collect(),
            fresh_violations: fresh.iter().map(|one| one.violations).collect(),
            untested: untested(&fresh),
            evaluations: candidates.iter().map(Evaluated::candidate).collect(),
            stop: optimiser.stop_reason(),
            slices: slices.unwrap_or_default(),
            comparison,
        })
    }

    /// The feasible candidates that no other beats in every objective, in order.
    fn front(&self, candidates: &[Evaluated]) -> Vec<usize> {
        let vector = |one: &Evaluated| -> Option<Vec<f64>> {
            let each = self.tune.objectives.iter().zip(&one.evaluation.objectives);
            each.map(|(objective, value)| Some(objective.direction.minimised(value.value?))).collect()
        };
        let feasible = candidates.iter().enumerate().filter(|(_, one)| one.evaluation.is_feasible());
        let (indices, vectors): (Vec<usize>, Vec<Vec<f64>>) =
            feasible.filter_map(|(index, one)| Some((index, vector(one)?))).unzip();
        non_dominated(&vectors).into_iter().map(|place| indices[place]).collect()
    }

    fn compare(&self, chosen: &[(Target, Value)]) -> Result<BeforeAndAfter, ExperimentError> {
        let summaries = |settings: &[(Target, Value)], fresh| -> Result<_, ExperimentError> {
            let cases = self.runs_with(settings, fresh)?;
            Ok(self.context.summaries(&self.context.run_all(1, &cases)?))
        };
        Ok(BeforeAndAfter {
            shown_in: self.context.summaries_in(),
            before: summaries(&[], false)?,
            after: summaries(chosen, false)?,
            before_fresh: summaries(&[], true)?,
            after_fresh: summaries(chosen, true)?,
        })
    }
}

/// The constraints about which nothing was at stake with some answer, each reason once.
fn untested(fresh: &[Kept]) -> Vec<UntestedConstraint> {
    let mut all = Vec::new();
    for one in fresh.iter().flat_map(|one| &one.untested) {
        if !all.contains(one) {
            all.push(one.clone());
        }
    }
    all
}

/// Tells the optimiser of those that are within its space; gives the number of each.
fn tell(first: &[FirstCandidate], optimiser: &mut Optimiser) -> Result<Vec<Option<u64>>, optimise::Error> {
    let space = optimiser.definition().space.clone();
    let one = |one: &FirstCandidate| {
        one.within(&space).map(|point| optimiser.observe(point, one.evaluation().clone())).transpose()
    };
    first.iter().map(one).collect()
}
