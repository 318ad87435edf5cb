//! All requested metrics of one run at once: the worst over pairs, with whose it was.

use nalgebra::Vector2;

use super::encounter::{Encounters, Presence, lerp, velocity_inside};
use super::{FreeFlow, Meter, MetricContext, Scope, Worst, metric};
use crate::scenario::{MetricReference, World};
use crate::sim::{Observer, Snapshot, Step};

/// Meters for every request and every pair of road users that it concerns.
pub struct Measurement {
    encounters: Encounters,
    requests: Vec<Request>,
    end_on_collision: bool,
}

/// What one request came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The value that counts for the run and whose it is; `None` if it exists for nobody.
    pub worst: Option<SubjectValue>,
    /// Everybody that the metric was measured for.
    pub subjects: Vec<SubjectValue>,
}

/// A metric of one pair, vehicle or pedestrian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubjectValue {
    pub vehicle: Option<usize>,
    pub pedestrian: Option<usize>,
    /// `None` when it does not exist in this run.
    pub value: Option<f64>,
    /// When it took that value, s.
    pub instant: Option<f64>,
}

/// Indices of the vehicle and the pedestrian that a metric is measured for.
type Subject = (Option<usize>, Option<usize>);

struct Request {
    worst: Worst,
    meters: Vec<(Subject, Box<dyn Meter>)>,
}

impl Measurement {
    /// `requests` must have been checked against the registry. `free_flows` has one entry per vehicle, `free_speeds`
    /// (m/s) one per pedestrian; without them the metrics that compare to them do not exist.
    pub fn new(
        world: &World,
        requests: &[MetricReference],
        free_flows: &[FreeFlow],
        free_speeds: &[f64],
    ) -> Self {
        let meters = |reference: &MetricReference| {
            let metric = metric(&reference.name).expect("requests were checked against the registry");
            let settings = metric.declaration.resolve(&reference.settings).expect("settings were checked");
            let subjects = subjects(metric.scope, world)
                .filter(|subject| concerns(reference, world, *subject))
                .map(|(vehicle, pedestrian)| {
                    let context = MetricContext {
                        settings: &settings,
                        world,
                        vehicle: vehicle.unwrap_or(0),
                        pedestrian: pedestrian.unwrap_or(0),
                        free_flow: vehicle.and_then(|index| free_flows.get(index).copied()),
                        free_speed: pedestrian.and_then(|index| free_speeds.get(index).copied()),
                    };
                    ((vehicle, pedestrian), (metric.build)(&context))
                });
            Request { worst: metric.worst, meters: subjects.collect() }
        };
        Self {
            encounters: Encounters::new(world),
            requests: requests.iter().map(meters).collect(),
            end_on_collision: world.end_on_collision,
        }
    }

    /// The worst value of every request, in order.
    pub fn values(&self) -> Vec<Option<f64>> {
        self.readings().into_iter().map(|reading| reading.worst.and_then(|worst| worst.value)).collect()
    }

    /// Every request in order, with whose values they are.
    pub fn readings(&self) -> Vec<Reading> {
        self.requests.iter().map(|request| request.reading(&self.encounters)).collect()
    }

    /// Whether each pedestrian appeared, and came into a vehicle's lane.
    pub fn presences(&self) -> Vec<Presence> {
        self.encounters.presences()
    }

    fn take(&mut self, step: &Step) {
        self.encounters.observe(step);
        for (_, meter) in self.requests.iter_mut().flat_map(|request| &mut request.meters) {
            meter.observe(step, &self.encounters);
        }
    }
}

impl Request {
    fn reading(&self, encounters: &Encounters) -> Reading {
        let subjects: Vec<_> = self
            .meters
            .iter()
            .map(|((vehicle, pedestrian), meter)| SubjectValue {
                vehicle: *vehicle,
                pedestrian: *pedestrian,
                value: meter.value(encounters),
                instant: meter.instant(encounters),
            })
            .collect();
        let badness = |subject: &SubjectValue| {
            let value = subject.value?;
            Some(if self.worst == Worst::Smallest { -value } else { value })
        };
        let mut worst: Option<(f64, SubjectValue)> = None;
        for subject in &subjects {
            if let Some(bad) = badness(subject).filter(|bad| worst.is_none_or(|(most, _)| *bad > most)) {
                worst = Some((bad, *subject));
            }
        }
        Reading { worst: worst.map(|(_, subject)| subject), subjects }
    }
}

impl Observer for Measurement {
    fn observe(&mut self, step: &Step) {
        match self.encounters.observe_contacts(step, self.end_on_collision) {
            Some(moment) if self.end_on_collision => {
                // Once in a run, its last step; so it may allocate.
                let after = inside(step, moment);
                self.take(&Step { duration: moment, after: &after, ..*step });
            }
            _ => self.take(step),
        }
    }
}

/// Whom a metric is measured for in a world.
fn subjects(scope: Scope, world: &World) -> impl Iterator<Item = Subject> {
    let indices = |wanted: bool, count: usize| {
        if wanted { (0..count).map(Some).collect() } else { vec![None] }
    };
    let vehicles: Vec<_> = indices(scope != Scope::Pedestrian, world.vehicles.len());
    let pedestrians: Vec<_> = indices(scope != Scope::Vehicle, world.pedestrians.len());
    vehicles
        .into_iter()
        .flat_map(move |vehicle| pedestrians.clone().into_iter().map(move |pedestrian| (vehicle, pedestrian)))
}

fn concerns(reference: &MetricReference, world: &World, (vehicle, pedestrian): Subject) -> bool {
    reference.pair.as_ref().is_none_or(|(car, person)| {
        vehicle.is_none_or(|index| world.vehicles[index].name == *car)
            && pedestrian.is_none_or(|index| world.pedestrians[index].name == *person)
    })
}

/// The state `moment` s after the beginning of a step.
fn inside(step: &Step, moment: f64) -> Snapshot {
    let part = moment / step.duration;
    let mut state = step.after.clone();
    for (car, before) in state.vehicles.iter_mut().zip(&step.before.vehicles) {
        car.motion.travelled = lerp(before.motion.travelled, car.motion.travelled, part);
        car.motion.speed = lerp(before.motion.speed, car.motion.speed, part);
    }
    for (person, before) in state.pedestrians.iter_mut().zip(&step.before.pedestrians) {
        let velocity: Vector2<f64> = velocity_inside(step.duration, before, person, part);
        person.position = before.position.lerp(&person.position, part);
        person.velocity = velocity;
    }
    state
}
