//! What there is to say about a project, as values.

use std::error::Error;
use std::fmt;
use std::sync::Arc;

use files::escape::terminal;
use lang::{self, Code, Diagnostic, Excerpt, Failure, Severity, Sources, Style};
use scenario::Origin;

/// Something to be said about a project before it runs.
#[derive(Debug, Clone)]
pub enum Notice {
    /// All that is wrong with a text.
    Failure(Failure),
    /// A finding of the language, at places in texts.
    Finding {
        /// What was found, with its places.
        finding: Diagnostic,
        /// The texts that the places are in.
        sources: Arc<Sources>,
    },
    /// An error at a place that travelled with what was read there.
    Error {
        /// What it is about.
        code: Code,
        /// What is wrong, in a sentence without a full stop.
        message: String,
        /// Where.
        origin: Origin,
        /// What has to be known besides, a sentence each.
        notes: Vec<String>,
        /// What to do about it, if that is known.
        help: Option<String>,
    },
    /// Something that has no place in a text.
    Plain {
        /// How much it matters.
        level: NoticeLevel,
        /// A sentence without a full stop.
        message: String,
        /// What to do about it, if that is known.
        help: Option<String>,
    },
}

/// How much it matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoticeLevel {
    /// Nothing can be run.
    Error,
    /// It can be run, though it may not be what was meant.
    Warning,
    /// Something to be known.
    Note,
}

impl Notice {
    /// How much it matters.
    pub fn level(&self) -> NoticeLevel {
        match self {
            Self::Finding { finding, .. } => match finding.severity {
                Severity::Error => NoticeLevel::Error,
                Severity::Warning => NoticeLevel::Warning,
            },
            Self::Failure(_) | Self::Error { .. } => NoticeLevel::Error,
            Self::Plain { level, .. } => *level,
        }
    }

    /// As text for people, in lines that end.
    pub fn render(&self, style: Style) -> String {
        match self {
            Self::Failure(failure) => failure.render(style),
            Self::Finding { finding, sources } => format!("{}\n\n", lang::render(finding, sources, style)),
            Self::Error { code, message, origin, notes, help } => {
                let excerpt = Excerpt { title: message, origin, label: "", notes, help: help.as_deref() };
                format!("{}\n\n", excerpt.render_as(Some(*code), style.colour))
            }
            Self::Plain { level, message, help } => {
                let level = match level {
                    NoticeLevel::Error => "error",
                    NoticeLevel::Warning => "warning",
                    NoticeLevel::Note => "note",
                };
                let help =
                    help.as_ref().map(|help| format!("help: {}\n", terminal(help))).unwrap_or_default();
                format!("{level}: {}\n{help}", terminal(message))
            }
        }
    }
}

/// Why a project cannot be run: at least one error, with the warnings and notes around it.
#[derive(Debug, Clone)]
pub struct Problems(pub Vec<Notice>);

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.0.iter().try_for_each(|notice| f.write_str(&notice.render(Style::default())))
    }
}

impl Error for Problems {}
