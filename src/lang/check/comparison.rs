//! Comparisons of blocks: a metric with a bound that is the same for all runs, and the unit that it is written in.

use super::criterion;
use super::metric::Cast;
use crate::diagnostic::Diagnostic;
use crate::syntax::ast;
use crate::value::{self, NameScope};
use scenario::{Comparison, Expression, Notation};

/// A comparison whose bound is the same for all runs.
pub fn constant_comparison(
    (condition, undefined, what): (ast::Condition, Option<ast::Undefined>, &str),
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Comparison> {
    let comparison = criterion::comparison(condition, criterion::undefined(undefined), cast, scope, report)?;
    match &comparison.bound {
        Expression::Constant(_) => Some(comparison),
        varying => value::not_constant(condition.span(), varying, what, report),
    }
}

/// The unit that the bound of a comparison is written in.
pub fn bound_in(node: ast::Condition, scope: &NameScope) -> Option<Notation> {
    let bound = node.bound()?;
    // What is wrong with it was reported when it was read as a comparison.
    value::evaluate(bound, scope, &mut Vec::new())?.notation
}
