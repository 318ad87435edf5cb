//! `claim …`: what is measured, compared to numbers and to each other.

use super::criterion::{self, From};
use super::places::TextPlaces;
use super::subject::{StatementSubject, Subjects};
use super::target::{Takes, target};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::ast::{self, View};
use crate::syntax::{Node, phrase};
use crate::value::{self, Calculation, NameScope, Typed, ValueKind};
use scenario::{
    BinaryOperator, Dimension, Expression, Measured, OutcomesOf, ParameterKind, Quantity, Relation,
    StatementClaim, StatementClaimKind, TrendDirection, Value, VariationCondition,
};

/// The claim at `node`.
pub fn claim(
    node: ast::Claim,
    subjects: &Subjects,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<StatementClaim> {
    let mut claims = Claims { subjects, scope, places, report };
    let kind = match node.trend() {
        Some(trend) => claims.trend(trend)?,
        None => claims.comparison(node)?,
    };
    let text = phrase(*node).trim_start_matches("claim").trim().to_string();
    Some(StatementClaim { kind, text, origin: places.origin(node.span()) })
}

struct Claims<'a, 's> {
    subjects: &'a Subjects<'s>,
    scope: &'a NameScope<'a>,
    places: &'a TextPlaces<'a>,
    report: &'a mut Vec<Diagnostic>,
}

/// A part of a calculation.
struct Term {
    quantity: Quantity,
    dimension: Dimension,
    /// What it can be.
    range: (f64, f64),
    span: Span,
    /// A `when` that nothing keeps apart from what follows it.
    when: Option<Span>,
}

const ANYTHING: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

impl Term {
    fn kind(&self) -> (ValueKind, Span) {
        (ValueKind::Number(self.dimension), self.span)
    }
}

impl<'s> Claims<'_, 's> {
    fn comparison(&mut self, node: ast::Claim) -> Option<StatementClaimKind> {
        let mut sides = node.sides();
        let (left, right) = (sides.next()?, sides.next()?);
        let (left, right) = (value::calculate(*left, self), value::calculate(*right, self));
        let (left, right) = (left?, right?);
        match (&left.quantity, &right.quantity) {
            (Quantity::Number(_), Quantity::Number(_)) => {
                self.report.push(
                    Diagnostic::new(Code::BadClaim, node.span(), "this compares numbers with each other")
                        .label("whatever the results are")
                        .hint("compare what is measured: `mean(pet) of SCENARIO >= 1.5 s`"),
                );
                return None;
            }
            (Quantity::Number(number), _) => self.bound(*number, &left, &right)?,
            (_, Quantity::Number(number)) => self.bound(*number, &right, &left)?,
            _ if left.dimension != right.dimension => {
                let (left_name, right_name) = (left.kind().0.name(), right.kind().0.name());
                self.report.push(
                    Diagnostic::new(
                        Code::MixedDimensions,
                        node.span(),
                        format!("{left_name} is compared to {right_name}"),
                    )
                    .label("of different kinds")
                    .context(left.span, left_name)
                    .context(right.span, right_name)
                    .hint("compare quantities of the same kind"),
                );
                return None;
            }
            _ => {}
        }
        let relation = node.relation()?.meaning();
        Some(StatementClaimKind::Compares { left: left.quantity, relation, right: right.quantity })
    }

    /// A number that something measured is compared to.
    fn bound(&mut self, number: f64, bound: &Term, measured: &Term) -> Option<()> {
        let typed = Typed::constant(Value::Number(number), ValueKind::Number(bound.dimension), bound.span);
        let what = "what this is compared to";
        if !value::expect_kind(&typed, ValueKind::Number(measured.dimension), what, self.report) {
            return None;
        }
        let (low, high) = measured.range;
        if !(low..=high).contains(&number) {
            let dimension = bound.dimension;
            self.report.push(value::out_of_range(&typed, what, number, measured.range, dimension, None));
            return None;
        }
        Some(())
    }

    fn trend(&mut self, node: ast::Trend) -> Option<StatementClaimKind> {
        let (term, subject) = self.measured(node.measured())?;
        let Quantity::Measured(measured) = term.quantity else { return None };
        let name = node.name();
        let Some(binding) = subject.varied.get(name.text()) else {
            self.report.push(
                Diagnostic::new(
                    Code::UnknownVariation,
                    name.span(),
                    format!("scenario `{}` does not vary `{}`", subject.scenario.name, name.text()),
                )
                .label("not varied")
                .suggest(name.text(), subject.varied.keys().map(String::as_str)),
            );
            return None;
        };
        let kind = binding.value.as_ref()?.kind;
        if !matches!(kind, ValueKind::Number(_)) {
            self.report.push(
                Diagnostic::new(
                    Code::NoOrder,
                    name.span(),
                    format!("`{}` is {}, which has no order", name.text(), kind.name()),
                )
                .label("neither smaller nor larger")
                .hint("compare two of its values: `… when NAME = one < … when NAME = another`"),
            );
            return None;
        }
        if binding.varied.as_ref().is_some_and(|values| values.len() < 2) {
            self.report.push(
                Diagnostic::new(
                    Code::BadClaim,
                    name.span(),
                    format!("`{}` has one value only, so nothing rises or falls with it", name.text()),
                )
                .label("does not change")
                .context(binding.span, "varied here")
                .hint("vary it over more values"),
            );
            return None;
        }
        let rises = node.rises();
        let direction = if rises { TrendDirection::Rises } else { TrendDirection::Falls };
        Some(StatementClaimKind::Trend { measured, direction, variable: name.text().to_string() })
    }

    /// With what it is measured in.
    fn measured(&mut self, node: ast::Measured) -> Option<(Term, StatementSubject<'s>)> {
        let (of, subject) = self.outcomes(node.outcomes())?;
        let cast = subject.cast();
        let aggregate = criterion::aggregate(node.aggregate(), &cast, self.scope, self.report);
        let varied = NameScope { outer: Some(self.scope), names: subject.varied.clone(), member: None };
        let conditions = node.when().into_iter().flat_map(ast::When::conditions);
        let when: Vec<_> =
            conditions.map(|condition| self.run_condition(condition, &subject, &varied)).collect();
        let (aggregate, dimension, range) = aggregate?;
        let when = when.into_iter().collect::<Option<_>>()?;
        let quantity = Quantity::Measured(Measured { aggregate, of, when });
        let when = node.when().map(|when| when.span());
        Some((Term { quantity, dimension, range, span: node.span(), when }, subject))
    }

    fn run_condition(
        &mut self,
        node: ast::WhenCondition,
        subject: &StatementSubject,
        varied: &NameScope,
    ) -> Option<VariationCondition> {
        let condition = criterion::when_condition(node, From::Scenario, varied, self.report)?;
        let (Some((low, high)), Expression::Constant(Value::Number(bound))) =
            (subject.searched.get(&condition.variable), &condition.bound)
        else {
            return Some(condition);
        };
        let (message, hint) = match condition.relation {
            Relation::Equal | Relation::NotEqual => (
                "a search finds any value between two, hardly ever exactly this one",
                "compare by `<` or `>`",
            ),
            relation if !relation.holds(*low, *bound) && !relation.holds(*high, *bound) => {
                ("the search never looks there", "compare to a value within its range")
            }
            _ => return Some(condition),
        };
        self.report.push(
            Diagnostic::new(Code::NeverApplies, node.span(), message)
                .label("holds for no run, or for all")
                .hint(hint),
        );
        None
    }

    /// `of NAME` or `of EVALUATE.CONDITION`
    fn outcomes(&mut self, node: ast::Outcomes) -> Option<(OutcomesOf, StatementSubject<'s>)> {
        let (subjects, places) = (self.subjects, self.places);
        let mut names = node.names();
        let (name, condition) = (names.next()?, names.next());
        let text = name.text().to_string();
        if let Some(condition) = condition {
            return self.condition(name, condition);
        }
        if subjects.searches.has(name.text()) {
            let search = subjects.searches.find(name.text())?;
            return Some((OutcomesOf::Search(text), subjects.found_by(search, places)?));
        }
        if let Some(evaluate) = subjects.evaluates.find(name.text()) {
            self.report.push(
                Diagnostic::new(
                    Code::UnknownCondition,
                    name.span(),
                    format!("`{text}` has several conditions, and nothing says which one is measured"),
                )
                .label("which condition?")
                .hint(format!("write `of {text}.{}`", evaluate.conditions[0].name)),
            );
            return None;
        }
        if subjects.tunes.has(name.text()) {
            self.report.push(
                Diagnostic::new(
                    Code::UnknownBlock,
                    name.span(),
                    format!("`{text}` is a tune, which chooses parameters and has no runs of its own"),
                )
                .label("a tune")
                .hint(format!("evaluate it, `evaluate NAME {{ on …; with default, {text} }}`, and write `of NAME.{text}`")),
            );
            return None;
        }
        if subjects.evaluates.has(name.text()) {
            return None;
        }
        let also: Vec<&str> = subjects.searches.names().chain(subjects.evaluates.names()).collect();
        let subject = subjects.scenario(name.span(), name.text(), &also, places, self.report)?;
        Some((OutcomesOf::Scenario(text), subject))
    }

    fn condition(
        &mut self,
        name: ast::Name,
        condition: ast::Name,
    ) -> Option<(OutcomesOf, StatementSubject<'s>)> {
        let (subjects, places) = (self.subjects, self.places);
        if !subjects.evaluates.has(name.text()) {
            let known = subjects.searches.has(name.text())
                || subjects.scenario_names(places).any(|known| known == name.text());
            let diagnostic = Diagnostic::new(
                Code::UnknownBlock,
                name.span(),
                format!("there is no evaluate `{}` here", name.text()),
            );
            self.report.push(if known {
                diagnostic.label("has no conditions").hint(format!("write `of {}`", name.text()))
            } else {
                diagnostic.label("not in this suite").suggest(name.text(), subjects.evaluates.names())
            });
            return None;
        }
        let evaluate = subjects.evaluates.find(name.text())?;
        let conditions = evaluate.conditions.iter().map(|condition| condition.name.as_str());
        if !conditions.clone().any(|known| known == condition.text()) {
            self.report.push(
                Diagnostic::new(
                    Code::UnknownCondition,
                    condition.span(),
                    format!("evaluate `{}` has no condition `{}`", name.text(), condition.text()),
                )
                .label("not after its `with`")
                .suggest(condition.text(), conditions),
            );
            return None;
        }
        let subject = subjects.of(&evaluate.on, places)?;
        let (evaluate, condition) = (name.text().to_string(), condition.text().to_string());
        Some((OutcomesOf::Condition { evaluate, condition }, subject))
    }

    /// `chosen(av.controller.braking_distance) of TUNE`
    fn chosen(&mut self, node: ast::Chosen) -> Option<Term> {
        let (subjects, places) = (self.subjects, self.places);
        let (place, name) = (node.target(), node.tune());
        if !subjects.tunes.has(name.text()) {
            self.report.push(
                Diagnostic::new(
                    Code::UnknownBlock,
                    name.span(),
                    format!("there is no tune `{}` here", name.text()),
                )
                .label("not in this suite")
                .suggest(name.text(), subjects.tunes.names()),
            );
            return None;
        }
        let tune = subjects.tunes.find(name.text())?;
        let wanted = phrase(*place);
        let targets: Vec<String> = tune.over.iter().map(|range| range.target.to_string()).collect();
        if !targets.contains(&wanted) {
            self.report.push(
                Diagnostic::new(
                    Code::BadTarget,
                    place.span(),
                    format!("tune `{}` does not choose `{wanted}`", name.text()),
                )
                .label("not after its `over`")
                .suggest(&wanted, targets.iter().map(String::as_str)),
            );
            return None;
        }
        let subject = subjects.of(&tune.on, places)?;
        let (target, takes) = target(place, &subject, self.report)?;
        let kind = match takes {
            Takes::Kind(kind) => kind,
            Takes::Parameter(declaration, parameter) => {
                match declaration.parameter(&parameter).map(|found| &found.kind) {
                    Some(ParameterKind::Number { dimension, .. }) => ValueKind::Number(*dimension),
                    Some(ParameterKind::Whole { .. }) => ValueKind::Number(Dimension::NUMBER),
                    Some(ParameterKind::Flag { .. }) => ValueKind::Flag,
                    _ => ValueKind::Word,
                }
            }
        };
        let ValueKind::Number(dimension) = kind else {
            return value::not_a_number((kind, node.span()), self.report);
        };
        let quantity = Quantity::Chosen { tune: name.text().to_string(), target };
        Some(Term { quantity, dimension, range: ANYTHING, span: node.span(), when: None })
    }

    /// A number, or a name that stands for one.
    fn number(&mut self, node: ast::Operand) -> Option<Term> {
        if matches!(node, ast::Operand::Reference(_))
            && self.scope.find(node.text()).is_none()
            && self.places.files.registry.metrics().get(node.text()).is_some()
        {
            let name = node.text();
            self.report.push(
                Diagnostic::new(
                    Code::BadClaim,
                    node.span(),
                    format!("`{name}` has a value in every run, and a claim compares one number"),
                )
                .label("not summed up")
                .hint(format!("say how it is summed up, and over which runs: `mean({name}) of SCENARIO`")),
            );
            return None;
        }
        let typed = value::operand(node, self.scope, self.report)?;
        let ValueKind::Number(dimension) = typed.kind else {
            return value::not_a_number((typed.kind, typed.span), self.report);
        };
        let Some(number) = typed.as_constant_number() else {
            return value::not_constant(typed.span, &typed.expression, "a claim", self.report);
        };
        let quantity = Quantity::Number(number);
        Some(Term { quantity, dimension, range: ANYTHING, span: node.span(), when: None })
    }

    /// Reports a `when` that does not say how far it reaches.
    fn apart(&mut self, term: &Term) -> Option<()> {
        let Some(when) = term.when else { return Some(()) };
        self.report.push(
            Diagnostic::new(Code::BadClaim, when, "this `when` stands in the middle of a calculation")
                .label("how far does it reach?")
                .hint(
                    "put brackets around what it belongs to: `(mean(pet) of SCENARIO when tta = 6 s) + 1 s`",
                ),
        );
        None
    }
}

