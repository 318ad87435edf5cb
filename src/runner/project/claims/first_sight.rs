//! Claims whose number depends on people who decide at first sight: looked at before anything runs.

use super::budget::at;
use crate::plan;
use lang::{Code, Diagnostic, Sources};
use scenario::{Aggregate, Claim, Comparison, DeclaredMayGo, Origin, Scenario, Stake, Suite};
use sim::decides_at_first_sight;

/// Scenarios with this tag are as somebody published them.
const AS_PUBLISHED: &str = "published";

/// So many drawn runs of a scenario are looked at, at most.
const MOST_DRAWN: usize = 40;

/// One warning a suite, where in a scenario that something claims a rate of collisions or who goes first of, people decide at first sight.
/// Scenarios with the tag `published` are left out, and what cannot be planned is left to planning.
pub(super) fn examine_first_sight(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let told = suite.scenarios.iter().filter(|scenario| !scenario.tags.iter().any(|tag| tag == AS_PUBLISHED));
    let mut found: Option<(Diagnostic, usize)> = None;
    for scenario in told {
        let Some((what, origin)) = depends_on_first_sight(suite, scenario) else { continue };
        let Some((who, share)) = people_at_first_sight(suite, scenario) else { continue };
        if let Some((_, others)) = &mut found {
            *others += 1;
            continue;
        }
        let message =
            format!("`{what}` depends on `{who}` of `{}`, who decides at first sight{share}", scenario.name);
        let finding = at(Code::FirstSight, origin, message, sources)
            .label("is about people who have not looked")
            .hint("say for how long they look before they may go: `looks for 1 s`; the number is then another one, and not a corrected one");
        found = Some((finding, 0));
    }
    let said = |(finding, others): (Diagnostic, usize)| match others {
        0 => finding,
        1 => finding.note("so it is in one more scenario"),
        _ => finding.note(format!("so it is in {others} more scenarios")),
    };
    found.map(said).into_iter().collect()
}

/// What claims a rate of collisions or who goes first in a scenario, and where.
fn depends_on_first_sight<'s>(suite: &'s Suite, scenario: &'s Scenario) -> Option<(String, &'s Origin)> {
    let mut criteria = scenario.criteria.iter().filter(|criterion| depends(&criterion.claim));
    let criterion = criteria.next().map(|criterion| (criterion.text.clone(), &criterion.origin));
    let about = |name: &Option<String>| name.as_ref() == Some(&scenario.name);
    let mut estimates = suite.estimates.iter().filter(|estimate| {
        (estimate.scenario == scenario.name || about(&estimate.compared_with))
            && is_collision(&estimate.event)
    });
    criterion.or_else(|| {
        estimates.next().map(|estimate| (format!("estimate {}", estimate.name), &estimate.origin))
    })
}

fn depends(claim: &Claim) -> bool {
    let is_order = claim.metric().known().is_some_and(|metric| metric.stake == Stake::Order);
    let is_rate = match claim {
        Claim::Aggregate { aggregate: Aggregate::Rate(event) | Aggregate::Count(event), .. } => {
            is_collision(event)
        }
        Claim::Runs { comparison, share, confidence } => {
            (share.is_some() || confidence.is_some()) && is_collision(comparison)
        }
        Claim::Aggregate { .. } => false,
    };
    is_order || is_rate
}

fn is_collision(event: &Comparison) -> bool {
    event.metric.name() == "collision"
}

/// The first pedestrian of a scenario who decides at first sight, and in which share of the runs if not in all.
fn people_at_first_sight(suite: &Suite, scenario: &Scenario) -> Option<(String, String)> {
    let runs = plan::sample_scenario(suite, scenario, MOST_DRAWN).ok()?;
    // Of people of whom it is said when they may go the user has thought.
    let unsaid = |person: &usize| scenario.pedestrians[*person].may_go == DeclaredMayGo::AtOnce;
    (0..scenario.pedestrians.len()).filter(unsaid).find_map(|person| {
        let count = runs.iter().filter(|case| decides_at_first_sight(&case.world, person)).count();
        let share = match count {
            0 => return None,
            all if all == runs.len() => String::new(),
            some => format!(" in {some} of {} runs looked at", runs.len()),
        };
        Some((scenario.pedestrians[person].name.clone(), share))
    })
}
