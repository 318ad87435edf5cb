//! The JSON Schema of the YAML form, for editors: made from the keys and a registry.

use serde_json::{Map, Value, json};

use crate::declared::{choices, named};
use crate::syntax::words::{BlockEntry, BlockKind, StatementEntry, YamlShape};
use scenario::registry::Registry;
use scenario::{Declaration, Parameter, ParameterKind};

/// A schema of draft 2020-12 for scenario files and suites in YAML.
pub fn schema(registry: &Registry) -> Value {
    let definitions: Map<String, Value> =
        blocks().map(|known| (known.word(), block(known, registry))).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Scenario files and suites of scenario-runner",
        "$ref": "#/$defs/file",
        "$defs": definitions,
    })
}

/// Those with keys.
fn blocks() -> impl Iterator<Item = &'static BlockEntry> {
    BlockKind::ALL.into_iter().map(BlockKind::block).filter(|block| block.keys().next().is_some())
}

/// To the block that a statement opens.
fn reference(statement: &StatementEntry) -> Value {
    let block = statement.opens.map(|kind| kind.block().word()).unwrap_or_default();
    json!({ "$ref": format!("#/$defs/{block}") })
}

fn block(block: &BlockEntry, registry: &Registry) -> Value {
    let properties: Map<String, Value> =
        block.keys().map(|statement| (statement.key.to_string(), described(statement, registry))).collect();
    json!({ "type": "object", "additionalProperties": false, "properties": properties })
}

fn described(statement: &StatementEntry, registry: &Registry) -> Value {
    let mut value = value(statement, registry);
    value["description"] = statement.doc.into();
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

fn value(statement: &StatementEntry, registry: &Registry) -> Value {
    match statement.shape {
        YamlShape::Words | YamlShape::Lines | YamlShape::Commas => one_or_several(&words()),
        YamlShape::Text => one_or_several(&json!({ "type": "string" })),
        YamlShape::Table => one_or_several(&json!({
            "anyOf": [
                { "type": "string" },
                {
                    "type": "object",
                    "properties": {
                        "file": { "type": "string" },
                        "without": one_or_several(&json!({ "type": "string" })),
                    },
                    "required": ["file", "without"],
                    "additionalProperties": false,
                },
            ],
        })),
        YamlShape::Named => mapping_of(&json!({ "anyOf": [reference(statement), { "type": "null" }] })),
        YamlShape::NameOrBlock => json!({ "anyOf": [{ "type": "string" }, reference(statement)] }),
        YamlShape::Statements if statement.opens == Some(BlockKind::Path) => {
            let turn = json!({
                "type": "object",
                "properties": {
                    "turn left": named("turn", "", registry).map(|turn| settings(&turn)),
                    "turn right": named("turn", "", registry).map(|turn| settings(&turn)),
                },
                "additionalProperties": false,
                "minProperties": 1,
                "maxProperties": 1,
            });
            list_of(&json!({ "anyOf": [{ "type": "string" }, turn] }))
        }
        YamlShape::Statements => list_of(&json!({ "type": "string" })),
        YamlShape::Model => model(statement.word(), registry),
        YamlShape::Tested => mapping_of(&model(statement.word(), registry)),
        YamlShape::NamedModels => mapping_of(&model(statement.word(), registry)),
        YamlShape::NamedSettings => mapping_of(&own_settings(statement, registry)),
        YamlShape::Settings => own_settings(statement, registry),
        YamlShape::Values => mapping_of(&one_or_several(&words())),
        YamlShape::Drawn => mapping_of(&json!({
            "anyOf": [
                { "type": "string" },
                {
                    "type": "object",
                    "properties": { "file": { "type": "string" } },
                    "required": ["file"],
                    "additionalProperties": false,
                },
            ],
        })),
        YamlShape::Together => one_or_several(&mapping_of(&one_or_several(&words()))),
        YamlShape::Bindings => mapping_of(&words()),
        YamlShape::Flag | YamlShape::NotFlag => json!({ "type": "boolean" }),
        YamlShape::Cases => json!({
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
        YamlShape::Conditions => one_or_several(&json!({
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
        YamlShape::ParameterSets => one_or_several(&mapping_of(&words())),
        YamlShape::Rows => mapping_of(&one_or_several(&words())),
        YamlShape::Parameters => mapping_of(&json!({ "type": ["string", "number", "boolean", "null"] })),
        YamlShape::Weights => one_or_several(&mapping_of(&words())),
        YamlShape::Texts => one_or_several(&json!({ "type": "string" })),
        YamlShape::OwnParameters => mapping_of(&json!({
            "anyOf": [
                words(),
                {
                    "type": "object",
                    "properties": {
                        "default": words(),
                        "text": { "type": "string" },
                        "in": one_or_several(&words()),
                        "as": { "type": "string" },
                        "unit": { "type": "string" },
                        "doc": { "type": "string" },
                    },
                    "additionalProperties": false,
                },
            ],
        })),
        YamlShape::GroupSize => json!({ "type": "integer", "minimum": 1 }),
        YamlShape::Base => json!({ "type": "string" }),
    }
}

/// A registered name, or that name with its settings.
fn model(keyword: &str, registry: &Registry) -> Value {
    let declarations = choices(keyword, registry);
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

/// Of a statement that names nothing registered.
fn own_settings(statement: &StatementEntry, registry: &Registry) -> Value {
    named(statement.word(), "", registry).map_or(Value::Null, |declaration| settings(&declaration))
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
