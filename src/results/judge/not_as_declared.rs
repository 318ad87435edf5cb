//! What went otherwise than a scenario declares, whatever its criteria say: steps of scripts that never began, vehicles that left the road, streams that
//! were over before somebody went.

use crate::{LeftRoad, Outcome, OutlastedRuns, WaitingStep};
use scenario::Criterion;

/// The steps of scripts that began in no run.
pub(super) fn never_began(outcomes: &[Outcome]) -> Vec<WaitingStep> {
    let Some((first, others)) = outcomes.split_first() else { return Vec::new() };
    let never = |step: &&WaitingStep| others.iter().all(|outcome| outcome.waiting_steps.contains(step));
    first.waiting_steps.iter().filter(never).cloned().collect()
}

/// The metric that says whether a vehicle touches a kerb.
const KERB_CONTACT: &str = "kerb_contact";

/// The vehicles whose bodies left their carriageways, unless a criterion is about that.
pub(super) fn left_road(criteria: &[Criterion], outcomes: &[Outcome]) -> Vec<LeftRoad> {
    if criteria.iter().any(|criterion| criterion.claim.metric().name() == KERB_CONTACT) {
        return Vec::new();
    }
    let mut found: Vec<LeftRoad> = Vec::new();
    for vehicle in outcomes.iter().flat_map(|outcome| &outcome.left_road) {
        match found.iter_mut().find(|known| known.vehicle == *vehicle) {
            Some(known) => known.runs += 1,
            None => found.push(LeftRoad { vehicle: vehicle.clone(), runs: 1, of: outcomes.len() }),
        }
    }
    found
}

/// The streams whose last vehicle had passed before somebody went across.
pub(super) fn outlasted(outcomes: &[Outcome]) -> Vec<OutlastedRuns> {
    let mut found: Vec<OutlastedRuns> = Vec::new();
    for outlasted in outcomes.iter().flat_map(|outcome| &outcome.outlasted) {
        match found.iter_mut().find(|known| known.outlasted == *outlasted) {
            Some(known) => known.runs += 1,
            None => found.push(OutlastedRuns { outlasted: outlasted.clone(), runs: 1, of: outcomes.len() }),
        }
    }
    found
}
