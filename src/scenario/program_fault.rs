//! What a program does that it must not, with the end of its log.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use super::{DeclaredProgram, Origin};

/// A program that did not do its part in a run. It is never a result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProgramFault {
    /// Which kind of fault it is.
    pub kind: FaultKind,
    /// What happened, in a few words.
    pub message: String,
    /// What the file calls the program; empty where that is not known yet.
    #[serde(default)]
    pub controller: String,
    /// Where it is declared.
    #[serde(default)]
    pub declared: Box<Origin>,
    /// The last lines of its log, as they are indented.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub log_tail: Vec<String>,
    /// The file that has all of its log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<String>,
}

/// A kind of fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// It ended, by itself or by a signal.
    Exited,
    /// It did not answer in time.
    Timeout,
    /// What it answered is nothing that the protocol knows.
    Garbage,
    /// It answered with what no vehicle can do.
    BadValue,
    /// It said that it cannot decide.
    Refused,
    /// It failed with many runs at once, and with none of them alone.
    OnlyTogether,
}

impl FaultKind {
    /// Every one.
    pub const ALL: [Self; 6] =
        [Self::Exited, Self::Timeout, Self::Garbage, Self::BadValue, Self::Refused, Self::OnlyTogether];

    /// As reports say it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Exited => "exited",
            Self::Timeout => "timeout",
            Self::Garbage => "garbage",
            Self::BadValue => "bad_value",
            Self::Refused => "refused",
            Self::OnlyTogether => "only_together",
        }
    }

    /// Whether the process cannot be asked again.
    pub fn is_final(self) -> bool {
        matches!(self, Self::Exited | Self::Timeout | Self::Garbage)
    }
}

impl Display for FaultKind {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        out.write_str(self.word())
    }
}

impl ProgramFault {
    /// One of a program that is not named yet, without a log.
    pub fn new(kind: FaultKind, message: impl Into<String>) -> Self {
        Self {
            kind,
            message: message.into(),
            controller: String::new(),
            declared: Box::default(),
            log_tail: Vec::new(),
            log: None,
        }
    }

    /// The same, of this program.
    pub fn of(self, program: &DeclaredProgram) -> Self {
        Self { controller: program.name.clone(), declared: Box::new(program.origin.clone()), ..self }
    }

    /// Kind and message, in one line.
    pub fn summary(&self) -> String {
        let message: String = self.message.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        format!("{}: {}", self.kind, message.trim())
    }
}

/// Kind and message in the first line, then the end of its log.
impl Display for ProgramFault {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        out.write_str(&self.summary())?;
        if !self.log_tail.is_empty() {
            write!(out, "\nend of its log:")?;
            for line in &self.log_tail {
                write!(out, "\n  | {line}")?;
            }
        }
        match &self.log {
            Some(log) => write!(out, "\nlog: {log}"),
            None => Ok(()),
        }
    }
}
