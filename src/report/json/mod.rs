//! Results as JSON, for programs. The same suite and seed give the same file on every machine, but for the times.

use numbers::json;
use results::{
    BlockReport, BlockState, GateReport, GateState, Horizon, Outcome, Program, RatingReport, RatingState,
    RecordedReport, RecordedState, Requests, RunFault, SuiteReport, TrialReport, TrialState, UnitError,
};
mod error;
mod first_layout;
mod parts;
mod read;
mod verify;

use std::io::{self, Write};
use std::rc::Rc;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::{Map, Value, json};

use super::need_every_trial;
use super::wording::{trial_warnings, verdict_word};
use error::LAYOUT;
pub use error::ResultsError;
pub use read::read_results;
use results::Results;

use results::judge::per_run;
use scenario::Assignment;

/// Writes everything as pretty-printed JSON with a final line end, a run at a time: nothing but what is being written is
/// held.
///
/// # Errors
/// Those of `out`; or the results do not hold every trial.
pub fn write_json(results: &Results, mut out: impl Write) -> io::Result<()> {
    need_every_trial(results)?;
    let Results { requests, suites, recordings, denies_untested } = results;
    let record = Object {
        members: members(json!({ "requests": plain(requests), "denies_untested": denies_untested })),
        lists: vec![("recordings", list(recordings, |one| Item::Value(plain(one))))],
        objects: Vec::new(),
    };
    let document = Object {
        members: members(json!({
            "layout": LAYOUT,
            "overall": { "verdict": plain(&results.overall()), "exit_code": results.exit_code() },
            "tool": { "name": "scenario-runner", "version": Program::of(suites).version },
        })),
        lists: vec![("suites", list(suites, move |report| Item::Object(suite_object(report, requests))))],
        objects: vec![("record", record)],
    };
    serde_json::to_writer_pretty(&mut out, &document)?;
    out.write_all(b"\n")
}

/// An object, some of whose members are lists too long to be held; members come in the order of their names.
struct Object<'v> {
    members: Map<String, Value>,
    lists: Vec<(&'static str, List<'v>)>,
    /// Members that have such lists themselves.
    objects: Vec<(&'static str, Object<'v>)>,
}

/// Makes its items when they are written.
type List<'v> = Box<dyn Fn() -> Box<dyn Iterator<Item = Item<'v>> + 'v> + 'v>;

enum Item<'v> {
    Value(Value),
    Object(Object<'v>),
}

fn list<'v, T>(items: &'v [T], item: impl Fn(&'v T) -> Item<'v> + Clone + 'v) -> List<'v> {
    Box::new(move || Box::new(items.iter().map(item.clone())))
}

fn members(object: Value) -> Map<String, Value> {
    match object {
        Value::Object(members) => members,
        _ => unreachable!("it was made as an object"),
    }
}

impl Serialize for Object<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut names: Vec<&str> = self.members.keys().map(String::as_str).collect();
        names.extend(self.lists.iter().map(|(name, _)| *name));
        names.extend(self.objects.iter().map(|(name, _)| *name));
        names.sort_unstable();
        let mut map = serializer.serialize_map(Some(names.len()))?;
        for name in names {
            if let Some((_, list)) = self.lists.iter().find(|(list, _)| *list == name) {
                map.serialize_entry(name, &Each(list))?;
            } else if let Some((_, object)) = self.objects.iter().find(|(object, _)| *object == name) {
                map.serialize_entry(name, object)?;
            } else {
                map.serialize_entry(name, &self.members[name])?;
            }
        }
        map.end()
    }
}

impl Serialize for Item<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Value(value) => value.serialize(serializer),
            Self::Object(object) => object.serialize(serializer),
        }
    }
}

struct Each<'l, 'v>(&'l List<'v>);

impl Serialize for Each<'_, '_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq((self.0)())
    }
}

