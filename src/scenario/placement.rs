//! Where road users are, from when on, and what they take up.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// Where a vehicle's centre is at time 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VehicleStart {
    /// This many metres before the middle of the crossing.
    Distance(f64),
    /// At the time to arrival `time` (s) at the line across the road at world `x` (m), for a part of the vehicle and
    /// at the speed it cruises at once settled.
    TimeToArrival {
        /// s
        time: f64,
        /// The part of the vehicle that arrives.
        reference: VehicleReference,
        /// The line's place, m in the world frame.
        x: f64,
    },
}

/// The part of a vehicle that distances and times to arrival are measured from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VehicleReference {
    /// The middle of its length and width.
    #[default]
    Centre,
    /// The middle of its front edge.
    Front,
}

impl VehicleReference {
    /// How far it is ahead of the centre of a vehicle of this length, m.
    pub fn ahead_of_centre(self, length: f64) -> f64 {
        match self {
            Self::Centre => 0.0,
            Self::Front => length / 2.0,
        }
    }
}

/// A pedestrian's footprint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Looks alike from everywhere.
    Disc {
        /// m
        radius: f64,
    },
    /// Turns with the pedestrian's heading.
    Rectangle {
        /// Along the heading, m.
        length: f64,
        /// Across the heading, m.
        width: f64,
    },
}

impl Shape {
    /// Along the heading and across it, m; of a disc, those of the square around it.
    pub fn extents(self) -> (f64, f64) {
        match self {
            Self::Disc { radius } => (2.0 * radius, 2.0 * radius),
            Self::Rectangle { length, width } => (length, width),
        }
    }
}

/// A place in the world frame (see [`Road`](super::Road)) in m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// Along the road, m; 0 is the middle of the crossing.
    pub x: f64,
    /// Across the road, m; 0 is the centre of lane 0.
    pub y: f64,
}

impl From<Position> for Vector2<f64> {
    fn from(Position { x, y }: Position) -> Self {
        Self::new(x, y)
    }
}

/// When a pedestrian that is there may go.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MayGo {
    /// As soon as it appears.
    #[default]
    AtOnce,
    /// So long after it has appeared, s; above 0.
    After(f64),
    /// At the first step at which the time to arrival of vehicle `vehicle` at the pedestrian's place along the road is at most `time`
    /// (s), or `or_after` (s) after it has appeared, whichever is earlier.
    TimeToArrival {
        /// Index into [`World::vehicles`](crate::World::vehicles).
        vehicle: usize,
        /// The part of the vehicle that arrives.
        reference: VehicleReference,
        /// s
        time: f64,
        /// s
        or_after: f64,
    },
}

impl MayGo {
    pub(crate) fn is_at_once(&self) -> bool {
        *self == Self::AtOnce
    }

    /// The time (s) from appearing until it may go, where `time_to_arrival` is that of a vehicle's part when it appears, s.
    pub fn wait(&self, time_to_arrival: impl FnOnce(usize, VehicleReference) -> f64) -> f64 {
        match *self {
            Self::AtOnce => 0.0,
            Self::After(time) => time,
            Self::TimeToArrival { vehicle, reference, time, or_after } => {
                let left = time_to_arrival(vehicle, reference) - time;
                if left.is_finite() { left.clamp(0.0, or_after) } else { or_after }
            }
        }
    }

    /// The longest time (s) from appearing until it may go.
    pub fn longest(&self) -> f64 {
        match *self {
            Self::AtOnce => 0.0,
            Self::After(time) | Self::TimeToArrival { or_after: time, .. } => time,
        }
    }
}

/// When a pedestrian enters the world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Appearance {
    /// At a time in s.
    At(f64),
    /// At the first step at which the time to arrival of vehicle `vehicle` at the pedestrian's place along the road
    /// is at most `time` (s).
    TimeToArrival {
        /// Index into [`World::vehicles`](crate::World::vehicles).
        vehicle: usize,
        /// The part of the vehicle that arrives.
        reference: VehicleReference,
        /// s
        time: f64,
    },
    /// At the very moment, also within a step, from which on vehicle `vehicle` would take `time` (s) at the speed that it has until its
    /// front is at `place` (m) of its path.
    Meeting {
        /// Index into [`World::vehicles`](crate::World::vehicles).
        vehicle: usize,
        /// s
        time: f64,
        /// m
        place: f64,
    },
}
