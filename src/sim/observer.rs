//! What is told of a run while it happens, to metrics and recorders.

use serde::{Deserialize, Serialize};

use super::state::Snapshot;

/// Follows a run. Nothing it does can change the run.
pub trait Observer {
    /// Called once, with the state at time 0.
    fn begin(&mut self, _start: &Snapshot) {}

    /// Called after every step.
    fn observe(&mut self, step: &Step);
}

/// One step: between the two states positions change smoothly; event times inside are interpolated linearly.
#[derive(Debug, Clone, Copy)]
pub struct Step<'a> {
    /// At its beginning, s.
    pub time: f64,
    /// s
    pub duration: f64,
    pub before: &'a Snapshot,
    pub after: &'a Snapshot,
    /// What each pedestrian's model was up to during the step.
    pub pedestrian_modes: &'a [&'static str],
    /// What each vehicle's controller was up to during the step.
    pub vehicle_modes: &'a [&'static str],
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ending {
    pub reason: StopReason,
    /// s
    pub time: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// Every vehicle passed the finish line and every pedestrian is across.
    Completed,
    /// Two footprints met and the scenario ends on collision.
    Collision,
    /// Time was up.
    Horizon,
}
