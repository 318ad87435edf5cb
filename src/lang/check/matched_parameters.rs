//! `match mean of …`, `match deviation of …`: what is known of how a parameter is distributed among people.

use std::collections::HashMap;

use super::subject::StatementSubject;
use super::target::{Takes, reject_unmeant, target};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings::repeated;
use crate::source::Span;
use crate::syntax::ast;
use crate::syntax::phrase;
use crate::value::{NameScope, written_constant};
use scenario::{
    DeclaredPedestrian, Dimension, MatchedParameter, ParameterKind, ParameterStatistic, Part, Target,
};

/// What the statements say of the parameters of `weighed`, a pedestrian of `subject` who the candidates are; means first, each followed by
/// its deviation.
pub fn matched_parameters(
    block: ast::CalibrateBlock,
    subject: &StatementSubject,
    weighed: &DeclaredPedestrian,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<MatchedParameter>> {
    let (mut means, mut deviations) = (Vec::new(), Vec::new());
    let mut said: HashMap<String, Span> = HashMap::new();
    let mut wrong = false;
    for node in block.parameters() {
        let what =
            format!("{} of {}", if node.is_mean() { "mean" } else { "deviation" }, phrase(*node.target()));
        if let Some(first) = said.insert(what.clone(), node.span()) {
            report.push(repeated(&what, node.span(), first));
        }
        match one(node, &what, subject, weighed, scope, report) {
            Some(found) if node.is_mean() => means.push(found),
            Some(found) => deviations.push((node, found)),
            None => wrong = true,
        }
    }
    let mut found = Vec::new();
    for (node, deviation) in &deviations {
        if !wrong && !means.iter().any(|mean| mean.parameter == deviation.parameter) {
            let (target, unit) = (phrase(*node.target()), &deviation.unit);
            report.push(
                Diagnostic::new(
                    Code::MissingStatement,
                    node.span(),
                    format!("a deviation of `{target}`, whose mean is not matched"),
                )
                .label("from which mean")
                .hint(format!("say `match mean of {target} to … {unit} within … {unit}` as well")),
            );
            wrong = true;
        }
    }
    for mean in means {
        let centre = mean.value;
        let own = deviations.iter().map(|(_, one)| one).filter(|one| one.parameter == mean.parameter);
        let own = own.map(|one| MatchedParameter {
            statistic: ParameterStatistic::DeviationFrom(centre),
            ..one.clone()
        });
        let own: Vec<_> = own.collect();
        found.push(mean);
        found.extend(own);
    }
    (!wrong).then_some(found)
}

/// One statement; of a deviation the mean is not known yet.
fn one(
    node: ast::MatchedParameter,
    what: &str,
    subject: &StatementSubject,
    weighed: &DeclaredPedestrian,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<MatchedParameter> {
    let (target, takes) = target(node.target(), subject, report)?;
    let no_parameter = |message: String| {
        Diagnostic::new(Code::BadCandidates, node.target().span(), message)
            .label("no parameter of who is weighed")
    };
    let (Target::Setting { road_user, part: Part::Model, parameter }, Takes::Parameter(declaration, _)) =
        (&target, &takes)
    else {
        report.push(
            no_parameter(format!("`{target}` is no parameter of a pedestrian"))
                .hint(format!("write it like `{}.model.PARAMETER`", weighed.name)),
        );
        return None;
    };
    if !weighed.is(road_user) {
        report.push(
            no_parameter(format!("`{road_user}` is not who is weighed in `{}`", subject.scenario.name))
                .hint(format!("the candidates are `{0}`: write `{0}.model.{parameter}`", weighed.name)),
        );
        return None;
    }
    reject_unmeant(node.target(), &target, &takes, subject.scenario, "is matched", report)?;
    let (dimension, (low, high)) = match declaration.parameter(parameter).map(|found| &found.kind) {
        Some(ParameterKind::Number { dimension, range, .. }) => (*dimension, *range),
        Some(ParameterKind::Whole { range: (low, high), .. }) => {
            (Dimension::NUMBER, (*low as f64, *high as f64))
        }
        _ => {
            report.push(
                no_parameter(format!("`{target}` is no number, so that it has no mean"))
                    .hint("match a parameter that is a quantity; `scenario-runner models` lists them"),
            );
            return None;
        }
    };
    let width = high - low;
    let mut bounds = node.bounds();
    let (value_node, within_node) = (bounds.next()?, bounds.next()?);
    let range = if node.is_mean() { (low, high) } else { (0.0, width) };
    let value = written_constant(value_node, dimension, range, &format!("the {what}"), scope, report);
    let within = format!("how far the {what} may be away");
    let (within, _) = written_constant(within_node, dimension, (0.0, width), &within, scope, report)?;
    if within <= 0.0 {
        report.push(
            Diagnostic::new(Code::OutOfRange, within_node.span(), "a tolerance of nothing")
                .label("must be above 0")
                .hint("say how well it is known; a hundredth of the value is close"),
        );
        return None;
    }
    let (value, _) = value?;
    Some(MatchedParameter {
        parameter: parameter.clone(),
        statistic: ParameterStatistic::Mean,
        value,
        within,
        unit: dimension.si_unit(),
    })
}
