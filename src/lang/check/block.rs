//! Blocks of statements, possibly said in several layers: a base first, what builds on it last.

use std::collections::HashMap;

use crate::lang::codes::Code;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::settings::repeated;
use crate::lang::source::Span;
use crate::lang::tree::{Node, Rule};
use crate::lang::value::Scope;

/// A block with the names that its values may use.
#[derive(Clone, Copy)]
pub struct Layer<'a> {
    pub block: Node<'a>,
    pub scope: &'a Scope<'a>,
}

/// A statement with the names that its values may use.
#[derive(Clone, Copy)]
pub struct Said<'a> {
    pub node: Node<'a>,
    pub scope: &'a Scope<'a>,
}

/// The statement of that kind in the last layer that has one.
pub fn last<'a>(layers: &[Layer<'a>], rule: Rule) -> Option<Said<'a>> {
    layers.iter().rev().find_map(|layer| {
        let node = layer.block.child(rule)?;
        Some(Said { node, scope: layer.scope })
    })
}

/// As [`last`], for statements of two kinds that say the same thing.
pub fn last_of<'a>(layers: &[Layer<'a>], rules: [Rule; 2]) -> Option<Said<'a>> {
    layers.iter().rev().find_map(|layer| {
        let node = layer.block.children().find(|child| rules.contains(&child.rule()))?;
        Some(Said { node, scope: layer.scope })
    })
}

/// Reports every statement that stands again in the same block, except of kinds that may.
pub fn reject_repeats(block: Node, may_repeat: &[Rule], report: &mut Vec<Diagnostic>) {
    let mut seen: HashMap<Rule, (Span, &str)> = HashMap::new();
    for statement in block.children() {
        let rule = statement.rule();
        if matches!(rule, Rule::bad | Rule::bad_setting) || may_repeat.contains(&rule) {
            continue;
        }
        let span = statement.span();
        let word = statement.text().split_whitespace().next().unwrap_or_default();
        match seen.get(&rule) {
            Some((first, said)) if *said == word || rule == Rule::doc => {
                report.push(repeated(word.trim_matches('"'), span, *first));
            }
            Some((first, said)) => report.push(
                Diagnostic::new(
                    Code::RepeatedStatement,
                    span,
                    format!("`{word}` after `{said}`: one of them is too many"),
                )
                .label("said again")
                .context(*first, "said first here")
                .hint("remove one of them"),
            ),
            None => _ = seen.insert(rule, (span, word)),
        }
    }
}

/// Reports that `what` lacks something. `broken` blocks had a statement that did not parse, which may have been it.
pub fn missing(
    layers: &[Layer],
    name: Span,
    what: &str,
    lacks: &str,
    example: &str,
    report: &mut Vec<Diagnostic>,
) {
    if layers.iter().any(|layer| layer.block.has(Rule::bad)) {
        return;
    }
    report.push(
        Diagnostic::new(Code::MissingStatement, name, format!("{what} has no {lacks}"))
            .label(format!("has no {lacks}"))
            .hint(format!("say `{example}`")),
    );
}
