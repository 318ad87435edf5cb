//! Verdicts that were read are worked out again from the runs, values, bounds and intervals beside them: an edited word turns nothing green.

use super::error::{ResultsError, contradiction};
use results::judge::{Watch, judge_rating};
use results::{
    BlockResult, ClaimValues, Conclusion, EstimateResult, Finding, GateReport, GateState, RecordedState,
    Requests, Results, StatementResult, SuiteReport, TrialReport, TrialState, TrialVerdict, Verdict,
};

/// The same results, if each verdict is what its parts come to.
///
/// # Errors
/// The first unit of which that is not so.
pub(super) fn verified(results: Results) -> Result<Results, ResultsError> {
    results.suites.iter().try_for_each(|suite| of_suite(suite, &results.requests))?;
    Ok(results)
}

fn of_suite(suite: &SuiteReport, requests: &Requests) -> Result<(), ResultsError> {
    suite.trials.iter().try_for_each(|trial| of_trial(trial, requests))?;
    for recorded in &suite.recorded {
        if let RecordedState::Ran(rerun) = &recorded.state {
            of_findings(&recorded.key, &rerun.judged)?;
        }
    }
    for block in &suite.blocks {
        let Some(result) = block.result() else { continue };
        let wrong = match result {
            BlockResult::Statement(statement) => wrong_statement(statement),
            BlockResult::Estimate(estimate) => wrong_estimate(estimate),
            BlockResult::Search(_)
            | BlockResult::Tune(_)
            | BlockResult::Evaluate(_)
            | BlockResult::Calibrate(_) => None,
        };
        if let Some(what) = wrong {
            return Err(contradiction(&block.key, what));
        }
    }
    suite.gates.iter().try_for_each(of_gate)?;
    for rating in &suite.ratings {
        let again =
            judge_rating(&rating.rating, &suite.identity.suite, &suite.trials, &suite.identity.set, requests);
        if again.state != rating.state {
            return Err(contradiction(&rating.key, "its cells and points are not what the runs come to"));
        }
    }
    Ok(())
}

/// A trial's findings, from its runs.
fn of_trial(report: &TrialReport, requests: &Requests) -> Result<(), ResultsError> {
    let TrialState::Judged(judged) = &report.state else { return Ok(()) };
    let key = &report.trial.key;
    of_findings(key, judged)?;
    let again = Watch::new(&report.trial, requests).verdict(&report.outcomes);
    if again == *judged {
        return Ok(());
    }
    let differs = |(one, other): &(&Finding, &Finding)| one != other;
    let what = match judged.findings.iter().zip(&again.findings).find(differs) {
        Some((written, found)) => format!(
            "it says that `{}` {}, and its runs come to something else: {}",
            written.criterion,
            word(written.verdict),
            word(found.verdict)
        ),
        None => "what it says of its runs is not what they come to".to_string(),
    };
    Err(contradiction(key, what))
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Passed => "passed",
        Verdict::Inconclusive => "is inconclusive",
        Verdict::Failed => "failed",
    }
}

/// The worst of its findings.
fn of_findings(key: &str, judged: &TrialVerdict) -> Result<(), ResultsError> {
    let worst = judged.findings.iter().map(|finding| finding.verdict).max().unwrap_or(Verdict::Passed);
    match worst == judged.verdict {
        true => Ok(()),
        false => Err(contradiction(key, "its verdict is not the worst of its findings")),
    }
}

/// What in a statement is not what its claims and their values come to.
fn wrong_statement(statement: &StatementResult) -> Option<String> {
    for claim in &statement.claims {
        let ClaimValues::Compared { left: Some(left), relation, right: Some(right) } = &claim.values else {
            continue;
        };
        if claim.holds.is_some_and(|holds| holds != relation.holds(*left, *right)) {
            return Some(format!("whether `{}` holds is not what its numbers say", claim.text));
        }
    }
    let any = |holds: Option<bool>| statement.claims.iter().any(|claim| claim.holds == holds);
    let untested = statement.claims.iter().any(|claim| claim.untested.is_some());
    let is_wrong = match &statement.conclusion {
        Conclusion::NotComparable(_) => any(Some(false)),
        Conclusion::NotReproduced => !any(Some(false)),
        Conclusion::Reproduced => any(Some(false)) || any(None) || untested,
        Conclusion::Untested => any(Some(false)) || any(None) || !untested,
    };
    is_wrong.then(|| "its conclusion is not what its claims come to".to_string())
}

/// What in an estimate is not what its numbers come to.
fn wrong_estimate(estimate: &EstimateResult) -> Option<String> {
    let of_nothing = estimate.encounters == 0 && estimate.hits == 0;
    let is_refused = |guaranteed: bool| of_nothing || (!guaranteed && !estimate.refusals.is_empty());
    let wrong = estimate.claims.iter().find(|claim| {
        estimate.compared.is_none() && claim.verdict == Verdict::Passed && is_refused(claim.guaranteed)
    })?;
    Some(format!("`{}` passed, and the estimate that it rests on is refused", wrong.text))
}

/// A gate's verdict, from its checks, and those from their numbers.
fn of_gate(report: &GateReport) -> Result<(), ResultsError> {
    let GateState::Judged(verdict) = &report.state else { return Ok(()) };
    if verdict.worked_out() != verdict.verdict {
        return Err(contradiction(&report.key, "its verdict is not what its comparisons come to"));
    }
    match verdict.checks.iter().find(|check| check.contradicts_itself()) {
        Some(check) => {
            let what =
                format!("what it says of `{}` in {} is not what its numbers say", check.label, check.place);
            Err(contradiction(&report.key, what))
        }
        None => Ok(()),
    }
}
