//! Failing cases moved towards what is declared: what is left is what the failure needs.
//!
//! One thing is moved at a time, all the way if the case still fails there, else as far as it does, and this again until
//! nothing moves. The seed stays. Each step depends only on runs before it, a round of one run each, so the same case always
//! shrinks alike.

mod knob;

use std::sync::Arc;

use thiserror::Error;

use crate::plan::PlanError;
use crate::run::{BatchError, Executor, MeasuredMetrics, RunBatch, RunError, Stop, Wanted};
use results::judge::{PerRun, RunStanding};
use results::{Outcome, Requests};
use scenario::registry::Registry;
use scenario::significant;

pub use knob::{Knob, KnobPlace};

/// Why there is nothing to shrink.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ShrinkError {
    /// The case cannot be planned.
    #[error("{0}")]
    Plan(#[from] PlanError),
    /// The case cannot be run.
    #[error("{0}")]
    Run(#[from] RunError),
    /// Somebody wished it before anything was known.
    #[error("interrupted")]
    Stopped,
    /// The run does not fail the criterion.
    #[error("the run does not speak against `{criterion}`")]
    Holds {
        /// In canonical words.
        criterion: String,
    },
}

/// One thing that was moved, or tried to.
#[derive(Debug, Clone, PartialEq)]
pub struct Move {
    /// What was moved.
    pub knob: Knob,
    /// Its value in the case that was given, SI units.
    pub from: f64,
    /// Its value now, SI units.
    pub to: f64,
}

impl Move {
    /// The share of the way to the nominal value, 0..1.
    pub fn share(&self) -> f64 {
        (self.to - self.from) / (self.knob.nominal - self.from)
    }
}

/// A failing case that is as near to what is declared as it still fails.
#[derive(Debug, Clone, PartialEq)]
pub struct Shrunk {
    /// The case as it is now.
    pub place: KnobPlace,
    /// What its run came to.
    pub outcome: Outcome,
    /// What was measured, in the order of the outcome's metrics.
    pub requests: Requests,
    /// How it stands to the criterion, which it still fails.
    pub standing: RunStanding,
    /// Of everything that was not nominal from the beginning.
    pub moves: Vec<Move>,
    /// Road users without whom it still fails.
    pub left_out: Vec<String>,
    /// How many runs it took.
    pub runs: usize,
    /// Whether somebody stopped it before it was done.
    pub stopped: bool,
}

/// Told after every run: how many there were, and what is being moved.
pub type ShrinkProgress<'p> = dyn FnMut(usize, &str) + 'p;

/// More rounds over everything change hardly anything.
const MOST_ROUNDS: usize = 8;
/// A value that still fails is sought up to this share of the way.
const RESOLUTION: f64 = 0.01;
/// A shorter way is not worth an odd number.
const LEAST_MOVE: f64 = 0.05;
/// Of the way that was found, rounding may give away this much.
const GIVEN_FOR_ROUNDNESS: f64 = 0.1;
const MOST_DIGITS: i32 = 6;

/// Shrinks the case at `place`, which fails `criterion`, as long as nobody wishes to stop. `executor` makes the runs.
///
/// # Errors
/// If it cannot be run, or does not fail.
pub fn shrink(
    place: KnobPlace,
    criterion: &PerRun,
    registry: &Registry,
    executor: &dyn Executor,
    stop: &Stop,
    progress: &mut ShrinkProgress,
) -> Result<Shrunk, ShrinkError> {
    let mut trials = Trials::new(criterion, registry, executor, stop, progress);
    let mut shrunk = trials.begin(place)?;
    leave_out(&mut shrunk, &mut trials);
    let knobs = knob::knobs(&shrunk.place);
    let from: Vec<f64> = knobs.iter().map(|knob| knob.value(&shrunk.place)).collect();
    for _ in 0..MOST_ROUNDS {
        let mut moved = false;
        for knob in &knobs {
            moved |= turn(knob, &mut shrunk, &mut trials);
        }
        if !moved {
            break;
        }
    }
    let moves = knobs.into_iter().zip(from).filter(|(knob, from)| knob.nominal != *from);
    shrunk.moves = moves.map(|(knob, from)| Move { to: knob.value(&shrunk.place), knob, from }).collect();
    (shrunk.runs, shrunk.stopped) = (trials.runs, stop.is_requested());
    Ok(shrunk)
}

/// The case at `place`, which fails `criterion`, as it is.
///
/// # Errors
/// As for [`shrink`].
pub fn unmoved(
    place: KnobPlace,
    criterion: &PerRun,
    registry: &Registry,
    executor: &dyn Executor,
) -> Result<Shrunk, ShrinkError> {
    Trials::new(criterion, registry, executor, &Stop::default(), &mut |_, _| ()).begin(place)
}

/// What is measured in every run: all metrics, and the criterion's own.
pub fn requests(criterion: &PerRun, registry: &Registry) -> Requests {
    let mut requests = Requests::defaults(registry);
    requests.add(criterion.criterion.claim.metric());
    requests
}

/// Runs cases to see whether they fail.
struct Trials<'t, 'p> {
    criterion: &'t PerRun,
    measured: Arc<MeasuredMetrics>,
    executor: &'t dyn Executor,
    stop: &'t Stop,
    progress: &'t mut ShrinkProgress<'p>,
    runs: usize,
}

impl<'t, 'p> Trials<'t, 'p> {
    fn new(
        criterion: &'t PerRun,
        registry: &Registry,
        executor: &'t dyn Executor,
        stop: &'t Stop,
        progress: &'t mut ShrinkProgress<'p>,
    ) -> Self {
        Self {
            criterion,
            measured: MeasuredMetrics::new(requests(criterion, registry)),
            executor,
            stop,
            progress,
            runs: 0,
        }
    }

    fn begin(&mut self, place: KnobPlace) -> Result<Shrunk, ShrinkError> {
        let failed = self.run(&place, "")?;
        let criterion = || self.criterion.criterion.text.clone();
        let (outcome, standing) = failed.ok_or_else(|| ShrinkError::Holds { criterion: criterion() })?;
        let (moves, left_out) = (Vec::new(), Vec::new());
        let requests = self.measured.requests.clone();
        Ok(Shrunk { place, outcome, requests, standing, moves, left_out, runs: self.runs, stopped: false })
    }

    /// What comes of the case, if it fails.
    fn run(&mut self, place: &KnobPlace, what: &str) -> Result<Option<(Outcome, RunStanding)>, ShrinkError> {
        // The first run is made whatever is wished: without it there is nothing to say.
        let never = Stop::default();
        let stop = if self.runs == 0 { &never } else { self.stop };
        let batch = RunBatch { executor: self.executor, measured: &self.measured, stop };
        let outcome = match batch.one(&place.case()?, Wanted::Outcome) {
            Ok(ran) => ran.outcome,
            Err(BatchError::Run { error, .. }) => return Err((*error).into()),
            Err(BatchError::Stopped) => return Err(ShrinkError::Stopped),
        };
        self.runs += 1;
        (self.progress)(self.runs, what);
        let standing = self.criterion.standing(&outcome, &self.measured.requests);
        Ok((!standing.holds).then_some((outcome, standing)))
    }

    /// Takes the place if the case there still fails. One that cannot be run does not.
    fn take(&mut self, place: &KnobPlace, what: &str, shrunk: &mut Shrunk) -> bool {
        if self.stop.is_requested() {
            return false;
        }
        let Ok(Some((outcome, standing))) = self.run(place, what) else { return false };
        (shrunk.place, shrunk.outcome, shrunk.standing) = (place.clone(), outcome, standing);
        true
    }
}

/// Leaves out one road user after the other that the failure does not need.
fn leave_out(shrunk: &mut Shrunk, trials: &mut Trials) {
    let criterion = trials.criterion;
    let metric = criterion.criterion.claim.metric();
    let named = |name: &str| {
        let pair = metric.pair.as_ref();
        pair.is_some_and(|(car, other)| car == name || other == name)
            || (pair.is_some() && metric.is_of_vehicle(name))
            || metric.several.iter().any(|one| one == name)
    };
    let cars = shrunk.place.scenario.vehicles.iter().map(|car| car.name.clone());
    let people = shrunk.place.scenario.pedestrians.iter().map(|one| one.name.clone());
    let everybody: Vec<String> = people.chain(cars).filter(|name| !named(name)).collect();
    for name in everybody {
        let mut place = shrunk.place.clone();
        let scenario = &mut place.scenario;
        let awaited = scenario.pedestrians.iter().any(|one| one.awaits().any(|awaited| awaited == name));
        scenario.pedestrians.retain(|one| one.name != name);
        scenario.vehicles.retain(|car| car.name != name);
        place.individuals.retain(|one| one.pedestrian != name);
        let is_encounter = !place.scenario.pedestrians.is_empty() && !place.scenario.vehicles.is_empty();
        if is_encounter && !awaited && trials.take(&place, &name, shrunk) {
            shrunk.left_out.push(name);
        }
    }
}

/// Moves one value as near to its nominal one as the case still fails. Says whether it moved.
fn turn(knob: &Knob, shrunk: &mut Shrunk, trials: &mut Trials) -> bool {
    let from = knob.value(&shrunk.place);
    let way = knob.nominal - from;
    if way == 0.0 || trials.stop.is_requested() {
        return false;
    }
    let mut fails_at = |value: f64, shrunk: &mut Shrunk| {
        let mut place = shrunk.place.clone();
        knob.set(&mut place, value);
        trials.take(&place, &knob.name, shrunk)
    };
    if fails_at(knob.nominal, shrunk) {
        return true;
    }
    let before = shrunk.clone();
    let (mut fails, mut holds) = (0.0, 1.0);
    while holds - fails > RESOLUTION {
        let middle = (fails + holds) / 2.0;
        if fails_at(from + middle * way, shrunk) { fails = middle } else { holds = middle }
    }
    if fails < LEAST_MOVE {
        *shrunk = before;
        return false;
    }
    // A round number nearly as near reads better.
    let least = fails * (1.0 - GIVEN_FOR_ROUNDNESS);
    let round = (1..=MOST_DIGITS).filter_map(|digits| round_towards(from + fails * way, from, digits));
    let near = round.filter(|value| (least..=fails).contains(&((value - from) / way)));
    for value in near.collect::<Vec<_>>() {
        if value != from && fails_at(value, shrunk) {
            return true;
        }
    }
    true
}

/// The number of so many significant digits next to `value` on the side of `from`.
fn round_towards(value: f64, from: f64, digits: i32) -> Option<f64> {
    let near: f64 = significant(value, digits).parse().ok()?;
    let inside = |number: &f64| (from..=value).contains(number) || (value..=from).contains(number);
    let step = libm::pow(10.0, libm::floor(libm::log10(value.abs())) + 1.0 - f64::from(digits));
    let beyond = format!("{:.12}", near + if from < value { -step } else { step });
    [Some(near), beyond.parse().ok()].into_iter().flatten().find(inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers_lie_on_the_side_that_fails() {
        assert_eq!(round_towards(9.237, 6.0, 1), Some(9.0));
        assert_eq!(round_towards(9.237, 6.0, 2), Some(9.2));
        assert_eq!(round_towards(9.237, 14.0, 2), Some(9.3));
        assert_eq!(round_towards(9.97, 14.0, 1), Some(10.0));
        assert_eq!(round_towards(0.0437, 0.01, 2), Some(0.043));
        assert_eq!(round_towards(-1.26, -2.0, 2), Some(-1.3));
        // None of so few digits lies between.
        assert_eq!(round_towards(6.4, 6.3, 1), None);
    }
}
