//! Ratings: what the runs of each cell are worth, and what the cells earn by that.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::criteria::counts_as_none;
use super::untested::untested_by;
use crate::{
    CellWorth, EarnedPoints, NotRated, Outcome, PointsFinding, RatedCell, RatingReport, RatingResult,
    RatingState, Requests, Skip, TrialReport, TrialState, Untested, Verdict, is_value,
};
use scenario::{
    MetricReference, Rating, Scope, Trial, Value, VariationCondition, Weights, Worst, significant,
};
use sim::StopReason;
use sim::measure::Closeness;

/// Scenarios with this tag have numbers that were not read in the rule itself.
const UNVERIFIED: &str = "unverified";

/// Points that differ by less are the same: what is left of adding thirds.
const RESOLUTION: f64 = 1e-9;

/// What a rating of the suite called `suite` comes to on all `trials` of it. `set` is what was otherwise on the command line.
pub fn judge_rating(
    rating: &Arc<Rating>,
    suite: &str,
    trials: &[TrialReport],
    set: &[String],
    requests: &Requests,
) -> RatingReport {
    let state = match left_out(rating, trials, set) {
        Some(why) => RatingState::NotJudged(why),
        None => RatingState::Rated(Box::new(rated(rating, trials, requests))),
    };
    RatingReport { rating: rating.clone(), key: RatingReport::key_of(suite, rating), state }
}

/// The tag of the rating that a trial has.
fn tag<'r>(rating: &'r Rating, trial: &Trial) -> Option<&'r str> {
    let mut tags = rating.points.iter().map(|points| points.tag.as_str());
    tags.find(|tag| trial.tags.iter().any(|own| own == tag))
}

/// Why these are not the cells of the rating.
fn left_out(rating: &Rating, trials: &[TrialReport], set: &[String]) -> Option<NotRated> {
    if trials.iter().all(|trial| trial.skip() == Some(&Skip::NotSelected)) {
        return Some(NotRated::NotSelected);
    }
    let others: Vec<String> =
        set.iter().filter(|one| is_value(one) && !is_of_what_is_tested(one)).cloned().collect();
    if !others.is_empty() {
        return Some(NotRated::OtherCells(others));
    }
    let cells = || trials.iter().filter(|one| tag(rating, &one.trial).is_some());
    let left_out = cells().filter(|trial| trial.skipped()).count();
    (left_out > 0).then(|| NotRated::Part { left_out, cells: cells().count() })
}

/// Whether a value that was set is a parameter of the vehicle that is tested, or adds runs to cells.
fn is_of_what_is_tested(set: &str) -> bool {
    let name = set.split('=').next().unwrap_or_default();
    let parts: Vec<&str> = name.split('.').collect();
    name == "repeat" || matches!(parts.as_slice(), [_, "controller" | "dynamics" | "sees", ..])
}

fn rated(rating: &Rating, trials: &[TrialReport], requests: &Requests) -> RatingResult {
    let cell = |trial: &TrialReport| {
        let tag = tag(rating, &trial.trial)?;
        let worth = worth(rating, trial, requests).unwrap_or_else(CellWorth::NotAssessed);
        Some(RatedCell {
            key: trial.trial.key.clone(),
            scenario: trial.trial.scenario.clone(),
            tag: tag.to_string(),
            unverified: trial.trial.tags.iter().any(|tag| tag == UNVERIFIED),
            variation: trial.trial.variation.clone(),
            worth,
        })
    };
    let cells: Vec<RatedCell> = trials.iter().filter_map(cell).collect();
    let earned = |points: &scenario::TagPoints| {
        let own: Vec<Option<f64>> =
            cells.iter().filter(|cell| cell.tag == points.tag).map(|cell| cell.worth.weight()).collect();
        let weights: Option<Vec<f64>> = own.iter().copied().collect();
        EarnedPoints {
            tag: points.tag.clone(),
            // Without a cell nothing is earned, and nothing is known either.
            points: weights
                .filter(|weights| !weights.is_empty())
                .map(|weights| points.by.share(&weights) * points.maximum),
            maximum: points.maximum,
            cells: own.len(),
            not_assessed: own.iter().filter(|weight| weight.is_none()).count(),
        }
    };
    let tags: Vec<EarnedPoints> = rating.points.iter().map(earned).collect();
    let points = tags.iter().map(|tag| tag.points).sum::<Option<f64>>();
    let finding = |criterion: &scenario::PointsCriterion| {
        let points = match &criterion.tag {
            Some(wanted) => tags.iter().find(|one| one.tag == *wanted).and_then(|one| one.points),
            None => points,
        };
        let holds = |points: f64| {
            let points = if (points - criterion.bound).abs() < RESOLUTION { criterion.bound } else { points };
            criterion.relation.holds(points, criterion.bound)
        };
        let verdict = match points.map(holds) {
            Some(true) => Verdict::Passed,
            Some(false) => Verdict::Failed,
            None => Verdict::Inconclusive,
        };
        PointsFinding { criterion: criterion.text.clone(), verdict, points }
    };
    let findings = rating.criteria.iter().map(finding).collect();
    RatingResult { cells, tags, points, maximum: rating.maximum(), findings }
}

