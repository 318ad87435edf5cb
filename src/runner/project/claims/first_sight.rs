//! Claims whose number depends on people who decide at first sight, and looks that outlast all vehicles: looked at before anything runs.

use super::budget::at;
use crate::plan;
use lang::{Code, Diagnostic, Sources};
use scenario::{
    Aggregate, CaseSet, Claim, DeclaredMayGo, DeclaredPedestrian, LookEffect, Measured, MetricReference,
    Origin, OutcomesOf, Scenario, Stake, Suite,
};
use sim::{decides_at_first_sight, looks_until_all_are_past};

/// Scenarios with this tag are as somebody published them.
const AS_PUBLISHED: &str = "published";

/// So many drawn runs of a scenario are looked at, at most.
const MOST_DRAWN: usize = 40;

/// One warning a suite, where in a scenario that something claims a rate of collisions or who goes first of, people decide at first sight.
/// Suites that hold their results against a source are left out, and so are scenarios with the tag `published`; what cannot be planned is left
/// to planning.
pub(super) fn examine_first_sight(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let mut published = suite.statements.iter().map(|statement| &statement.source);
    if published.any(Option::is_some) || suite.evaluates.iter().any(|evaluate| evaluate.source.is_some()) {
        return Vec::new();
    }
    let believes = |person: &DeclaredPedestrian| {
        let models = person.model.all().iter().filter_map(|model| model.known());
        models.into_iter().any(|model| model.look == LookEffect::Counts)
    };
    let told = suite.scenarios.iter().filter(|scenario| {
        scenario.pedestrians.iter().any(believes) && !scenario.tags.iter().any(|tag| tag == AS_PUBLISHED)
    });
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
            .hint("say for how long they look before they may go: `looks for 1 s`; populations that ship were fitted without a look, so that the new number is uncalibrated");
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
    let is_it = |name: &str| name == scenario.name;
    let criteria = scenario.criteria.iter().filter(|criterion| depends(&criterion.claim));
    let criteria = criteria.map(|criterion| (criterion.text.clone(), &criterion.origin));
    let estimates = suite.estimates.iter().filter(|estimate| {
        let about = is_it(&estimate.scenario) || estimate.compared_with.as_deref().is_some_and(is_it);
        about && is_collision(&estimate.event.metric)
    });
    let estimates = estimates.map(|estimate| (format!("estimate {}", estimate.name), &estimate.origin));
    let evaluates = suite.evaluates.iter().filter(|evaluate| {
        is_on(&evaluate.on, is_it) && evaluate.measures.iter().any(|measure| is_rate(&measure.aggregate))
    });
    let evaluates = evaluates.map(|evaluate| (format!("evaluate {}", evaluate.name), &evaluate.origin));
    let tunes = suite.tunes.iter().filter(|tune| {
        let mut bounds = tune.constraints.iter();
        is_on(&tune.on, is_it) && bounds.any(|bound| is_collision(&bound.metric) || is_order(&bound.metric))
    });
    let tunes = tunes.map(|tune| (format!("tune {}", tune.name), &tune.origin));
    let statements = suite.statements.iter().flat_map(|statement| &statement.claims);
    let statements = statements.filter(|claim| claim.measured().iter().any(|one| is_of(one, is_it)));
    let statements = statements.map(|claim| (claim.text.clone(), &claim.origin));
    criteria.chain(estimates).chain(evaluates).chain(tunes).chain(statements).next()
}

fn is_on(cases: &CaseSet, is_it: impl Fn(&str) -> bool) -> bool {
    match cases {
        CaseSet::Scenario(scenario) | CaseSet::Sample { scenario, .. } => is_it(scenario),
        CaseSet::Search(_) | CaseSet::Bests(_) | CaseSet::Saved(_) => false,
    }
}

fn is_of(measured: &Measured, is_it: impl Fn(&str) -> bool) -> bool {
    matches!(&measured.of, OutcomesOf::Scenario(name) if is_it(name)) && is_rate(&measured.aggregate)
}

fn depends(claim: &Claim) -> bool {
    match claim {
        Claim::Aggregate { aggregate, .. } => is_rate(aggregate),
        Claim::Runs { comparison, share, confidence } => {
            let is_share = share.is_some() || confidence.is_some();
            is_order(&comparison.metric) || is_share && is_collision(&comparison.metric)
        }
    }
}

fn is_rate(aggregate: &Aggregate) -> bool {
    let counts = matches!(aggregate, Aggregate::Rate(_) | Aggregate::Count(_));
    is_order(aggregate.metric()) || counts && is_collision(aggregate.metric())
}

fn is_order(metric: &MetricReference) -> bool {
    metric.known().is_some_and(|metric| metric.stake == Stake::Order)
}

/// Metrics that say whether somebody was hit.
fn is_collision(metric: &MetricReference) -> bool {
    ["collision", "impact_speed"].contains(&metric.name())
}

/// The first pedestrian of a scenario who decides at first sight, and in which share of the runs if not in all. Where something says when a
/// pedestrian may go, some values may let it go at once.
fn people_at_first_sight(suite: &Suite, scenario: &Scenario) -> Option<(String, String)> {
    let runs = plan::sample_scenario(suite, scenario, MOST_DRAWN).ok()?;
    (0..scenario.pedestrians.len()).find_map(|person| {
        let count = runs.iter().filter(|case| decides_at_first_sight(&case.world, person)).count();
        let is_unsaid = scenario.pedestrians[person].may_go == DeclaredMayGo::AtOnce;
        let share = match count {
            all if all == runs.len() && all > 0 => String::new(),
            some if some > 0 && is_unsaid => format!(" in {some} of {} runs looked at", runs.len()),
            _ => return None,
        };
        Some((scenario.pedestrians[person].name.clone(), share))
    })
}

/// A warning for every pedestrian that looks until all vehicles are past: nothing is left to be met then.
pub(super) fn examine_long_looks(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let looks = |person: &DeclaredPedestrian| matches!(person.may_go, DeclaredMayGo::After(_));
    let mut found = Vec::new();
    for scenario in suite.scenarios.iter().filter(|scenario| scenario.pedestrians.iter().any(looks)) {
        let runs = plan::sample_scenario(suite, scenario, MOST_DRAWN).unwrap_or_default();
        for (person, declared) in scenario.pedestrians.iter().enumerate() {
            let past = runs.iter().filter(|case| looks_until_all_are_past(&case.world, person)).count();
            if past == 0 {
                continue;
            }
            let share = if past == runs.len() {
                String::new()
            } else {
                format!("in {past} of {} runs looked at ", runs.len())
            };
            let said = scenario.written.get(&format!("{}.looks", declared.name));
            let origin = said.map_or(&declared.origin, |said| &said.origin);
            let message = format!(
                "{share}{} `{}` looks until every vehicle is past, unless one brakes for it",
                declared.kind.word(),
                declared.name
            );
            found.push(at(Code::LongLook, origin, message, sources).label("nothing is left to meet").hint(
                "let vehicles be farther away by the look: `appears when time_to_arrival(av) = gap + look`, or `start gap + look before crossing`",
            ));
        }
    }
    found
}
