//! Numbers that chance has a part in: seeds and streams, designs, distributions, summaries, intervals and tests.
//!
//! Pure functions: the same numbers in give the same numbers out. What is random is drawn from a given seed. The room knows
//! nothing of simulations and imports no other one.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

pub mod design;
pub mod distributions;
pub mod inference;
pub mod json;
pub mod lanes;
pub mod random;
pub mod rare;
pub mod summary;
