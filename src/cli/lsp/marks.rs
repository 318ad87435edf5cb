//! What is shown within a text: what values come to, and colours by meaning.

use std::path::Path;

use lsp_types::Range;
use serde_json::{Value, json};

use super::document::{Positions, offset_of};
use files::Files;
use lang::{SymbolKind, TokenColour};
use scenario::registry::Registry;

/// The kinds of tokens by their numbers, in words of the protocol.
const TYPES: &[&str] = &[
    "keyword",
    "comment",
    "string",
    "number",
    "type",
    "property",
    "enumMember",
    "function",
    "struct",
    "class",
    "namespace",
    "variable",
    "parameter",
];

/// The modifiers by their bits.
const MODIFIERS: &[&str] = &["declaration", "defaultLibrary"];

pub fn legend() -> Value {
    json!({ "tokenTypes": TYPES, "tokenModifiers": MODIFIERS })
}

fn word(colour: TokenColour) -> &'static str {
    match colour {
        TokenColour::Keyword => "keyword",
        TokenColour::Comment => "comment",
        TokenColour::Text => "string",
        TokenColour::Number => "number",
        TokenColour::Unit => "type",
        TokenColour::Setting => "property",
        TokenColour::Choice => "enumMember",
        TokenColour::Named(kind) => match kind {
            SymbolKind::Scenario => "function",
            SymbolKind::Road => "struct",
            SymbolKind::Controller => "class",
            SymbolKind::Block | SymbolKind::Suite | SymbolKind::Gate | SymbolKind::Rating => "namespace",
            SymbolKind::Parameter | SymbolKind::ProgramParameter => "parameter",
            _ => "variable",
        },
    }
}

/// Five numbers a token: lines and columns from the one before, length, type and modifiers.
pub fn semantic_tokens(path: &Path, text: &str, registry: &Registry, files: &dyn Files) -> Value {
    let mut positions = Positions::new(text);
    let mut data: Vec<u32> = Vec::new();
    let (mut line, mut column) = (0, 0);
    for token in lang::coloured(path, text, registry, files) {
        let (start, end) = (positions.at(token.start), positions.at(token.end));
        if start.line != end.line {
            continue;
        }
        let word = word(token.colour);
        let Some(number) = TYPES.iter().position(|one| *one == word) else { continue };
        let modifiers = u32::from(token.defines) | u32::from(token.colour == TokenColour::Choice) << 1;
        let right = if start.line == line { start.character - column } else { start.character };
        data.extend([start.line - line, right, end.character - start.character, number as u32, modifiers]);
        (line, column) = (start.line, start.character);
    }
    json!({ "data": data })
}

pub fn inlay_hints(
    path: &Path,
    text: &str,
    range: Range,
    registry: &Registry,
    files: &dyn Files,
) -> Vec<Value> {
    let wanted = offset_of(text, range.start)..=offset_of(text, range.end);
    let mut positions = Positions::new(text);
    let hints = lang::hints(path, text, registry, files);
    let shown = hints.iter().filter(|hint| wanted.contains(&hint.at));
    shown
        .map(|hint| json!({ "position": positions.at(hint.at), "label": hint.text, "paddingLeft": true }))
        .collect()
}
