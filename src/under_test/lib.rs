//! Users' own controllers: programs that decide for vehicles, started, asked and watched as child processes.
//!
//! [`ProcessPool`] holds the processes of the programs that may be started, [`Process`] is one that has said hello, and
//! `wire` is what is said to it. What a program does that it must not is a [`ProgramFault`]. Nothing here knows what runs are for.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

mod answer_times;
mod child;
#[cfg(feature = "fmu")]
mod co_simulation;
mod conformance;
mod conversation;
#[cfg(feature = "wasm")]
mod guest;
mod hello;
mod log;
mod lookup;
#[cfg(not(feature = "wasm"))]
mod no_guest;
mod parent;
mod permission;
mod pool;
mod process;
mod process_group;
mod quote;
mod scenes;
mod start;
mod strict_json;
mod supervise;
mod watchdog;
mod wire;
mod wire_record;

pub use answer_times::AnswerClock;
#[cfg(feature = "fmu")]
pub use co_simulation::host as fmu_host;
pub use conformance::{Conformance, TriedTimes, again, conformance};
pub use conversation::{AnswerDifference, AskedDecision, Conversation, Spoken};
pub use hello::{Hello, KnowsMore};
pub use parent::Parent;
pub use permission::{ALLOW_RUN, Allowed, AllowedError, Permission};
pub use pool::{AcquiredProcesses, Prepared, ProcessPool, ProgramUse};
pub use process::{Failed, Process};
pub use scenario::{FaultKind, ProgramFault};
pub use start::{StartError, StartProblem};
pub use supervise::supervise_if_asked;
pub use wire::{Answered, Decision, DueDecision, MoreTables, Opened};
pub use wire_record::{WireRecord, WireRecordError, read_conversations};
