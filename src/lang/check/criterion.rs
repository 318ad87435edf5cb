//! `expect { … }`

use std::sync::Arc;

use super::Places;
use super::confidence::refuse_confidence;
use super::pedestrian::unknown_vehicle;
use super::road::constants;
use crate::lang::codes::Code;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::print;
use crate::lang::settings::{self, lone_word, repeated};
use crate::lang::tree::{Node, Rule};
use crate::lang::value::{self, Kind, Scope};
use crate::registry::Table;
use crate::scenario::{
    Aggregate, Claim, Comparison, Criterion, Dimension, Expression, Metric, MetricKind, MetricReference,
    People, Reach, Relation, Scope as Measured, Value, VariationCondition, WhenUndefined,
};

/// The words for what sums up runs, with what each is.
pub const AGGREGATES: [(&str, &str); 8] = [
    ("mean", "The mean over runs."),
    ("median", "The median over runs."),
    ("min", "The smallest of all runs."),
    ("max", "The largest of all runs."),
    ("std", "The standard deviation over runs."),
    ("quantile", "`quantile(95 %, pet)`: what that share of runs stays below."),
    ("rate", "The share of runs in which something holds."),
    ("count", "The number of runs in which something holds."),
];

/// Who is in the scenario that a criterion is about.
pub struct Cast<'a> {
    pub vehicles: Vec<&'a str>,
    pub pedestrians: Vec<&'a str>,
    /// Of the road.
    pub boxes: Vec<&'a str>,
    /// Whether people are taken from a population, and if so whether there are several.
    pub individuals: Option<bool>,
    /// What can be measured.
    pub metrics: &'a Table<Metric>,
}

/// Where criteria come from: one of a suite leaves out scenarios that do not vary what its `when` is about.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum From {
    Scenario,
    Suite,
}

/// The criterion of a `criterion` node; `None` if it is wrong or, for a suite's, not about this scenario.
pub fn criterion(
    node: Node,
    from: From,
    cast: &Cast,
    scope: &Scope,
    places: &Places,
    report: &mut Vec<Diagnostic>,
) -> Option<Criterion> {
    let before = report.len();
    let modifiers = modifiers(node, scope, report);
    let mut applies = true;
    let mut when = Vec::new();
    for condition in node.all(Rule::when).flat_map(|when| when.all(Rule::when_condition)) {
        match when_condition(condition, from, scope, report) {
            Some(condition) => when.push(condition),
            None => applies = false,
        }
    }
    let claim = match node.child(Rule::aggregate_claim) {
        Some(claim) => aggregate_claim(claim, &modifiers, cast, scope, report),
        None => runs_claim(node.child(Rule::condition)?, &modifiers, cast, scope, report),
    };
    let people = whom(node, claim.as_ref(), cast, report);
    let text = text(node);
    if !places.files.overrides.is_empty() {
        set_aside(&mut report[before..]);
    }
    (report.len() == before && applies).then_some(())?;
    let reach = Reach { people, limits: None };
    Some(Criterion { claim: claim?, when, text, reach, origin: places.origin(node.span()) })
}

/// Whom the criterion says that it speaks of.
fn whom(node: Node, claim: Option<&Claim>, cast: &Cast, report: &mut Vec<Diagnostic>) -> Option<People> {
    let said = node.child(Rule::whom)?;
    let all = said.has(Rule::kw_all);
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
    share: Option<(Node<'t>, Option<f64>)>,
    confidence: Option<(Node<'t>, Option<f64>)>,
    undefined: WhenUndefined,
}

fn modifiers<'t>(node: Node<'t>, scope: &Scope, report: &mut Vec<Diagnostic>) -> Modifiers<'t> {
    for rule in [Rule::share, Rule::undefined, Rule::confidence, Rule::whom, Rule::when] {
        let mut said = node.all(rule);
        if let (Some(first), Some(second)) = (said.next(), said.next()) {
            let word = first.text().split_whitespace().next().unwrap_or_default();
            let mut diagnostic = repeated(word, second.span(), first.span());
            diagnostic.code = Code::RepeatedModifier;
            report.push(diagnostic);
        }
    }
    let mut part = |rule, what: &str, open: bool| {
        let node = node.child(rule)?;
        let value =
            node.child(Rule::expression).and_then(|expression| share(expression, what, open, scope, report));
        Some((node, value))
    };
    let share = part(Rule::share, "the share of runs", false);
    let confidence = part(Rule::confidence, "the confidence", true);
    Modifiers { share, confidence, undefined: undefined(node) }
}

