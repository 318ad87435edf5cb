//! Where a closing brace is missing, as far as indentation tells.

use super::lexer::{DEEPEST_NESTING, Token, TokenKind};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::{SourceId, Span};

/// An opening brace without its partner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Missing {
    pub opening: Token,
    /// The byte before which it was likely meant to close: the end of the last word that belongs to its block.
    pub at: usize,
}

/// A bracket that is open.
struct Open {
    token: Token,
    is_brace: bool,
    /// Number of the line that it stands in, and how far that is indented.
    line: usize,
    indent: usize,
}

/// Every brace that is not closed, in the order of where it was meant to close. A block ends where a line is indented no further
/// than the one that it begins in.
///
/// `None` where brackets are wrong in another way, or lines are indented so that nothing can be told.
pub fn missing(text: &str, tokens: &[Token]) -> Option<Vec<Missing>> {
    let mut found: Vec<Missing> = Vec::new();
    let mut open: Vec<Open> = Vec::new();
    let (mut line, mut indent, mut is_first) = (0, 0, true);
    // Where the last token ends that is neither space nor comment.
    let mut last = 0;
    for token in tokens {
        let symbol = &text[token.start..token.end];
        match token.kind {
            TokenKind::Newline => {
                (line, indent, is_first) = (line + 1, 0, true);
                continue;
            }
            TokenKind::Space => {
                if is_first {
                    indent += token.end - token.start;
                }
                continue;
            }
            TokenKind::Comment => continue,
            TokenKind::OpenString => return None,
            _ => {}
        }
        if std::mem::take(&mut is_first) {
            let ends = |block: &Open| match symbol {
                "}" => block.indent > indent,
                _ => block.indent >= indent,
            };
            while let Some(block) = open.pop_if(|block| block.is_brace && block.line < line && ends(block)) {
                found.push(Missing { opening: block.token, at: last });
            }
        }
        match token.kind {
            TokenKind::Open if open.len() == DEEPEST_NESTING => return None,
            TokenKind::Open => open.push(Open { token: *token, is_brace: symbol == "{", line, indent }),
            TokenKind::Close => {
                let opening = open.pop()?.token;
                if !matches!(
                    (&text[opening.start..opening.end], symbol),
                    ("{", "}") | ("[", "]") | ("(", ")")
                ) {
                    return None;
                }
            }
            _ => {}
        }
        last = token.end;
    }
    while let Some(block) = open.pop() {
        if !block.is_brace {
            return None;
        }
        found.push(Missing { opening: block.token, at: last });
    }
    // With so many it is no slip, and indentation tells nothing.
    (found.len() <= DEEPEST_NESTING).then_some(found)
}

/// The text with the braces that are missing.
pub fn closed(text: &str, missing: &[Missing]) -> String {
    let mut whole = String::with_capacity(text.len() + missing.len());
    let mut at = 0;
    for one in missing {
        whole.push_str(&text[at..one.at]);
        whole.push('}');
        at = one.at;
    }
    whole.push_str(&text[at..]);
    whole
}

/// What to say of each.
pub fn explain(source: SourceId, text: &str, missing: &[Missing]) -> Vec<Diagnostic> {
    let explain = |one: &Missing| {
        let start = text[..one.opening.start].rfind(['\n', '\r']).map_or(0, |at| at + 1);
        let head = text[start..one.opening.start].trim_start_matches('\u{feff}').trim();
        const LONGEST_HEAD: usize = 60;
        let whose = match head.chars().count() {
            1..=LONGEST_HEAD => format!(" of `{head}`"),
            _ => String::new(),
        };
        let opening = Span::new(source, one.opening.start, one.opening.end);
        let diagnostic =
            Diagnostic::new(Code::UnclosedBracket, opening, format!("`{{`{whose} is never closed"))
                .label("opened here");
        // The place is the last character that is still inside.
        let before = text[..one.at].char_indices().next_back().map_or(one.at, |(at, _)| at);
        if one.at > one.opening.end {
            diagnostic
                .context(Span::new(source, before, one.at), "likely meant to close behind this")
                .hint("put `}` on a line of its own there; lines are indented as if it stood there")
        } else {
            diagnostic.hint("put `}` where it ends")
        }
    };
    missing.iter().map(explain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::lexer::tokens;

    /// The heads of the lines that lack a brace, each with what stands before the place where it should be.
    fn lacking(text: &str) -> Option<Vec<(&str, &str)>> {
        let line = |at: usize| text[..at].rsplit('\n').next().unwrap_or_default().trim();
        let found = missing(text, &tokens(text))?;
        Some(found.iter().map(|one| (line(one.opening.start), line(one.at))).collect())
    }

    #[test]
    fn the_block_that_a_line_leaves_is_the_one_that_lacks_a_brace() {
        let text = "scenario a {\n  vehicle av {\n    speed 1 m/s # fast\n\n  pedestrian b {\n    x\n  }\n}\nroad c {\n}\n";
        assert_eq!(lacking(text), Some(vec![("vehicle av", "speed 1 m/s")]));
        let text = "scenario a {\n  vehicle av {\n    speed 1 m/s\n}\nroad c {\n}\n";
        assert_eq!(lacking(text), Some(vec![("vehicle av", "speed 1 m/s")]));
        let text = "scenario a {\n  vehicle av {\n    speed 1 m/s\n  }\n\nroad c {\n}\n";
        assert_eq!(lacking(text), Some(vec![("scenario a", "}")]));
    }

    #[test]
    fn several_are_missing_and_the_last_ones_at_the_end() {
        let text = "scenario a {\n  vehicle av {\n    sees {\n      range\n  expect {\n    x\n";
        let found = vec![("sees", "range"), ("vehicle av", "range"), ("expect", "x"), ("scenario a", "x")];
        assert_eq!(lacking(text), Some(found));
        let whole = closed(text, &missing(text, &tokens(text)).unwrap());
        assert_eq!(missing(&whole, &tokens(&whole)), Some(Vec::new()), "{whole}");
    }

    #[test]
    fn lists_over_several_lines_end_no_block() {
        let text = "scenario a {\n  vary x in [\n1,\n2\n]\n  vehicle av {\n    speed\n}\n";
        assert_eq!(lacking(text), Some(vec![("vehicle av", "speed")]));
    }

    #[test]
    fn nothing_is_guessed_where_lines_are_not_indented() {
        assert_eq!(lacking("scenario a {\nvehicle av {\nspeed\n}\n"), None);
        assert_eq!(lacking("scenario a {\n  x (\n}\n"), None);
        assert_eq!(lacking("a }\n"), None);
        assert_eq!(lacking("a {\n  b\n}\n"), Some(Vec::new()));
    }
}
