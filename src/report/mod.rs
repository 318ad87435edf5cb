//! Results for people and machines: one file a format.

mod baseline;
pub mod chart;
mod columns;
mod csv;
mod cut;
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
mod groups;
#[cfg(test)]
mod hostile;
mod html;
mod json;
mod junit;
mod models;
mod pages;
mod recorded;
mod recording;
mod replay;
mod repository;
mod rows;
mod runs;
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

use thiserror::Error;

use crate::experiment::{Block, BlockResult};
use crate::judge::gate::GateVerdict;
use crate::judge::{self, Finding, TrialVerdict, Verdict};
use crate::plan::Trial;
use crate::run::Outcome;
use crate::scenario::Gate;

pub use baseline::{Form, render_baseline, render_difference};
pub use csv::write_csv;
pub use cut::{Cut, CutBy};
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
pub use json::write_json;
pub use junit::write_junit;
pub use models::{render_model, render_models};
pub use pages::{ModelPage, model_pages};
pub use recorded::{RecordedReport, RecordedState, Rerun};
pub use recording::{PairCourse, Place, Recording};
pub use replay::{
    ReplayIntroduction, block_command, case_values, record_command, render_replay, replay_command,
    replay_reasons, set_options,
};
pub use repository::Repository;
pub use runs::write_runs;
pub use shrunk::{SHRUNK_BY, render_shrunk, run_words, shrunk_file};
pub use skip::Skip;
pub use statement::{claim_values, conclusion_words, render_statement, render_statements};
pub use table::render_tables;
pub use tap::write_tap;
pub use terminal::{Live, StatusLevel, Terminal};
pub use trace::write_trace;
use wording::verdict_word;

/// Which suite was run, and how to run it again.
#[derive(Debug, Clone, Copy)]
pub struct SuiteIdentity<'a> {
    pub suite: &'a str,
    /// The file that was run, as the user named it.
    pub file: &'a str,
    pub seed: u64,
    /// What was set on the command line: `av.speed=40km/h`.
    pub set: &'a [String],
}

impl SuiteIdentity<'_> {
    /// `seed 1`, or `seed 1, with av.speed=40km/h` where the runs are not those that the file declares.
    pub fn seed_words(&self) -> String {
        match self.set {
            [] => format!("seed {}", self.seed),
            set => format!("seed {}, with {}", self.seed, set.join(", ")),
        }
    }
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
    /// Whether somebody interrupted it before all that was to be done was done.
    pub interrupted: bool,
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
    /// The runs to judge are not all there.
    NotJudged(NotJudged),
}

/// Why nobody looked at a gate: not all runs of its suite are there.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum NotJudged {
    /// Nothing of its suite was to be run.
    #[error("nothing of its suite was selected")]
    NotSelected,
    /// A filter, a share of several machines, or an early end left some out.
    #[error("{left_out} of {trials} trials were not run, and part of a suite says nothing about the whole")]
    Part { left_out: usize, trials: usize },
    /// A trial that came to nothing: which, and what happened.
    #[error("{0}")]
    Incomplete(String),
    /// The runs that a trial did not need for its own verdict could not be run.
    #[error("{0}")]
    Broken(String),
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
    /// Begun, and cut off.
    NotFinished(Cut),
    /// Nobody tried to run it.
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
    /// Begun, and cut off.
    NotFinished(Cut),
    /// Nobody tried to run it.
    Skipped(Skip),
}

impl SuiteReport<'_> {
    /// How every unit of the suite stands.
    pub fn standings(&self) -> impl Iterator<Item = Standing> {
        let recorded = self.recorded.iter().map(RecordedReport::standing);
        let trials = self.trials.iter().map(TrialReport::standing);
        recorded.chain(trials).chain(self.blocks.iter().map(BlockReport::standing))
    }
}

impl GateReport<'_> {
    /// Whether nobody looked at it.
    pub fn skipped(&self) -> bool {
        matches!(self.state, GateState::NotJudged(_))
    }

    /// Whether nobody looked at it though something of its suite was run: it may be that it would have failed.
    pub fn is_open(&self) -> bool {
        matches!(&self.state, GateState::NotJudged(why) if *why != NotJudged::NotSelected)
    }

    pub fn verdict(&self) -> Option<Verdict> {
        match &self.state {
            GateState::Judged(verdict) => Some(verdict.verdict),
            GateState::Refused(_) | GateState::NotJudged(_) => None,
        }
    }

    pub fn standing(&self) -> Standing {
        match &self.state {
            GateState::NotJudged(NotJudged::Broken(_)) => Standing::Errored,
            _ => Standing::of(self.skipped(), self.verdict()),
        }
    }
}

impl BlockReport<'_> {
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

    pub fn verdict(&self) -> Option<Verdict> {
        self.result().map(|result| if result.failure().is_some() { Verdict::Failed } else { Verdict::Passed })
    }

    pub fn standing(&self) -> Standing {
        match &self.state {
            BlockState::NotFinished(cut) => Standing::NotFinished(cut.by()),
            _ => Standing::of(self.skipped(), self.verdict()),
        }
    }
}

impl TrialReport<'_> {
    /// What was found of each of its criteria, if it was run.
    pub fn findings(&self) -> &[Finding] {
        match &self.state {
            TrialState::Judged(judged) => &judged.findings,
            TrialState::Errored(_) | TrialState::NotFinished(_) | TrialState::Skipped(_) => &[],
        }
    }

    /// How many runs it took, where they were added until it was decided.
    pub fn stopping(&self) -> Option<&judge::Stopping> {
        match &self.state {
            TrialState::Judged(judged) => judged.stopping.as_ref(),
            TrialState::Errored(_) | TrialState::NotFinished(_) | TrialState::Skipped(_) => None,
        }
    }

    /// Whether nobody tried to run it.
    pub fn skipped(&self) -> bool {
        self.skip().is_some()
    }

    /// Why nobody tried to run it.
    pub fn skip(&self) -> Option<&Skip> {
        match &self.state {
            TrialState::Skipped(skip) => Some(skip),
            _ => None,
        }
    }

    pub fn verdict(&self) -> Option<Verdict> {
        match &self.state {
            TrialState::Judged(judged) => Some(judged.verdict),
            TrialState::Errored(_) | TrialState::NotFinished(_) | TrialState::Skipped(_) => None,
        }
    }

    /// Whether it was run, but no criterion applied to it: it passed nothing.
    pub fn claims_nothing(&self) -> bool {
        matches!(&self.state, TrialState::Judged(judged) if judged.claims_nothing())
    }

    pub fn standing(&self) -> Standing {
        match &self.state {
            TrialState::NotFinished(cut) => Standing::NotFinished(cut.by()),
            TrialState::Judged(judged) if judged.claims_nothing() => Standing::NotJudged,
            _ => Standing::of(self.skipped(), self.verdict()),
        }
    }
}
