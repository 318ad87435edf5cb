//! The blocks of a suite as units of work that build on each other.

use std::collections::HashMap;

use super::{
    BlockProgress, Context, ExperimentError, run_evaluate, run_search, run_statement, run_tune, statement,
};
use results::{BlockResult, EvaluateResult, Outcome, SearchResult, TuneResult};
use scenario::{Block, Case, CaseSet, OutcomesOf, ParameterSet, SampleSize};

/// What a block has to wait for.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Need {
    /// The result of the block of this name.
    Block(String),
    /// Every run of the scenario of this name.
    Scenario(String),
}

/// What is known so far; later blocks read it.
#[derive(Debug, Default)]
pub struct EarlierResults {
    /// By name of the block.
    pub blocks: HashMap<String, BlockResult>,
    /// Every run, by name of the scenario; only scenarios that some block needs, and only once they are complete. Their
    /// metrics are in the order of the context's requests.
    pub scenarios: HashMap<String, Vec<(Case, Outcome)>>,
}

/// What it has to wait for, each once.
pub fn needs(block: &Block) -> Vec<Need> {
    let all = match block {
        Block::Search(_) => Vec::new(),
        Block::Tune(tune) => case_set_needs(&tune.on),
        Block::Evaluate(evaluate) => {
            let mut needs = case_set_needs(&evaluate.on);
            needs.extend(evaluate.conditions.iter().filter_map(|one| match &one.parameters {
                ParameterSet::Tuned(tune) => Some(Need::Block(tune.clone())),
                _ => None,
            }));
            needs
        }
        Block::Statement(statement) => {
            let of = statement::measured(statement).into_iter().map(|measured| match &measured.of {
                OutcomesOf::Scenario(name) => Need::Scenario(name.clone()),
                OutcomesOf::Search(name) | OutcomesOf::Condition { evaluate: name, .. } => {
                    Need::Block(name.clone())
                }
            });
            let chosen = statement::tunes(statement).into_iter().map(|name| Need::Block(name.to_string()));
            of.chain(chosen).collect()
        }
    };
    let mut needs = Vec::new();
    for need in all {
        if !needs.contains(&need) {
            needs.push(need);
        }
    }
    needs
}

/// Runs it. `results` must hold what it [needs].
///
/// # Errors
/// Whatever keeps it from a result.
pub fn run_block(
    block: &Block,
    context: &Context,
    results: &EarlierResults,
    progress: &dyn BlockProgress,
) -> Result<BlockResult, ExperimentError> {
    match block {
        Block::Search(search) => run_search(context, search, progress).map(BlockResult::Search),
        Block::Tune(tune) => run_tune(context, tune, results, progress).map(BlockResult::Tune),
        Block::Evaluate(evaluate) => {
            run_evaluate(context, evaluate, results, progress).map(BlockResult::Evaluate)
        }
        Block::Statement(statement) => run_statement(context, statement, results).map(BlockResult::Statement),
    }
}

fn case_set_needs(set: &CaseSet) -> Vec<Need> {
    match set {
        CaseSet::Search(name) | CaseSet::Bests(name) => vec![Need::Block(name.clone())],
        CaseSet::Sample { count: SampleSize::AsManyAs(search), .. } => vec![Need::Block(search.clone())],
        CaseSet::Sample { .. } | CaseSet::Scenario(_) | CaseSet::Saved(_) => Vec::new(),
    }
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
