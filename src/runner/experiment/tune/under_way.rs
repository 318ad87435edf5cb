//! One tune under way: the runs of its candidates and their evaluations.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::experiment::context::{BlockProgress, Context};
use crate::experiment::error::ExperimentError;
use crate::experiment::overrides;
use crate::experiment::rounds::EvaluateRound;
use numbers::random::derive_seed;
use optimise::{Evaluation, Margin, ObjectiveValue, Proposal};
use results::judge::comparison_untested_by;
use results::{Outcome, SavedCase, UntestedConstraint, Violations};
use scenario::{Case, Comparison, Objective, Target, Tune, Value};

/// Cases of a candidate that may run ahead of the search for a violation. What comes after one is not counted, so that this
/// number changes nothing but the time it takes.
const AHEAD: usize = 8;

/// How a candidate keeps the constraints.
pub struct Kept {
    /// In how many of its runs it violates one.
    pub violations: Violations,
    /// Those about which nothing was at stake.
    pub untested: Vec<UntestedConstraint>,
}

/// One tune under way.
pub struct TuneUnderWay<'a> {
    pub context: &'a Context<'a>,
    /// For the evaluations, of which nothing but objectives and constraints is kept: what is shown is run again.
    pub evaluating: Context<'a>,
    pub tune: &'a Tune,
    pub cases: Vec<SavedCase>,
    pub progress: &'a dyn BlockProgress,
    pub done: AtomicUsize,
}

impl EvaluateRound for TuneUnderWay<'_> {
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
        self.evaluation_of(outcomes, abandoned)
    }

    fn evaluated(&self, evaluation: &Evaluation) {
        self.note(evaluation);
    }
}

impl TuneUnderWay<'_> {
    /// The evaluation of a candidate from its runs.
    pub fn evaluation_of(&self, outcomes: &[Outcome], abandoned: bool) -> Evaluation {
        let objective = |objective: &Objective| {
            let (value, noise_variance) =
                self.evaluating.objective(&objective.aggregate, objective.direction, outcomes);
            // Of a part of the set an objective says nothing.
            let value = value.filter(|_| !abandoned);
            ObjectiveValue { value, noise_variance: noise_variance.filter(|_| value.is_some()) }
        };
        let margin =
            |constraint| Margin { censored: abandoned, ..self.evaluating.margin(constraint, outcomes) };
        Evaluation {
            objectives: self.tune.objectives.iter().map(objective).collect(),
            margins: self.tune.constraints.iter().map(margin).collect(),
            repetitions: 1,
            left_out: 0,
        }
    }

    /// Tells how far the tune is, after an evaluation.
    pub fn note(&self, evaluation: &Evaluation) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let best = evaluation.objectives[0].value.filter(|_| evaluation.keeps_constraints());
        let all = 1 + self.tune.tries.len() + self.tune.budget.evaluations as usize;
        self.progress.evaluated(done, all, best);
    }

    fn violated(&self, outcomes: &[Outcome]) -> bool {
        !self.tune.constraints.iter().all(|one| self.evaluating.margin(one, outcomes).is_kept())
    }

    /// In how many runs a constraint is violated.
    pub fn violations(&self, outcomes: &[Outcome]) -> Violations {
        let violated = outcomes.iter().filter(|outcome| self.violated(std::slice::from_ref(*outcome)));
        Violations { runs: violated.count(), of: outcomes.len() }
    }

    /// How the candidate of these runs keeps the constraints.
    pub fn kept(&self, outcomes: &[Outcome]) -> Kept {
        let all: Vec<_> = outcomes.iter().collect();
        let untested = |(index, one): (usize, &Comparison)| {
            let reason = comparison_untested_by(one, &all, self.evaluating.requests())?;
            Some(UntestedConstraint { constraint: one.text(self.tune.constraint_in(index)), reason })
        };
        let constraints = self.tune.constraints.iter().enumerate();
        Kept { violations: self.violations(outcomes), untested: constraints.filter_map(untested).collect() }
    }

    /// The set's cases with these settings: under the same seeds for every candidate, or `again` under others.
    pub fn runs_with(&self, settings: &[(Target, Value)], again: bool) -> Result<Vec<Case>, ExperimentError> {
        let suite = self.context.suite;
        let mut cases = Vec::with_capacity(self.cases.len() * self.tune.fresh.max(1) as usize);
        for (index, saved) in self.cases.iter().enumerate() {
            let key = format!("{}/{}/case={}", suite.key_name(), self.tune.name, index + 1);
            for run in 1..=self.tune.fresh.max(1) {
                let (key, named) = match self.tune.fresh {
                    0 => (key.clone(), again.then(|| format!("{key}/fresh"))),
                    _ if again => (format!("{key}/fresh={run}"), Some(format!("{key}/again={run}"))),
                    _ => (format!("{key}/fresh={run}"), Some(format!("{key}/fresh={run}"))),
                };
                let seed = named.map(|name| derive_seed(suite.seed, suite.own_key(&name)));
                cases.push(self.context.revive(saved, settings, key, seed)?);
            }
        }
        Ok(cases)
    }
}
