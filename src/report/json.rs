//! Results as JSON, for programs. The same suite and seed give the same file on every machine, but for the times.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::{
    BlockReport, BlockState, GateReport, GateState, RecordedReport, RecordedState, SuiteReport, TrialReport,
    TrialState,
};
use crate::judge::per_run;
use crate::run::{Outcome, Requests};

/// Version of the layout; raised when a reader would have to change.
const LAYOUT: u32 = 1;

/// Everything as pretty-printed JSON with a final line end.
pub fn to_json(reports: &[SuiteReport], requests: &Requests) -> String {
    let value = json!({
        "layout": LAYOUT,
        "tool": { "name": env!("CARGO_PKG_NAME"), "version": env!("CARGO_PKG_VERSION") },
        "suites": reports.iter().map(|report| suite_value(report, requests)).collect::<Vec<_>>(),
    });
    let mut text = serde_json::to_string_pretty(&value).expect("a tree of plain values serialises");
    text.push('\n');
    text
}

fn suite_value(report: &SuiteReport, requests: &Requests) -> Value {
    json!({
        "suite": report.identity.suite,
        "file": report.identity.file,
        "seed": report.identity.seed,
        "wall_time_s": report.wall_time.as_secs_f64(),
        "recorded": report.recorded.iter().map(|one| recorded_value(one, requests)).collect::<Vec<_>>(),
        "trials": report.trials.iter().map(|trial| trial_value(trial, requests)).collect::<Vec<_>>(),
        "blocks": report.blocks.iter().map(block_value).collect::<Vec<_>>(),
        "gates": report.gates.iter().map(gate_value).collect::<Vec<_>>(),
    })
}

fn trial_value(report: &TrialReport, requests: &Requests) -> Value {
    let variation: Map<_, _> = report
        .trial
        .cases
        .first()
        .into_iter()
        .flat_map(|case| &case.variation)
        .map(|assignment| (assignment.name.clone(), plain(&assignment.value)))
        .collect();
    let criteria: Vec<_> = report.trial.criteria.iter().filter_map(per_run).collect();
    let run = |outcome: &Outcome| {
        let mut value = outcome_value(outcome, requests);
        let standings: Vec<_> = criteria.iter().map(|one| one.standing(outcome, requests)).collect();
        value["criteria"] = plain(&standings);
        value
    };
    let mut value = json!({
        "key": report.trial.key,
        "scenario": report.trial.scenario,
        "tags": report.trial.tags,
        "variation": variation,
        "wall_time_s": report.wall_time.as_secs_f64(),
        "runs": report.outcomes.iter().map(run).collect::<Vec<_>>(),
    });
    let fields = value.as_object_mut().expect("it was made as an object");
    match &report.state {
        TrialState::Judged(judged) => {
            fields.insert("verdict".into(), plain(&judged.verdict));
            fields.insert("findings".into(), plain(&judged.findings));
            if let Some(stopping) = &judged.stopping {
                fields.insert("stopping".into(), plain(stopping));
            }
        }
        TrialState::Errored(message) => {
            fields.insert("verdict".into(), "error".into());
            fields.insert("message".into(), message.as_str().into());
        }
        TrialState::Skipped(reason) => {
            fields.insert("verdict".into(), "skipped".into());
            fields.insert("message".into(), reason.to_string().into());
        }
    }
    value
}

