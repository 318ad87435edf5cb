//! A registry for people: what models, controllers, dynamics and metrics there are.

use std::fmt::Write;
use std::sync::Arc;

use super::format::with_unit;
use files::escape::terminal;
use scenario::registry::Registry;
use scenario::{ControllerModel, Declaration, Dimension, Metric, MetricKind, Parameter, ParameterKind};

/// One line each.
pub fn render_models(registry: &Registry) -> String {
    let mut text = String::new();
    for (kind, declarations) in registry.declarations() {
        let width = declarations.iter().map(|one| one.name.len()).max().unwrap_or(0);
        writeln!(text, "{kind}").expect("writing to a string cannot fail");
        for one in declarations {
            writeln!(text, "  {:<width$}  {}", one.name, one.summary)
                .expect("writing to a string cannot fail");
        }
        text.push('\n');
    }
    text.push_str("`scenario-runner models NAME` shows parameters, units, ranges and sources.\n");
    text
}

/// All about one registered thing; `None` if nothing has that name.
pub fn render_model(name: &str, registry: &Registry) -> Option<String> {
    let found: Vec<String> = registry
        .declarations()
        .into_iter()
        .flat_map(|(kind, declarations)| declarations.into_iter().map(move |one| (kind, one)))
        .filter(|(_, one)| one.name == name)
        .map(|(kind, one)| render_declaration(kind, one) + &render_range(registry.metrics().get(&one.name)))
        .collect();
    (!found.is_empty()).then(|| found.join("\n"))
}

/// Where a controller that is a program is declared, and what would run; empty for what ships.
pub fn render_declared(model: &ControllerModel) -> String {
    let Some(program) = &model.program else { return String::new() };
    let place = format!("{}:{}", program.file, program.origin.line);
    terminal(&format!("{} is declared in {place} and runs {}\n", program.name, program.typed()))
}

/// Between what limits a metric lies; nothing for anything else.
fn render_range(metric: Option<&Arc<Metric>>) -> String {
    let Some(metric) = metric else { return String::new() };
    match (metric.range.in_words(), &metric.kind) {
        (Some(range), _) => format!("\n  range: {range}\n"),
        (None, MetricKind::Quantity(_)) => {
            "\n  range: not limited, so that bounds on its mean are approximate\n".to_string()
        }
        (None, _) => String::new(),
    }
}

fn render_declaration(kind: &str, one: &Declaration) -> String {
    let mut text = String::new();
    let mut line = |content: &str| {
        text.push_str(content.trim_end());
        text.push('\n');
    };
    line(&format!("{} ({})", one.name, kind.trim_end_matches('s')));
    line(&format!("  {}", one.summary));
    line(&format!("  source: {}", one.source));
    if let Some(family) = &one.presets {
        line("");
        line(&format!("  {}: (default {})", family.word, family.default));
        for preset in &family.presets {
            line(&format!("    {:<14} {}", preset.name, preset.doc));
        }
    }
    if !one.parameters.is_empty() {
        line("");
        line("  parameters");
    }
    for parameter in &one.parameters {
        line(&format!("    {:<28} {}", parameter.name, parameter.doc));
        line(&format!("    {:<28} {}; {}", "", value(parameter), parameter.source));
        if let ParameterKind::Choice { options, .. } = &parameter.kind {
            for option in options {
                line(&format!("    {:<28}   {}: {}", "", option.name, option.doc));
            }
        }
    }
    text
}

/// Default and range, such as `5 m (0 m .. 50 m)`.
fn value(parameter: &Parameter) -> String {
    match &parameter.kind {
        ParameterKind::Number { dimension, default, range: (low, high) } => {
            let default =
                default.map_or_else(|| "not set".to_string(), |number| with_unit(number, *dimension));
            format!("{default} ({} .. {})", with_unit(*low, *dimension), with_unit(*high, *dimension))
        }
        ParameterKind::Whole { default, range: (low, high) } => {
            let show = |number: i64| with_unit(number as f64, Dimension::NUMBER);
            format!("{} ({} .. {})", show(*default), show(*low), show(*high))
        }
        ParameterKind::Flag { default } => format!("{default} (true or false)"),
        ParameterKind::Choice { default, .. } => format!("{default} (one of)"),
        ParameterKind::Text { default, .. } if default.is_empty() => "not set (text)".to_string(),
        ParameterKind::Text { default, .. } => default.to_string(),
        ParameterKind::Pedestrian => "not set (a pedestrian)".to_string(),
    }
}