impl Calculation for Claims<'_, '_> {
    type Operand = Term;

    fn operand(&mut self, node: Node) -> Option<Term> {
        match ast::ClaimedOperand::cast(node)? {
            ast::ClaimedOperand::Measured(node) => self.measured(node).map(|(term, _)| term),
            ast::ClaimedOperand::Chosen(node) => self.chosen(node),
            ast::ClaimedOperand::ClaimedGroup(node) => {
                let inside = value::calculate(*node.inside(), self)?;
                Some(Term { span: node.span(), when: None, ..inside })
            }
            ast::ClaimedOperand::Quantity(node) => self.number(ast::Operand::Quantity(node)),
            ast::ClaimedOperand::Reference(node) => self.number(ast::Operand::Reference(node)),
        }
    }

    fn negate(&mut self, term: Term) -> Option<Term> {
        self.apart(&term)?;
        let quantity = match term.quantity {
            Quantity::Number(number) => Quantity::Number(-number),
            quantity => Quantity::Binary {
                operator: BinaryOperator::Multiply,
                left: Box::new(Quantity::Number(-1.0)),
                right: Box::new(quantity),
            },
        };
        Some(Term { quantity, range: ANYTHING, ..term })
    }

    fn join(&mut self, left: Term, operator: BinaryOperator, right: Term) -> Option<Term> {
        self.apart(&left)?;
        self.apart(&right)?;
        let span = left.span.to(right.span);
        let dimension = value::dimension(left.kind(), operator, right.kind(), self.report)?;
        if operator == BinaryOperator::Divide && right.quantity == Quantity::Number(0.0) {
            self.report.push(value::not_finite(span));
            return None;
        }
        let quantity = match (&left.quantity, &right.quantity) {
            (Quantity::Number(left), Quantity::Number(right)) => {
                let result = match operator {
                    BinaryOperator::Add => left + right,
                    BinaryOperator::Subtract => left - right,
                    BinaryOperator::Multiply => left * right,
                    BinaryOperator::Divide => left / right,
                };
                if !result.is_finite() {
                    self.report.push(value::not_finite(span));
                    return None;
                }
                Quantity::Number(result)
            }
            _ => {
                Quantity::Binary { operator, left: Box::new(left.quantity), right: Box::new(right.quantity) }
            }
        };
        Some(Term { quantity, dimension, range: ANYTHING, span, when: None })
    }
}
