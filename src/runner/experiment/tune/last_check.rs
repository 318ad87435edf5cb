//! The last check of a tune: its answer, the best that was seen and what is declared, all evaluated again on the same runs.
//!
//! Every candidate meets the cases twice: with the seeds on which it was chosen, and with fresh ones. How far runs of one and the same case
//! differ says how much of a difference between candidates is chance: nothing where nothing is drawn.

use std::collections::HashMap;

use super::candidates::Evaluated;
use super::under_way::TuneUnderWay;
use crate::experiment::error::ExperimentError;
use numbers::distributions::student_quantile;
use numbers::random::{Stream, derive_seed};
use numbers::summary::std;
use optimise::{Fitted, Reevaluated, WorseBy, choose};
use results::{Outcome, Violations};
use scenario::Goal;

/// How many of the best observed candidates the answer is compared with.
const MOST_COMPARED: usize = 2;
/// Confidence that one candidate is worse than another.
const CONFIDENCE: f64 = 0.95;
/// How often runs are drawn again to tell the error of a difference.
const RESAMPLES: usize = 200;

/// What the check comes to.
pub struct Choice {
    /// The index of the candidate.
    pub index: usize,
    /// By how much its first objective differs from that of the declared values, on fresh seeds.
    pub change: Option<f64>,
    /// In how many of the runs with fresh seeds it violates a constraint.
    pub fresh: Violations,
}

/// A candidate that was evaluated again.
struct Finalist {
    index: usize,
    seen: Vec<Outcome>,
    fresh: Vec<Outcome>,
}

/// A run by its place among those of a candidate.
#[derive(Debug, Clone, Copy)]
struct DrawnRun {
    run: usize,
    fresh: bool,
}

