//! The only way to and from files: one atomic writer, one appending log, one bounded reader.
//!
//! Everything else in the program goes through these; `clippy.toml` forbids the functions of the standard library that
//! would go around them. What is promised, and which test holds it, stands in `docs/reliability.md`.

// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]
#![allow(clippy::disallowed_methods, reason = "this is where they are wrapped")]

mod batch;
mod changes;
mod destination;
pub mod escape;
mod folder;
mod in_place;
mod letters;
mod log;
mod log_reader;
mod log_tail;
mod pieces;
mod read;
mod recording;
mod relative;
mod source;
mod temporary;
#[cfg(test)]
mod tests;
mod whole;

pub use batch::Batch;
pub use changes::Changes;
pub use folder::make_folder;
pub use letters::{base64, from_base64, hexadecimal};
pub use log::{Log, LogContents, append_text};
pub use log_reader::{Header, LARGEST_RECORD, LogError, LogFormat, LogReader};
pub use log_tail::LogTail;
pub use pieces::{Places, digest};
pub use read::{
    LARGEST, Lines, ReadError, check_kind, read_bytes, read_kind, read_standard_input, read_text,
};
pub use recording::RecordingDisk;
pub use relative::relative;
pub use source::{Disk, Files, Memory, Overlay, PatternError};
pub use whole::{WholeFile, check_target, create_new, remove, write};
