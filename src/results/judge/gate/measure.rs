//! What a question's pairs of runs give: one difference per independent unit, turned so that positive is worse.

use super::questions::{About, Question, RunPair};
use crate::TrialChange;
use numbers::summary::mean;

/// The numbers behind a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Differences<'a> {
    /// What is independent, in the order of [`Self::worse`]: the run's key or, where there are several people, who it is.
    pub units: Vec<&'a str>,
    /// One per pair of runs or, where there are several people, per person: those of each trial by themselves, or of all people together.
    pub worse: Vec<Vec<f64>>,
    /// Means over what is compared; events as shares.
    pub base: f64,
    pub candidate: f64,
    /// Events in pairs of runs: how many have what is bad on one side only, base and candidate.
    pub one_sided: Option<(u64, u64)>,
}

/// Smaller relative differences are rounding, which differs from machine to machine.
const ROUNDING: f64 = 1e-6;

/// The side of a pair.
type Side = fn(&RunPair<'_>) -> Option<f64>;

const BASE: Side = |pair| pair.base;
const CANDIDATE: Side = |pair| pair.candidate;

/// 1 where larger is worse, -1 where smaller is.
pub fn sign(about: About) -> f64 {
    let larger_is_worse = match about {
        About::Mean(direction) => direction.larger_is_worse,
        About::Rate(event) | About::Existence(Some(event)) => event.bad,
        About::Holds(condition) => condition.bad,
        About::Existence(None) | About::New => true,
    };
    if larger_is_worse { 1.0 } else { -1.0 }
}

pub fn differences<'a>(question: &'a Question) -> Differences<'a> {
    let numbers = |side: Side, pair: &RunPair| number(question.about, side(pair));
    type Row<'r> = (&'r str, Option<f64>, Option<f64>);
    let strata: Vec<Vec<Row>> = if question.by_people {
        let people = question.pairs.iter().map(|pair| pair.person).max().map_or(0, |last| last + 1);
        let of_person = |person: usize| {
            let runs = || question.pairs.iter().filter(|pair| pair.person == person);
            let mean_of = |side: Side| {
                let values: Vec<f64> = runs().filter_map(|pair| numbers(side, pair)).collect();
                mean(&values)
            };
            (runs().next().map_or("", |pair| pair.who), mean_of(BASE), mean_of(CANDIDATE))
        };
        vec![(0..people).map(of_person).collect()]
    } else {
        // Which trials there are is no matter of chance.
        let trials = question.pairs.chunk_by(|one, next| one.trial == next.trial);
        let row = |pair: &'a RunPair| (pair.key.as_str(), numbers(BASE, pair), numbers(CANDIDATE, pair));
        trials.map(|trial| trial.iter().map(row).collect()).collect()
    };
    let of_both = |rows: Vec<Row<'a>>| -> Vec<(&'a str, f64, f64)> {
        rows.into_iter().filter_map(|(unit, base, candidate)| Some((unit, base?, candidate?))).collect()
    };
    let strata: Vec<Vec<(&str, f64, f64)>> = strata.into_iter().map(of_both).collect();
    let both: Vec<(&str, f64, f64)> = strata.concat();
    let count = both.len() as f64;
    let sign = sign(question.about);
    let worse_of = |stratum: &Vec<(&str, f64, f64)>| -> Vec<f64> {
        stratum.iter().map(|(_, base, candidate)| sign * difference(*base, *candidate)).collect()
    };
    let worse: Vec<Vec<f64>> = strata.iter().map(worse_of).collect();
    let is_event = !matches!(question.about, About::Mean(_));
    let one_sided = (is_event && !question.by_people).then(|| {
        let many = |wanted: f64| worse.iter().flatten().filter(|one| **one == wanted).count() as u64;
        (many(-1.0), many(1.0))
    });
    Differences {
        base: both.iter().map(|pair| pair.1).sum::<f64>() / count,
        candidate: both.iter().map(|pair| pair.2).sum::<f64>() / count,
        units: both.iter().map(|pair| pair.0).collect(),
        worse,
        one_sided,
    }
}

/// What a run counts as.
fn number(about: About, value: Option<f64>) -> Option<f64> {
    match about {
        About::Existence(_) => Some(f64::from(value.is_some())),
        About::Rate(_) => value.map(|value| f64::from(value != 0.0)),
        About::Holds(condition) => condition.holds(value).map(f64::from),
        About::New => Some(f64::from(value.is_some_and(|value| value != 0.0))),
        About::Mean(_) => value,
    }
}

/// By how much a pair got worse, if it can be compared; negative if it got better.
pub fn worse_by(about: About, pair: &RunPair) -> Option<f64> {
    let (base, candidate) = number(about, pair.base).zip(number(about, pair.candidate))?;
    Some(sign(about) * difference(base, candidate))
}

/// The trial of a comparison that got worse by most; `None` where there is only one.
pub fn worst_trial(question: &Question) -> Option<TrialChange> {
    let trials: Vec<&[RunPair]> = question.pairs.chunk_by(|one, next| one.trial == next.trial).collect();
    if trials.len() < 2 {
        return None;
    }
    let change = |pairs: &&[RunPair]| {
        let both = pairs
            .iter()
            .filter_map(|pair| number(question.about, pair.base).zip(number(question.about, pair.candidate)));
        let (base, candidate): (Vec<f64>, Vec<f64>) = both.unzip();
        let (base, candidate) = (mean(&base)?, mean(&candidate)?);
        let worse_by = sign(question.about) * difference(base, candidate);
        Some(TrialChange { key: pairs[0].trial.to_string(), base, candidate, worse_by })
    };
    let changes = trials.iter().filter_map(change);
    // The first of equal ones.
    changes.reduce(|worst, other| if other.worse_by > worst.worse_by { other } else { worst })
}

/// Candidate minus base, but for rounding.
pub fn difference(base: f64, candidate: f64) -> f64 {
    let difference = candidate - base;
    if difference.abs() <= ROUNDING * base.abs().max(candidate.abs()) { 0.0 } else { difference }
}
