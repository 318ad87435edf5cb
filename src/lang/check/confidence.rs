//! What may be claimed with a confidence.

use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::syntax::ast;
use scenario::{Aggregate, Relation};

/// Of some aggregates no sample ever shows anything with confidence.
pub fn refuse_confidence(
    confidence: ast::Confidence,
    aggregate: &Aggregate,
    relation: Relation,
    report: &mut Vec<Diagnostic>,
) -> Option<()> {
    let (message, hint) = match (aggregate, relation) {
        (Aggregate::Count(_), _) => (
            "a count is of the runs that were done, without confidence",
            "say something of all runs there could be: `rate(…)`",
        ),
        (Aggregate::Min(_), _) => (
            "runs do not tell how small a metric can get, at no confidence",
            "bound a small quantile instead: `quantile(5 %, …)`",
        ),
        (Aggregate::Max(_), _) => (
            "runs do not tell how large a metric can get, at no confidence",
            "bound a large quantile instead: `quantile(95 %, …)`",
        ),
        (Aggregate::Std(_), _) => (
            "runs do not tell how far a metric spreads, at no confidence: no bounds on a spread hold for every metric",
            "bound two quantiles instead: `quantile(5 %, …)` and `quantile(95 %, …)`",
        ),
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
