//! Models that only know people on foot or on bicycles, or only how to cross a road.

use scenario::{PedestrianContext, RoadUserKind};
use sim::ModelError;

/// Whether the pedestrian is on foot, as the model of this name needs it.
///
/// # Errors
/// If they ride.
pub fn check_on_foot(context: &PedestrianContext, model: &str) -> Result<(), ModelError> {
    let kind = context.setup.kind;
    if kind.is_pedestrian() {
        return Ok(());
    }
    Err(ModelError::with_hint(
        format!("`{model}` is about people on foot, and this is {}", kind.noun()),
        match kind {
            RoadUserKind::Cyclist => {
                "take `yielding_cyclist`, `scripted` or `timeline`, or let it be a `pedestrian`"
            }
            _ => "take `scripted` or `timeline`, or let it be a `pedestrian`",
        },
    ))
}

/// Whether the pedestrian is on a bicycle, as the model of this name needs it.
///
/// # Errors
/// If they walk or ride something else.
pub fn check_on_bicycle(context: &PedestrianContext, model: &str) -> Result<(), ModelError> {
    let kind = context.setup.kind;
    if kind == RoadUserKind::Cyclist {
        return Ok(());
    }
    Err(ModelError::with_hint(
        format!("`{model}` is about people on bicycles, and this is {}", kind.noun()),
        "let it be a `cyclist`, or take `scripted` or `timeline`",
    ))
}

/// Whether the pedestrian is on foot and its way leads across the road, as the model of this name needs it.
///
/// # Errors
/// If they ride, and if their way leads along a lane.
pub fn check_across(context: &PedestrianContext, model: &str) -> Result<(), ModelError> {
    check_on_foot(context, model)?;
    if context.setup.crosses(&context.world.road) {
        return Ok(());
    }
    Err(ModelError::with_hint(
        format!("`{model}` is about people who cross a road, and this one walks along a lane"),
        "take `scripted`, `timeline` or `social_force`, or let it cross",
    ))
}
