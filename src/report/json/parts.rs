//! Parts of written results that layouts have in common: runs, verdicts and faults, read back.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::error::{ResultsError, contradiction};
use numbers::json;
use results::{
    ByMetric, Critical, CutOff, Finding, GateState, GateVerdict, Horizon, LeftRoad, NotJudged, Outcome,
    Outlasted, OutlastedRuns, PairPresence, Refusal, Requests, RunFault, RunsTaken, TrialVerdict, Verdict,
    WaitingStep,
};
use scenario::{Draw, FaultKind, Individual, Origin, ProgramFault};
use sim::Ending;
use sim::measure::Open;

/// One run, of any layout.
#[derive(Deserialize)]
pub(super) struct Run {
    pub key: String,
    #[serde(with = "json::whole")]
    pub seed: u64,
    individuals: Vec<Individual>,
    #[serde(default)]
    drawn: Vec<Draw>,
    ending: Ending,
    pub metrics: Map<String, Value>,
    #[serde(default)]
    open: BTreeMap<String, Open>,
    #[serde(with = "json::hexadecimal")]
    fingerprint: u64,
    #[serde(default)]
    record: Option<RunRecord>,
}

#[derive(Deserialize)]
struct RunRecord {
    critical: ByMetric<Critical>,
    presences: Vec<PairPresence>,
    wall_time: Duration,
    #[serde(default)]
    waiting_steps: Vec<WaitingStep>,
    #[serde(default)]
    left_road: Vec<Arc<str>>,
    #[serde(default)]
    outlasted: Vec<Outlasted>,
    #[serde(default)]
    cut_off: Option<Box<CutOff>>,
}

impl Run {
    pub(super) fn outcome(mut self, requests: &Requests) -> Result<Outcome, ResultsError> {
        let value = |reference: &scenario::MetricReference| {
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
                waiting_steps: Vec::new(),
                left_road: Vec::new(),
                outlasted: Vec::new(),
                wall_time: Duration::ZERO,
                cut_off: (!self.open.is_empty())
                    .then(|| Box::new(CutOff { open: open.collect(), ..CutOff::default() })),
            }
        });
        Ok(Outcome {
            key: self.key,
            seed: self.seed,
            individuals: self.individuals,
            drawn: self.drawn,
            ending: self.ending,
            metrics,
            critical: record.critical,
            presences: record.presences,
            waiting_steps: record.waiting_steps,
            left_road: record.left_road,
            outlasted: record.outlasted,
            cut_off: record.cut_off,
            fingerprint: self.fingerprint,
            wall_time: record.wall_time,
        })
    }
}

/// A trial's verdict, which has to be that of its findings.
pub(super) fn judged(
    key: &str,
    verdict: &str,
    findings: Vec<Finding>,
    stopping: Option<RunsTaken>,
    horizon: Option<Horizon>,
    (never_began, left_road, outlasted): (Vec<WaitingStep>, Vec<LeftRoad>, Vec<OutlastedRuns>),
) -> Result<TrialVerdict, ResultsError> {
    let worst = findings.iter().map(|finding| finding.verdict).max().unwrap_or(Verdict::Passed);
    if !says(verdict, worst) {
        let what = format!("its verdict is `{verdict}`, and the worst of its findings is another");
        return Err(contradiction(key, what));
    }
    Ok(TrialVerdict { verdict: worst, findings, stopping, horizon, never_began, left_road, outlasted })
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
            if !says(verdict, result.verdict) {
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

/// Whether a word is that of a verdict, of a unit or of all.
pub(super) fn says(word: &str, verdict: impl Serialize) -> bool {
    serde_json::to_value(verdict).is_ok_and(|said| said == word)
}

/// A run that a program kept from its end, as it is written.
#[derive(Deserialize)]
pub(super) struct FaultOfRun {
    run: String,
    vehicle: String,
    controller: String,
    declared: Box<Origin>,
    fault: FaultInWords,
}

#[derive(Deserialize)]
struct FaultInWords {
    kind: FaultKind,
    time: f64,
    message: String,
    log: Option<String>,
    log_tail: Vec<String>,
}

pub(super) fn faults(written: Vec<FaultOfRun>) -> Vec<RunFault> {
    let fault = |FaultOfRun { run, vehicle, controller, declared, fault }: FaultOfRun| {
        let FaultInWords { kind, time, message, log, log_tail } = fault;
        let fault = ProgramFault { kind, message, controller, declared, log_tail, log };
        RunFault { run, vehicle, time, fault }
    };
    written.into_iter().map(fault).collect()
}
