//! What is so where nothing is said.

/// What a scenario is that does not say otherwise, and whoever is in it.
pub struct Defaults;

impl Defaults {
    /// s
    pub const STEP: f64 = 0.025;
    /// s
    pub const HORIZON: f64 = 60.0;
    /// m
    pub const FINISH: f64 = 100.0;
    pub const REPEAT: u32 = 1;
    /// How far beyond the opposite kerb a pedestrian walks, m.
    pub const GOAL: f64 = 2.0;
}
