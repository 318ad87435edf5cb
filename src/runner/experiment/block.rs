//! The blocks of a suite as units of work that build on each other.

use super::calibrate::run_calibrate;
use super::context::{BlockProgress, Context};
use super::earlier::EarlierResults;
use super::error::ExperimentError;
use super::estimate::run_estimate;
use super::evaluate::run_evaluate;
use super::search::run_search;
use super::statement::run_statement;
use super::tune::run_tune;
use results::BlockResult;
use scenario::Block;

/// Runs it. `results` must hold what it [needs](super::needs()).
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
        Block::Calibrate(calibrate) => {
            run_calibrate(context, calibrate, progress).map(BlockResult::Calibrate)
        }
        Block::Estimate(estimate) => run_estimate(context, estimate, progress).map(BlockResult::Estimate),
        Block::Statement(statement) => run_statement(context, statement, results).map(BlockResult::Statement),
    }
}
