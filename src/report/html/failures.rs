//! What did not pass, as a list: failures of one cause together, and whatever was not brought to its end.

use serde::Serialize;

use super::command::ReplayCommand;
use crate::groups::{Group, groups};
use crate::wording::{recorded_remark, run_in_words, standing_words, verdict_mark, verdict_word};
use results::{CutBy, RecordedReport, Standing, SuiteReport, TrialState, Verdict};

/// More lines of a suite are not written out.
const MOST_LINES: usize = 60;

/// A line of the list.
#[derive(Debug, Serialize)]
pub struct FailureLine {
    class: &'static str,
    mark: &'static str,
    /// What it is about: a scenario, a block, a recorded run.
    name: String,
    /// The criterion, if it is about one.
    criterion: Option<String>,
    said: String,
    /// What was found where it is worst.
    worst: Option<String>,
    command: Option<ReplayCommand>,
}

impl FailureLine {
    /// About no criterion.
    fn plain(standing: Standing, name: String, said: String, command: Option<ReplayCommand>) -> Self {
        let (class, mark) = standing_words(standing);
        Self { class, mark, name, criterion: None, said, worst: None, command }
    }
}

/// The lines of a suite, and how many there would be more.
pub fn failure_lines(report: &SuiteReport, animated: &[String]) -> (Vec<FailureLine>, usize) {
    let mut lines: Vec<FailureLine> =
        report.recorded.iter().filter_map(|one| recorded_line(report, one, animated)).collect();
    lines.extend(groups(report).into_iter().map(|group| group_line(report, &group, animated)));
    lines.extend(unfinished(report, animated));
    for block in &report.blocks {
        let standing = block.standing();
        if matches!(standing, Standing::Judged(Verdict::Passed) | Standing::Skipped | Standing::Found) {
            continue;
        }
        let said = crate::failure::render_block_failure(&report.identity, block, false);
        let said = said.lines().next().unwrap_or_default().trim_start_matches("error: ").to_string();
        let name = format!("{} {}", block.block.kind(), block.block.name());
        let command = report.identity.block_command(&block.key);
        let command = ReplayCommand::of_block(&block.key, command);
        lines.push(FailureLine::plain(standing, name, said, Some(command)));
    }
    let more = lines.len().saturating_sub(MOST_LINES);
    lines.truncate(MOST_LINES);
    (lines, more)
}

/// Whether a recorded run is a reason not to call a page passed.
pub fn is_open(one: &RecordedReport) -> bool {
    !matches!(one.standing(), Standing::Judged(Verdict::Passed) | Standing::Skipped | Standing::NotJudged)
}

fn recorded_line(report: &SuiteReport, one: &RecordedReport, animated: &[String]) -> Option<FailureLine> {
    if !is_open(one) {
        return None;
    }
    let said = match &one.trial_state() {
        TrialState::Errored(error) => error.message.to_string(),
        TrialState::Judged(judged) if judged.verdict == Verdict::Inconclusive => {
            format!("recorded before, could not be decided again{}", recorded_remark(one))
        }
        _ => format!("recorded before, fails again{}", recorded_remark(one)),
    };
    let command = ReplayCommand::of_run(report, &one.recorded.key, animated);
    Some(FailureLine::plain(one.standing(), one.recorded.key.clone(), said, Some(command)))
}

fn group_line(report: &SuiteReport, group: &Group, animated: &[String]) -> FailureLine {
    let (trial, finding) = group.worst;
    let worst = finding.worst.first().map(|run| format!("{}, in {}", run_in_words(finding, run), run.key));
    FailureLine {
        class: verdict_word(group.verdict),
        mark: verdict_mark(group.verdict),
        name: group.scenario.to_string(),
        criterion: Some(group.criterion.to_string()),
        said: group.in_words(),
        worst: worst.or_else(|| Some(format!("worst in {trial}"))),
        command: group.run().map(|key| ReplayCommand::of_run(report, key, animated)),
    }
}

/// Trials without a verdict, those of one scenario and one state together.
fn unfinished(report: &SuiteReport, animated: &[String]) -> Vec<FailureLine> {
    let mut lines: Vec<(FailureLine, usize)> = Vec::new();
    for trial in &report.trials {
        let said = match &trial.state {
            // What a gate ended is told with it.
            TrialState::NotFinished(cut) if cut.by() == CutBy::GateFailed => continue,
            TrialState::NotFinished(cut) => cut.to_string(),
            TrialState::Errored(error) => error.message.to_string(),
            TrialState::Judged(_) | TrialState::Skipped(_) => continue,
        };
        let standing = trial.standing();
        let class = standing_words(standing).0;
        let name = &trial.trial.scenario;
        if let Some((_, count)) =
            lines.iter_mut().find(|(known, _)| known.name == *name && known.class == class)
        {
            *count += 1;
            continue;
        }
        let run = trial.error().and_then(|error| error.faults.first()).map(|fault| fault.run.clone());
        let command = run.map(|key| ReplayCommand::of_run(report, &key, animated));
        lines.push((FailureLine::plain(standing, name.clone(), said, command), 1));
    }
    let told = |(line, count): (FailureLine, usize)| match count {
        1 => line,
        _ => FailureLine { said: format!("{} trials are so; the first: {}", count, line.said), ..line },
    };
    lines.into_iter().map(told).collect()
}

#[cfg(test)]
mod tests {
    use results::RecordedState;

    use super::*;
    use crate::fixture::Session;

    #[test]
    fn every_trial_and_block_that_did_not_pass_is_in_it() {
        let session = Session::new();
        let report = session.report();
        let (lines, more) = failure_lines(&report, &[]);
        assert_eq!(more, 0);
        let with = |class: &str| lines.iter().filter(|line| line.class == class).count();
        let failing = groups(&report).len();
        let blocks = report.blocks.iter().filter(|block| {
            !matches!(
                block.standing(),
                Standing::Judged(Verdict::Passed) | Standing::Skipped | Standing::Found
            )
        });
        let recorded = report.recorded.iter().filter(|one| is_open(one)).count();
        assert!(failing > 0 && recorded > 0);
        // The errored trial has a line of its own.
        assert_eq!(lines.len(), failing + blocks.count() + recorded + 1);
        assert!(with("error") >= 1);
        let mut undecided = report;
        for one in &mut undecided.recorded {
            if let RecordedState::Ran(rerun) = &mut one.state {
                rerun.judged.verdict = Verdict::Inconclusive;
            }
        }
        let (lines, _) = failure_lines(&undecided, &[]);
        assert!(lines.iter().any(|line| line.said.contains("could not be decided again")), "{lines:?}");
        assert!(lines.iter().all(|line| !line.said.contains("fails again")), "{lines:?}");
        let cut = session.interrupted();
        let (lines, _) = failure_lines(&cut, &[]);
        assert!(lines.iter().any(|line| line.class == "not finished"), "{lines:?}");
    }
}
