//! Cases run for an experiment, and metrics summed up over them.

use std::sync::Arc;
use std::time::Duration;

use super::context::Context;
use super::error::ExperimentError;
use crate::run::{BatchError, MeasuredMetrics, RunBatch};
use numbers::summary::{mean, variance_of_mean};
use optimise::Margin;
use results::judge::{Seen, holds_undefined, objective_against};
use results::{CaseRun, MetricSummary, Outcome, SavedCase};
use scenario::{Aggregate, Case, Comparison, Goal, MetricKind, MetricReference, Relation, ShownIn};

impl Context<'_> {
    /// Runs every case, in a round; the outcomes are in the order of the cases. The first of a block or condition has the number 0: it is made
    /// twice.
    pub(super) fn run_all(&self, number: usize, cases: &[Case]) -> Result<Vec<Outcome>, ExperimentError> {
        self.run_reading(&self.measured, number, cases)
    }

    /// As [`Self::run_all`], reading other metrics off the runs.
    pub(super) fn run_reading(
        &self,
        measured: &Arc<MeasuredMetrics>,
        number: usize,
        cases: &[Case],
    ) -> Result<Vec<Outcome>, ExperimentError> {
        let batch = RunBatch { executor: self.executor, measured, stop: &self.stop };
        batch.outcomes_keeping(&self.first_runs, number, cases.iter().cloned(), || ()).map_err(failed)
    }

    /// As [`Self::run_reading`]; `None` of a case in which a pedestrian appears where there is no room, or would have to appear before the run
    /// begins.
    pub(super) fn run_leaving_out(
        &self,
        measured: &Arc<MeasuredMetrics>,
        number: usize,
        cases: &[Case],
    ) -> Result<Vec<Option<Outcome>>, ExperimentError> {
        let batch = RunBatch { executor: self.executor, measured, stop: &self.stop };
        batch.outcomes_leaving_out(&self.first_runs, number, cases.iter().cloned()).map_err(failed)
    }

    /// Cases with their outcomes, in the same order.
    pub(super) fn case_runs(
        &self,
        cases: impl IntoIterator<Item = SavedCase>,
        outcomes: Vec<Outcome>,
    ) -> Vec<CaseRun> {
        let run = |(case, mut outcome): (SavedCase, Outcome)| {
            // Nobody asks when a metric had its value, and results are the same bytes however long they took.
            outcome.forget_unasked(&[], self.requests());
            outcome.wall_time = Duration::ZERO;
            let passed_first = self.passed_first(&outcome);
            CaseRun { case, outcome, passed_first }
        };
        cases.into_iter().zip(outcomes).map(run).collect()
    }

    /// The metric in every outcome.
    pub(super) fn values(&self, metric: &MetricReference, outcomes: &[Outcome]) -> Vec<Option<f64>> {
        let index =
            self.requests().index(metric).expect("the context requested every metric that is asked for");
        outcomes.iter().map(|outcome| outcome.metrics[index]).collect()
    }

    /// What every outcome says of the metric.
    pub(super) fn seen(&self, metric: &MetricReference, outcomes: &[Outcome]) -> Vec<Seen> {
        let index =
            self.requests().index(metric).expect("the context requested every metric that is asked for");
        outcomes.iter().map(|outcome| Seen::of(outcome, index)).collect()
    }

    /// An objective's value over the outcomes, with the variance of its error where it is a mean of several runs. Runs that
    /// the horizon cut off, or in which the metric does not exist, count as what is farthest from the goal, so that no
    /// candidate gets better by runs that come to nothing; `None` where nothing bounds that.
    pub(super) fn objective(
        &self,
        objective: &Aggregate,
        goal: Goal,
        outcomes: &[Outcome],
    ) -> (Option<f64>, Option<f64>) {
        let relation = match goal {
            Goal::Minimise => Relation::LessOrEqual,
            Goal::Maximise => Relation::GreaterOrEqual,
        };
        let (value, counted) = objective_against(objective, relation, outcomes, self.requests());
        let variance = match objective {
            Aggregate::Mean(_) if value.is_some() => {
                variance_of_mean(&counted.into_iter().flatten().collect::<Vec<_>>())
            }
            _ => None,
        };
        (value, variance)
    }

    /// How far every run is from violating a constraint; without a value where that cannot be said, which counts as violated, unless the
    /// constraint holds in each of them by what it bounds not being there.
    pub(super) fn margin(&self, constraint: &Comparison, outcomes: &[Outcome]) -> Margin {
        self.worst_margin(constraint, outcomes).map_or(Margin::of(None), |worst| match worst.is_finite() {
            true => Margin::of(Some(worst)),
            false if outcomes.is_empty() => Margin::of(None),
            false => Margin::kept(),
        })
    }

    /// The least margin of the runs that have one, infinite where the constraint holds in all others; `None` where it does not.
    fn worst_margin(&self, constraint: &Comparison, outcomes: &[Outcome]) -> Option<f64> {
        let (relation, bound) = (constraint.relation, constraint.constant_bound());
        let mut worst = f64::INFINITY;
        for seen in self.seen(&constraint.metric, outcomes) {
            let margin = match seen {
                Seen::Undefined if holds_undefined(constraint, false) => continue,
                Seen::Undefined => return None,
                Seen::Value(value) => margin(relation, value, bound),
                // However it would have gone on.
                Seen::Open { .. } if seen.holds(constraint, false) => {
                    let farthest = seen.worst(&constraint.metric, relation);
                    farthest.map_or(1.0, |value| margin(relation, value, bound))
                }
                Seen::Open { .. } => {
                    let farthest = seen.worst(&constraint.metric, relation);
                    let nearest = seen.best(relation).filter(|value| !relation.holds(*value, bound));
                    margin(relation, farthest.filter(|value| value.is_finite()).or(nearest)?, bound)
                }
            };
            worst = worst.min(margin);
        }
        Some(worst)
    }

    /// Every quantity and flag over the outcomes, for tables. Categories have no mean.
    pub(super) fn summaries(&self, outcomes: &[Outcome]) -> Vec<MetricSummary> {
        self.summed_up()
            .map(|reference| {
                let seen = self.seen(reference, outcomes);
                let mut values: Vec<f64> = seen.into_iter().filter_map(Seen::value).collect();
                values.sort_by(f64::total_cmp);
                MetricSummary {
                    metric: reference.label(),
                    kind: reference.known().map(|metric| metric.kind.clone()),
                    runs: outcomes.len(),
                    defined: values.len(),
                    mean: mean(&values),
                    min: values.first().copied(),
                    max: values.last().copied(),
                }
            })
            .collect()
    }

    /// How the metrics of [`Self::summaries`] are shown, in their order.
    pub(super) fn summaries_in(&self) -> Vec<ShownIn> {
        let shown_in = |reference: &MetricReference| match reference.known()?.kind {
            MetricKind::Flag => Some(ShownIn::new(None, "%")),
            _ => Some(ShownIn::new(self.suite.notation(&reference.label()), &reference.unit())),
        };
        self.summed_up().map(|reference| shown_in(reference).unwrap_or_default()).collect()
    }

    /// The metrics that have a mean: not those that are words.
    fn summed_up(&self) -> impl Iterator<Item = &MetricReference> {
        let has_mean = |reference: &&MetricReference| {
            reference.known().is_some_and(|metric| !matches!(metric.kind, MetricKind::Category(_)))
        };
        self.requests().iter().filter(has_mean)
    }

    /// Who passed first in an outcome, in the metric's own words.
    pub(super) fn passed_first(&self, outcome: &Outcome) -> Option<String> {
        let index = self.requests().iter().position(|reference| reference.name() == "passed_first")?;
        let MetricKind::Category(words) = &self.requests().as_slice()[index].known()?.kind else {
            return None;
        };
        words.get(outcome.metrics[index]? as usize).map(ToString::to_string)
    }
}

fn failed(error: BatchError) -> ExperimentError {
    match error {
        BatchError::Run { key, error } => ExperimentError::Run { values: String::new(), key, error },
        BatchError::Stopped => ExperimentError::Stopped,
    }
}

/// How far a value is from violating a constraint; negative where it does.
fn margin(relation: Relation, value: f64, bound: f64) -> f64 {
    let margin = relation.margin(value, bound);
    if relation.holds(value, bound) {
        margin.unwrap_or(1.0)
    } else {
        // A strict relation is violated at its bound already, where the margin is 0.
        margin.unwrap_or(-1.0).min(-f64::MIN_POSITIVE)
    }
}
