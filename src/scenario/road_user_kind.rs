//! What somebody is who is no vehicle: on foot, or on wheels.

use serde::{Deserialize, Serialize};

use super::Shape;

/// Whether somebody walks or rides. Who rides is placed, moved and met as somebody on foot is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RoadUserKind {
    /// On foot.
    #[default]
    Pedestrian,
    /// On a bicycle.
    Cyclist,
    /// On an electric scooter, standing.
    Escooter,
}

impl RoadUserKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Pedestrian, Self::Cyclist, Self::Escooter];

    /// As files call it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pedestrian => "pedestrian",
            Self::Cyclist => "cyclist",
            Self::Escooter => "escooter",
        }
    }

    /// With its article: "a cyclist".
    pub fn noun(self) -> &'static str {
        match self {
            Self::Pedestrian => "a pedestrian",
            Self::Cyclist => "a cyclist",
            Self::Escooter => "an escooter",
        }
    }

    /// Whether they are on foot.
    pub fn is_pedestrian(&self) -> bool {
        *self == Self::Pedestrian
    }

    /// The footprint of whom nothing is said. A bicycle is Euro NCAP's bicyclist target, 1.89 m x 0.5 m; that of a scooter is ours.
    pub fn body(self) -> Shape {
        match self {
            Self::Pedestrian => Shape::Disc { radius: 0.25 },
            Self::Cyclist => Shape::Rectangle { length: 1.89, width: 0.5 },
            Self::Escooter => Shape::Rectangle { length: 1.2, width: 0.6 },
        }
    }

    /// How far ahead of the centre of that footprint the point is that they are measured by, m: of a bicycle its cranks, 0.62 m ahead of the
    /// rear axle.
    pub fn reference(self) -> f64 {
        match self {
            Self::Pedestrian | Self::Escooter => 0.0,
            Self::Cyclist => 0.015,
        }
    }
}
