//! What the numbers of a scenario may be; the checker and the plan both read these.

use super::Dimension;

/// Bounds of a number in SI units, both included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    pub dimension: Dimension,
    pub range: (f64, f64),
}

const fn limit(dimension: Dimension, low: f64, high: f64) -> Limit {
    Limit { dimension, range: (low, high) }
}

pub const STEP: Limit = limit(Dimension::TIME, 0.000_1, 1.0);
pub const HORIZON: Limit = limit(Dimension::TIME, 0.1, 3600.0);
pub const FINISH: Limit = limit(Dimension::LENGTH, 0.0, 10_000.0);
pub const LANE_WIDTH: Limit = limit(Dimension::LENGTH, 1.0, 20.0);
pub const SPEED_LIMIT: Limit = limit(Dimension::SPEED, 0.0, 100.0);
/// Length and width of road users.
pub const SIZE: Limit = limit(Dimension::LENGTH, 0.1, 30.0);
pub const RADIUS: Limit = limit(Dimension::LENGTH, 0.01, 5.0);
pub const VEHICLE_SPEED: Limit = limit(Dimension::SPEED, 0.0, 100.0);
pub const VEHICLE_START: Limit = limit(Dimension::LENGTH, 0.0, 10_000.0);
pub const VEHICLE_ARRIVAL: Limit = limit(Dimension::TIME, 0.0, 600.0);
/// From kerb or lane centre, as it is written.
pub const PEDESTRIAN_START: Limit = limit(Dimension::LENGTH, -100.0, 100.0);
pub const ALONG: Limit = limit(Dimension::LENGTH, -100.0, 100.0);
pub const GOAL: Limit = limit(Dimension::LENGTH, -10.0, 100.0);
pub const APPEARS_AT: Limit = limit(Dimension::TIME, 0.0, 3600.0);
pub const APPEARS_WHEN: Limit = limit(Dimension::TIME, 0.0, 600.0);