pub fn undefined(node: Node) -> WhenUndefined {
    match node.child(Rule::undefined) {
        Some(undefined) if undefined.has(Rule::kw_passes) => WhenUndefined::Passes,
        Some(_) => WhenUndefined::Fails,
        None => WhenUndefined::AsDeclared,
    }
}

/// A constant between 0 and 1 or, for a confidence, above 1/2 and below 1: at 1/2 a claim would pass by luck as often as
/// not, and below it bounds change sides.
pub fn share(
    node: Node,
    what: &str,
    confidence: bool,
    scope: &Scope,
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
    node: Node,
    modifiers: &Modifiers,
    cast: &Cast,
    scope: &Scope,
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
    node: Node,
    modifiers: &Modifiers,
    cast: &Cast,
    scope: &Scope,
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
    let relation = relation(node.child(Rule::relation)?);
    let bound = node.child(Rule::expression)?;
    let (aggregate, dimension, range) = aggregate(node, cast, scope, report)?;
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

/// The aggregate below a node, with the dimension and range of what it can be compared to.
pub fn aggregate(
    node: Node,
    cast: &Cast,
    scope: &Scope,
    report: &mut Vec<Diagnostic>,
) -> Option<(Aggregate, Dimension, (f64, f64))> {
    if let Some(rate) = node.child(Rule::rate) {
        let comparison = comparison(rate.child(Rule::condition)?, undefined(rate), cast, scope, report)?;
        return Some(if rate.has(Rule::kw_rate) {
            (Aggregate::Rate(comparison), Dimension::NUMBER, (0.0, 1.0))
        } else {
            (Aggregate::Count(comparison), Dimension::NUMBER, (0.0, 1e9))
        });
    }
    let (of, level) = match node.child(Rule::quantile) {
        Some(quantile) => {
            let level =
                share(quantile.child(Rule::expression)?, "the level of a quantile", false, scope, report);
            (quantile, Some(level))
        }
        None => (node.child(Rule::statistic)?, None),
    };
    let metric_node = of.child(Rule::metric)?;
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
    let statistic = of.child(Rule::statistic_name).map_or("", Node::text);
    let aggregate = match (level, statistic) {
        (Some(level), _) => Aggregate::Quantile(level?, reference),
        (_, "mean") => Aggregate::Mean(reference),
        (_, "median") => Aggregate::Median(reference),
        (_, "min") => Aggregate::Min(reference),
        (_, "max") => Aggregate::Max(reference),
        _ => Aggregate::Std(reference),
    };
    Some((aggregate, dimension, (f64::NEG_INFINITY, f64::INFINITY)))
}

fn aggregate_word(aggregate: &Aggregate) -> String {
    match aggregate {
        Aggregate::Rate(_) => "rate(…)".to_string(),
        Aggregate::Count(_) => "count(…)".to_string(),
        Aggregate::Mean(metric)
        | Aggregate::Median(metric)
        | Aggregate::Min(metric)
        | Aggregate::Max(metric)
        | Aggregate::Std(metric)
        | Aggregate::Quantile(_, metric) => metric.name().to_string(),
    }
}

/// `no collision`, `gap_accepted`, `pet >= 1.5 s`, `passed_first = pedestrian`
pub fn comparison(
    node: Node,
    when_undefined: WhenUndefined,
    cast: &Cast,
    scope: &Scope,
    report: &mut Vec<Diagnostic>,
) -> Option<Comparison> {
    let metric_node = node.child(Rule::metric)?;
    let (reference, found) = metric_reference(metric_node, cast, scope, report)?;
    let name = reference.name().to_string();
    let done = |relation, bound| Some(Comparison { metric: reference, relation, bound, when_undefined });
    if node.has(Rule::kw_no) {
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
    let (Some(relation_node), Some(bound)) = (node.child(Rule::relation), node.child(Rule::expression))
    else {
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
    let relation = relation(relation_node);
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
            if !value::expect_kind(&value, Kind::Flag, &what, report) {
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

pub fn kind_name(metric: &Metric) -> String {
    match &metric.kind {
        MetricKind::Quantity(dimension) => Kind::Number(*dimension).name(),
        MetricKind::Flag => "true or false".to_string(),
        MetricKind::Category(words) => {
            format!("one of {}", words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", "))
        }
    }
}

fn example(metric: &Metric) -> String {
    let name = &metric.declaration.name;
    match &metric.kind {
        MetricKind::Quantity(dimension) => {
            let bound = format!("{name} >= 1.5 {}", dimension.si_unit());
            format!("such as `{}`", bound.trim_end())
        }
        MetricKind::Flag => format!("such as `no {name}`"),
        MetricKind::Category(words) => {
            format!("such as `{name} = {}`", words.first().map_or("…", |word| &**word))
        }
    }
}

/// A metric with the road users it is for.
pub fn metric_reference(
    node: Node,
    cast: &Cast,
    scope: &Scope,
    report: &mut Vec<Diagnostic>,
) -> Option<(MetricReference, Arc<Metric>)> {
    let name = node.child(Rule::name)?;
    let Some(found) = cast.metrics.get(name.text()) else {
        let message = format!("there is no metric `{}`", name.text());
        let diagnostic = Diagnostic::new(Code::UnknownMetric, name.span(), message).label("unknown metric");
        report.push(match AGGREGATES.iter().any(|(word, _)| *word == name.text()) {
            true => {
                diagnostic.hint("this is about single runs: compare a metric itself, such as `pet < 1.5 s`")
            }
            false => diagnostic.suggest(name.text(), cast.metrics.names()),
        });
        return None;
    };
    let details = node.child(Rule::metric_details);
    let settings = constants(details, &found.declaration, scope, report);
    let pair = match details {
        Some(details) => pair(details, found, cast, report)?,
        None => None,
    };
    Some((MetricReference { metric: found.into(), settings: settings?, pair }, found.clone()))
}

/// The pair that is meant. A metric of one road user has a value with the first of the other kind; contacts of one
/// vehicle, with whatever it touches, have no second name.
fn pair(
    details: Node,
    metric: &Metric,
    cast: &Cast,
    report: &mut Vec<Diagnostic>,
) -> Option<Option<(String, String)>> {
    let names: Vec<_> = details.all(Rule::name).collect();
    if names.is_empty() {
        return Some(None);
    }
    let mut known = |name: Node, is_vehicle: bool| {
        let known = if is_vehicle { &cast.vehicles } else { &cast.pedestrians };
        if known.contains(&name.text()) {
            return Some(name.text().to_string());
        }
        report.push(if is_vehicle {
            unknown_vehicle(name, known)
        } else {
            Diagnostic::new(
                Code::UnknownPedestrian,
                name.span(),
                format!("the scenario has no pedestrian `{}`", name.text()),
            )
            .label("unknown pedestrian")
            .suggest(name.text(), known.iter().copied())
        });
        None
    };
    if let ([vehicle, others @ ..], Measured::Contact) = (names.as_slice(), metric.scope)
        && others.len() <= 1
    {
        let vehicle = known(*vehicle, true)?;
        let Some(other) = others.first() else { return Some(Some((vehicle, String::new()))) };
        return Some(Some((vehicle.clone(), solid(*other, &vehicle, cast, report)?)));
    }
    let first = |names: &[&str]| names.first().map(|name| name.to_string());
    let pair = match (names.as_slice(), metric.scope) {
        ([vehicle, pedestrian], Measured::Pair) => {
            let (vehicle, pedestrian) = (known(*vehicle, true), known(*pedestrian, false));
            (vehicle?, pedestrian?)
        }
        ([vehicle], Measured::Vehicle) => (known(*vehicle, true)?, first(&cast.pedestrians)?),
        ([pedestrian], Measured::Pedestrian) => {
            let pedestrian = known(*pedestrian, false)?;
            (first(&cast.vehicles)?, pedestrian)
        }
        _ => {
            let name = &metric.declaration.name;
            let (whom, example) = match metric.scope {
                Measured::Pair => ("a vehicle and a pedestrian", format!("{name}(av, walker)")),
                Measured::Contact => ("a vehicle and what it touches", format!("{name}(av, walker)")),
                Measured::Vehicle => ("a vehicle", format!("{name}(av)")),
                Measured::Pedestrian => ("a pedestrian", format!("{name}(walker)")),
            };
            report.push(
                Diagnostic::new(Code::BadPair, details.span(), format!("`{name}` is measured for {whom}"))
                    .label(format!("{} named here", names.len()))
                    .hint(format!("write `{example}`")),
            );
            return None;
        }
    };
    Some(Some(pair))
}

/// Anything but `vehicle` that it may touch.
fn solid(name: Node, vehicle: &str, cast: &Cast, report: &mut Vec<Diagnostic>) -> Option<String> {
    let all = cast.pedestrians.iter().chain(&cast.vehicles).chain(&cast.boxes).copied();
    if name.text() == vehicle {
        report.push(
            Diagnostic::new(Code::TouchesItself, name.span(), format!("`{vehicle}` never touches itself"))
                .label("the same vehicle")
                .hint("name a pedestrian, another vehicle or a box of the road; or nothing, for whatever it touches"),
        );
        return None;
    }
    if all.clone().any(|known| known == name.text()) {
        return Some(name.text().to_string());
    }
    report.push(
        Diagnostic::new(
            Code::UnknownSolid,
            name.span(),
            format!("the scenario has no pedestrian, vehicle or box `{}`", name.text()),
        )
        .label("nothing of this name")
        .suggest(name.text(), all.filter(|known| *known != vehicle)),
    );
    None
}

pub fn relation(node: Node) -> Relation {
    match node.text() {
        "<" => Relation::Less,
        "<=" | "≤" => Relation::LessOrEqual,
        ">" => Relation::Greater,
        ">=" | "≥" => Relation::GreaterOrEqual,
        "!=" | "≠" => Relation::NotEqual,
        _ => Relation::Equal,
    }
}

/// A condition on a variation; `None` also where a suite's criterion is not about this scenario.
pub fn when_condition(
    node: Node,
    from: From,
    scope: &Scope,
    report: &mut Vec<Diagnostic>,
) -> Option<VariationCondition> {
    let name = node.child(Rule::name)?;
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
    let relation_node = node.child(Rule::relation)?;
    let relation = relation(relation_node);
    let bound_node = node.child(Rule::expression).or_else(|| node.child(Rule::lone_operand))?;
    let what = format!("`{}`", name.text());
    let bound = match (kind, lone_word(bound_node)) {
        (Kind::Word, Some(word)) if scope.find(word).is_none() => {
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
    if !matches!(kind, Kind::Number(_)) && !matches!(relation, Relation::Equal | Relation::NotEqual) {
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

/// The criterion in its one spelling.
pub fn text(node: Node) -> String {
    let mut text = match node.child(Rule::aggregate_claim) {
        Some(claim) => claim.children().next().map_or(String::new(), aggregate_text) + &bound_text(claim),
        None => node.child(Rule::condition).map_or(String::new(), condition_text),
    };
    if let Some(share) = node.child(Rule::share).and_then(|share| share.child(Rule::expression)) {
        text += &format!(" in {} of runs", print::expression(share));
    }
    text += &undefined_text(node);
    if let Some(confidence) = node.child(Rule::confidence).and_then(|node| node.child(Rule::expression)) {
        text += &format!(" with {} confidence", print::expression(confidence));
    }
    if let Some(whom) = node.child(Rule::whom) {
        text += if whom.has(Rule::kw_all) { " of all people" } else { " of these people" };
    }
    let conditions: Vec<_> = node
        .all(Rule::when)
        .flat_map(|when| when.all(Rule::when_condition))
        .map(|condition| {
            condition.child(Rule::name).map_or("", Node::text).to_string() + &bound_text(condition)
        })
        .collect();
    if !conditions.is_empty() {
        text += &format!(" when {}", conditions.join(" and "));
    }
    text
}

/// A `rate`, `quantile` or `statistic` in its one spelling.
pub fn aggregate_text(of: Node) -> String {
    let name = of.text().split('(').next().unwrap_or_default().trim();
    let level = of.child(Rule::expression).map(|level| format!("{}, ", print::expression(level)));
    let inside = match of.child(Rule::condition) {
        Some(condition) => condition_text(condition) + &undefined_text(of),
        None => of.child(Rule::metric).map_or(String::new(), metric_text),
    };
    format!("{name}({}{inside})", level.unwrap_or_default())
}

fn condition_text(node: Node) -> String {
    let no = if node.has(Rule::kw_no) { "no " } else { "" };
    let metric = node.child(Rule::metric).map_or(String::new(), metric_text);
    format!("{no}{metric}{}", bound_text(node))
}

fn undefined_text(node: Node) -> String {
    match node.child(Rule::undefined) {
        Some(undefined) if undefined.has(Rule::kw_passes) => " undefined passes".to_string(),
        Some(_) => " undefined fails".to_string(),
        None => String::new(),
    }
}

fn bound_text(node: Node) -> String {
    match (node.child(Rule::relation), node.child(Rule::expression)) {
        (Some(relation_node), Some(bound)) => {
            format!(" {} {}", relation(relation_node).symbol(), print::expression(bound))
        }
        _ => String::new(),
    }
}

pub fn metric_text(node: Node) -> String {
    let name = node.child(Rule::name).map_or("", Node::text);
    let Some(details) = node.child(Rule::metric_details) else { return name.to_string() };
    let inside: Vec<_> = details
        .children()
        .map(|part| match (part.child(Rule::setting_name), part.child(Rule::expression)) {
            (Some(setting), Some(value)) => format!("{}: {}", setting.text(), print::expression(value)),
            _ => part.text().to_string(),
        })
        .collect();
    format!("{name}({})", inside.join(", "))
}
