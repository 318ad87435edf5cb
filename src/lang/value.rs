//! Values: calculations over names with their dimensions.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};

use super::codes::Code;
use super::diagnostic::{Diagnostic, Remedy};
use super::source::Span;
use super::syntax::Node;
use super::syntax::ast::{self, Term, View};
use super::units;
use scenario::limits::Limit;
use scenario::{self, BinaryOperator, Dimension, Expression, Notation, Value, VariedValue};

/// A calculation over variations with more parts than this is refused.
const MOST_PARTS: usize = 1000;

/// What kind of thing a value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValueKind {
    Number(Dimension),
    Flag,
    Word,
}

/// A value with what was found out about it.
#[derive(Debug, Clone)]
pub struct Typed {
    pub expression: Expression,
    pub kind: ValueKind,
    /// The unit it is written in, as far as one can be said to be its own.
    pub notation: Option<Notation>,
    /// Number of parts of the expression.
    size: usize,
    pub span: Span,
}

/// What a name stands for.
#[derive(Debug, Clone)]
pub struct Binding {
    /// `None` if its definition is wrong, which has been reported already.
    pub value: Option<Typed>,
    /// The values that a variation over a list takes.
    pub varied: Option<Vec<VariedValue>>,
    /// Where it is defined.
    pub span: Span,
    pub used: Used,
}

/// Whether anything asked for a name. Of the names of a file, scenarios ask that are checked side by side.
#[derive(Debug, Default)]
pub struct Used(AtomicBool);

impl Used {
    pub fn get(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    fn set(&self) {
        // Most names are known to be used: what is only read is shared without waiting.
        if !self.get() {
            self.0.store(true, Ordering::Relaxed);
        }
    }
}

impl Clone for Used {
    fn clone(&self) -> Self {
        Self(self.get().into())
    }
}

/// The names that a value may use, inner ones hiding outer ones.
#[derive(Debug, Default)]
pub struct NameScope<'a> {
    pub outer: Option<&'a NameScope<'a>>,
    pub names: HashMap<String, Binding>,
    /// Whose value is meant where `each(…)` gives every member of a group its own.
    pub member: Option<Member>,
}

/// A member of a group of pedestrians.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Member {
    /// From 0.
    pub index: usize,
    /// How many there are.
    pub of: usize,
}

impl Binding {
    pub fn new(value: Option<Typed>, span: Span) -> Self {
        Self { value, varied: None, span, used: Used::default() }
    }
}

impl<'a> NameScope<'a> {
    pub fn inside(outer: &'a NameScope<'a>) -> Self {
        Self { outer: Some(outer), names: HashMap::new(), member: None }
    }

    /// What the name stands for here; it then counts as used.
    pub fn find(&self, name: &str) -> Option<&Binding> {
        let found = self.names.get(name).or_else(|| self.outer?.find(name))?;
        found.used.set();
        Some(found)
    }

    /// What `each(…)` is about here.
    fn member(&self) -> Option<Member> {
        self.member.or_else(|| self.outer?.member())
    }

    /// Every name that can be used here.
    pub fn all_names(&self) -> Vec<&str> {
        let mut names = self.outer.map_or_else(Vec::new, NameScope::all_names);
        names.extend(self.names.keys().map(String::as_str));
        names
    }
}

impl ValueKind {
    /// With an article: "a length", "a word".
    pub fn name(self) -> String {
        match self {
            Self::Number(Dimension::NUMBER) => "a number without unit".to_string(),
            Self::Number(dimension) if dimension.name().starts_with(['a', 'i']) => {
                format!("an {}", dimension.name())
            }
            Self::Number(dimension) if dimension.name() == "compound quantity" => {
                format!("a quantity in {}", dimension.si_unit())
            }
            Self::Number(dimension) => format!("a {}", dimension.name()),
            Self::Flag => "`true` or `false`".to_string(),
            Self::Word => "a word".to_string(),
        }
    }
}

impl Typed {
    pub fn constant(value: Value, kind: ValueKind, span: Span) -> Self {
        Self { expression: Expression::Constant(value), kind, notation: None, size: 1, span }
    }

    pub fn word(word: &str, span: Span) -> Self {
        Self::constant(Value::Word(word.to_string()), ValueKind::Word, span)
    }

