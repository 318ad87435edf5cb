//! `vary …`

use std::collections::HashMap;

use super::block::Layer;
use super::literal;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings::repeated;
use crate::source::Span;
use crate::syntax::ast;
use crate::units;
use crate::value::{self, Binding, NameScope, Typed, ValueKind};
use scenario::{
    DISTRIBUTIONS, Dimension, Distribution, DistributionError, DistributionOf, DistributionWord, Notation,
    Samples, SamplingScheme, Value, Variation, VariedValue, significant,
};

/// More values than this in one variation are taken for a mistake.
const MOST_VALUES: usize = 1_000_000;

/// One name with what it is varied over.
struct Varied<'t> {
    name: &'t str,
    span: Span,
    kind: ValueKind,
    notation: Option<Notation>,
    over: Over,
}

impl Varied<'_> {
    fn typed(&self) -> Typed {
        Typed::variable(self.name, self.kind, self.notation, self.span)
    }
}

/// The kind of a variation's values, and their unit.
#[derive(Clone, Copy)]
struct Written {
    kind: ValueKind,
    notation: Option<Notation>,
}

impl Written {
    fn of(typed: &Typed) -> Self {
        Self { kind: typed.kind, notation: typed.notation }
    }
}

enum Over {
    Values(Vec<VariedValue>),
    Distribution(Distribution),
}

/// Every variation of a scenario and the names they give to its values. A later layer's variation of a name replaces
/// the earlier ones.
pub fn variations(
    layers: &[Layer<ast::ScenarioBlock>],
    report: &mut Vec<Diagnostic>,
) -> (Vec<Variation>, HashMap<String, Binding>) {
    let mut variations: Vec<Variation> = Vec::new();
    let mut bindings: HashMap<String, Binding> = HashMap::new();
    let mut together_with: HashMap<String, Vec<(String, Span)>> = HashMap::new();
    for layer in layers {
        let mut names: HashMap<&str, Span> = HashMap::new();
        for node in layer.block.variations() {
            let before = report.len();
            let own = varied_names(node);
            let is_other = |(name, _): &(&String, &Binding)| !own.iter().any(|(own, _)| own == name);
            let known: HashMap<String, Binding> =
                bindings.iter().filter(is_other).map(|(name, one)| (name.clone(), one.clone())).collect();
            let (varied, variation) = match node {
                ast::Variation::Varied(node) => single(node, layer.scope, &known, report),
                ast::Variation::VaryTogether(node) => together(node, layer.scope, known.clone(), report),
            };
            say_why_unknown(&mut report[before..], layer, &known, layers);
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
                let mut binding = Binding::new(Some(varied.typed()), varied.span);
                binding.varied = match varied.over {
                    Over::Values(values) => Some(values),
                    Over::Distribution(distribution) => distribution.options().map(<[_]>::to_vec),
                };
                bindings.insert(varied.name.to_string(), binding);
            }
            variations.extend(variation);
        }
    }
    (in_order(variations, &bindings, report), bindings)
}

/// What a variation depends on stands before it. A layer may have varied that anew, and so moved it behind.
fn in_order(
    mut variations: Vec<Variation>,
    bindings: &HashMap<String, Binding>,
    report: &mut Vec<Diagnostic>,
) -> Vec<Variation> {
    let mut ordered: Vec<Variation> = Vec::new();
    while !variations.is_empty() {
        let is_ready = |variation: &Variation| {
            let others = variations.iter().filter(|other| other.names() != variation.names());
            !others.flat_map(Variation::names).any(|name| variation.depends_on().contains(&name.as_str()))
        };
        let Some(ready) = variations.iter().position(is_ready) else {
            let names: Vec<_> = variations.iter().flat_map(Variation::names).collect();
            // The one that closes the circle was said last.
            let spans = names.iter().filter_map(|name| bindings.get(*name)).map(|binding| binding.span);
            let span = spans.max_by_key(|span| (span.source, span.start));
            let names: Vec<_> = names.iter().map(|name| format!("`{name}`")).collect();
            report.extend(span.map(|span| {
                let message = format!("{} depend on each other", names.join(" and "));
                Diagnostic::new(Code::BadDistribution, span, message)
                    .label("in a circle")
                    .hint("let one of them depend on nothing that is varied")
            }));
            ordered.append(&mut variations);
            break;
        };
        ordered.push(variations.remove(ready));
    }
    ordered
}

