//! Results as version 0.1 wrote them: runs and verdicts, but little of what was declared.
//!
//! Criteria are known by their findings only, and there are no courses. Blocks have nothing that reports of today could be
//! made of.

use std::sync::Arc;
use std::time::SystemTime;

use regex_lite::Regex;
use serde::Deserialize;
use serde_json::{Map, Value};

use super::error::{ResultsError, contradiction, seconds};
use super::parts::{Run, gate_state, judged};
use results::{
    Cut, CutBy, Finding, GateReport, GateVerdict, Horizon, NotJudged, Program, Recorded, RecordedReport,
    RecordedState, Refusal, Requests, Rerun, Results, RunsTaken, Skip, Stopping, SuiteIdentity, SuiteReport,
    TrialReport, TrialState,
};
use scenario::{
    Assignment, Gate, GateRule, MetricReference, Origin, Reference, Settings, Tolerance, Trial,
    Value as Setting,
};

#[derive(Deserialize)]
pub struct FirstLayout {
    tool: Tool,
    suites: Vec<Suite>,
}

#[derive(Deserialize)]
struct Tool {
    version: String,
}

#[derive(Deserialize)]
struct Suite {
    #[serde(flatten)]
    identity: SuiteIdentity,
    wall_time_s: f64,
    interrupted: bool,
    recorded: Vec<RecordedRun>,
    trials: Vec<TrialOfSuite>,
    blocks: Vec<BlockOfSuite>,
    gates: Vec<GateOfSuite>,
}

#[derive(Deserialize)]
struct RecordedRun {
    key: String,
    recorded: String,
    scenario: String,
    against: Vec<String>,
    wall_time_s: f64,
    verdict: String,
    #[serde(default)]
    message: Option<String>,
    #[serde(default)]
    same_case: bool,
    #[serde(default)]
    findings: Vec<Finding>,
    #[serde(default)]
    run: Option<Run>,
}

#[derive(Deserialize)]
struct TrialOfSuite {
    key: String,
    scenario: String,
    tags: Vec<String>,
    variation: Map<String, Value>,
    wall_time_s: f64,
    verdict: String,
    #[serde(default)]
    message: Option<String>,
    #[serde(default)]
    cut_by: Option<CutBy>,
    #[serde(default)]
    findings: Vec<Finding>,
    #[serde(default)]
    stopping: Option<RunsTaken>,
    #[serde(default)]
    horizon: Option<Horizon>,
    runs: Vec<Run>,
}

#[derive(Deserialize)]
struct BlockOfSuite {
    key: String,
}

#[derive(Deserialize)]
struct GateOfSuite {
    key: String,
    gate: String,
    rules: Vec<String>,
    verdict: String,
    #[serde(default)]
    result: Option<Box<GateVerdict>>,
    #[serde(default)]
    message: Option<String>,
    #[serde(default)]
    reasons: Vec<String>,
    #[serde(default)]
    help: Option<String>,
}

pub fn results(document: FirstLayout) -> Result<Results, ResultsError> {
    let requests = requests(&document)?;
    let program = Program { version: document.tool.version, platform: "not known".into() };
    let suites = document.suites.into_iter().map(|suite| suite.report(&requests, &program));
    let suites = suites.collect::<Result<_, _>>()?;
    Ok(Results { requests, suites, recordings: Vec::new(), denies_untested: false })
}

/// What was measured, by the labels of the first run.
fn requests(document: &FirstLayout) -> Result<Requests, ResultsError> {
    let mut requests = Requests::default();
    let recorded =
        document.suites.iter().flat_map(|suite| &suite.recorded).filter_map(|one| one.run.as_ref());
    let runs = document.suites.iter().flat_map(|suite| &suite.trials).flat_map(|trial| &trial.runs);
    let Some(run) = runs.chain(recorded).next() else { return Ok(requests) };
    for label in run.metrics.keys() {
        let reference = reference(label);
        if reference.label() != *label {
            return Err(contradiction(&run.key, format!("`{label}` is no metric")));
        }
        requests.add(&reference);
    }
    Ok(requests)
}

