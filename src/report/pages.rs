//! A registry as Markdown: the generated part of every page in `docs/models/`.

use std::fmt::Write;

use super::format::with_unit;
use scenario::registry::Registry;
use scenario::{
    Attention, ControllerModel, Declaration, Dimension, LookEffect, LooksAt, Parameter, ParameterKind,
    PedestrianModel, PresetFamily, Settings, SignalConduct, Value,
};

/// A page about one registered model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelPage {
    /// `pedestrian`, `controller`, `dynamics` or `perception`.
    pub kind: &'static str,
    /// As scenarios call the model.
    pub name: String,
    /// One line.
    pub summary: String,
    /// Everything that the registry knows of it, as Markdown.
    pub reference: String,
}

impl ModelPage {
    fn new(kind: &'static str, declaration: &Declaration, facts: &[String]) -> Self {
        let reference = reference(declaration, facts);
        let (name, summary) = (declaration.name.to_string(), declaration.summary.to_string());
        Self { kind, name, summary, reference }
    }

    /// Without folder, such as `controller-carla_behavior.md`.
    pub fn file_name(&self) -> String {
        format!("{}-{}.md", self.kind, self.name)
    }
}

/// One page for every pedestrian model, controller, vehicle dynamics, and perception, in the registry's order.
pub fn model_pages(registry: &Registry) -> Vec<ModelPage> {
    let pedestrians = registry.pedestrians().iter().map(|model| {
        let people =
            model.takes_individuals.then(|| "Parameter sets may come from a population.".to_string());
        let facts: Vec<_> = people.into_iter().chain([signals(model.signals), look(model)]).collect();
        ModelPage::new("pedestrian", &model.declaration, &facts)
    });
    let controllers = registry.controllers().iter().map(|model| {
        let dynamics = format!("Drives `{}` unless told otherwise.", model.default_dynamics);
        ModelPage::new(
            "controller",
            &model.declaration,
            &[dynamics, signals(model.signals), attention(model)],
        )
    });
    let dynamics = registry.dynamics().iter().map(|model| {
        let (length, width) = model.size;
        let size = format!(
            "Length {}, width {} unless told otherwise.",
            with_unit(length, Dimension::LENGTH),
            with_unit(width, Dimension::LENGTH)
        );
        ModelPage::new("dynamics", &model.declaration, &[size])
    });
    let perception = ModelPage::new("perception", &registry.perception().declaration, &[]);
    pedestrians.chain(controllers).chain(dynamics).chain([perception]).collect()
}

fn signals(conduct: SignalConduct) -> String {
    let does = match conduct {
        SignalConduct::Obeys => "obeys it, unless a scenario says `ignores signals`",
        SignalConduct::Ignores => "ignores it, unless a scenario says `obeys signals`",
        SignalConduct::Never { .. } => "looks at no signal and cannot be told to obey it",
        SignalConduct::Own => "is told what it shows and decides by itself",
    };
    format!("At a crossing with a signal it {does}.")
}

fn attention(model: &ControllerModel) -> String {
    let looks_at = match model.attention {
        Attention::Scripted => return "It looks at nothing on the road.".to_string(),
        Attention::Own => return "It gets everything on the road and decides by itself.".to_string(),
        Attention::Reacts(looks_at) => {
            model.declaration.resolve(&Settings::default()).map(|settings| looks_at(&settings))
        }
    };
    let Ok(LooksAt { people_crossing, people_along, vehicles_ahead, other_roads }) = looks_at else {
        return "What it looks at depends on its settings.".to_string();
    };
    let all = [
        (people_crossing, "people who cross its lane"),
        (people_along, "people who move along it"),
        (vehicles_ahead, "vehicles ahead in it"),
        (other_roads, "vehicles of other roads"),
    ];
    let those = |wanted: bool| {
        let names: Vec<&str> =
            all.iter().filter(|(looks, _)| *looks == wanted).map(|(_, name)| *name).collect();
        names.join(", ")
    };
    format!("With its defaults it looks at: {}; not at: {}.", those(true), those(false))
}

/// What a look before it may go makes of a pedestrian.
fn look(model: &PedestrianModel) -> String {
    let fixed = model.declaration.resolve(&Settings::default()).map(|defaults| (model.is_fixed)(&defaults));
    let said = match (model.look, fixed) {
        (LookEffect::Counts, _) => {
            "With `looks for` what it sees before it may go counts: it perceives and believes meanwhile."
        }
        (LookEffect::Delays, Ok(false)) => {
            "It decides by what is there at the moment: what it sees during `looks for` changes nothing, it only goes later."
        }
        (LookEffect::Delays, _) => {
            "Where it walks the same whatever it sees it refuses `looks for`, and takes `may go`, with which it stands in sight before."
        }
    };
    said.to_string()
}

