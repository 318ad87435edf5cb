//! Criteria about running a red light on roads that have no signal: looked at before anything runs.

use super::budget::{add_once, at};
use crate::plan;
use lang::{Code, Diagnostic, Sources};
use scenario::{Case, Criterion, CrossingKind, Scenario, Stake, Suite};

/// A warning for every criterion about red lights in a scenario in which none of its vehicles reaches a signal. What cannot be planned
/// is left to planning.
pub fn examine_signals(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> = Vec::new();
    for scenario in &suite.scenarios {
        of_scenario(suite, scenario, sources).into_iter().for_each(|finding| add_once(&mut found, finding));
    }
    found
}

fn of_scenario(suite: &Suite, scenario: &Scenario, sources: &Sources) -> Vec<Diagnostic> {
    let needs_red = |criterion: &&Criterion| {
        criterion.claim.metric().known().is_some_and(|metric| metric.stake == Stake::Value)
    };
    let concerned: Vec<&Criterion> = scenario.criteria.iter().filter(needs_red).collect();
    if concerned.is_empty() {
        return Vec::new();
    }
    let Ok(trials) = plan::probe_scenario(suite, scenario) else { return Vec::new() };
    let comes_to_a_signal = |criterion: &Criterion| {
        trials.iter().flat_map(|trial| trial.cases.iter()).any(|case| has_signal(&case, criterion))
    };
    let blind = concerned.into_iter().filter(|criterion| !comes_to_a_signal(criterion));
    let warning = |criterion: &Criterion| {
        let message = format!("`{}` is about red lights, and no vehicle reaches a signal", criterion.text);
        at(Code::NoSignal, &criterion.origin, message, sources)
            .label("no run can put this to the test")
            .hint("declare `crossing signalised { … }` on the road, or leave the criterion out")
    };
    blind.map(warning).collect()
}

/// Whether a vehicle that a criterion is about reaches a signal that shows red to vehicles.
fn has_signal(case: &Case, criterion: &Criterion) -> bool {
    let metric = criterion.claim.metric();
    let meant = case.world.vehicles.iter().filter(|car| metric.is_of_vehicle(&car.name));
    meant.into_iter().any(|car| {
        let mut crossings = case.world.road_of(car).crossings();
        crossings.any(|(_, crossing)| match crossing.kind {
            CrossingKind::Signalised(signal) => signal.pedestrian_green > 0.0,
            _ => false,
        })
    })
}
