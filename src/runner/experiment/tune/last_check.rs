//! The last check of a tune: its answer, the best that was seen and what is declared, all evaluated again on the same runs.
//!
//! Every candidate meets the cases twice: with the seeds on which it was chosen, and with fresh ones. How far runs of one and the same case
//! differ says how much of a difference between candidates is chance: nothing where nothing is drawn.

use std::collections::HashMap;

use super::candidates::Evaluated;
use super::under_way::{Kept, TuneUnderWay};
use crate::experiment::error::ExperimentError;
use numbers::random::derive_seed;
use optimise::{Fitted, Reevaluated, SamplingError, WorseBy, choose};
use results::Outcome;

/// How many of the best observed candidates the answer is compared with.
const MOST_COMPARED: usize = 2;

/// The candidate that the check chooses.
pub struct Choice {
    /// The index of the candidate.
    pub index: usize,
    /// By how much its first objective differs from that of the declared values, on fresh seeds.
    pub change: Option<f64>,
    /// How it keeps the constraints with fresh seeds.
    pub fresh: Kept,
}

/// A candidate that was evaluated again.
struct Finalist {
    index: usize,
    /// On the seeds that it was chosen on, and then as many on fresh ones.
    runs: Vec<Outcome>,
    /// How it keeps the constraints with fresh seeds.
    kept: Kept,
}

impl Finalist {
    fn seen(&self) -> &[Outcome] {
        &self.runs[..self.runs.len() / 2]
    }

    fn fresh(&self) -> &[Outcome] {
        &self.runs[self.runs.len() / 2..]
    }
}

