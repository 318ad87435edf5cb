//! What `statement` blocks declare: claims of a source, held against the results of a suite.

use serde::{Deserialize, Serialize};

use super::{Aggregate, BinaryOperator, MetricReference, Origin, Relation, Target, VariationCondition};

/// Something that a source says, and what must hold in our results for it to count as reproduced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Statement {
    pub name: String,
    /// What the source says, in a sentence.
    pub doc: Option<String>,
    /// Where it says so, such as `Wang et al., experiment 2`.
    pub source: Option<String>,
    /// The numbers that the source gives, in words, to be shown beside ours.
    pub reported: Option<String>,
    /// It is reproduced if all of them hold; empty only if it is not comparable.
    pub claims: Vec<StatementClaim>,
    pub standing: DeclaredStanding,
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

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StatementClaim {
    pub kind: StatementClaimKind,
    /// In canonical words.
    pub text: String,
    pub origin: Origin,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StatementClaimKind {
    Compares {
        left: Quantity,
        relation: Relation,
        right: Quantity,
    },
    /// The aggregate, taken at every value of a variation in ascending order, never moves the other way and ends
    /// beyond where it began.
    Trend {
        measured: Measured,
        direction: TrendDirection,
        variable: String,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrendDirection {
    Rises,
    Falls,
}

/// A number with a unit, computed from results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// SI units.
    Number(f64),
    Measured(Measured),
    /// The value of a parameter that a tune chose.
    Chosen {
        tune: String,
        target: Target,
    },
    Binary {
        operator: BinaryOperator,
        left: Box<Quantity>,
        right: Box<Quantity>,
    },
}

/// An aggregate over the outcomes of something in the suite.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    pub aggregate: Aggregate,
    pub of: OutcomesOf,
    /// Only outcomes whose variations fulfil these.
    pub when: Vec<VariationCondition>,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OutcomesOf {
    /// Every run of a scenario.
    Scenario(String),
    /// The runs at the best point of every individual that a search found.
    Search(String),
    /// The runs of one condition of an `evaluate` block.
    Condition { evaluate: String, condition: String },
}

impl StatementClaim {
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