/// The metric of a label such as `pet(av, walker, window=0.5)`.
fn reference(label: &str) -> MetricReference {
    let (name, inside) = label.split_once('(').unwrap_or((label, ""));
    let (mut names, mut settings) = (Vec::new(), Settings::default());
    for part in inside.trim_end_matches(')').split(", ").filter(|part| !part.is_empty()) {
        match part.split_once('=') {
            Some((setting, value)) => settings.set(
                setting.to_string(),
                match (value.parse(), value) {
                    (Ok(number), _) => Setting::Number(number),
                    (_, "true") => Setting::Flag(true),
                    (_, "false") => Setting::Flag(false),
                    (_, word) => Setting::Word(word.to_string()),
                },
            ),
            None => names.push(part.to_string()),
        }
    }
    let mut names = names.into_iter();
    let pair = names.next().map(|first| (first, names.next().unwrap_or_default()));
    MetricReference { settings, pair, ..MetricReference::plain(Reference::unresolved(name)) }
}

impl Suite {
    fn report(self, requests: &Requests, program: &Program) -> Result<SuiteReport, ResultsError> {
        if let Some(block) = self.blocks.into_iter().next() {
            return Err(ResultsError::Lacking {
                key: block.key,
                what: "what this block declares is not in it".into(),
            });
        }
        Ok(SuiteReport {
            identity: self.identity,
            program: program.clone(),
            started: SystemTime::UNIX_EPOCH,
            wall_time: seconds("suite", self.wall_time_s)?,
            recorded: self.recorded.into_iter().map(|one| one.report(requests)).collect::<Result<_, _>>()?,
            trials: self.trials.into_iter().map(|one| one.report(requests)).collect::<Result<_, _>>()?,
            summary: None,
            controllers: Vec::new(),
            people: Vec::new(),
            blocks: Vec::new(),
            gates: self.gates.into_iter().map(GateOfSuite::report).collect::<Result<_, _>>()?,
            ratings: Vec::new(),
            interrupted: self.interrupted,
        })
    }
}

impl RecordedRun {
    fn report(self, requests: &Requests) -> Result<RecordedReport, ResultsError> {
        let wall_time = seconds(&self.key, self.wall_time_s)?;
        let mut seed = 0;
        let state = match (self.verdict.as_str(), self.run, self.message) {
            ("error", None, Some(message)) => RecordedState::Errored(message.into()),
            ("skipped", None, Some(message)) => RecordedState::Skipped(skip(&message)),
            (verdict, Some(run), _) => {
                seed = run.seed;
                // Those that only spoke against criteria over many runs decided nothing.
                let said = serde_json::from_value(verdict.into())?;
                let (own, against) = self.findings.into_iter().partition(|finding| finding.verdict <= said);
                RecordedState::Ran(Box::new(Rerun {
                    may_differ: false,
                    outcome: run.outcome(requests)?,
                    same_case: self.same_case,
                    judged: judged(&self.key, verdict, own, None, None, Default::default())?,
                    against,
                }))
            }
            (verdict, ..) => return Err(contradiction(&self.key, format!("`{verdict}` without its reason"))),
        };
        let recorded = Recorded {
            key: self.recorded,
            scenario: self.scenario,
            seed,
            variation: Vec::new(),
            people: Vec::new(),
            case: 0,
            fingerprint: 0,
            against: self.against,
        };
        Ok(RecordedReport { recorded: Arc::new(recorded), key: self.key, state, wall_time })
    }
}

impl TrialOfSuite {
    fn report(self, requests: &Requests) -> Result<TrialReport, ResultsError> {
        let wall_time = seconds(&self.key, self.wall_time_s)?;
        let trial = Trial {
            scenario: self.scenario,
            doc: None,
            tags: self.tags,
            variation: assignments(&self.key, &self.variation)?,
            runs: self.runs.len(),
            first_run: self.runs.first().map_or_else(|| self.key.clone(), |run| run.key.clone()),
            rounds: None,
            criteria: Arc::default(),
            declared: self.findings.len(),
            origin: self.findings.first().map_or_else(Origin::default, |finding| finding.origin.clone()),
            key: self.key,
        };
        let runs = self.runs.into_iter().map(|run| run.outcome(requests));
        let outcomes = runs.collect::<Result<_, _>>()?;
        let state = match (self.verdict.as_str(), self.message) {
            ("error", Some(message)) => TrialState::Errored(message.into()),
            ("skipped", Some(message)) => TrialState::Skipped(skip(&message)),
            ("not_finished", Some(message)) => {
                TrialState::NotFinished(cut(&trial.key, self.cut_by, message)?)
            }
            (verdict, None) => TrialState::Judged(judged(
                &trial.key,
                verdict,
                self.findings,
                self.stopping,
                self.horizon,
                Default::default(),
            )?),
            (verdict, _) => return Err(contradiction(&trial.key, format!("`{verdict}` without its reason"))),
        };
        Ok(TrialReport { trial: Arc::new(trial), outcomes, state, departures: Vec::new(), wall_time })
    }
}

