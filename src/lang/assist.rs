//! What an editor asks: what is this, what could stand here, where is it defined.
//!
//! Completion goes by tokens alone, because a text is seldom whole while it is being written.

use std::path::Path;

use super::check::{OBSTACLE, SIGNALISED, UNMARKED, ZEBRA};
use super::files::Files;
use super::lexer::{self, Token, TokenKind};
use super::source::{Sources, Span};
use super::statements;
use super::tree::{Node, Rule, Tree};
use super::units;
use crate::metrics::{METRICS, metric};
use crate::scenario::{Declaration, Parameter, ParameterKind};
use crate::{pedestrian, vehicle};

/// A word that could stand somewhere.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Proposal {
    pub word: String,
    /// One line.
    pub detail: String,
}

/// What the word at byte `offset` means, in Markdown, with the bytes it is about.
pub fn hover(tree: &Tree, offset: usize) -> Option<(Span, String)> {
    let path = path_to(tree, offset);
    let node = *path.last()?;
    let parent = path.len().checked_sub(2).map(|index| path[index]);
    let text = match (node.rule(), parent.map(Node::rule)) {
        (Rule::unit, _) => {
            let unit = units::unit_of(node.text())?;
            format!("`{}`: {}, a unit of {}", unit.symbol, unit.doc, unit.dimension.name())
        }
        (Rule::name, Some(Rule::controller | Rule::dynamics | Rule::model)) => {
            declared(&declaration_of(parent?)?)
        }
        (Rule::name, Some(Rule::metric)) => declared(&metric(node.text())?.declaration),
        (Rule::setting_name, _) => {
            let owner = path.iter().rev().find_map(|node| declaration_of(*node))?;
            match owner.parameter(node.text()) {
                Some(found) => parameter(found),
                None => {
                    let family = owner.presets.filter(|family| family.word == node.text())?;
                    let names: Vec<_> = family
                        .presets
                        .iter()
                        .map(|preset| format!("- `{}`: {}", preset.name, preset.doc))
                        .collect();
                    format!("Named settings; `{}` if not said.\n\n{}", family.default, names.join("\n"))
                }
            }
        }
        (Rule::reference | Rule::name, _) => {
            let place = local_definition(&path, node.text())?;
            let line = tree.text()[..place.start].rfind('\n').map_or(0, |at| at + 1);
            let end = tree.text()[place.end..].find('\n').map_or(tree.text().len(), |at| place.end + at);
            format!("```scn\n{}\n```", tree.text()[line..end].trim())
        }
        _ => {
            let index = path.iter().rposition(|node| !statements_of(node.rule()).is_empty())?;
            let statement = path.get(index + 1)?;
            let word = statement.text().split_whitespace().next()?;
            let known = statements_of(path[index].rule()).iter().find(|known| known.word == word)?;
            format!("{}\n\n`{}`", known.doc, known.usage)
        }
    };
    Some((node.span(), text))
}

fn statements_of(rule: Rule) -> &'static [statements::Statement] {
    statements::BLOCKS.iter().find(|block| block.rule == rule).map_or(&[], |block| block.statements)
}

/// The nodes around a byte, from the file to the innermost.
fn path_to(tree: &Tree, offset: usize) -> Vec<Node<'_>> {
    let mut path = vec![tree.root()];
    while let Some(inner) = path.last().and_then(|node| {
        node.children().find(|child| child.span().start <= offset && offset <= child.span().end)
    }) {
        path.push(inner);
    }
    path
}

/// What a statement that names something registered declares.
fn declaration_of(statement: Node) -> Option<Declaration> {
    let name = statement.child(Rule::name).map_or("", Node::text);
    match statement.rule() {
        Rule::controller => vehicle::controller(name).map(|found| found.declaration),
        Rule::dynamics => vehicle::dynamics(name).map(|found| found.declaration),
        Rule::model => pedestrian::model(name).map(|found| found.declaration),
        Rule::metric => metric(name).map(|found| found.declaration),
        Rule::sees => Some(vehicle::PERCEPTION),
        Rule::obstacle => Some(OBSTACLE),
        Rule::crossing if statement.has(Rule::kw_zebra) => Some(ZEBRA),
        Rule::crossing if statement.has(Rule::kw_unmarked) => Some(UNMARKED),
        Rule::crossing => Some(SIGNALISED),
        _ => None,
    }
}

fn declared(declaration: &Declaration) -> String {
    let mut text =
        format!("**{}** – {}\n\nSource: {}\n", declaration.name, declaration.summary, declaration.source);
    for found in declaration.parameters {
        text.push_str(&format!("\n- `{}`: {}", found.name, found.doc));
    }
    text
}

