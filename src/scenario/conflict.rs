//! Conflicts: where the way of a person meets the path of a vehicle.

/// Where the straight way of a person meets the path of a vehicle; see [`Path::conflict`](super::Path::conflict).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conflict {
    /// Along the vehicle's path, m behind the middle of the crossing.
    pub place: f64,
    /// From where the person is, along its way, m; negative once past it.
    pub distance: f64,
}

/// Half the length (m) of the conflict along the path of the first of two who meet at a right angle: the length of its own
/// body and the width of the other's, (length, width) each.
pub fn half_extent(own: (f64, f64), other: (f64, f64)) -> f64 {
    (own.0 + other.1) / 2.0
}
