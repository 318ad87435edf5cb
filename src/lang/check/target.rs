//! `tta` or `av.controller.braking_distance`: what is searched, tuned, set and asked for.

use super::subject::{StatementSubject, declarations, groups};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings;
use crate::syntax::ast;
use crate::value::ValueKind;
use scenario::{ANOTHER_MODEL, Declaration, Expression, Part, Scenario, Target, Value};

/// What a target takes: anything of a kind, or what a parameter declares.
pub enum Takes {
    Kind(ValueKind),
    Parameter(Declaration, String),
}

/// Reports a target that has one published value, unless the scenario's settings say that another model is meant.
pub fn reject_unmeant(
    node: ast::Target,
    target: &Target,
    takes: &Takes,
    scenario: &Scenario,
    what: &str,
    report: &mut Vec<Diagnostic>,
) -> Option<()> {
    let (Takes::Parameter(declaration, name), Target::Setting { road_user, .. }) = (takes, target) else {
        return Some(());
    };
    if declaration.parameter(name).is_none_or(|parameter| parameter.published.is_none()) {
        return Some(());
    }
    let cars = scenario.vehicles.iter().filter(|car| car.name == *road_user);
    let people = scenario.pedestrians.iter().filter(|person| person.is(road_user));
    let settings =
        cars.map(|car| &car.controller.settings).chain(people.map(|person| &person.model.settings));
    let meant = settings.into_iter().any(|settings| {
        let flag = settings.iter().find(|(name, _)| name == ANOTHER_MODEL);
        flag.is_some_and(|(_, said)| *said == Expression::Constant(Value::Flag(true)))
    });
    if !meant {
        report.push(settings::unmeant(node.span(), &format!("`{target}`"), what));
        return None;
    }
    Some(())
}

/// What a name means, and what it takes.
pub fn target(
    node: ast::Target,
    subject: &StatementSubject,
    report: &mut Vec<Diagnostic>,
) -> Option<(Target, Takes)> {
    let name = node.name();
    let scenario = subject.scenario;
    let Some(parameter) = node.parameter() else {
        let kind =
            subject.varied.get(name.text()).map(|binding| binding.value.as_ref().map(|value| value.kind));
        let Some(kind) = kind else {
            report.push(
                Diagnostic::new(
                    Code::BadTarget,
                    name.span(),
                    format!("scenario `{}` does not vary `{}`", scenario.name, name.text()),
                )
                .label("not varied")
                .suggest(name.text(), subject.varied.keys().map(String::as_str)),
            );
            return None;
        };
        return Some((Target::Variation(name.text().to_string()), Takes::Kind(kind?)));
    };
    let part = match (node.is_of_controller(), node.is_of_dynamics(), node.is_of_sees()) {
        (true, ..) => Part::Controller,
        (_, true, _) => Part::Dynamics,
        (.., true) => Part::Sees,
        _ => Part::Model,
    };
    let declared = declarations(scenario, name.text(), part, &subject.registry);
    if declared.is_empty() {
        let users = scenario.vehicles.iter().map(|vehicle| vehicle.name.as_str());
        let people = scenario.pedestrians.iter().map(|person| person.name.as_str());
        let groups = groups(&scenario.pedestrians);
        let everybody: Vec<_> = users.chain(people).chain(groups.iter().map(|(group, _)| *group)).collect();
        let known = everybody.contains(&name.text());
        let diagnostic = Diagnostic::new(
            Code::BadTarget,
            node.span(),
            format!("there is no `{}` in scenario `{}`", node.text(), scenario.name),
        )
        .label(if known { "has no such part" } else { "no road user of this name" });
        report.push(if known {
            diagnostic.hint("vehicles have `controller`, `dynamics` and `sees`, pedestrians `model`")
        } else {
            diagnostic.suggest(name.text(), everybody)
        });
        return None;
    }
    // Where a variation chooses between several, each of them must have it.
    let mut takes = None;
    for declaration in &declared {
        let presets = declaration.presets.as_ref().map(|family| &*family.word);
        let names = declaration.parameters.iter().map(|found| &*found.name).chain(presets);
        let Some(found) = names.clone().find(|known| *known == parameter.text()).map(str::to_string) else {
            report.push(
                Diagnostic::new(
                    Code::UnknownParameter,
                    parameter.span(),
                    format!("`{}` has no parameter `{}`", declaration.name, parameter.text()),
                )
                .label("unknown parameter")
                .suggest(parameter.text(), names),
            );
            return None;
        };
        takes.get_or_insert(Takes::Parameter(declaration.clone(), found));
    }
    let target =
        Target::Setting { road_user: name.text().to_string(), part, parameter: parameter.text().to_string() };
    Some((target, takes?))
}
