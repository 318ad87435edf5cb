//! Which way traffic drives along a road, and from which side people cross it.

use serde::{Deserialize, Serialize};

/// Which way traffic drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Along +x.
    Forward,
    /// Along -x.
    Backward,
}

impl Direction {
    /// Of the direction along x.
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
        }
    }
}

/// The side of the road that a pedestrian comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The kerb beside lane 0; the pedestrian walks towards +y.
    Near,
    /// The opposite kerb; the pedestrian walks towards -y.
    Far,
}

impl Side {
    /// The other side.
    pub fn opposite(self) -> Self {
        match self {
            Self::Near => Self::Far,
            Self::Far => Self::Near,
        }
    }

    /// Sign of the walking direction along y.
    pub fn walking_sign(self) -> f64 {
        match self {
            Self::Near => 1.0,
            Self::Far => -1.0,
        }
    }
}
