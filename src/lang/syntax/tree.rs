//! The lossless syntax tree: nodes of the grammar over the tokens of a text.

use std::sync::Arc;

use pest::Parser;
use pest::iterators::Pair;

use super::lexer::{self, Token};
use crate::source::{SourceId, Span};

pub(super) use grammar::scn::{Grammar, Rule};

/// A text with its tokens and nodes. The tokens, put together, are the text; nodes are spans of it.
#[derive(Debug, Clone)]
pub struct Tree {
    pub(crate) source: SourceId,
    text: Arc<str>,
    tokens: Vec<Token>,
    /// In the order in which they begin, parents before children.
    nodes: Vec<NodeData>,
}

#[derive(Debug, Clone, Copy)]
struct NodeData {
    rule: Rule,
    start: u32,
    end: u32,
    /// Index of the first node that is not below this one.
    after: u32,
}

/// A node of a tree.
#[derive(Debug, Clone, Copy)]
pub struct Node<'t> {
    tree: &'t Tree,
    index: u32,
}

impl Tree {
    /// That of a text before it is parsed: without nodes.
    pub(super) fn unparsed(source: SourceId, text: Arc<str>, tokens: Vec<Token>) -> Self {
        Self { source, text, tokens, nodes: Vec::new() }
    }

    /// A text that the rule describes by itself; its root is the node of that rule.
    pub(super) fn of(rule: Rule, text: &str) -> Option<Self> {
        let mut pairs = Grammar::parse(rule, text).ok()?;
        let tokens = lexer::tokens(text);
        let mut tree = Self::unparsed(SourceId(u32::MAX), text.into(), tokens);
        tree.add(pairs.next()?, &[]);
        Some(tree)
    }

    /// The same, as the tree of that text.
    pub(crate) fn of_source(self, source: SourceId) -> Self {
        Self { source, ..self }
    }

    pub(super) fn add_empty_file(&mut self) {
        let end = self.text.len() as u32;
        self.nodes = vec![NodeData { rule: Rule::file, start: 0, end, after: 1 }];
    }

    /// Adds a pair and all below it, without the white space that implicit skipping left at ends. The text that it is of has a
    /// character more than the tree's at each of the places `added`.
    pub(super) fn add(&mut self, pair: Pair<Rule>, added: &[usize]) {
        let index = self.nodes.len();
        let own = |at: usize| {
            // The one with index `i` stands at `added[i] + i` there.
            let before = added.iter().enumerate().take_while(|(index, place)| *place + index < at).count();
            at - before
        };
        let (start, end) = (own(pair.as_span().start()), own(pair.as_span().end()));
        let rule = pair.as_rule();
        self.nodes.push(NodeData { rule, start: start as u32, end: end as u32, after: 0 });
        for inner in pair.into_inner() {
            if inner.as_rule() != Rule::EOI {
                self.add(inner, added);
            }
        }
        let after = self.nodes.len() as u32;
        let end = if rule == Rule::file { self.text.len() } else { self.trim(start, end) };
        self.nodes[index].after = after;
        self.nodes[index].end = end as u32;
    }

    /// Where the last token of `start..end` that is neither space nor comment ends.
    fn trim(&self, start: usize, end: usize) -> usize {
        use lexer::TokenKind::{Comment, Newline, Space};
        let mut last = self.tokens.partition_point(|token| token.start < end);
        while last > 0 && self.tokens[last - 1].start >= start {
            let token = self.tokens[last - 1];
            if !matches!(token.kind, Space | Newline | Comment) {
                return token.end.min(end);
            }
            last -= 1;
        }
        end
    }

    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Every token, comments and white space included, in order and without gaps.
    pub(crate) fn tokens(&self) -> &[Token] {
        &self.tokens
    }

    pub(crate) fn root(&self) -> Node<'_> {
        Node { tree: self, index: 0 }
    }

    /// Every node, parents before children.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = Node<'_>> {
        (0..self.nodes.len() as u32).map(|index| Node { tree: self, index })
    }

    pub(crate) fn node(&self, index: NodeIndex) -> Node<'_> {
        Node { tree: self, index: index.0 }
    }
}

/// A node's place in its tree, for keeping without borrowing the tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct NodeIndex(u32);

/// What kind of node something is: equal where the grammar has one rule for both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct NodeKind(Rule);

impl<'t> Node<'t> {
    fn data(self) -> NodeData {
        self.tree.nodes[self.index as usize]
    }

    pub fn index(self) -> NodeIndex {
        NodeIndex(self.index)
    }

    pub fn tree(self) -> &'t Tree {
        self.tree
    }

    pub(super) fn rule(self) -> Rule {
        self.data().rule
    }

    pub fn span(self) -> Span {
        let data = self.data();
        Span::new(self.tree.source, data.start as usize, data.end as usize)
    }

    pub fn text(self) -> &'t str {
        let data = self.data();
        &self.tree.text[data.start as usize..data.end as usize]
    }

    pub fn children(self) -> impl Iterator<Item = Node<'t>> {
        let end = self.data().after;
        let mut next = self.index + 1;
        std::iter::from_fn(move || {
            (next < end).then(|| {
                let child = Node { tree: self.tree, index: next };
                next = child.data().after;
                child
            })
        })
    }

    /// The node itself and every node below it, parents before children.
    pub fn descendants(self) -> impl Iterator<Item = Node<'t>> {
        (self.index..self.data().after).map(move |index| Node { tree: self.tree, index })
    }

    /// What kind of node it is, to be compared.
    pub fn kind(self) -> NodeKind {
        NodeKind(self.rule())
    }

    /// Whether it is what could not be read.
    pub fn is_bad(self) -> bool {
        matches!(self.rule(), Rule::bad | Rule::bad_setting)
    }

    /// Whether one of its own parts could not be read.
    pub fn has_bad(self) -> bool {
        self.children().any(Node::is_bad)
    }

    /// Whether something in it could not be read.
    pub fn is_broken(self) -> bool {
        self.descendants().any(Node::is_bad)
    }
}