fn suite_object<'v>(report: &'v SuiteReport, requests: &'v Requests) -> Object<'v> {
    let mut own = members(json!({
        "suite": report.identity.suite,
        "file": report.identity.file,
        "seed": plain(&Whole(report.identity.seed)),
        "wall_time_s": report.wall_time.as_secs_f64(),
        "interrupted": report.interrupted,
        "record": { "started": plain(&report.started), "program": plain(&report.program) },
    }));
    if !report.controllers.is_empty() {
        own.insert("controllers".into(), plain(&report.controllers));
    }
    if !report.people.is_empty() {
        own.insert("people".into(), plain(&report.people));
    }
    if !report.identity.set.is_empty() {
        own.insert("set".into(), json!(report.identity.set));
    }
    if !report.identity.tested.is_empty() {
        own.insert("tested".into(), plain(&report.identity.tested));
    }
    if !report.identity.earlier_seeds.is_empty() {
        own.insert("earlier_seeds".into(), plain(&report.identity.earlier_seeds));
    }
    if !report.identity.texts.is_empty() {
        own.insert("texts".into(), plain(&report.identity.texts));
    }
    let mut lists: Vec<(&'static str, List<'v>)> = Vec::new();
    if !report.ratings.is_empty() {
        lists.push(("ratings", list(&report.ratings, |rating| Item::Value(rating_value(rating)))));
    }
    Object {
        members: own,
        lists: lists
            .into_iter()
            .chain([
                ("recorded", list(&report.recorded, move |one| Item::Value(recorded_value(one, requests)))),
                ("trials", list(&report.trials, move |trial| Item::Object(trial_object(trial, requests)))),
                ("blocks", list(&report.blocks, |block| Item::Value(block_value(block)))),
                ("gates", list(&report.gates, |gate| Item::Value(gate_value(gate)))),
            ])
            .collect(),
        objects: Vec::new(),
    }
}

/// Values by the name of the variation.
pub(super) fn variation_value(variation: &[Assignment]) -> Value {
    let values = variation.iter().map(|assignment| (assignment.name.clone(), plain(&assignment.value)));
    Value::Object(values.collect())
}

fn trial_object<'v>(report: &'v TrialReport, requests: &'v Requests) -> Object<'v> {
    let variation = &report.trial.variation;
    let criteria: Rc<Vec<_>> = Rc::new(report.trial.criteria.iter().filter_map(per_run).collect());
    let run = move |outcome: &Outcome| {
        let mut value = outcome_value(outcome, requests);
        let Outcome { critical, presences, waiting_steps, left_road, outlasted, cut_off, wall_time, .. } =
            outcome;
        value["record"] = json!({
            "critical": plain(critical),
            "presences": plain(presences),
            "wall_time": plain(wall_time),
        });
        if !waiting_steps.is_empty() {
            value["record"]["waiting_steps"] = plain(waiting_steps);
        }
        if !left_road.is_empty() {
            value["record"]["left_road"] = plain(left_road);
        }
        if !outlasted.is_empty() {
            value["record"]["outlasted"] = plain(outlasted);
        }
        if let Some(cut_off) = cut_off {
            value["record"]["cut_off"] = plain(cut_off);
        }
        let standings: Vec<_> = criteria.iter().map(|one| one.standing(outcome, requests)).collect();
        value["criteria"] = plain(&standings);
        Item::Value(value)
    };
    let mut fields = members(json!({
        "key": report.trial.key,
        "scenario": report.trial.scenario,
        "tags": report.trial.tags,
        "variation": variation_value(variation),
        "wall_time_s": report.wall_time.as_secs_f64(),
        "record": { "trial": plain(&report.trial), "departures": report.departures },
    }));
    let warnings = trial_warnings(report);
    if !warnings.is_empty() {
        fields.insert("warnings".into(), warnings.into());
    }
    let mut objects = Vec::new();
    match &report.state {
        TrialState::Judged(judged) => {
            fields.insert("verdict".into(), plain(&judged.verdict));
            fields.insert("findings".into(), plain(&judged.findings));
            if judged.claims_nothing() {
                fields.insert("judged".into(), false.into());
            }
            if !judged.never_began.is_empty() {
                fields.insert("never_began".into(), plain(&judged.never_began));
            }
            if !judged.left_road.is_empty() {
                fields.insert("left_road".into(), plain(&judged.left_road));
            }
            if !judged.outlasted.is_empty() {
                fields.insert("outlasted".into(), plain(&judged.outlasted));
            }
            objects.extend(judged.horizon.as_ref().map(|horizon| ("horizon", horizon_object(horizon))));
            if let Some(stopping) = &judged.stopping {
                fields.insert("stopping".into(), plain(stopping));
            }
        }
        TrialState::Errored(error) => {
            fields.insert("verdict".into(), "error".into());
            insert_error(&mut fields, error);
        }
        TrialState::NotFinished(cut) => {
            fields.insert("verdict".into(), "not_finished".into());
            fields.insert("message".into(), cut.to_string().into());
            fields.insert("cut_by".into(), plain(&cut.by()));
            fields["record"]["cut"] = plain(cut);
        }
        TrialState::Skipped(reason) => {
            fields.insert("verdict".into(), "skipped".into());
            fields.insert("message".into(), reason.to_string().into());
            fields["record"]["skip"] = plain(reason);
        }
    }
    let runs = report.error().map_or(&report.outcomes, |error| &error.finished);
    Object { members: fields, lists: vec![("runs", list(runs, run))], objects }
}

