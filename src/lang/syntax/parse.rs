//! From a text to its tree, and to what is wrong with it.

use std::sync::Arc;

use pest::Parser;

use super::read::read;
use super::tree::{Grammar, Node, Rule, Tree};
use super::{closing, error, lexer};
use crate::diagnostic::Diagnostic;
use crate::source::SourceId;

impl Tree {
    /// Reads `text`. Always gives a tree. Where braces are missing and indentation tells where, it is the tree of the text with
    /// them; with brackets that are wrong in another way it has no nodes below the file.
    pub fn parse(source: SourceId, text: Arc<str>) -> (Self, Vec<Diagnostic>) {
        let tokens = lexer::tokens(&text);
        let unbalanced = lexer::balance(source, &text, &tokens);
        let mut tree = Self::unparsed(source, text.clone(), tokens);
        if unbalanced.is_empty() {
            let Some(spans) = read(Rule::file, &text) else {
                tree.add_empty_file();
                return (tree, vec![unreadable(source, &text)]);
            };
            tree.set_nodes(spans, &[]);
            let diagnostics = error::explain(&tree);
            return (tree, diagnostics);
        }
        if let Some(missing) = closing::missing(&text, tree.tokens()).filter(|missing| !missing.is_empty())
            && let Some(spans) = read(Rule::file, &closing::closed(&text, &missing))
        {
            let added: Vec<usize> = missing.iter().map(|one| one.at).collect();
            tree.set_nodes(spans, &added);
            let mut diagnostics = closing::explain(source, &text, &missing);
            // Of a statement that lacks a brace itself there is nothing to say but that.
            let is_whole = |finding: &Diagnostic| {
                let bad = tree.nodes().filter(|node| node.is_bad());
                let (start, end) = (finding.span().start, finding.span().end);
                let around = bad.map(Node::span).filter(|span| span.start <= start && end <= span.end);
                !around.into_iter().any(|span| added.iter().any(|at| span.start < *at && *at <= span.end))
            };
            let others = error::explain(&tree);
            diagnostics.extend(others.into_iter().filter(is_whole));
            return (tree, diagnostics);
        }
        tree.add_empty_file();
        (tree, unbalanced)
    }
}

/// Why the rule of a file does not describe the text.
fn unreadable(source: SourceId, text: &str) -> Diagnostic {
    let diagnostic = match Grammar::parse(Rule::file, text) {
        Err(error) => error::unexpected(source, 0, text, &error),
        Ok(_) => unreachable!("both read by one grammar"),
    };
    diagnostic.hint("is a line unfinished?")
}
