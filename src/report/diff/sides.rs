//! Two runs that are laid side by side, and what is known of them.

use crate::replay::{RunReason, run_reasons};
use crate::why::Standing;
use results::{Outcome, Requests, TwoRuns};
use scenario::{Case, Criterion};

/// What the two are called.
pub(crate) const LETTERS: [&str; 2] = ["A", "B"];

/// Two runs that are told side by side.
pub struct RunDiff<'a> {
    /// The run that was asked for.
    pub key: &'a str,
    /// The one and the other.
    pub sides: [DiffSide<'a>; 2],
    /// What is measured in both.
    pub requests: &'a Requests,
    /// What came of them.
    pub two: &'a TwoRuns,
    /// What has to be known besides, a sentence each.
    pub remarks: &'a [String],
}

/// One of two runs.
pub struct DiffSide<'a> {
    /// What is otherwise in it: `controller av=carla_behavior`.
    pub otherwise: &'a str,
    /// The run.
    pub case: &'a Case,
    /// What it has of its own, as a scenario writes it.
    pub values: &'a [(String, String)],
    /// What is asked of it.
    pub criteria: &'a [Criterion],
}

impl RunDiff<'_> {
    pub(crate) fn outcomes(&self) -> [&Outcome; 2] {
        [&self.two.a.outcome, &self.two.b.outcome]
    }

    pub(crate) fn reasons(&self) -> [Vec<RunReason>; 2] {
        let [a, b] = self.outcomes();
        [(&self.sides[0], a), (&self.sides[1], b)]
            .map(|(side, outcome)| run_reasons(side.criteria, outcome, self.requests))
    }

    pub(crate) fn standings(&self) -> [Standing; 2] {
        let ([a, b], [in_a, in_b]) = (self.outcomes(), self.reasons());
        [Standing::of(&in_a, a), Standing::of(&in_b, b)]
    }
}
