//! A text as tokens that, put together, give the text back byte for byte.
//!
//! Comments and white space are here and nowhere else; brackets and quotes are balanced here, before the grammar
//! is asked, so that its recovery may rely on them.

use crate::codes::Code;
use crate::diagnostic::{Diagnostic, Remedy};
use crate::source::{SourceId, Span};

/// Brackets inside brackets beyond this are refused.
pub const DEEPEST_NESTING: usize = 64;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TokenKind {
    Space,
    Newline,
    Comment,
    String,
    /// A quote without its partner in the same line.
    OpenString,
    Word,
    Number,
    /// One of `{ [ (`.
    Open,
    /// One of `} ] )`.
    Close,
    Punctuation,
    /// A character that no statement uses.
    Stray,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Token {
    pub kind: TokenKind,
    pub start: usize,
    pub end: usize,
}

/// Splits the text of a file without leaving anything out. A byte order mark, which some editors put at its
/// beginning, counts as space there and nowhere else.
pub fn tokens(text: &str) -> Vec<Token> {
    let mut tokens = fragment(text);
    if let Some(first) = tokens.first_mut().filter(|_| text.starts_with('\u{feff}')) {
        first.kind = TokenKind::Space;
    }
    tokens
}

/// Splits a part of a file.
pub fn fragment(text: &str) -> Vec<Token> {
    let mut tokens = Vec::with_capacity(text.len() / 4);
    let mut start = 0;
    while start < text.len() {
        let (kind, length) = next(&text[start..]);
        tokens.push(Token { kind, start, end: start + length });
        start += length;
    }
    tokens
}

fn next(rest: &str) -> (TokenKind, usize) {
    let bytes = rest.as_bytes();
    let run = |belongs: fn(char) -> bool| rest.find(|c| !belongs(c)).unwrap_or(rest.len());
    match bytes[0] {
        b'\n' => (TokenKind::Newline, 1),
        b'\r' if bytes.get(1) == Some(&b'\n') => (TokenKind::Newline, 2),
        b'\r' => (TokenKind::Newline, 1),
        b' ' | b'\t' => (TokenKind::Space, run(|c| matches!(c, ' ' | '\t'))),
        b'#' => (TokenKind::Comment, run(|c| c != '\n' && c != '\r')),
        b'"' => string(bytes),
        b'{' | b'[' | b'(' => (TokenKind::Open, 1),
        b'}' | b']' | b')' => (TokenKind::Close, 1),
        b'0'..=b'9' => (TokenKind::Number, run(|c| c.is_ascii_digit() || c == '_')),
        b'A'..=b'Z' | b'a'..=b'z' | b'_' => (TokenKind::Word, run(|c| c.is_ascii_alphanumeric() || c == '_')),
        b'!' | b'%' | b'*'..=b'/' | b':'..=b'>' | b'^' => (TokenKind::Punctuation, 1),
        _ => match rest.chars().next() {
            Some(c @ ('²' | '³' | '°' | 'µ' | '≤' | '≥' | '≠')) => {
                (TokenKind::Punctuation, c.len_utf8())
            }
            Some(c) => (TokenKind::Stray, c.len_utf8()),
            None => (TokenKind::Stray, rest.len()),
        },
    }
}

fn string(bytes: &[u8]) -> (TokenKind, usize) {
    let mut at = 1;
    while at < bytes.len() {
        match bytes[at] {
            b'"' => return (TokenKind::String, at + 1),
            b'\n' | b'\r' => break,
            b'\\' if at + 1 < bytes.len() && !matches!(bytes[at + 1], b'\n' | b'\r') => at += 2,
            _ => at += 1,
        }
    }
    // A backslash may have jumped into a character of several bytes; none of its other bytes is a quote or line end.
    (TokenKind::OpenString, at.min(bytes.len()))
}

/// Brackets without partner, quotes without end and nesting beyond reason.
pub fn balance(source: SourceId, text: &str, tokens: &[Token]) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    let mut open: Vec<Token> = Vec::new();
    let mut too_deep = false;
    let symbol = |token: &Token| &text[token.start..token.end];
    let span = |token: &Token| Span::new(source, token.start, token.end);
    for token in tokens {
        match token.kind {
            TokenKind::OpenString => diagnostics.push(
                Diagnostic::new(Code::UnclosedString, span(token), "this text has no closing quote")
                    .label("begins here and runs to the end of the line")
                    .hint("put `\"` at its end; a text stays within one line")
                    .remedy(Remedy::AddBehind("\"".to_string())),
            ),
            TokenKind::Open => {
                if open.len() == DEEPEST_NESTING && !too_deep {
                    too_deep = true;
                    diagnostics.push(
                        Diagnostic::new(
                            Code::NestedTooDeeply,
                            span(token),
                            format!("brackets are nested more than {DEEPEST_NESTING} deep"),
                        )
                        .label("one level too many")
                        .hint("name parts of it with `let`"),
                    );
                }
                open.push(*token);
            }
            TokenKind::Close => match open.pop() {
                Some(opening) if closing(symbol(&opening)) == symbol(token) => {}
                Some(opening) => {
                    diagnostics.push(
                        Diagnostic::new(
                            Code::MismatchedBracket,
                            span(token),
                            format!("`{}` does not close `{}`", symbol(token), symbol(&opening)),
                        )
                        .label(format!("expected `{}`", closing(symbol(&opening))))
                        .context(span(&opening), "opened here")
                        .hint(format!("close it with `{}` first", closing(symbol(&opening)))),
                    );
                    return diagnostics;
                }
                None => diagnostics.push(
                    Diagnostic::new(
                        Code::UnopenedBracket,
                        span(token),
                        format!("`{}` closes nothing", symbol(token)),
                    )
                    .label("no bracket is open here")
                    .hint("remove it, or look for one `}` too many above")
                    .remedy(Remedy::Remove),
                ),
            },
            _ => {}
        }
    }
    for opening in open.iter().rev().take(if too_deep { 0 } else { 8 }) {
        diagnostics.push(
            Diagnostic::new(
                Code::UnclosedBracket,
                span(opening),
                format!("`{}` is never closed", symbol(opening)),
            )
            .label("opened here")
            .hint(format!("put `{}` where it ends", closing(symbol(opening)))),
        );
    }
    diagnostics
}

fn closing(opening: &str) -> &'static str {
    match opening {
        "{" => "}",
        "[" => "]",
        _ => ")",
    }
}
