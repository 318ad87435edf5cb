//! Blocks of statements, possibly said in several layers: a base first, what builds on it last.

use std::collections::HashMap;

use crate::codes::Code;
use crate::diagnostic::{Diagnostic, Remedy};
use crate::settings::repeated;
use crate::source::Span;
use crate::syntax::ast::{self, View};
use crate::syntax::{Node, NodeKind, words};
use crate::value::NameScope;

/// A block with the names that its values may use.
#[derive(Clone, Copy)]
pub struct Layer<'a, B> {
    pub block: B,
    pub scope: &'a NameScope<'a>,
}

/// A statement with the names that its values may use.
#[derive(Clone, Copy)]
pub struct Said<'a, S> {
    pub node: S,
    pub scope: &'a NameScope<'a>,
}

/// What a block says in the last layer in which it does.
pub fn last<'a, B: Copy, S>(layers: &[Layer<'a, B>], said: impl Fn(B) -> Option<S>) -> Option<Said<'a, S>> {
    layers.iter().rev().find_map(|layer| Some(Said { node: said(layer.block)?, scope: layer.scope }))
}

/// Reports every statement that stands again in the same block and may not.
pub fn reject_repeats(block: Node, report: &mut Vec<Diagnostic>) {
    let mut seen: HashMap<NodeKind, (Span, &str)> = HashMap::new();
    let known = block.block();
    for statement in block.children() {
        let kind = statement.kind();
        let own = known.and_then(|block| statement.statement_of(block));
        if statement.is_bad() || own.is_some_and(|own| own.repeats) {
            continue;
        }
        let span = statement.span();
        let word = statement.text().split_whitespace().next().unwrap_or_default();
        match seen.get(&kind) {
            Some((first, said)) if *said == word || ast::Doc::cast(statement).is_some() => {
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
                .hint("remove one of them")
                .remedy(Remedy::Remove),
            ),
            None => _ = seen.insert(kind, (span, word)),
        }
    }
}

/// Two statements that say the same thing cannot stand together.
pub fn exclude(first: Option<Node>, second: Option<Node>, report: &mut Vec<Diagnostic>) {
    if let (Some(first), Some(second)) = (first, second) {
        let word = |node: Node| {
            let entry = words::all().find(|statement| statement.is(node));
            entry.map_or_else(|| node.text().to_string(), |statement| statement.words.to_string())
        };
        let mut diagnostic = repeated(&word(second), second.span(), first.span());
        diagnostic.message = format!("`{}` and `{}` say the same thing", word(first), word(second));
        report.push(diagnostic);
    }
}

/// Reports that `what` lacks the statement `S`. Of blocks with a statement that could not be read it may have been that.
pub fn missing<'a, S: View<'a>>(
    layers: &[Layer<'a, impl View<'a>>],
    name: Span,
    what: &str,
    report: &mut Vec<Diagnostic>,
) {
    let known = layers.first().and_then(|layer| words::viewed::<S>(*layer.block));
    let Some((lacks, example)) = known.map(words::StatementEntry::missing) else { return };
    if layers.iter().any(|layer| layer.block.has_bad()) {
        return;
    }
    report.push(
        Diagnostic::new(Code::MissingStatement, name, format!("{what} has no {lacks}"))
            .label(format!("has no {lacks}"))
            .hint(format!("say `{example}`"))
            .remedy(Remedy::SayInside(example.to_string())),
    );
}
