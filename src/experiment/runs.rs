//! Cases run for an experiment, and metrics summed up over them.

use rayon::prelude::*;
use serde::{Deserialize, Serialize, Serializer};

use super::cases::SavedCase;
use super::{ExperimentError, Laboratory};
use crate::judge::{aggregate, holds_undefined};
use crate::metrics::{MetricKind, metric};
use crate::run::{Outcome, Unwatched, run_case};
use crate::scenario::{Aggregate, Case, Comparison, MetricReference};

impl Laboratory<'_> {
    /// Runs every case side by side; the outcomes are in the order of the cases.
    pub(super) fn run_all(&self, cases: &[Case]) -> Result<Vec<Outcome>, ExperimentError> {
        cases.par_iter().map(|case| self.run_one(case)).collect()
    }

    pub(super) fn run_one(&self, case: &Case) -> Result<Outcome, ExperimentError> {
        if self.stop.is_requested() {
            return Err(ExperimentError::Stopped);
        }
        Ok(run_case(case, &self.requests, &self.free_flows, &mut Unwatched)?)
    }

    /// Cases with their outcomes, in the same order.
    pub(super) fn case_runs(
        &self,
        cases: impl IntoIterator<Item = SavedCase>,
        outcomes: Vec<Outcome>,
    ) -> Vec<CaseRun> {
        let run = |(case, outcome): (SavedCase, Outcome)| {
            let passed_first = self.passed_first(&outcome);
            CaseRun { case, outcome, passed_first }
        };
        cases.into_iter().zip(outcomes).map(run).collect()
    }

    /// The metric in every outcome.
    pub(super) fn values(&self, metric: &MetricReference, outcomes: &[Outcome]) -> Vec<Option<f64>> {
        let index =
            self.requests.index(metric).expect("the laboratory requested every metric that is asked for");
        outcomes.iter().map(|outcome| outcome.metrics[index]).collect()
    }

    /// An objective's value over the outcomes, with the variance of its error where it is a mean of several runs.
    pub(super) fn objective(
        &self,
        objective: &Aggregate,
        outcomes: &[Outcome],
    ) -> (Option<f64>, Option<f64>) {
        let value = aggregate(objective, outcomes, &self.requests);
        let variance = match objective {
            Aggregate::Mean(metric) => {
                let values: Vec<f64> = self.values(metric, outcomes).into_iter().flatten().collect();
                error_variance(&values)
            }
            _ => None,
        };
        (value, variance)
    }

    /// How far every run is from violating a constraint; `None` where that cannot be said, which counts as violated.
    pub(super) fn margin(&self, constraint: &Comparison, outcomes: &[Outcome]) -> Option<f64> {
        let bound = constraint.constant_bound();
        let mut worst = f64::INFINITY;
        for value in self.values(&constraint.metric, outcomes) {
            match value {
                Some(value) => {
                    let margin = constraint.relation.margin(value, bound);
                    worst = worst.min(if constraint.relation.holds(value, bound) {
                        margin.unwrap_or(1.0)
                    } else {
                        // A strict relation is violated at its bound already, where the margin is 0.
                        margin.unwrap_or(-1.0).min(-f64::MIN_POSITIVE)
                    });
                }
                None if holds_undefined(constraint, false) => {}
                None => return None,
            }
        }
        (worst < f64::INFINITY).then_some(worst)
    }

    /// Every quantity and flag over the outcomes, for tables. Categories have no mean.
    pub(super) fn summaries(&self, outcomes: &[Outcome]) -> Vec<MetricSummary> {
        let has_mean = |reference: &&MetricReference| {
            metric(&reference.name).is_some_and(|metric| !matches!(metric.kind, MetricKind::Category(_)))
        };
        self.requests
            .iter()
            .filter(has_mean)
            .map(|reference| {
                let mut values: Vec<f64> = self.values(reference, outcomes).into_iter().flatten().collect();
                values.sort_by(f64::total_cmp);
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                MetricSummary {
                    metric: reference.label(),
                    runs: outcomes.len(),
                    defined: values.len(),
                    mean: (!values.is_empty()).then_some(mean),
                    min: values.first().copied(),
                    max: values.last().copied(),
                }
            })
            .collect()
    }

    /// Who passed first in an outcome, in the metric's own words.
    pub(super) fn passed_first(&self, outcome: &Outcome) -> Option<&'static str> {
        let index = self.requests.iter().position(|reference| reference.name == "passed_first")?;
        let MetricKind::Category(words) = metric("passed_first")?.kind else { return None };
        words.get(outcome.metrics[index]? as usize).copied()
    }
}

/// A case that was run, with what came of it.
#[derive(Debug, Clone, Serialize)]
pub struct CaseRun {
    pub case: SavedCase,
    /// Its metrics are in the order of the laboratory's requests.
    #[serde(serialize_with = "outcome_alone")]
    pub outcome: Outcome,
    pub passed_first: Option<&'static str>,
}

/// Without what the case says already.
fn outcome_alone<S: Serializer>(outcome: &Outcome, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Alone<'a> {
        ending: &'a crate::sim::Ending,
        metrics: &'a [Option<f64>],
        fingerprint: String,
    }
    let Outcome { ending, metrics, fingerprint, .. } = outcome;
    Alone { ending, metrics, fingerprint: format!("{fingerprint:016x}") }.serialize(serializer)
}

/// One metric over a set of runs; flags are shares.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MetricSummary {
    pub metric: String,
    pub runs: usize,
    /// Runs in which the metric exists.
    pub defined: usize,
    pub mean: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
}

/// Variance of the mean of some values; `None` for fewer than two.
fn error_variance(values: &[f64]) -> Option<f64> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    (values.len() > 1).then(|| squares / (count - 1.0) / count)
}
