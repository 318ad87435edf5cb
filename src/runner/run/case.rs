//! One case from start to outcome.

use std::sync::Arc;
use std::time::Instant;

use super::build::{RunError, road_users};
use super::cut_off::cut_off;
use super::free_flow::FreeFlows;
use super::name::shared;
use super::panic::in_case;
use results::{ByMetric, Critical, CutOff, Outcome, Requests};
use scenario::{Case, World};
use sim::measure::{Measurement, Reading};
use sim::{Ending, Fingerprint, Observer, Snapshot, Step, StopReason, simulate};

/// Runs one case and reads the requested metrics off it. `watcher` sees every step and changes nothing.
///
/// A pure function of the case, but for the wall time it notes.
///
/// # Panics
/// With a [`Panicked`](super::Panicked) that names the case, if a model does.
pub fn run_case(
    case: &Case,
    requests: &Requests,
    free_flows: &FreeFlows,
    watcher: &mut dyn Observer,
) -> Result<Outcome, RunError> {
    in_case(&case.key, || run(case, requests, free_flows, watcher))
}

fn run(
    case: &Case,
    requests: &Requests,
    free_flows: &FreeFlows,
    watcher: &mut dyn Observer,
) -> Result<Outcome, RunError> {
    let begun = Instant::now();
    let users = road_users(&case.world, case.seed)?;
    let free_speeds: Vec<f64> = users.pedestrians.iter().map(|pedestrian| pedestrian.free_speed()).collect();
    let flows = free_flows.of(&case.world)?;
    let mut observers = Observers {
        measurement: Measurement::new(&case.world, requests.as_slice(), &flows, &free_speeds),
        fingerprint: Fingerprint::default(),
        last: None,
        watcher,
    };
    let ending = simulate(&case.world, users, &mut observers)
        .map_err(|fault| RunError::of_fault(&case.world, fault, false))?;
    let readings = observers.measurement.readings();
    let too_early = observers.last.as_ref().filter(|_| ending.reason != StopReason::Completed);
    let cut_off = too_early.map(|last| cut_off(&case.world, last, &observers.measurement, &readings));
    let pedestrians = names(case.world.pedestrians.iter().map(|one| &one.name));
    let vehicles = names(case.world.vehicles.iter().map(|car| &car.name));
    Ok(Outcome {
        key: case.key.clone(),
        seed: case.seed,
        individuals: case.individuals.clone(),
        ending,
        metrics: readings.iter().map(|reading| reading.worst?.value).collect(),
        critical: critical(&case.world, &vehicles, &pedestrians, &readings),
        presences: pedestrians.into_iter().zip(observers.measurement.presences()).collect(),
        cut_off: cut_off.filter(|cut_off| *cut_off != CutOff::default()).map(Box::new),
        fingerprint: observers.fingerprint.value(),
        wall_time: begun.elapsed(),
    })
}

fn names<'a>(names: impl Iterator<Item = &'a String>) -> Vec<Arc<str>> {
    names.map(|name| shared(name)).collect()
}

/// When and for whom the readings are what they are.
fn critical(
    world: &World,
    vehicles: &[Arc<str>],
    pedestrians: &[Arc<str>],
    readings: &[Reading],
) -> ByMetric<Critical> {
    let of = |reading: &Reading| {
        let worst = reading.worst?;
        Some(Critical {
            time: worst.instant,
            vehicle: worst.vehicle.map(|index| vehicles[index].clone()),
            pedestrian: worst.pedestrian.map(|index| pedestrians[index].clone()),
            other: worst.other.map(|other| shared(other.name(world))),
        })
        .filter(|critical| *critical != Critical::default())
    };
    readings.iter().map(of).collect()
}

/// Sees nothing: for runs of which only the outcome matters.
pub struct Unwatched;

impl Observer for Unwatched {
    fn observe(&mut self, _step: &Step) {}
}

struct Observers<'a> {
    measurement: Measurement,
    fingerprint: Fingerprint,
    last: Option<Snapshot>,
    watcher: &'a mut dyn Observer,
}

impl Observer for Observers<'_> {
    fn begin(&mut self, start: &Snapshot) {
        self.measurement.begin(start);
        self.fingerprint.begin(start);
        self.watcher.begin(start);
    }

    fn observe(&mut self, step: &Step) {
        self.measurement.observe(step);
        self.fingerprint.observe(step);
        self.watcher.observe(step);
    }

    fn end(&mut self, ending: &Ending, last: &Snapshot) {
        self.measurement.end(ending, last);
        self.fingerprint.end(ending, last);
        self.watcher.end(ending, last);
        self.last = Some(last.clone());
    }
}
