//! Status lines: a verb of fixed width, the time it took, and what it is about.

use std::time::Duration;

use anstyle::{AnsiColor, Style};

use crate::table::paint;
use files::escape::terminal_line;
use results::{CutBy, Skip, Standing, Verdict};

/// Which units get a status line. Each level shows what those before it show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum StatusLevel {
    /// No unit.
    None,
    /// No unit by itself: one character for each, in rows.
    Dot,
    /// Those that failed, could not be run, are inconclusive, or miss what they need.
    Fail,
    /// And those that take long.
    Slow,
    /// And those that passed.
    Pass,
    /// And those that were not run.
    Skip,
    /// And every unit when it begins.
    All,
}

pub const GOOD: Style = AnsiColor::Green.on_default().bold();
pub const DOUBTFUL: Style = AnsiColor::Yellow.on_default().bold();
pub const PLAIN: Style = Style::new();
pub const BAD: Style = AnsiColor::Red.on_default().bold();

/// The level at which such a unit is shown.
pub fn level(standing: Standing, skip: Option<&Skip>) -> StatusLevel {
    match standing {
        Standing::Skipped if matches!(skip, Some(Skip::Needs { .. })) => StatusLevel::Fail,
        Standing::Skipped if matches!(skip, Some(Skip::Stale(_))) => StatusLevel::Pass,
        Standing::Skipped | Standing::NotFinished(CutBy::GateFailed) => StatusLevel::Skip,
        Standing::NotJudged | Standing::Found | Standing::Judged(Verdict::Passed) => StatusLevel::Pass,
        Standing::Judged(_) | Standing::NotFinished(_) | Standing::Errored => StatusLevel::Fail,
    }
}

pub fn unit_line(standing: Standing, took: Duration, said: &str, colour: bool) -> String {
    let (verb, style) = match standing {
        Standing::Skipped => ("SKIP", DOUBTFUL),
        Standing::NotJudged => ("NOT JUDGED", DOUBTFUL),
        Standing::Found => ("FOUND", PLAIN),
        Standing::Judged(Verdict::Passed) => ("PASS", GOOD),
        Standing::Judged(Verdict::Inconclusive) => ("INCONCLUSIVE", DOUBTFUL),
        Standing::Judged(Verdict::Failed) => ("FAIL", BAD),
        Standing::NotFinished(CutBy::Interrupted | CutBy::GateFailed) => ("NOT FINISHED", DOUBTFUL),
        Standing::NotFinished(CutBy::TimeLimit) => ("NOT FINISHED", BAD),
        Standing::Errored => ("ERROR", BAD),
    };
    let time = match standing {
        // Its runs were made between those of others.
        Standing::Skipped | Standing::NotFinished(CutBy::GateFailed) => "[         ]".to_string(),
        _ => seconds(took),
    };
    line(verb, style, Some(&time), said, colour)
}

/// What stands for a unit where each has one character.
pub fn mark(standing: Standing) -> (char, Style) {
    match standing {
        Standing::Judged(Verdict::Passed) => ('.', GOOD),
        Standing::Judged(Verdict::Failed) => ('F', BAD),
        Standing::Judged(Verdict::Inconclusive) => ('?', DOUBTFUL),
        Standing::NotJudged => ('-', DOUBTFUL),
        Standing::Found => ('-', PLAIN),
        Standing::Skipped | Standing::NotFinished(CutBy::GateFailed) => ('s', DOUBTFUL),
        Standing::NotFinished(CutBy::Interrupted) => ('i', DOUBTFUL),
        Standing::NotFinished(CutBy::TimeLimit) => ('T', BAD),
        Standing::Errored => ('E', BAD),
    }
}

/// A unit that has taken longer than `than` and is still running.
pub fn slow_line(than: Duration, said: &str, colour: bool) -> String {
    let time = format!("[>{:>7.3}s]", than.as_secs_f64());
    line("SLOW", DOUBTFUL, Some(&time), said, colour)
}

/// `[   0.004s]`.
pub fn seconds(time: Duration) -> String {
    format!("[{:>8.3}s]", time.as_secs_f64())
}

/// Verbs stand to the right in twelve columns.
pub fn line(verb: &str, style: Style, time: Option<&str>, said: &str, colour: bool) -> String {
    let space = " ".repeat(12_usize.saturating_sub(verb.len()));
    let verb = paint(verb, style, colour);
    let time = time.map(|time| format!("{time} ")).unwrap_or_default();
    format!("{space}{verb} {time}{}", terminal_line(said))
}
