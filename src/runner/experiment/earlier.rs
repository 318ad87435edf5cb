//! What the blocks that were run before came to; later ones read it.

use std::collections::HashMap;

use super::error::ExperimentError;
use results::{BlockResult, EvaluateResult, Outcome, SearchResult, TuneResult};
use scenario::Case;

/// What is known so far; later blocks read it.
#[derive(Debug, Default)]
pub struct EarlierResults {
    /// By name of the block.
    pub blocks: HashMap<String, BlockResult>,
    /// Every run, by name of the scenario; only scenarios that some block needs, and only once they are complete. Their
    /// metrics are in the order of the context's requests.
    pub scenarios: HashMap<String, Vec<(Case, Outcome)>>,
}

impl EarlierResults {
    /// What the search of this name found.
    pub(super) fn search(&self, name: &str) -> Result<&SearchResult, ExperimentError> {
        match self.blocks.get(name) {
            Some(BlockResult::Search(search)) => Ok(search),
            _ => Err(ExperimentError::NotRun(name.to_string())),
        }
    }

    /// What the tune of this name chose.
    pub(super) fn tune(&self, name: &str) -> Result<&TuneResult, ExperimentError> {
        match self.blocks.get(name) {
            Some(BlockResult::Tune(tune)) => Ok(tune),
            _ => Err(ExperimentError::NotRun(name.to_string())),
        }
    }

    /// What the evaluation of this name measured.
    pub(super) fn evaluate(&self, name: &str) -> Result<&EvaluateResult, ExperimentError> {
        match self.blocks.get(name) {
            Some(BlockResult::Evaluate(evaluate)) => Ok(evaluate),
            _ => Err(ExperimentError::NotRun(name.to_string())),
        }
    }
}
