//! The run that passed and is nearest to another one, among those that were made.

use super::per_run::per_run;
use crate::{Neighbour, Outcome, Results, TrialReport};
use scenario::{Case, Draw, Value};

/// Of the runs of its scenario with all that is wanted of each, the one nearest to a case; `None` if there is none.
///
/// Values that differ count by their distance as a share of the span of all runs of the scenario, words and people 1 each; of two
/// equally near the first is taken. A run that ended before somebody was met has not passed.
pub fn nearest_passing(results: &Results, case: &Case) -> Option<Neighbour> {
    let trials = || results.suites.iter().flat_map(|suite| &suite.trials);
    let runs = || {
        let of_scenario = trials().filter(|trial| trial.trial.scenario == case.scenario);
        of_scenario.flat_map(|trial| trial.outcomes.iter().map(move |outcome| (trial, outcome)))
    };
    let mine: Vec<(String, String, Value)> = values_of_case(case);
    let spans: Vec<f64> = mine
        .iter()
        .map(|(name, _, _)| {
            let numbers =
                runs().flat_map(|(trial, outcome)| values(trial, outcome)).filter_map(|one| match one.2 {
                    Value::Number(number) if one.0 == *name => Some(number),
                    _ => None,
                });
            let (low, high) = numbers
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), one| (low.min(one), high.max(one)));
            high - low
        })
        .collect();
    let passing = runs().filter(|(trial, outcome)| {
        outcome.key != case.key && {
            let mut wanted = trial.trial.criteria.iter().filter_map(per_run).peekable();
            wanted.peek().is_some()
                && wanted.all(|one| one.standing(outcome, &results.requests).holds)
                && !outcome.hides_meetings()
        }
    });
    let with_distance = passing.map(|(trial, outcome)| {
        let theirs = values(trial, outcome);
        let (mut distance, mut differences) = (0.0, Vec::new());
        for ((name, label, value), span) in mine.iter().zip(&spans) {
            let other = theirs.iter().find(|one| one.0 == *name);
            distance += match (value, other.map(|one| &one.2)) {
                (one, Some(other)) if one == other => continue,
                (Value::Number(one), Some(Value::Number(other))) if *span > 0.0 => (one - other).abs() / span,
                _ => 1.0,
            };
            let there = other.map_or_else(|| "-".to_string(), |one| one.1.clone());
            differences.push((name.clone(), there, label.clone()));
        }
        (distance, Neighbour { key: outcome.key.clone(), differences })
    });
    with_distance.min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, neighbour)| neighbour)
}

/// What makes a case one of many: names with labels and values.
fn values_of_case(case: &Case) -> Vec<(String, String, Value)> {
    let varied = case.variation.iter().map(|one| (one.name.clone(), one.label.clone(), one.value.clone()));
    let drawn = drawn(&case.drawn);
    let people = case.individuals.iter().map(person);
    varied.chain(drawn).chain(people).collect()
}

fn values(trial: &TrialReport, outcome: &Outcome) -> Vec<(String, String, Value)> {
    let varied = trial.trial.variation.iter();
    let varied = varied.map(|one| (one.name.clone(), one.label.clone(), one.value.clone()));
    varied.chain(drawn(&outcome.drawn)).chain(outcome.individuals.iter().map(person)).collect()
}

/// What was drawn, but for people, whose draw has a name that no file can give.
fn drawn(draws: &[Draw]) -> impl Iterator<Item = (String, String, Value)> {
    let own = draws.iter().filter(|one| !one.name.contains('.'));
    own.map(|one| (one.name.clone(), one.label.clone(), one.value.clone()))
}

/// Numbers of people are names: 17 is no nearer to 18 than to 3.
fn person(one: &scenario::Individual) -> (String, String, Value) {
    let label = format!("{} of {}", one.number, one.population);
    (format!("{} individual", one.pedestrian), label.clone(), Value::Word(label))
}
