//! What is opened and how: a suite with the runs that it asks for, and what is otherwise than its files say.

use std::path::PathBuf;

use super::apart;
use crate::plan::Plan;
use lang::{Outside, Override, Replacement};
use results::Recorded;
use scenario::Suite;

/// A suite with the runs that it asks for.
#[derive(Debug)]
pub struct PlannedSuite {
    /// As the user named it.
    pub file: String,
    /// What the file says.
    pub suite: Suite,
    /// The trials and runs that it asks for.
    pub plan: Plan,
    /// Runs that failed in earlier sessions.
    pub recorded: Vec<Recorded>,
}

impl PlannedSuite {
    /// What a key of the suite that was made where others had its name is where it is alone. `None` if it begins otherwise.
    pub fn key_alone<'k>(&self, key: &'k str) -> Option<&'k str> {
        apart::key_alone(key, &self.file, &self.suite.name)
    }
}

/// What is otherwise than the files say.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct ProjectOptions {
    pub(super) seed: Option<u64>,
    pub(super) outside: Outside,
}

impl ProjectOptions {
    /// Replaces the seed of every suite.
    pub fn seed(self, seed: impl Into<Option<u64>>) -> Self {
        Self { seed: seed.into(), ..self }
    }

    /// Gives everything of these names other values, as if they stood in the files.
    pub fn set(self, set: impl IntoIterator<Item = Override>) -> Self {
        Self { outside: Outside { set: set.into_iter().collect(), ..self.outside }, ..self }
    }

    /// Puts controllers in the place of those that scenarios name, as `test … as` in a suite.
    pub fn controllers(self, controllers: impl IntoIterator<Item = Replacement>) -> Self {
        Self { outside: Outside { controllers: controllers.into_iter().collect(), ..self.outside }, ..self }
    }

    /// Reads these files besides, whose controllers [`Self::controllers`] and values may name.
    pub fn uses(self, files: impl IntoIterator<Item = PathBuf>) -> Self {
        Self { outside: Outside { uses: files.into_iter().collect(), ..self.outside }, ..self }
    }
}
