//! Each criterion of a trial against the trial's outcomes.

use serde::Serialize;

use super::confidence::{self, Bounds};
use super::nearest::{WorstRun, nearest};
use super::statistics;
use super::stopping::Stopping;
use super::vacuity::{self, Vacuity};
use super::verdict::Verdict;
use crate::run::{Outcome, Requests};
use crate::scenario::{
    Aggregate, Claim, Comparison, Criterion, MetricReference, Origin, Relation, WhenUndefined, constant,
};

/// A trial's verdict: the worst of its findings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrialVerdict {
    pub verdict: Verdict,
    pub findings: Vec<Finding>,
    /// Where runs were added until the criteria were decided: how many it took and why there were no more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopping: Option<Stopping>,
}

/// What a finding's `observed` and `bound` are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// The share of runs that hold, where every run has to.
    EveryRun,
    /// The share of runs that hold.
    Share,
    /// The number of runs that hold.
    Count,
    /// An aggregate in the metric's own unit.
    Value,
}

/// One criterion's verdict and what it rests on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    pub criterion: String,
    pub origin: Origin,
    pub verdict: Verdict,
    /// The metric that the criterion is about.
    pub metric: String,
    pub measure: Measure,
    /// Where runs are added, those after which the criterion was decided: the trial may have had more for others.
    pub runs: usize,
    /// Runs in which the comparison holds, or, for aggregates of values, in which the metric exists.
    pub holding: usize,
    /// Runs in which the metric does not exist.
    pub undefined: usize,
    /// The aggregate's value or the share of runs; `None` if no run gives one.
    pub observed: Option<f64>,
    /// What it was compared to.
    pub bound: f64,
    /// Signed distance from failing in the unit of what was compared; negative when failing.
    pub margin: Option<f64>,
    /// Interval of the estimate at the stated confidence.
    pub interval: Option<(f64, f64)>,
    /// The runs that speak most against the criterion, worst first.
    pub worst: Vec<WorstRun>,
    /// Where no run speaks against it, the one nearest to that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub closest: Option<WorstRun>,
    /// Why it was never put to the test, if it passed without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vacuous: Option<Vacuity>,
}

/// Judges one trial. `requests` says which metric is where in the outcomes.
pub fn judge(criteria: &[Criterion], outcomes: &[Outcome], requests: &Requests) -> TrialVerdict {
    let evidence = Evidence { outcomes, requests, bounds: Bounds::Fixed };
    let findings = criteria.iter().map(|criterion| find(criterion, &evidence)).collect();
    TrialVerdict::of(findings, criteria, outcomes)
}

impl TrialVerdict {
    /// Of a trial whose runs were fixed beforehand.
    pub(super) fn of(mut findings: Vec<Finding>, criteria: &[Criterion], outcomes: &[Outcome]) -> Self {
        vacuity::mark(&mut findings, criteria, outcomes);
        let verdict = findings.iter().map(|finding| finding.verdict).max().unwrap_or(Verdict::Passed);
        Self { verdict, findings, stopping: None }
    }
}

/// What a criterion is judged by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Evidence<'a> {
    pub outcomes: &'a [Outcome],
    pub requests: &'a Requests,
    pub bounds: Bounds,
}

