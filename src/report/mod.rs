//! Results for people and machines: one file a format.

mod baseline;
pub mod chart;
mod columns;
mod digest;
mod evaluation;
mod event;
mod excerpt;
mod experiment;
mod failure;
mod figures;
pub mod findings;
#[cfg(test)]
mod fixture;
mod format;
mod found;
mod gate;
mod gate_markdown;
mod github;
mod html;
mod json;
mod junit;
mod models;
mod pages;
mod recorded;
mod recording;
mod replay;
#[cfg(test)]
mod schema;
mod shrunk;
mod skip;
mod statement;
mod table;
mod tap;
mod terminal;
mod trace;
mod variable;
mod wording;

use std::time::Duration;

use crate::experiment::{Block, BlockResult};
use crate::judge::gate::GateVerdict;
use crate::judge::{self, Finding, TrialVerdict, Verdict};
use crate::plan::Trial;
use crate::run::Outcome;
use crate::scenario::Gate;

pub use baseline::{Form, render_baseline, render_difference};
pub use evaluation::render_evaluate;
pub use event::{Evaluations, Event, Outline, Reporter, Standing, Stopping, UnitReport};
pub use excerpt::Excerpt;
pub use experiment::{render_block, render_tune, tuned_parameters};
pub use failure::{explain, render_block_failure, render_failure, with_worst};
pub use figures::{Figure, figures};
pub use format::{count, in_unit, quantity, share};
pub use found::render_search;
pub use gate::{Replay, render_gate, render_gate_report, render_gates, render_reason};
pub use gate_markdown::gate_markdown;
pub use github::{annotations, step_summary};
pub use html::{Chosen, choose_runs, to_html};
pub use json::to_json;
pub use junit::to_junit;
pub use models::{registered_names, render_model, render_models};
pub use pages::{ModelPage, model_pages};
pub use recorded::{RecordedReport, RecordedState, Rerun};
pub use recording::{PairCourse, Place, Recording};
pub use replay::{block_command, record_command, render_replay, replay_command};
pub use shrunk::{render_shrunk, run_words, shrunk_file};
pub use skip::Skip;
pub use statement::{claim_values, conclusion_words, render_statement, render_statements};
pub use table::render_tables;
pub use tap::to_tap;
pub use terminal::{Live, StatusLevel, Terminal};
pub use trace::write_trace;

/// Which suite was run, and how to run it again.
#[derive(Debug, Clone, Copy)]
pub struct SuiteIdentity<'a> {
    pub suite: &'a str,
    /// The file that was run, as the user named it.
    pub file: &'a str,
    pub seed: u64,
}

/// What reports are made of: a suite's trials with what became of them.
#[derive(Debug)]
pub struct SuiteReport<'a> {
    pub identity: SuiteIdentity<'a>,
    /// Wall-clock time when the suite began.
    pub started: std::time::SystemTime,
    pub wall_time: Duration,
    /// Runs that failed in an earlier session, run again before everything else.
    pub recorded: Vec<RecordedReport<'a>>,
    pub trials: Vec<TrialReport<'a>>,
    /// The suite's blocks, each after what it builds on.
    pub blocks: Vec<BlockReport<'a>>,
    /// The suite's gates; empty until all of its trials are judged.
    pub gates: Vec<GateReport<'a>>,
}

/// What became of a gate.
#[derive(Debug)]
pub struct GateReport<'a> {
    pub gate: &'a Gate,
    /// Such as `zebra/gate=braking`.
    pub key: String,
    pub state: GateState,
}

#[derive(Debug, Clone)]
pub enum GateState {
    Judged(Box<GateVerdict>),
    /// There is no baseline, or it may not be compared with.
    Refused(Refusal),
    /// Not every trial was run to its end; the message says which.
    Skipped(String),
}

/// Why a gate cannot be judged.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    pub message: String,
    /// Every reason not to compare, if there is a baseline.
    pub reasons: Vec<String>,
    /// What to do.
    pub help: String,
}

#[derive(Debug)]
pub struct TrialReport<'a> {
    pub trial: &'a Trial,
    /// Empty if it was not run.
    pub outcomes: Vec<Outcome>,
    pub state: TrialState,
    pub wall_time: Duration,
}

#[derive(Debug, Clone, PartialEq)]
pub enum TrialState {
    Judged(TrialVerdict),
    /// Could not be run to its end; the message says why.
    Errored(String),
    Skipped(Skip),
}

/// What became of a `search`, a `tune` or whatever else a suite computes besides its trials.
#[derive(Debug)]
pub struct BlockReport<'a> {
    pub block: Block<'a>,
    /// Such as `zebra/search=low_pet`.
    pub key: String,
    pub state: BlockState,
    pub wall_time: Duration,
}

#[derive(Debug, Clone)]
pub enum BlockState {
    /// It came to a result, which may still [fail](BlockResult::failure).
    Finished(Box<BlockResult>),
    /// Could not be run to its end; the message says why.
    Errored(String),
    Skipped(Skip),
}

impl GateReport<'_> {
    pub fn skipped(&self) -> bool {
        matches!(self.state, GateState::Skipped(_))
    }

    pub fn verdict(&self) -> Option<Verdict> {
        match &self.state {
            GateState::Judged(verdict) => Some(verdict.verdict),
            GateState::Refused(_) | GateState::Skipped(_) => None,
        }
    }

    pub fn standing(&self) -> Standing {
        Standing::of(self.skipped(), self.verdict())
    }
}

impl BlockReport<'_> {
    /// Whether nobody tried to run it, or it was cut off.
    pub fn skipped(&self) -> bool {
        self.skip().is_some()
    }

    /// Why nobody tried to run it, or it was cut off.
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
            BlockState::Errored(_) | BlockState::Skipped(_) => None,
        }
    }

    pub fn verdict(&self) -> Option<Verdict> {
        self.result().map(|result| if result.failure().is_some() { Verdict::Failed } else { Verdict::Passed })
    }

    pub fn standing(&self) -> Standing {
        Standing::of(self.skipped(), self.verdict())
    }
}

impl TrialReport<'_> {
    /// What was found of each of its criteria, if it was run.
    pub fn findings(&self) -> &[Finding] {
        match &self.state {
            TrialState::Judged(judged) => &judged.findings,
            TrialState::Errored(_) | TrialState::Skipped(_) => &[],
        }
    }

    /// How many runs it took, where they were added until it was decided.
    pub fn stopping(&self) -> Option<&judge::Stopping> {
        match &self.state {
            TrialState::Judged(judged) => judged.stopping.as_ref(),
            TrialState::Errored(_) | TrialState::Skipped(_) => None,
        }
    }

    /// Whether nobody tried to run it, or it was cut off.
    pub fn skipped(&self) -> bool {
        self.skip().is_some()
    }

    /// Why nobody tried to run it, or it was cut off.
    pub fn skip(&self) -> Option<&Skip> {
        match &self.state {
            TrialState::Skipped(skip) => Some(skip),
            _ => None,
        }
    }

    pub fn verdict(&self) -> Option<Verdict> {
        match &self.state {
            TrialState::Judged(judged) => Some(judged.verdict),
            TrialState::Errored(_) | TrialState::Skipped(_) => None,
        }
    }

    pub fn standing(&self) -> Standing {
        Standing::of(self.skipped(), self.verdict())
    }
}
