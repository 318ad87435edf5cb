//! Filter expressions such as `scenario(zebra) & tag(paper) & !model(jaywalker)`: which trials a command is about.
//!
//! The syntax is that of nextest's filtersets with predicates of our own. [`Filters::parse`] reads what was given
//! by `-E`, [`Filters::matches`] decides for each [`Subject`], [`Filters::warnings`] names what never applies.

mod condition;
mod matcher;
mod parse;
mod predicate;
mod reference;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

pub use predicate::{SCENARIO, Subject};
pub use reference::reference;

use super::diagnostic::Diagnostic;
use super::source::Sources;
use super::{Failure, diagnostic};
use condition::{Condition, Filter, Test};

/// Everything that was given by `-E`: subjects that one of the expressions selects are meant, all without any.
#[derive(Debug, Clone, Default)]
pub struct Filters {
    filters: Vec<Filter>,
    /// The texts, for showing warnings.
    pub sources: Sources,
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
