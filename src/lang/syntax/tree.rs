//! The lossless syntax tree: nodes of the grammar over the tokens of a text.

use std::sync::Arc;

use reader::RuleSpan;

use super::lexer::{self, Token};
use super::read::{is_shallow, read};
use crate::source::{SourceId, Span};

pub(super) use grammar::scn::{Grammar, Rule};

/// A text with its tokens and nodes. The tokens, put together, are the text; nodes are spans of it.
#[derive(Debug, Clone)]
pub struct Tree {
    pub(crate) source: SourceId,
    text: Arc<str>,
    tokens: Vec<Token>,
    /// In the order in which they begin, parents before children.
    nodes: Vec<RuleSpan>,
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
        let tokens = lexer::tokens(text);
        let spans = is_shallow(&tokens).then(|| read(rule, text))??;
        let mut tree = Self::unparsed(SourceId(u32::MAX), text.into(), tokens);
        tree.set_nodes(spans, &[]);
        Some(tree)
    }

    /// The same, as the tree of that text.
    pub(crate) fn of_source(self, source: SourceId) -> Self {
        Self { source, ..self }
    }

    pub(super) fn add_empty_file(&mut self) {
        let end = self.text.len() as u32;
        self.nodes = vec![RuleSpan { rule: Rule::file, start: 0, end, after: 1 }];
    }

    /// Takes what rules describe as nodes, without the white space that implicit skipping left at ends. The text that they are of has
    /// a character more than the tree's at each of the places `added`.
    pub(super) fn set_nodes(&mut self, mut spans: Vec<RuleSpan>, added: &[usize]) {
        let own = |at: u32| {
            // The one with index `i` stands at `added[i] + i` there.
            let before = added.iter().enumerate().take_while(|(index, place)| *place + index < at as usize);
            at as usize - before.count()
        };
        // The first token that does not begin before the node.
        let mut first = 0;
        for span in &mut spans {
            let (start, end) = (own(span.start), own(span.end));
            while self.tokens.get(first).is_some_and(|token| token.start < start) {
                first += 1;
            }
            let end = if span.rule == Rule::file { self.text.len() } else { self.trim(first, end) };
            (span.start, span.end) = (start as u32, end as u32);
        }
        self.nodes = spans;
    }

    /// Where the last token before `end` ends that is neither space nor comment, of those from `first` on.
    fn trim(&self, first: usize, end: usize) -> usize {
        use lexer::TokenKind::{Comment, Newline, Space};
        let tokens = &self.tokens[first..];
        // Most nodes are small, and a tree of a large file has many.
        let mut near = 1;
        while tokens.get(near).is_some_and(|token| token.start < end) {
            near *= 2;
        }
        let within = &tokens[..near.min(tokens.len())];
        let within = &within[..within.partition_point(|token| token.start < end)];
        let means_something = |token: &&Token| !matches!(token.kind, Space | Newline | Comment);
        within.iter().rfind(means_something).map_or(end, |token| token.end.min(end))
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
    fn data(self) -> RuleSpan {
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
