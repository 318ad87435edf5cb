//! Claims whose number depends on pedestrians that decide at first sight, and looks that outlast all vehicles: before anything runs.

use super::budget::at;
use super::sampled::SampledScenario;
use lang::{Code, Diagnostic, Sources};
use scenario::{
    Aggregate, Case, CaseSet, Claim, DeclaredMayGo, DeclaredPedestrian, Measured, MetricReference, Origin,
    OutcomesOf, Scenario, Stake, Suite,
};
use sim::{decides_at_first_sight, looks_until_all_are_past};

/// Scenarios with this tag are as their source has them.
const PUBLISHED: &str = "published";

/// One warning a suite: something claims a rate of collisions or a passing order in a scenario in which a pedestrian decides at first sight.
/// Suites that hold their results against a source are left out, and so are scenarios with the tag `published`.
pub(super) fn examine_first_sight(
    suite: &Suite,
    sampled: &[SampledScenario],
    sources: &Sources,
) -> Vec<Diagnostic> {
    let mut published = suite.statements.iter().map(|statement| &statement.source);
    if published.any(Option::is_some) || suite.evaluates.iter().any(|evaluate| evaluate.source.is_some()) {
        return Vec::new();
    }
    let mut told = sampled.iter().filter_map(|one| {
        let is_published = one.scenario.tags.iter().any(|tag| tag == PUBLISHED);
        let claim = depends_on_first_sight(suite, one.scenario).filter(|_| !is_published)?;
        Some((one.scenario, claim, decides_in_some(one)?))
    });
    let Some((scenario, (claim, origin), (pedestrian, share))) = told.next() else { return Vec::new() };
    let message = format!(
        "`{claim}` depends on `{pedestrian}` of `{}`, who decides at first sight{share}",
        scenario.name
    );
    let finding = at(Code::FirstSight, origin, message, sources)
        .label("is about people who have not looked")
        .hint("say for how long they look before they may go: `looks for 1 s`; populations that ship were fitted without a look, so that the new number is uncalibrated");
    vec![match told.count() {
        0 => finding,
        1 => finding.note("so it is in one more scenario"),
        others => finding.note(format!("so it is in {others} more scenarios")),
    }]
}

/// What claims a rate of collisions or a passing order in a scenario, and where.
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

/// Whether a metric says that a pedestrian was hit.
fn is_collision(metric: &MetricReference) -> bool {
    ["collision", "impact_speed"].contains(&metric.name())
}

/// The first pedestrian that decides at first sight, and in which share of the runs if not in all. Where a scenario says when it may go, some
/// values may let it go at once.
fn decides_in_some(SampledScenario { scenario, runs }: &SampledScenario) -> Option<(String, String)> {
    scenario.pedestrians.iter().enumerate().find_map(|(pedestrian, declared)| {
        let count = runs.iter().filter(|case| decides_at_first_sight(&case.world, pedestrian)).count();
        let share = share_of(count, runs)?;
        match (share.is_empty(), &declared.may_go) {
            (true, _) => Some((declared.name.clone(), share)),
            (false, DeclaredMayGo::AtOnce) => Some((declared.name.clone(), format!(" {share}"))),
            (false, _) => None,
        }
    })
}

/// Nothing of all runs, "in 3 of 40 runs looked at" of some; `None` of none.
fn share_of(count: usize, runs: &[Case]) -> Option<String> {
    match count {
        0 => None,
        all if all == runs.len() => Some(String::new()),
        some => Some(format!("in {some} of {} runs looked at", runs.len())),
    }
}

/// A warning for every pedestrian that looks until all vehicles are past: nothing is left to be met then.
pub(super) fn examine_long_looks(sampled: &[SampledScenario], sources: &Sources) -> Vec<Diagnostic> {
    sampled.iter().flat_map(|one| long_looks(one, sources)).collect()
}

fn long_looks(SampledScenario { scenario, runs }: &SampledScenario, sources: &Sources) -> Vec<Diagnostic> {
    let of_pedestrian = |(pedestrian, declared): (usize, &DeclaredPedestrian)| {
        let past = runs.iter().filter(|case| looks_until_all_are_past(&case.world, pedestrian)).count();
        let share = share_of(past, runs)?;
        let said = scenario.written.get(&format!("{}.looks", declared.name));
        let origin = said.map_or(&declared.origin, |said| &said.origin);
        let gap = if share.is_empty() { "" } else { " " };
        let message = format!(
            "{share}{gap}{} `{}` looks until every vehicle is past, unless one brakes for it",
            declared.kind.word(),
            declared.name
        );
        Some(at(Code::LongLook, origin, message, sources).label("nothing is left to meet").hint(
            "let vehicles be farther away by the look: `appears when time_to_arrival(av) = gap + look`, or `start gap + look before crossing`",
        ))
    };
    scenario.pedestrians.iter().enumerate().filter_map(of_pedestrian).collect()
}

#[cfg(test)]
mod tests {
    use super::super::sampled::sample;
    use super::*;
    use files::Memory;
    use models::standard;

    /// What is said to depend on first sight where a scenario whose pedestrian decides at first sight has these blocks.
    fn dependent(blocks: &str) -> Option<String> {
        let text = format!(
            "scenario a {{
  road {{ lane_width 3.5 m; speed_limit 30 km/h; crossing zebra }}
  draw gap from uniform(3 s, 6 s)
  vehicle av {{ controller yielding; speed 30 km/h; start gap before crossing }}
  pedestrian walker {{ model commotions; start 2 m from kerb }}
  repeat 20
  expect {{ mean(max_deceleration) <= 9 m/s^2 with 95 % confidence }}
}}
{blocks}
"
        );
        let files = Memory::default().with("text.scn", text.as_str());
        let loaded = lang::load("text.scn".as_ref(), &standard(), &files);
        let loaded = loaded.unwrap_or_else(|failure| panic!("{text}\n{:?}", failure.diagnostics));
        let found = examine_first_sight(&loaded.suite, &sample(&loaded.suite), &loaded.sources);
        assert!(found.len() <= 1);
        found.first().map(|finding| finding.message.split('`').nth(1).unwrap_or_default().to_string())
    }

    #[test]
    fn every_unit_that_claims_collisions_or_an_order_depends_on_first_sight() {
        let estimate = "estimate p { of a; event collision; budget 1000 runs, by crude }";
        let evaluate = "evaluate e { on a; with default; measure rate(collision) }";
        let tune = "tune t { on a; minimise mean(max_deceleration); subject to no collision
  over av.controller.margin in 0.5 m .. 2 m; budget 4 evaluations, by random }";
        let statement = "statement s { claim rate(collision) of a <= 50 % }";
        for (blocks, expected) in [
            ("", None),
            (estimate, Some("estimate p")),
            (evaluate, Some("evaluate e")),
            (tune, Some("tune t")),
            (statement, Some("rate(collision) of a <= 50 %")),
            ("statement s { source \"A book\"; claim rate(collision) of a <= 50 % }", None),
            ("statement s { claim mean(max_deceleration) of a <= 5 m/s^2 }", None),
        ] {
            assert_eq!(dependent(blocks).as_deref(), expected, "{blocks}");
        }
    }
}
