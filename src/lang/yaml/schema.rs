//! The JSON Schema of the YAML form, for editors: made from the keys and a registry.

use serde_json::{Map, Value, json};

use super::shape::{Key, Shape, keys};
use crate::lang::check::{obstacle, signalised, unmarked, zebra};
use crate::lang::statements;
use crate::lang::tree::Rule;
use crate::registry::Registry;
use crate::scenario::{Declaration, Parameter, ParameterKind};

const BLOCKS: [Rule; 11] = [
    Rule::file,
    Rule::road_block,
    Rule::scenario_block,
    Rule::vehicle_block,
    Rule::pedestrian_block,
    Rule::suite_block,
    Rule::gate_block,
    Rule::search_block,
    Rule::tune_block,
    Rule::evaluate_block,
    Rule::statement_block,
];

/// A schema of draft 2020-12 for scenario files and suites in YAML.
pub fn schema(registry: &Registry) -> Value {
    let definitions: Map<String, Value> =
        BLOCKS.iter().map(|rule| (definition_name(*rule), block(*rule, registry))).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Scenario files and suites of scenario-runner",
        "$ref": "#/$defs/file",
        "$defs": definitions,
    })
}

fn definition_name(rule: Rule) -> String {
    format!("{rule:?}").trim_end_matches("_block").to_string()
}

fn reference(rule: Rule) -> Value {
    json!({ "$ref": format!("#/$defs/{}", definition_name(rule)) })
}

fn block(rule: Rule, registry: &Registry) -> Value {
    let properties: Map<String, Value> =
        keys(rule).iter().map(|key| (key.name.to_string(), described(key, rule, registry))).collect();
    json!({ "type": "object", "additionalProperties": false, "properties": properties })
}

fn described(key: &Key, block: Rule, registry: &Registry) -> Value {
    let mut value = value(key, registry);
    let statements = statements::block(block).statements;
    let doc = match key.rule {
        Rule::doc => Some("What it is about."),
        Rule::base => Some("The scenario or template that it builds on, with arguments: `base(delay: 2 s)`."),
        Rule::parameters => Some("The parameters of a template with their defaults."),
        rule => statements.iter().find(|statement| statement.rule == rule).map(|statement| statement.doc),
    };
    if let (Some(fields), Some(doc)) = (value.as_object_mut(), doc) {
        fields.insert("description".to_string(), doc.into());
    }
    value
}

/// Words of the language, which YAML may read as a number or truth value.
fn words() -> Value {
    json!({ "type": ["string", "number", "boolean"] })
}

fn list_of(items: &Value) -> Value {
    json!({ "type": "array", "items": items })
}

fn one_or_several(item: &Value) -> Value {
    json!({ "anyOf": [item, list_of(item)] })
}

fn mapping_of(value: &Value) -> Value {
    json!({ "type": "object", "additionalProperties": value })
}