    pub fn variable(name: &str, kind: ValueKind, notation: Option<Notation>, span: Span) -> Self {
        Self { expression: Expression::Variable(name.to_string()), kind, notation, size: 1, span }
    }

    /// The number, if it is one and does not vary.
    pub fn as_constant_number(&self) -> Option<f64> {
        match &self.expression {
            Expression::Constant(value) => value.as_number(),
            _ => None,
        }
    }
}

/// What a calculation is made of: values, or what results measure.
pub trait Calculation {
    type Operand;

    /// What stands between two operators. Mistakes are reported and give `None`, here and below.
    fn operand(&mut self, node: Node) -> Option<Self::Operand>;

    fn negate(&mut self, operand: Self::Operand) -> Option<Self::Operand>;

    fn join(
        &mut self,
        left: Self::Operand,
        operator: BinaryOperator,
        right: Self::Operand,
    ) -> Option<Self::Operand>;
}

/// The result of a node's operands, operators and negations, multiplication before addition.
pub fn calculate<C: Calculation>(node: Node, calculation: &mut C) -> Option<C::Operand> {
    fn joined<C: Calculation>(
        calculation: &mut C,
        left: Option<C::Operand>,
        operator: Option<BinaryOperator>,
        right: C::Operand,
    ) -> Option<C::Operand> {
        match (left, operator) {
            (Some(left), Some(operator)) => calculation.join(left, operator, right),
            _ => Some(right),
        }
    }
    // Terms to be added up; multiplication binds its factors to the last of them at once.
    let mut sum: Option<C::Operand> = None;
    let mut pending_sum: Option<BinaryOperator> = None;
    let mut product: Option<C::Operand> = None;
    let mut pending_product: Option<BinaryOperator> = None;
    let mut negative = false;
    for term in node.terms() {
        match term {
            Term::Negation => negative = !negative,
            Term::Operator(operator @ (BinaryOperator::Multiply | BinaryOperator::Divide)) => {
                pending_product = Some(operator);
            }
            Term::Operator(operator) => {
                sum = Some(joined(calculation, sum, pending_sum.take(), product.take()?)?);
                pending_sum = Some(operator);
            }
            Term::Operand(part) => {
                let mut operand = calculation.operand(part)?;
                if std::mem::take(&mut negative) {
                    operand = calculation.negate(operand)?;
                }
                product = Some(joined(calculation, product.take(), pending_product.take(), operand)?);
            }
        }
    }
    joined(calculation, sum, pending_sum, product?)
}

/// The value of an expression. Mistakes are reported and give `None`.
pub fn evaluate(node: ast::Expression, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<Typed> {
    let mut result = calculate(*node, &mut Values { scope, report })?;
    result.span = node.span();
    Some(result)
}

struct Values<'a> {
    scope: &'a NameScope<'a>,
    report: &'a mut Vec<Diagnostic>,
}

impl Calculation for Values<'_> {
    type Operand = Typed;

    fn operand(&mut self, node: Node) -> Option<Typed> {
        operand(ast::Operand::cast(node)?, self.scope, self.report)
    }

    fn negate(&mut self, operand: Typed) -> Option<Typed> {
        negate(operand, self.report)
    }

    fn join(&mut self, left: Typed, operator: BinaryOperator, right: Typed) -> Option<Typed> {
        join(left, operator, right, self.report)
    }
}