/// Why a name is not known in a variation though there is something of that name.
fn say_why_unknown(
    findings: &mut [Diagnostic],
    layer: &Layer<ast::ScenarioBlock>,
    known: &HashMap<String, Binding>,
    layers: &[Layer<ast::ScenarioBlock>],
) {
    let varied = layers.iter().flat_map(|layer| layer.block.variations()).flat_map(varied_names);
    let varied: HashMap<&str, Span> = varied.collect();
    let drawn: HashMap<&str, Span> = layers
        .iter()
        .flat_map(|layer| layer.block.draws())
        .map(|one| (one.name().text(), one.name().span()))
        .collect();
    let lets = layer.block.bindings().map(ast::Binding::name);
    let lets: HashMap<&str, Span> = lets.map(|name| (name.text(), name.span())).collect();
    for finding in findings.iter_mut().filter(|finding| finding.code == Code::UnknownName) {
        let is_it = |name: &&&str| finding.message == format!("`{name}` is not defined");
        let (code, message, place, hint) = if let Some(name) = varied.keys().find(is_it) {
            if known.contains_key(*name) {
                let message = format!("values of a list or range may not depend on `{name}`, which varies");
                let hint = format!(
                    "use `{name}` where the values are used, or draw them: `normal({name}, …) 10 times`"
                );
                (Code::NotConstant, message, varied[name], hint)
            } else {
                let message = format!("`{name}` is varied, but not before this");
                let hint = format!("put the line that varies `{name}` above this one");
                (Code::UnknownName, message, varied[name], hint)
            }
        } else if let Some(name) = drawn.keys().find(is_it) {
            let message = format!(
                "`{name}` is another one in every run, and a variation is the same for all runs of a trial"
            );
            (Code::NotConstant, message, drawn[name], format!("draw this as well, or vary `{name}`"))
        } else if let Some(name) = lets.keys().find(is_it) {
            let message = format!("variations do not know `{name}`, a `let` of their own scenario");
            (Code::UnknownName, message, lets[name], "put the `let` before the scenario".to_string())
        } else {
            continue;
        };
        *finding = Diagnostic::new(code, finding.span(), message)
            .label("cannot be used here")
            .context(place, "defined here")
            .hint(hint);
    }
}

/// Reports names that a layer leaves without values when it varies `name` anew, with which they were varied together.
fn left_alone(
    block: ast::ScenarioBlock,
    name: &str,
    span: Span,
    others: &[(String, Span)],
    report: &mut Vec<Diagnostic>,
) {
    let anew: Vec<&str> = block.variations().flat_map(varied_names).map(|(name, _)| name).collect();
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

pub fn varied_names<'t>(node: ast::Variation<'t>) -> Vec<(&'t str, Span)> {
    node.names().map(|name| (name.text(), name.span())).collect()
}

type Outcome<'t> = (Vec<Varied<'t>>, Option<Variation>);

fn single<'t>(
    node: ast::Varied<'t>,
    scope: &NameScope,
    known: &HashMap<String, Binding>,
    report: &mut Vec<Diagnostic>,
) -> Outcome<'t> {
    let Some(varied) = varied(node, scope, known, report) else { return (Vec::new(), None) };
    let names = vec![varied.name.to_string()];
    let variation = match &varied.over {
        Over::Values(values) => {
            Some(Variation::Grid { names, rows: values.iter().map(|value| vec![value.clone()]).collect() })
        }
        Over::Distribution(distribution) => node
            .sampling()
            .and_then(|sampling| samples(sampling, vec![(distribution.clone(), varied.kind)], report))
            .map(|samples| Variation::Sampled { names, samples }),
    };
    (vec![varied], variation)
}

