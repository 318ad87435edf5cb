//! `exposure …` of an estimate: how many encounters there are along a distance.

use super::criterion;
use super::places::TextPlaces;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{self, NameScope};
use scenario::{Dimension, Exposure};

/// So far are distances that numbers of encounters are told for, m.
pub const THOUSAND_KILOMETRES: f64 = 1e6;

/// What encounters or events are counted along, m.
pub fn distance(node: ast::Expression, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<f64> {
    let every = (f64::NEG_INFINITY, f64::INFINITY);
    let along = value::constant_in(node, Dimension::LENGTH, every, "the distance", scope, report)?;
    if along > 0.0 && along.is_finite() {
        return Some(along);
    }
    report.push(
        Diagnostic::new(Code::BadExposure, node.span(), "encounters are counted along a distance above 0")
            .label("no distance")
            .hint("write `per 1000 km`"),
    );
    None
}

/// A number that somebody has to give: none of it has a default.
pub fn exposure(
    node: ast::Exposure,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Exposure> {
    let numbers: Vec<ast::Expression> = node.numbers().collect();
    let (along, counts) = numbers.split_last()?;
    let Some(source) = node.source() else {
        report.push(
            Diagnostic::new(
                Code::BadExposure,
                node.span(),
                "nothing says how the number of encounters is known".to_string(),
            )
            .label("without a source")
            .hint("add `source \"…\"`: what was counted, where, when and by whom; that it is a guess can be said too"),
        );
        return None;
    };
    if counts.is_empty() {
        report.push(
            Diagnostic::new(Code::BadExposure, node.span(), "how many encounters there are is missing")
                .label("no number")
                .hint(
                    "give the number of such encounters where the system is to drive, such as `exposure 3 .. 12 encounters per 1000 km`: \
                     nobody else knows it, and there is no default",
                ),
        );
        return None;
    }
    let every = (f64::NEG_INFINITY, f64::INFINITY);
    let along = distance(*along, scope, report)?;
    let count = |one: &ast::Expression| {
        value::constant_in(*one, Dimension::NUMBER, every, "the number of encounters", scope, report)
    };
    let counts: Vec<f64> = counts.iter().map(count).collect::<Option<_>>()?;
    let (low, high) = (*counts.first()?, *counts.last()?);
    let mut wrong = |span: Span, message: String, label: &str, hint: &str| {
        report.push(Diagnostic::new(Code::BadExposure, span, message).label(label).hint(hint));
        None
    };
    if !(low >= 0.0 && high > 0.0 && high.is_finite()) {
        let message = format!("{low} .. {high} encounters: there must be some, or nothing is said");
        return wrong(
            numbers[0].span(),
            message,
            "not above 0",
            "write at least how many there are at most: `0 .. 3`",
        );
    }
    if low > high {
        let message = format!("at least {low} encounters and at most {high}");
        return wrong(numbers[0].span(), message, "more than the second", "write the smaller one first");
    }
    if source.value().trim().is_empty() {
        return wrong(
            source.span(),
            "nothing says how the number of encounters is known".to_string(),
            "empty",
            "say what was counted, where, when and by whom; a guess is a source too if it says that it is one",
        );
    }
    let confidence = match node.confidence() {
        Some(said) => Some(criterion::share(said.value(), "the confidence", true, scope, report)?),
        None => None,
    };
    let text = node.text().split_whitespace().collect::<Vec<_>>().join(" ");
    let per = THOUSAND_KILOMETRES / along;
    Some(Exposure {
        low: low * per,
        high: high * per,
        confidence,
        source: source.value(),
        text: text.split(" source ").next().unwrap_or_default().to_string(),
        origin: places.origin(node.span()),
    })
}