fn recorded_value(report: &RecordedReport, requests: &Requests) -> Value {
    let mut value = json!({
        "key": report.key,
        "recorded": report.recorded.key,
        "scenario": report.recorded.scenario,
        "against": report.recorded.against,
        "wall_time_s": report.wall_time.as_secs_f64(),
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
        RecordedState::Errored(message) => ("error".into(), Some(message.clone())),
        RecordedState::Skipped(reason) => ("skipped".into(), Some(reason.to_string())),
    };
    fields.insert("verdict".into(), verdict);
    if let Some(message) = message {
        fields.insert("message".into(), message.into());
    }
    value
}

fn gate_value(report: &GateReport) -> Value {
    let mut value = json!({
        "key": report.key,
        "gate": report.gate.name,
        "rules": report.gate.rules.iter().map(|rule| rule.text.as_str()).collect::<Vec<_>>(),
    });
    let fields = value.as_object_mut().expect("it was made as an object");
    match &report.state {
        GateState::Judged(verdict) => {
            fields.insert("verdict".into(), plain(&verdict.verdict));
            fields.insert("result".into(), plain(verdict));
        }
        GateState::Refused(refusal) => {
            fields.insert("verdict".into(), "error".into());
            fields.insert("message".into(), refusal.message.as_str().into());
            fields.insert("reasons".into(), refusal.reasons.clone().into());
            fields.insert("help".into(), refusal.help.as_str().into());
        }
        GateState::Skipped(message) => {
            fields.insert("verdict".into(), "skipped".into());
            fields.insert("message".into(), message.as_str().into());
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
    });
    let fields = value.as_object_mut().expect("it was made as an object");
    let (verdict, message) = match &report.state {
        BlockState::Finished(result) => {
            fields.insert("result".into(), plain(result));
            let failure = result.failure();
            (if failure.is_some() { "failed" } else { "passed" }, failure)
        }
        BlockState::Errored(message) => ("error", Some(message.clone())),
        BlockState::Skipped(reason) => ("skipped", Some(reason.to_string())),
    };
    fields.insert("verdict".into(), verdict.into());
    if let Some(message) = message {
        fields.insert("message".into(), message.into());
    }
    value
}

fn outcome_value(outcome: &Outcome, requests: &Requests) -> Value {
    let metrics: Map<_, _> = requests
        .iter()
        .zip(&outcome.metrics)
        .map(|(reference, value)| (reference.label(), value.map_or(Value::Null, Value::from)))
        .collect();
    json!({
        "key": outcome.key,
        "seed": outcome.seed,
        "individuals": outcome.individuals,
        "ending": outcome.ending,
        "metrics": metrics,
        "fingerprint": format!("{:016x}", outcome.fingerprint),
    })
}

fn plain(value: &impl Serialize) -> Value {
    serde_json::to_value(value).expect("plain data serialises")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::{BlockResult, Conclusion};
    use crate::report::fixture::{Session, evaluation, statement};
    use crate::report::schema::violations;
    use crate::scenario::Standing;

    fn results() -> Value {
        let session = Session::new();
        let text = to_json(&[session.report()], &session.requests);
        serde_json::from_str(&text).expect("it is JSON")
    }

    fn schema() -> Value {
        serde_json::from_str(include_str!("../../docs/results.schema.json")).expect("the schema is JSON")
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
        let results: Value = serde_json::from_str(&to_json(&[report], &session.requests)).unwrap();
        let findings = results.pointer("/suites/0/trials/0/findings").unwrap();
        assert_eq!(
            (&findings[0]["interval"], &findings[1]["interval"]),
            (&json!([null, 1.5]), &json!([0.5, null]))
        );
        assert_eq!(violations(&schema(), &results), Vec::<String>::new());
    }

    #[test]
    fn results_of_every_kind_of_block_are_what_the_schema_says() {
        let mut results = results();
        let blocks = results.pointer_mut("/suites/0/blocks").and_then(Value::as_array_mut).unwrap();
        let differs = Standing::Differs("the car is heavier".into());
        let unknown = Conclusion::NotComparable("nobody was run".into());
        for result in [
            BlockResult::Evaluate(evaluation()),
            BlockResult::Statement(statement(Standing::Reproduced, unknown)),
            BlockResult::Statement(statement(differs, Conclusion::NotReproduced)),
        ] {
            let kind = if matches!(result, BlockResult::Evaluate(_)) { "evaluate" } else { "statement" };
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
            ("/layout", json!(2)),
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
