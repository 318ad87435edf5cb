//! Which units of a project are run, and until when.

use super::unit::{Unit, with_needs};

/// Which of a project's units are to run. Whatever they need runs, too.
#[derive(Debug, Clone)]
pub struct Selection {
    wanted: Wanted,
    pub(super) max_failures: Option<usize>,
}

#[derive(Debug, Clone)]
enum Wanted {
    All,
    Containing(String),
    Named(String),
    Marked(Vec<bool>),
}

impl Selection {
    /// All of them.
    pub fn all() -> Self {
        Self::of(Wanted::All)
    }

    /// Those whose name contains `part`, as on the command line.
    pub fn containing(part: impl Into<String>) -> Self {
        Self::of(Wanted::Containing(part.into()))
    }

    /// The one of that name.
    pub fn named(key: impl Into<String>) -> Self {
        Self::of(Wanted::Named(key.into()))
    }

    /// Those for which there is `true`, in the order of [`units`](super::units).
    pub fn marked(marks: Vec<bool>) -> Self {
        Self::of(Wanted::Marked(marks))
    }

    fn of(wanted: Wanted) -> Self {
        Self { wanted, max_failures: None }
    }

    /// After so many failures nothing more begins; `None`: whatever fails.
    pub fn until_failures(self, most: Option<usize>) -> Self {
        Self { max_failures: most, ..self }
    }

    /// Whether each unit is to run.
    pub(super) fn chosen(&self, units: &[Unit]) -> Vec<bool> {
        let wanted = |index: usize, unit: &Unit| match &self.wanted {
            Wanted::All => true,
            Wanted::Containing(part) => unit.key.contains(part.as_str()),
            Wanted::Named(key) => unit.key == *key,
            Wanted::Marked(marks) => marks.get(index).is_some_and(|mark| *mark),
        };
        with_needs(units, units.iter().enumerate().map(|(index, unit)| wanted(index, unit)).collect())
    }
}
