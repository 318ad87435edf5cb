//! What a controller asks of its vehicle.

use serde::{Deserialize, Serialize};

/// The kind of [`Command`] that a controller gives and dynamics take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandKind {
    /// Positions of accelerator and brake.
    Pedals,
    /// m/s² along the path.
    Acceleration,
}

/// What a controller asks of its vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Command {
    /// Pedal positions, each 0..1.
    Pedals {
        /// How far the accelerator is pressed, 0..1.
        throttle: f64,
        /// How far the brake is pressed, 0..1.
        brake: f64,
    },
    /// m/s²
    Acceleration(f64),
}

impl Command {
    /// Which kind of command it is.
    pub fn kind(self) -> CommandKind {
        match self {
            Self::Pedals { .. } => CommandKind::Pedals,
            Self::Acceleration(_) => CommandKind::Acceleration,
        }
    }

    /// Whether a vehicle can follow it.
    pub fn is_finite(self) -> bool {
        match self {
            Self::Pedals { throttle, brake } => throttle.is_finite() && brake.is_finite(),
            Self::Acceleration(acceleration) => acceleration.is_finite(),
        }
    }
}
