//! Results read back from JSON, so that reports can be made of them later.

use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;

use serde::Deserialize;

use super::error::{ResultsError, contradiction, seconds};
use super::first_layout;
use super::parts::{FaultOfRun, Run, faults, gate_state, judged, says};
use super::verify::verified;
use results::{
    BlockReport, BlockResult, BlockState, Chosen, Cut, Finding, GateReport, GateVerdict, Horizon, LeftRoad,
    NotJudged, NotRated, Outcome, OutlastedRuns, PeopleUsed, Program, RatingReport, RatingResult,
    RatingState, Recorded, RecordedReport, RecordedState, Recording, Refusal, Requests, Results, RunsTaken,
    Skip, SuiteIdentity, SuiteReport, TestedController, TrialReport, TrialState, UnitError, WaitingStep,
};
use scenario::registry::Registry;
use scenario::{Block, Gate, Rating, Trial};

/// The largest file that is read: about a million runs.
const LARGEST: u64 = 2 << 30;

/// Reads what [`super::write_json`] wrote, of this version or of 0.1.
///
/// # Errors
/// [`ResultsError`].
pub fn read_results(path: &Path, registry: &Registry) -> Result<Results, ResultsError> {
    results_of(&files::read_bytes(path, LARGEST)?, registry)
}

/// As [`read_results`], of a file's bytes. Version 0.1 did not write what its verdicts could be worked out from.
fn results_of(bytes: &[u8], registry: &Registry) -> Result<Results, ResultsError> {
    #[derive(Deserialize)]
    struct Layout {
        layout: u64,
    }
    match serde_json::from_slice::<Layout>(bytes)?.layout {
        1 => Ok(first_layout::results(serde_json::from_slice(bytes)?)?.resolved(registry)?),
        2 => verified(parsed(bytes, registry)?),
        other => Err(ResultsError::Layout(other)),
    }
}

/// Results of this layout, whether or not their verdicts follow from their parts.
pub(super) fn parsed(bytes: &[u8], registry: &Registry) -> Result<Results, ResultsError> {
    Ok(serde_json::from_slice::<Document>(bytes)?.results()?.resolved(registry)?)
}

#[derive(Deserialize)]
struct Document {
    #[serde(default)]
    overall: Option<WrittenOverall>,
    record: DocumentRecord,
    suites: Vec<Suite>,
}

/// The verdict on all units, as it is written.
#[derive(Deserialize)]
struct WrittenOverall {
    verdict: String,
    exit_code: u8,
}

#[derive(Deserialize)]
struct DocumentRecord {
    requests: Requests,
    recordings: Vec<(Chosen, Recording)>,
    #[serde(default)]
    denies_untested: bool,
}

#[derive(Deserialize)]
struct Suite {
    #[serde(flatten)]
    identity: SuiteIdentity,
    wall_time_s: f64,
    interrupted: bool,
    record: SuiteRecord,
    #[serde(default)]
    controllers: Vec<TestedController>,
    #[serde(default)]
    people: Vec<PeopleUsed>,
    recorded: Vec<RecordedRun>,
    trials: Vec<TrialOfSuite>,
    blocks: Vec<BlockOfSuite>,
    gates: Vec<GateOfSuite>,
    #[serde(default)]
    ratings: Vec<RatingOfSuite>,
}

