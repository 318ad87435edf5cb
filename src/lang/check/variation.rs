//! `vary …`

use std::collections::HashMap;

use super::block::Layer;
use crate::lang::codes::Code;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::print;
use crate::lang::settings::{lone_word, repeated};
use crate::lang::source::Span;
use crate::lang::tree::{Node, Rule};
use crate::lang::units;
use crate::lang::value::{self, Binding, Kind, Scope, Typed};
use crate::scenario::{
    Dimension, Distribution, Samples, SamplingScheme, Value, Variation, VariedValue, significant,
};

/// What values can be drawn from.
pub const DISTRIBUTIONS: [&str; 4] = ["uniform", "normal", "truncated_normal", "choice"];

/// More values than this in one variation are taken for a mistake.
const MOST_VALUES: usize = 1_000_000;

/// One name with what it is varied over.
struct Varied<'t> {
    name: &'t str,
    span: Span,
    kind: Kind,
    over: Over,
}

enum Over {
    Values(Vec<VariedValue>),
    Distribution(Distribution),
}

/// Every variation of a scenario and the names they give to its values. A later layer's variation of a name replaces
/// the earlier ones.
pub fn variations(
    layers: &[Layer],
    report: &mut Vec<Diagnostic>,
) -> (Vec<Variation>, HashMap<String, Binding>) {
    let mut variations: Vec<Variation> = Vec::new();
    let mut bindings: HashMap<String, Binding> = HashMap::new();
    let mut together_with: HashMap<String, Vec<(String, Span)>> = HashMap::new();
    for layer in layers {
        let mut names: HashMap<&str, Span> = HashMap::new();
        let statements =
            layer.block.children().filter(|node| matches!(node.rule(), Rule::vary | Rule::vary_together));
        for node in statements {
            let (varied, variation) = match node.rule() {
                Rule::vary => single(node, layer.scope, report),
                _ => together(node, layer.scope, report),
            };
            for (name, span) in &varied_names(node) {
                if let Some(first) = names.insert(name, *span) {
                    report.push(repeated(name, *span, first));
                }
                variations.retain(|earlier| !varies(earlier, name));
                if let Some(others) = together_with.remove(*name) {
                    left_alone(layer.block, name, *span, &others, report);
                }
                // Poisoned unless the variation turns out well below.
                bindings.insert(name.to_string(), Binding::new(None, *span));
            }
            for (name, _) in &varied_names(node) {
                let others = varied_names(node).into_iter().filter(|(other, _)| other != name);
                together_with
                    .insert(name.to_string(), others.map(|(name, span)| (name.to_string(), span)).collect());
            }
            for varied in varied {
                let mut binding =
                    Binding::new(Some(Typed::variable(varied.name, varied.kind, varied.span)), varied.span);
                if let Over::Values(values) | Over::Distribution(Distribution::Choice(values)) = varied.over {
                    binding.varied = Some(values);
                }
                bindings.insert(varied.name.to_string(), binding);
            }
            variations.extend(variation);
        }
    }
    (variations, bindings)
}

/// Reports names that a layer leaves without values when it varies `name` anew, with which they were varied together.
fn left_alone(block: Node, name: &str, span: Span, others: &[(String, Span)], report: &mut Vec<Diagnostic>) {
    let anew: Vec<&str> = block
        .children()
        .filter(|node| matches!(node.rule(), Rule::vary | Rule::vary_together))
        .flat_map(varied_names)
        .map(|(name, _)| name)
        .collect();
    let alone: Vec<&(String, Span)> =
        others.iter().filter(|(other, _)| !anew.contains(&other.as_str())).collect();
    let Some((other, first)) = alone.first() else { return };
    report.push(
        Diagnostic::new(
            Code::UnknownVariation,
            span,
            format!("varying `{name}` anew leaves `{other}` without values: they are varied together"),
        )
        .label(format!("replaces `{other}` too"))
        .context(*first, "varied together here")
        .hint(format!("vary `{other}` anew too, with `{name}` in `vary together {{ … }}` or by itself")),
    );
}

fn varies(variation: &Variation, name: &str) -> bool {
    let (Variation::Grid { names, .. } | Variation::Sampled { names, .. }) = variation;
    names.iter().any(|varied| varied == name)
}

