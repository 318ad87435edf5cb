//! Quick fixes, as the protocol has them.

use std::path::Path;

use lsp_types::{CodeActionParams, NumberOrString};
use serde_json::{Value, json};

use super::document::offset_of;
use super::names::range_in;
use files::Files;
use scenario::registry::Registry;

/// What can be done about the findings that an editor shows at a place.
pub fn code_actions(
    path: &Path,
    text: &str,
    parameters: &CodeActionParams,
    registry: &Registry,
    files: &dyn Files,
) -> Vec<Value> {
    let shown = &parameters.context.diagnostics;
    let only = parameters.context.only.as_deref();
    let wanted = only.is_none_or(|kinds| kinds.iter().any(|kind| "quickfix".starts_with(kind.as_str())));
    // Editors ask at every move of the cursor.
    if shown.is_empty() || !wanted {
        return Vec::new();
    }
    let touching = offset_of(text, parameters.range.start)..offset_of(text, parameters.range.end);
    let action = |fix: lang::Fix| {
        let at = range_in(text, &fix.at);
        let code = Some(NumberOrString::String(fix.code.name().to_string()));
        let about: Vec<_> = shown.iter().filter(|one| one.code == code && one.range == at).collect();
        let edit = json!({ "range": range_in(text, &fix.range), "newText": fix.text });
        let mut changes = serde_json::Map::new();
        changes.insert(parameters.text_document.uri.as_str().to_string(), json!([edit]));
        json!({ "title": fix.title, "kind": "quickfix", "diagnostics": about, "edit": { "changes": changes } })
    };
    lang::fixes(path, text, touching, registry, files).into_iter().map(action).collect()
}
