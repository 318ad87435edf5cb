//! `test NAME as VEHICLE`: whether what is put in the place of controllers is put there, and what was there.

use super::places::TextPlaces;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::syntax::{ast, phrase};
use scenario::{Scenario, TestedInstead};

/// What is tested in the place of others, once the scenarios are checked, of which everything is said that is wrong.
pub fn tested<'s>(
    places: &TextPlaces,
    scenarios: impl Iterator<Item = &'s Scenario> + Clone,
    report: &mut Vec<Diagnostic>,
) -> Vec<TestedInstead> {
    let has_errors = crate::texts::has_errors(report);
    let mut all: Vec<ast::Tested> = Vec::new();
    let mut instead = Vec::new();
    for (node, _) in places.files.tested() {
        let vehicle = node.vehicle().name();
        if let Some(first) = all.iter().find(|first| first.vehicle().name().text() == vehicle.text()) {
            report.push(
                Diagnostic::new(
                    Code::NotTested,
                    node.span(),
                    format!("two controllers are to drive `{}`", vehicle.text()),
                )
                .label("the second one")
                .context(first.span(), "the first one")
                .hint("leave one of them out"),
            );
            continue;
        }
        all.push(node);
        set_besides(node, places, report);
        let replaced = places.files.tests.replaced();
        let Some(names) = replaced.get(vehicle.text()) else {
            // What could not be read may well have such a vehicle.
            if !has_errors {
                let vehicles = scenarios.clone().flat_map(|one| &one.vehicles);
                let mut known: Vec<&str> = vehicles.map(|vehicle| vehicle.name.as_str()).collect();
                known.sort_unstable();
                known.dedup();
                report.push(
                    Diagnostic::new(
                        Code::NotTested,
                        vehicle.span(),
                        format!("no scenario has a vehicle `{}`", vehicle.text()),
                    )
                    .label("nobody is called like this")
                    .suggest(vehicle.text(), known),
                );
            }
            continue;
        };
        let has_none = |one: &&Scenario| one.vehicles.iter().all(|own| own.name != vehicle.text());
        let without: Vec<&Scenario> = scenarios.clone().filter(has_none).collect();
        let all = scenarios.clone().count();
        if !node.where_present() {
            not_everywhere(node, &without, all, report);
        }
        let settings = node.settings().map(|settings| format!(" {}", phrase(*settings))).unwrap_or_default();
        instead.push(TestedInstead {
            vehicle: vehicle.text().to_string(),
            controller: format!("{}{settings}", node.name().text()),
            instead_of: names.iter().cloned().collect(),
            partly: (!without.is_empty()).then_some((all - without.len(), all)),
        });
    }
    instead
}

/// A suite that tests a controller has it in each of its scenarios, or says that it knows; of the command line it is a warning, since its files
/// may be of anything.
fn not_everywhere(node: ast::Tested, without: &[&Scenario], all: usize, report: &mut Vec<Diagnostic>) {
    let vehicle = node.vehicle().name().text();
    let place = |one: &Scenario| format!("declared in {}:{}", one.origin.file, one.origin.line);
    if node.is_of_command_line() {
        report.extend(without.iter().map(|one| {
            let message = format!("scenario `{}` has no vehicle `{vehicle}`", one.name);
            Diagnostic::new(Code::PartlyTested, node.span(), message)
                .label("is not tested there")
                .note(place(one))
                .hint("leave the scenario out, or rename its vehicle")
        }));
        return;
    }
    let Some(first) = without.first() else { return };
    let message = match without.len() {
        1 => format!("scenario `{}` has no vehicle `{vehicle}`", first.name),
        some => format!("{some} of {all} scenarios have no vehicle `{vehicle}`, such as `{}`", first.name),
    };
    report.push(
        Diagnostic::new(Code::NotTested, node.span(), message)
            .label("is not tested there")
            .note(place(first))
            .hint("leave the scenario out, or rename its vehicle; if that is meant, say `where present` behind this"),
    );
}

/// A value that is set for the controller that is replaced would be lost.
fn set_besides(node: ast::Tested, places: &TextPlaces, report: &mut Vec<Diagnostic>) {
    let (vehicle, controller) = (node.vehicle().name().text(), node.name().text());
    for one in places.files.overrides.all() {
        let part = one.name.strip_prefix(vehicle).and_then(|rest| rest.strip_prefix(".controller"));
        let hint = match part.map(|part| part.strip_prefix('.')) {
            Some(Some(parameter)) => format!("say it here: `{controller} {{ {parameter}: {} }}`", one.value),
            Some(None) => "leave one of them out".to_string(),
            None => continue,
        };
        report.push(
            Diagnostic::new(
                Code::NotTested,
                node.span(),
                format!("`{one}` is set for a controller that `{controller}` takes the place of"),
            )
            .label("comes with settings of its own")
            .hint(hint),
        );
    }
}
