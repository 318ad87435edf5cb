//! Lanes that a box blocks although nothing says that this is meant: looked at before anything runs.

use crate::plan;
use lang::{Code, Diagnostic, Sources, Span};
use scenario::{Scenario, Suite};
use sim::{Solid, blocked_lanes};

/// Scenarios with this tag have boxes in lanes on purpose.
const MEANT: &str = "blocked_lane";

/// A warning for every vehicle that cannot get to its finish line because a box stands in its lane, unless a criterion of
/// its scenario names the box or the scenario is tagged `blocked_lane`. What cannot be planned is left to planning.
pub fn examine_lanes(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let concerned = suite
        .scenarios
        .iter()
        .filter(|scenario| !scenario.road.boxes.is_empty() && !scenario.tags.iter().any(|tag| tag == MEANT));
    concerned.flat_map(|scenario| of_scenario(suite, scenario, sources)).collect()
}

fn of_scenario(suite: &Suite, scenario: &Scenario, sources: &Sources) -> Vec<Diagnostic> {
    let Ok(trials) = plan::probe_scenario(suite, scenario) else { return Vec::new() };
    let mut known: Vec<(String, usize)> = Vec::new();
    let mut found = Vec::new();
    for case in trials.iter().flat_map(|trial| trial.cases.iter()) {
        for (vehicle, index, way) in blocked_lanes(&case.world) {
            let driven = &case.world.vehicles[vehicle].name;
            let Some(car) = scenario.vehicle(driven) else { continue };
            let body = Solid::Box(index).name(&case.world);
            let named = scenario.criteria.iter().any(|criterion| {
                let metric = criterion.claim.metric();
                let with = metric.pair.as_ref().map(|(_, with)| with);
                metric.is_of_vehicle(driven) && with.is_some_and(|with| with == body)
            });
            if named || known.contains(&(car.name.clone(), index)) {
                continue;
            }
            known.push((car.name.clone(), index));
            let span = sources.span(&scenario.origin).unwrap_or_else(|| {
                let (first, _) = sources.iter().next().expect("a suite was read from somewhere");
                Span::beginning(first)
            });
            let message = format!("box `{body}` stands in the lane of `{}`", car.name);
            found.push(
                Diagnostic::new(Code::BlockedLane, span, message)
                    .label("its vehicle runs into the box unless it stops")
                    .note(format!("{:.1} m ahead of its centre at the start, in {}", way.max(0.0), case.key))
                    .hint(format!(
                        "move the box; or, if it is meant, name it in a criterion, such as \
                         `no collision({}, {body})`, or say `tags {MEANT}`",
                        car.name
                    )),
            );
        }
    }
    found
}
