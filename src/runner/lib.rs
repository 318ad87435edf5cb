//! Suites are planned, run and judged, and what blocks ask of them is searched, tuned and evaluated.
//!
//! [`project`] opens what files say, [`plan`] makes cases of it, [`run`] makes runs of these on an executor, [`experiment`]
//! are the blocks, and a [`session`] does all that a user asked for; [`shards`] are its runs on many machines.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

pub mod baseline;
pub mod corpus;
pub mod diff;
pub mod experiment;
pub mod gap_choice;
pub mod plan;
pub mod project;
pub mod run;
pub mod session;
pub mod shards;
pub mod shrink;
pub mod watch;
pub mod why;
