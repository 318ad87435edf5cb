//! Verdicts that were read are worked out again from the runs, values, bounds and intervals beside them: an edited word turns nothing green.

use super::error::{ResultsError, contradiction};
use crate::wording::verdict_word;
use results::judge::{Watch, judge, judge_rating};
use results::{
    BlockResult, Candidate, ClaimValues, Conclusion, EstimateResult, Finding, GateReport, GateState,
    RecordedReport, RecordedState, Requests, Results, SearchResult, StatementResult, SuiteReport,
    TrialReport, TrialState, TuneResult, Verdict, Violations,
};
use scenario::{Block, DeclaredStanding};

/// The same results, if each verdict follows from its parts.
///
/// # Errors
/// The first unit of which that is not so.
pub(super) fn verified(results: Results) -> Result<Results, ResultsError> {
    results.suites.iter().try_for_each(|suite| of_suite(suite, &results.requests))?;
    Ok(results)
}

fn of_suite(suite: &SuiteReport, requests: &Requests) -> Result<(), ResultsError> {
    suite.trials.iter().try_for_each(|trial| of_trial(trial, requests))?;
    suite.recorded.iter().try_for_each(of_recorded)?;
    for block in &suite.blocks {
        let Some(result) = block.result() else { continue };
        let wrong = match result {
            BlockResult::Statement(statement) => wrong_statement(statement),
            BlockResult::Estimate(estimate) => wrong_estimate(estimate),
            BlockResult::Search(search) => wrong_search(&block.block, search, requests),
            BlockResult::Tune(tune) => wrong_tune(tune),
            BlockResult::Evaluate(_) | BlockResult::Calibrate(_) => None,
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
            return Err(contradiction(&rating.key, "its cells and points do not follow from the runs"));
        }
    }
    Ok(())
}

/// A trial's verdict, from its runs.
fn of_trial(report: &TrialReport, requests: &Requests) -> Result<(), ResultsError> {
    let TrialState::Judged(judged) = &report.state else { return Ok(()) };
    let again = Watch::new(&report.trial, requests).verdict(&report.outcomes);
    if again == *judged {
        return Ok(());
    }
    let differs = |(written, found): &(&Finding, &Finding)| written != found;
    let what = match judged.findings.iter().zip(&again.findings).find(differs) {
        Some((written, found)) if written.verdict != found.verdict => {
            let (said, is) = (verdict_word(written.verdict), verdict_word(found.verdict));
            format!("it says {said} of `{}`, and its runs give {is}", written.criterion)
        }
        Some((written, _)) => format!("its numbers of `{}` are not those of its runs", written.criterion),
        None => "its verdict does not follow from its runs".to_string(),
    };
    Err(contradiction(&report.trial.key, what))
}

/// The verdict on a recorded run, from its findings.
fn of_recorded(recorded: &RecordedReport) -> Result<(), ResultsError> {
    let RecordedState::Ran(rerun) = &recorded.state else { return Ok(()) };
    let worst = rerun.judged.findings.iter().map(|finding| finding.verdict).max();
    match worst.unwrap_or(Verdict::Passed) == rerun.judged.verdict {
        true => Ok(()),
        false => Err(contradiction(&recorded.key, "its verdict is not the worst of its findings")),
    }
}

/// What in a statement does not follow from its claims and their values.
fn wrong_statement(statement: &StatementResult) -> Option<String> {
    for claim in &statement.claims {
        let ClaimValues::Compared { left: Some(left), relation, right: Some(right) } = &claim.values else {
            continue;
        };
        if claim.holds.is_some_and(|holds| holds != relation.holds(*left, *right)) {
            return Some(format!("whether `{}` holds does not follow from its numbers", claim.text));
        }
    }
    let any = |holds: Option<bool>| statement.claims.iter().any(|claim| claim.holds == holds);
    let untested = statement.claims.iter().any(|claim| claim.untested.is_some());
    let follows = match (&statement.standing, &statement.conclusion) {
        // Declared so, whatever its claims say.
        (DeclaredStanding::NotComparable(_), conclusion) => {
            matches!(conclusion, Conclusion::NotComparable(_))
        }
        (_, Conclusion::NotComparable(_)) => !any(Some(false)) && any(None),
        (_, Conclusion::NotReproduced) => any(Some(false)),
        (_, Conclusion::Reproduced) => !any(Some(false)) && !any(None) && !untested,
        (_, Conclusion::Untested) => !any(Some(false)) && !any(None) && untested,
    };
    (!follows).then(|| "its conclusion does not follow from its claims".to_string())
}

