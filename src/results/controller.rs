//! What is known of programs under test besides what their runs came to: which they are, how fast they answered, and whether the same
//! run came out the same.

use serde::{Deserialize, Serialize};

use scenario::Origin;

/// A controller that is a program, as it was tested in a suite.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TestedController {
    /// What the file calls it.
    pub name: String,
    /// Where it is declared.
    pub declared: Origin,
    /// Name and version as the program says them, such as `my_av 2026.3`; empty if it says neither.
    #[serde(default)]
    pub program: String,
    /// How fast it answered; `None` if it was not asked. It depends on the machine, and nothing is judged by it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub answers: Option<AnswerTimes>,
    /// Runs that were made a second time, to see whether they come out the same. They count nowhere.
    #[serde(default)]
    pub second_runs: usize,
    /// Those of them that came out differently, in their order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub differing: Vec<DifferingRun>,
}

/// Wall time of an answer, for each run of its request.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AnswerTimes {
    /// Of how many answers.
    pub answers: u64,
    /// s, to about 1 %.
    pub median: f64,
    /// The time that 99 of 100 answers do not exceed, s, to about 1 %.
    pub percentile_99: f64,
    /// s
    pub worst: f64,
    /// The share of answers that took longer than the time between two decisions (0..1).
    pub late: f64,
}

/// A run that came out differently when it was made a second time, alone in another process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DifferingRun {
    /// The run's key.
    pub run: String,
    /// The first difference, such as `at 3.2 s -1.2 m/s^2, then -1.15 m/s^2`.
    pub difference: String,
}

impl TestedController {
    /// That it is not deterministic, if it was seen.
    pub fn nondeterminism(&self) -> Option<String> {
        Some(format!("W1102: `{}` is not deterministic: {}", self.name, self.first_difference()?))
    }

    /// The first difference that was seen, with its run and how many of those that were made twice differed.
    pub fn first_difference(&self) -> Option<String> {
        let first = self.differing.first()?;
        let (of, differ) = (self.second_runs, self.differing.len());
        let said = format!(
            "{} ({}; {differ} of {of} runs that were made twice came out differently)",
            first.difference, first.run
        );
        Some(said)
    }
}