/// Why a unit could not be run to its end, with the runs that programs kept from theirs.
fn insert_error(fields: &mut Map<String, Value>, error: &UnitError) {
    fields.insert("message".into(), error.message.as_str().into());
    if !error.faults.is_empty() {
        let fault = |one: &RunFault| {
            json!({
                "run": one.run,
                "vehicle": one.vehicle,
                "controller": one.fault.controller,
                "declared": plain(&one.fault.declared),
                "fault": {
                    "kind": one.fault.kind,
                    "time": one.time,
                    "message": one.fault.message,
                    "log": one.fault.log,
                    "log_tail": one.fault.log_tail,
                },
            })
        };
        fields.insert("faults".into(), error.faults.iter().map(fault).collect());
    }
}

fn horizon_object(horizon: &Horizon) -> Object<'_> {
    let Horizon { runs, of, stranded, on_course } = horizon;
    Object {
        members: members(json!({ "runs": runs, "of": of })),
        lists: vec![
            ("stranded", list(stranded, |run| Item::Value(plain(run)))),
            ("on_course", list(on_course, |run| Item::Value(plain(run)))),
        ],
        objects: Vec::new(),
    }
}

fn recorded_value(report: &RecordedReport, requests: &Requests) -> Value {
    let mut value = json!({
        "key": report.key,
        "recorded": report.recorded.key,
        "scenario": report.recorded.scenario,
        "against": report.recorded.against,
        "wall_time_s": report.wall_time.as_secs_f64(),
        "record": { "recorded": plain(&report.recorded), "state": plain(&report.state) },
    });
    let fields = value.as_object_mut().expect("it was made as an object");
    let (verdict, message) = match &report.state {
        RecordedState::Ran(rerun) => {
            let findings: Vec<_> = rerun.judged.findings.iter().chain(&rerun.against).collect();
            fields.insert("same_case".into(), rerun.same_case.into());
            fields.insert("findings".into(), plain(&findings));
            fields.insert("run".into(), outcome_value(&rerun.outcome, requests));
            (plain(&rerun.judged.verdict), None)
        }
        RecordedState::Errored(error) => {
            insert_error(fields, error);
            ("error".into(), None)
        }
        RecordedState::Skipped(reason) => ("skipped".into(), Some(reason.to_string())),
    };
    fields.insert("verdict".into(), verdict);
    if let Some(message) = message {
        fields.insert("message".into(), message.into());
    }
    value
}

/// A rating: its verdict is `null` where it expects nothing.
fn rating_value(report: &RatingReport) -> Value {
    let mut value = json!({
        "key": report.key,
        "rating": report.rating.name,
        "record": { "rating": plain(&report.rating) },
    });
    let fields = value.as_object_mut().expect("it was made as an object");
    match &report.state {
        RatingState::Rated(result) => {
            fields.insert("verdict".into(), plain(&result.verdict()));
            fields.insert("points".into(), plain(&result.points));
            fields.insert("maximum".into(), plain(&result.maximum));
            fields.insert("result".into(), plain(result));
        }
        RatingState::NotJudged(why) => {
            fields.insert("verdict".into(), "not_judged".into());
            fields.insert("message".into(), why.to_string().into());
            fields["record"]["not_judged"] = plain(why);
        }
    }
    value
}

fn gate_value(report: &GateReport) -> Value {
    let mut value = json!({
        "key": report.key,
        "gate": report.gate.name,
        "rules": report.gate.rules.iter().map(|rule| rule.text.as_str()).collect::<Vec<_>>(),
        "record": { "gate": plain(&report.gate) },
    });
    let fields = value.as_object_mut().expect("it was made as an object");
    match &report.state {
        GateState::Judged(verdict) => {
            fields.insert("verdict".into(), plain(&verdict.verdict));
            // With what holds unless the gate says otherwise.
            fields.insert("rules".into(), plain(&verdict.rules));
            fields.insert("result".into(), plain(verdict));
        }
        GateState::Refused(refusal) => {
            fields.insert("verdict".into(), "error".into());
            fields.insert("message".into(), refusal.message.as_str().into());
            fields.insert("reasons".into(), refusal.reasons.clone().into());
            fields.insert("help".into(), refusal.help.as_str().into());
        }
        GateState::NotJudged(why) => {
            fields.insert("verdict".into(), "not_judged".into());
            fields.insert("message".into(), why.to_string().into());
            fields["record"]["not_judged"] = plain(why);
        }
    }
    value
}

