//! The people of the HIKER experiment beside a population that was calibrated elsewhere: shares, spread between persons, initiation
//! times.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use serde::Deserialize;

use super::hiker::{HikerError, HikerReference};
use super::meeting::Waiting;
use super::parameters::Parameters;
use super::variant::Variant;
use numbers::random::derive_seed;
use numbers::summary::median;

/// What each person of the experiment did, `hiker_persons.json`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HikerPersons {
    /// What the file says about itself.
    #[serde(rename = "note")]
    pub _note: String,
    /// By scenario: trials of a person, of these crossed before the second car, and how many persons did so.
    pub scenarios: BTreeMap<String, Vec<(u32, u32, u32)>>,
}

/// A scenario as people did, and as the population does.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldBackScenario {
    /// The scenario's name.
    pub scenario: String,
    /// Share of trials in which people crossed before the second car.
    pub observed: f64,
    /// Its standard error by drawing persons anew.
    pub error: f64,
    /// Of the population.
    pub share: f64,
    /// Share of pairs of a person's trials in which both crossed before it.
    pub observed_spread: f64,
    /// Of the population.
    pub spread: f64,
    /// Median initiation time of people who crossed before it, s after the first car passed; `None` where too few did.
    pub observed_start: Option<f64>,
    /// Of the population.
    pub start: Option<f64>,
}

impl HikerPersons {
    /// Reads the file.
    ///
    /// # Errors
    /// If it cannot be read or is not of the format.
    pub fn read(file: &Path) -> Result<Self, HikerError> {
        let text =
            files::read_text(file).map_err(|error| HikerError::Read { file: file.to_owned(), error })?;
        serde_json::from_str(&text).map_err(|error| HikerError::Format { file: file.to_owned(), error })
    }
}

/// Puts every one of `people` into every scenario of which it is known what persons did, `repetitions` times each, at least 2; `waiting` says what
/// keeps them from entering before the first car has passed.
pub fn held_back(
    reference: &HikerReference,
    persons: &HikerPersons,
    variant: &Variant,
    people: &[Parameters],
    (repetitions, seed): (u32, u64),
    waiting: Waiting,
) -> Vec<HeldBackScenario> {
    let middle = reference.quantile_levels.iter().position(|&level| level == 0.5);
    let one = |(name, scenario): (&String, &super::hiker::HikerScenario)| {
        let known = persons.scenarios.get(name)?;
        let runs: Vec<Vec<f64>> = people
            .par_iter()
            .enumerate()
            .map(|(person, parameters)| {
                let run = |repetition| {
                    let seed = derive_seed(seed, &format!("held back/{name}/{person}/{repetition}"));
                    scenario.start_of_crossing(variant, parameters, (seed, waiting))
                };
                (0..repetitions).filter_map(run).collect()
            })
            .collect();
        let count = f64::from(repetitions);
        let number = people.len() as f64;
        let pairs = |held: f64, all: f64| held * (held - 1.0) / (all * (all - 1.0));
        let mut starts: Vec<f64> = runs.iter().flatten().copied().collect();
        starts.sort_by(f64::total_cmp);
        let (observed, error) = share_of(known);
        // Who has a single trial has no pair of them.
        let several = || known.iter().filter(|(trials, ..)| *trials > 1);
        let observed_pairs: f64 = several()
            .map(|(trials, held, persons)| f64::from(*persons) * pairs(f64::from(*held), f64::from(*trials)))
            .sum();
        Some(HeldBackScenario {
            scenario: name.clone(),
            observed,
            error,
            share: starts.len() as f64 / (number * count),
            observed_spread: observed_pairs / several().map(|(.., persons)| f64::from(*persons)).sum::<f64>(),
            spread: runs.iter().map(|starts| pairs(starts.len() as f64, count)).sum::<f64>() / number,
            observed_start: middle.and_then(|middle| scenario.human.quantiles.as_ref()?.get(middle).copied()),
            start: median(&starts),
        })
    };
    reference.scenarios.iter().filter_map(one).collect()
}

/// The share of all trials, and the standard error of a ratio over persons.
pub(super) fn share_of(persons: &[(u32, u32, u32)]) -> (f64, f64) {
    let sum = |of: &dyn Fn(f64, f64) -> f64| {
        let each = persons
            .iter()
            .map(|(trials, held, count)| f64::from(*count) * of(f64::from(*trials), f64::from(*held)));
        each.sum::<f64>()
    };
    let (number, trials) = (sum(&|_, _| 1.0), sum(&|trials, _| trials));
    let share = sum(&|_, held| held) / trials;
    let squares = sum(&|trials, held| (held - share * trials) * (held - share * trials));
    (share, (squares * number / (number - 1.0).max(1.0)).sqrt() / trials)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_between_persons() {
        // Two of four persons always cross, two never: 10 trials each say no more than one.
        let (share, error) = share_of(&[(10, 0, 2), (10, 10, 2)]);
        assert_eq!(share, 0.5);
        assert!((error - (0.25f64 / 3.0).sqrt()).abs() < 1e-12, "{error}");
    }
}
