//! What an editor can do about findings: edits that take them away.

use std::ops::Range;
use std::path::Path;

use super::assist::path_to;
use super::codes::Code;
use super::diagnostic::{Diagnostic, Remedy};
use super::source::{Sources, Span};
use super::syntax::ast::{self, View};
use super::syntax::{Node, Tree};
use files::Files;
use scenario::registry::Registry;

/// An edit that takes a finding away. What else is wrong then is found then.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fix {
    /// Such as "Write `collision`".
    pub title: String,
    /// What the finding is about.
    pub code: Code,
    /// The first place of the finding.
    pub at: Range<usize>,
    /// Bytes of the text.
    pub range: Range<usize>,
    /// In their place.
    pub text: String,
}

/// What can be done about the findings in a text that touch some bytes of it. `text` stands for the file at `path`.
pub fn fixes(
    path: &Path,
    text: &str,
    touching: Range<usize>,
    registry: &Registry,
    texts: &dyn Files,
) -> Vec<Fix> {
    let examined = crate::examine_edited(path, text, registry, texts);
    let own = path.display().to_string();
    let mut found = Vec::new();
    for finding in &examined.found {
        let span = finding.span();
        let touches = span.start <= touching.end && touching.start <= span.end;
        if touches && examined.sources.get(span.source).name == own {
            found.extend(of_finding(finding, text));
        }
    }
    found
}

fn of_finding(finding: &Diagnostic, text: &str) -> Vec<Fix> {
    let (tree, _) = Tree::parse(Sources::default().add("", ""), text.into());
    let at = finding.span().start..finding.span().end;
    let fix = |title: String, range: Range<usize>, text: String| Fix {
        title,
        code: finding.code,
        at: at.clone(),
        range,
        text,
    };
    let written = text.get(at.clone()).unwrap_or_default();
    let one = |remedy: &Remedy| match remedy {
        Remedy::Replace(other) => Some(fix(format!("Write `{other}`"), at.clone(), other.clone())),
        Remedy::AddBehind(more) => {
            Some(fix(format!("Write `{}{more}`", excerpt(written)), at.end..at.end, more.clone()))
        }
        Remedy::SayInside(statement) => {
            let (range, text) = inside(&tree, at.start, statement)?;
            Some(fix(format!("Say `{statement}`"), range, text))
        }
        Remedy::Remove => {
            let range = removed(&tree, text, &at);
            Some(fix(format!("Remove `{}`", excerpt(&text[range.clone()])), range, String::new()))
        }
    };
    let mut found: Vec<Fix> = finding.remedies.iter().filter_map(one).collect();
    if let (Code::UnclosedBracket, [_, closing]) = (finding.code, finding.labels.as_slice()) {
        let line = line_around(text, at.start);
        let indent: String = line.chars().take_while(|c| matches!(c, ' ' | '\t')).collect();
        let end = closing.span.end;
        found.push(fix("Close it with `}`".to_string(), end..end, format!("\n{indent}}}")));
    }
    found
}

/// The beginning of a text, of one line.
fn excerpt(text: &str) -> String {
    const LONGEST: usize = 40;
    let line = text.trim().lines().next().unwrap_or_default();
    let short: String = line.chars().take(LONGEST).collect();
    if short.len() < line.len() { format!("{short}…") } else { short }
}

fn line_around(text: &str, at: usize) -> &str {
    let start = text[..at].rfind('\n').map_or(0, |at| at + 1);
    text[start..].lines().next().unwrap_or_default()
}

/// One statement more at the end of the block of what is named at a byte.
fn inside(tree: &Tree, at: usize, statement: &str) -> Option<(Range<usize>, String)> {
    if statement.contains('…') {
        return None;
    }
    let named = path_to(tree, at + 1).into_iter().rev().find(|node| node.text().ends_with('}'))?;
    let text = named.text();
    let close = named.span().end - 1;
    let last = text[..text.len() - 1].trim_end_matches([' ', '\t', '\n', '\r']);
    let start = named.span().start + last.len();
    if !text.contains('\n') {
        let separator = if last.ends_with('{') { " " } else { "; " };
        return Some((start..close, format!("{separator}{statement} ")));
    }
    let line = line_around(tree.text(), named.span().start);
    let indent: String = line.chars().take_while(|c| matches!(c, ' ' | '\t')).collect();
    Some((start..close, format!("\n{indent}  {statement}\n{indent}")))
}

/// The bytes of the statement or setting whose name or whole stands there, with what separates it from the next.
fn removed(tree: &Tree, text: &str, at: &Range<usize>) -> Range<usize> {
    let is_there = |node: &Node| node.span().start == at.start && node.span().end == at.end;
    let path = path_to(tree, at.start + usize::from(at.start < at.end));
    let place = path.iter().position(is_there);
    let node = place.map(|place| match path[place - place.min(1)] {
        parent if ast::Setting::cast(parent).is_some() || ast::Binding::cast(parent).is_some() => parent,
        parent if ast::Argument::cast(parent).is_some() => parent,
        _ => path[place],
    });
    let span = node.map_or(Span::new(tree.root().span().source, at.start, at.end), Node::span);
    let before = &text[..span.start];
    let line = before.rfind('\n').map_or(0, |at| at + 1);
    let behind = &text[span.end..];
    let rest = behind.find('\n').map_or(behind, |end| &behind[..end]);
    if before[line..].trim().is_empty() && (rest.trim().is_empty() || rest.trim_start().starts_with('#')) {
        return line..(span.end + rest.len() + usize::from(span.end + rest.len() < text.len()));
    }
    let separators = behind.len() - behind.trim_start_matches([' ', '\t', ';', ',']).len();
    span.start..span.end + separators
}
