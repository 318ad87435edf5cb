//! The blocks of a suite as units of work that build on each other.

use std::collections::HashMap;

use serde::Serialize;

use super::{
    EvaluateResult, ExperimentError, Laboratory, Progress, SearchResult, StatementResult, TuneResult,
    run_evaluate, run_search, run_statement, run_tune, statement,
};
use crate::run::Outcome;
use crate::scenario::{
    Case, CaseSet, Evaluate, Origin, OutcomesOf, ParameterSet, SampleSize, Search, Statement, Suite, Tune,
};

/// Something in a suite that takes simulations and gives one result.
#[derive(Debug, Clone, Copy)]
pub enum Block<'a> {
    Search(&'a Search),
    Tune(&'a Tune),
    Evaluate(&'a Evaluate),
    Statement(&'a Statement),
}

/// What a block has to wait for.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Need {
    /// The result of the block of this name.
    Block(String),
    /// Every run of the scenario of this name.
    Scenario(String),
}

/// What a block came to.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "snake_case")]
// There are few of them and nobody moves them about.
#[allow(clippy::large_enum_variant)]
pub enum BlockResult {
    Search(SearchResult),
    Tune(TuneResult),
    Evaluate(EvaluateResult),
    Statement(StatementResult),
}

/// What is known so far; later blocks read it.
#[derive(Debug, Default)]
pub struct Results {
    /// By name of the block.
    pub blocks: HashMap<String, BlockResult>,
    /// Every run, by name of the scenario; only scenarios that some block needs, and only once they are complete. Their
    /// metrics are in the order of the laboratory's requests.
    pub scenarios: HashMap<String, Vec<(Case, Outcome)>>,
}

impl<'a> Block<'a> {
    /// Every block of a suite in an order in which each comes after what it needs.
    pub fn all(suite: &'a Suite) -> Vec<Self> {
        let searches = suite.searches.iter().map(Self::Search);
        let tunes = suite.tunes.iter().map(Self::Tune);
        let evaluates = suite.evaluates.iter().map(Self::Evaluate);
        let statements = suite.statements.iter().map(Self::Statement);
        searches.chain(tunes).chain(evaluates).chain(statements).collect()
    }

    pub fn name(&self) -> &'a str {
        match self {
            Self::Search(search) => &search.name,
            Self::Tune(tune) => &tune.name,
            Self::Evaluate(evaluate) => &evaluate.name,
            Self::Statement(statement) => &statement.name,
        }
    }

    /// The word that declares it, such as `search`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Search(_) => "search",
            Self::Tune(_) => "tune",
            Self::Evaluate(_) => "evaluate",
            Self::Statement(_) => "statement",
        }
    }

    /// What reports call it: `zebra/search=low_pet`. No trial has such a key: names of scenarios have no `=`.
    pub fn key(&self, suite: &str) -> String {
        format!("{suite}/{}={}", self.kind(), self.name())
    }

    pub fn doc(&self) -> Option<&'a str> {
        match self {
            Self::Search(search) => search.doc.as_deref(),
            Self::Tune(tune) => tune.doc.as_deref(),
            Self::Evaluate(evaluate) => evaluate.doc.as_deref(),
            Self::Statement(statement) => statement.doc.as_deref(),
        }
    }

    pub fn origin(&self) -> &'a Origin {
        match self {
            Self::Search(search) => &search.origin,
            Self::Tune(tune) => &tune.origin,
            Self::Evaluate(evaluate) => &evaluate.origin,
            Self::Statement(statement) => &statement.origin,
        }
    }

    /// What it has to wait for, each once.
    pub fn needs(&self) -> Vec<Need> {
        let all = match self {
            Self::Search(_) => Vec::new(),
            Self::Tune(tune) => case_set_needs(&tune.on),
            Self::Evaluate(evaluate) => {
                let mut needs = case_set_needs(&evaluate.on);
                needs.extend(evaluate.conditions.iter().filter_map(|one| match &one.parameters {
                    ParameterSet::Tuned(tune) => Some(Need::Block(tune.clone())),
                    _ => None,
                }));
                needs
            }
            Self::Statement(statement) => {
                let of = statement::measured(statement).into_iter().map(|measured| match &measured.of {
                    OutcomesOf::Scenario(name) => Need::Scenario(name.clone()),
                    OutcomesOf::Search(name) | OutcomesOf::Condition { evaluate: name, .. } => {
                        Need::Block(name.clone())
                    }
                });
                let chosen =
                    statement::tunes(statement).into_iter().map(|name| Need::Block(name.to_string()));
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

    /// Runs it. `results` must hold what it [needs](Self::needs).
    ///
    /// # Errors
    /// Whatever keeps it from a result.
    pub fn run(
        &self,
        laboratory: &Laboratory,
        results: &Results,
        progress: &dyn Progress,
    ) -> Result<BlockResult, ExperimentError> {
        match self {
            Self::Search(search) => run_search(laboratory, search, progress).map(BlockResult::Search),
            Self::Tune(tune) => run_tune(laboratory, tune, results, progress).map(BlockResult::Tune),
            Self::Evaluate(evaluate) => {
                run_evaluate(laboratory, evaluate, results, progress).map(BlockResult::Evaluate)
            }
            Self::Statement(statement) => {
                run_statement(laboratory, statement, results).map(BlockResult::Statement)
            }
        }
    }
}

fn case_set_needs(set: &CaseSet) -> Vec<Need> {
    match set {
        CaseSet::Search(name) | CaseSet::Bests(name) => vec![Need::Block(name.clone())],
        CaseSet::Sample { count: SampleSize::AsManyAs(search), .. } => vec![Need::Block(search.clone())],
        CaseSet::Sample { .. } | CaseSet::Scenario(_) | CaseSet::Saved(_) => Vec::new(),
    }
}

impl BlockResult {
    /// Why it is not what the block was to show; `None` if it is.
    pub fn failure(&self) -> Option<String> {
        match self {
            Self::Search(_) | Self::Evaluate(_) => None,
            Self::Tune(tune) if tune.chosen.is_none() && tune.pareto.is_empty() => {
                Some("no candidate keeps every constraint: nothing is chosen".to_string())
            }
            Self::Tune(_) => None,
            Self::Statement(statement) => statement.surprise(),
        }
    }
}

impl Results {
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
