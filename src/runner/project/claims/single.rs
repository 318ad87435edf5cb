//! Claims about many runs that are asked of one run at a time, because every draw of a variation is a trial of its own.

use super::budget::at;
use super::trials::{ByFinding, TrialsAbout};
use crate::plan::{self, PlanError};
use lang::{Code, Diagnostic, Sources};
use scenario::{Aggregate, Claim, Criterion, Relation, Scenario, Suite, Variation, constant};

/// A warning for every criterion about a share, mean or quantile of runs in trials of a sampled variation that have so few
/// runs that it can only be about each of them. What cannot be planned is left to planning.
pub(super) fn examine_single_runs(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let sampled = |scenario: &&Scenario| {
        let drawn = |one: &Variation| matches!(one, Variation::Sampled { samples, .. } if samples.count > 1);
        scenario.variations.iter().any(drawn) && scenario.criteria.iter().any(is_about_many)
    };
    suite
        .scenarios
        .iter()
        .filter(sampled)
        .flat_map(|scenario| of_scenario(suite, scenario, sources))
        .collect()
}

/// Whether it sums up runs. Extremes and counts say the same of one run as of many.
pub(super) fn is_about_many(criterion: &Criterion) -> bool {
    match &criterion.claim {
        Claim::Runs { share, .. } => share.is_some_and(|share| share > 0.0 && share < 1.0),
        Claim::Aggregate { aggregate, .. } => {
            let extreme = aggregate.is_broken_by_one(true) || aggregate.is_broken_by_one(false);
            !(extreme || matches!(aggregate, Aggregate::Count(_)))
        }
    }
}

fn of_scenario(suite: &Suite, scenario: &Scenario, sources: &Sources) -> Vec<Diagnostic> {
    let Ok(YesOrNo { said, trials, runs }) = yes_or_no(suite, scenario) else { return Vec::new() };
    let each = match runs {
        1 => "one run".to_string(),
        runs => format!("{runs} runs"),
    };
    let finding = |(criterion, about): (Criterion, TrialsAbout)| {
        let message = format!("`{}` is asked of {each} at a time", criterion.text);
        let diagnostic = at(Code::OneRunEach, &criterion.origin, message, sources)
            .label("yes or no in each trial")
            .note(means(&criterion, runs))
            .hint(format!(
                "say what has to hold in every run, or let every run draw a value of its own: `draw` instead of `vary`, and `repeat 100` in scenario `{}`",
                scenario.name
            ));
        about.note(diagnostic, scenario, trials)
    };
    said.into_iter().map(finding).collect()
}

/// What of a scenario's criteria comes to yes or no in its trials.
#[derive(Default)]
struct YesOrNo {
    said: ByFinding<Criterion>,
    /// How many there are in all.
    trials: usize,
    /// Of each trial.
    runs: usize,
}

fn yes_or_no(suite: &Suite, scenario: &Scenario) -> Result<YesOrNo, PlanError> {
    let mut found = YesOrNo::default();
    for trial in plan::outline(suite, scenario)? {
        let trial = trial?;
        (found.trials, found.runs) = (found.trials + 1, trial.runs);
        for criterion in trial.criteria.iter().filter(|one| is_yes_or_no(one, trial.runs)) {
            let same =
                |known: &Criterion| (&known.origin, &known.text) == (&criterion.origin, &criterion.text);
            found.said.add(&trial, same, || criterion.clone());
        }
    }
    Ok(found)
}

/// Whether only two things can come of it that make a difference: of one run anything, of several a share that all runs have
/// to keep.
fn is_yes_or_no(criterion: &Criterion, runs: usize) -> bool {
    if !is_about_many(criterion) {
        return false;
    }
    let step = 1.0 / runs as f64;
    let near_all = |share: f64| share > 1.0 - step && share < 1.0;
    runs == 1
        || match &criterion.claim {
            Claim::Runs { share, confidence: None, .. } => share.is_some_and(near_all),
            Claim::Aggregate { aggregate: Aggregate::Rate(_), relation, bound, confidence: None, .. } => {
                let bound = constant(bound);
                match relation {
                    Relation::Less | Relation::LessOrEqual => near_all(1.0 - bound),
                    Relation::Greater | Relation::GreaterOrEqual => near_all(bound),
                    Relation::Equal | Relation::NotEqual => false,
                }
            }
            _ => false,
        }
}

/// What it comes to there.
fn means(criterion: &Criterion, runs: usize) -> String {
    match &criterion.claim {
        Claim::Aggregate { aggregate: Aggregate::Rate(_), .. } | Claim::Runs { .. } if runs == 1 => {
            "a share of one run is 0 % or 100 %".to_string()
        }
        Claim::Aggregate { .. } if runs == 1 => "of one run it is the value of that run".to_string(),
        _ => format!("with {runs} runs it says the same as of every single one of them"),
    }
}