fn block_value(report: &BlockReport) -> Value {
    let mut value = json!({
        "key": report.key,
        "kind": report.block.kind(),
        "name": report.block.name(),
        "wall_time_s": report.wall_time.as_secs_f64(),
        "record": { "block": plain(&report.block) },
    });
    let fields = value.as_object_mut().expect("it was made as an object");
    let (verdict, message) = match &report.state {
        BlockState::Finished(result) => {
            fields.insert("result".into(), plain(result));
            let failure = result.failure();
            (result.verdict().map_or("found", verdict_word), failure)
        }
        BlockState::Errored(error) => {
            insert_error(fields, error);
            ("error", None)
        }
        BlockState::NotFinished(cut) => {
            fields.insert("cut_by".into(), plain(&cut.by()));
            fields["record"]["cut"] = plain(cut);
            ("not_finished", Some(cut.to_string()))
        }
        BlockState::Skipped(reason) => {
            fields["record"]["skip"] = plain(reason);
            ("skipped", Some(reason.to_string()))
        }
    };
    fields.insert("verdict".into(), verdict.into());
    if let Some(message) = message {
        fields.insert("message".into(), message.into());
    }
    value
}

pub(super) fn outcome_value(outcome: &Outcome, requests: &Requests) -> Value {
    let metrics: Map<_, _> = requests
        .iter()
        .zip(&outcome.metrics)
        .map(|(reference, value)| (reference.label(), value.map_or(Value::Null, Value::from)))
        .collect();
    let open = requests.iter().enumerate();
    let open = open.filter_map(|(index, reference)| Some((reference.label(), plain(&outcome.open(index)?))));
    let open: Map<_, _> = open.collect();
    let mut value = json!({
        "key": outcome.key,
        "seed": plain(&Whole(outcome.seed)),
        "individuals": outcome.individuals,
        "ending": outcome.ending,
        "metrics": metrics,
        "fingerprint": format!("{:016x}", outcome.fingerprint),
    });
    if !outcome.drawn.is_empty() {
        value["drawn"] = plain(&outcome.drawn);
    }
    if !open.is_empty() {
        value["open"] = open.into();
    }
    value
}