impl TuneUnderWay<'_> {
    /// The candidate to answer with; `None` where none is feasible.
    pub fn choose(
        &self,
        candidates: &[Evaluated],
        fitted: Option<&Fitted>,
    ) -> Result<Option<Choice>, ExperimentError> {
        let sign = self.sign();
        let value = |one: &Evaluated| one.evaluation.objectives[0].value.map(|value| sign * value);
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
        let finalists =
            self.evaluate_again(candidates, best.iter().copied().chain([predicted]).chain(declared))?;
        let of = |index: usize| {
            finalists
                .iter()
                .find(|one| one.index == index)
                .expect("every candidate that is compared is there")
        };
        let worse_by = |one, other| Ok::<_, ExperimentError>(self.worse_by(of(one), of(other)));
        let index = choose(predicted, &best, declared, worse_by)?;
        let change = declared
            .filter(|declared| *declared != index)
            .and_then(|declared| self.change_on_fresh(of(declared), of(index)));
        Ok(Some(Choice { index, change, fresh: self.violations(&of(index).fresh) }))
    }

    /// In how many runs with fresh seeds a candidate violates a constraint.
    pub fn fresh_violations(&self, candidate: &Evaluated) -> Result<Violations, ExperimentError> {
        Ok(self.violations(&self.evaluating.run_all(1, &self.runs_with(&candidate.settings, true)?)?))
    }

    /// By how much the first objective changes on runs that no candidate was chosen on.
    fn change_on_fresh(&self, declared: &Finalist, chosen: &Finalist) -> Option<f64> {
        let change = self.to_minimise(&chosen.fresh) - self.to_minimise(&declared.fresh);
        change.is_finite().then_some(self.sign() * change)
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
            for fresh in [false, true] {
                cases.push(self.runs_with(&candidates[*index].settings, fresh)?);
            }
        }
        let mut outcomes = self.evaluating.run_all(1, &cases.concat())?.into_iter().map(bare);
        let mut next = |runs: usize| outcomes.by_ref().take(runs).collect::<Vec<_>>();
        let pairs = once.iter().zip(cases.chunks(2));
        Ok(pairs
            .map(|(index, both)| Finalist {
                index: *index,
                seen: next(both[0].len()),
                fresh: next(both[1].len()),
            })
            .collect())
    }

    /// By how much the first objective of one is worse than that of the other.
    fn worse_by(&self, one: &Finalist, other: &Finalist) -> WorseBy {
        let of = |finalist: &Finalist| Reevaluated {
            seen: self.to_minimise(&finalist.seen),
            fresh: self.to_minimise(&finalist.fresh),
        };
        let differences = self.differences(one, other);
        let known: Vec<f64> = differences.iter().copied().filter(|one| one.is_finite()).collect();
        let worse = WorseBy::of(of(one), of(other), self.error_of(&known, one, other));
        // Chance may leave either without a value: nothing shows that the one is better.
        let is_known = known.len() == differences.len();
        WorseBy { fresh: if is_known { worse.fresh } else { f64::INFINITY }, ..worse }
    }

    /// By how much the one is worse than the other on runs that are drawn again; not finite where either has no value.
    ///
    /// The cases are what they are, and what each draws could be otherwise. So runs are drawn again among those of the same case, the same
    /// for both candidates: where a case has a single run, among that and the one with a fresh seed.
    fn differences(&self, one: &Finalist, other: &Finalist) -> Vec<f64> {
        let pools = self.pools();
        let name = format!("{}/{} last check", self.context.suite.name, self.tune.name);
        let mut stream = Stream::seeded(derive_seed(self.context.suite.seed, &name));
        let mut differences = Vec::with_capacity(RESAMPLES);
        for _ in 0..RESAMPLES {
            let drawn: Vec<DrawnRun> = pools.iter().map(|pool| pool[stream.index(pool.len())]).collect();
            let again = |of: &Finalist| -> f64 {
                let run = |drawn: &DrawnRun| {
                    if drawn.fresh { &of.fresh[drawn.run] } else { &of.seen[drawn.run] }.clone()
                };
                self.to_minimise(&drawn.iter().map(run).collect::<Vec<_>>())
            };
            differences.push(again(one) - again(other));
        }
        differences
    }

    /// By how much chance alone may well make the one worse than the other on the seeds that were seen, out of differences on runs that are
    /// drawn again. A draw from `n` runs varies by (n − 1)/n of what a new run does.
    fn error_of(&self, differences: &[f64], one: &Finalist, other: &Finalist) -> f64 {
        let pools = self.pools();
        let smallest = pools.iter().map(Vec::len).min().unwrap_or(2).max(2) as f64;
        let deviation = std(differences).unwrap_or(0.0) * (smallest / (smallest - 1.0)).sqrt();
        let freedom = |pool: &Vec<DrawnRun>| match pool[..] {
            [one, other] if one.run == other.run => 1.0,
            _ => 1.0 - 1.0 / pool.len() as f64,
        };
        // What varies by nothing says nothing of how well the deviation is known.
        let metric = self.tune.objectives[0].aggregate.metric();
        let values = [one, other]
            .map(|of| [&of.seen, &of.fresh].map(|outcomes| self.evaluating.values(metric, outcomes)));
        let varies = |pool: &&Vec<DrawnRun>| {
            values.iter().any(|[seen, fresh]| {
                let value = |drawn: &DrawnRun| if drawn.fresh { fresh[drawn.run] } else { seen[drawn.run] };
                pool.iter().any(|drawn| value(drawn) != value(&pool[0]))
            })
        };
        let freedom: f64 = pools.iter().filter(varies).map(freedom).sum();
        student_quantile(CONFIDENCE, freedom.max(1.0)) * deviation
    }

    /// For each run those that could stand in its place.
    fn pools(&self) -> Vec<Vec<DrawnRun>> {
        let of_each = self.tune.fresh.max(1) as usize;
        let mut alike: HashMap<String, Vec<usize>> = HashMap::new();
        let mut names = Vec::with_capacity(self.cases.len() * of_each);
        for (index, case) in self.cases.iter().enumerate() {
            let same = (&case.scenario, &case.variation, &case.settings, &case.individuals);
            let name = serde_json::to_string(&same).expect("plain data serialises");
            for run in index * of_each..(index + 1) * of_each {
                alike.entry(name.clone()).or_default().push(run);
                names.push(name.clone());
            }
        }
        let pool = |(run, name): (usize, &String)| match &alike[name][..] {
            [_] => [false, true].map(|fresh| DrawnRun { run, fresh }).to_vec(),
            several => several.iter().map(|run| DrawnRun { run: *run, fresh: false }).collect(),
        };
        names.iter().enumerate().map(pool).collect()
    }

    /// The first objective over runs as a number to minimise; infinite without a value.
    fn to_minimise(&self, outcomes: &[Outcome]) -> f64 {
        let objective = &self.tune.objectives[0];
        let value = self.evaluating.objective(&objective.aggregate, objective.direction, outcomes).0;
        value.map_or(f64::INFINITY, |value| self.sign() * value)
    }

    fn sign(&self) -> f64 {
        match self.tune.objectives[0].direction {
            Goal::Minimise => 1.0,
            Goal::Maximise => -1.0,
        }
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
