//! What a registry refuses, beside what ships.

use models::standard;
use scenario_runner_scenario::agent::ModelError;
use scenario_runner_scenario::registry::{Registry, RegistryError};
use scenario_runner_scenario::{
    CommandKind, ControllerModel, Declaration, Dimension, Parameter, Preset, PresetFamily, Value,
};

fn with(declaration: Declaration) -> Result<Registry, RegistryError> {
    standard().with_controller(model(declaration))
}

fn model(declaration: Declaration) -> ControllerModel {
    ControllerModel::new(declaration, CommandKind::Acceleration, |_| Err(ModelError::new("never built")))
}

#[test]
fn what_scenarios_cannot_speak_of_is_refused() {
    let own = |name: &'static str| Declaration::new(name, "");
    assert!(with(own("own")).is_ok());
    for name in ["", "1st", "my-own", "when", "straße"] {
        assert!(matches!(with(own(name)), Err(RegistryError::BadName { .. })), "{name}");
    }
    assert!(matches!(with(own("idm_aeb")), Err(RegistryError::Duplicate { .. })));
    let gap = |default, range| own("own").number("gap", Dimension::LENGTH, default, range, "");
    let said = |declaration| with(declaration).err().map(|error| error.to_string()).unwrap_or_default();
    assert_eq!(said(gap(9.0, (0.0, 5.0))), "`own`: the default: `gap` of `own` is 9, outside 0 .. 5 m");
    assert!(said(gap(1.0, (5.0, 0.0))).contains("is empty"));
    assert!(said(gap(1.0, (0.0, 5.0)).with(Parameter::flag("gap", true, "", ""))).contains("two parameters"));
    let preset = |name| Preset::new("wild", "", [(name, Value::Number(2.0))]);
    let family = |name| PresetFamily::new("profile", "wild", [preset(name)]);
    assert_eq!(said(gap(1.0, (0.0, 5.0)).presets(family("gap"))), "");
    assert!(said(gap(1.0, (0.0, 5.0)).presets(family("gab"))).contains("which is no parameter"));
}

#[test]
fn dynamics_that_do_not_fit_are_refused() {
    let driving = |name| standard().with_controller(model(Declaration::new("own", "")).driving(name));
    let unknown = driving("ideel").err().unwrap().to_string();
    assert!(unknown.ends_with("did you mean `ideal`?"), "{unknown}");
    let pedals = ControllerModel { gives: CommandKind::Pedals, ..model(Declaration::new("own", "")) };
    let unfit = standard().with_controller(pedals.driving("ideal"));
    assert!(matches!(unfit, Err(RegistryError::UnfitDynamics { .. })));
}
