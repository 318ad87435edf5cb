//! What is drawn of a run besides where everybody is: times to collision, who was in a shared area when, and what pedestrians' models make of it.
//! It is worked out as metrics are, by an [`Encounters`] of its own, so that runs that are not drawn pay nothing for it.

use serde::{Deserialize, Serialize};

use super::InStep;
use super::encounter::Encounters;
use super::followed::Followed;
use super::measurement::Measurement;
use super::passage::Reached;
use crate::geometry::first_contact;
use crate::{Ending, ModelState, Observer, Snapshot, StateQuantity, Step};
use scenario::{MetricReference, World, Worst};

/// What is drawn of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RunDetails {
    /// The ends of its steps, s.
    pub times: Vec<f64>,
    /// Every vehicle with every pedestrian, vehicle by vehicle.
    pub pairs: Vec<PairDetails>,
    /// In the order of the world.
    pub people: Vec<PersonDetails>,
    /// Those of what is measured that have a value during the run, and existed at some time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<StepReadings>,
}

/// What a metric is the worst of, over time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StepReadings {
    /// Its place among what is measured.
    pub metric: usize,
    /// Whether the smallest is the worst; else the largest is.
    pub is_smallest: bool,
    /// For each time the worst since the one before, over everybody that it is measured for; `None` where there is none.
    pub worst: Vec<Option<f64>>,
}

impl StepReadings {
    /// The worse of two of its values.
    pub fn worse(&self, one: f64, other: f64) -> f64 {
        if self.is_smallest { one.min(other) } else { one.max(other) }
    }

    /// For each time the worst until then.
    pub fn worst_so_far(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        self.worst.iter().scan(None, |known: &mut Option<f64>, now| {
            *known = known.zip(*now).map(|(known, now)| self.worse(known, now)).or(*known).or(*now);
            Some(*known)
        })
    }
}

/// A vehicle and a pedestrian in a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PairDetails {
    /// The vehicle's place in the world.
    pub vehicle: usize,
    /// The pedestrian's.
    pub pedestrian: usize,
    /// As the metric `min_ttc` takes it, s; one for each time, `None` where they are on no collision course.
    pub time_to_collision: Vec<Option<f64>>,
    /// The same if the vehicle went straight on from where it is; empty where it did.
    pub straight_on: Vec<Option<f64>>,
    /// When they first touched, s.
    pub contact: Option<f64>,
    /// Every time that the pedestrian's centre passed the centre line of the vehicle's lane.
    pub passings: Vec<PassingTimes>,
    /// Every stay of the pedestrian's footprint in what the vehicle's footprint sweeps.
    pub visits: Vec<VisitTimes>,
}

/// When two centres passed a conflict point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PassingTimes {
    /// s
    pub pedestrian: f64,
    /// When the vehicle's did.
    pub vehicle: Reached,
}

/// When two were in the area that they share.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct VisitTimes {
    /// When the pedestrian came, s.
    pub from: f64,
    /// When they left, s; `None` if they were there to the end of the run.
    pub to: Option<f64>,
    /// When the vehicle's front came.
    pub enters: Reached,
    /// When its rear left.
    pub leaves: Reached,
}

/// What a pedestrian's model made of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PersonDetails {
    /// Empty of models that do not say.
    pub quantities: Vec<StateQuantity>,
    /// One for each time, or none at all; `None` where nothing is weighed.
    pub states: Vec<Option<ModelState>>,
}

/// Follows a run and records its details.
pub struct RecordedDetails {
    encounters: Encounters,
    half_lengths: Vec<f64>,
    /// Whether the vehicle of each pair did not keep straight at some time.
    bends: Vec<bool>,
    measurement: Measurement,
    details: RunDetails,
}