/// Draws may depend on the names above them in the same block as well.
fn together<'t>(
    node: ast::VaryTogether<'t>,
    scope: &NameScope,
    mut known: HashMap<String, Binding>,
    report: &mut Vec<Diagnostic>,
) -> Outcome<'t> {
    let block = node.block();
    let lines: Vec<_> = block.each().collect();
    let is_drawn = node.sampling().is_some();
    let mut found = Vec::new();
    for line in &lines {
        let Some(one) = varied(*line, scope, &known, report) else { continue };
        if is_drawn {
            known.insert(one.name.to_string(), Binding::new(Some(one.typed()), one.span));
        }
        found.push(one);
    }
    let varied = found;
    if varied.len() != lines.len() || block.has_bad() {
        return (varied, None);
    }
    if varied.is_empty() {
        report.push(empty(block.span(), "`vary together` names nothing", "x in [1, 2]"));
        return (varied, None);
    }
    let names = varied.iter().map(|varied| varied.name.to_string()).collect();
    let variation = match node.sampling() {
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
    node: ast::Sampling,
    distributions: Vec<(Distribution, ValueKind)>,
    report: &mut Vec<Diagnostic>,
) -> Option<Samples> {
    let count = literal::count(node.count(), 1, MOST_VALUES as u32, "the number of draws", report)?;
    let scheme = if node.by_latin_hypercube() {
        SamplingScheme::LatinHypercube
    } else if node.by_sobol() {
        SamplingScheme::Sobol
    } else {
        SamplingScheme::Random
    };
    let unit = |kind: &ValueKind| match kind {
        ValueKind::Number(dimension) => dimension.si_unit(),
        _ => String::new(),
    };
    let units = distributions.iter().map(|(_, kind)| unit(kind)).collect();
    let distributions = distributions.into_iter().map(|(distribution, _)| distribution).collect();
    Some(Samples { count, scheme, distributions, units })
}

fn varied<'t>(
    node: ast::Varied<'t>,
    scope: &NameScope,
    known: &HashMap<String, Binding>,
    report: &mut Vec<Diagnostic>,
) -> Option<Varied<'t>> {
    let name = node.name();
    let (Written { kind, notation }, over) = if let Some(list) = node.list() {
        let (written, values) = values(list.span(), list.values(), scope, report)?;
        (written, Over::Values(values))
    } else if let Some(range) = node.range() {
        let (written, values) = range_values(range, report)?;
        (written, Over::Values(values))
    } else {
        let (written, distribution) = distribution(node.distribution()?, scope, known, report)?;
        (written, Over::Distribution(distribution))
    };
    Some(Varied { name: name.text(), span: name.span(), kind, notation, over })
}

