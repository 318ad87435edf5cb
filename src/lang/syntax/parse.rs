//! From a text to its tree, and to what is wrong with it.

use std::sync::Arc;

use pest::Parser;

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
            match Grammar::parse(Rule::file, &text) {
                Ok(mut pairs) => {
                    if let Some(file) = pairs.next() {
                        tree.add(file, &[]);
                    }
                    let diagnostics = error::explain(&tree);
                    return (tree, diagnostics);
                }
                Err(error) => {
                    tree.add_empty_file();
                    let diagnostic =
                        error::unexpected(source, 0, &text, &error).hint("is a line unfinished?");
                    return (tree, vec![diagnostic]);
                }
            }
        }
        if let Some(missing) = closing::missing(&text, tree.tokens()).filter(|missing| !missing.is_empty())
            && let Ok(mut pairs) = Grammar::parse(Rule::file, &closing::closed(&text, &missing))
        {
            let added: Vec<usize> = missing.iter().map(|one| one.at).collect();
            if let Some(file) = pairs.next() {
                tree.add(file, &added);
            }
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
