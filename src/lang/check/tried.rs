//! `try { braking_distance: 8 m }` of a tune: a candidate of the user's own.

use std::collections::HashMap;

use super::subject::StatementSubject;
use super::target::{Takes, target};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings::{self, repeated};
use crate::source::Span;
use crate::syntax::{ast, phrase};
use crate::value::{self, NameScope};
use scenario::{Dimension, Expression, ParameterKind, RangeValues, SearchRange, Target, Value};

/// The candidates that a tune tries first; `over` are its ranges, in the order of `nodes`.
pub fn tried<'t>(
    block: ast::TuneBlock<'t>,
    over: &[SearchRange],
    subject: &StatementSubject,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<Vec<(Target, Value)>>> {
    let nodes: Vec<ast::OverRange<'t>> = block.over().flat_map(ast::Over::ranges).collect();
    let ranges: Vec<(&SearchRange, ast::OverRange<'t>)> = over.iter().zip(nodes).collect();
    let each: Vec<_> =
        block.tries().map(|node| candidate(node.set(), &ranges, subject, scope, report)).collect();
    each.into_iter().collect()
}

fn candidate(
    node: ast::ParameterSet,
    ranges: &[(&SearchRange, ast::OverRange)],
    subject: &StatementSubject,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<(Target, Value)>> {
    let nodes: Vec<ast::Given> = node.given().collect();
    if nodes.is_empty() && !node.has_bad() {
        report.push(
            Diagnostic::new(Code::BadTry, node.span(), "this candidate sets nothing")
                .label("no parameters")
                .hint("what is declared is tried in any case"),
        );
        return None;
    }
    let mut said: HashMap<String, Span> = HashMap::new();
    let values: Vec<_> = nodes
        .into_iter()
        .map(|node| {
            let (range, over) = range(node.target(), ranges, report)?;
            let name = range.target.to_string();
            if let Some(first) = said.insert(name.clone(), node.target().span()) {
                report.push(repeated(&name, node.target().span(), first));
                return None;
            }
            Some((range.target.clone(), given(node.value(), (range, over), subject, scope, report)?))
        })
        .collect();
    values.into_iter().collect()
}

/// The range that a name means: `av.controller.braking_distance`, or `braking_distance` where one alone is called so.
fn range<'r, 't>(
    node: ast::Target,
    ranges: &'r [(&'r SearchRange, ast::OverRange<'t>)],
    report: &mut Vec<Diagnostic>,
) -> Option<(&'r SearchRange, ast::OverRange<'t>)> {
    let wanted = phrase(*node);
    let is_meant = |range: &SearchRange| match &range.target {
        Target::Setting { parameter, .. } if node.parameter().is_none() => *parameter == wanted,
        target => target.to_string() == wanted,
    };
    let mut meant = ranges.iter().filter(|(range, _)| is_meant(range));
    let (first, second) = (meant.next(), meant.next());
    if second.is_some() {
        report.push(
            Diagnostic::new(Code::BadTry, node.span(), format!("`{wanted}` is tuned of several"))
                .label("of which?")
                .hint(format!("write its whole name: `{}`", first?.0.target)),
        );
        return None;
    }
    if first.is_none() {
        let known: Vec<String> = ranges
            .iter()
            .map(|(range, _)| match &range.target {
                Target::Setting { parameter, .. } if node.parameter().is_none() => parameter.clone(),
                target => target.to_string(),
            })
            .collect();
        report.push(
            Diagnostic::new(Code::BadTry, node.span(), format!("`{wanted}` is not tuned"))
                .label("in no `over` of this tune")
                .suggest(&wanted, known.iter().map(String::as_str)),
        );
    }
    first.copied()
}

/// A value within the range.
fn given(
    node: ast::Expression,
    (range, over): (&SearchRange, ast::OverRange),
    subject: &StatementSubject,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let what = format!("`{}`", range.target);
    if let RangeValues::Words(words) = &range.values {
        let options: Vec<&str> = words.iter().map(String::as_str).collect();
        return match settings::choice(node, &what, &options, scope, report)? {
            Expression::Constant(value) => Some(value),
            varying => value::not_constant(node.span(), &varying, "a candidate", report),
        };
    }
    // What is wrong with the range itself was reported with it.
    let Takes::Parameter(declaration, name) = target(over.target(), subject, &mut Vec::new())?.1 else {
        return None;
    };
    let dimension = match declaration.parameter(&name).map(|known| &known.kind) {
        Some(ParameterKind::Number { dimension, .. }) => *dimension,
        _ => Dimension::NUMBER,
    };
    let limits = match range.values {
        RangeValues::Real { low, high } | RangeValues::Logarithmic { low, high } => (low, high),
        RangeValues::Whole { low, high } => (low as f64, high as f64),
        RangeValues::Words(_) => return None,
    };
    let number = value::constant_in(node, dimension, limits, &what, scope, report)?;
    if matches!(range.values, RangeValues::Whole { .. }) && number.fract() != 0.0 {
        report.push(
            Diagnostic::new(Code::BadTry, node.span(), format!("{what} takes whole numbers"))
                .label("not a whole number")
                .hint("write a whole number"),
        );
        return None;
    }
    Some(Value::Number(number))
}