#[derive(Deserialize)]
struct SuiteRecord {
    started: SystemTime,
    program: Program,
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
    #[serde(default)]
    never_began: Vec<WaitingStep>,
    #[serde(default)]
    left_road: Vec<LeftRoad>,
    #[serde(default)]
    outlasted: Vec<OutlastedRuns>,
    #[serde(default)]
    faults: Vec<FaultOfRun>,
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

#[derive(Deserialize)]
struct BlockOfSuite {
    key: String,
    verdict: String,
    #[serde(default)]
    message: Option<String>,
    wall_time_s: f64,
    #[serde(default)]
    result: Option<Box<BlockResult>>,
    #[serde(default)]
    faults: Vec<FaultOfRun>,
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

#[derive(Deserialize)]
struct RatingOfSuite {
    key: String,
    verdict: Option<String>,
    #[serde(default)]
    result: Option<Box<RatingResult>>,
    record: RatingRecord,
}

#[derive(Deserialize)]
struct RatingRecord {
    rating: Arc<Rating>,
    #[serde(default)]
    not_judged: Option<NotRated>,
}

impl Document {
    fn results(self) -> Result<Results, ResultsError> {
        let DocumentRecord { requests, recordings, denies_untested } = self.record;
        let suites = self.suites.into_iter().map(|suite| suite.report(&requests));
        let suites = suites.collect::<Result<_, _>>()?;
        let results = Results { requests, suites, recordings, denies_untested };
        let (verdict, exit_code) = (results.overall(), results.exit_code());
        match self.overall {
            Some(written) if written.exit_code != exit_code || !says(&written.verdict, verdict) => {
                let what = format!(
                    "it says `{}` with the exit code {}, and its units give another verdict with {exit_code}",
                    written.verdict, written.exit_code
                );
                Err(contradiction("overall", what))
            }
            _ => Ok(results),
        }
    }
}

impl Suite {
    fn report(self, requests: &Requests) -> Result<SuiteReport, ResultsError> {
        Ok(SuiteReport {
            identity: self.identity,
            program: self.record.program,
            started: self.record.started,
            wall_time: seconds("suite", self.wall_time_s)?,
            recorded: self.recorded.into_iter().map(RecordedRun::report).collect::<Result<_, _>>()?,
            trials: self.trials.into_iter().map(|one| one.report(requests)).collect::<Result<_, _>>()?,
            summary: None,
            controllers: self.controllers,
            people: self.people,
            blocks: self.blocks.into_iter().map(BlockOfSuite::report).collect::<Result<_, _>>()?,
            gates: self.gates.into_iter().map(GateOfSuite::report).collect::<Result<_, _>>()?,
            ratings: self.ratings.into_iter().map(RatingOfSuite::report).collect::<Result<_, _>>()?,
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
        let mut outcomes: Vec<Outcome> = runs.collect::<Result<_, _>>()?;
        let state = match (self.verdict.as_str(), self.message, cut, skip) {
            ("error", Some(message), None, None) => {
                let faults = faults(self.faults);
                let finished = std::mem::take(&mut outcomes);
                TrialState::Errored(UnitError { message, faults, finished })
            }
            ("not_finished", _, Some(cut), None) => TrialState::NotFinished(cut),
            ("skipped", _, None, Some(skip)) => TrialState::Skipped(skip),
            (verdict, None, None, None) => {
                let otherwise = (self.never_began, self.left_road, self.outlasted);
                TrialState::Judged(judged(
                    &trial.key,
                    verdict,
                    self.findings,
                    self.stopping,
                    self.horizon,
                    otherwise,
                )?)
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

impl BlockOfSuite {
    fn report(self) -> Result<BlockReport, ResultsError> {
        let BlockRecord { block, cut, skip } = self.record;
        let verdict = self.verdict.as_str();
        let state = match (verdict, self.result, self.message, cut, skip) {
            ("passed" | "inconclusive" | "failed" | "found", Some(result), _, None, None) => {
                let fits = match result.verdict() {
                    Some(known) => says(verdict, known),
                    None => verdict == "found",
                };
                if !fits {
                    let what = format!("its verdict is `{verdict}`, and its result says otherwise");
                    return Err(contradiction(&self.key, what));
                }
                BlockState::Finished(result)
            }
            ("error", None, Some(message), None, None) => {
                BlockState::Errored(UnitError { message, faults: faults(self.faults), finished: Vec::new() })
            }
            ("not_finished", None, _, Some(cut), None) => BlockState::NotFinished(cut),
            ("skipped", None, _, None, Some(skip)) => BlockState::Skipped(skip),
            _ => return Err(contradiction(&self.key, format!("`{verdict}` without its reason"))),
        };
        let wall_time = seconds(&self.key, self.wall_time_s)?;
        Ok(BlockReport { block, key: self.key, state, wall_time })
    }
}

impl RatingOfSuite {
    fn report(self) -> Result<RatingReport, ResultsError> {
        let RatingRecord { rating, not_judged } = self.record;
        let state = match (self.verdict.as_deref(), self.result, not_judged) {
            (Some("not_judged"), None, Some(why)) => RatingState::NotJudged(why),
            (verdict, Some(result), None) => {
                let fits = match (verdict, result.verdict()) {
                    (Some(word), Some(verdict)) => says(word, verdict),
                    (None, None) => true,
                    _ => false,
                };
                if !fits || result.findings.len() != rating.criteria.len() {
                    let verdict = verdict.unwrap_or("null");
                    let what = format!("its verdict is `{verdict}`, and its result says otherwise");
                    return Err(contradiction(&self.key, what));
                }
                RatingState::Rated(result)
            }
            (verdict, ..) => {
                let verdict = verdict.unwrap_or("null");
                return Err(contradiction(&self.key, format!("`{verdict}` without its reason")));
            }
        };
        Ok(RatingReport { rating, key: self.key, state })
    }
}

impl GateOfSuite {
    fn report(self) -> Result<GateReport, ResultsError> {
        let GateRecord { gate, not_judged } = self.record;
        let state = gate_state(&self.key, &self.verdict, self.result, self.refusal, not_judged)?;
        Ok(GateReport { gate, key: self.key, state })
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use serde_json::Value;

    use super::super::error::LAYOUT;
    use super::*;
    use crate::fixture::{Session, evaluation, statement};
    use crate::write_json;
    use models::standard;
    use results::judge::judge;
    use results::{Conclusion, CutOff, Outlasted};
    use scenario::DeclaredStanding;
    use sim::measure::Open;

    fn written(results: &Results) -> String {
        let mut bytes = Vec::new();
        write_json(results, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    /// A session with every state that anything can be in, and every kind of block.
    fn every_kind() -> Vec<Results> {
        let session = Session::new();
        let mut report = session.report();
        let TrialState::Judged(judged) = &mut report.trials[0].state else { panic!("it was judged") };
        judged.findings[0].observed = Some(f64::INFINITY);
        judged.findings[0].margin = Some(f64::NEG_INFINITY);
        judged.findings[0].interval = Some((f64::NEG_INFINITY, 1.5));
        report.trials[0].departures = vec!["`walker`: `dt` of `commotions` is not what was published".into()];
        let cut_off = CutOff {
            open: [None, Some(Open { low: 0.5, high: f64::INFINITY })].into_iter().collect(),
            stranded: vec!["walker".into()],
            ..CutOff::default()
        };
        report.trials[0].outcomes[0].cut_off = Some(Box::new(cut_off));
        report.trials[0].outcomes[0].outlasted =
            vec![Outlasted { stream: "cars".into(), pedestrian: "walker".into() }];
        let trial = &mut report.trials[0];
        let TrialState::Judged(judged) = &mut trial.state else { panic!("it was judged") };
        judged.outlasted = vec![OutlastedRuns {
            outlasted: trial.outcomes[0].outlasted[0].clone(),
            runs: 1,
            of: trial.outcomes.len(),
        }];
        assert!(crate::wording::not_as_declared(judged).iter().any(|said| {
            said.starts_with("the last vehicle of `cars` had passed before `walker` went across in 1 of ")
        }));
        report.trials[0].outcomes[1].seed = u64::MAX;
        let results = [
            BlockResult::Evaluate(evaluation()),
            BlockResult::Statement(statement(DeclaredStanding::Reproduced, Conclusion::NotReproduced)),
        ];
        for result in results {
            let mut block = report.blocks[0].clone();
            block.state = BlockState::Finished(Box::new(result));
            report.blocks.push(block);
        }
        vec![
            session.results(report),
            session.results(session.interrupted()),
            {
                let odd = Session::with_names("\u{1F6B6} <&>\"'\\");
                odd.results(odd.report())
            },
            Results::default(),
        ]
    }

    #[test]
    fn what_is_written_is_read_back_equal_and_judged_again_equal() {
        for results in every_kind() {
            let text = written(&results);
            let again =
                parsed(text.as_bytes(), &standard()).unwrap_or_else(|error| panic!("{error}\n{text}"));
            for (new, old) in again.suites.iter().zip(&results.suites) {
                assert_eq!(new.identity, old.identity);
                new.trials.iter().zip(&old.trials).for_each(|(new, old)| assert_eq!(new, old));
                new.blocks.iter().zip(&old.blocks).for_each(|(new, old)| assert_eq!(new, old));
                new.gates.iter().zip(&old.gates).for_each(|(new, old)| assert_eq!(new, old));
                new.ratings.iter().zip(&old.ratings).for_each(|(new, old)| assert_eq!(new, old));
            }
            assert_eq!(again.requests, results.requests);
            again.recordings.iter().zip(&results.recordings).for_each(|(new, old)| assert_eq!(new, old));
            again
                .suites
                .iter()
                .zip(&results.suites)
                .for_each(|(new, old)| assert_eq!(new.recorded, old.recorded));
            assert!(again == results, "the results differ from what was written");
            assert_eq!(written(&again), text);
            let judged = |results: &Results| -> Vec<_> {
                let trials = results.suites.iter().flat_map(|suite| &suite.trials);
                let trials = trials.filter(|one| matches!(one.state, TrialState::Judged(_)));
                trials.map(|one| judge(&one.trial.criteria, &one.outcomes, &results.requests)).collect()
            };
            assert_eq!(judged(&again), judged(&results));
            assert!(!judged(&again).is_empty() || results.suites.is_empty());
        }
    }

    #[test]
    fn a_verdict_that_is_not_that_of_its_findings_is_refused() {
        let session = Session::new();
        let text = written(&session.results(session.report()));
        let value: Value = serde_json::from_str(&text).unwrap();
        let trials = value["suites"][0]["trials"].as_array().unwrap();
        let failed = trials.iter().position(|trial| trial["verdict"] == "failed").unwrap();
        for (place, verdict, said) in [
            (format!("/suites/0/trials/{failed}/verdict"), "passed", "the worst of its findings is another"),
            (format!("/suites/0/trials/{failed}/verdict"), "skipped", "the worst of its findings is another"),
            (
                format!("/suites/0/trials/{failed}/verdict"),
                "nonsense",
                "the worst of its findings is another",
            ),
            ("/suites/0/gates/0/verdict".into(), "passed", "its result another"),
            ("/suites/0/gates/3/verdict".into(), "passed", "without its reason"),
            ("/suites/0/ratings/0/verdict".into(), "failed", "its result says otherwise"),
            ("/suites/0/ratings/1/verdict".into(), "passed", "its result says otherwise"),
            ("/suites/0/ratings/2/verdict".into(), "passed", "its result says otherwise"),
            ("/suites/0/ratings/3/verdict".into(), "passed", "without its reason"),
            ("/suites/0/blocks/1/verdict".into(), "nonsense", "without its reason"),
            ("/suites/0/blocks/0/verdict".into(), "failed", "its result says otherwise"),
        ] {
            let mut changed = value.clone();
            *changed.pointer_mut(&place).unwrap() = verdict.into();
            let error = results_of(changed.to_string().as_bytes(), &standard()).unwrap_err().to_string();
            assert!(error.contains(said), "{place}: {error}");
        }
    }

    #[test]
    fn what_is_cut_short_or_of_another_layout_is_refused() {
        let session = Session::new();
        let text = written(&session.results(session.report()));
        for share in 0..20 {
            let error = results_of(&text.as_bytes()[..text.len() * share / 20], &standard()).unwrap_err();
            assert!(matches!(error, ResultsError::Format(_)), "{error}");
        }
        let newer = text.replacen(&format!("\"layout\": {LAYOUT}"), "\"layout\": 9", 1);
        let error = results_of(newer.as_bytes(), &standard()).unwrap_err().to_string();
        assert_eq!(error, "its layout is 9, and this version reads 1 to 2; use the version that wrote it");
    }

    #[test]
    fn a_run_without_a_metric_that_was_asked_for_is_refused() {
        let session = Session::new();
        let mut value: Value = serde_json::from_str(&written(&session.results(session.report()))).unwrap();
        let metrics =
            value.pointer_mut("/suites/0/trials/0/runs/2/metrics").unwrap().as_object_mut().unwrap();
        let pet = metrics.remove("pet").unwrap();
        let error = results_of(value.to_string().as_bytes(), &standard()).unwrap_err().to_string();
        assert!(error.contains("it has no `pet`"), "{error}");
        let metrics =
            value.pointer_mut("/suites/0/trials/0/runs/2/metrics").unwrap().as_object_mut().unwrap();
        metrics.insert("pet".into(), pet.clone());
        metrics.insert("pat".into(), pet);
        let error = results_of(value.to_string().as_bytes(), &standard()).unwrap_err().to_string();
        assert!(error.contains("nothing asked for its `pat`"), "{error}");
    }

    #[test]
    fn of_a_time_limit_in_the_words_of_0_1_no_number_is_made_up() {
        let text = include_str!("../../../tests/results/layout_1.json");
        let cut = |message: &str| {
            let mut value: Value = serde_json::from_str(text).unwrap();
            let trial = value.pointer_mut("/suites/0/trials/0").unwrap();
            trial["verdict"] = "not_finished".into();
            trial["cut_by"] = "time_limit".into();
            trial["message"] = message.into();
            results_of(value.to_string().as_bytes(), &standard())
                .map(|results| results.suites[0].trials[0].state.clone())
        };
        let limit = Duration::from_millis(1500);
        let known = TrialState::NotFinished(Cut::TimeLimit { limit, finished: 3, runs: 6 });
        assert_eq!(cut("time limit of 1.5 s exceeded after 3 of 6 runs").unwrap(), known);
        let error = cut("it took too long").unwrap_err().to_string();
        assert!(error.contains("`it took too long` is no time limit"), "{error}");
    }

    #[test]
    fn what_version_0_1_wrote_is_read() {
        let text = include_str!("../../../tests/results/layout_1.json");
        let results = results_of(text.as_bytes(), &standard()).unwrap();
        let value: Value = serde_json::from_str(text).unwrap();
        let trials = value["suites"][0]["trials"].as_array().unwrap();
        assert_eq!(results.suites[0].trials.len(), trials.len());
        for (read, written) in results.suites[0].trials.iter().zip(trials) {
            assert_eq!(serde_json::to_value(read.verdict()).unwrap(), written["verdict"]);
            assert_eq!(read.outcomes.len(), written["runs"].as_array().unwrap().len());
            assert_eq!(serde_json::to_value(read.findings()).unwrap(), written["findings"]);
        }
        let with_block = text.replacen("\"blocks\": []", "\"blocks\": [{ \"key\": \"zebra/search=a\" }]", 1);
        let error = results_of(with_block.as_bytes(), &standard()).unwrap_err().to_string();
        assert!(error.contains("written by 0.1, so run the suite again"), "{error}");
    }
}
