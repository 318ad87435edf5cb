//! Testing automated-vehicle controllers against pedestrians who behave like people.

pub mod calibrate;
pub mod cli;
pub mod corpus;
pub mod dispatch;
pub mod experiment;
pub mod judge;
pub mod lang;
pub mod metrics;
pub mod optimise;
pub mod pedestrian;
pub mod plan;
pub mod report;
pub mod run;
pub mod scenario;
pub mod shrink;
pub mod sim;
pub mod testing;
pub mod vehicle;