impl RecordedDetails {
    /// Of a run of this world that has not begun; `requests` are what is measured in it.
    pub fn new(world: &World, requests: &[MetricReference]) -> Self {
        let reading = |(metric, reference): (usize, &MetricReference)| StepReadings {
            metric,
            is_smallest: reference.known().is_some_and(|metric| metric.worst == Worst::Smallest),
            worst: Vec::new(),
        };
        let readings = requests.iter().enumerate().map(reading).collect();
        let people = world.pedestrians.len();
        let pair = |(vehicle, pedestrian)| PairDetails { vehicle, pedestrian, ..PairDetails::default() };
        let pairs = (0..world.vehicles.len()).flat_map(|car| (0..people).map(move |person| (car, person)));
        let pairs: Vec<PairDetails> = pairs.map(pair).collect();
        let mut followed = Followed::default();
        followed.look_ahead();
        Self {
            encounters: Encounters::new(world, followed),
            half_lengths: world.vehicles.iter().map(|car| car.length / 2.0).collect(),
            bends: vec![false; pairs.len()],
            measurement: Measurement::new(world, requests, &[], &[]),
            details: RunDetails {
                times: Vec::new(),
                pairs,
                people: vec![PersonDetails::default(); people],
                readings,
            },
        }
    }

    /// What was recorded.
    pub fn into_details(self) -> RunDetails {
        self.details
    }
}

impl Observer for RecordedDetails {
    fn begin(&mut self, start: &Snapshot) {
        self.measurement.begin(start);
    }

    fn observe(&mut self, step: &Step) {
        self.encounters.observe(step);
        self.measurement.observe(step);
        let RunDetails { times, pairs, people, readings } = &mut self.details;
        for (reading, now) in readings.iter_mut().zip(self.measurement.in_step()) {
            match now {
                InStep::AtTheEnd => {}
                InStep::Nothing => reading.worst.push(None),
                InStep::Worst(worst) => reading.worst.push(Some(worst)),
            }
        }
        for (index, person) in people.iter_mut().enumerate() {
            if times.is_empty() {
                person.quantities = step.minds.quantities(index);
            }
            if !person.quantities.is_empty() {
                let is_there = step.before.pedestrians[index].present;
                person.states.push(step.minds.state(index).filter(|_| is_there));
            }
        }
        times.push(step.time + step.duration);
        for (pair, bends) in pairs.iter_mut().zip(&mut self.bends) {
            let (car, person) =
                (&step.after.vehicles[pair.vehicle], &step.after.pedestrians[pair.pedestrian]);
            // Who is not there yet is on no course.
            let is_there = step.before.pedestrians[pair.pedestrian].present;
            let known = self.encounters.pair(pair.vehicle, pair.pedestrian).time_to_collision();
            let along = known.filter(|_| is_there);
            *bends |= !car.keeps_straight();
            let straight = match is_there && !car.keeps_straight() {
                true => first_contact(car, person, person.velocity - car.velocity()),
                false => along,
            };
            pair.time_to_collision.push(along);
            pair.straight_on.push(straight);
        }
    }

    fn end(&mut self, _ending: &Ending, _last: &Snapshot) {
        self.encounters.end();
        self.details.readings.retain(|reading| reading.worst.iter().any(Option::is_some));
        for (pair, bends) in self.details.pairs.iter_mut().zip(&self.bends) {
            let encounter = self.encounters.pair(pair.vehicle, pair.pedestrian);
            let (passage, half) = (self.encounters.passage(pair.vehicle), self.half_lengths[pair.vehicle]);
            pair.contact = encounter.contact.map(|contact| contact.time);
            let passings = encounter.passings.iter().map(|passing| PassingTimes {
                pedestrian: passing.time,
                vehicle: passage.reached(passing.place),
            });
            pair.passings = passings.collect();
            let visits = encounter.visits.iter().map(|visit| VisitTimes {
                from: visit.from,
                to: Some(visit.to).filter(|to| to.is_finite()),
                enters: passage.reached(visit.low - half),
                leaves: passage.reached(visit.high + half),
            });
            pair.visits = visits.collect();
            if !bends {
                pair.straight_on = Vec::new();
            }
        }
    }
}
