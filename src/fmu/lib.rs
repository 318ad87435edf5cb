//! Functional mock-up units (FMI 2.0 and 3.0): what they say of themselves, read as data, and their libraries, loaded for co-simulation.
//!
//! [`Archive`] reads the file of one and executes nothing. [`Library`] loads native code: whoever calls it is in a process of its own,
//! which may crash.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

mod archive;
mod binding;
mod description;
mod element;
mod error;
mod library;

pub use archive::{Archive, Unpacked};
pub use description::{BaseUnit, Causality, Description, FmiVersion, Kind, Scalar, Variability};
pub use error::{FmuError, FmuRefusal};
pub use library::{Instance, Library, LibraryPlace};
