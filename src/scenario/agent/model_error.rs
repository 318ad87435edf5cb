//! Why a model cannot be built for a case, with its numbers as data: whoever knows the scenario shows them as it writes them.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{Dimension, Notation, Text, show_apart};

/// Why a model cannot be built for a case. It reads in SI units; [`Self::told`] takes others.
#[derive(Debug, Clone, PartialEq, Error, Serialize, Deserialize)]
#[error("{}", self.told(&|_| None))]
pub struct ModelError {
    /// What stands before, between and after the numbers.
    words: Vec<String>,
    numbers: Vec<Stated>,
    /// What to write instead.
    pub hint: Option<String>,
}

/// A number of a model's error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stated {
    /// SI units.
    pub value: f64,
    /// What kind of quantity it is, for the unit that it is shown in.
    pub dimension: Dimension,
    /// Who says it, for the unit that it is shown in.
    pub of: StatedBy,
}

/// What of a scenario makes a number what it is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StatedBy {
    /// The model's setting of this name.
    Setting(Text),
    /// The place that the road user starts at.
    Start,
    /// The simulation's step.
    Step,
}

impl ModelError {
    /// An error in words; numbers may be added to it.
    pub fn new(message: impl Into<String>) -> Self {
        Self { words: vec![message.into()], numbers: Vec::new(), hint: None }
    }

    /// An error with what to do about it.
    pub fn with_hint(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..Self::new(message) }
    }

    /// One whose `message` has a number wherever there is `{}`.
    pub fn stating(message: &str, numbers: impl Into<Vec<Stated>>, hint: impl Into<String>) -> Self {
        let words = message.split("{}").map(str::to_string).collect();
        Self { words, numbers: numbers.into(), hint: Some(hint.into()) }
    }

    /// What is wrong, every number in the unit that its part of the scenario is written in; `None`: in SI units. Numbers that
    /// differ look different.
    pub fn told(&self, written: &dyn Fn(&StatedBy) -> Option<Notation>) -> String {
        let numbers: Vec<_> =
            self.numbers.iter().map(|one| (one.value, one.dimension, written(&one.of))).collect();
        let numbers = show_apart(&numbers).into_iter().map(Some).chain(std::iter::repeat(None));
        let parts = self.words.iter().zip(numbers);
        parts.map(|(words, number)| words.clone() + number.as_deref().unwrap_or_default()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Symbol;

    #[test]
    fn numbers_are_told_as_they_are_written() {
        let time = |value, of| Stated { value, dimension: Dimension::TIME, of };
        let numbers = [time(0.03, StatedBy::Setting("dt".into())), time(0.005, StatedBy::Step)];
        let error = ModelError::stating("it decides every {}, but the step is {}", numbers, "let it fit");
        assert_eq!(error.to_string(), "it decides every 0.03 s, but the step is 0.005 s");
        let ms = Notation { symbol: Symbol::new("ms"), numerator: 1.0, denominator: 1000.0 };
        let told = error.told(&|of| (*of == StatedBy::Setting("dt".into())).then_some(ms));
        assert_eq!(told, "it decides every 30 ms, but the step is 0.005 s");
        let plain = ModelError::new("no {} here");
        assert_eq!(plain.told(&|_| Some(ms)), "no {} here");
    }
}
