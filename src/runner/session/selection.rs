//! Which units of a project are run, and until when.

use super::unit::{Units, with_needs};

/// Which of a project's units are to run. Whatever they need runs, too.
#[derive(Debug, Clone)]
pub struct Selection {
    wanted: Wanted,
    pub(super) first: Vec<bool>,
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
        Self { wanted, first: Vec::new(), max_failures: None }
    }

    /// After so many failures nothing more begins; `None`: whatever fails.
    pub fn until_failures(self, most: Option<usize>) -> Self {
        Self { max_failures: most, ..self }
    }

    /// Those for which there is `true`, in the order of [`units`](super::units), begin before the others, with what they need. What comes of
    /// units does not depend on it, but which of them are run does, if failures end the session.
    pub fn first(self, marks: Vec<bool>) -> Self {
        Self { first: marks, ..self }
    }

    /// Whether each unit is to run.
    pub(super) fn chosen(&self, units: &Units) -> Vec<bool> {
        let by_key = |is_wanted: &dyn Fn(&str) -> bool| units.keys().map(|key| is_wanted(&key)).collect();
        let wanted = match &self.wanted {
            Wanted::All => vec![true; units.len()],
            Wanted::Containing(part) => by_key(&|key| key.contains(part.as_str())),
            Wanted::Named(name) => by_key(&|key| key == name),
            Wanted::Marked(marks) => {
                let mut marks = marks.clone();
                marks.resize(units.len(), false);
                marks
            }
        };
        with_needs(units, wanted)
    }
}