fn value(key: &Key, registry: &Registry) -> Value {
    match key.shape {
        Shape::Words(_) | Shape::Lines(_) | Shape::Commas(_) => one_or_several(&words()),
        Shape::Text(_) => one_or_several(&json!({ "type": "string" })),
        Shape::Named(_, rule) => mapping_of(&json!({ "anyOf": [reference(rule), { "type": "null" }] })),
        Shape::NameOrBlock(_, rule) => json!({ "anyOf": [{ "type": "string" }, reference(rule)] }),
        Shape::Statements(_) => list_of(&json!({ "type": "string" })),
        Shape::Model(keyword) => model(keyword, registry),
        Shape::NamedSettings(_) => mapping_of(&settings(&obstacle())),
        Shape::Settings(_) => settings(&registry.perception().declaration),
        Shape::Values(_) => mapping_of(&one_or_several(&words())),
        Shape::Together => one_or_several(&mapping_of(&one_or_several(&words()))),
        Shape::Bindings => mapping_of(&words()),
        Shape::Flag(_) | Shape::NotFlag(_) => json!({ "type": "boolean" }),
        Shape::Cases => json!({
            "anyOf": [
                { "type": "string" },
                {
                    "type": "object",
                    "properties": { "file": { "type": "string" } },
                    "required": ["file"],
                    "additionalProperties": false,
                },
            ],
        }),
        Shape::Conditions => one_or_several(&json!({
            "anyOf": [
                { "type": "string" },
                {
                    "type": "object",
                    "properties": {
                        "file": { "type": "string" },
                        "set": mapping_of(&words()),
                        "as": { "type": "string" },
                    },
                    "required": ["as"],
                    "minProperties": 2,
                    "maxProperties": 2,
                    "additionalProperties": false,
                },
            ],
        })),
        Shape::Rows(_) => mapping_of(&one_or_several(&words())),
        Shape::Head if key.rule == Rule::parameters => {
            mapping_of(&json!({ "type": ["string", "number", "boolean", "null"] }))
        }
        Shape::Head => json!({ "type": "string" }),
    }
}

/// A registered name, or that name with its settings.
fn model(keyword: &str, registry: &Registry) -> Value {
    let crossings = [("zebra", zebra()), ("unmarked", unmarked()), ("signalised", signalised())];
    let declarations: Vec<(&str, &Declaration)> = match keyword {
        "controller" => registry.controllers().declarations().map(named).collect(),
        "dynamics" => registry.dynamics().declarations().map(named).collect(),
        "model" => registry.pedestrians().declarations().map(named).collect(),
        _ => crossings.iter().map(|(name, declaration)| (*name, declaration)).collect(),
    };
    let names: Vec<_> = declarations
        .iter()
        .map(|(name, declaration)| json!({ "const": name, "description": declaration.summary }))
        .collect();
    let properties: Map<String, Value> =
        declarations.iter().map(|(name, declaration)| (name.to_string(), settings(declaration))).collect();
    // What is no name of a registered thing is the name of a variation that chooses between them.
    let may_vary = keyword != "crossing";
    let others = if may_vary { json!({ "type": "object" }) } else { json!(false) };
    let name = if may_vary {
        json!({ "anyOf": [{ "oneOf": names }, { "type": "string", "description": "A variation over names." }] })
    } else {
        json!({ "oneOf": names })
    };
    json!({
        "anyOf": [
            name,
            {
                "type": "object",
                "properties": properties,
                "additionalProperties": others,
                "minProperties": 1,
                "maxProperties": 1,
            },
        ],
    })
}

fn named(declaration: &Declaration) -> (&str, &Declaration) {
    (&declaration.name, declaration)
}

/// Every parameter may be words, because it may be calculated from variations.
fn settings(declaration: &Declaration) -> Value {
    let mut properties: Map<String, Value> = declaration
        .parameters
        .iter()
        .map(|parameter| {
            let mut value = words();
            value["description"] = description(parameter).into();
            (parameter.name.to_string(), value)
        })
        .collect();
    if let Some(family) = &declaration.presets {
        let names: Vec<_> = family.presets.iter().map(|preset| &*preset.name).collect();
        let description = format!("Named settings: {}. Default: {}.", names.join(", "), family.default);
        properties.insert(family.word.to_string(), json!({ "type": "string", "description": description }));
    }
    json!({
        "type": "object",
        "description": declaration.summary,
        "properties": properties,
        "additionalProperties": false,
    })
}

fn description(parameter: &Parameter) -> String {
    let takes = match &parameter.kind {
        ParameterKind::Choice { options, .. } => {
            options.iter().map(|option| &*option.name).collect::<Vec<_>>().join(", ")
        }
        kind => kind.expectation(),
    };
    let default =
        parameter.default_value().map(|value| format!(" Default (SI): {value}.")).unwrap_or_default();
    format!("{} Takes {takes}.{default}", parameter.doc)
}
