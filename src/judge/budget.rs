//! Whether the runs there will be can show what a criterion claims at its confidence: looked at before anything runs.

use std::collections::HashSet;

use super::confidence::{self, share_interval};
use super::statistics;
use super::verdict::Verdict;
use crate::lang::{Code, Diagnostic, Sources, Span};
use crate::plan::{self, Outline};
use crate::scenario::{Aggregate, Claim, Criterion, Origin, Relation, Scenario, Suite, constant};

/// What it takes for a claim to pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needed {
    /// At least so many runs.
    Runs(u64),
    /// No number of runs would do.
    More,
}

/// The fewest runs with which a claim with stated confidence can pass, however well they go; `None` for a claim
/// without confidence, and for spreads, whose intervals know no such number.
///
/// It asks the same bounds as the verdict does, so that both always agree.
pub fn runs_needed(claim: &Claim) -> Option<Needed> {
    let needed = match claim {
        Claim::Runs { share, confidence, .. } => {
            share_needs(Relation::GreaterOrEqual, (*share)?, (*confidence)?)
        }
        Claim::Aggregate { aggregate, relation, bound, confidence, .. } => {
            let confidence = (*confidence)?;
            match aggregate {
                Aggregate::Rate(_) => share_needs(*relation, constant(bound), confidence),
                Aggregate::Median(_) => quantile_needs(*relation, 0.5, confidence),
                Aggregate::Quantile(level, _) => quantile_needs(*relation, *level, confidence),
                // One value has no spread, and with it no interval of its mean.
                Aggregate::Mean(_) => Some(2),
                Aggregate::Std(_) => return None,
                Aggregate::Min(_) | Aggregate::Max(_) | Aggregate::Count(_) => None,
            }
        }
    };
    Some(needed.map_or(Needed::More, Needed::Runs))
}

/// The fewest runs after which the best that can happen shows the share.
fn share_needs(relation: Relation, bound: f64, confidence: f64) -> Option<u64> {
    let all_hold = match relation {
        Relation::Greater | Relation::GreaterOrEqual => true,
        Relation::Less | Relation::LessOrEqual => false,
        Relation::Equal | Relation::NotEqual => return None,
    };
    let passes = |runs: u64| {
        let holding = if all_hold { runs as usize } else { 0 };
        let interval = share_interval(holding, runs as usize, confidence);
        confidence::decide(relation, interval, bound) == Verdict::Passed
    };
    let near = statistics::runs_needed(if all_hold { bound } else { 1.0 - bound }, confidence)?;
    // A strict relation, or rounding, may take one run more than the formula.
    (near.saturating_sub(1).max(1)..=near + 1).find(|runs| passes(*runs))
}

/// The fewest values of which the extreme one bounds the quantile.
fn quantile_needs(relation: Relation, level: f64, confidence: f64) -> Option<u64> {
    match relation {
        Relation::Less | Relation::LessOrEqual => statistics::runs_needed(level, confidence),
        Relation::Greater | Relation::GreaterOrEqual => statistics::runs_needed(1.0 - level, confidence),
        Relation::Equal | Relation::NotEqual => None,
    }
}

/// What is wrong with the criteria of a suite once its trials are known: those that can never pass, as errors, and those
/// whose `when` holds in no trial, as warnings. What keeps a scenario from being planned is left to planning.
pub fn examine_criteria(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut applying: HashSet<&Origin> = HashSet::new();
    let outlines: Vec<(&Scenario, Vec<Outline>)> = suite
        .scenarios
        .iter()
        .filter(|scenario| scenario.criteria.iter().any(depends_on_trials))
        .filter_map(|scenario| Some((scenario, plan::outline(suite, scenario).ok()?)))
        .collect();
    for (scenario, trials) in &outlines {
        let mut said: Vec<(&Criterion, Needed, Vec<&Outline>)> = Vec::new();
        for trial in trials {
            for criterion in &trial.criteria {
                applying.insert(&criterion.origin);
                let Some(needed) = runs_needed(&criterion.claim) else { continue };
                if matches!(needed, Needed::Runs(needed) if needed <= trial.runs as u64) {
                    continue;
                }
                let same = said.iter_mut().find(|(known, known_needed, _)| {
                    known.origin == criterion.origin && *known_needed == needed
                });
                match same {
                    Some((_, _, trials)) => trials.push(trial),
                    None => said.push((criterion, needed, vec![trial])),
                }
            }
        }
        for (criterion, needed, short) in said {
            found.push(never_passes(scenario, criterion, needed, &short, trials.len(), sources));
        }
    }
    let mut idle: HashSet<&Origin> = HashSet::new();
    for (scenario, _) in &outlines {
        for criterion in scenario.criteria.iter().filter(|criterion| !criterion.when.is_empty()) {
            if !applying.contains(&criterion.origin) && idle.insert(&criterion.origin) {
                found.push(
                    at(Code::NeverSampled, criterion, "this applies to none of the values drawn", sources)
                        .label("never checked")
                        .note(format!("with seed {}", suite.seed))
                        .hint("draw more values, or let its `when` hold for more of them"),
                );
            }
        }
    }
    found
}

/// Whether it takes the trials to know if a criterion can pass or applies.
fn depends_on_trials(criterion: &Criterion) -> bool {
    let confidence = match &criterion.claim {
        Claim::Runs { confidence, .. } | Claim::Aggregate { confidence, .. } => confidence,
    };
    confidence.is_some() || !criterion.when.is_empty()
}

