//! Definitions of names, and which of them are of one thing: a vehicle that a scenario and its base both describe has one name.

use std::collections::HashMap;

use crate::source::Span;

/// What kind of thing a name is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SymbolKind {
    /// `scenario NAME`, or a template.
    Scenario,
    /// `road NAME`.
    Road,
    /// `controller NAME { … }` of a file.
    Controller,
    /// A search, tune, evaluate, calibrate, estimate or statement.
    Block,
    /// `suite NAME`.
    Suite,
    /// `gate NAME`.
    Gate,
    /// `rating NAME`.
    Rating,
    /// `vehicle NAME`.
    Vehicle,
    /// `pedestrian NAME`, `cyclist NAME` or `escooter NAME`.
    Pedestrian,
    /// `box NAME`, `parked NAME` and their like on a road.
    Obstacle,
    /// `crossing NAME zebra`.
    Crossing,
    /// `let NAME`.
    Constant,
    /// `vary NAME` or `draw NAME`.
    Variation,
    /// What a template takes.
    Parameter,
    /// What a condition of an `evaluate` is called.
    Condition,
    /// A parameter that a program under test knows.
    ProgramParameter,
}

impl SymbolKind {
    /// With an article: "a scenario".
    pub fn name(self) -> &'static str {
        match self {
            Self::Scenario => "a scenario",
            Self::Road => "a road",
            Self::Controller => "a controller",
            Self::Block => "a block",
            Self::Suite => "a suite",
            Self::Gate => "a gate",
            Self::Rating => "a rating",
            Self::Vehicle => "a vehicle",
            Self::Pedestrian => "a pedestrian",
            Self::Obstacle => "a box of a road",
            Self::Crossing => "a crossing",
            Self::Constant => "a constant",
            Self::Variation => "a variation",
            Self::Parameter => "a parameter of a template",
            Self::Condition => "a condition of an evaluate",
            Self::ProgramParameter => "a parameter of a program",
        }
    }
}

/// A definition, by its place among all.
pub type DefinitionIndex = usize;

/// Every definition, and which are of one thing.
#[derive(Debug, Default)]
pub struct Classes {
    kinds: Vec<SymbolKind>,
    by_span: HashMap<Span, DefinitionIndex>,
    /// Of each, another of the same thing nearer to the one that stands for all.
    parents: Vec<DefinitionIndex>,
}

impl Classes {
    /// The definition whose name stands there.
    pub fn define(&mut self, span: Span, kind: SymbolKind) -> DefinitionIndex {
        *self.by_span.entry(span).or_insert_with(|| {
            self.kinds.push(kind);
            self.parents.push(self.parents.len());
            self.parents.len() - 1
        })
    }

    pub fn at(&self, span: Span) -> Option<DefinitionIndex> {
        self.by_span.get(&span).copied()
    }

    /// The definition that stands for all of the same thing.
    pub fn root(&self, mut definition: DefinitionIndex) -> DefinitionIndex {
        while self.parents[definition] != definition {
            definition = self.parents[definition];
        }
        definition
    }

    pub fn kind(&self, definition: DefinitionIndex) -> SymbolKind {
        self.kinds[definition]
    }

    /// Says that all of them are of one thing, and gives the first.
    pub fn unite(&mut self, of: &[DefinitionIndex]) -> Option<DefinitionIndex> {
        let (first, others) = of.split_first()?;
        for other in others {
            let (left, right) = (self.root(*first), self.root(*other));
            self.parents[left.max(right)] = left.min(right);
        }
        Some(*first)
    }
}