/// Constants of one kind, all different.
fn values<'t>(
    span: Span,
    expressions: impl Iterator<Item = ast::Expression<'t>>,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(Written, Vec<VariedValue>)> {
    let mut kind: Option<(Written, Span)> = None;
    let mut values: Vec<VariedValue> = Vec::new();
    let mut said: HashMap<String, Span> = HashMap::new();
    let mut failed = false;
    for expression in expressions {
        let Some((typed, label)) = constant(expression, scope, report) else {
            failed = true;
            continue;
        };
        if let Some((first, place)) = kind {
            if !value::expect_kind(&typed, first.kind, "this value of the list", report) {
                if let Some(diagnostic) = report.last_mut() {
                    let first = format!("the first is {}", first.kind.name());
                    *diagnostic = diagnostic.clone().context(place, first);
                }
                failed = true;
                continue;
            }
        } else {
            kind = Some((Written::of(&typed), typed.span));
        }
        let scenario::Expression::Constant(value) = typed.expression else { continue };
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
fn constant(
    expression: ast::Expression,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(Typed, String)> {
    if let Some(word) = expression.lone_word()
        && scope.find(word).is_none()
    {
        return Some((Typed::word(word, expression.span()), word.to_string()));
    }
    let typed = value::evaluate(expression, scope, report)?;
    let label = match &typed.expression {
        scenario::Expression::Constant(Value::Word(word)) => word.clone(),
        scenario::Expression::Constant(_) => {
            expression.text().chars().filter(|c| !c.is_whitespace()).collect()
        }
        _ => return value::not_constant(typed.span, &typed.expression, "a varied value", report),
    };
    Some((typed, label))
}

/// `6 s .. 18 s step 4 s`: computed in the unit it is written in, so that values and labels are what people expect.
fn range_values(node: ast::Range, report: &mut Vec<Diagnostic>) -> Option<(Written, Vec<VariedValue>)> {
    let mut bad = |span: Span, message: &str| {
        report.push(
            Diagnostic::new(Code::BadDistribution, span, message)
                .label("in this range")
                .hint("write numbers of one unit: `6 s .. 18 s step 4 s`"),
        );
        None
    };
    let mut bounds = Vec::new();
    for expression in node.bounds() {
        let Some((number, symbol)) = expression.signed_quantity() else {
            return bad(expression.span(), "a range is made of numbers");
        };
        bounds.push((number, symbol));
    }
    let [(first, unit), (last, last_unit), (step, step_unit)] = bounds.as_slice() else { return None };
    if unit != last_unit || unit != step_unit {
        return bad(node.span(), "the parts of a range have different units");
    }
    let converted = match *unit {
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
    let kind = ValueKind::Number(converted.map_or(Dimension::NUMBER, |unit| unit.dimension));
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
    Some((Written { kind, notation: converted.map(units::UnitEntry::notation) }, values))
}

/// `choice(child: 30 %, adult: 70 %)`
fn weighted(
    node: ast::Distribution,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(Written, Distribution)> {
    let bad = |span: Span, message: String, hint: &str| {
        Diagnostic::new(Code::BadDistribution, span, message).label("cannot be drawn from").hint(hint)
    };
    if let Some(alone) = node.values().next() {
        let message = format!("`{}` has no weight, and others have", alone.text());
        report.push(bad(alone.span(), message, "give every value a weight, or none"));
        return None;
    }
    let pairs: Vec<(ast::Expression, ast::Expression)> =
        node.weighted().filter_map(|one| one.parts().next().zip(one.parts().nth(1))).collect();
    let (written, options) = values(node.span(), pairs.iter().map(|(value, _)| *value), scope, report)?;
    let (mut weights, mut in_percent) = (Vec::new(), true);
    for (_, weight) in &pairs {
        let typed = value::evaluate(*weight, scope, report)?;
        if !value::expect_kind(&typed, ValueKind::Number(Dimension::NUMBER), "a weight", report) {
            return None;
        }
        let scenario::Expression::Constant(Value::Number(number)) = typed.expression else {
            return value::not_constant(typed.span, &typed.expression, "a weight", report);
        };
        if number < 0.0 {
            let message = format!("the weight {} is below 0", significant(number, 6));
            report.push(bad(typed.span, message, "give it a weight of at least 0"));
            return None;
        }
        in_percent &= weight.text().contains('%');
        weights.push(number);
    }
    let sum: f64 = weights.iter().sum();
    if sum == 0.0 || !sum.is_finite() {
        let message = "all weights are 0, or larger than a number can be".to_string();
        report.push(bad(node.span(), message, "give a value a weight above 0"));
        return None;
    }
    if in_percent && (sum - 1.0).abs() > 1e-9 {
        let message = format!("the shares come to {} %, not to 100 %", significant(100.0 * sum, 6));
        report.push(bad(
            node.span(),
            message,
            "let them come to 100 %, or write plain numbers, which are relative",
        ));
        return None;
    }
    Some((written, Distribution::Weighted { options, weights }))
}

/// What a draw is from, with the kind and the unit of its values.
pub struct DrawnFrom {
    pub kind: ValueKind,
    pub notation: Option<Notation>,
    pub distribution: Distribution,
}

/// A distribution; `known` are the names that its numbers may depend on.
pub fn drawn_from(
    node: ast::Distribution,
    scope: &NameScope,
    known: &HashMap<String, Binding>,
    report: &mut Vec<Diagnostic>,
) -> Option<DrawnFrom> {
    let (Written { kind, notation }, distribution) = distribution(node, scope, known, report)?;
    Some(DrawnFrom { kind, notation, distribution })
}

/// `known` are the variations that its numbers may depend on.
fn distribution(
    node: ast::Distribution,
    scope: &NameScope,
    known: &HashMap<String, Binding>,
    report: &mut Vec<Diagnostic>,
) -> Option<(Written, Distribution)> {
    let name = node.name();
    let count = node.values().count();
    let Some(entry) = DistributionWord::find(name.text()) else {
        let unknown = name.text();
        report.push(
            Diagnostic::new(
                Code::BadDistribution,
                name.span(),
                format!("there is no distribution `{unknown}`"),
            )
            .label("unknown")
            .suggest(unknown, DISTRIBUTIONS.map(|known| known.word)),
        );
        return None;
    };
    let (wanted, of) = match entry.of {
        DistributionOf::Values if node.weighted().next().is_some() => return weighted(node, scope, report),
        DistributionOf::Values => {
            let (kind, values) = values(node.span(), node.values(), scope, report)?;
            return Some((kind, Distribution::Choice(values)));
        }
        DistributionOf::Numbers(wanted, of) => (wanted, of),
    };
    if let Some(node) = node.weighted().next() {
        report.push(
            Diagnostic::new(
                Code::BadDistribution,
                node.span(),
                format!("the numbers of `{}` have no weights", name.text()),
            )
            .label("a value with a weight")
            .hint("write the numbers alone; `choice(a: 70 %, b: 30 %)` has weights"),
        );
        return None;
    }
    if count != wanted.len() {
        let wanted = wanted.iter().map(|one| one.name).collect::<Vec<_>>().join(", ");
        report.push(
            Diagnostic::new(
                Code::BadDistribution,
                node.span(),
                format!("`{}` takes {wanted}, but got {count} values", name.text()),
            )
            .label("cannot be drawn from")
            .hint(format!("write `{}({wanted})`", name.text())),
        );
        return None;
    }
    let scope = &NameScope { outer: Some(scope), names: known.clone(), member: None };
    let mut numbers = Vec::new();
    let mut kind = None;
    for (expression, wanted) in node.values().zip(wanted) {
        let typed = value::evaluate(expression, scope, report)?;
        if wanted.is_plain {
            let what = format!("the {} of `{}`", wanted.name, name.text());
            if !value::expect_kind(&typed, ValueKind::Number(Dimension::NUMBER), &what, report) {
                return None;
            }
            numbers.push(typed.expression);
            continue;
        }
        let expected = *kind.get_or_insert(match typed.kind {
            ValueKind::Number(_) => Written::of(&typed),
            _ => Written { kind: ValueKind::Number(Dimension::NUMBER), notation: None },
        });
        if !value::expect_kind(&typed, expected.kind, "this part of the distribution", report) {
            return None;
        }
        numbers.push(typed.expression);
    }
    let distribution = of(numbers)?;
    // What depends on other variations is checked when they are known.
    if let Err(error) = distribution.known(&Default::default())
        && !matches!(error, DistributionError::Evaluation(_))
    {
        let found = Diagnostic::new(Code::BadDistribution, node.span(), error.to_string())
            .label("cannot be drawn from");
        report.push(match error.hint() {
            Some(hint) => found.hint(hint),
            None => found,
        });
        return None;
    }
    Some((kind?, distribution))
}
