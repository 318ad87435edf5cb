//! What may be claimed with a confidence.

use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::syntax::ast;
use scenario::{Aggregate, AggregateBounds, Relation};

/// Of some aggregates no sample ever shows anything with confidence.
pub fn refuse_confidence(
    confidence: ast::Confidence,
    aggregate: &Aggregate,
    relation: Relation,
    report: &mut Vec<Diagnostic>,
) -> Option<()> {
    let (message, hint) = match (aggregate.bounds(), relation) {
        (AggregateBounds::Unknown { why, instead }, _) => (why, instead),
        (_, Relation::Equal | Relation::NotEqual) => (
            "no number of runs shows with confidence that something is exactly so large",
            "compare by `<=` or `>=`",
        ),
        _ => return Some(()),
    };
    report.push(
        Diagnostic::new(Code::BadModifier, confidence.span(), message)
            .label("has no meaning here")
            .hint(hint),
    );
    None
}
