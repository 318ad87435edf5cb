//! Results read back from JSON, so that reports can be made of them later.

use crate::numbers::json;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use serde::Deserialize;
use serde_json::{Map, Value};
use thiserror::Error;

use super::LAYOUT;
use super::first_layout;
use crate::files::{self, ReadError};
use crate::metrics::{Open, Presence};
use crate::results::{
    BlockReport, BlockResult, BlockState, ByMetric, Chosen, Critical, Cut, CutOff, Finding, GateReport,
    GateState, GateVerdict, Horizon, NotJudged, Outcome, Recorded, RecordedReport, RecordedState, Recording,
    Refusal, Requests, Results, RunsTaken, Skip, SuiteIdentity, SuiteReport, TrialReport, TrialState,
    TrialVerdict, Verdict,
};
use crate::scenario::{Block, Gate, Individual, Trial};
use crate::sim::Ending;

/// The largest file that is read: about a million runs.
const LARGEST: u64 = 2 << 30;

/// Why a file is not taken for results.
#[derive(Debug, Error)]
pub enum ResultsError {
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Cut off, of another program, or changed by hand.
    #[error("it is not what `--json` writes: {0}")]
    Format(#[from] serde_json::Error),
    #[error("its layout is {0}, and this version reads 1 to {LAYOUT}; use the version that wrote it")]
    Layout(u64),
    /// What it says of itself is not what its parts say.
    #[error("{key}: {what}")]
    Contradiction { key: String, what: String },
    /// Something that version 0.1 did not write down.
    #[error("{key}: {what}; it was written by 0.1, so run the suite again with this version")]
    Lacking { key: String, what: String },
}

/// Reads what [`super::write_json`] wrote, of this version or of 0.1.
///
/// # Errors
/// [`ResultsError`].
pub fn read_results(path: &Path) -> Result<Results, ResultsError> {
    results_of(&files::read_bytes(path, LARGEST)?)
}

/// As [`read_results`], of a file's bytes.
pub(super) fn results_of(bytes: &[u8]) -> Result<Results, ResultsError> {
    #[derive(Deserialize)]
    struct Layout {
        layout: u64,
    }
    match serde_json::from_slice::<Layout>(bytes)?.layout {
        1 => first_layout::results(serde_json::from_slice(bytes)?),
        2 => serde_json::from_slice::<Document>(bytes)?.results(),
        other => Err(ResultsError::Layout(other)),
    }
}

#[derive(Deserialize)]
struct Document {
    record: DocumentRecord,
    suites: Vec<Suite>,
}

#[derive(Deserialize)]
struct DocumentRecord {
    requests: Requests,
    recordings: Vec<(Chosen, Recording)>,
}

#[derive(Deserialize)]
struct Suite {
    #[serde(flatten)]
    identity: SuiteIdentity,
    wall_time_s: f64,
    interrupted: bool,
    record: SuiteRecord,
    recorded: Vec<RecordedRun>,
    trials: Vec<TrialOfSuite>,
    blocks: Vec<BlockOfSuite>,
    gates: Vec<GateOfSuite>,
}

#[derive(Deserialize)]
struct SuiteRecord {
    started: SystemTime,
}

#[derive(Deserialize)]
struct RecordedRun {
    key: String,
    wall_time_s: f64,
    record: RecordedRecord,
}

#[derive(Deserialize)]
struct RecordedRecord {
    recorded: Arc<Recorded>,
    state: RecordedState,
}

#[derive(Deserialize)]
struct TrialOfSuite {
    key: String,
    verdict: String,
    #[serde(default)]
    message: Option<String>,
    wall_time_s: f64,
    #[serde(default)]
    findings: Vec<Finding>,
    #[serde(default)]
    stopping: Option<RunsTaken>,
    #[serde(default)]
    horizon: Option<Horizon>,
    runs: Vec<Run>,
    record: TrialRecord,
}

#[derive(Deserialize)]
struct TrialRecord {
    trial: Arc<Trial>,
    departures: Vec<String>,
    #[serde(default)]
    cut: Option<Cut>,
    #[serde(default)]
    skip: Option<Skip>,
}

/// One run, of any layout.
#[derive(Deserialize)]
pub(super) struct Run {
    pub key: String,
    #[serde(with = "json::whole")]
    pub seed: u64,
    individuals: Vec<Individual>,
    ending: Ending,
    pub metrics: Map<String, Value>,
    #[serde(default)]
    open: std::collections::BTreeMap<String, Open>,
    #[serde(with = "json::hexadecimal")]
    fingerprint: u64,
    #[serde(default)]
    record: Option<RunRecord>,
}

#[derive(Deserialize)]
struct RunRecord {
    critical: ByMetric<Critical>,
    presences: Vec<(Arc<str>, Presence)>,
    wall_time: Duration,
    #[serde(default)]
    cut_off: Option<Box<CutOff>>,
}

#[derive(Deserialize)]
struct BlockOfSuite {
    key: String,
    verdict: String,
    #[serde(default)]
    message: Option<String>,
    wall_time_s: f64,
    #[serde(default)]
    result: Option<Box<BlockResult>>,
    record: BlockRecord,
}

#[derive(Deserialize)]
struct BlockRecord {
    block: Arc<Block>,
    #[serde(default)]
    cut: Option<Cut>,
    #[serde(default)]
    skip: Option<Skip>,
}

#[derive(Deserialize)]
struct GateOfSuite {
    key: String,
    verdict: String,
    #[serde(default)]
    result: Option<Box<GateVerdict>>,
    #[serde(flatten)]
    refusal: Option<Refusal>,
    record: GateRecord,
}

#[derive(Deserialize)]
struct GateRecord {
    gate: Arc<Gate>,
    #[serde(default)]
    not_judged: Option<NotJudged>,
}

impl Document {
    fn results(self) -> Result<Results, ResultsError> {
        let DocumentRecord { requests, recordings } = self.record;
        let suites = self.suites.into_iter().map(|suite| suite.report(&requests));
        let suites = suites.collect::<Result<_, _>>()?;
        Ok(Results { requests, suites, recordings })
    }
}

impl Suite {
    fn report(self, requests: &Requests) -> Result<SuiteReport, ResultsError> {
        Ok(SuiteReport {
            identity: self.identity,
            started: self.record.started,
            wall_time: seconds("suite", self.wall_time_s)?,
            recorded: self.recorded.into_iter().map(RecordedRun::report).collect::<Result<_, _>>()?,
            trials: self.trials.into_iter().map(|one| one.report(requests)).collect::<Result<_, _>>()?,
            blocks: self.blocks.into_iter().map(BlockOfSuite::report).collect::<Result<_, _>>()?,
            gates: self.gates.into_iter().map(GateOfSuite::report).collect::<Result<_, _>>()?,
            interrupted: self.interrupted,
        })
    }
}

impl RecordedRun {
    fn report(self) -> Result<RecordedReport, ResultsError> {
        let RecordedRecord { recorded, state } = self.record;
        let wall_time = seconds(&self.key, self.wall_time_s)?;
        Ok(RecordedReport { recorded, key: self.key, state, wall_time })
    }
}

impl TrialOfSuite {
    fn report(self, requests: &Requests) -> Result<TrialReport, ResultsError> {
        let TrialRecord { trial, departures, cut, skip } = self.record;
        let runs = self.runs.into_iter().map(|run| run.outcome(requests));
        let outcomes: Vec<Outcome> = runs.collect::<Result<_, _>>()?;
        let state = match (self.verdict.as_str(), self.message, cut, skip) {
            ("error", Some(message), None, None) => TrialState::Errored(message),
            ("not_finished", _, Some(cut), None) => TrialState::NotFinished(cut),
            ("skipped", _, None, Some(skip)) => TrialState::Skipped(skip),
            (verdict, None, None, None) => {
                TrialState::Judged(judged(&trial.key, verdict, self.findings, self.stopping, self.horizon)?)
            }
            (verdict, ..) => return Err(contradiction(&self.key, format!("`{verdict}` without its reason"))),
        };
        if trial.key != self.key {
            return Err(contradiction(&self.key, format!("it records the trial {}", trial.key)));
        }
        let wall_time = seconds(&self.key, self.wall_time_s)?;
        Ok(TrialReport { trial, outcomes, state, departures, wall_time })
    }
}

/// A trial's verdict, which has to be that of its findings.
pub(super) fn judged(
    key: &str,
    verdict: &str,
    findings: Vec<Finding>,
    stopping: Option<RunsTaken>,
    horizon: Option<Horizon>,
) -> Result<TrialVerdict, ResultsError> {
    let worst = findings.iter().map(|finding| finding.verdict).max().unwrap_or(Verdict::Passed);
    let said: Verdict = serde_json::from_value(verdict.into())?;
    if said != worst {
        let what = format!("its verdict is `{verdict}`, and the worst of its findings is another");
        return Err(contradiction(key, what));
    }
    Ok(TrialVerdict { verdict: worst, findings, stopping, horizon })
}

impl Run {
    pub(super) fn outcome(mut self, requests: &Requests) -> Result<Outcome, ResultsError> {
        let value = |reference: &crate::scenario::MetricReference| {
            let label = reference.label();
            match self.metrics.remove(&label) {
                Some(Value::Null) => Ok(None),
                Some(Value::Number(number)) => Ok(number.as_f64()),
                _ => Err(contradiction(&self.key, format!("it has no `{label}`"))),
            }
        };
        let metrics = requests.iter().map(value).collect::<Result<_, _>>()?;
        if let Some(other) = self.metrics.keys().next() {
            return Err(contradiction(&self.key, format!("nothing asked for its `{other}`")));
        }
        let record = self.record.unwrap_or_else(|| {
            let open = requests.iter().map(|reference| self.open.get(&reference.label()).copied());
            RunRecord {
                critical: ByMetric::default(),
                presences: Vec::new(),
                wall_time: Duration::ZERO,
                cut_off: (!self.open.is_empty())
                    .then(|| Box::new(CutOff { open: open.collect(), ..CutOff::default() })),
            }
        });
        Ok(Outcome {
            key: self.key,
            seed: self.seed,
            individuals: self.individuals,
            ending: self.ending,
            metrics,
            critical: record.critical,
            presences: record.presences,
            cut_off: record.cut_off,
            fingerprint: self.fingerprint,
            wall_time: record.wall_time,
        })
    }
}

impl BlockOfSuite {
    fn report(self) -> Result<BlockReport, ResultsError> {
        let BlockRecord { block, cut, skip } = self.record;
        let verdict = self.verdict.as_str();
        let state = match (verdict, self.result, self.message, cut, skip) {
            ("passed" | "failed", Some(result), _, None, None) => {
                if (verdict == "failed") != result.failure().is_some() {
                    let what = format!("its verdict is `{verdict}`, and its result says otherwise");
                    return Err(contradiction(&self.key, what));
                }
                BlockState::Finished(result)
            }
            ("error", None, Some(message), None, None) => BlockState::Errored(message),
            ("not_finished", None, _, Some(cut), None) => BlockState::NotFinished(cut),
            ("skipped", None, _, None, Some(skip)) => BlockState::Skipped(skip),
            _ => return Err(contradiction(&self.key, format!("`{verdict}` without its reason"))),
        };
        let wall_time = seconds(&self.key, self.wall_time_s)?;
        Ok(BlockReport { block, key: self.key, state, wall_time })
    }
}

impl GateOfSuite {
    fn report(self) -> Result<GateReport, ResultsError> {
        let GateRecord { gate, not_judged } = self.record;
        let state = gate_state(&self.key, &self.verdict, self.result, self.refusal, not_judged)?;
        Ok(GateReport { gate, key: self.key, state })
    }
}

/// What became of a gate, whose verdict has to be that of its result.
pub(super) fn gate_state(
    key: &str,
    verdict: &str,
    result: Option<Box<GateVerdict>>,
    refusal: Option<Refusal>,
    not_judged: Option<NotJudged>,
) -> Result<GateState, ResultsError> {
    match (verdict, result, refusal, not_judged) {
        ("error", None, Some(refusal), None) => Ok(GateState::Refused(refusal)),
        ("not_judged", None, _, Some(why)) => Ok(GateState::NotJudged(why)),
        ("passed" | "inconclusive" | "failed", Some(result), _, None) => {
            let said: Verdict = serde_json::from_value(verdict.into())?;
            if said != result.verdict {
                return Err(contradiction(
                    key,
                    format!("its verdict is `{verdict}`, and its result another"),
                ));
            }
            Ok(GateState::Judged(result))
        }
        (verdict, ..) => Err(contradiction(key, format!("`{verdict}` without its reason"))),
    }
}

pub(super) fn contradiction(key: &str, what: impl Into<String>) -> ResultsError {
    ResultsError::Contradiction { key: key.to_string(), what: what.into() }
}

pub(super) fn seconds(key: &str, seconds: f64) -> Result<Duration, ResultsError> {
    let wrong = |error: std::time::TryFromFloatSecsError| contradiction(key, error.to_string());
    Duration::try_from_secs_f64(seconds).map_err(wrong)
}
