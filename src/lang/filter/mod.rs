//! Filter expressions such as `scenario(zebra) & tag(paper) & !model(jaywalker)`: which trials a command is about.
//!
//! The syntax is that of nextest's filtersets with predicates of our own. [`Filters::parse`] reads what was given
//! by `-E`, [`Filters::matches`] decides for each [`Subject`], [`Filters::warnings`] names what never applies.

mod matcher;
mod parse;
mod predicate;
mod reference;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use predicate::Asked;
pub use predicate::{SCENARIO, Subject};
pub use reference::reference;

use super::codes::Code;
use super::diagnostic::Diagnostic;
use super::source::{Sources, Span};
use super::{Failure, diagnostic};
use matcher::{Matcher, ValueMatcher};

/// Everything that was given by `-E`: subjects that one of the expressions selects are meant, all without any.
#[derive(Debug, Clone, Default)]
pub struct Filters {
    filters: Vec<Filter>,
    /// The texts, for showing warnings.
    pub sources: Sources,
}

/// One expression.
#[derive(Debug, Clone)]
struct Filter {
    expression: Expression,
    /// What expressions refer to by index.
    conditions: Vec<Condition>,
}

/// How conditions are combined.
#[derive(Debug, Clone)]
enum Expression {
    Condition(usize),
    Not(Box<Expression>),
    All(Vec<Expression>),
    Any(Vec<Expression>),
}

/// A predicate with its pattern.
#[derive(Debug, Clone)]
struct Condition {
    asked: Asked,
    test: Test,
    /// The pattern without marks, for hints.
    text: String,
    span: Span,
}

#[derive(Debug, Clone)]
enum Test {
    Name(Matcher),
    Value {
        name: String,
        value: ValueMatcher,
    },
    /// Of `all()` and `none()`.
    Always(bool),
}

/// Is shown subjects.
pub type Show<'s> = dyn FnMut(&Subject) + 's;

/// Shows all subjects that there are, one after the other.
pub type Each<'s> = dyn Fn(&mut Show) + 's;

impl Filters {
    /// Reads every expression.
    ///
    /// # Errors
    /// Everything that is wrong with any of them.
    pub fn parse<T: AsRef<str>>(texts: &[T]) -> Result<Self, Failure> {
        let mut filters = Self::default();
        let mut report = Vec::new();
        for text in texts {
            let source = filters.sources.add("-E", text.as_ref());
            let filter = parse::parse(source, text.as_ref(), &mut report);
            filters.filters.extend(filter);
        }
        if report.is_empty() {
            Ok(filters)
        } else {
            report.truncate(diagnostic::MOST_FINDINGS);
            Err(Failure { diagnostics: report, sources: filters.sources })
        }
    }

    /// Whether there is no expression, so that everything is meant.
    pub fn is_empty(&self) -> bool {
        self.filters.is_empty()
    }

    /// Whether one of the expressions selects the subject; everything is selected where there are none.
    pub fn matches(&self, subject: &Subject) -> bool {
        self.is_empty() || self.filters.iter().any(|filter| filter.holds(&filter.expression, subject))
    }

    /// A warning for every predicate that holds for none of the subjects, of which there may be millions: `each` shows them one
    /// after the other.
    pub fn warnings(&self, each: &Each) -> Vec<Diagnostic> {
        let conditions = self.filters.iter().flat_map(|filter| &filter.conditions);
        let mut idle: Vec<&Condition> =
            conditions.filter(|condition| !matches!(condition.test, Test::Always(_))).collect();
        if !idle.is_empty() {
            each(&mut |subject| idle.retain(|condition| !condition.holds(subject)));
        }
        let warning = |condition: &Condition| {
            let mut values = BTreeSet::new();
            each(&mut |subject| values.extend(condition.asked.values(subject)));
            condition.idle(&values)
        };
        idle.into_iter().map(warning).collect()
    }
}

impl Filter {
    fn holds(&self, expression: &Expression, subject: &Subject) -> bool {
        match expression {
            Expression::Condition(index) => self.conditions[*index].holds(subject),
            Expression::Not(inner) => !self.holds(inner, subject),
            Expression::All(parts) => parts.iter().all(|part| self.holds(part, subject)),
            Expression::Any(parts) => parts.iter().any(|part| self.holds(part, subject)),
        }
    }
}

impl Condition {
    fn holds(&self, subject: &Subject) -> bool {
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
    fn idle(&self, values: &BTreeSet<String>) -> Diagnostic {
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
