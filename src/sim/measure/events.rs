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

/// The part of the way from `from` to `to` that lies inside two borders, as shares of the way.
pub fn part_within(from: f64, to: f64, (low, high): (f64, f64)) -> Option<(f64, f64)> {
    if from == to {
        return (low < from && from < high).then_some((0.0, 1.0));
    }
    let (one, other) = ((low - from) / (to - from), (high - from) / (to - from));
    let (enter, leave) = (one.min(other).max(0.0), one.max(other).min(1.0));
    (enter < leave).then_some((enter, leave))
}
/// The smallest value of a convex function between 0 and 1, and where it has it.
pub fn least_of(at: &mut dyn FnMut(f64) -> f64) -> (f64, f64) {
    // Still coming nearer at the end: then the end is nearest.
    let end = at(1.0);
    if at(1.0 - 1e-6) >= end {
        return (end, 1.0);
    }
    // Golden section search: the step shrinks to 1e-6 of itself, and the minimum is flat there.
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let (mut low, mut high) = (0.0, 1.0);
    let (mut left, mut right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut at_left, mut at_right) = (at(left), at(right));
    for _ in 0..28 {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - GOLDEN * (high - low);
            at_left = at(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + GOLDEN * (high - low);
            at_right = at(right);
        }
    }
    if at_left <= at_right { (at_left, left) } else { (at_right, right) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_step_within_a_band() {
        assert_eq!(part_within(-3.0, -1.0, (-2.0, 2.0)), Some((0.5, 1.0)));
        assert_eq!(part_within(1.0, 5.0, (-2.0, 2.0)), Some((0.0, 0.25)));
        assert_eq!(part_within(-4.0, 4.0, (-2.0, 2.0)), Some((0.25, 0.75)));
        assert_eq!(part_within(1.0, 1.0, (-2.0, 2.0)), Some((0.0, 1.0)));
        assert_eq!(part_within(2.0, 2.0, (-2.0, 2.0)), None);
        assert_eq!(part_within(3.0, 5.0, (-2.0, 2.0)), None);
    }
}
