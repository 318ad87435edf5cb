//! A case under way: its road users, whatever is read off, and the free flow that it is measured against.

use std::sync::Arc;
use std::time::Instant;

use super::build::{RunError, road_users};
use super::cut_off::cut_off;
use super::name::shared;
use results::{ByMetric, Critical, CutOff, Outcome, Outlasted, PairPresence, Requests, WaitingStep};
use scenario::{Case, World};
use sim::measure::{FreeFlow, Measurement, Presence, Reading};
use sim::{
    Course, Ending, Fault, GivenCommand, Observer, Progress, RunChange, RunFingerprint, Snapshot, Solid,
    Step, StopReason,
};

/// A case under way, which waits wherever somebody outside decides.
pub struct RunningCase {
    course: Course,
    seen: Seen,
    begun: Instant,
    ended: Option<Ending>,
}

/// What is read off a run.
struct Seen {
    measurement: Measurement,
    fingerprint: RunFingerprint,
    last: Option<Snapshot>,
}

impl RunningCase {
    /// The run of a case before its first decision, measured against these free flows.
    pub fn start(case: &Case, requests: &Requests, flows: &[FreeFlow]) -> Result<Self, RunError> {
        let begun = Instant::now();
        if let Some(why) = &case.impossible {
            return Err(RunError::Impossible(why.clone()));
        }
        let users = road_users(&case.world, case.seed)?;
        let free_speeds: Vec<f64> =
            users.pedestrians.iter().map(|pedestrian| pedestrian.free_speed()).collect();
        let seen = Seen {
            measurement: Measurement::new(&case.world, requests.as_slice(), flows, &free_speeds),
            fingerprint: RunFingerprint::new(&case.world),
            last: None,
        };
        Ok(Self { course: Course::start(case.world.clone(), users), seen, begun, ended: None })
    }

    /// The same, in which something goes otherwise, if anything does, and of which commands are noted if they are wanted.
    pub fn otherwise(mut self, change: Option<&RunChange>, notes_commands: bool) -> Self {
        if let Some(change) = change {
            self.course = self.course.changed(change.clone());
        }
        if notes_commands {
            self.course = self.course.noting_commands();
        }
        self
    }

    /// Goes on until somebody outside has to decide, or to the end; `watcher` sees every step and changes nothing.
    pub fn go_on(&mut self, watcher: &mut dyn Observer) -> Result<Progress, Fault> {
        let progress = self.course.next(&mut Both { seen: &mut self.seen, watcher })?;
        if let Progress::Ended(ending) = progress {
            self.ended = Some(ending);
        }
        Ok(progress)
    }

    pub fn seen_course(&self) -> &Course {
        &self.course
    }

    /// Where somebody outside decides.
    pub fn course(&mut self) -> &mut Course {
        &mut self.course
    }

    /// What came of it, and what each vehicle was told if that was noted.
    ///
    /// # Panics
    /// If it has not come to its end.
    pub fn outcome(self, case: &Case) -> (Outcome, Vec<Vec<GivenCommand>>) {
        let Self { course, seen, begun, ended } = self;
        let waiting = course.waiting_steps().into_iter();
        let waiting_steps =
            waiting.map(|(of, step)| WaitingStep { of: shared(of.name(&case.world)), step }).collect();
        let commands = course.into_commands();
        let ending = ended.expect("it has come to its end");
        let readings = seen.measurement.readings();
        let too_early = seen.last.as_ref().filter(|_| ending.reason != StopReason::Completed);
        let cut_off = too_early.map(|last| cut_off(&case.world, last, &seen.measurement, &readings));
        let pedestrians = names(case.world.pedestrians.iter().map(|one| &one.name));
        let vehicles = names(case.world.vehicles.iter().map(|car| &car.name));
        let outcome = Outcome {
            key: case.key.clone(),
            seed: case.seed,
            individuals: case.individuals.clone(),
            drawn: case.drawn.clone(),
            ending,
            metrics: readings.iter().map(|reading| reading.worst?.value).collect(),
            critical: critical(&case.world, &vehicles, &pedestrians, &readings),
            presences: presences(&case.world, &vehicles, &seen.measurement),
            waiting_steps,
            left_road: names_of(&vehicles, seen.measurement.left_road()),
            outlasted: outlasted(&case.world, &pedestrians, &seen.measurement),
            cut_off: cut_off.filter(|cut_off| *cut_off != CutOff::default()).map(Box::new),
            fingerprint: seen.fingerprint.value(),
            wall_time: begun.elapsed(),
        };
        (outcome, commands)
    }
}

/// The vehicles of these indices.
fn names_of(vehicles: &[Arc<str>], which: impl Iterator<Item = usize>) -> Vec<Arc<str>> {
    which.map(|index| vehicles[index].clone()).collect()
}

fn names<'a>(names: impl Iterator<Item = &'a String>) -> Vec<Arc<str>> {
    names.map(|name| shared(name)).collect()
}

/// What road users had to do with each other, by their names.
fn presences(world: &World, vehicles: &[Arc<str>], measurement: &Measurement) -> Vec<PairPresence> {
    let named = |(vehicle, other, presence): (usize, Solid, Presence)| PairPresence {
        vehicle: vehicles[vehicle].clone(),
        other: shared(other.name(world)),
        of_vehicles: matches!(other, Solid::Vehicle(_)),
        presence,
    };
    measurement.presences().into_iter().map(named).collect()
}

/// Streams that were over before somebody went across.
fn outlasted(world: &World, pedestrians: &[Arc<str>], measurement: &Measurement) -> Vec<Outlasted> {
    let named = |(stream, pedestrian): (usize, usize)| Outlasted {
        stream: shared(&world.streams[stream].name),
        pedestrian: pedestrians[pedestrian].clone(),
    };
    measurement.outlasted().map(named).collect()
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
        let stream = || worst.stream.map(|index| shared(&world.streams[index].name));
        Some(Critical {
            time: worst.instant,
            vehicle: worst.vehicle.map(|index| vehicles[index].clone()).or_else(stream),
            pedestrian: worst.pedestrian.map(|index| pedestrians[index].clone()),
            other: worst.other.map(|other| shared(other.name(world))),
        })
        .filter(|critical| *critical != Critical::default())
    };
    readings.iter().map(of).collect()
}

struct Both<'a> {
    seen: &'a mut Seen,
    watcher: &'a mut dyn Observer,
}

impl Observer for Both<'_> {
    fn begin(&mut self, start: &Snapshot) {
        self.seen.measurement.begin(start);
        self.seen.fingerprint.begin(start);
        self.watcher.begin(start);
    }

    fn observe(&mut self, step: &Step) {
        self.seen.measurement.observe(step);
        self.seen.fingerprint.observe(step);
        self.watcher.observe(step);
    }

    fn end(&mut self, ending: &Ending, last: &Snapshot) {
        self.seen.measurement.end(ending, last);
        self.seen.fingerprint.end(ending, last);
        self.watcher.end(ending, last);
        self.seen.last = Some(last.clone());
    }
}
