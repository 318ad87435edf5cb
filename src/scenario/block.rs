//! What a suite computes besides its trials.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{
    Calibrate, Estimate, Evaluate, Keep, MatchedRate, MetricReference, Origin, Search, Statement,
    StatementClaim, Suite, Tune,
};

/// Something in a suite that takes simulations and gives one result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
// There are few of them and nobody moves them about.
#[allow(clippy::large_enum_variant)]
pub enum Block {
    /// Where a metric is worst.
    Search(Search),
    /// Which parameters of a controller are best.
    Tune(Tune),
    /// How parameter sets compare on the same cases.
    Evaluate(Evaluate),
    /// Which weights of candidates reproduce what people did.
    Calibrate(Calibrate),
    /// How probable a rare event is.
    Estimate(Estimate),
    /// Whether what a source says is reproduced.
    Statement(Statement),
}

impl Block {
    /// Every block of a suite in an order in which each comes after what it needs.
    pub fn all(suite: &Suite) -> Vec<Arc<Self>> {
        let searches = suite.searches.iter().cloned().map(Self::Search);
        let tunes = suite.tunes.iter().cloned().map(Self::Tune);
        let evaluates = suite.evaluates.iter().cloned().map(Self::Evaluate);
        let calibrates = suite.calibrates.iter().cloned().map(Self::Calibrate);
        let estimates = suite.estimates.iter().cloned().map(Self::Estimate);
        let statements = suite.statements.iter().cloned().map(Self::Statement);
        let first = searches.chain(tunes).chain(evaluates).chain(calibrates);
        first.chain(estimates).chain(statements).map(Arc::new).collect()
    }

    /// As the suite calls it; no two blocks of a suite share one.
    pub fn name(&self) -> &str {
        match self {
            Self::Search(search) => &search.name,
            Self::Tune(tune) => &tune.name,
            Self::Evaluate(evaluate) => &evaluate.name,
            Self::Calibrate(calibrate) => &calibrate.name,
            Self::Estimate(estimate) => &estimate.name,
            Self::Statement(statement) => &statement.name,
        }
    }

    /// The word that declares it, such as `search`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Search(_) => "search",
            Self::Tune(_) => "tune",
            Self::Evaluate(_) => "evaluate",
            Self::Calibrate(_) => "calibrate",
            Self::Estimate(_) => "estimate",
            Self::Statement(_) => "statement",
        }
    }

    /// What reports call it: `zebra/search=low_pet`. No trial has such a key: names of scenarios have no `=`.
    pub fn key(&self, suite: &str) -> String {
        format!("{suite}/{}={}", self.kind(), self.name())
    }

    /// What the suite says of it, in a sentence.
    pub fn doc(&self) -> Option<&str> {
        match self {
            Self::Search(search) => search.doc.as_deref(),
            Self::Tune(tune) => tune.doc.as_deref(),
            Self::Evaluate(evaluate) => evaluate.doc.as_deref(),
            Self::Calibrate(calibrate) => calibrate.doc.as_deref(),
            Self::Estimate(estimate) => estimate.doc.as_deref(),
            Self::Statement(statement) => statement.doc.as_deref(),
        }
    }

    /// Where it is declared.
    pub fn origin(&self) -> &Origin {
        match self {
            Self::Search(search) => &search.origin,
            Self::Tune(tune) => &tune.origin,
            Self::Evaluate(evaluate) => &evaluate.origin,
            Self::Calibrate(calibrate) => &calibrate.origin,
            Self::Estimate(estimate) => &estimate.origin,
            Self::Statement(statement) => &statement.origin,
        }
    }

    /// Every metric that it names.
    pub fn metrics_mut(&mut self) -> Vec<&mut MetricReference> {
        match self {
            Self::Search(search) => {
                let kept = search.keep.iter_mut().filter_map(|one| match one {
                    Keep::Metric { comparison, .. } => Some(&mut comparison.metric),
                    Keep::Plausibility { .. } => None,
                });
                let expected = search.expect.iter_mut().map(|criterion| criterion.claim.metric_mut());
                [search.objective.aggregate.metric_mut()].into_iter().chain(kept).chain(expected).collect()
            }
            Self::Tune(tune) => {
                let objectives = tune.objectives.iter_mut().map(|objective| objective.aggregate.metric_mut());
                objectives
                    .chain(tune.constraints.iter_mut().map(|constraint| &mut constraint.metric))
                    .collect()
            }
            Self::Evaluate(evaluate) => {
                evaluate.measures.iter_mut().map(|measure| measure.aggregate.metric_mut()).collect()
            }
            Self::Calibrate(calibrate) => {
                calibrate.rates.iter_mut().flat_map(MatchedRate::metrics_mut).collect()
            }
            Self::Estimate(estimate) => {
                [&mut estimate.event.metric].into_iter().chain(&mut estimate.score).collect()
            }
            Self::Statement(statement) => {
                statement.claims.iter_mut().flat_map(StatementClaim::metrics_mut).collect()
            }
        }
    }
}