/// What a cell is worth, or why that is not known.
fn worth(rating: &Rating, trial: &TrialReport, requests: &Requests) -> Result<CellWorth, String> {
    match &trial.state {
        TrialState::Judged(_) => {}
        TrialState::Errored(error) => return Err(error.first_line().to_string()),
        TrialState::NotFinished(cut) => return Err(cut.to_string()),
        TrialState::Skipped(reason) => return Err(reason.to_string()),
    }
    let weights = table(rating, &trial.trial)?;
    let index = requests.index(&rating.measure);
    let index = index.ok_or_else(|| format!("`{}` was not measured", rating.measure.label()))?;
    let worst = rating.measure.known().map_or(Worst::Neither, |metric| metric.worst);
    let mut found: Option<(f64, Run)> = None;
    for outcome in &trial.outcomes {
        let run = run(&rating.measure, index, weights, outcome, requests)?;
        let weight = weights
            .weight(run.value)
            .ok_or_else(|| format!("`{}` does not exist in {}", rating.measure.label(), outcome.key))?;
        let is_worse = found.as_ref().is_none_or(|(known, other)| {
            weight < *known || weight == *known && is_worse(worst, run.value, other.value)
        });
        if is_worse {
            found = Some((weight, run));
        }
    }
    let (weight, run) = found.ok_or_else(|| "no run was made".to_string())?;
    let runs = trial.outcomes.len();
    Ok(CellWorth::Weighed { weight, value: run.value, absent: run.absent, run: run.key.to_string(), runs })
}

fn is_worse(worst: Worst, value: Option<f64>, other: Option<f64>) -> bool {
    match (worst, value, other) {
        (Worst::Largest, Some(value), Some(other)) => value > other,
        (Worst::Smallest, Some(value), Some(other)) => value < other,
        _ => false,
    }
}

/// The one table of weights that speaks of a trial.
fn table<'r>(rating: &'r Rating, trial: &Trial) -> Result<&'r Weights, String> {
    let values: BTreeMap<String, Value> =
        trial.variation.iter().map(|one| (one.name.clone(), one.value.clone())).collect();
    let holds = |condition: &VariationCondition| condition.holds(&values) == Ok(true);
    let mut speaking = rating.weights.iter().filter(|weights| weights.when.iter().all(holds));
    match (speaking.next(), speaking.next()) {
        (Some(weights), None) => Ok(weights),
        (None, _) => Err("no weights are about this cell".to_string()),
        (Some(_), Some(_)) => Err("two tables of weights are about this cell".to_string()),
    }
}

/// A run with its value.
struct Run<'o> {
    key: &'o str,
    value: Option<f64>,
    /// The metric does not exist in it, and the value is what that counts as.
    absent: bool,
}

/// What was measured in a run, or why it says nothing: it ended before its encounter did, or there was none.
fn run<'o>(
    measure: &MetricReference,
    index: usize,
    weights: &Weights,
    outcome: &'o Outcome,
    requests: &Requests,
) -> Result<Run<'o>, String> {
    let (key, label) = (outcome.key.as_str(), measure.label());
    let value = outcome.metrics.get(index).copied().flatten();
    let untested = untested_by(measure, &[outcome], requests);
    let closest = match &untested {
        Some(Untested::Pairs { pairs, .. }) => pairs.iter().map(|pair| pair.closest).min(),
        _ => None,
    };
    if closest == Some(Closeness::Absent) {
        return Err(format!("nobody appeared in {key}"));
    }
    if outcome.open(index).is_some() {
        let seconds = significant(outcome.ending.time, 4);
        return Err(format!("{key} was cut off at {seconds} s, before `{label}` was decided"));
    }
    let metric = measure.known();
    if value.is_none()
        && metric.is_some_and(|metric| matches!(metric.scope, Scope::Pair | Scope::Stream | Scope::Contact))
    {
        if outcome.ending.reason == StopReason::Collision {
            return Err(format!("a contact ended {key} of which `{label}` says nothing"));
        }
        let concerned =
            |one: &&crate::Unfinished| measure.is_of_vehicle(&one.vehicle) && measure.is_of(&one.pedestrian);
        if let Some(one) = outcome.cut_off.iter().flat_map(|cut_off| &cut_off.unfinished).find(concerned) {
            let (vehicle, pedestrian, seconds) =
                (&one.vehicle, &one.pedestrian, significant(outcome.ending.time, 4));
            return Err(format!(
                "{key} was cut off at {seconds} s, before `{vehicle}` and `{pedestrian}` were past each other"
            ));
        }
    }
    if untested.is_some() {
        return Err(match closest {
            Some(closest) if closest < Closeness::InTheWay => {
                format!("no pedestrian came into the way of a vehicle in {key}: nothing was at stake")
            }
            _ => format!("no pedestrian came near a vehicle in {key}: nothing was at stake"),
        });
    }
    if value.is_some() {
        return Ok(Run { key, value, absent: false });
    }
    let counts_as_none = metric.is_some_and(counts_as_none) && weights.weight(None).is_none();
    Ok(Run { key, value: counts_as_none.then_some(0.0), absent: counts_as_none })
}

#[cfg(test)]
mod tests;