fn varied_names<'t>(node: Node<'t>) -> Vec<(&'t str, Span)> {
    let name = |node: Node<'t>| node.child(Rule::name).map(|name| (name.text(), name.span()));
    match node.child(Rule::together_block) {
        Some(block) => block.all(Rule::varied).filter_map(name).collect(),
        None => name(node).into_iter().collect(),
    }
}

type Outcome<'t> = (Vec<Varied<'t>>, Option<Variation>);

fn single<'t>(node: Node<'t>, scope: &Scope, report: &mut Vec<Diagnostic>) -> Outcome<'t> {
    let Some(varied) = varied(node, scope, report) else { return (Vec::new(), None) };
    let names = vec![varied.name.to_string()];
    let variation = match &varied.over {
        Over::Values(values) => {
            Some(Variation::Grid { names, rows: values.iter().map(|value| vec![value.clone()]).collect() })
        }
        Over::Distribution(distribution) => node
            .child(Rule::sampling)
            .and_then(|sampling| samples(sampling, vec![(distribution.clone(), varied.kind)], report))
            .map(|samples| Variation::Sampled { names, samples }),
    };
    (vec![varied], variation)
}

fn together<'t>(node: Node<'t>, scope: &Scope, report: &mut Vec<Diagnostic>) -> Outcome<'t> {
    let Some(block) = node.child(Rule::together_block) else { return (Vec::new(), None) };
    let lines: Vec<_> = block.all(Rule::varied).collect();
    let varied: Vec<_> = lines.iter().filter_map(|line| varied(*line, scope, report)).collect();
    if varied.len() != lines.len() || block.has(Rule::bad) {
        return (varied, None);
    }
    if varied.is_empty() {
        report.push(empty(block.span(), "`vary together` names nothing", "x in [1, 2]"));
        return (varied, None);
    }
    let names = varied.iter().map(|varied| varied.name.to_string()).collect();
    let sampling = node.child(Rule::sampling);
    let variation = match sampling {
        Some(sampling) => {
            let mut distributions = Vec::new();
            for one in &varied {
                match &one.over {
                    Over::Distribution(distribution) => distributions.push((distribution.clone(), one.kind)),
                    Over::Values(values) => {
                        distributions.push((Distribution::Choice(values.clone()), one.kind));
                    }
                }
            }
            samples(sampling, distributions, report).map(|samples| Variation::Sampled { names, samples })
        }
        None => rows(&varied, report).map(|rows| Variation::Grid { names, rows }),
    };
    (varied, variation)
}

/// The lists side by side, as rows.
fn rows(varied: &[Varied], report: &mut Vec<Diagnostic>) -> Option<Vec<Vec<VariedValue>>> {
    let mut columns = Vec::new();
    for one in varied {
        match &one.over {
            Over::Values(values) => columns.push(values),
            Over::Distribution(_) => {
                report.push(
                    Diagnostic::new(
                        Code::BadDistribution,
                        one.span,
                        format!("nothing says how often `{}` is drawn", one.name),
                    )
                    .label("a distribution")
                    .hint("write `vary together 100 times { … }`"),
                );
                return None;
            }
        }
    }
    let length = columns.first()?.len();
    if let Some(other) = columns.iter().position(|column| column.len() != length) {
        report.push(
            Diagnostic::new(
                Code::UnequalLists,
                varied[other].span,
                format!("`{}` and `{}` have different numbers of values", varied[0].name, varied[other].name),
            )
            .label(format!("{} values", columns[other].len()))
            .context(varied[0].span, format!("{length} values"))
            .hint("give each name as many values, or use two `vary` lines for every combination"),
        );
        return None;
    }
    Some((0..length).map(|row| columns.iter().map(|column| column[row].clone()).collect()).collect())
}

fn samples(
    node: Node,
    distributions: Vec<(Distribution, Kind)>,
    report: &mut Vec<Diagnostic>,
) -> Option<Samples> {
    let count =
        super::count(node.child(Rule::integer)?, 1, MOST_VALUES as u32, "the number of draws", report)?;
    let scheme = if node.has(Rule::kw_latin_hypercube) {
        SamplingScheme::LatinHypercube
    } else if node.has(Rule::kw_sobol) {
        SamplingScheme::Sobol
    } else {
        SamplingScheme::Random
    };
    let unit = |kind: &Kind| match kind {
        Kind::Number(dimension) => dimension.si_unit(),
        _ => String::new(),
    };
    let units = distributions.iter().map(|(_, kind)| unit(kind)).collect();
    let distributions = distributions.into_iter().map(|(distribution, _)| distribution).collect();
    Some(Samples { count, scheme, distributions, units })
}

