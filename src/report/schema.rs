//! Whether a JSON value is what a JSON Schema says: for the tests of the published schemas.

use serde_json::{Map, Value};

/// Every way in which `value` is not what `schema` says. A keyword that is not understood counts as one.
pub fn violations(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(schema, schema, value, "$", &mut found);
    found
}

fn check(root: &Value, schema: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
    let Value::Object(keywords) = schema else {
        return found.push(format!("{place}: the schema is not an object"));
    };
    let mut say = |wrong: bool, what: String| {
        if wrong {
            found.push(format!("{place}: {what}"));
        }
    };
    for (keyword, rule) in keywords {
        match keyword.as_str() {
            "$schema"
            | "$defs"
            | "title"
            | "description"
            | "properties"
            | "additionalProperties"
            | "items" => {}
            "$ref" => say(target(root, rule).is_none(), format!("{rule} leads nowhere")),
            "const" => say(value != rule, format!("{value} is not {rule}")),
            "enum" => say(
                !rule.as_array().is_some_and(|all| all.contains(value)),
                format!("{value} is not one of {rule}"),
            ),
            "type" => say(!of_type(rule, value), format!("{value} is not of type {rule}")),
            "required" => {
                for name in rule.as_array().into_iter().flatten().filter_map(Value::as_str) {
                    let missing = value.as_object().is_some_and(|fields| !fields.contains_key(name));
                    say(missing, format!("`{name}` is missing"));
                }
            }
            "minimum" => say(
                value.as_f64().zip(rule.as_f64()).is_some_and(|(value, least)| value < least),
                format!("{value} is below {rule}"),
            ),
            "maximum" => say(
                value.as_f64().zip(rule.as_f64()).is_some_and(|(value, most)| value > most),
                format!("{value} is above {rule}"),
            ),
            "minItems" | "maxItems" => {
                say(beyond(keyword, value.as_array().map(Vec::len), rule), "length".into())
            }
            "minLength" | "maxLength" => {
                let length = value.as_str().map(|text| text.chars().count());
                say(beyond(keyword, length, rule), "length".into());
            }
            other => say(true, format!("the keyword `{other}` is not understood")),
        }
    }
    if let Some(inner) = keywords.get("$ref").and_then(|rule| target(root, rule)) {
        check(root, inner, value, place, found);
    }
    if let (Some(items), Value::Array(list)) = (keywords.get("items"), value) {
        for (index, item) in list.iter().enumerate() {
            check(root, items, item, &format!("{place}[{index}]"), found);
        }
    }
    if let Value::Object(fields) = value {
        check_fields(root, keywords, fields, place, found);
    }
}

fn check_fields(
    root: &Value,
    keywords: &Map<String, Value>,
    fields: &Map<String, Value>,
    place: &str,
    found: &mut Vec<String>,
) {
    for (name, field) in fields {
        let place = format!("{place}.{name}");
        let known = keywords.get("properties").and_then(|properties| properties.get(name));
        match (known, keywords.get("additionalProperties")) {
            (Some(schema), _) => check(root, schema, field, &place, found),
            (None, Some(Value::Bool(false))) => found.push(format!("{place}: nobody expects it")),
            (None, Some(schema @ Value::Object(_))) => check(root, schema, field, &place, found),
            (None, _) => {}
        }
    }
}

fn target<'a>(root: &'a Value, reference: &Value) -> Option<&'a Value> {
    root.pointer(reference.as_str()?.strip_prefix('#')?)
}

fn of_type(rule: &Value, value: &Value) -> bool {
    let is = |name: &str| match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        _ => false,
    };
    match rule {
        Value::String(name) => is(name),
        Value::Array(names) => names.iter().filter_map(Value::as_str).any(is),
        _ => false,
    }
}

/// Whether a length is beyond the bound of a keyword that begins with `min` or `max`.
fn beyond(keyword: &str, length: Option<usize>, rule: &Value) -> bool {
    let Some((length, bound)) = length.zip(rule.as_u64()) else { return false };
    if keyword.starts_with("min") { (length as u64) < bound } else { length as u64 > bound }
}
