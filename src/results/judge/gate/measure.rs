//! What a question's pairs of runs give: one difference per independent unit, turned so that positive is worse.

use super::questions::{About, Question, RunPair};
use crate::TrialChange;
use numbers::summary::mean;

/// The numbers behind a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Differences {
    /// One per pair of runs or, where there are several people, per person.
    pub worse: Vec<f64>,
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
        About::Existence(None) | About::New => true,
    };
    if larger_is_worse { 1.0 } else { -1.0 }
}

pub fn differences(question: &Question) -> Differences {
    let numbers = |side: Side, pair: &RunPair| number(question.about, side(pair));
    let rows: Vec<(Option<f64>, Option<f64>)> = if question.by_people {
        let people = question.pairs.iter().map(|pair| pair.person).max().map_or(0, |last| last + 1);
        let of_person = |side: Side, person: usize| {
            let runs = question.pairs.iter().filter(|pair| pair.person == person);
            let values: Vec<f64> = runs.filter_map(|pair| numbers(side, pair)).collect();
            mean(&values)
        };
        (0..people).map(|person| (of_person(BASE, person), of_person(CANDIDATE, person))).collect()
    } else {
        question.pairs.iter().map(|pair| (numbers(BASE, pair), numbers(CANDIDATE, pair))).collect()
    };
    let both: Vec<(f64, f64)> =
        rows.into_iter().filter_map(|(base, candidate)| base.zip(candidate)).collect();
    let count = both.len() as f64;
    let sign = sign(question.about);
    let worse: Vec<f64> = both.iter().map(|(base, candidate)| sign * difference(*base, *candidate)).collect();
    let is_event = !matches!(question.about, About::Mean(_));
    let one_sided = (is_event && !question.by_people).then(|| {
        let many = |wanted: f64| worse.iter().filter(|one| **one == wanted).count() as u64;
        (many(-1.0), many(1.0))
    });
    Differences {
        base: both.iter().map(|pair| pair.0).sum::<f64>() / count,
        candidate: both.iter().map(|pair| pair.1).sum::<f64>() / count,
        worse,
        one_sided,
    }
}

/// What a run counts as.
fn number(about: About, value: Option<f64>) -> Option<f64> {
    match about {
        About::Existence(_) => Some(f64::from(value.is_some())),
        About::Rate(_) => value.map(|value| f64::from(value != 0.0)),
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