/// A seed, which as a number other languages might round.
#[derive(Serialize)]
struct Whole(#[serde(with = "json::whole")] u64);

pub(super) fn plain(value: &impl Serialize) -> Value {
    serde_json::to_value(value).expect("plain data serialises")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Session, calibration, evaluation, statement};
    use crate::schema::violations;
    use results::{AnswerTimes, BlockResult, Conclusion, DifferingRun, TestedController};
    use scenario::{DeclaredStanding, FaultKind, ProgramFault};

    fn text(results: &Results) -> String {
        let mut text = Vec::new();
        write_json(results, &mut text).expect("there is room");
        String::from_utf8(text).expect("it is text")
    }

    fn results() -> Value {
        let session = Session::new();
        serde_json::from_str(&text(&session.results(session.report()))).expect("it is JSON")
    }

    #[test]
    fn what_is_written_in_pieces_is_what_is_written_at_once() {
        let session = Session::new();
        let text = text(&session.results(session.report()));
        let value: Value = serde_json::from_str(&text).expect("it is JSON");
        assert_eq!(text, serde_json::to_string_pretty(&value).expect("plain data serialises") + "\n");
    }

    fn schema() -> Value {
        serde_json::from_str(include_str!("../../../docs/results.schema.json")).expect("the schema is JSON")
    }

    #[test]
    fn results_are_what_the_published_schema_says() {
        assert_eq!(violations(&schema(), &results()), Vec::<String>::new());
    }

    #[test]
    fn an_interval_without_an_end_has_null_there_and_the_schema_says_so() {
        let session = Session::new();
        let mut report = session.report();
        let TrialState::Judged(judged) = &mut report.trials[0].state else { panic!("it was judged") };
        judged.findings[0].interval = Some((f64::NEG_INFINITY, 1.5));
        judged.findings[1].interval = Some((0.5, f64::INFINITY));
        let results: Value = serde_json::from_str(&text(&session.results(report))).unwrap();
        let findings = results.pointer("/suites/0/trials/0/findings").unwrap();
        assert_eq!(
            (&findings[0]["interval"], &findings[1]["interval"]),
            (&json!([null, 1.5]), &json!([0.5, null]))
        );
        assert_eq!(violations(&schema(), &results), Vec::<String>::new());
    }

    #[test]
    fn what_is_known_of_programs_is_what_the_schema_says_and_is_read_back() {
        let session = Session::new();
        let mut report = session.report();
        let fault = ProgramFault {
            controller: "own".into(),
            log_tail: vec!["  lane.width".into()],
            log: Some("own-1.log".into()),
            ..ProgramFault::new(FaultKind::Timeout, "no answer within 1 s")
        };
        let fault = RunFault { run: "zebra/a/rep=2".into(), vehicle: "av".into(), time: 0.5, fault };
        let finished = std::mem::take(&mut report.trials[0].outcomes);
        let error = UnitError::of_faults(vec![fault.clone()], &["all of it".into()], finished);
        assert!(error.message.starts_with("1 of 7 runs ended in a fault (timeout)\n"), "{error}");
        report.trials[0].state = TrialState::Errored(error);
        report.blocks[0].state =
            BlockState::Errored(UnitError { faults: vec![fault], ..UnitError::from("no".to_string()) });
        report.controllers = vec![TestedController {
            name: "own".into(),
            program: "tested 1.0".into(),
            answers: Some(AnswerTimes { answers: 7, median: 0.1, percentile_99: 0.2, worst: 0.3, late: 0.5 }),
            second_runs: 1,
            differing: vec![DifferingRun { run: "zebra/a/rep=1".into(), difference: "at 1 s".into() }],
            ..TestedController::default()
        }];
        let results = session.results(report);
        let text = text(&results);
        assert_eq!(violations(&schema(), &serde_json::from_str(&text).unwrap()), Vec::<String>::new());
        let read = super::read::parsed(text.as_bytes(), &models::standard()).unwrap();
        assert_eq!(read.suites[0].trials[0].state, results.suites[0].trials[0].state);
        assert_eq!(read.suites[0].blocks[0].state, results.suites[0].blocks[0].state);
        assert_eq!(read.suites[0].controllers, results.suites[0].controllers);
    }

    #[test]
    fn results_of_every_kind_of_block_are_what_the_schema_says() {
        let mut results = results();
        let blocks = results.pointer_mut("/suites/0/blocks").and_then(Value::as_array_mut).unwrap();
        let differs = DeclaredStanding::Differs("the car is heavier".into());
        let unknown = Conclusion::NotComparable("nobody was run".into());
        for result in [
            BlockResult::Evaluate(evaluation()),
            BlockResult::Calibrate(calibration()),
            BlockResult::Statement(statement(DeclaredStanding::Reproduced, unknown)),
            BlockResult::Statement(statement(differs, Conclusion::NotReproduced)),
        ] {
            let kind = match result {
                BlockResult::Evaluate(_) => "evaluate",
                BlockResult::Calibrate(_) => "calibrate",
                _ => "statement",
            };
            blocks.push(json!({
                "key": "zebra/one",
                "kind": kind,
                "name": "one",
                "wall_time_s": 0.5,
                "verdict": "passed",
                "result": plain(&result),
            }));
        }
        assert_eq!(violations(&schema(), &results), Vec::<String>::new());
    }

    #[test]
    fn the_schema_refuses_what_is_wrong() {
        let wrong: [(&str, Value); 6] = [
            ("/layout", json!(1)),
            ("/suites/0/trials/0/verdict", json!("fine")),
            ("/suites/0/trials/0/runs/0/metrics/pet", json!("1.5 s")),
            ("/suites/0/trials/0/runs/0/fingerprint", json!("beef")),
            ("/suites/0/trials/0/findings/0", json!({})),
            ("/suites/0/trials/0/variation", json!({ "tta": [6] })),
        ];
        for (place, value) in wrong {
            let mut results = results();
            *results.pointer_mut(place).expect("the place exists") = value;
            assert!(!violations(&schema(), &results).is_empty(), "nobody minds {place}");
        }
        let mut results = results();
        results["suites"][0]["surprise"] = json!(1);
        assert_eq!(violations(&schema(), &results), ["$.suites[0].surprise: nobody expects it"]);
    }
}
