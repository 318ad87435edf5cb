//! What `statement` blocks declare: claims of a source, held against the results of a suite.

use serde::{Deserialize, Serialize};

use super::{Aggregate, BinaryOperator, MetricReference, Origin, Relation, Target, VariationCondition};

/// Something that a source says, and what must hold in our results for it to count as reproduced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Statement {
    /// As the suite calls it.
    pub name: String,
    /// What the source says, in a sentence.
    pub doc: Option<String>,
    /// Where it says so, such as `Wang et al., experiment 2`.
    pub source: Option<String>,
    /// The numbers that the source gives, in words, to be shown beside ours.
    pub reported: Option<String>,
    /// It is reproduced if all of them hold; empty only if it is not comparable.
    pub claims: Vec<StatementClaim>,
    /// What is known about it.
    pub standing: DeclaredStanding,
    /// Where it is declared.
    pub origin: Origin,
}

/// What is known about a statement; the runner fails where the results say otherwise.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeclaredStanding {
    /// Expected to be reproduced.
    Reproduced,
    /// Known not to be reproduced, for this reason; a run that does reproduce it fails, so that the reason is revised.
    Differs(String),
    /// Cannot be compared, for this reason.
    NotComparable(String),
}

/// What must hold in the suite's results for a statement to count as reproduced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StatementClaim {
    /// What it says.
    pub kind: StatementClaimKind,
    /// In canonical words.
    pub text: String,
    /// Where it is written.
    pub origin: Origin,
}

/// What a claim of a statement says.
#[expect(clippy::large_enum_variant, reason = "a suite has a handful of them")]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StatementClaimKind {
    /// Two quantities compare so.
    Compares {
        /// Before the relation.
        left: Quantity,
        /// How the two must compare.
        relation: Relation,
        /// After the relation.
        right: Quantity,
    },
    /// The aggregate, taken at every value of a variation in ascending order, never moves the other way and ends
    /// beyond where it began.
    Trend {
        /// What is taken at every value.
        measured: Measured,
        /// Which way it must move.
        direction: TrendDirection,
        /// The name of a variation.
        variable: String,
    },
}

/// Which way an aggregate moves with a variation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrendDirection {
    /// It grows with the variation.
    Rises,
    /// It gets smaller as the variation grows.
    Falls,
}

/// A number with a unit, computed from results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// SI units.
    Number(f64),
    /// An aggregate over outcomes of the suite.
    Measured(Measured),
    /// The value of a parameter that a tune chose.
    Chosen {
        /// The tune's name.
        tune: String,
        /// The parameter that it chose.
        target: Target,
    },
    /// Arithmetic with two of them.
    Binary {
        /// What is done with them.
        operator: BinaryOperator,
        /// Before the operator.
        left: Box<Quantity>,
        /// After the operator.
        right: Box<Quantity>,
    },
}

/// An aggregate over the outcomes of something in the suite.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// What sums them up.
    pub aggregate: Aggregate,
    /// Which outcomes.
    pub of: OutcomesOf,
    /// Only outcomes whose variations fulfil these.
    pub when: Vec<VariationCondition>,
}

/// Which outcomes of a suite a statement measures.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OutcomesOf {
    /// Every run of a scenario.
    Scenario(String),
    /// The runs at the best point of every individual that a search found.
    Search(String),
    /// The runs of one condition of an `evaluate` block.
    Condition {
        /// The block's name.
        evaluate: String,
        /// The name of one of its conditions.
        condition: String,
    },
}

impl StatementClaim {
    /// Everything that it measures.
    pub fn measured(&self) -> Vec<&Measured> {
        match &self.kind {
            StatementClaimKind::Trend { measured, .. } => vec![measured],
            StatementClaimKind::Compares { left, right, .. } => {
                [left, right].into_iter().flat_map(Quantity::measured).collect()
            }
        }
    }

    /// Every metric that it names.
    pub fn metrics_mut(&mut self) -> Vec<&mut MetricReference> {
        match &mut self.kind {
            StatementClaimKind::Trend { measured, .. } => vec![measured.aggregate.metric_mut()],
            StatementClaimKind::Compares { left, right, .. } => {
                [left, right].into_iter().flat_map(Quantity::metrics_mut).collect()
            }
        }
    }
}

impl Quantity {
    fn measured(&self) -> Vec<&Measured> {
        match self {
            Self::Measured(measured) => vec![measured],
            Self::Binary { left, right, .. } => {
                [left, right].into_iter().flat_map(|side| side.measured()).collect()
            }
            Self::Number(_) | Self::Chosen { .. } => Vec::new(),
        }
    }

    fn metrics_mut(&mut self) -> Vec<&mut MetricReference> {
        match self {
            Self::Measured(measured) => vec![measured.aggregate.metric_mut()],
            Self::Binary { left, right, .. } => {
                [left, right].into_iter().flat_map(|side| side.metrics_mut()).collect()
            }
            Self::Number(_) | Self::Chosen { .. } => Vec::new(),
        }
    }
}
