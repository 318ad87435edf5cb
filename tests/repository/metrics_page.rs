//! `docs/metrics.md` is what the registry says. `SNAPSHOTS=overwrite cargo test --test repository metrics_page` rewrites it.

use std::fmt::Write;

use models::standard;
use scenario::{Absence, Dimension, Metric, MetricKind, Scope, Worst};
use scenario::{Parameter, ParameterKind};

const INTRODUCTION: &str = "\
# Metrics

Every metric is read off the exact state of a run while it happens, not off a recorded trace. Events inside a simulation
step are interpolated linearly. A run that ends on collision is measured up to the moment of contact.

The **conflict point** of a pair is where the centre line of the vehicle's lane and the pedestrian's actual path cross.
The **strip** is what the vehicle's footprint sweeps along its lane. Where a scenario has several pairs, the worst value
counts for the run; a criterion may name one pair instead.

A metric that does not exist in a run (nobody crossed, nobody collided) is **undefined**: reports show \u{2013}. Where it says
below that this is better or worse than any value, criteria take it so; else such a run speaks against them. `undefined passes`
and `undefined fails` say it otherwise. A run that the horizon ends before a metric is decided counts as the worst that could
still have come.

That a criterion cannot fail (W0936) is told by the parameters of its metric, the horizon and the fastest that a road user may
be, not by how hard a vehicle brakes, since dynamics need not limit what a controller commands: of a threshold of 100 m/s^2, which
no real car reaches, nothing is said.

This page is generated from the registry in `src/models/metrics/`.
";

#[test]
fn the_page_says_what_the_registry_says() {
    let mut page = INTRODUCTION.to_string();
    for metric in standard().metrics() {
        page.push_str(&section(metric));
    }
    let assert = snapbox::Assert::new().action_env(snapbox::assert::DEFAULT_ACTION_ENV);
    assert.eq(page, snapbox::Data::read_from("docs/metrics.md".as_ref(), None).raw());
}

fn section(metric: &Metric) -> String {
    let declaration = &metric.declaration;
    let value = match &metric.kind {
        MetricKind::Flag => "yes or no".to_string(),
        MetricKind::Category(words) => format!("one of {}", words.join(", ")),
        MetricKind::Quantity(Dimension::NUMBER) => Dimension::NUMBER.name().to_string(),
        MetricKind::Quantity(dimension) => format!("{} in {}", dimension.name(), dimension.si_unit()),
    };
    let scope = match metric.scope {
        Scope::Pair => "per vehicle and pedestrian",
        Scope::Stream => "per stream and pedestrian",
        Scope::Contact => "per vehicle and anything that it may touch",
        Scope::Vehicles => "per vehicle and another vehicle",
        Scope::Vehicle => "per vehicle",
        Scope::Pedestrian => "per pedestrian",
    };
    let worst = match (&metric.kind, metric.worst) {
        (MetricKind::Quantity(_), Worst::Smallest) => "the smallest counts",
        (MetricKind::Quantity(_), Worst::Largest) => "the largest counts",
        (_, Worst::Neither) => "none is worse, and the largest is named",
        (MetricKind::Flag, Worst::Smallest) => "one no counts",
        (MetricKind::Flag, Worst::Largest) => "one yes counts",
        (MetricKind::Category(_), Worst::Smallest) => "the first of these counts",
        (MetricKind::Category(_), Worst::Largest) => "the last of these counts",
    };
    let mut text = format!("\n## `{}`\n\n{}\n\n", declaration.name, declaration.summary);
    writeln!(text, "- Value: {value}, {scope}; {worst}").unwrap();
    match metric.absence {
        Absence::Good => text.push_str("- Undefined: better than any value\n"),
        Absence::Bad => text.push_str("- Undefined: worse than any value\n"),
        Absence::Open => {}
    }
    match (metric.range.in_words(), &metric.kind) {
        (Some(range), _) => writeln!(text, "- Range: {range}").unwrap(),
        (None, MetricKind::Quantity(_)) => {
            text.push_str("- Range: not limited, so that bounds on its mean are approximate\n")
        }
        (None, _) => {}
    }
    writeln!(text, "- Source: {}", declaration.source).unwrap();
    if !declaration.parameters.is_empty() {
        text.push_str("\n| parameter | default | range | meaning | source |\n|---|---|---|---|---|\n");
    }
    for parameter in &declaration.parameters {
        let (default, range) = default_and_range(parameter);
        let Parameter { name, doc, source, .. } = parameter;
        writeln!(text, "| `{name}` | {default} | {range} | {doc} | {source} |").unwrap();
    }
    text
}

fn default_and_range(parameter: &Parameter) -> (String, String) {
    match &parameter.kind {
        ParameterKind::Number { dimension, default, range: (low, high) } => {
            let unit = dimension.si_unit();
            let default = default.map_or("\u{2013}".to_string(), |number| format!("{number} {unit}"));
            (default, format!("{low} .. {high} {unit}"))
        }
        ParameterKind::Whole { default, range: (low, high) } => {
            (default.to_string(), format!("{low} .. {high}"))
        }
        ParameterKind::Flag { default } => (default.to_string(), "true, false".to_string()),
        ParameterKind::Choice { default, options } => {
            let options: Vec<_> =
                options.iter().map(|option| format!("{} ({})", option.name, option.doc)).collect();
            (default.to_string(), options.join(", "))
        }
        ParameterKind::Text { default, .. } => (default.to_string(), "text".to_string()),
        ParameterKind::Pedestrian => (String::new(), "name of a pedestrian".to_string()),
    }
}