fn parameter(found: &Parameter) -> String {
    let range = match found.kind {
        ParameterKind::Number { dimension, range: (low, high), .. } => {
            format!(", {low} .. {high} {}", dimension.si_unit())
        }
        ParameterKind::Whole { range: (low, high), .. } => format!(", {low} .. {high}"),
        _ => String::new(),
    };
    let default = found.default_value().map(|value| format!("Default (SI): {value}. ")).unwrap_or_default();
    format!("{}\n\nTakes {}{range}. {default}Source: {}", found.doc, found.kind.expectation(), found.source)
}

/// The words that could stand at byte `offset` of the file at `path`, with the names that it defines or uses.
pub fn complete(path: &Path, text: &str, offset: usize) -> Vec<Proposal> {
    let before = &text[..offset.min(text.len())];
    let tokens: Vec<Token> =
        lexer::tokens(before).into_iter().filter(|token| token.kind != TokenKind::Space).collect();
    if tokens.last().is_some_and(|token| matches!(token.kind, TokenKind::Comment | TokenKind::OpenString)) {
        return Vec::new();
    }
    let word = |token: &Token| &before[token.start..token.end];
    // The first words of every statement whose braces are open here, and the current statement.
    let mut open: Vec<Vec<&str>> = Vec::new();
    let mut statement: Vec<&str> = Vec::new();
    for token in &tokens {
        match (token.kind, word(token)) {
            (TokenKind::Newline | TokenKind::Comment, _) | (_, ";") => statement.clear(),
            (_, "{") => open.push(std::mem::take(&mut statement)),
            (_, "}") => {
                open.pop();
                statement.clear();
            }
            (_, text) => statement.push(text),
        }
    }
    // The word being written is what is to be completed.
    let writing = tokens.last().filter(|token| token.kind == TokenKind::Word && token.end == before.len());
    if writing.is_some() {
        statement.pop();
    }
    let owner = open.last().map_or(&[] as &[&str], Vec::as_slice);
    if let Some(declaration) = settings_of(owner) {
        return setting(&declaration, &statement);
    }
    let block = block_of(owner);
    match statement.as_slice() {
        [] => first_words(block),
        [.., number] if number.starts_with(|c: char| c.is_ascii_digit()) => {
            units::UNITS.iter().map(|unit| proposal(unit.symbol, unit.doc)).collect()
        }
        ["controller"] => vehicle::CONTROLLERS.iter().map(|known| of(&known.declaration)).collect(),
        ["dynamics"] => vehicle::DYNAMICS.iter().map(|known| of(&known.declaration)).collect(),
        ["model"] => pedestrian::MODELS.iter().map(|known| of(&known.declaration)).collect(),
        ["crossing"] => {
            let kinds = [("zebra", ZEBRA), ("unmarked", UNMARKED), ("signalised", SIGNALISED)];
            kinds.iter().map(|(name, kind)| proposal(name, kind.summary)).collect()
        }
        ["road"] => visible(path, &without_line(text, before.len()), &[Rule::road_definition]),
        [.., ":"] if block == Rule::file => {
            visible(path, &without_line(text, before.len()), &[Rule::scenario, Rule::define])
        }
        [.., "in" | "on" | "of" | "with" | "as"] if refers(block) => {
            let blocks = [Rule::search, Rule::tune, Rule::evaluate];
            visible(path, &without_line(text, before.len()), &[&blocks[..], &[Rule::scenario]].concat())
        }
        _ if matches!(
            block,
            Rule::expect_block
                | Rule::search_block
                | Rule::tune_block
                | Rule::evaluate_block
                | Rule::statement_block
                | Rule::gate_block
        ) =>
        {
            metrics()
        }
        _ => Vec::new(),
    }
}

/// Whether a block names scenarios and other blocks.
fn refers(block: Rule) -> bool {
    matches!(block, Rule::search_block | Rule::tune_block | Rule::evaluate_block | Rule::statement_block)
}

/// A text that is being written as one that can be read: without the line at `offset`, with every brace closed.
fn without_line(text: &str, offset: usize) -> String {
    let start = text[..offset].rfind('\n').map_or(0, |at| at + 1);
    let end = text[offset..].find('\n').map_or(text.len(), |at| offset + at);
    let mut whole = format!("{}{}", &text[..start], &text[end..]);
    let tokens = lexer::tokens(&whole);
    let count = |brace: &str| tokens.iter().filter(|token| &whole[token.start..token.end] == brace).count();
    let missing = count("{").saturating_sub(count("}"));
    whole.push_str(&"\n}".repeat(missing));
    whole
}

