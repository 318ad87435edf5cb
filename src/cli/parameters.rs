//! Parameter files put over a suite, so that two sets can be compared on it.

use std::path::Path;

use super::{Exit, load};
use files::Disk;
use lang::{self, Excerpt, NamedValue, Style, nearest};
use report::console::stderr;
use runner::experiment::{ParameterFile, apply_settings};
use scenario::registry::Registry;
use scenario::{Declaration, ParameterKind, Part, Scenario, Settings, Suite, Target, Value};

/// Puts what the parameter file at `path` says over the vehicles of `suite`, which was read from `file`. Definitions
/// reach every vehicle that has a parameter of that name, or the one that a whole name such as
/// `av_controller_braking_distance` begins with; JSON names vehicle and part. What is wrong goes to stderr.
pub fn put_over(suite: &mut Suite, file: &str, path: &Path, registry: &Registry) -> Result<(), Exit> {
    let colour = stderr().takes_colour();
    if load::names_a_file(&path.to_string_lossy()) {
        let values = lang::named_values(path, registry, &Disk).map_err(|failure| {
            stderr().styled(&failure.render(Style { colour }));
            Exit::Scenario
        })?;
        if values.is_empty() {
            writeln!(stderr(), "error: {} defines nothing", path.display());
            writeln!(stderr(), "help: write parameters of a controller as `let braking_distance = 4.75 m`");
            return Err(Exit::Usage);
        }
        return values.iter().try_for_each(|value| put_named(suite, file, value, colour));
    }
    let parameters = ParameterFile::read(path, &Disk).map_err(|error| {
        writeln!(stderr(), "error: {error}");
        Exit::Usage
    })?;
    for setting in &parameters.parameters {
        let mut fits = false;
        for scenario in &mut suite.scenarios {
            let mut changed = scenario.clone();
            if apply_settings(&mut changed, std::slice::from_ref(setting)).is_ok() {
                *scenario = changed;
                fits = true;
            }
        }
        if !fits {
            writeln!(
                stderr(),
                "error: no scenario of {file} has `{}`, which {} sets",
                setting.0,
                path.display()
            );
            return Err(Exit::Usage);
        }
    }
    Ok(())
}

fn put_named(suite: &mut Suite, file: &str, value: &NamedValue, colour: bool) -> Result<(), Exit> {
    let wrong = |title: String, help: Option<String>| {
        let excerpt =
            Excerpt { title: &title, origin: &value.origin, label: "", notes: &[], help: help.as_deref() };
        stderr().styled(&format!("{}\n\n", excerpt.render(colour)));
        Exit::Usage
    };
    let mut known: Vec<String> = Vec::new();
    let mut fits = false;
    for scenario in &mut suite.scenarios {
        for (road_user, part, declaration) in tested_parts(scenario) {
            known.extend(declaration.parameters.iter().map(|parameter| parameter.name.to_string()));
            let target = |parameter: &str| {
                let road_user = road_user.clone();
                Target::Setting { road_user, part, parameter: parameter.to_string() }
            };
            let whole = target("").identifier();
            let candidates = [Some(value.name.as_str()), value.name.strip_prefix(&whole)];
            let Some(parameter) = candidates.into_iter().flatten().find(|name| takes(&declaration, name))
            else {
                continue;
            };
            fits = true;
            let named = NamedValue { name: parameter.to_string(), ..value.clone() };
            check(&declaration, &named).map_err(|reason| wrong(reason, None))?;
            let setting = (target(parameter), value.value.clone());
            apply_settings(scenario, std::slice::from_ref(&setting))
                .map_err(|error| wrong(error.to_string(), None))?;
        }
    }
    if fits || value.used {
        return Ok(());
    }
    let help =
        nearest(&value.name, known.iter().map(String::as_str)).map(|near| format!("did you mean `{near}`?"));
    Err(wrong(format!("no vehicle of {file} has a parameter `{}`", value.name), help))
}

/// Everything about the vehicles of a scenario that is said in it and may be tested.
fn tested_parts(scenario: &Scenario) -> Vec<(String, Part, Declaration)> {
    let mut parts = Vec::new();
    for car in &scenario.vehicles {
        let found = [
            (Part::Controller, car.controller.first.declaration()),
            (Part::Dynamics, car.dynamics.as_ref().and_then(|model| model.first.declaration())),
            (Part::Sees, car.sees.as_ref().and_then(|model| model.first.declaration())),
        ];
        let found = found.into_iter().filter_map(|(part, declaration)| Some((part, declaration?.clone())));
        parts.extend(found.map(|(part, declaration)| (car.name.clone(), part, declaration)));
    }
    parts
}

/// Whether it has such a parameter, or its family of presets is called so.
fn takes(declaration: &Declaration, name: &str) -> bool {
    declaration.parameter(name).is_some()
        || declaration.presets.as_ref().is_some_and(|family| family.word == name)
}

fn check(declaration: &Declaration, value: &NamedValue) -> Result<(), String> {
    if let Some(ParameterKind::Number { dimension, .. }) =
        declaration.parameter(&value.name).map(|parameter| &parameter.kind)
        && let Some(found) = value.dimension
        && found != *dimension
    {
        let (wanted, found) = (dimension.name(), found.name());
        return Err(format!("`{}` of `{}` is a {wanted}, not a {found}", value.name, declaration.name));
    }
    let mut settings = Settings::default();
    settings.set(value.name.clone(), Value::clone(&value.value));
    declaration.resolve(&settings).map(|_| ()).map_err(|error| error.to_string())
}