fn varied<'t>(node: Node<'t>, scope: &Scope, report: &mut Vec<Diagnostic>) -> Option<Varied<'t>> {
    let name = node.child(Rule::name)?;
    let (kind, over) = if let Some(list) = node.child(Rule::list) {
        let (kind, values) = values(list.span(), list.all(Rule::expression), scope, report)?;
        (kind, Over::Values(values))
    } else if let Some(range) = node.child(Rule::range) {
        let (kind, values) = range_values(range, report)?;
        (kind, Over::Values(values))
    } else {
        let (kind, distribution) = distribution(node.child(Rule::distribution)?, scope, report)?;
        (kind, Over::Distribution(distribution))
    };
    Some(Varied { name: name.text(), span: name.span(), kind, over })
}

/// Constants of one kind, all different.
fn values<'t>(
    span: Span,
    expressions: impl Iterator<Item = Node<'t>>,
    scope: &Scope,
    report: &mut Vec<Diagnostic>,
) -> Option<(Kind, Vec<VariedValue>)> {
    let mut kind: Option<(Kind, Span)> = None;
    let mut values: Vec<VariedValue> = Vec::new();
    let mut said: HashMap<String, Span> = HashMap::new();
    let mut failed = false;
    for expression in expressions {
        let Some((typed, label)) = constant(expression, scope, report) else {
            failed = true;
            continue;
        };
        if let Some((first, place)) = kind {
            if !value::expect_kind(&typed, first, "this value of the list", report) {
                if let Some(diagnostic) = report.last_mut() {
                    *diagnostic = diagnostic.clone().context(place, format!("the first is {}", first.name()));
                }
                failed = true;
                continue;
            }
        } else {
            kind = Some((typed.kind, typed.span));
        }
        let crate::scenario::Expression::Constant(value) = typed.expression else { continue };
        if let Some(first) = said.insert(format!("{value:?}"), typed.span) {
            report.push(
                Diagnostic::new(Code::RepeatedValue, typed.span, format!("`{label}` is listed twice"))
                    .label("again")
                    .context(first, "first here")
                    .hint("list each value once; `repeat` runs all of them several times"),
            );
            failed = true;
        }
        values.push(VariedValue { value, label });
    }
    if failed {
        return None;
    }
    let Some((kind, _)) = kind else {
        report.push(empty(span, "this list has no values", "[6 s, 10 s]"));
        return None;
    };
    Some((kind, values))
}

fn empty(span: Span, message: &str, example: &str) -> Diagnostic {
    Diagnostic::new(Code::EmptyList, span, message)
        .label("empty")
        .hint(format!("list values, such as `{example}`"))
}

/// A value that does not vary, with the words it was written in. A name that is not defined is a word.
fn constant(expression: Node, scope: &Scope, report: &mut Vec<Diagnostic>) -> Option<(Typed, String)> {
    if let Some(word) = lone_word(expression)
        && scope.find(word).is_none()
    {
        return Some((Typed::word(word, expression.span()), word.to_string()));
    }
    let typed = value::evaluate(expression, scope, report)?;
    let label = match &typed.expression {
        crate::scenario::Expression::Constant(Value::Word(word)) => word.clone(),
        crate::scenario::Expression::Constant(_) => {
            expression.text().chars().filter(|c| !c.is_whitespace()).collect()
        }
        _ => return value::not_constant(typed.span, &typed.expression, "a varied value", report),
    };
    Some((typed, label))
}

