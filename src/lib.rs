//! Testing automated-vehicle controllers against pedestrians who behave like people.

pub mod metrics;
pub mod pedestrian;
pub mod plan;
pub mod scenario;
pub mod sim;
pub mod vehicle;
