//! The words of a text by what they are, for editors that colour by meaning.

use std::path::Path;

use super::source::Span;
use super::symbols::{SymbolKind, Symbols};
use super::syntax::ast::{self, View};
use super::syntax::{Node, TokenKind};
use super::texts::Texts;
use files::{Files, Overlay};
use scenario::registry::Registry;

/// What a piece of text is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TokenColour {
    /// A word of the language.
    Keyword,
    /// Behind `#`.
    Comment,
    /// In quotes, and tags.
    Text,
    /// Digits.
    Number,
    /// Of a number.
    Unit,
    /// What is set between braces, and signals of programs.
    Setting,
    /// A model, controller or metric that ships, and other words that stand for a choice.
    Choice,
    /// What a file gives a name to.
    Named(SymbolKind),
}

/// A piece of a text with what it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ColouredToken {
    /// Of the first byte.
    pub start: usize,
    /// Behind the last byte.
    pub end: usize,
    /// What it is.
    pub colour: TokenColour,
    /// Whether the name is given here.
    pub defines: bool,
}

/// The pieces of a text that mean something, in order and without overlap; those that cannot be read are left out. `text` stands
/// for the file at `path`.
pub fn coloured(path: &Path, text: &str, registry: &Registry, texts: &dyn Files) -> Vec<ColouredToken> {
    let texts = Overlay::new(texts, path, text);
    let mut files = Texts::new(registry, &texts).while_edited();
    let Some(file) = files.open(path, None, &mut Vec::new()) else { return Vec::new() };
    let source = files.tree(file).source;
    if files.sources.resolve(Span::beginning(source)).source != source {
        return Vec::new();
    }
    let symbols = Symbols::of(&mut files);
    let tree = files.tree(file);
    let mut places = places(tree.root());
    for one in symbols.occurrences.iter().filter(|one| one.span.source == source) {
        let named = (one.span.start, one.span.end, Some(TokenColour::Named(one.kind)), one.defines);
        match places.binary_search_by_key(&named.0, |place| place.0) {
            Ok(at) => places[at] = named,
            Err(at) => places.insert(at, named),
        }
    }
    let mut next = 0;
    let mut found = Vec::new();
    for token in tree.tokens() {
        while places.get(next).is_some_and(|place| place.1 <= token.start) {
            next += 1;
        }
        let inside = places.get(next).filter(|place| place.0 <= token.start && token.end <= place.1);
        let colour = match (token.kind, inside) {
            (TokenKind::Comment, _) => Some(TokenColour::Comment),
            (_, Some(place)) => place.2,
            (TokenKind::String, _) => Some(TokenColour::Text),
            (TokenKind::Number, _) => Some(TokenColour::Number),
            (TokenKind::Word, _) => Some(TokenColour::Keyword),
            _ => None,
        };
        let defines = inside.is_some_and(|place| place.3);
        found.extend(colour.map(|colour| ColouredToken {
            start: token.start,
            end: token.end,
            colour,
            defines,
        }));
    }
    found
}

type PlaceOfWord = (usize, usize, Option<TokenColour>, bool);

/// The words that are none of the language, and what cannot be read, by place.
fn places(root: Node) -> Vec<PlaceOfWord> {
    let mut found = Vec::new();
    let mut after = 0;
    for node in root.descendants() {
        let span = node.span();
        if span.start < after {
            continue;
        }
        let colour = match ast::Word::cast(node) {
            Some(ast::Word::Unit(_)) => Some(TokenColour::Unit),
            Some(ast::Word::SettingName(_) | ast::Word::Signal(_)) => Some(TokenColour::Setting),
            Some(ast::Word::Name(_) | ast::Word::Reference(_)) => Some(TokenColour::Choice),
            None if ast::Tag::cast(node).is_some() => Some(TokenColour::Text),
            None if node.is_bad() => None,
            None if ast::DistributionName::cast(node).is_some() => Some(TokenColour::Choice),
            None if ast::Quantity::cast(node).is_some() || ast::Number::cast(node).is_some() => {
                if ast::Number::cast(node).is_some() {
                    found.push((span.start, span.end, Some(TokenColour::Number), false));
                    after = span.end;
                }
                continue;
            }
            None => continue,
        };
        found.push((span.start, span.end, colour, false));
        after = span.end;
    }
    found
}
