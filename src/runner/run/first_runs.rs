//! Runs that are made twice, to see whether programs decide the same the second time.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::job::{LoggedDecision, Ran, Wanted, programs};
use scenario::{Case, Dimension, show, show_apart};

/// One of so many runs is made twice, the first of each scenario among them.
const EACH: usize = 200;

/// Which runs in which programs decide are made twice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VerifyRuns {
    /// None of them.
    None,
    /// The first of each scenario and of each block, and every 200th.
    #[default]
    Some,
    /// Every one.
    All,
}

/// The runs of a suite that are to be made a second time, and what came of the first.
#[derive(Debug, Clone, Default)]
pub struct FirstRuns {
    verify: VerifyRuns,
    kept: Arc<Mutex<Kept>>,
}

#[derive(Debug, Default)]
struct Kept {
    /// How many runs of each scenario there may have been up to now.
    numbered: HashMap<String, usize>,
    runs: Vec<FirstRun>,
}

/// A run that came to its end.
#[derive(Debug, Clone)]
pub struct FirstRun {
    /// What is run.
    pub case: Case,
    /// Of the run.
    pub fingerprint: u64,
    /// What programs decided in it.
    pub decisions: Vec<LoggedDecision>,
}

impl FirstRuns {
    /// None yet, with those of them that are to be kept.
    pub fn new(verify: VerifyRuns) -> Self {
        Self { verify, kept: Arc::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The number of the first of so many further runs of a scenario. Which runs are made twice depends on the order in which this is
    /// asked, and on nothing else.
    pub fn number(&self, scenario: &str, runs: usize) -> usize {
        let mut kept = self.lock();
        let next = kept.numbered.entry(scenario.to_string()).or_default();
        let first = *next;
        *next += runs;
        first
    }

    /// Whether the run of this number is made twice.
    pub fn takes(&self, number: usize, case: &Case) -> bool {
        let is_due = match self.verify {
            VerifyRuns::None => false,
            VerifyRuns::Some => number.is_multiple_of(EACH),
            VerifyRuns::All => true,
        };
        let programs = if is_due { programs(case) } else { Vec::new() };
        !programs.is_empty() && !programs.iter().any(|program| program.may_differ())
    }

    /// What is wanted of the run of this number.
    pub fn wanted(&self, number: usize, case: &Case) -> Wanted {
        if self.takes(number, case) { Wanted::Decisions } else { Wanted::Outcome }
    }

    /// Keeps a run that is made twice.
    pub fn keep(&self, case: &Case, ran: &mut Ran) {
        let (fingerprint, decisions) = (ran.outcome.fingerprint, std::mem::take(&mut ran.decisions));
        self.lock().runs.push(FirstRun { case: case.clone(), fingerprint, decisions });
    }

    /// All that were kept, in the order of their names.
    pub fn take(&self) -> Vec<FirstRun> {
        let mut runs = std::mem::take(&mut self.lock().runs);
        runs.sort_by(|one, other| one.case.key.cmp(&other.case.key));
        runs.dedup_by(|one, other| one.case.key == other.case.key);
        runs
    }
}

impl FirstRun {
    /// The first difference to the same run made again, with the vehicle of which it is; `None` if there is none.
    pub fn difference(&self, again: &Ran) -> Option<(usize, String)> {
        let pairs = self.decisions.iter().zip(&again.decisions);
        let differs = |one: &LoggedDecision, other: &LoggedDecision| {
            let bits =
                |one: &LoggedDecision| one.values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            one.vehicle != other.vehicle || one.time != other.time || bits(one) != bits(other)
        };
        if let Some((one, other)) = pairs.clone().find(|(one, other)| differs(one, other)) {
            return Some((one.vehicle, in_words(one, other)));
        }
        let (longer, same) =
            (self.decisions.len().max(again.decisions.len()), self.decisions.len() == again.decisions.len());
        if same && self.fingerprint == again.outcome.fingerprint {
            return None;
        }
        let vehicle = self.decisions.first().map_or(0, |one| one.vehicle);
        let (first, second) = (self.decisions.len(), again.decisions.len());
        Some(match same {
            false => (vehicle, format!("{first} decisions, then {second}")),
            true => (vehicle, format!("another course after the same {longer} decisions")),
        })
    }
}

/// Such as `at 3.2 s -1.2 m/s^2, then -1.15 m/s^2`.
fn in_words(one: &LoggedDecision, other: &LoggedDecision) -> String {
    let time = show(one.time, None, Dimension::TIME);
    if one.time != other.time {
        return format!(
            "at {time} a decision that the second time was at {}",
            show(other.time, None, Dimension::TIME)
        );
    }
    let number = |value: f64, dimension: Dimension| (value, dimension, None);
    let (first, second) = match (&one.values[..], &other.values[..]) {
        ([one], [other]) => {
            let mut both =
                show_apart(&[number(*one, Dimension::ACCELERATION), number(*other, Dimension::ACCELERATION)])
                    .into_iter();
            (both.next().unwrap_or_default(), both.next().unwrap_or_default())
        }
        (one, other) => {
            let numbers: Vec<_> =
                one.iter().chain(other).map(|value| number(*value, Dimension::NUMBER)).collect();
            let shown = show_apart(&numbers);
            let (one, other) = shown.split_at(one.len());
            let names = |values: &[String]| match values {
                [throttle, brake] => format!("throttle {throttle} and brake {brake}"),
                _ => format!("the plan {}", values.join(" ")),
            };
            (names(one), names(other))
        }
    };
    format!("at {time} {first}, then {second}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decision(values: &[f64]) -> LoggedDecision {
        LoggedDecision { vehicle: 0, time: 3.2, values: values.to_vec() }
    }

    #[test]
    fn the_first_difference_is_named() {
        let said = |one: &[f64], other: &[f64]| in_words(&decision(one), &decision(other));
        assert_eq!(said(&[-1.2], &[-1.15]), "at 3.2 s -1.2 m/s^2, then -1.15 m/s^2");
        assert_eq!(said(&[0.1], &[0.1 + 1e-16]), "at 3.2 s 0.1 m/s^2, then 0.1000000000000001 m/s^2");
        assert_eq!(said(&[0.0], &[1e-17]), "at 3.2 s 0 m/s^2, then 1e-17 m/s^2");
        assert_eq!(said(&[0.0], &[-0.0]), "at 3.2 s 0 m/s^2, then -0 m/s^2");
        assert_eq!(
            said(&[0.2, 0.0], &[0.3, 0.0]),
            "at 3.2 s throttle 0.2 and brake 0, then throttle 0.3 and brake 0"
        );
        assert_eq!(
            said(&[0.0, 8.0, 1.0, 7.0], &[0.0, 8.0, 1.0, 6.0]),
            "at 3.2 s the plan 0 8 1 7, then the plan 0 8 1 6"
        );
    }

    #[test]
    fn the_first_of_a_scenario_and_every_200th_are_numbered() {
        let first = FirstRuns::new(VerifyRuns::Some);
        assert_eq!([first.number("a", 150), first.number("b", 10), first.number("a", 150)], [0, 0, 150]);
        assert_eq!(first.number("a", 1), 300);
    }
}
