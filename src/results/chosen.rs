//! Which runs are recorded again to be drawn: the worst ones, examples, and enough of every scenario for its chart.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};

use super::suite::SuiteReport;
use super::trial::{TrialReport, TrialState};
use crate::Verdict;

/// A run that is to be drawn.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Chosen {
    /// The run's key.
    pub key: String,
    /// Why it is animated; `None` for a run that is only a line in the chart of trajectories.
    pub reason: Option<String>,
}

/// Animated because they speak against a criterion.
const MOST_WORST: usize = 24;
/// Animated as examples.
const MOST_EXAMPLES: usize = 16;
/// Lines per scenario in the chart of trajectories.
const MOST_COURSES: usize = 40;

/// The runs to draw, those to animate first, worst ones before examples.
pub fn choose_runs(report: &SuiteReport) -> Vec<Chosen> {
    let mut seen = HashSet::new();
    let mut chosen = Vec::new();
    for (_, key, reason) in worst_runs(report) {
        if chosen.len() < MOST_WORST && seen.insert(key) {
            chosen.push(Chosen { key: key.to_string(), reason: Some(reason.to_string()) });
        }
    }
    let most = chosen.len() + MOST_EXAMPLES;
    let scenarios = report.scenarios();
    for key in examples(&scenarios) {
        if chosen.len() == most {
            break;
        }
        if seen.insert(key) {
            chosen.push(Chosen { key: key.to_string(), reason: Some("example".into()) });
        }
    }
    for (_, trials) in &scenarios {
        let keys: Vec<&str> =
            trials.iter().flat_map(|trial| &trial.outcomes).map(|outcome| outcome.key.as_str()).collect();
        // Evenly over all runs, so that every variation and person has its share.
        let wanted = keys.len().min(MOST_COURSES);
        for place in 0..wanted {
            let key = keys[place * keys.len() / wanted];
            if seen.insert(key) {
                chosen.push(Chosen { key: key.to_string(), reason: None });
            }
        }
    }
    chosen
}

/// Each criterion's worst run of every trial, then each one's second worst, and so on, with the criterion.
fn worst_runs(report: &SuiteReport) -> Vec<(usize, &str, &str)> {
    let mut runs = Vec::new();
    for trial in &report.trials {
        let TrialState::Judged(judged) = &trial.state else { continue };
        for finding in judged.findings.iter().filter(|finding| finding.verdict != Verdict::Passed) {
            for (rank, run) in finding.worst.iter().enumerate() {
                runs.push((rank, run.key.as_str(), finding.criterion.as_str()));
            }
        }
    }
    runs.sort_by_key(|(rank, _, _)| *rank);
    runs
}

/// The first run of every trial, a trial of each scenario at a time.
fn examples<'r>(scenarios: &[(&'r str, Vec<&'r TrialReport>)]) -> impl Iterator<Item = &'r str> {
    let longest = scenarios.iter().map(|(_, trials)| trials.len()).max().unwrap_or(0);
    (0..longest)
        .flat_map(move |rank| scenarios.iter().filter_map(move |(_, trials)| trials.get(rank)))
        .filter_map(|trial| trial.outcomes.first().map(|outcome| outcome.key.as_str()))
}
