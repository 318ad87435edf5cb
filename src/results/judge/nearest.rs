//! Runs that speak against a criterion, or come nearest to that: how far from the bound, when and for whom.

use std::sync::Arc;

use serde::Serialize;

use super::per_run::PerRun;
use super::seen::{Evidence, Seen};
use crate::{Outcome, Requests, WorstRun};
use scenario::{Claim, MetricReference, Relation, Worst};

/// How many runs a finding names.
const WORST_RUNS: usize = 3;

/// The runs for which `speaks_against`, those farthest on the wrong side of the relation to `bound` first; and if there
/// are none, the run that is nearest to it.
pub(super) fn nearest(
    metric: &MetricReference,
    (relation, bound): (Relation, f64),
    values: &[Option<f64>],
    evidence: &Evidence,
    cut_off: impl Fn(usize) -> bool,
    speaks_against: impl Fn(usize) -> bool,
) -> (Vec<WorstRun>, Option<WorstRun>) {
    let smaller_is_worse = match relation {
        Relation::Greater | Relation::GreaterOrEqual => true,
        Relation::Less | Relation::LessOrEqual => false,
        Relation::Equal | Relation::NotEqual => {
            metric.known().is_some_and(|metric| metric.worst == Worst::Smallest)
        }
    };
    let badness = |value: Option<f64>| match value {
        None => f64::INFINITY,
        Some(value) if smaller_is_worse => -value,
        Some(value) => value,
    };
    let index = evidence.requests.index(metric);
    let run = |(place, (value, outcome)): (usize, (&Option<f64>, &Outcome))| {
        let critical = index.and_then(|index| outcome.critical.get(index));
        WorstRun {
            key: outcome.key.clone(),
            value: *value,
            margin: value.and_then(|value| relation.margin(value, bound)).filter(|_| !cut_off(place)),
            cut_off: cut_off(place),
            critical: critical.cloned(),
        }
    };
    let all = || values.iter().zip(evidence.outcomes).enumerate();
    let mut against: Vec<_> = all().filter(|(place, _)| speaks_against(*place)).collect();
    if against.is_empty() {
        let margin = |value: &Option<f64>| value.and_then(|value| relation.margin(value, bound));
        let near = all().filter_map(|one| Some((margin(one.1.0).filter(|_| !cut_off(one.0))?, one)));
        let nearest = near.min_by(|(left, _), (right, _)| left.total_cmp(right));
        return (Vec::new(), nearest.map(|(_, one)| run(one)));
    }
    // Who was cut off is worse than what it shows.
    let badness = |(place, (value, _)): &(usize, (&Option<f64>, &Outcome))| {
        if cut_off(*place) { f64::INFINITY } else { badness(**value) }
    };
    against.sort_by(|left, right| badness(right).total_cmp(&badness(left)));
    against.truncate(WORST_RUNS);
    (against.into_iter().map(run).collect(), None)
}

/// How one run stands to what a criterion wants of each.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunStanding {
    /// In canonical words.
    pub criterion: String,
    /// Whether the run has what the criterion wants.
    pub holds: bool,
    /// As [`WorstRun::margin`].
    pub margin: Option<f64>,
    /// The critical instant, s.
    pub time: Option<f64>,
    /// Whose value it is, by name; `None` for a metric of pedestrians.
    pub vehicle: Option<Arc<str>>,
    /// Whose value it is, by name; `None` for a metric of vehicles.
    pub pedestrian: Option<Arc<str>>,
    /// Another vehicle or a box that the vehicle touches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other: Option<Arc<str>>,
}

impl PerRun {
    /// How a run stands to it.
    pub fn standing(&self, outcome: &Outcome, requests: &Requests) -> RunStanding {
        let Claim::Runs { comparison, .. } = &self.criterion.claim else {
            unreachable!("what is wanted of each run is a comparison")
        };
        let index = requests.index(&comparison.metric);
        let value = index.and_then(|index| outcome.metrics[index]);
        let critical = index.and_then(|index| outcome.critical.get(index)).cloned().unwrap_or_default();
        RunStanding {
            criterion: self.criterion.text.clone(),
            holds: index.is_some_and(|index| Seen::of(outcome, index).holds(comparison, false)),
            margin: value
                .filter(|_| index.is_some_and(|index| Seen::of(outcome, index).is_value()))
                .and_then(|value| comparison.relation.margin(value, comparison.constant_bound())),
            time: critical.time,
            vehicle: critical.vehicle,
            pedestrian: critical.pedestrian,
            other: critical.other,
        }
    }
}
