//! What a registry knows of the metrics in results: of those that were read, only their names are known.

use std::sync::Arc;

use thiserror::Error;

use super::{
    BlockReport, BlockResult, BlockState, Finding, GateReport, GateState, RecordedState, Results,
    ScenarioSummary, SuiteReport, TrialReport, TrialState,
};
use scenario::registry::Registry;
use scenario::{Metric, Reference};

/// A metric that this program does not have: its values cannot be shown, since nobody knows what they are.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("this program has no metric called `{0}`")]
pub struct UnknownMetric(pub String);

impl Results {
    /// The same, with all metrics resolved.
    ///
    /// # Errors
    /// If the registry lacks one.
    pub fn resolved(mut self, registry: &Registry) -> Result<Self, UnknownMetric> {
        let mut unknown = None;
        let mut resolve = |metric: &mut Reference<Metric>| match registry.metrics().get(metric.name()) {
            Some(known) => *metric = known.into(),
            None => unknown = Some(UnknownMetric(metric.name().to_string())),
        };
        self.requests.iter_mut().for_each(|request| resolve(&mut request.metric));
        self.suites.iter_mut().for_each(|suite| of_suite(suite, &mut resolve));
        unknown.map_or(Ok(self), Err)
    }
}

type Resolve<'r> = &'r mut dyn FnMut(&mut Reference<Metric>);

fn of_suite(suite: &mut SuiteReport, resolve: Resolve) {
    let SuiteReport {
        identity: _,
        program: _,
        started: _,
        wall_time: _,
        recorded,
        trials,
        summary,
        blocks,
        gates,
        ratings,
        interrupted: _,
        controllers: _,
        people: _,
    } = suite;
    for report in recorded {
        if let RecordedState::Ran(rerun) = &mut report.state {
            of_findings(&mut rerun.judged.findings, resolve);
            of_findings(&mut rerun.against, resolve);
        }
    }
    trials.iter_mut().for_each(|trial| of_trial(trial, resolve));
    for ScenarioSummary { criteria, nearest, .. } in summary.iter_mut().flat_map(|one| &mut one.scenarios) {
        let criteria = criteria.iter_mut().flat_map(|applied| &mut applied.criteria);
        criteria.for_each(|criterion| resolve(&mut criterion.claim.metric_mut().metric));
        let findings = nearest.iter_mut().filter_map(|one| one.finding.as_mut());
        findings.for_each(|(_, finding)| resolve(&mut finding.metric));
    }
    blocks.iter_mut().for_each(|block| of_block(block, resolve));
    gates.iter_mut().for_each(|gate| of_gate(gate, resolve));
    for report in ratings {
        resolve(&mut Arc::make_mut(&mut report.rating).measure.metric);
    }
}

fn of_findings(findings: &mut [Finding], resolve: Resolve) {
    findings.iter_mut().for_each(|finding| resolve(&mut finding.metric));
}

fn of_trial(report: &mut TrialReport, resolve: Resolve) {
    let criteria = Arc::make_mut(&mut Arc::make_mut(&mut report.trial).criteria);
    criteria.iter_mut().for_each(|criterion| resolve(&mut criterion.claim.metric_mut().metric));
    if let TrialState::Judged(judged) = &mut report.state {
        of_findings(&mut judged.findings, resolve);
    }
}

fn of_block(report: &mut BlockReport, resolve: Resolve) {
    let declared = Arc::make_mut(&mut report.block).metrics_mut();
    declared.into_iter().for_each(|reference| resolve(&mut reference.metric));
    let BlockState::Finished(result) = &mut report.state else { return };
    match &mut **result {
        BlockResult::Evaluate(evaluate) => {
            let measures = evaluate.measures.iter_mut();
            measures.for_each(|measure| resolve(&mut measure.aggregate.metric_mut().metric));
        }
        BlockResult::Search(search) => {
            let runs = search.judged.iter_mut().flat_map(|judged| &mut judged.runs);
            runs.for_each(|run| of_findings(&mut run.findings, resolve));
        }
        BlockResult::Tune(_)
        | BlockResult::Calibrate(_)
        | BlockResult::Estimate(_)
        | BlockResult::Statement(_) => {}
    }
}

fn of_gate(report: &mut GateReport, resolve: Resolve) {
    let rules = &mut Arc::make_mut(&mut report.gate).rules;
    rules.iter_mut().filter_map(|rule| rule.metric.as_mut()).for_each(|metric| resolve(&mut metric.metric));
    if let GateState::Judged(verdict) = &mut report.state {
        verdict.checks.iter_mut().for_each(|check| resolve(&mut check.metric));
    }
}
