//! Engines that have commands done on other machines: Ray and Slurm, as they are.
//!
//! An [`Engine`] is given [`Task`]s and says of each how it ended. Where and when tasks are done is the engine's matter, and so is that a task
//! whose worker is lost is done again. A task that came to its end with an exit code, whichever, has a result and is not done again. Nothing
//! here knows what the commands are for.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

mod client;
mod error;
mod jobs;
mod quote;
mod ray;
mod slices;
mod slurm;
mod submission;
mod task;

pub use error::EngineError;
pub use ray::{RAY_VERSION, Ray};
pub use slices::{EngineName, EngineOptions, run_slices, slice_output};
pub use slurm::Slurm;
pub use task::{EndedTask, Engine, EngineEvent, Task, TaskEnd};
