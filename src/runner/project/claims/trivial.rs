//! Criteria that cannot fail or can never pass, found before anything runs.

use std::collections::BTreeMap;
use std::mem::discriminant;

use super::budget::{add_once, at};
use crate::plan::{self, PlanError};
use lang::{Code, Diagnostic, Sources};
use results::judge::{Possible, possible};
use scenario::{Criterion, Expression, Scenario, Suite, Value};

/// A warning for every criterion that cannot fail, and an error for every one that can never pass, in none of the trials that
/// it applies to. What cannot be planned is left to planning.
pub fn examine_bounds(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> = Vec::new();
    for scenario in &suite.scenarios {
        for (criterion, possible) in of_scenario(suite, scenario) {
            if let Some(finding) = finding(criterion, possible, sources) {
                add_once(&mut found, finding);
            }
        }
    }
    found
}

fn of_scenario<'s>(suite: &Suite, scenario: &'s Scenario) -> Vec<(&'s Criterion, Possible)> {
    let people = plan::select_people(suite.seed, scenario).map_or(1, |people| people.len());
    let most = scenario.runs.as_ref().map(|budget| budget.most as usize);
    let runs = most.unwrap_or_else(|| people.saturating_mul(scenario.repeat as usize));
    let longest = sim::longest_run(scenario.horizon, scenario.step);
    let known = |criterion: &Criterion| {
        let mut criterion = criterion.clone();
        let reference = criterion.claim.metric();
        criterion.reach.limits =
            reference.known().and_then(|known| known.limits(&reference.settings, longest));
        for bound in criterion.claim.bounds_mut() {
            *bound = Expression::Constant(bound.evaluate(&BTreeMap::<String, Value>::new()).ok()?);
        }
        Some(criterion)
    };
    let known: Vec<_> = scenario.criteria.iter().map(known).collect();
    let in_trials = match known.contains(&None) {
        true => in_trials(suite, scenario, &known, runs).unwrap_or_default(),
        false => Vec::new(),
    };
    let of = |(index, criterion): (usize, &'s Criterion)| {
        let possible = match &known[index] {
            Some(known) => possible(known, runs),
            None => in_trials.get(index)?.clone()?,
        };
        Some((criterion, possible))
    };
    scenario.criteria.iter().enumerate().filter_map(of).collect()
}

/// What can come of each criterion that is not `known` in the trials that it applies to; `None` where it applies to none.
fn in_trials(
    suite: &Suite,
    scenario: &Scenario,
    known: &[Option<Criterion>],
    runs: usize,
) -> Result<Vec<Option<Possible>>, PlanError> {
    let mut found: Vec<Option<Possible>> = vec![None; scenario.criteria.len()];
    for trial in plan::outline(suite, scenario)? {
        for applying in trial?.criteria.iter() {
            let declared = scenario.criteria.iter().zip(known).zip(&mut found);
            let same = declared.filter(|((one, known), _)| {
                known.is_none() && (&one.origin, &one.text) == (&applying.origin, &applying.text)
            });
            // Where trials do not agree there is nothing more to find out.
            for (_, found) in same.filter(|(_, found)| **found != Some(Possible::Both)) {
                let here = possible(applying, runs);
                *found = Some(match found.take() {
                    Some(first) if discriminant(&first) != discriminant(&here) => Possible::Both,
                    Some(first) => first,
                    None => here,
                });
            }
        }
    }
    Ok(found)
}

fn finding(criterion: &Criterion, possible: Possible, sources: &Sources) -> Option<Diagnostic> {
    let text = &criterion.text;
    let other_side = "bound it from the other side, claim more, or leave it out";
    Some(match possible {
        Possible::Both => return None,
        Possible::NeverFails(why) => {
            at(Code::CannotFail, &criterion.origin, format!("`{text}` cannot fail"), sources)
                .label("holds whatever happens")
                .note(why)
                .hint(other_side)
        }
        Possible::OnlyAbsence { why, fails_by } => {
            let metric = &criterion.claim.metric().name();
            let message = format!("no value of `{metric}` makes `{text}` fail");
            at(Code::CannotFail, &criterion.origin, message, sources)
                .label("holds for every value that there can be")
                .note(why)
                .note(format!("it fails only by runs {fails_by}"))
                .hint(other_side)
        }
        Possible::NeverHolds(why) => {
            at(Code::NeverHolds, &criterion.origin, format!("`{text}` can never pass"), sources)
                .label("fails whatever happens")
                .note(why)
                .hint("claim what a run can come to")
        }
    })
}
