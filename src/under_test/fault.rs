//! What a program does that it must not, with the end of its log.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use sim::ControllerError;

/// A program that did not do its part in a run. It is never a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgramFault {
    /// Which kind of fault it is.
    pub kind: FaultKind,
    /// What happened, in a few words.
    pub message: String,
    /// The last lines of its log.
    pub log_tail: Vec<String>,
    /// Where all of them are.
    pub log: Option<PathBuf>,
}

/// A kind of fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
    /// One without a log.
    pub fn new(kind: FaultKind, message: impl Into<String>) -> Self {
        Self { kind, message: message.into(), log_tail: Vec::new(), log: None }
    }

    /// As what keeps a controller from deciding.
    pub fn into_error(self) -> ControllerError {
        ControllerError::new(self.to_string())
    }
}

/// Kind and message in the first line, then the end of its log.
impl Display for ProgramFault {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Self { kind, message, log_tail, log } = self;
        write!(out, "{kind}: {}", one_line(message))?;
        if !log_tail.is_empty() {
            write!(out, "\nend of its log:")?;
            for line in log_tail {
                write!(out, "\n  | {}", one_line(line))?;
            }
        }
        match log {
            Some(log) => write!(out, "\nlog: {}", log.display()),
            None => Ok(()),
        }
    }
}

/// A text that stands in one line; whoever shows it escapes it.
pub fn one_line(text: &str) -> String {
    text.chars().map(|one| if one.is_control() { ' ' } else { one }).collect::<String>().trim().to_string()
}

/// The beginning of what a program said.
pub fn quoted(said: &[u8]) -> String {
    const MOST: usize = 80;
    let text = String::from_utf8_lossy(&said[..said.len().min(4 * MOST)]);
    let text = one_line(&text);
    match text.char_indices().nth(MOST) {
        Some((at, _)) => format!("`{}…`", &text[..at]),
        None => format!("`{text}`"),
    }
}