/// `6 s .. 18 s step 4 s`: computed in the unit it is written in, so that values and labels are what people expect.
fn range_values(node: Node, report: &mut Vec<Diagnostic>) -> Option<(Kind, Vec<VariedValue>)> {
    let mut bad = |span: Span, message: &str| {
        report.push(
            Diagnostic::new(Code::BadDistribution, span, message)
                .label("in this range")
                .hint("write numbers of one unit: `6 s .. 18 s step 4 s`"),
        );
        None
    };
    let mut bounds = Vec::new();
    for expression in node.all(Rule::expression) {
        let Some((number, symbol)) = print::signed_quantity(expression) else {
            return bad(expression.span(), "a range is made of numbers");
        };
        bounds.push((number, symbol));
    }
    let [(first, unit), (last, last_unit), (step, step_unit)] = bounds.as_slice() else { return None };
    if unit != last_unit || unit != step_unit {
        return bad(node.span(), "the parts of a range have different units");
    }
    let converted = match unit.as_str() {
        "" => None,
        symbol => match units::unit_of(symbol) {
            Some(unit) => Some(unit),
            None => return bad(node.span(), &format!("there is no unit `{symbol}`")),
        },
    };
    if *step <= 0.0 || last < first {
        return bad(node.span(), "a range goes up from its first value in positive steps");
    }
    // A last value that rounding pushed a hair beyond the end still counts.
    let count = ((last - first) / step + 1e-9).floor();
    if count >= MOST_VALUES as f64 {
        report.push(
            Diagnostic::new(
                Code::TooManyValues,
                node.span(),
                format!("this range has more than {MOST_VALUES} values"),
            )
            .label("too many values")
            .hint("take larger steps"),
        );
        return None;
    }
    let kind = Kind::Number(converted.map_or(Dimension::NUMBER, |unit| unit.dimension));
    let values = (0..=count as usize)
        .map(|index| {
            let written = significant(first + index as f64 * step, 12);
            let number: f64 = written.parse().unwrap_or(*first);
            VariedValue {
                value: Value::Number(converted.map_or(number, |unit| unit.to_si(number))),
                label: format!("{written}{unit}"),
            }
        })
        .collect();
    Some((kind, values))
}

fn distribution(node: Node, scope: &Scope, report: &mut Vec<Diagnostic>) -> Option<(Kind, Distribution)> {
    let name = node.child(Rule::distribution_name)?;
    let count = node.all(Rule::expression).count();
    let mut bad = |message: String, hint: &str| {
        report.push(
            Diagnostic::new(Code::BadDistribution, node.span(), message)
                .label("cannot be drawn from")
                .hint(hint),
        );
        None
    };
    let wanted = match name.text() {
        "choice" => {
            let (kind, values) = values(node.span(), node.all(Rule::expression), scope, report)?;
            return Some((kind, Distribution::Choice(values)));
        }
        "uniform" => "low, high",
        "normal" => "mean, standard deviation",
        "truncated_normal" => "mean, standard deviation, low, high",
        unknown => {
            report.push(
                Diagnostic::new(
                    Code::BadDistribution,
                    name.span(),
                    format!("there is no distribution `{unknown}`"),
                )
                .label("unknown")
                .suggest(unknown, DISTRIBUTIONS),
            );
            return None;
        }
    };
    if count != wanted.split(", ").count() {
        let message = format!("`{}` takes {wanted}, but got {count} values", name.text());
        return bad(message, &format!("write `{}({wanted})`", name.text()));
    }
    let mut numbers = Vec::new();
    let mut kind = None;
    for expression in node.all(Rule::expression) {
        let typed = value::evaluate(expression, scope, report)?;
        let expected = *kind.get_or_insert(match typed.kind {
            Kind::Number(_) => typed.kind,
            _ => Kind::Number(Dimension::NUMBER),
        });
        if !value::expect_kind(&typed, expected, "this part of the distribution", report) {
            return None;
        }
        numbers.push(
            typed
                .as_constant_number()
                .or_else(|| value::not_constant(typed.span, &typed.expression, "a distribution", report))?,
        );
    }
    let mut bad = |message: &str, hint: &str| {
        report.push(
            Diagnostic::new(Code::BadDistribution, node.span(), message)
                .label("cannot be drawn from")
                .hint(hint),
        );
        None
    };
    let distribution = match *numbers.as_slice() {
        [low, high] if name.text() == "uniform" => {
            if low >= high {
                return bad("the low end is not below the high end", "write the smaller value first");
            }
            Distribution::Uniform { low, high }
        }
        [_, standard_deviation, ..] if standard_deviation <= 0.0 => {
            return bad("the standard deviation is not positive", "give a positive standard deviation");
        }
        [mean, standard_deviation] => Distribution::Normal { mean, standard_deviation },
        [mean, standard_deviation, low, high] => {
            if low >= high {
                return bad("the low end is not below the high end", "write the smaller value first");
            }
            Distribution::TruncatedNormal { mean, standard_deviation, low, high }
        }
        _ => return None,
    };
    Some((kind?, distribution))
}
