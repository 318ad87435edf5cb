//! What to type to see a run or a block again, and whether the page shows it itself.

use serde::Serialize;

use results::SuiteReport;

/// What to type to see something again.
#[derive(Debug, Serialize)]
pub struct ReplayCommand {
    pub key: String,
    command: String,
    /// Whether the page has the run's animation.
    animated: bool,
}

impl ReplayCommand {
    pub fn of_run(report: &SuiteReport, key: &str, animated: &[String]) -> Self {
        let command = report.identity.replay_command(key);
        Self { animated: animated.iter().any(|known| known == key), key: key.to_string(), command }
    }

    pub fn of_block(key: &str, command: String) -> Self {
        Self { key: key.to_string(), command, animated: false }
    }
}
