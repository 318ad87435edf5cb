//! Times between two centres that pass although the bodies were in the shared area at the same time.

use crate::{Finding, Outcome, Requests, Verdict};
use scenario::{Criterion, MetricReference};

/// The time between the centres, and that between the bodies.
const PET: &str = "pet";
const PET_AREA: &str = "pet_area";

/// Says of each finding on `pet` that passed in how many runs the bodies used the shared area at the same time.
pub(super) fn mark(
    findings: &mut [Finding],
    criteria: &[Criterion],
    outcomes: &[Outcome],
    requests: &Requests,
) {
    let Some(area) = requests.iter().position(is_area) else { return };
    for (finding, criterion) in findings.iter_mut().zip(criteria) {
        let reference = criterion.claim.metric();
        if reference.name() != PET || finding.verdict != Verdict::Passed {
            continue;
        }
        let Some(own) = requests.index(reference) else { continue };
        let overlaps = |outcome: &&Outcome| {
            let [centres, bodies] = [own, area].map(|index| outcome.metrics.get(index).copied().flatten());
            centres.is_some_and(|time| time > 0.0)
                && bodies == Some(0.0)
                && is_about(reference, outcome, area)
        };
        finding.overlapping = outcomes.iter().filter(overlaps).count();
    }
}

/// The time between bodies among the metrics that are measured, where the time between centres is asked for: it has to be measured beside.
pub fn measured_beside<'r>(asked: &Requests, measured: &'r Requests) -> Option<&'r MetricReference> {
    asked.iter().any(|one| one.name() == PET).then(|| measured.iter().find(|one| is_area(one))).flatten()
}

/// Whether a metric is the time between bodies, of all pairs and with its defaults.
fn is_area(reference: &MetricReference) -> bool {
    reference.name() == PET_AREA && reference.pair.is_none() && reference.settings.0.is_empty()
}

/// Whether the pair of which the time between bodies is the smallest is one that a reference is about.
fn is_about(reference: &MetricReference, outcome: &Outcome, area: usize) -> bool {
    if reference.pair.is_none() {
        return true;
    }
    match outcome.critical.get(area) {
        Some(critical) => {
            critical.vehicle.as_deref().is_some_and(|name| reference.is_of_vehicle(name))
                && critical.pedestrian.as_deref().is_some_and(|name| reference.is_of(name))
        }
        None => outcome.presences.len() == 1,
    }
}
