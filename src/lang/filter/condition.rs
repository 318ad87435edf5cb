//! One filter expression: conditions, and how they are combined.

use std::collections::BTreeSet;

use super::matcher::{Matcher, ValueMatcher};
use super::predicate::{Asked, SCENARIO, Subject};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;

/// One expression.
#[derive(Debug, Clone)]
pub(super) struct Filter {
    pub expression: Expression,
    /// What expressions refer to by index.
    pub conditions: Vec<Condition>,
}

/// How conditions are combined.
#[derive(Debug, Clone)]
pub(super) enum Expression {
    Condition(usize),
    Not(Box<Expression>),
    All(Vec<Expression>),
    Any(Vec<Expression>),
}

/// A predicate with its pattern.
#[derive(Debug, Clone)]
pub(super) struct Condition {
    pub asked: Asked,
    pub test: Test,
    /// The pattern without marks, for hints.
    pub text: String,
    pub span: Span,
}

#[derive(Debug, Clone)]
pub(super) enum Test {
    Name(Matcher),
    Value {
        name: String,
        value: ValueMatcher,
    },
    /// Of `all()` and `none()`.
    Always(bool),
}

impl Filter {
    pub fn holds(&self, expression: &Expression, subject: &Subject) -> bool {
        match expression {
            Expression::Condition(index) => self.conditions[*index].holds(subject),
            Expression::Not(inner) => !self.holds(inner, subject),
            Expression::All(parts) => parts.iter().all(|part| self.holds(part, subject)),
            Expression::Any(parts) => parts.iter().any(|part| self.holds(part, subject)),
        }
    }
}

impl Condition {
    pub fn holds(&self, subject: &Subject) -> bool {
        let matcher = match &self.test {
            Test::Always(always) => return *always,
            Test::Value { name, value } => {
                let mut values = subject.variation.iter().filter(|assignment| assignment.name == *name);
                return values.any(|assignment| value.matches(assignment));
            }
            Test::Name(matcher) => matcher,
        };
        let any = |names: &[&str]| names.iter().any(|name| matcher.matches(name));
        let named = || {
            if self.text.contains('/') {
                matcher.matches(&format!("{}/{}", subject.suite, subject.name))
            } else {
                matcher.matches(subject.name)
            }
        };
        match self.asked {
            Asked::Scenario => subject.kind == SCENARIO && named(),
            Asked::Block => subject.kind != SCENARIO && named(),
            Asked::Suite => matcher.matches(subject.suite),
            Asked::Tag => subject.tags.iter().any(|tag| matcher.matches(tag)),
            Asked::Model => any(&subject.models),
            Asked::Controller => any(&subject.controllers),
            Asked::File => subject.files.iter().any(|file| matcher.matches_path(file)),
            Asked::Kind => matcher.matches(subject.kind),
            Asked::Variation | Asked::All | Asked::None => false,
        }
    }

    /// Says that it holds for nothing, and what would, of all the values that it asks about.
    pub fn idle(&self, values: &BTreeSet<String>) -> Diagnostic {
        let finding = Diagnostic::new(Code::IdlePredicate, self.span, "this matches nothing that is loaded")
            .label("matches nothing");
        if let Test::Value { name, .. } = &self.test {
            let prefix = format!("{name}=");
            let own: Vec<_> = values.iter().filter(|value| value.starts_with(&prefix)).collect();
            if !own.is_empty() {
                return finding.suggest("", own.into_iter().map(String::as_str));
            }
            let names: BTreeSet<&str> = values.iter().filter_map(|value| value.split('=').next()).collect();
            return finding.suggest(name, names);
        }
        if self.asked == Asked::Scenario && self.text.contains('=') {
            return finding.hint(format!("values of variations are asked for by `variation({})`", self.text));
        }
        let names = values.iter().map(String::as_str);
        let asks_path = self.text.contains('/');
        match self.asked {
            Asked::Scenario | Asked::Block => {
                finding.suggest(&self.text, names.filter(|name| name.contains('/') == asks_path))
            }
            _ => finding.suggest(&self.text, names),
        }
    }
}
