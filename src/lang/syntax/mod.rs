//! Text and tree: the grammar, the tree that loses nothing, its typed views, the statements, and the way back into text.
//!
//! What the grammar calls a rule is known to nobody outside: what reads a tree asks the views of [`ast`] and the statements of
//! [`words`].

pub mod ast;
mod closing;
mod entry;
mod error;
mod format;
mod fragment;
#[cfg(test)]
mod grammar;
mod lexer;
mod parse;
mod print;
mod read;
mod tree;
pub mod words;

pub use ast::View;
pub use error::{Next, goes_on_with};
pub use format::{format, phrase};
pub use fragment::{Given, claim, criterion, given, replacement};
pub use lexer::{DEEPEST_NESTING, Token, TokenKind, balance, fragment, tokens};
pub use print::{aggregate_text, condition_text, criterion_text, expression, metric_text, metric_text_of};
pub use tree::{Node, NodeIndex, NodeKind, Tree};