/// One criterion against the evidence.
pub(super) fn find(criterion: &Criterion, evidence: &Evidence) -> Finding {
    let Evidence { outcomes, requests, bounds } = *evidence;
    match &criterion.claim {
        Claim::Runs { comparison, share, confidence } => {
            runs(criterion, comparison, *share, *confidence, evidence)
        }
        Claim::Aggregate { aggregate, relation, bound, when_undefined, confidence } => {
            let bound = constant(bound);
            match aggregate {
                Aggregate::Rate(comparison) => {
                    let held = holding(comparison, outcomes, requests);
                    let rate = held.count as f64 / outcomes.len() as f64;
                    let finding = against(criterion, Measure::Share, *relation, bound, Some(rate), &held);
                    let finding = with_confidence_in_share(finding, *relation, *confidence, bounds);
                    with_worst_of_rate(finding, comparison, *relation, &held, evidence)
                }
                Aggregate::Count(comparison) => {
                    let held = holding(comparison, outcomes, requests);
                    let count = held.count as f64;
                    let finding = against(criterion, Measure::Count, *relation, bound, Some(count), &held);
                    with_worst_of_rate(finding, comparison, *relation, &held, evidence)
                }
                Aggregate::Mean(metric)
                | Aggregate::Median(metric)
                | Aggregate::Min(metric)
                | Aggregate::Max(metric)
                | Aggregate::Std(metric)
                | Aggregate::Quantile(_, metric) => {
                    let values = values(metric, outcomes, requests);
                    let defined: Vec<f64> = values.iter().copied().flatten().collect();
                    let undefined = values.len() - defined.len();
                    let held = Held { count: defined.len(), undefined, values };
                    let observed = aggregate_of(aggregate, defined.clone());
                    let mut finding = against(criterion, Measure::Value, *relation, bound, observed, &held);
                    if let (Some(confidence), Some(_)) = (confidence, observed) {
                        let seed = outcomes.first().map_or(0, |outcome| outcome.seed);
                        let interval = bounds.of_values(aggregate, &defined, *confidence, seed);
                        finding.interval = interval.map(|interval| (interval.low, interval.high));
                        finding.verdict = interval.map_or(Verdict::Inconclusive, |interval| {
                            confidence::decide(*relation, interval, bound)
                        });
                    }
                    if observed.is_none() && *when_undefined == WhenUndefined::Passes {
                        finding.verdict = Verdict::Passed;
                    }
                    finding.worst = nearest(metric, (*relation, bound), &held.values, evidence, |_| true).0;
                    finding
                }
            }
        }
    }
}

/// Where a confidence is stated, the verdict rests on the bounds of the share and not on the share that was seen.
fn with_confidence_in_share(
    finding: Finding,
    relation: Relation,
    confidence: Option<f64>,
    bounds: Bounds,
) -> Finding {
    let Some(confidence) = confidence else { return finding };
    let interval = bounds.of_share(finding.holding, finding.runs, confidence);
    Finding {
        verdict: confidence::decide(relation, interval, finding.bound),
        interval: Some((interval.low, interval.high)),
        ..finding
    }
}

/// An aggregate over runs; `None` where it does not exist. For rates and counts a run whose metric does not exist counts
/// as its comparison says.
pub fn aggregate(aggregate: &Aggregate, outcomes: &[Outcome], requests: &Requests) -> Option<f64> {
    match aggregate {
        Aggregate::Rate(comparison) => {
            let held = holding(comparison, outcomes, requests);
            (!outcomes.is_empty()).then(|| held.count as f64 / outcomes.len() as f64)
        }
        Aggregate::Count(comparison) => Some(holding(comparison, outcomes, requests).count as f64),
        _ => aggregate_of(
            aggregate,
            values(aggregate.metric(), outcomes, requests).into_iter().flatten().collect(),
        ),
    }
}

/// The metric of every run and in how many runs a comparison over it holds.
struct Held {
    count: usize,
    undefined: usize,
    values: Vec<Option<f64>>,
}

fn runs(
    criterion: &Criterion,
    comparison: &Comparison,
    share: Option<f64>,
    confidence: Option<f64>,
    evidence: &Evidence,
) -> Finding {
    let Evidence { outcomes, requests, bounds } = *evidence;
    let held = holding(comparison, outcomes, requests);
    let bound = comparison.constant_bound();
    let rate = held.count as f64 / outcomes.len() as f64;
    let mut finding = match share {
        Some(share) => {
            let finding =
                against(criterion, Measure::Share, Relation::GreaterOrEqual, share, Some(rate), &held);
            with_confidence_in_share(finding, Relation::GreaterOrEqual, confidence, bounds)
        }
        None => against(criterion, Measure::EveryRun, Relation::GreaterOrEqual, 1.0, Some(rate), &held),
    };
    if share.is_none() {
        // The run nearest to failing says more than the share of runs.
        let margins =
            held.values.iter().flatten().filter_map(|value| comparison.relation.margin(*value, bound));
        finding.margin = margins.reduce(f64::min);
    }
    let wanted = (comparison.relation, bound);
    let (worst, closest) = nearest(&comparison.metric, wanted, &held.values, evidence, |value| {
        !comparison_holds(comparison, bound, value)
    });
    Finding { worst, closest, ..finding }
}