/// A quantity, a truth value, a word, a name or a group.
pub fn operand(node: ast::Operand, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<Typed> {
    match node {
        ast::Operand::Quantity(node) => quantity(node, report),
        ast::Operand::Boolean(node) => {
            Some(Typed::constant(Value::Flag(node.text() == "true"), ValueKind::Flag, node.span()))
        }
        ast::Operand::Text(node) => {
            Some(Typed::constant(Value::Word(node.value()), ValueKind::Word, node.span()))
        }
        ast::Operand::Group(node) => evaluate(node.inside(), scope, report),
        ast::Operand::Each(node) => each(node, scope, report),
        ast::Operand::Reference(node) => {
            let name = node.text();
            match scope.find(name) {
                Some(binding) => binding.value.clone().map(|value| Typed { span: node.span(), ..value }),
                None => {
                    report.push(
                        Diagnostic::new(Code::UnknownName, node.span(), format!("`{name}` is not defined"))
                            .label("no `let` above, no variation and no parameter has this name")
                            .suggest(name, scope.all_names()),
                    );
                    None
                }
            }
        }
    }
}

/// The value of the member of a group that a scope is about.
fn each(node: ast::Each, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<Typed> {
    let Some(member) = scope.member() else {
        report.push(
            Diagnostic::new(Code::BadEach, node.span(), "`each(…)` is for the members of a group")
                .label("there is no group here")
                .hint("a group reads `pedestrian walkers times 3 { …; along each(0 m, 0.7 m, 1.4 m) }`"),
        );
        return None;
    };
    let given = node.values().count();
    if given != member.of {
        let people = if member.of == 1 { "person".to_string() } else { format!("{} people", member.of) };
        report.push(
            Diagnostic::new(
                Code::BadEach,
                node.span(),
                format!("`each` gives {given} values to a group of {people}"),
            )
            .label(format!("{given} for {}", member.of))
            .hint("give as many values as the group has members, or change `times`"),
        );
        return None;
    }
    evaluate(node.values().nth(member.index)?, scope, report)
}

fn quantity(node: ast::Quantity, report: &mut Vec<Diagnostic>) -> Option<Typed> {
    let number = node.number().value()?;
    let (number, dimension, notation) = match node.unit() {
        None => (number, Dimension::NUMBER, None),
        Some(symbol) => match units::unit_of(symbol.text()) {
            Some(unit) => (unit.to_si(number), unit.dimension, Some(unit.notation())),
            None => {
                let mut diagnostic = Diagnostic::new(
                    Code::UnknownUnit,
                    symbol.span(),
                    format!("there is no unit `{}`", symbol.text()),
                )
                .label("not a unit");
                diagnostic = match units::meant(symbol.text()) {
                    Some(unit) => {
                        diagnostic.hint(format!("write `{unit}`")).remedy(Remedy::Replace(unit.to_string()))
                    }
                    // Of short ones the nearest is seldom meant, and would change the value.
                    None if symbol.text().len() < 4 => {
                        let all: Vec<_> =
                            units::UNITS.iter().map(|unit| format!("`{}`", unit.symbol)).collect();
                        diagnostic.hint(format!("there are {}", all.join(", ")))
                    }
                    None => diagnostic.suggest(symbol.text(), units::UNITS.iter().map(|unit| unit.symbol)),
                };
                report.push(diagnostic);
                return None;
            }
        },
    };
    if !number.is_finite() {
        report.push(
            Diagnostic::new(Code::NotFinite, node.span(), "this number is too large")
                .label("beyond what a number can hold")
                .hint("is the exponent right?"),
        );
        return None;
    }
    let constant = Typed::constant(Value::Number(number), ValueKind::Number(dimension), node.span());
    Some(Typed { notation, ..constant })
}

fn negate(operand: Typed, report: &mut Vec<Diagnostic>) -> Option<Typed> {
    if !matches!(operand.kind, ValueKind::Number(_)) {
        return not_a_number((operand.kind, operand.span), report);
    }
    let expression = match operand.expression {
        Expression::Constant(Value::Number(number)) => Expression::number(-number),
        varying => Expression::Negated(Box::new(varying)),
    };
    Some(Typed { expression, size: operand.size + 1, ..operand })
}

pub fn not_a_number<T>((kind, span): (ValueKind, Span), report: &mut Vec<Diagnostic>) -> Option<T> {
    report.push(
        Diagnostic::new(Code::WrongType, span, format!("cannot calculate with {}", kind.name()))
            .label("not a number")
            .hint("only quantities can be calculated with"),
    );
    None
}

/// The dimension of `left operator right`.
pub fn dimension(
    left: (ValueKind, Span),
    operator: BinaryOperator,
    right: (ValueKind, Span),
    report: &mut Vec<Diagnostic>,
) -> Option<Dimension> {
    let span = left.1.to(right.1);
    let ValueKind::Number(left_dimension) = left.0 else { return not_a_number(left, report) };
    let ValueKind::Number(right_dimension) = right.0 else { return not_a_number(right, report) };
    let dimension = match operator {
        BinaryOperator::Multiply => left_dimension.times(right_dimension),
        BinaryOperator::Divide => left_dimension.over(right_dimension),
        BinaryOperator::Add | BinaryOperator::Subtract if left_dimension == right_dimension => {
            Some(left_dimension)
        }
        BinaryOperator::Add | BinaryOperator::Subtract => {
            report.push(
                Diagnostic::new(
                    Code::MixedDimensions,
                    span,
                    format!("{} and {} cannot be added or subtracted", left.0.name(), right.0.name()),
                )
                .label("of different kinds")
                .context(left.1, left.0.name())
                .context(right.1, right.0.name())
                .hint("give both the same kind of unit"),
            );
            return None;
        }
    };
    if dimension.is_none() {
        report.push(
            Diagnostic::new(Code::NotFinite, span, "the dimension of this calculation is out of all bounds")
                .label("too high a power")
                .hint("no quantity in traffic has such a dimension"),
        );
    }
    dimension
}

pub fn not_finite(span: Span) -> Diagnostic {
    Diagnostic::new(Code::NotFinite, span, "the result of this calculation is not a number")
        .label("divides by zero or grows beyond all bounds")
        .hint("check the numbers on both sides")
}

/// `left operator right`
fn join(left: Typed, operator: BinaryOperator, right: Typed, report: &mut Vec<Diagnostic>) -> Option<Typed> {
    let span = left.span.to(right.span);
    let dimension = dimension((left.kind, left.span), operator, (right.kind, right.span), report)?;
    let size = left.size + right.size + 1;
    // Of two units that are multiplied, one is the result's own only where the other stands for none.
    let own = |typed: &Typed| typed.notation.filter(|_| typed.kind == ValueKind::Number(dimension));
    let notation = own(&left).or(own(&right));
    let constant = matches!(
        (&left.expression, &right.expression),
        (Expression::Constant(Value::Number(_)), Expression::Constant(Value::Number(_)))
    );
    if size > MOST_PARTS && !constant {
        report.push(
            Diagnostic::new(
                Code::TooLong,
                span,
                format!("this calculation has more than {MOST_PARTS} parts"),
            )
            .label("too long")
            .hint("vary the result itself instead"),
        );
        return None;
    }
    let mut expression =
        Expression::Binary { operator, left: Box::new(left.expression), right: Box::new(right.expression) };
    let mut size = size;
    if constant {
        size = 1;
        match expression.evaluate(&Default::default()) {
            Ok(value) => expression = Expression::Constant(value),
            Err(_) => {
                report.push(not_finite(span));
                return None;
            }
        }
    }
    Some(Typed { expression, kind: ValueKind::Number(dimension), notation, size, span })
}

/// Whether a value is of a kind; if not, says so.
pub fn expect_kind(value: &Typed, kind: ValueKind, what: &str, report: &mut Vec<Diagnostic>) -> bool {
    if value.kind == kind {
        return true;
    }
    let units = match kind {
        ValueKind::Number(dimension) => units::units_for(dimension),
        _ => None,
    };
    let diagnostic = match (kind, value.kind) {
        (ValueKind::Number(wanted), ValueKind::Number(Dimension::NUMBER)) => {
            let missing = Diagnostic::new(
                Code::MissingUnit,
                value.span,
                format!("{what} is {}, but this number has no unit", kind.name()),
            );
            let usual = units::UNITS.iter().filter(|unit| unit.dimension == wanted && unit.is_usual);
            let remedies = usual.map(|unit| Remedy::AddBehind(format!(" {}", unit.symbol))).collect();
            Diagnostic { remedies, ..missing }.label("needs a unit")
        }
        (ValueKind::Number(_), ValueKind::Number(_)) => Diagnostic::new(
            Code::WrongDimension,
            value.span,
            format!("{what} is {}, not {}", kind.name(), value.kind.name()),
        )
        .label(format!("this is {}", value.kind.name())),
        _ => Diagnostic::new(
            Code::WrongType,
            value.span,
            format!("{what} is {}, not {}", kind.name(), value.kind.name()),
        )
        .label(format!("this is {}", value.kind.name())),
    };
    report.push(match (kind, units) {
        (ValueKind::Number(Dimension::NUMBER), _) => {
            diagnostic.hint("write a number without unit, or with `%`")
        }
        (ValueKind::Number(_), Some(units)) => diagnostic.hint(format!("give it in {units}")),
        (ValueKind::Number(dimension), None) => {
            diagnostic.hint(format!("calculate it, so that it comes out in {}", dimension.si_unit()))
        }
        (kind, _) => diagnostic.hint(format!("write {}", kind.name())),
    });
    false
}

/// A quantity of a dimension. `what` begins the message: "the speed of a vehicle".
pub fn quantity_of(
    node: ast::Expression,
    dimension: Dimension,
    what: &str,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Typed> {
    let value = evaluate(node, scope, report)?;
    expect_kind(&value, ValueKind::Number(dimension), what, report).then_some(value)
}

/// As [`quantity_of`], within a range that holds for every value it can take.
pub fn quantity_in(
    node: ast::Expression,
    dimension: Dimension,
    range: (f64, f64),
    what: &str,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Typed> {
    let value = quantity_of(node, dimension, what, scope, report)?;
    let (low, high) = range;
    for (found, label) in possible(&value.expression, scope) {
        if let Value::Number(number) = found
            && !(low..=high).contains(&number)
        {
            report.push(out_of_range(&value, what, number, range, dimension, label));
            return None;
        }
    }
    Some(value)
}

/// As [`quantity_in`], with one of the limits of a scenario.
pub fn quantity_within(
    node: ast::Expression,
    limit: Limit,
    what: &str,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Typed> {
    quantity_in(node, limit.dimension, limit.range, what, scope, report)
}

/// As [`constant_in`], with the unit that it is written in.
pub fn written_constant(
    node: ast::Expression,
    dimension: Dimension,
    range: (f64, f64),
    what: &str,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(f64, Option<Notation>)> {
    let value = quantity_in(node, dimension, range, what, scope, report)?;
    let number =
        value.as_constant_number().or_else(|| not_constant(value.span, &value.expression, what, report))?;
    Some((number, value.notation))
}

/// As [`quantity_in`], for places where all runs share one value.
pub fn constant_in(
    node: ast::Expression,
    dimension: Dimension,
    range: (f64, f64),
    what: &str,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<f64> {
    written_constant(node, dimension, range, what, scope, report).map(|(number, _)| number)
}

pub fn not_constant<T>(
    span: Span,
    expression: &Expression,
    what: &str,
    report: &mut Vec<Diagnostic>,
) -> Option<T> {
    report.push(
        Diagnostic::new(Code::NotConstant, span, format!("{what} may not vary between runs"))
            .label(format!("depends on `{}`", expression.variables().join("`, `")))
            .hint("write a scenario for each value"),
    );
    None
}

/// That `value` can be `found`, which is not in range; `varied` says where.
pub fn out_of_range(
    value: &Typed,
    what: &str,
    found: f64,
    range: (f64, f64),
    dimension: Dimension,
    varied: Option<String>,
) -> Diagnostic {
    let (message, bounds) = scenario::out_of_range(what, found, range, dimension, value.notation);
    let found = scenario::show(found, value.notation, dimension);
    let diagnostic = Diagnostic::new(Code::OutOfRange, value.span, message);
    match varied {
        Some(varied) => diagnostic.label(format!("{found} where {varied}")),
        None => diagnostic.label("out of range"),
    }
    .hint(format!("choose a value {bounds}"))
}

/// The values an expression takes, with the variation's value that leads to it; nothing if it depends on more than
/// one variation or on a sampled one (those are checked again for every run).
pub fn possible(expression: &Expression, scope: &NameScope) -> Vec<(Value, Option<String>)> {
    if let Expression::Constant(value) = expression {
        return vec![(value.clone(), None)];
    }
    let mut names = expression.variables();
    names.sort_unstable();
    names.dedup();
    let [name] = names.as_slice() else { return Vec::new() };
    let Some(varied) = scope.find(name).and_then(|binding| binding.varied.as_ref()) else {
        return Vec::new();
    };
    varied
        .iter()
        .filter_map(|choice| {
            let variables = std::collections::BTreeMap::from([(name.to_string(), choice.value.clone())]);
            let value = expression.evaluate(&variables).ok()?;
            Some((value, Some(format!("{name} = {}", choice.label))))
        })
        .collect()
}
