//! Nobody starts inside another body.

use super::error::PlanError;
use scenario::{DeclaredVehicleStart, Scenario, World};
use sim::{self, Solid};

/// # Errors
/// The first two bodies of the world, which `scenario` was resolved to, that are inside each other where they begin.
pub fn refuse_overlaps(scenario: &Scenario, world: &World) -> Result<(), PlanError> {
    let Some((first, second)) = sim::overlaps(world).into_iter().next() else { return Ok(()) };
    // A pedestrian is more likely in the wrong place than a vehicle, and a vehicle than a box.
    let (who, other) = match (first, second) {
        (Solid::Vehicle(_), Solid::Pedestrian(_)) => (second, first),
        _ => (first, second),
    };
    let kind = |solid: Solid| match solid {
        Solid::Vehicle(_) => "vehicle",
        Solid::Pedestrian(_) => "pedestrian",
        Solid::Box(_) => "box",
    };
    let (origin, hint) = match who {
        Solid::Vehicle(index) => {
            let declared = scenario.vehicle(&world.vehicles[index].name);
            let origin = declared.map_or(&scenario.origin, |declared| &declared.origin);
            match declared.map(|declared| &declared.start) {
                Some(DeclaredVehicleStart::Stream(_)) => {
                    (origin, "`lane` and `first` say where its stream starts")
                }
                _ => (origin, "`lane` and `start … before crossing` say where it starts"),
            }
        }
        Solid::Pedestrian(index) => (
            &scenario.pedestrians[index].origin,
            "`from`, `along` and `start … from kerb` say where it starts, `appears` when",
        ),
        Solid::Box(_) => (&scenario.origin, "move the box"),
    };
    let (own, others) = (who.name(world), other.name(world));
    let message = format!("{} `{own}` starts inside {} `{others}`", kind(who), kind(other));
    Err(PlanError::new(origin, message).with_hint(hint))
}
