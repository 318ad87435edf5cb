//! `controller commotions { same_as: walker }`: that there is such a pedestrian, and that it has parameters to give.

use super::model::Named;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::value::Typed;
use scenario::{ControllerModel, DeclaredPedestrian, Expression, Membership, ParameterKind, Value};

/// A setting of a controller that names a pedestrian.
pub struct SameAs {
    /// The controller.
    owner: String,
    /// The parameter's name.
    parameter: String,
    said: Typed,
}

/// The settings of a controller that name pedestrians.
pub fn same_as(controller: &Named<ControllerModel>) -> Vec<SameAs> {
    let declarations = || controller.found.iter().map(|found| &found.declaration);
    let names = |name: &str| {
        let declared = |declaration: &&scenario::Declaration| {
            let parameter = declaration.parameter(name);
            parameter.is_some_and(|one| matches!(one.kind, ParameterKind::Pedestrian))
        };
        declarations().find(declared).map(|declaration| declaration.name.to_string())
    };
    let settings = controller.given.iter().filter_map(|(parameter, said)| {
        Some(SameAs { owner: names(parameter)?, parameter: parameter.clone(), said: said.clone() })
    });
    settings.collect()
}

/// Reports those who are not there, and those with another model. What varies is looked at when the runs are planned.
pub fn check_same_as(alike: &[SameAs], pedestrians: &[DeclaredPedestrian], report: &mut Vec<Diagnostic>) {
    for SameAs { owner, parameter, said } in alike {
        let Expression::Constant(Value::Word(name)) = &said.expression else { continue };
        let what = format!("`{parameter}` of `{owner}`");
        let unknown = |message: String| {
            Diagnostic::new(Code::UnknownPedestrian, said.span, message)
                .label("no pedestrian of this scenario")
        };
        let Some(walker) = pedestrians.iter().find(|one| one.name == *name) else {
            let of_group =
                |one: &&DeclaredPedestrian| one.group.as_ref().is_some_and(|group| group.group == *name);
            report.push(match pedestrians.iter().find(of_group).and_then(|one| one.group.as_ref()) {
                Some(group) => {
                    unknown(format!("{what} names the group `{name}`, where one person is needed"))
                        .hint(format!("name a member: `{}`", Membership::member_name(group)))
                }
                None => unknown(format!("{what} names `{name}`, and there is no such pedestrian"))
                    .suggest(name, pedestrians.iter().map(|one| one.name.as_str())),
            });
            continue;
        };
        if let Some(other) = walker.model.all().iter().find(|model| model.name() != owner) {
            let message = format!("{what} names `{name}`, whose model is `{other}`");
            report.push(
                Diagnostic::new(Code::DoesNotFit, said.span, message)
                    .label(format!("has no parameters of `{owner}`"))
                    .hint(format!("give `{name}` the model `{owner}`, or leave `{parameter}` out")),
            );
        }
    }
}
