//! `expect { pet >= 1.5 s }` of a search: what every run that it keeps has to fulfil.

use super::criterion::{From, criterion};
use super::metric::Cast;
use super::places::TextPlaces;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{self, NameScope};
use scenario::{Claim, Criterion, Expression};

/// The criteria of a search, each about one run.
pub fn expectations(
    block: ast::SearchBlock,
    cast: &Cast,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<Criterion>> {
    let nodes = block.expects().flat_map(|expect| expect.block().criteria());
    let each = nodes.map(|node| {
        is_about_one_run(node, report)?;
        let found = criterion(node, From::Scenario, cast, scope, places, report)?;
        for one in &found {
            is_constant(node, one, report)?;
        }
        Some(found)
    });
    let each: Vec<Option<Vec<Criterion>>> = each.collect();
    each.into_iter().collect::<Option<Vec<_>>>().map(|all| all.concat())
}

/// Reports what speaks of many runs, or of some: a search is judged run by run.
fn is_about_one_run(node: ast::Criterion, report: &mut Vec<Diagnostic>) -> Option<()> {
    let mut refuse = |span: Span, label: &str| {
        report.push(
            Diagnostic::new(
                Code::BadExpectation,
                span,
                "a search is judged run by run, by the runs that it keeps",
            )
            .label(label)
            .hint("say what each of them has to fulfil: `pet >= 1.5 s` or `no collision`"),
        );
        None
    };
    if let Some(claim) = node.aggregate_claim() {
        return refuse(claim.span(), "sums up many runs");
    }
    let parts = [
        (node.share().map(|part| part.span()), "speaks of many runs"),
        (node.confidence().map(|part| part.span()), "speaks of many runs"),
        (node.whom().map(|part| part.span()), "speaks of many people"),
        (node.whens().next().map(|part| part.span()), "speaks of some runs"),
    ];
    match parts.into_iter().find_map(|(span, label)| Some((span?, label))) {
        Some((span, label)) => refuse(span, label),
        None => Some(()),
    }
}

fn is_constant(node: ast::Criterion, found: &Criterion, report: &mut Vec<Diagnostic>) -> Option<()> {
    let Claim::Runs { comparison, .. } = &found.claim else { return None };
    match &comparison.bound {
        Expression::Constant(_) => Some(()),
        varying => value::not_constant(node.span(), varying, "the bound of this criterion", report),
    }
}