/// What in a search does not follow from the runs that it found.
fn wrong_search(declared: &Block, search: &SearchResult, requests: &Requests) -> Option<String> {
    let Block::Search(declared) = declared else { return Some("it is of another block".to_string()) };
    let of_kept = search.found.iter().any(|found| found.kept.contains(&true));
    let Some(judged) = &search.judged else {
        let is_missing = !declared.expect.is_empty();
        return is_missing.then(|| "it expects something, and no run is judged".to_string());
    };
    if declared.expect.is_empty() || judged.of_kept != of_kept {
        return Some("which runs are judged does not follow from what it expects and keeps".to_string());
    }
    let each = search.found.iter().enumerate().flat_map(|(index, found)| {
        let runs = found.runs.iter().zip(&found.kept).filter(|(_, kept)| **kept || !of_kept);
        runs.map(move |(run, _)| (index, run))
    });
    let found: Vec<_> = each.collect();
    if found.len() != judged.runs.len() {
        return Some("not all of its runs are judged".to_string());
    }
    let differs = found.iter().zip(&judged.runs).find(|((index, run), judged)| {
        let again = judge(&declared.expect, std::slice::from_ref(&run.outcome), requests);
        judged.found != *index
            || !judged.key.starts_with(&run.case.key)
            || judged.fresh_holding > judged.fresh_runs
            || judged.findings != again.findings
    });
    differs.map(|(_, judged)| format!("what it says of `{}` does not follow from that run", judged.key))
}

/// What in a tune does not follow from its candidates.
fn wrong_tune(tune: &TuneResult) -> Option<String> {
    let follows = |one: &Candidate| {
        let is_broken = one.margins.iter().flatten().any(|margin| *margin < 0.0);
        one.margins.len() == tune.constraints.len()
            && !(one.keeps_constraints && is_broken)
            && one.feasible == (one.keeps_constraints && !one.objectives.contains(&None))
    };
    if !tune.evaluations.iter().all(follows) {
        return Some(
            "whether a candidate is feasible does not follow from its values and margins".to_string(),
        );
    }
    let answers: Vec<_> = tune.chosen.iter().chain(&tune.pareto).collect();
    if !answers.iter().all(|one| tune.evaluations.contains(one)) {
        return Some("its choice is not one of its candidates".to_string());
    }
    let is_declared_broken = tune.violations.is_some_and(|violations| violations.runs > 0);
    if !is_declared_broken && answers.iter().any(|one| !one.feasible) {
        return Some("what is chosen is not feasible".to_string());
    }
    let looked_at = if tune.constraints.is_empty() { 0 } else { answers.len() };
    let is_whole = |one: &Violations| one.of > 0 && one.runs <= one.of;
    let is_judged = tune.fresh_violations.len() == looked_at && tune.fresh_violations.iter().all(is_whole);
    (!is_judged).then(|| "what is chosen is not judged with fresh seeds".to_string())
}

/// What in an estimate does not follow from its numbers.
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
        return Err(contradiction(&report.key, "its verdict does not follow from its comparisons"));
    }
    match verdict.checks.iter().find(|check| check.contradicts_itself()) {
        Some(check) => {
            let what = format!(
                "what it says of `{}` in {} does not follow from its numbers",
                check.label, check.place
            );
            Err(contradiction(&report.key, what))
        }
        None => Ok(()),
    }
}
