//! What happens between a vehicle and a pedestrian, whichever way it is found out, and what it is worked out with.

use nalgebra::Vector2;

use crate::PedestrianState;
use scenario::{Located, Shape};

/// A pedestrian's centre passes the centre line of a vehicle's lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passing {
    /// s
    pub time: f64,
    /// The conflict point, as a distance along the vehicle's lane behind the middle of the crossing, m.
    pub place: f64,
    /// Whether they pass it from the side that they started from.
    pub towards_goal: bool,
}

/// A stay of a pedestrian's footprint in what a vehicle's footprint sweeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Visit {
    /// s
    pub from: f64,
    /// s; infinite while it lasts.
    pub to: f64,
    /// Extent of the footprint along the vehicle's lane over the visit, m.
    pub low: f64,
    /// The other end of that extent, m.
    pub high: f64,
}

/// Half the extent of a footprint along a path and across it, m, where it is.
#[inline]
pub fn half_extent(person: &PedestrianState, place: &Located) -> Vector2<f64> {
    half_extent_along(person, place.heading)
}

/// Half the extent of a footprint along a direction and across it, m.
#[inline]
pub fn half_extent_along(person: &PedestrianState, direction: Vector2<f64>) -> Vector2<f64> {
    match person.shape {
        Shape::Disc { radius } => Vector2::new(radius, radius),
        Shape::Rectangle { length, width } => {
            let forward = direction.dot(&person.heading).abs();
            let sideways = direction.perp(&person.heading).abs();
            Vector2::new(length * forward + width * sideways, length * sideways + width * forward) / 2.0
        }
    }
}

/// The value at a share `part` (0..1) of the way from one value to another.
pub fn lerp(from: f64, to: f64, part: f64) -> f64 {
    from + part * (to - from)
}

/// The share of a step after which a rising quantity reaches `line`.
pub fn rising(before: f64, after: f64, line: f64) -> Option<f64> {
    (before < line && after >= line).then(|| (line - before) / (after - before))
}