/// The names of some kinds that a file defines or sees in files that it uses, in the order of the alphabet, with the line that
/// defines each.
fn visible(path: &Path, text: &str, kinds: &[Rule]) -> Vec<Proposal> {
    let mut files = Files::default();
    files.overlay(path, text);
    let Some(file) = files.open(path, None, &mut Vec::new()) else { return Vec::new() };
    let names = files.names(file);
    let all = names.roads.iter().chain(&names.scenarios).chain(&names.blocks);
    let mut found: Vec<Proposal> = all
        .filter(|(_, defined)| kinds.contains(&files.tree(defined.file).node(defined.node).rule()))
        .map(|(name, defined)| {
            let node = files.tree(defined.file).node(defined.node);
            let first_line = node.text().lines().next().unwrap_or_default();
            proposal(name, first_line.trim_end_matches('{').trim_end())
        })
        .collect();
    found.sort_by(|one, other| one.word.cmp(&other.word));
    found
}

fn proposal(word: &str, detail: &str) -> Proposal {
    Proposal { word: word.to_string(), detail: detail.to_string() }
}

fn of(declaration: &Declaration) -> Proposal {
    proposal(declaration.name, declaration.summary)
}

fn metrics() -> Vec<Proposal> {
    METRICS.iter().map(|known| of(&known.declaration)).collect()
}

/// The kind of block that a statement opens.
fn block_of(owner: &[&str]) -> Rule {
    match owner {
        [] => Rule::file,
        ["road", ..] => Rule::road_block,
        ["scenario" | "define", ..] => Rule::scenario_block,
        ["vehicle", ..] => Rule::vehicle_block,
        ["pedestrian", ..] => Rule::pedestrian_block,
        ["expect", ..] => Rule::expect_block,
        ["vary", ..] => Rule::together_block,
        ["suite", ..] => Rule::suite_block,
        ["gate", ..] => Rule::gate_block,
        ["search", ..] => Rule::search_block,
        ["tune", ..] => Rule::tune_block,
        ["evaluate", ..] => Rule::evaluate_block,
        ["statement", ..] => Rule::statement_block,
        _ => Rule::settings,
    }
}

fn first_words(block: Rule) -> Vec<Proposal> {
    if block == Rule::expect_block {
        return metrics();
    }
    let mut words: Vec<Proposal> = Vec::new();
    for known in statements_of(block).iter().filter(|known| !known.word.is_empty()) {
        if words.iter().all(|word| word.word != known.word) {
            words.push(proposal(known.word, known.doc));
        }
    }
    words
}

/// What the settings belong to that a statement opens.
fn settings_of(owner: &[&str]) -> Option<Declaration> {
    match owner {
        ["controller", name] => vehicle::controller(name).map(|found| found.declaration),
        ["dynamics", name] => vehicle::dynamics(name).map(|found| found.declaration),
        ["model", name] => pedestrian::model(name).map(|found| found.declaration),
        ["sees"] => Some(vehicle::PERCEPTION),
        ["box" | "parked", _] => Some(OBSTACLE),
        ["crossing", "zebra"] => Some(ZEBRA),
        ["crossing", "unmarked"] => Some(UNMARKED),
        ["crossing", "signalised"] => Some(SIGNALISED),
        _ => None,
    }
}

/// Names of parameters, or what the one before the colon takes.
fn setting(declaration: &Declaration, statement: &[&str]) -> Vec<Proposal> {
    let current = statement.rsplit(|word| *word == ",").next().unwrap_or_default();
    match current {
        [] => {
            let presets = declaration.presets.map(|family| proposal(family.word, "Named settings."));
            declaration
                .parameters
                .iter()
                .map(|found| proposal(found.name, found.doc))
                .chain(presets)
                .collect()
        }
        [name, ":"] => {
            if let Some(family) = declaration.presets.filter(|family| family.word == *name) {
                return family.presets.iter().map(|preset| proposal(preset.name, preset.doc)).collect();
            }
            match declaration.parameter(name).map(|found| found.kind) {
                Some(ParameterKind::Choice { options, .. }) => {
                    options.iter().map(|option| proposal(option.name, option.doc)).collect()
                }
                Some(ParameterKind::Flag { .. }) => vec![proposal("true", ""), proposal("false", "")],
                _ => Vec::new(),
            }
        }
        [.., number] if number.starts_with(|c: char| c.is_ascii_digit()) => {
            units::UNITS.iter().map(|unit| proposal(unit.symbol, unit.doc)).collect()
        }
        _ => Vec::new(),
    }
}

