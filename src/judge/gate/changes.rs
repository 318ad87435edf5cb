//! What is tested and is not what it was.

use std::collections::BTreeSet;

use crate::judge::baseline::{Pairing, TestedVehicle};
use crate::results::Change;
use crate::scenario::{Declaration, Dimension, ModelSetup, ParameterKind, Value};
use crate::vehicle;

/// What is tested and differs, once each.
pub fn changes(pairing: &Pairing) -> Vec<Change> {
    let mut found: Vec<Change> = Vec::new();
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

/// What of a vehicle differs.
pub fn vehicle_changes(before: &TestedVehicle, after: &TestedVehicle) -> Vec<Change> {
    let vehicle = &after.name;
    let words = |what: &str, old: String, new: String| {
        (old != new).then(|| Change::Other(format!("{vehicle}.{what}: {old} -> {new}")))
    };
    let name = |setup: Option<&ModelSetup>| setup.map_or("none".to_string(), |setup| setup.name.clone());
    let controller = vehicle::controller(&after.controller.name).map(|model| &model.declaration);
    let dynamics = vehicle::dynamics(&after.dynamics.name).map(|model| &model.declaration);
    let parts = [
        ("controller", Some(&before.controller), Some(&after.controller), controller),
        ("dynamics", Some(&before.dynamics), Some(&after.dynamics), dynamics),
        ("sees", before.sees.as_ref(), after.sees.as_ref(), Some(&vehicle::PERCEPTION)),
    ];
    let mut changes = Vec::new();
    for (part, before, after, declaration) in parts {
        changes.extend(words(part, name(before), name(after)));
        let (Some(before), Some(after)) = (before, after) else { continue };
        if before.name != after.name {
            continue;
        }
        let settings = |setup: &ModelSetup| setup.settings.0.keys().cloned().collect::<BTreeSet<_>>();
        for parameter in settings(before).union(&settings(after)) {
            let what = format!("{part}.{parameter}");
            let dimension = declaration.and_then(|one| dimension(one, parameter));
            match (before.settings.get(parameter), after.settings.get(parameter), dimension) {
                (Some(Value::Number(old)), Some(Value::Number(new)), Some(dimension)) => {
                    changes.extend(number(vehicle, &what, *old, *new, dimension));
                }
                (old, new, _) => {
                    let text = |value: Option<&Value>| value.map_or("none".to_string(), Value::to_string);
                    changes.extend(words(&what, text(old), text(new)));
                }
            }
        }
    }
    changes.extend(words("name", before.name.clone(), after.name.clone()));
    changes.extend(number(vehicle, "length", before.length, after.length, Dimension::LENGTH));
    changes.extend(number(vehicle, "width", before.width, after.width, Dimension::LENGTH));
    changes
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
