//! What became of a block.

use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::cut::Cut;
use super::skip::Skip;
use super::standing::Standing;
use super::unit_error::UnitError;
use super::{
    CalibrateResult, EstimateResult, EvaluateResult, JudgedSearch, SearchResult, StatementResult, TuneResult,
};
use crate::Verdict;
use scenario::Block;

/// What became of a `search`, a `tune` or whatever else a suite computes besides its trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BlockReport {
    /// What the suite declares.
    pub block: Arc<Block>,
    /// Such as `zebra/search=low_pet`.
    pub key: String,
    /// What it came to.
    pub state: BlockState,
    /// Wall-clock time that it took.
    pub wall_time: Duration,
}

/// How far a block got, and what it came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BlockState {
    /// It came to a result, which may still [fail](BlockResult::failure).
    Finished(Box<BlockResult>),
    /// Could not be run to its end.
    Errored(UnitError),
    /// Begun, and cut off.
    NotFinished(Cut),
    /// Nobody tried to run it.
    Skipped(Skip),
}

impl BlockReport {
    /// Whether nobody tried to run it.
    pub fn skipped(&self) -> bool {
        self.skip().is_some()
    }

    /// Why nobody tried to run it.
    pub fn skip(&self) -> Option<&Skip> {
        match &self.state {
            BlockState::Skipped(skip) => Some(skip),
            _ => None,
        }
    }

    /// What it came to, if it did.
    pub fn result(&self) -> Option<&BlockResult> {
        match &self.state {
            BlockState::Finished(result) => Some(result),
            BlockState::Errored(_) | BlockState::NotFinished(_) | BlockState::Skipped(_) => None,
        }
    }

    /// The verdict of a block with a result that is judged; `None` of other blocks.
    pub fn verdict(&self) -> Option<Verdict> {
        self.result().and_then(BlockResult::verdict)
    }

    /// How it stands, for counts and exit codes.
    pub fn standing(&self) -> Standing {
        match &self.state {
            BlockState::Finished(result) => result.verdict().map_or(Standing::Found, Standing::Judged),
            BlockState::Errored(_) => Standing::Errored,
            BlockState::NotFinished(cut) => Standing::NotFinished(cut.by()),
            BlockState::Skipped(_) => Standing::Skipped,
        }
    }
}

/// What a block came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
// There are few of them and nobody moves them about.
#[allow(clippy::large_enum_variant)]
pub enum BlockResult {
    /// Of a `search`.
    Search(SearchResult),
    /// Of a `tune`.
    Tune(TuneResult),
    /// Of an `evaluate`.
    Evaluate(EvaluateResult),
    /// Of a `calibrate`.
    Calibrate(CalibrateResult),
    /// Of an `estimate`.
    Estimate(EstimateResult),
    /// Of a `statement`.
    Statement(StatementResult),
}

impl BlockResult {
    /// Whether it is what the block was to show; `None` of a search that found something and expects nothing.
    pub fn verdict(&self) -> Option<Verdict> {
        Some(match self {
            Self::Search(search) => return search.verdict(),
            Self::Estimate(estimate) => estimate.verdict(),
            Self::Statement(statement) => statement.verdict(),
            _ if self.failure().is_some() => Verdict::Failed,
            _ => Verdict::Passed,
        })
    }

    /// Whether other blocks can build on it, whatever its verdict.
    pub fn is_usable(&self) -> bool {
        match self {
            Self::Search(_) | Self::Evaluate(_) | Self::Calibrate(_) => true,
            Self::Tune(tune) => tune.nothing_chosen().is_none(),
            Self::Estimate(_) | Self::Statement(_) => self.failure().is_none(),
        }
    }

    /// How many evaluations an optimiser made; 0 of blocks without one.
    pub fn evaluations(&self) -> usize {
        match self {
            Self::Search(search) => search.evaluations(),
            Self::Tune(tune) => tune.evaluations.len(),
            Self::Evaluate(_) | Self::Calibrate(_) | Self::Estimate(_) | Self::Statement(_) => 0,
        }
    }

    /// Whether some criterion or constraint passed without being put to the test, or numbers that nothing judges are of runs in which nothing was at stake.
    pub fn is_untested(&self) -> bool {
        match self {
            Self::Search(search) => search.judged.as_ref().is_some_and(JudgedSearch::is_untested),
            Self::Tune(tune) => tune.failure().is_none() && !tune.untested.is_empty(),
            Self::Evaluate(evaluate) => !evaluate.untested().is_empty(),
            Self::Calibrate(_) | Self::Estimate(_) | Self::Statement(_) => false,
        }
    }

    /// Why it is not what the block was to show, or why that cannot be said; `None` if it is.
    pub fn failure(&self) -> Option<String> {
        match self {
            Self::Search(search) => search.failure(),
            Self::Evaluate(_) | Self::Calibrate(_) => None,
            Self::Tune(tune) => tune.failure(),
            Self::Estimate(estimate) => estimate.failure(),
            Self::Statement(statement) => statement.failure(),
        }
    }
}