/// Where the name at byte `offset` of the file at `path` is defined, possibly in a file that it uses.
pub fn definition(path: &Path, text: &str, offset: usize) -> Option<(Span, Sources)> {
    let mut files = Files::default();
    files.overlay(path, text);
    let file = files.open(path, None, &mut Vec::new())?;
    let tree = files.tree(file);
    let around = path_to(tree, offset);
    let node = *around.last()?;
    let parent = around.len().checked_sub(2).map(|index| around[index])?;
    let name = node.text();
    let names = files.names(file);
    let span = match (node.rule(), parent.rule()) {
        (Rule::name, Rule::base) => names.scenarios.get(name)?.span,
        (
            Rule::name,
            Rule::search_in
            | Rule::on_cases
            | Rule::as_many
            | Rule::evaluated
            | Rule::outcomes
            | Rule::chosen,
        ) => names.blocks.get(name).or_else(|| names.scenarios.get(name))?.span,
        (Rule::name, Rule::road_choice) => names.roads.get(name)?.span,
        (Rule::reference | Rule::name, _) => local_definition(&around, name)
            .or_else(|| files.scope(file).names.get(name).map(|binding| binding.span))?,
        _ => return None,
    };
    Some((span, files.sources))
}

/// Where the blocks around a place define a name.
fn local_definition(path: &[Node], name: &str) -> Option<Span> {
    const DEFINING: [Rule; 6] =
        [Rule::binding, Rule::vary, Rule::varied, Rule::vehicle, Rule::pedestrian, Rule::parameter];
    path.iter()
        .rev()
        .filter(|node| matches!(node.rule(), Rule::scenario | Rule::define | Rule::file))
        .find_map(|node| {
            let whole_file = node.rule() == Rule::file;
            node.descendants()
                .filter(|inner| {
                    DEFINING.contains(&inner.rule()) && (!whole_file || inner.rule() == Rule::binding)
                })
                .filter_map(|inner| inner.child(Rule::name))
                .find(|defined| defined.text() == name)
                .map(Node::span)
        })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    const TEXT: &str = "let pace = 1.4 m/s\nscenario a {\n  vehicle av {\n    controller carla_behavior { braking_distance: 5 m }\n    \
                        speed pace\n  }\n  expect { no collision }\n}\n";

    fn at(word: &str) -> usize {
        TEXT.rfind(word).unwrap() + 1
    }

    #[test]
    fn hover_says_what_the_registry_says() {
        let (tree, _) = Tree::parse(Sources::default().add("a.scn", TEXT), Arc::from(TEXT));
        let hovered = |word| hover(&tree, at(word)).map(|(_, text)| text).unwrap_or_default();
        assert!(hovered("carla_behavior").starts_with("**carla_behavior**"), "{}", hovered("carla_behavior"));
        assert!(hovered("braking_distance").contains("a length in m"), "{}", hovered("braking_distance"));
        assert!(hovered("collision").starts_with("**collision**"));
        assert!(hovered("speed").contains("steady cruise"));
        assert!(hovered("m }").contains("metre"));
        assert_eq!(hovered("pace\n"), "```scn\nlet pace = 1.4 m/s\n```");

        let text = "tune t {\n  otherwise fewest violations\n}\nstatement s {\n  differs \"why\"\n}\n";
        let (tree, _) = Tree::parse(Sources::default().add("a.scn", text), Arc::from(text));
        for (word, doc) in [("otherwise", "fewest runs"), ("differs", "not to be reproduced")] {
            let (_, said) = hover(&tree, text.find(word).unwrap() + 1).unwrap();
            assert!(said.contains(doc), "{said}");
        }
    }

    #[test]
    fn completion_knows_where_it_is() {
        let words = |text: &str| {
            complete(Path::new("nowhere/a.scn"), text, text.len())
                .into_iter()
                .map(|found| found.word)
                .collect::<Vec<_>>()
        };
        assert!(words("").contains(&"scenario".to_string()));
        assert!(words("scenario a {\n  ve").contains(&"vehicle".to_string()));
        assert!(words("scenario a { vehicle v {\n controller ").contains(&"carla_behavior".to_string()));
        assert!(words("vehicle v { controller carla_behavior { ").contains(&"braking_distance".to_string()));
        assert!(
            words("vehicle v { controller carla_behavior { gap: 1, profile: ")
                .contains(&"cautious".to_string())
        );
        assert!(words("scenario a { expect {\n  no ").contains(&"collision".to_string()));
        assert!(words("vehicle v { speed 30 ").contains(&"km/h".to_string()));
        assert!(words("# scen").is_empty());
        let text = "define base {\n}\nscenario a : base {\n}\nsearch s {\n  in a\n}\ntune t {\n  on ";
        assert_eq!(words(text), ["a", "s", "t"]);
        assert_eq!(words(&format!("{text}s\n}}\nscenario b : ")), ["a", "base"]);
        assert_eq!(complete(Path::new("nowhere/a.scn"), &format!("{text}\n}}\n"), text.len()).len(), 3);
    }

    #[test]
    fn definitions_are_found() {
        let (span, sources) = definition(Path::new("nowhere/a.scn"), TEXT, at("pace")).unwrap();
        assert_eq!(sources.text(span), "pace");
        assert_eq!(sources.location(span).line, 1);
    }
}
