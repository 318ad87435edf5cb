//! Models that only know how to cross a road.

use scenario::PedestrianContext;
use sim::ModelError;

/// Whether the pedestrian's way leads across the road, as the model of this name needs it.
///
/// # Errors
/// If it leads along a lane.
pub fn check_across(context: &PedestrianContext, model: &str) -> Result<(), ModelError> {
    if context.setup.crosses(&context.world.road) {
        return Ok(());
    }
    Err(ModelError::with_hint(
        format!("`{model}` is about people who cross a road, and this one walks along a lane"),
        "take `scripted`, `timeline` or `social_force`, or let it cross",
    ))
}
