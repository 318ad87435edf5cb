//! `expect { … }`

use super::confidence::refuse_confidence;
use super::metric::{Cast, example, kind_name, metric_reference};
use super::places::TextPlaces;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings::{self, repeated};
use crate::syntax;
use crate::syntax::ast::{self, View};
use crate::value::{self, NameScope, ValueKind};
use scenario::{
    Aggregate, AggregateOf, AggregateWord, Claim, Comparison, Criterion, Dimension, Expression, MetricKind,
    People, Reach, Relation, Scope as Measured, Value, VariationCondition, WhenUndefined,
};

/// Where criteria come from: one of a suite leaves out scenarios that do not vary what its `when` is about.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum From {
    Scenario,
    Suite,
}

/// The criterion of a `criterion` node, one for each where it is about the runs of several people; `None` if it is wrong or, for a
/// suite's, not about this scenario.
pub fn criterion(
    node: ast::Criterion,
    from: From,
    cast: &Cast,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<Criterion>> {
    let before = report.len();
    let modifiers = modifiers(node, scope, report);
    let mut applies = true;
    let mut when = Vec::new();
    for condition in node.whens().flat_map(ast::When::conditions) {
        match when_condition(condition, from, scope, report) {
            Some(condition) => when.push(condition),
            None => applies = false,
        }
    }
    let claim = match node.aggregate_claim() {
        Some(claim) => aggregate_claim(claim, &modifiers, cast, scope, report),
        None => runs_claim(node.condition()?, &modifiers, cast, scope, report),
    };
    let people = whom(node, claim.as_ref(), cast, report);
    let text = syntax::criterion_text(node);
    if !places.files.overrides.is_empty() {
        set_aside(&mut report[before..]);
    }
    (report.len() == before && applies).then_some(())?;
    let reach = Reach { people, ..Reach::default() };
    Some(of_each(Criterion { claim: claim?, when, text, reach, origin: places.origin(node.span()) }, node))
}

/// What is said of the runs of several people is said of each of them.
fn of_each(said: Criterion, node: ast::Criterion) -> Vec<Criterion> {
    let about = said.claim.metric();
    let (Claim::Runs { .. }, false, Some(metric)) =
        (&said.claim, about.several.is_empty(), node.condition().map(ast::Condition::metric))
    else {
        return vec![said];
    };
    let written = syntax::metric_text(metric);
    let names_vehicle = about.known().is_some_and(|known| known.scope != Measured::Pedestrian);
    let one = |name: &String| {
        let mut one = said.clone();
        let about = one.claim.metric_mut();
        about.several.clear();
        about.pair.iter_mut().for_each(|(_, other)| other.clone_from(name));
        one.text = said.text.replacen(&written, &syntax::metric_text_of(metric, names_vehicle, name), 1);
        one
    };
    about.several.iter().map(one).collect()
}

/// Whom the criterion says that it speaks of.
fn whom(
    node: ast::Criterion,
    claim: Option<&Claim>,
    cast: &Cast,
    report: &mut Vec<Diagnostic>,
) -> Option<People> {
    let said = node.whom()?;
    let all = said.are_all();
    if claim.is_some_and(|claim| claim.confidence().is_none()) {
        report.push(
            Diagnostic::new(
                Code::BadPeople,
                said.span(),
                "without a confidence a criterion speaks of the runs that were done and of nobody else",
            )
            .label("has no meaning here")
            .hint("say how sure to be: `with 95 % confidence`, or leave it out"),
        );
        return None;
    }
    if cast.individuals.is_none() {
        report.push(
            Diagnostic::new(
                Code::BadPeople,
                said.span(),
                "nobody in this scenario is somebody from a population",
            )
            .label("which people?")
            .hint("take people from a population, `individuals 20 of standard`, or leave it out"),
        );
        return None;
    }
    if !all && cast.are_drawn {
        report.push(
            Diagnostic::new(
                Code::BadPeople,
                said.span(),
                "every run is of somebody else, so that there are no people to come back to",
            )
            .label("of which people?")
            .hint("say `of all people`, or take some: `individuals 20 of standard`"),
        );
        return None;
    }
    if all && cast.individuals == Some(false) {
        report.push(
            Diagnostic::new(Code::BadPeople, said.span(), "one person does not speak for all people")
                .label("only one walks")
                .hint("take more people, `individuals 20 of standard`, or say `of these people`"),
        );
        return None;
    }
    Some(if all { People::All } else { People::These })
}

/// What was set from outside may well be a value that a criterion says nothing about.
pub fn set_aside(findings: &mut [Diagnostic]) {
    for finding in findings.iter_mut().filter(|finding| finding.code == Code::NeverApplies) {
        (finding.code, finding.severity) = (Code::SetAside, Code::SetAside.severity());
        finding.hints = vec!["with other values it applies again".to_string()];
    }
}

struct Modifiers<'t> {
    share: Option<(ast::Share<'t>, Option<f64>)>,
    confidence: Option<(ast::Confidence<'t>, Option<f64>)>,
    undefined: WhenUndefined,
}

fn modifiers<'t>(node: ast::Criterion<'t>, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Modifiers<'t> {
    reject_twice::<ast::Share>(node, report);
    reject_twice::<ast::Undefined>(node, report);
    reject_twice::<ast::Confidence>(node, report);
    reject_twice::<ast::Whom>(node, report);
    reject_twice::<ast::When>(node, report);
    let mut part = |value, what: &str, open: bool| share(value, what, open, scope, report);
    let share = node.share().map(|said| (said, part(said.value(), "the share of runs", false)));
    let confidence = node.confidence().map(|said| (said, part(said.value(), "the confidence", true)));
    Modifiers { share, confidence, undefined: undefined(node.undefined()) }
}

fn reject_twice<'t, M: View<'t>>(node: ast::Criterion<'t>, report: &mut Vec<Diagnostic>) {
    let mut said = node.parts::<M>();
    if let (Some(first), Some(second)) = (said.next(), said.next()) {
        let word = first.text().split_whitespace().next().unwrap_or_default();
        let mut diagnostic = repeated(word, second.span(), first.span());
        diagnostic.code = Code::RepeatedModifier;
        report.push(diagnostic);
    }
}

pub fn undefined(said: Option<ast::Undefined>) -> WhenUndefined {
    match said {
        Some(undefined) if undefined.passes() => WhenUndefined::Passes,
        Some(_) => WhenUndefined::Fails,
        None => WhenUndefined::AsDeclared,
    }
}

/// A constant between 0 and 1 or, for a confidence, above 1/2 and below 1: at 1/2 a claim would pass by luck as often as
/// not, and below it bounds change sides.
pub fn share(
    node: ast::Expression,
    what: &str,
    confidence: bool,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<f64> {
    let value = value::quantity_of(node, Dimension::NUMBER, what, scope, report)?;
    let number = value
        .as_constant_number()
        .or_else(|| value::not_constant(value.span, &value.expression, what, report))?;
    let fits = if confidence { number > 0.5 && number < 1.0 } else { (0.0..=1.0).contains(&number) };
    if !fits {
        let least = if confidence { 50 } else { 0 };
        let diagnostic = Diagnostic::new(
            Code::BadShare,
            node.span(),
            format!("{what} is {} %, but must lie between {least} % and 100 %", number * 100.0),
        )
        .label("out of range");
        report.push(if number > 1.0 && number <= 100.0 {
            diagnostic.hint(format!("write `{number} %`"))
        } else {
            diagnostic.hint("write it in percent, such as `95 %`")
        });
        return None;
    }
    Some(number)
}

fn runs_claim(
    node: ast::Condition,
    modifiers: &Modifiers,
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Claim> {
    let comparison = comparison(node, modifiers.undefined, cast, scope, report);
    if let (None, Some((confidence, _))) = (&modifiers.share, &modifiers.confidence) {
        report.push(
            Diagnostic::new(
                Code::BadModifier,
                confidence.span(),
                "a claim about every run is true or false, without confidence",
            )
            .label("has no meaning here")
            .hint("say for what share of runs it holds: `in 80 % of runs with 95 % confidence`"),
        );
        return None;
    }
    Some(Claim::Runs {
        comparison: comparison?,
        share: match modifiers.share {
            Some((_, share)) => Some(share?),
            None => None,
        },
        confidence: match modifiers.confidence {
            Some((_, confidence)) => Some(confidence?),
            None => None,
        },
    })
}

fn aggregate_claim(
    node: ast::AggregateClaim,
    modifiers: &Modifiers,
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Claim> {
    if let Some((share, _)) = &modifiers.share {
        report.push(
            Diagnostic::new(
                Code::BadModifier,
                share.span(),
                "an aggregate is one number for all runs together",
            )
            .label("has no meaning here")
            .hint("remove the share, or compare the metric itself instead of an aggregate"),
        );
    }
    let (relation, bound) = (node.relation().meaning(), node.bound());
    let (aggregate, dimension, range) = aggregate(node.aggregate(), cast, scope, report)?;
    if let Some((confidence, _)) = &modifiers.confidence {
        refuse_confidence(*confidence, &aggregate, relation, report)?;
    }
    let what = format!("the bound of `{}`", aggregate_word(&aggregate));
    let bound = value::quantity_in(bound, dimension, range, &what, scope, report)?;
    Some(Claim::Aggregate {
        aggregate,
        relation,
        bound: bound.expression,
        when_undefined: modifiers.undefined,
        confidence: match modifiers.confidence {
            Some((_, confidence)) => Some(confidence?),
            None => None,
        },
    })
}

/// What a rate counts; what an undefined run is may also be said behind it.
pub fn condition_of_rate(
    node: ast::Rate,
    also: Option<ast::Undefined>,
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Comparison> {
    comparison(node.condition(), undefined(node.undefined().or(also)), cast, scope, report)
}

/// The aggregate with the dimension and range of what it can be compared to.
pub fn aggregate(
    node: ast::Aggregate,
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(Aggregate, Dimension, (f64, f64))> {
    let known = AggregateWord::find(node.word())?;
    if let (ast::Aggregate::Rate(rate), AggregateOf::Runs(of, largest)) = (node, known.of) {
        let when_undefined = undefined(rate.undefined());
        let comparison = comparison(rate.condition(), when_undefined, cast, scope, report)?;
        return Some((of(comparison), Dimension::NUMBER, (0.0, largest)));
    }
    let level = match node {
        ast::Aggregate::Quantile(quantile) => {
            Some(share(quantile.level(), "the level of a quantile", false, scope, report))
        }
        _ => None,
    };
    let metric_node = node.metric()?;
    let (reference, found) = metric_reference(metric_node, cast, scope, report)?;
    let MetricKind::Quantity(dimension) = found.kind else {
        report.push(
            Diagnostic::new(
                Code::NoNumber,
                metric_node.span(),
                format!(
                    "`{}` is {}, of which there is no such aggregate",
                    reference.name(),
                    kind_name(&found)
                ),
            )
            .label("not a quantity")
            .hint(format!("take the share of runs: `rate({} …)`", reference.name())),
        );
        return None;
    };
    let aggregate = match (known.of, level) {
        (AggregateOf::Values(of), _) => of(reference),
        (AggregateOf::Level(of), Some(level)) => of(level?, reference),
        _ => return None,
    };
    Some((aggregate, dimension, (f64::NEG_INFINITY, f64::INFINITY)))
}

fn aggregate_word(aggregate: &Aggregate) -> String {
    match aggregate {
        Aggregate::Rate(_) => "rate(…)".to_string(),
        Aggregate::Count(_) => "count(…)".to_string(),
        of_values => of_values.metric().name().to_string(),
    }
}

/// `no collision`, `gap_accepted`, `pet >= 1.5 s`, `passed_first = pedestrian`
pub fn comparison(
    node: ast::Condition,
    when_undefined: WhenUndefined,
    cast: &Cast,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Comparison> {
    let metric_node = node.metric();
    let (reference, found) = metric_reference(metric_node, cast, scope, report)?;
    let name = reference.name().to_string();
    let done = |relation, bound| Some(Comparison { metric: reference, relation, bound, when_undefined });
    if node.is_negative() {
        if found.kind != MetricKind::Flag {
            report.push(
                Diagnostic::new(
                    Code::BadNo,
                    node.span(),
                    format!("`no` needs something true or false, but `{name}` is {}", kind_name(&found)),
                )
                .label("not true or false")
                .hint(format!("compare it: `{name} >= …`")),
            );
            return None;
        }
        return done(Relation::Equal, Expression::number(0.0));
    }
    let (Some(relation_node), Some(bound)) = (node.relation(), node.bound()) else {
        if found.kind != MetricKind::Flag {
            report.push(
                Diagnostic::new(
                    Code::MissingComparison,
                    metric_node.span(),
                    format!("`{name}` is {} and must be compared to something", kind_name(&found)),
                )
                .label("compared to nothing")
                .hint(example(&found)),
            );
            return None;
        }
        return done(Relation::Equal, Expression::number(1.0));
    };
    let relation = relation_node.meaning();
    let what = format!("the bound of `{name}`");
    let ordered = matches!(found.kind, MetricKind::Quantity(_));
    if !ordered && !matches!(relation, Relation::Equal | Relation::NotEqual) {
        report.push(
            Diagnostic::new(
                Code::NoOrder,
                relation_node.span(),
                format!("`{name}` is {}, which has no order", kind_name(&found)),
            )
            .label("neither smaller nor larger")
            .hint("compare it by `=` or `!=`"),
        );
        return None;
    }
    match &found.kind {
        MetricKind::Quantity(dimension) => {
            done(relation, value::quantity_of(bound, *dimension, &what, scope, report)?.expression)
        }
        MetricKind::Flag => {
            let value = value::evaluate(bound, scope, report)?;
            if !value::expect_kind(&value, ValueKind::Flag, &what, report) {
                return None;
            }
            let Expression::Constant(Value::Flag(flag)) = value.expression else {
                return value::not_constant(value.span, &value.expression, &what, report);
            };
            done(relation, Expression::number(f64::from(u8::from(flag))))
        }
        MetricKind::Category(words) => {
            let before = report.len();
            let options: Vec<&str> = words.iter().map(|word| &**word).collect();
            let Some(chosen) = settings::choice(bound, &what, &options, scope, report) else {
                for diagnostic in &mut report[before..] {
                    if diagnostic.code == Code::UnknownOption {
                        diagnostic.code = Code::UnknownWord;
                    }
                }
                return None;
            };
            let Expression::Constant(Value::Word(word)) = chosen else {
                return value::not_constant(bound.span(), &chosen, &what, report);
            };
            let index = words.iter().position(|known| *known == word)?;
            done(relation, Expression::number(index as f64))
        }
    }
}

/// A condition on a variation; `None` also where a suite's criterion is not about this scenario.
pub fn when_condition(
    node: ast::WhenCondition,
    from: From,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<VariationCondition> {
    let name = node.name();
    let binding = scope.find(name.text()).filter(|binding| match &binding.value {
        Some(value) => matches!(&value.expression, Expression::Variable(variable) if variable == name.text()),
        None => true,
    });
    let Some(binding) = binding else {
        if from == From::Scenario {
            let varied = scope.all_names().into_iter().filter(|known| {
                scope.find(known).and_then(|binding| binding.value.as_ref()).is_some_and(
                    |value| matches!(&value.expression, Expression::Variable(variable) if variable == known),
                )
            });
            report.push(
                Diagnostic::new(
                    Code::UnknownVariation,
                    name.span(),
                    format!("the scenario does not vary `{}`", name.text()),
                )
                .label("not varied")
                .suggest(name.text(), varied),
            );
        }
        return None;
    };
    let kind = binding.value.as_ref()?.kind;
    let relation_node = node.relation();
    let relation = relation_node.meaning();
    let bound_node = node.bound();
    let what = format!("`{}`", name.text());
    let bound = match (kind, bound_node.lone_word()) {
        (ValueKind::Word, Some(word)) if scope.find(word).is_none() => {
            Expression::Constant(Value::Word(word.to_string()))
        }
        _ => {
            let value = value::evaluate(bound_node, scope, report)?;
            if !value::expect_kind(&value, kind, &what, report) {
                return None;
            }
            value.expression
        }
    };
    if !matches!(kind, ValueKind::Number(_)) && !matches!(relation, Relation::Equal | Relation::NotEqual) {
        report.push(
            Diagnostic::new(
                Code::NoOrder,
                relation_node.span(),
                format!("{what} is {}, which has no order", kind.name()),
            )
            .label("neither smaller nor larger")
            .hint("compare it by `=` or `!=`"),
        );
        return None;
    }
    if let (Some(values), Expression::Constant(bound)) = (&binding.varied, &bound)
        && !values.iter().any(|varied| holds(relation, &varied.value, bound))
    {
        if from == From::Scenario {
            let labels: Vec<_> = values.iter().take(12).map(|varied| varied.label.as_str()).collect();
            report.push(
                Diagnostic::new(Code::NeverApplies, node.span(), "this holds for none of the runs")
                    .label("never true")
                    .context(binding.span, format!("takes {}", labels.join(", ")))
                    .hint("compare to one of the values, or remove the criterion"),
            );
        }
        return None;
    }
    Some(VariationCondition { variable: name.text().to_string(), relation, bound })
}

fn holds(relation: Relation, value: &Value, bound: &Value) -> bool {
    match (value, bound) {
        (Value::Number(value), Value::Number(bound)) => relation.holds(*value, *bound),
        _ => match relation {
            Relation::Equal => value == bound,
            Relation::NotEqual => value != bound,
            _ => false,
        },
    }
}
