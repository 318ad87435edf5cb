//! `gate NAME { … }`

use super::block::{Layer, missing, reject_repeats};
use super::criterion;
use super::literal;
use super::metric::Cast;
use super::metric::metric_reference;
use super::places::TextPlaces;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::syntax;
use crate::syntax::ast;
use crate::value::{self, NameScope, ValueKind};
use scenario::{
    Dimension, Expression, Gate, GateRate, GateRule, Metric, MetricKind, MetricReference, Notation, Relation,
    Tolerance, Value, Worst,
};
use std::sync::Arc;

/// What a rule promises that does not say how sure it wants to be.
pub const DEFAULT_CONFIDENCE: f64 = 0.95;

/// Beyond, the error that Berger and Boos' method leaves out of p-values is no longer small.
const MOST_CONFIDENCE: f64 = 0.9999;

/// The gate at `node`; its metrics may name the road users of `cast`.
pub fn gate(
    node: ast::Gate,
    cast: &Cast,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Gate> {
    let (name, block) = (node.name(), node.block());
    reject_repeats(*block, report);
    let baseline = block.baseline().map(ast::Baseline::path);
    if baseline.is_none() {
        let what = format!("gate `{}`", name.text());
        missing::<ast::Baseline>(&[Layer { block, scope }], name.span(), &what, report);
    }
    let nodes: Vec<ast::GateRule> = block.rules().collect();
    if nodes.is_empty() && !block.has_bad() {
        report.push(
            Diagnostic::new(Code::BadGate, name.span(), format!("gate `{}` forbids nothing", name.text()))
                .label("compares nothing")
                .hint("say `no metric worse by more than 5 % with 95 % confidence`"),
        );
        return None;
    }
    let rules: Vec<_> = nodes.into_iter().map(|node| rule(node, cast, scope, places, report)).collect();
    if let Some(blanket) = unguarded(&rules) {
        let message = format!("gate `{}` says nothing of collisions", name.text());
        report.push(
            Diagnostic::new(Code::CollisionsUnguarded, name.span(), message)
                .label(format!("`{blanket}` is about quantities"))
                .hint("add `collision not worse`: only where the baseline has no collision at all, none may be new by default"),
        );
    }
    Some(Gate {
        name: name.text().to_string(),
        doc: literal::doc(block.doc()),
        baseline: baseline.map(|string| places.beside(string.span(), &string.path()))?,
        sequential: block.sequential().is_some(),
        rules: rules.into_iter().collect::<Option<_>>()?,
        origin: places.origin(name.span()),
    })
}

/// What a rule about every metric says, of a gate that has no rule about collisions besides.
fn unguarded(rules: &[Option<GateRule>]) -> Option<&str> {
    let known = || rules.iter().flatten();
    let named = known().filter_map(|rule| rule.metric.as_ref()).any(|metric| metric.name() == "collision");
    let blanket = known().find(|rule| rule.metric.is_none())?;
    // Of a rule that could not be read nobody knows what it is about.
    (!named && rules.iter().all(Option::is_some)).then_some(&blanket.text)
}

fn rule(
    node: ast::GateRule,
    cast: &Cast,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<GateRule> {
    let primary = node.primary().is_some();
    if let Some(new) = node.none_new() {
        return none_new(new, primary, cast, scope, places, report);
    }
    let metric = match node.metric() {
        Some(node) => {
            let found = metric_reference(node, cast, scope, report)?;
            let is_word = matches!(&found.1.kind, MetricKind::Category(_));
            if is_word || found.1.worst == Worst::Neither {
                let message = match is_word {
                    true => format!("`{}` is a word, and no word is worse than another", found.0.name()),
                    false => format!("no value of `{}` is worse than another", found.0.name()),
                };
                report.push(
                    Diagnostic::new(Code::BadGate, node.span(), message)
                        .label("has no better or worse")
                        .hint("name a quantity or something that is true or false, such as `gap_accepted`"),
                );
                return None;
            }
            Some(found)
        }
        None => None,
    };
    let rate = match node.rate() {
        Some(node) => Some(rate(node, cast, scope, report)?),
        None => None,
    };
    let (metric, rate) = match rate {
        Some((metric, rate)) => (Some(metric), Some(rate)),
        None => (metric, None),
    };
    let kind = match &rate {
        // A difference of rates, as of what is true or false.
        Some(_) => Some(&MetricKind::Flag),
        None => metric.as_ref().map(|(_, found)| &found.kind),
    };
    let bound = node.tolerance().map(ast::GateTolerance::bound);
    let (tolerance, notation) = match bound {
        None => (Tolerance::Relative(0.0), None),
        Some(bound) => tolerance(bound, kind, scope, report)?,
    };
    let said = node.confidence().map(ast::Confidence::value);
    let confidence = match said {
        Some(said) => confidence(said, scope, report)?,
        None => DEFAULT_CONFIDENCE,
    };
    let mut text = match (&rate, node.metric()) {
        (Some(rate), _) => format!("{}{} not worse", said_first(primary), rate.text),
        (None, Some(metric)) => format!("{}{} not worse", said_first(primary), syntax::metric_text(metric)),
        (None, None) => "no metric worse".to_string(),
    };
    if let Some(bound) = bound {
        text += &format!(" by more than {}", syntax::expression(bound));
    }
    if let Some(said) = said {
        text += &format!(" with {} confidence", syntax::expression(said));
    }
    let metric = metric.map(|(reference, _)| reference);
    let origin = places.origin(node.span());
    Some(GateRule { metric, rate, tolerance, primary, confidence, text, notation, origin })
}

/// `rate(pet < 1.5 s)`: of what, and which side of its bound is worse.
fn rate(
    node: ast::Rate,
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<((MetricReference, Arc<Metric>), GateRate)> {
    let text = syntax::aggregate_text(ast::Aggregate::Rate(node));
    let condition = node.condition();
    let found = metric_reference(condition.metric(), cast, scope, report)?;
    let compared = criterion::condition_of_rate(node, None, cast, scope, report)?;
    let Expression::Constant(Value::Number(bound)) = compared.bound else {
        let what = format!("the bound of `{}`", found.0.name());
        return value::not_constant(condition.span(), &compared.bound, &what, report);
    };
    let mut refuse = |message: String, hint: String| {
        report.push(
            Diagnostic::new(Code::BadGate, node.span(), message).label("cannot be compared").hint(hint),
        );
        None
    };
    if ast::Aggregate::Rate(node).word() != "rate" {
        let hint = format!("say `rate({})`", syntax::condition_text(condition, node.undefined()));
        return refuse(
            "a gate compares shares of runs, which do not depend on how many there are".to_string(),
            hint,
        );
    }
    let larger_is_worse = match (found.1.worst, &found.1.kind) {
        (Worst::Neither, _) | (_, MetricKind::Category(_)) => {
            let message = format!("no value of `{}` is worse than another", found.0.name());
            return refuse(
                message,
                "name a quantity that has a worse side, such as `rate(pet < 1.5 s)`".to_string(),
            );
        }
        (worst, _) => worst == Worst::Largest,
    };
    let is_flag = found.1.kind == MetricKind::Flag;
    let holds_above = match compared.relation {
        Relation::Greater | Relation::GreaterOrEqual => true,
        Relation::Less | Relation::LessOrEqual => false,
        Relation::Equal if is_flag => bound != 0.0,
        Relation::NotEqual if is_flag => bound == 0.0,
        Relation::Equal | Relation::NotEqual => {
            let message = format!(
                "on both sides of one value of `{}` are others, one side of which is worse",
                found.0.name()
            );
            return refuse(
                message,
                format!("compare it by `<` or `>`, such as `rate({} < …)`", found.0.name()),
            );
        }
    };
    let rate = GateRate {
        relation: compared.relation,
        bound,
        when_undefined: compared.when_undefined,
        bad: holds_above == larger_is_worse,
        text,
    };
    Some((found, rate))
}

/// The confidence of a rule: all comparisons of a gate share what it leaves to chance.
fn confidence(said: ast::Expression, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<f64> {
    let confidence = criterion::share(said, "the confidence", true, scope, report)?;
    if confidence > MOST_CONFIDENCE {
        report.push(
            Diagnostic::new(
                Code::BadShare,
                said.span(),
                format!("the confidence of a gate can be {} % at most", MOST_CONFIDENCE * 100.0),
            )
            .label("more than its tests can give")
            .note(
                "they leave 1e-7 to chance in every comparison, and all comparisons of a gate share the rest",
            )
            .hint("say `with 99.9 % confidence`"),
        );
        return None;
    }
    Some(confidence)
}

fn said_first(primary: bool) -> &'static str {
    if primary { "primary " } else { "" }
}

/// `no new collision`
fn none_new(
    node: ast::NoneNew,
    primary: bool,
    cast: &Cast,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<GateRule> {
    let metric = node.metric();
    let (reference, found) = metric_reference(metric, cast, scope, report)?;
    if found.kind != MetricKind::Flag || found.worst != Worst::Largest {
        let message =
            format!("`{}` is nothing that happens in a run or does not, and is bad", reference.name());
        report.push(
            Diagnostic::new(Code::BadGate, metric.span(), message)
                .label("cannot be new")
                .hint(format!("say `no new collision`, or `{} not worse`", reference.name())),
        );
        return None;
    }
    Some(GateRule {
        metric: Some(reference),
        rate: None,
        tolerance: Tolerance::NoneNew { where_none_was: false },
        primary,
        confidence: DEFAULT_CONFIDENCE,
        text: format!("{}no new {}", said_first(primary), syntax::metric_text(metric)),
        notation: None,
        origin: places.origin(node.span()),
    })
}

/// In percent it is relative; in the metric's own unit absolute, with the unit that it is written in.
fn tolerance(
    node: ast::Expression,
    metric: Option<&MetricKind>,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(Tolerance, Option<Notation>)> {
    let found = value::evaluate(node, scope, report)?;
    let what = "how much worse a metric may be";
    let dimension = match (metric, found.kind) {
        (Some(MetricKind::Quantity(dimension)), ValueKind::Number(found)) if found == *dimension => found,
        _ => Dimension::NUMBER,
    };
    let quantities = node.parts::<ast::Quantity>();
    let is_percentage = quantities.filter_map(ast::Quantity::unit).any(|unit| unit.text() == "%");
    let number = value::constant_in(node, dimension, (0.0, f64::MAX), what, scope, report)?;
    Some(if dimension == Dimension::NUMBER && (is_percentage || metric.is_none()) {
        (Tolerance::Relative(number), None)
    } else {
        (Tolerance::Absolute(number), found.notation)
    })
}