impl GateOfSuite {
    fn report(self) -> Result<GateReport, ResultsError> {
        let rule = |text: &String| GateRule {
            metric: None,
            rate: None,
            tolerance: Tolerance::Absolute(0.0),
            primary: false,
            confidence: 1.0,
            text: text.clone(),
            notation: None,
            origin: Origin::default(),
        };
        let gate = Gate {
            name: self.gate,
            doc: None,
            baseline: String::new(),
            sequential: false,
            rules: self.rules.iter().map(rule).collect(),
            origin: Origin::default(),
        };
        let result = self.result.map(|result| Box::new(GateVerdict { rules: self.rules, ..*result }));
        let message = self.message.unwrap_or_default();
        let (mut refusal, mut not_judged) = (None, None);
        match self.verdict.as_str() {
            "error" => {
                let help = self.help.unwrap_or_default();
                refusal = Some(Refusal { message, reasons: self.reasons, help });
            }
            "not_judged" if message == NotJudged::NotSelected.to_string() => {
                not_judged = Some(NotJudged::NotSelected);
            }
            "not_judged" => not_judged = Some(NotJudged::Incomplete(message)),
            _ => {}
        }
        let state = gate_state(&self.key, &self.verdict, result, refusal, not_judged)?;
        Ok(GateReport { gate: Arc::new(gate), key: self.key, state })
    }
}

/// The values of a trial's variations, with the words in its key.
fn assignments(key: &str, variation: &Map<String, Value>) -> Result<Vec<Assignment>, ResultsError> {
    let mut assignments = Vec::new();
    // In the order of the key.
    for part in key.split('/') {
        let Some((name, label)) = part.split_once('=') else { continue };
        if let Some(value) = variation.get(name) {
            let value = serde_json::from_value(value.clone())?;
            assignments.push(Assignment { name: name.to_string(), label: label.to_string(), value });
        }
    }
    if assignments.len() != variation.len() {
        return Err(contradiction(key, "it varies what its name does not say"));
    }
    Ok(assignments)
}

/// Why something was not run, out of the words for it.
fn skip(message: &str) -> Skip {
    let max_fail = Regex::new(r"\(--max-fail (\d+)\)$").expect("the expression is valid");
    let needs = Regex::new(r"^needs (.+), which (.+)$").expect("the expression is valid");
    if message == Skip::NotSelected.to_string() {
        Skip::NotSelected
    } else if message == Stopping::Interrupted.to_string() {
        Skip::Stopped(Stopping::Interrupted)
    } else if let Some(number) = max_fail.captures(message).and_then(|found| found[1].parse().ok()) {
        Skip::Stopped(Stopping::MaxFail(number))
    } else if let Some(found) = needs.captures(message) {
        Skip::Needs { key: found[1].to_string(), happened: found[2].to_string() }
    } else {
        Skip::Stale(message.to_string())
    }
}

/// What cut a trial off, out of the words for it.
///
/// # Errors
/// If it was the time limit, and the words do not say which: no number is made up.
fn cut(key: &str, by: Option<CutBy>, message: String) -> Result<Cut, ResultsError> {
    let limit = Regex::new(r"^time limit of (.+) s exceeded after (\d+) of (\d+) runs$");
    let found = limit.expect("the expression is valid").captures(&message).and_then(|found| {
        let limit = std::time::Duration::try_from_secs_f64(found[1].parse().ok()?).ok()?;
        Some(Cut::TimeLimit { limit, finished: found[2].parse().ok()?, runs: found[3].parse().ok()? })
    });
    match by {
        Some(CutBy::TimeLimit) => {
            found.ok_or_else(|| contradiction(key, format!("`{message}` is no time limit")))
        }
        Some(CutBy::Interrupted | CutBy::GateFailed) | None => Ok(Cut::Block(message)),
    }
}
