//! Everything that was run, a run at a time in the order of the plan: what `--runs` and `--csv` write.

use results::judge::{PerRun, per_run};
use results::{Outcome, RecordedReport, RecordedState, Skip, SuiteReport, TrialReport, TrialState, Verdict};
use scenario::Assignment;

/// A run, or a trial that was to be run and has none.
pub struct Row<'r> {
    pub suite: &'r str,
    pub scenario: &'r str,
    /// The trial's key, or that of a run that failed before and was run again.
    pub trial: &'r str,
    pub variation: &'r [Assignment],
    /// Of the trial; `None` where it could not be judged, or nothing is claimed of it.
    pub verdict: Option<Verdict>,
    pub what: What<'r>,
}

pub enum What<'r> {
    Run(&'r Outcome),
    /// It was begun or wanted and has no runs to show: a state in one or two words, and why.
    Nothing(&'static str, String),
}

impl Row<'_> {
    /// `finished`, or why there is no run.
    pub fn state(&self) -> &'static str {
        match &self.what {
            What::Run(_) => "finished",
            What::Nothing(state, _) => state,
        }
    }
}

/// The trials of a suite with the runs of each, after the runs that failed before. What was not selected is not there;
/// what was selected and came to nothing has a row that says so, so that nobody takes fewer runs for all.
pub fn each_row<E>(
    report: &SuiteReport,
    mut row: impl FnMut(&Row, &[PerRun]) -> Result<(), E>,
) -> Result<(), E> {
    let suite = report.identity.suite.as_str();
    report.recorded.iter().try_for_each(|recorded| recorded_row(suite, recorded, &mut row))?;
    report.trials.iter().try_for_each(|trial| trial_rows(suite, trial, &mut row))
}

/// The row of a run that failed before, if it was selected.
pub fn recorded_row<E>(
    suite: &str,
    recorded: &RecordedReport,
    row: &mut impl FnMut(&Row, &[PerRun]) -> Result<(), E>,
) -> Result<(), E> {
    let (verdict, what) = match &recorded.state {
        RecordedState::Ran(rerun) => (Some(rerun.judged.verdict), What::Run(&rerun.outcome)),
        RecordedState::Errored(error) => (None, What::Nothing(ERRORED, error.message.clone())),
        RecordedState::Skipped(Skip::NotSelected) => return Ok(()),
        RecordedState::Skipped(skip) => (None, What::Nothing(NOT_RUN, skip.to_string())),
    };
    let (scenario, trial) = (recorded.recorded.scenario.as_str(), recorded.key.as_str());
    let variation = recorded.recorded.variation.as_slice();
    row(&Row { suite, scenario, trial, variation, verdict, what }, &[])
}

/// The rows of a trial, if it was selected.
pub fn trial_rows<E>(
    suite: &str,
    trial: &TrialReport,
    row: &mut impl FnMut(&Row, &[PerRun]) -> Result<(), E>,
) -> Result<(), E> {
    let criteria: Vec<PerRun> = trial.trial.criteria.iter().filter_map(per_run).collect();
    let of = |what| of_trial(suite, trial, what);
    let finished = trial.error().map_or(&[][..], |error| &error.finished);
    for outcome in trial.outcomes.iter().chain(finished) {
        row(&of(What::Run(outcome)), &criteria)?;
    }
    if let Some(error) = trial.error().filter(|error| !error.faults.is_empty()) {
        let mut faults = error.faults.iter();
        return faults.try_for_each(|fault| row(&of(What::Nothing(ERRORED, fault.in_words())), &criteria));
    }
    let nothing = match &trial.state {
        TrialState::Judged(_) | TrialState::Skipped(Skip::NotSelected) => return Ok(()),
        TrialState::Skipped(skip) => What::Nothing(NOT_RUN, skip.to_string()),
        TrialState::Errored(error) => What::Nothing(ERRORED, error.message.clone()),
        TrialState::NotFinished(cut) => What::Nothing("not finished", cut.to_string()),
    };
    row(&of(nothing), &criteria)
}

const ERRORED: &str = "error";
const NOT_RUN: &str = "not run";

fn of_trial<'r>(suite: &'r str, report: &'r TrialReport, what: What<'r>) -> Row<'r> {
    let trial = &report.trial;
    let variation = &trial.variation;
    let verdict = report.verdict().filter(|_| !report.claims_nothing());
    Row { suite, scenario: &trial.scenario, trial: &trial.key, variation, verdict, what }
}
