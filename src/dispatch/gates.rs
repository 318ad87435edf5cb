//! Gates, once everything is judged: each suite's runs against its baseline.

use std::path::Path;

use super::workshop::Workshop;
use crate::judge::baseline::{Baseline, Incompatible, measured_metrics, record};
use crate::judge::gate::judge_gate;
use crate::report::{
    GateReport, GateState, Refusal, SuiteReport, TrialReport, TrialState, record_command, render_reason,
};
use crate::run::{Unwatched, run_batch, run_case};
use crate::scenario::Gate;

/// Judges every gate of every suite and puts what it came to into the suite's report. With `lenient`, trials that a
/// baseline lacks are left out instead of being a reason not to compare.
pub fn judge_gates<'a>(workshop: &Workshop<'a>, reports: &mut [SuiteReport<'a>], lenient: bool) {
    for (suite, report) in reports.iter_mut().enumerate() {
        let gates = &workshop.suites()[suite].suite.gates;
        if gates.is_empty() {
            continue;
        }
        let trials: Vec<_> = report.trials.iter().collect();
        let measured = measured_trials(workshop, suite, &trials);
        report.gates = gates
            .iter()
            .map(|gate| judge_one_gate(workshop, suite, gate, measured.as_ref(), lenient))
            .collect();
    }
}

/// Judges one gate of the suite with index `suite` on what [`measured_trials`] gave.
pub fn judge_one_gate<'a>(
    workshop: &Workshop<'a>,
    suite: usize,
    gate: &'a Gate,
    measured: Result<&Baseline, &String>,
    lenient: bool,
) -> GateReport<'a> {
    let identity = workshop.identity(suite);
    let state = match measured {
        Ok(candidate) => state(gate, candidate, identity.file, lenient),
        Err(reason) => GateState::Skipped(reason.clone()),
    };
    GateReport { gate, key: gate_key(identity.suite, gate), state }
}

/// Such as `zebra/gate=braking`.
pub fn gate_key(suite: &str, gate: &Gate) -> String {
    format!("{suite}/gate={}", gate.name)
}

/// All trials of a suite as a baseline, or why they do not make one.
pub fn measured_trials(
    workshop: &Workshop,
    suite: usize,
    trials: &[&TrialReport],
) -> Result<Baseline, String> {
    let left_out = trials.iter().filter(|trial| trial.skipped()).count();
    if left_out > 0 {
        return Err(format!("{left_out} of {} trials were not run", trials.len()));
    }
    if let Some(trial) = trials.iter().find(|trial| matches!(trial.state, TrialState::Errored(_))) {
        return Err(format!("{} could not be run", trial.trial.key));
    }
    let prepared = &workshop.suites()[suite];
    let (requests, free_flows) = (workshop.requests(), workshop.free_flows(suite));
    let mut outcomes = Vec::with_capacity(trials.len());
    for trial in trials {
        // When a trial was decided must not decide what is compared.
        let rest: Vec<_> = trial.trial.cases[trial.outcomes.len()..].iter().collect();
        let rest = run_batch(&rest, requests, free_flows, || ());
        let rest = rest.map_err(|(key, error)| format!("{key}: {error}"))?;
        outcomes.push((trial.trial, [&trial.outcomes[..], &rest].concat()));
    }
    let trials: Vec<_> = outcomes.iter().map(|(trial, outcomes)| (*trial, &outcomes[..])).collect();
    let again = |case: &_| run_case(case, requests, free_flows, &mut Unwatched);
    let mut all = record(&prepared.plan.suite, prepared.plan.seed, &trials, requests, again)
        .map_err(|error| error.to_string())?;
    // Other suites of the session may have asked for more.
    all.keep_metrics(&measured_metrics(&prepared.suite));
    Ok(all)
}

fn state(gate: &Gate, candidate: &Baseline, file: &str, lenient: bool) -> GateState {
    let path = Path::new(&gate.baseline);
    let record = record_command(file, path);
    let judged = match Baseline::read(path) {
        Ok(base) => judge_gate(gate, &base, candidate, lenient),
        Err(error) => {
            let (message, help) = (error.to_string(), error.hint(&record));
            return GateState::Refused(Refusal { message, reasons: Vec::new(), help });
        }
    };
    match judged {
        Ok(verdict) => GateState::Judged(Box::new(verdict)),
        Err(reasons) => {
            let new_ones = reasons.iter().all(|reason| matches!(reason, Incompatible::New(_)));
            let lenient = if new_ones { "; `--baseline-lenient` leaves new trials out" } else { "" };
            GateState::Refused(Refusal {
                message: format!("the baseline {} may not be compared with", path.display()),
                reasons: reasons.iter().map(render_reason).collect(),
                help: format!("record it anew, from the version to compare with, by `{record}`{lenient}"),
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dispatch::Prepared;
    use crate::lang;
    use crate::plan::plan;
    use crate::run::{SharedTrial, Stop};

    #[test]
    fn trials_that_were_decided_early_are_run_to_their_end() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/zebra/carla_walker.scn");
        let suite = lang::load(&path).unwrap_or_else(|_| panic!("{} is a scenario", path.display())).suite;
        let plan = plan(&suite).unwrap();
        let suites = [Prepared { file: "walker.scn".into(), suite, plan, recorded: Vec::new() }];
        let workshop = Workshop::new(&suites, None, &Stop::default());
        let mut trials: Vec<_> = suites[0]
            .plan
            .trials
            .iter()
            .map(|trial| workshop.trial(0, &SharedTrial::new(trial), &|| ()))
            .collect();
        let measured = |trials: &[TrialReport]| {
            measured_trials(&workshop, 0, &trials.iter().collect::<Vec<_>>()).unwrap()
        };
        let whole = measured(&trials);
        trials[0].outcomes.truncate(3);
        assert_eq!(measured(&trials), whole);
        trials[0].state = TrialState::Errored("no".into());
        let error = measured_trials(&workshop, 0, &trials.iter().collect::<Vec<_>>()).unwrap_err();
        assert!(error.contains("could not be run"), "{error}");
    }
}