fn never_passes(
    scenario: &Scenario,
    criterion: &Criterion,
    needed: Needed,
    short: &[&Outline],
    trials: usize,
    sources: &Sources,
) -> Diagnostic {
    let text = &criterion.text;
    let runs = short[0].runs;
    let counted = |count: u64| if count == 1 { "1 run".to_string() } else { format!("{count} runs") };
    let diagnostic = match needed {
        Needed::Runs(needed) => {
            let people = (runs / scenario.repeat as usize).max(1) as u64;
            let has = if runs == 1 { "1".to_string() } else { runs.to_string() };
            let message = format!("`{text}` needs at least {}; this trial has {has}", counted(needed));
            at(Code::TooFewRuns, criterion, message, sources).label("can never pass").hint(format!(
                "say `repeat {}` in scenario `{}`, or claim less, or at less confidence",
                needed.div_ceil(people),
                scenario.name
            ))
        }
        Needed::More => {
            at(Code::TooFewRuns, criterion, format!("`{text}` can pass with no number of runs"), sources)
                .label("can never pass")
                .hint("claim a little less, such as 99 % instead of 100 %, or leave out the confidence")
        }
    };
    match short {
        [only] => diagnostic.note(format!("in {}", only.key)),
        all if all.len() == trials => {
            diagnostic.note(format!("in each of the {trials} trials of scenario `{}`", scenario.name))
        }
        [first, _] => diagnostic.note(format!("in {} and one more trial", first.key)),
        [first, others @ ..] => diagnostic.note(format!("in {} and {} more trials", first.key, others.len())),
        [] => diagnostic,
    }
}

fn at(code: Code, criterion: &Criterion, message: impl Into<String>, sources: &Sources) -> Diagnostic {
    let span = sources.span(&criterion.origin).unwrap_or_else(|| {
        let (first, _) = sources.iter().next().expect("a suite was read from somewhere");
        Span::beginning(first)
    });
    Diagnostic::new(code, span, message)
}

#[cfg(test)]
mod tests {
    use super::super::statistics::quantile_interval;
    use super::*;
    use statrs::distribution::{Binomial, DiscreteCDF};

    const AT_LEAST: Relation = Relation::GreaterOrEqual;

    #[test]
    fn the_known_numbers() {
        assert_eq!(share_needs(AT_LEAST, 0.95, 0.95), Some(59));
        assert_eq!(share_needs(AT_LEAST, 0.99, 0.95), Some(299));
        assert_eq!(share_needs(AT_LEAST, 0.999, 0.95), Some(2995));
        assert_eq!(share_needs(Relation::LessOrEqual, 0.01, 0.95), Some(299));
        assert_eq!(share_needs(Relation::Less, 0.05, 0.99), Some(90));
        assert_eq!(share_needs(AT_LEAST, 0.0, 0.95), Some(1));
        assert_eq!(share_needs(Relation::LessOrEqual, 1.0, 0.95), Some(1));
        // Two of two show half at exactly 75 %: not more than half.
        assert_eq!(share_needs(Relation::Greater, 0.5, 0.75), Some(3));
    }

    #[test]
    fn what_no_number_of_runs_shows() {
        assert_eq!(share_needs(AT_LEAST, 1.0, 0.95), None);
        assert_eq!(share_needs(Relation::LessOrEqual, 0.0, 0.95), None);
        assert_eq!(share_needs(Relation::Less, 0.0, 0.95), None);
        assert_eq!(share_needs(Relation::Greater, 1.0, 0.95), None);
        assert_eq!(share_needs(Relation::Equal, 0.5, 0.95), None);
        assert_eq!(quantile_needs(Relation::LessOrEqual, 1.0, 0.95), None);
        assert_eq!(quantile_needs(AT_LEAST, 0.0, 0.95), None);
    }

    #[test]
    fn fewer_runs_never_pass_and_so_many_can() {
        for confidence in [0.5, 0.8, 0.95, 0.99] {
            for share in [0.05, 0.1, 0.5, 0.8, 0.9, 0.95, 0.99, 0.9975] {
                let needed = share_needs(AT_LEAST, share, confidence).unwrap();
                let verdict = |runs: u64, holding: u64| {
                    confidence::decide(
                        AT_LEAST,
                        share_interval(holding as usize, runs as usize, confidence),
                        share,
                    )
                };
                assert_eq!(verdict(needed, needed), Verdict::Passed, "{share} at {confidence}");
                for runs in 1..needed {
                    assert_ne!(verdict(runs, runs), Verdict::Passed, "{share} at {confidence}: {runs}");
                }
                // As another implementation has it: were the share just `share`, so many would hold this seldom.
                let luck = |runs: u64| 1.0 - Binomial::new(share, runs).unwrap().cdf(runs - 1);
                assert!(luck(needed) <= (1.0 - confidence) * (1.0 + 1e-9));
                assert!(needed == 1 || luck(needed - 1) > (1.0 - confidence) * (1.0 - 1e-9));
            }
        }
    }

    #[test]
    fn quantiles_are_bounded_from_the_number_on_that_is_needed() {
        for confidence in [0.75, 0.9, 0.95, 0.99] {
            for level in [0.05, 0.25, 0.5, 0.9, 0.95] {
                let bounded = |runs: u64, above: bool| {
                    let values: Vec<f64> = (0..runs).map(|k| k as f64).collect();
                    let (low, high) = quantile_interval(&values, level, 2.0 * confidence - 1.0);
                    if above { high.is_some() } else { low.is_some() }
                };
                for (relation, above) in [(Relation::LessOrEqual, true), (AT_LEAST, false)] {
                    let needed = quantile_needs(relation, level, confidence).unwrap();
                    assert!(bounded(needed, above), "{level} at {confidence}: {needed}");
                    assert!(!bounded(needed - 1, above), "{level} at {confidence}: {needed}");
                }
            }
        }
    }
}