fn reference(one: &Declaration, facts: &[String]) -> String {
    let mut text = format!("{}\n\nSource: {}.\n", one.summary, one.source.trim_end_matches('.'));
    for fact in facts {
        write!(text, "\n{fact}\n").expect("writing to a string cannot fail");
    }
    if let Some(family) = &one.presets {
        text.push_str(&presets(one, family));
    }
    if !one.parameters.is_empty() {
        text.push_str(
            "\n### Parameters\n\n| name | default | range | meaning | source |\n|---|---|---|---|---|\n",
        );
    }
    for parameter in &one.parameters {
        let (default, range) = default_and_range(parameter);
        let cells = [
            format!("`{}`", parameter.name),
            default,
            range,
            parameter.doc.to_string(),
            parameter.source.to_string(),
        ];
        text.push_str(&row(&cells));
    }
    for parameter in &one.parameters {
        if let ParameterKind::Choice { options, .. } = &parameter.kind {
            write!(text, "\n`{}`\n\n", parameter.name).expect("writing to a string cannot fail");
            for option in options {
                writeln!(text, "- `{}`: {}", option.name, option.doc)
                    .expect("writing to a string cannot fail");
            }
        }
    }
    text
}

fn presets(one: &Declaration, family: &PresetFamily) -> String {
    let mut text = format!(
        "\n### Presets: `{}` (default `{}`)\n\n| name | meaning | values |\n|---|---|---|\n",
        family.word, family.default
    );
    for preset in &family.presets {
        let values: Vec<_> = preset
            .values
            .iter()
            .map(|(name, value)| format!("`{name}` {}", literal(one.parameter(name), value)))
            .collect();
        let values = if values.is_empty() { "the defaults below".to_string() } else { values.join(", ") };
        text.push_str(&row(&[format!("`{}`", preset.name), preset.doc.to_string(), values]));
    }
    text
}

fn literal(parameter: Option<&Parameter>, value: &Value) -> String {
    match (value, parameter.map(|parameter| &parameter.kind)) {
        (Value::Number(number), Some(ParameterKind::Number { dimension, .. })) => {
            with_unit(*number, *dimension)
        }
        (Value::Number(number), _) => with_unit(*number, Dimension::NUMBER),
        (Value::Flag(flag), _) => flag.to_string(),
        (Value::Word(word), _) => word.to_string(),
    }
}

fn default_and_range(parameter: &Parameter) -> (String, String) {
    let between = |low: String, high: String| format!("{low} .. {high}");
    match &parameter.kind {
        ParameterKind::Number { dimension, default, range: (low, high) } => {
            let show = |number| with_unit(number, *dimension);
            (default.map_or_else(|| "not set".to_string(), show), between(show(*low), show(*high)))
        }
        ParameterKind::Whole { default, range: (low, high) } => {
            (default.to_string(), between(low.to_string(), high.to_string()))
        }
        ParameterKind::Flag { default } => (default.to_string(), "true, false".to_string()),
        ParameterKind::Choice { default, options } => {
            let names: Vec<_> = options.iter().map(|option| format!("`{}`", option.name)).collect();
            (format!("`{default}`"), names.join(", "))
        }
        ParameterKind::Text { default, .. } if default.is_empty() => {
            ("not set".to_string(), "text".to_string())
        }
        ParameterKind::Text { default, .. } => (format!("`{default}`"), "text".to_string()),
        ParameterKind::Pedestrian => ("not set".to_string(), "name of a pedestrian".to_string()),
    }
}

fn row(cells: &[String]) -> String {
    let escaped: Vec<_> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    format!("| {} |\n", escaped.join(" | "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::standard;

    #[test]
    fn a_page_has_all_that_is_declared() {
        let pages = model_pages(&standard());
        let page = pages.iter().find(|page| page.name == "delay_lag").unwrap();
        assert_eq!(page.file_name(), "dynamics-delay_lag.md");
        insta::assert_snapshot!(page.reference);
    }

    #[test]
    fn file_names_are_unique() {
        let mut names: Vec<_> = model_pages(&standard()).iter().map(ModelPage::file_name).collect();
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
