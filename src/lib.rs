//! Testing automated-vehicle controllers against pedestrians who behave like people.

pub mod scenario;
pub mod sim;
