//! Whole numbers, docs and tags, as blocks say them.

use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::syntax::ast;

/// A whole number in a range.
pub fn count(
    node: ast::Integer,
    low: u32,
    high: u32,
    what: &str,
    report: &mut Vec<Diagnostic>,
) -> Option<u32> {
    let number = whole(node, report)?;
    match u32::try_from(number) {
        Ok(number) if (low..=high).contains(&number) => Some(number),
        _ => {
            report.push(
                Diagnostic::new(
                    Code::OutOfRange,
                    node.span(),
                    format!("{what} is {number}, but must be between {low} and {high}"),
                )
                .label("out of range")
                .hint(format!("choose a number between {low} and {high}")),
            );
            None
        }
    }
}

/// A whole number of at most 64 bits.
pub fn whole(node: ast::Integer, report: &mut Vec<Diagnostic>) -> Option<u64> {
    let digits = node.text().replace('_', "");
    let number = match digits.strip_prefix("0x") {
        Some(hexadecimal) => u64::from_str_radix(hexadecimal, 16),
        None => digits.parse(),
    };
    number.ok().or_else(|| {
        report.push(
            Diagnostic::new(Code::NumberTooLarge, node.span(), "this number has more than 64 bits")
                .label("too large")
                .hint(format!("the largest is {}", u64::MAX)),
        );
        None
    })
}

/// The text of what a block is about.
pub fn doc(doc: Option<ast::Doc>) -> Option<String> {
    doc.map(|doc| doc.quoted().value())
}

/// The tags that a block says, in order.
pub fn tags<'t>(said: impl Iterator<Item = ast::Tags<'t>>) -> Vec<String> {
    said.flat_map(ast::Tags::each).map(|tag| tag.text().to_string()).collect()
}
