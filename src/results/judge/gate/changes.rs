//! What is tested and is not what it was.

use std::collections::BTreeSet;

use crate::Change;
use crate::judge::baseline::{Baseline, Pairing, TestedVehicle};
use scenario::{Declaration, Dimension, ModelSetup, ParameterKind, Registered, Value};

/// What is tested and differs, once each.
pub fn changes(pairing: &Pairing) -> Vec<Change> {
    let mut found: Vec<Change> = Vec::new();
    let titles = (&pairing.base.programs, &pairing.candidate.programs);
    // Of one name, and yet another program: what it says of itself need not tell.
    let commands = (&pairing.base.what_runs, &pairing.candidate.what_runs);
    for (what, (before, after)) in [("", titles), (" runs", commands)] {
        for (name, now) in after {
            let changed = before.get(name).filter(|known| *known != now);
            found.extend(changed.map(|known| Change::Other(format!("{name}{what}: {known} -> {now}"))));
        }
    }
    for (base, candidate) in &pairing.trials {
        let before = &pairing.base.vehicles[base.vehicles];
        let after = &pairing.candidate.vehicles[candidate.vehicles];
        for (before, after) in before.iter().zip(after) {
            for change in vehicle_changes(before, after) {
                if !found.contains(&change) {
                    found.push(change);
                }
            }
        }
    }
    found
}

/// Which programs do not decide the same each time, a sentence for each side that is known of.
pub fn nondeterministic(pairing: &Pairing) -> Vec<String> {
    let sides = [("base", pairing.base), ("candidate", pairing.candidate)];
    let of = |(side, baseline): (&str, &Baseline)| {
        let each = baseline.nondeterministic.iter();
        each.map(|(name, how)| format!("W1102: `{name}` of the {side} is not deterministic: {how}"))
            .collect::<Vec<_>>()
    };
    sides.into_iter().flat_map(of).collect()
}

/// What of a vehicle differs.
pub fn vehicle_changes(before: &TestedVehicle, after: &TestedVehicle) -> Vec<Change> {
    let vehicle = &after.name;
    let mut changes = Vec::new();
    changes.extend(setup_changes(vehicle, "controller", Some(&before.controller), Some(&after.controller)));
    changes.extend(setup_changes(vehicle, "dynamics", Some(&before.dynamics), Some(&after.dynamics)));
    changes.extend(setup_changes(vehicle, "sees", before.sees.as_ref(), after.sees.as_ref()));
    changes.extend(words(vehicle, "name", before.name.clone(), after.name.clone()));
    let obeys = |one: &TestedVehicle| if one.obeys_signals { "yes" } else { "no" }.to_string();
    changes.extend(words(vehicle, "obeys_signals", obeys(before), obeys(after)));
    changes.extend(number(vehicle, "length", before.length, after.length, Dimension::LENGTH));
    changes.extend(number(vehicle, "width", before.width, after.width, Dimension::LENGTH));
    changes
}

/// A part of a vehicle before and after: what it is, and every parameter that one of them has.
fn setup_changes<T: Registered>(
    vehicle: &str,
    part: &str,
    before: Option<&ModelSetup<T>>,
    after: Option<&ModelSetup<T>>,
) -> Vec<Change> {
    let name =
        |setup: Option<&ModelSetup<T>>| setup.map_or("none".to_string(), |setup| setup.model.to_string());
    let mut changes: Vec<Change> = words(vehicle, part, name(before), name(after)).into_iter().collect();
    let (Some(before), Some(after)) = (before, after) else { return changes };
    if before.model != after.model {
        return changes;
    }
    let settings = |setup: &ModelSetup<T>| setup.settings.0.keys().cloned().collect::<BTreeSet<_>>();
    for parameter in settings(before).union(&settings(after)) {
        let what = format!("{part}.{parameter}");
        let dimension = after.model.declaration().and_then(|one| dimension(one, parameter));
        match (before.settings.get(parameter), after.settings.get(parameter), dimension) {
            (Some(Value::Number(old)), Some(Value::Number(new)), Some(dimension)) => {
                changes.extend(number(vehicle, &what, *old, *new, dimension));
            }
            (old, new, _) => {
                let text = |value: Option<&Value>| value.map_or("none".to_string(), Value::to_string);
                changes.extend(words(vehicle, &what, text(old), text(new)));
            }
        }
    }
    changes
}

fn words(vehicle: &str, what: &str, old: String, new: String) -> Option<Change> {
    (old != new).then(|| Change::Other(format!("{vehicle}.{what}: {old} -> {new}")))
}

fn number(vehicle: &str, what: &str, before: f64, after: f64, dimension: Dimension) -> Option<Change> {
    let what = format!("{vehicle}.{what}");
    (before != after).then_some(Change::Number { what, before, after, dimension, notation: None })
}

/// Of the numbers that a parameter takes.
fn dimension(declaration: &Declaration, parameter: &str) -> Option<Dimension> {
    match declaration.parameters.iter().find(|known| known.name == parameter)?.kind {
        ParameterKind::Number { dimension, .. } => Some(dimension),
        _ => None,
    }
}
