//! Pass criteria over the metrics of a trial's runs.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{
    Aggregate, Comparison, EvaluationError, Expression, MetricReference, Origin, Relation, Value,
    WhenUndefined,
};

/// What `expect` demands of a scenario's runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Criterion {
    /// What must hold.
    pub claim: Claim,
    /// Applies only to trials in which this holds; every comparison is over a variation.
    pub when: Vec<VariationCondition>,
    /// The criterion in canonical words, such as `pet >= 1.5 s in 80 % of runs`.
    pub text: String,
    /// Of whom it speaks, and between what limits its metric lies.
    #[serde(default)]
    pub reach: Reach,
    /// Where it is written.
    pub origin: Origin,
}

/// How far a criterion with confidence reaches beyond its runs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    /// Whom it speaks of, if it says so.
    pub people: Option<People>,
    /// Whether every run of its scenario is of somebody else, drawn anew: all people, and runs that are independent. Worked out when it
    /// is planned.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub drawn_people: bool,
    /// Between what limits its metric lies in its scenario, in the metric's unit. Worked out when it is planned.
    pub limits: Option<(f64, f64)>,
}

/// Whom a criterion speaks of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum People {
    /// Those who walk in its runs, as often as one likes.
    These,
    /// All people whom they were taken from.
    All,
}

/// A condition on a variation's value, such as `tta >= 18 s`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VariationCondition {
    /// The variation's name.
    pub variable: String,
    /// How the two must compare.
    pub relation: Relation,
    /// SI units, or a word; of constants alone.
    pub bound: Expression,
}

impl VariationCondition {
    /// Whether it holds where the variations have these values. Words are equal or not and nothing else.
    pub fn holds(&self, variables: &BTreeMap<String, Value>) -> Result<bool, EvaluationError> {
        let value = Expression::Variable(self.variable.clone()).evaluate(variables)?;
        let bound = self.bound.evaluate(variables)?;
        Ok(match (value, bound) {
            (Value::Number(left), Value::Number(right)) => self.relation.holds(left, right),
            (left, right) => match self.relation {
                Relation::Equal => left == right,
                Relation::NotEqual => left != right,
                _ => false,
            },
        })
    }
}

/// What a criterion says of the runs of a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Claim {
    /// The comparison holds in every run, or in at least a share (0..1) of them.
    Runs {
        /// What must hold in a run.
        comparison: Comparison,
        /// `None`: in every run.
        share: Option<f64>,
        /// With which (0..1) the share of all possible runs must be shown; `None`: the share of those that were made.
        confidence: Option<f64>,
    },
    /// An aggregate over the runs compares to a bound.
    Aggregate {
        /// What sums them up.
        aggregate: Aggregate,
        /// How the two must compare.
        relation: Relation,
        /// In the SI unit of the aggregate.
        bound: Expression,
        /// What a run in which the metric does not exist says.
        when_undefined: WhenUndefined,
        /// With which (0..1) it must be shown of all possible runs; `None`: it holds of those that were made.
        confidence: Option<f64>,
    },
}

impl Claim {
    /// The metric that the claim is about.
    pub fn metric(&self) -> &MetricReference {
        match self {
            Self::Runs { comparison, .. } => &comparison.metric,
            Self::Aggregate { aggregate, .. } => aggregate.metric(),
        }
    }

    /// The confidence that it states.
    pub fn confidence(&self) -> Option<f64> {
        match self {
            Self::Runs { confidence, .. } | Self::Aggregate { confidence, .. } => *confidence,
        }
    }

    /// The metric that it is about.
    pub fn metric_mut(&mut self) -> &mut MetricReference {
        match self {
            Self::Runs { comparison, .. } => &mut comparison.metric,
            Self::Aggregate { aggregate, .. } => aggregate.metric_mut(),
        }
    }
}