/// Names the runs that a rate or count has too many of: those that hold where it is bounded above, else the others.
fn with_worst_of_rate(
    finding: Finding,
    comparison: &Comparison,
    relation: Relation,
    held: &Held,
    evidence: &Evidence,
) -> Finding {
    let bound = comparison.constant_bound();
    let too_many_hold = matches!(relation, Relation::Less | Relation::LessOrEqual);
    let against = |value: Option<f64>| comparison_holds(comparison, bound, value) == too_many_hold;
    let direction = if too_many_hold { comparison.relation.opposite() } else { comparison.relation };
    let (worst, closest) = nearest(&comparison.metric, (direction, bound), &held.values, evidence, against);
    Finding { worst, closest, ..finding }
}

/// A finding that compares `observed` to `bound`.
fn against(
    criterion: &Criterion,
    measure: Measure,
    relation: Relation,
    bound: f64,
    observed: Option<f64>,
    held: &Held,
) -> Finding {
    let holds = observed.is_some_and(|value| relation.holds(value, bound));
    Finding {
        criterion: criterion.text.clone(),
        origin: criterion.origin.clone(),
        verdict: if holds { Verdict::Passed } else { Verdict::Failed },
        metric: criterion.claim.metric().name.clone(),
        measure,
        runs: held.values.len(),
        holding: held.count,
        undefined: held.undefined,
        observed,
        bound,
        margin: observed.and_then(|value| relation.margin(value, bound)),
        interval: None,
        worst: Vec::new(),
        closest: None,
        vacuous: None,
    }
}

fn holding(comparison: &Comparison, outcomes: &[Outcome], requests: &Requests) -> Held {
    let bound = comparison.constant_bound();
    let values = values(&comparison.metric, outcomes, requests);
    Held {
        count: values.iter().filter(|value| comparison_holds(comparison, bound, **value)).count(),
        undefined: values.iter().filter(|value| value.is_none()).count(),
        values,
    }
}

/// Whether a comparison holds for a metric's value, which may not exist.
pub fn holds(comparison: &Comparison, value: Option<f64>) -> bool {
    comparison_holds(comparison, comparison.constant_bound(), value)
}

fn comparison_holds(comparison: &Comparison, bound: f64, value: Option<f64>) -> bool {
    match value {
        Some(value) => comparison.relation.holds(value, bound),
        None => comparison.when_undefined == WhenUndefined::Passes,
    }
}

fn values(metric: &MetricReference, outcomes: &[Outcome], requests: &Requests) -> Vec<Option<f64>> {
    let index = requests.index(metric).expect("every criterion's metric was requested before the runs");
    outcomes.iter().map(|outcome| outcome.metrics[index]).collect()
}

/// `None` where the aggregate does not exist: of no values, or the spread of one.
fn aggregate_of(aggregate: &Aggregate, mut values: Vec<f64>) -> Option<f64> {
    // Sorted, so that sums do not depend on the order of the runs.
    values.sort_by(f64::total_cmp);
    match aggregate {
        Aggregate::Mean(_) => statistics::mean(&values),
        Aggregate::Median(_) => statistics::median(&values),
        Aggregate::Min(_) => values.first().copied(),
        Aggregate::Max(_) => values.last().copied(),
        Aggregate::Std(_) => statistics::std(&values),
        Aggregate::Quantile(level, _) => statistics::quantile(&values, *level),
        Aggregate::Rate(_) | Aggregate::Count(_) => {
            unreachable!("rates and counts are not aggregates of values")
        }
    }
}
