//! What is wrong with a functional mock-up unit, or with what it was asked.

use thiserror::Error;

/// Why the file of a unit, or its library, cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FmuError {
    /// Its bytes are no archive, or one that must not be unpacked.
    #[error("it is no archive as FMUs are: {0}")]
    Archive(String),
    /// `modelDescription.xml` says nothing that could be used.
    #[error("its modelDescription.xml {0}")]
    Description(String),
    /// It has nothing for this machine.
    #[error("it has no library for this machine: there is no {wanted} in it{}", others(.found))]
    NoBinary {
        /// The file that was looked for.
        wanted: String,
        /// The platforms that it has libraries for.
        found: Vec<String>,
    },
    /// What was unpacked cannot be written.
    #[error("it cannot be unpacked: {0}")]
    Unwritable(#[from] std::io::Error),
    /// The system does not load its library.
    #[error("its library is not loaded: {0}")]
    NotLoaded(String),
}

fn others(found: &[String]) -> String {
    if found.is_empty() { String::new() } else { format!(", but for {}", found.join(", ")) }
}

/// Why an instance did not do what it was asked.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct FmuRefusal {
    /// What it returned, and what it said of it.
    pub message: String,
    /// Whether nothing may be asked of this library in this process any more.
    pub is_fatal: bool,
}
