//! Testing automated-vehicle controllers against pedestrians who behave like people.

// What `clippy.toml` bans is banned from the program; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

pub mod calibrate;
pub mod cli;
pub mod console;
pub mod corpus;
pub mod escape;
pub mod experiment;
pub mod files;
pub mod judge;
pub mod lang;
pub mod metrics;
pub mod models;
pub mod numbers;
pub mod optimise;
pub mod pedestrian;
pub mod plan;
pub mod project;
pub mod registry;
pub mod report;
pub mod results;
pub mod run;
pub mod runner;
pub mod scenario;
pub mod shrink;
pub mod sim;
pub mod testing;
pub mod vehicle;
