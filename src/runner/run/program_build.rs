//! Which program makes runs: its own bytes decide, since a version is the same for many commits.

use std::env;
use std::fmt;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use files::{ReadError, hexadecimal};

/// A program of some machine. Results of another one are of other runs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Build {
    /// SHA-256 of the program's file, hexadecimal.
    pub digest: String,
    /// For which machines it is built, such as `x86_64-linux`.
    pub target: String,
    /// Of scenario-runner, for people.
    pub version: String,
}

impl Build {
    /// The program that is running.
    ///
    /// # Errors
    /// If its file cannot be read.
    pub fn here() -> Result<Self, ReadError> {
        // The file that runs, whatever stands in its place by now.
        let file = match cfg!(target_os = "linux") {
            true => Ok(PathBuf::from("/proc/self/exe")),
            false => env::current_exe(),
        };
        Ok(Self {
            digest: hexadecimal(&files::digest(&file?)?),
            target: format!("{}-{}", env::consts::ARCH, env::consts::OS),
            version: env!("CARGO_PKG_VERSION").to_string(),
        })
    }

    /// All that decides of it, in a word.
    pub fn identity(&self) -> String {
        format!("{} {}\n", self.digest, self.target)
    }
}

impl fmt::Display for Build {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let start = self.digest.get(..12).unwrap_or(&self.digest);
        write!(out, "scenario-runner {} for {} (SHA-256 {start}…)", self.version, self.target)
    }
}
