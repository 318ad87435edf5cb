//! A suite's blocks on the page: what each came to in a line, and its section.

use serde::Serialize;

use super::{calibrate, estimate, evaluate, search, tune};
use crate::failure::render_block_failure;
use crate::wording::FOUND;
use results::{BlockReport, BlockResult, BlockState, SuiteReport, Verdict};
use scenario::Block;

#[derive(Debug, Serialize)]
pub struct BlockSection {
    kind: &'static str,
    name: String,
    doc: String,
    state: &'static str,
    /// Of the page's style.
    class: &'static str,
    mark: &'static str,
    /// What it came to, in a line.
    summary: String,
    seconds: String,
    /// Why it has no result, or one that is not what it was to show.
    failure: Option<String>,
    /// Runs it again.
    command: String,
    search: Option<search::SearchSection>,
    tune: Option<tune::TuneSection>,
    evaluate: Option<evaluate::EvaluateSection>,
    calibrate: Option<calibrate::CalibrateSection>,
    estimate: Option<estimate::EstimateSection>,
}

impl BlockSection {
    /// Every block of a suite but its statements, which stand in a table of their own.
    pub fn all(report: &SuiteReport) -> Vec<Self> {
        let others = report.blocks.iter().filter(|block| !matches!(*block.block, Block::Statement(_)));
        others.map(|block| Self::new(report, block)).collect()
    }

    fn new(report: &SuiteReport, block: &BlockReport) -> Self {
        let (state, mark) = match (&block.state, block.verdict()) {
            (BlockState::Skipped(_), _) => ("skipped", "–"),
            (BlockState::Errored(_), _) => ("error", "!"),
            (BlockState::NotFinished(_), _) => ("not finished", "■"),
            (_, Some(Verdict::Failed)) => ("failed", "✗"),
            (_, Some(Verdict::Inconclusive)) => ("inconclusive", "?"),
            (_, Some(Verdict::Passed)) => ("passed", "✓"),
            (_, None) => (FOUND, "–"),
        };
        let failure = render_block_failure(&report.identity, block, false);
        let mut section = Self {
            kind: block.block.kind(),
            name: block.block.name().to_string(),
            doc: block.block.doc().unwrap_or_default().to_string(),
            state,
            class: if state == FOUND { "quiet" } else { state },
            mark,
            summary: String::new(),
            seconds: format!("{:.2}", block.wall_time.as_secs_f64()),
            failure: (!failure.is_empty()).then_some(failure),
            command: report.identity.block_command(&block.key),
            search: None,
            tune: None,
            evaluate: None,
            calibrate: None,
            estimate: None,
        };
        section.fill(report, block);
        section
    }

    fn fill(&mut self, report: &SuiteReport, block: &BlockReport) {
        let result = match &block.state {
            BlockState::Finished(result) => result.as_ref(),
            BlockState::Errored(error) => return self.summary = error.message.clone(),
            BlockState::NotFinished(cut) => return self.summary = cut.to_string(),
            BlockState::Skipped(reason) => return self.summary = reason.to_string(),
        };
        match (&*block.block, result) {
            (Block::Search(search), BlockResult::Search(result)) => {
                self.summary = search::SearchSection::summary(search, result);
                self.search = Some(search::SearchSection::new(report, search, result));
            }
            (Block::Tune(tune), BlockResult::Tune(result)) => {
                self.summary = tune::TuneSection::summary(tune, result);
                self.tune = Some(tune::TuneSection::new(tune, result));
            }
            (Block::Evaluate(evaluate), BlockResult::Evaluate(result)) => {
                self.summary = evaluate::EvaluateSection::summary(result);
                self.evaluate = Some(evaluate::EvaluateSection::new(report, evaluate, result));
            }
            (Block::Calibrate(_), BlockResult::Calibrate(result)) => {
                self.summary = calibrate::CalibrateSection::summary(result);
                self.calibrate = Some(calibrate::CalibrateSection::new(result));
            }
            (Block::Estimate(_), BlockResult::Estimate(result)) => {
                self.summary = estimate::EstimateSection::summary(result);
                self.estimate = Some(estimate::EstimateSection::new(report, result));
            }
            // A result of another kind than its block cannot be; nothing would be shown of it.
            _ => {}
        }
    }
}
