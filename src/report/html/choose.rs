//! Which runs are recorded again to be drawn: the worst ones, examples, and enough of every scenario for its chart.

use std::collections::HashSet;

use crate::judge::Verdict;
use crate::report::figures::scenarios;
use crate::report::{SuiteReport, TrialReport, TrialState};

/// A run that is to be drawn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chosen {
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
    for (key, reason) in worst_runs(report) {
        if chosen.len() < MOST_WORST && seen.insert(key.clone()) {
            chosen.push(Chosen { key, reason: Some(reason) });
        }
    }
    let most = chosen.len() + MOST_EXAMPLES;
    for key in examples(report) {
        if chosen.len() < most && seen.insert(key.clone()) {
            chosen.push(Chosen { key, reason: Some("example".into()) });
        }
    }
    for (_, trials) in scenarios(report) {
        let keys: Vec<&String> =
            trials.iter().flat_map(|trial| &trial.outcomes).map(|outcome| &outcome.key).collect();
        // Evenly over all runs, so that every variation and person has its share.
        let wanted = keys.len().min(MOST_COURSES);
        for place in 0..wanted {
            let key = keys[place * keys.len() / wanted];
            if seen.insert(key.clone()) {
                chosen.push(Chosen { key: key.clone(), reason: None });
            }
        }
    }
    chosen
}

/// Each criterion's worst run of every trial, then each one's second worst, and so on.
fn worst_runs(report: &SuiteReport) -> Vec<(String, String)> {
    let mut runs: Vec<(usize, String, String)> = Vec::new();
    for trial in &report.trials {
        let TrialState::Judged(judged) = &trial.state else { continue };
        for finding in judged.findings.iter().filter(|finding| finding.verdict != Verdict::Passed) {
            for (rank, run) in finding.worst.iter().enumerate() {
                runs.push((rank, run.key.clone(), finding.criterion.clone()));
            }
        }
    }
    runs.sort_by_key(|(rank, _, _)| *rank);
    runs.into_iter().map(|(_, key, reason)| (key, reason)).collect()
}

/// The first run of every trial, a trial of each scenario at a time.
fn examples(report: &SuiteReport) -> Vec<String> {
    let scenarios = scenarios(report);
    let longest = scenarios.iter().map(|(_, trials)| trials.len()).max().unwrap_or(0);
    let first = |trial: &&TrialReport| trial.outcomes.first().map(|outcome| outcome.key.clone());
    (0..longest)
        .flat_map(|rank| scenarios.iter().filter_map(move |(_, trials)| trials.get(rank)))
        .filter_map(first)
        .collect()
}