impl TuneUnderWay<'_> {
    /// The candidate to answer with; `None` where none is feasible.
    pub fn choose(
        &self,
        candidates: &[Evaluated],
        fitted: Option<&Fitted>,
    ) -> Result<Option<Choice>, ExperimentError> {
        let direction = self.tune.objectives[0].direction;
        let value = |one: &Evaluated| Some(direction.minimised(one.evaluation.objectives[0].value?));
        let feasible = candidates.iter().enumerate().filter(|(_, one)| one.evaluation.is_feasible());
        let mut feasible: Vec<(f64, usize)> =
            feasible.filter_map(|(index, one)| Some((value(one)?, index))).collect();
        feasible.sort_by(|left, right| left.0.total_cmp(&right.0).then(left.1.cmp(&right.1)));
        let best: Vec<usize> = feasible.iter().take(MOST_COMPARED).map(|(_, index)| *index).collect();
        let Some(&first) = best.first() else { return Ok(None) };
        let is_feasible = |index: usize| candidates[index].evaluation.is_feasible();
        let predicted = fitted.and_then(Fitted::best_predicted).map(|one| one.id);
        let predicted = candidates.iter().position(|one| predicted.is_some() && one.id == predicted);
        let predicted = predicted.filter(|index| is_feasible(*index)).unwrap_or(first);
        let declared = candidates.iter().position(Evaluated::is_declared).filter(|index| is_feasible(*index));
        let mut finalists =
            self.evaluate_again(candidates, best.iter().copied().chain([predicted]).chain(declared))?;
        let place = |index: usize| {
            let place = finalists.iter().position(|one| one.index == index);
            place.expect("every candidate that is compared is there")
        };
        let of = |index: usize| &finalists[place(index)];
        let pools = self.pools();
        let index = choose(predicted, &best, declared, |one, other| {
            Ok::<_, ExperimentError>(self.worse_by(of(one), of(other), &pools))
        })?;
        let change = declared
            .filter(|declared| *declared != index)
            .and_then(|declared| self.change_on_fresh(of(declared), of(index)));
        let chosen = place(index);
        Ok(Some(Choice { index, change, fresh: finalists.swap_remove(chosen).kept }))
    }

    /// How a candidate keeps the constraints with fresh seeds.
    pub fn kept_on_fresh(&self, candidate: &Evaluated) -> Result<Kept, ExperimentError> {
        Ok(self.kept(&self.evaluating.run_all(1, &self.runs_with(&candidate.settings, true)?)?))
    }

    /// By how much the first objective changes on runs that no candidate was chosen on.
    fn change_on_fresh(&self, declared: &Finalist, chosen: &Finalist) -> Option<f64> {
        let change = self.to_minimise(chosen.fresh()) - self.to_minimise(declared.fresh());
        change.is_finite().then(|| self.tune.objectives[0].direction.minimised(change))
    }

    /// Each candidate once, on the seeds that it was chosen on and on fresh ones.
    fn evaluate_again(
        &self,
        candidates: &[Evaluated],
        indices: impl Iterator<Item = usize>,
    ) -> Result<Vec<Finalist>, ExperimentError> {
        let mut once: Vec<usize> = indices.collect();
        once.sort_unstable();
        once.dedup();
        let mut cases = Vec::new();
        for index in &once {
            let settings = &candidates[*index].settings;
            cases.push([self.runs_with(settings, false)?, self.runs_with(settings, true)?].concat());
        }
        let mut outcomes = self.evaluating.run_all(1, &cases.concat())?.into_iter();
        let finalist = |(index, cases): (&usize, &Vec<_>)| {
            let runs: Vec<_> = outcomes.by_ref().take(cases.len()).collect();
            let kept = self.kept(&runs[runs.len() / 2..]);
            Finalist { index: *index, runs: runs.into_iter().map(bare).collect(), kept }
        };
        Ok(once.iter().zip(&cases).map(finalist).collect())
    }

    /// By how much the first objective of one is worse than that of the other.
    fn worse_by(&self, one: &Finalist, other: &Finalist, pools: &[Vec<usize>]) -> WorseBy {
        let of = |finalist: &Finalist| Reevaluated {
            seen: self.to_minimise(finalist.seen()),
            fresh: self.to_minimise(finalist.fresh()),
        };
        let metric = self.tune.objectives[0].aggregate.metric();
        let values = [one, other].map(|finalist| self.evaluating.values(metric, &finalist.runs));
        let is_same = |left: usize, right: usize| values.iter().all(|values| values[left] == values[right]);
        let over = |finalist: &Finalist, drawn: &[usize]| {
            self.to_minimise(&drawn.iter().map(|run| finalist.runs[*run].clone()).collect::<Vec<_>>())
        };
        let name = format!("{}/{} last check", self.context.suite.name, self.tune.name);
        let seed = derive_seed(self.context.suite.seed, &name);
        let chance = SamplingError::of(pools, seed, is_same, |drawn| over(one, drawn) - over(other, drawn));
        WorseBy::of(of(one), of(other), chance)
    }

    /// For each run those of the same case, by their places among those of a finalist: where a case has a single run, that with a fresh seed.
    fn pools(&self) -> Vec<Vec<usize>> {
        let of_each = self.tune.fresh.max(1) as usize;
        let all = self.cases.len() * of_each;
        let mut alike: HashMap<String, Vec<usize>> = HashMap::new();
        let mut names = Vec::with_capacity(all);
        for (index, case) in self.cases.iter().enumerate() {
            let same = (&case.scenario, &case.variation, &case.settings, &case.individuals);
            let name = serde_json::to_string(&same).expect("plain data serialises");
            for run in index * of_each..(index + 1) * of_each {
                alike.entry(name.clone()).or_default().push(run);
                names.push(name.clone());
            }
        }
        let pool = |name: &String| match &alike[name][..] {
            [run] => vec![*run, all + run],
            several => several.to_vec(),
        };
        names.iter().map(pool).collect()
    }

    /// The first objective over runs as a number to minimise; infinite without a value.
    fn to_minimise(&self, outcomes: &[Outcome]) -> f64 {
        let objective = &self.tune.objectives[0];
        let value = self.evaluating.objective(&objective.aggregate, objective.direction, outcomes).0;
        value.map_or(f64::INFINITY, |value| objective.direction.minimised(value))
    }
}

/// What objectives and constraints are made of: it is copied often.
fn bare(outcome: Outcome) -> Outcome {
    Outcome {
        key: String::new(),
        individuals: Vec::new(),
        drawn: Vec::new(),
        critical: Default::default(),
        presences: Vec::new(),
        ..outcome
    }
}
