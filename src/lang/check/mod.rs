//! From syntax to checked scenarios.

mod block;
mod book;
mod claim;
mod confidence;
mod controller;
mod criterion;
mod defaults;
mod evaluate;
mod experiment;
mod fmu;
mod gate;
mod metric;
mod model;
mod pedestrian;
mod rated_cells;
mod rating;
mod road;
mod runs;
mod scenario;
mod statement;
mod subject;
mod tested;
mod variation;
mod vehicle;

use std::path::Path;

use super::codes::Code;
use super::diagnostic::Diagnostic;
use super::source::Span;
use super::syntax::ast;
use super::texts::Texts;
use ::scenario::Origin;

pub use block::reject_repeats;
use book::Book;
pub use controller::controller;
pub use criterion::set_aside;
pub use evaluate::evaluate;
pub use experiment::{search, tune};
pub use gate::gate;
pub use metric::Cast;
pub use rated_cells::RatedScenarios;
pub use rating::rating;
pub use road::{bus, crossings, obstacle, parked_row};
pub use scenario::{SuiteCriteria, defined_road, scenario, write_scenario};
pub use statement::statement;
pub use subject::{Checked, Subjects};
pub use tested::tested;

/// Where things were said.
#[derive(Clone, Copy)]
pub struct Places<'a> {
    pub files: &'a Texts<'a>,
}

impl Places<'_> {
    pub fn origin(&self, span: Span) -> Origin {
        self.files.sources.origin(span)
    }

    /// The path of a file that is named relative to the file in which `span` is.
    pub fn beside(&self, span: Span, name: &str) -> String {
        let file = Path::new(&self.files.sources.get(span.source).name);
        super::texts::join(file, name).display().to_string()
    }
}

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
