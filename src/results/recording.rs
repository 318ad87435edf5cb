//! The course of one run in few numbers, for drawing: where everybody is ten times a second.

use serde::{Deserialize, Serialize};

use super::places::{self, Place};
use super::requests::Requests;
use super::written_details;
use nalgebra::Vector2;
use scenario::{Case, Criterion, PedestrianSetup, Shape};
use sim::measure::{PairDetails, PersonDetails, RunDetails, StepReadings};
use sim::{ModelState, PerceivedView, TimelineEvent, Trace};

/// A run as it is drawn. Metrics are never computed from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// The run.
    pub case: Case,
    /// What happened in it, in the order of time.
    pub events: Vec<TimelineEvent>,
    /// s; steps of about 0.1 s and the very end.
    #[serde(with = "places::times")]
    pub times: Vec<f64>,
    /// Per road user, vehicles first, one per time; `None` before it appears.
    #[serde(with = "places")]
    pub users: Vec<Vec<Option<Place>>>,
    /// Every vehicle with every pedestrian, vehicle by vehicle, one value per time where there is one for each; none where they were not
    /// recorded.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "written_details::pairs")]
    pub meetings: Vec<PairDetails>,
    /// What each pedestrian's model made of it, one per time; none where it was not recorded.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "written_details::people")]
    pub states: Vec<PersonDetails>,
    /// Of metrics that are the worst of something over time: the worst since the time before; of those that criteria are about.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "written_details::readings")]
    pub readings: Vec<StepReadings>,
    /// What controllers were told of others and was not so, in the order of time: of each vehicle what it was told last at each time. One without
    /// anybody says that all is so from then on.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "written_details::perceived")]
    pub perceived: Vec<PerceivedView>,
}

/// One pedestrian and one vehicle in the distance-distance plane.
#[derive(Debug, Clone, PartialEq)]
pub struct PairCourse {
    /// The vehicle's name.
    pub vehicle: String,
    /// The pedestrian's name.
    pub pedestrian: String,
    /// `(vehicle, pedestrian)` in m along each one's way, negative before the conflict point.
    pub points: Vec<(f64, f64)>,
}

/// Between two places, s.
const INTERVAL: f64 = 0.1;
/// Values of states are kept to one over this.
const STATE_DIGITS: f64 = 1e4;
/// Below this a heading is that of before, m/s.
const STANDING: f64 = 0.01;
/// Moments that are nearer than this are the same, s.
const SAME_TIME: f64 = 1e-9;

impl Recording {
    /// Thins out `trace`, which must be that of `case`.
    pub fn new(case: &Case, trace: &Trace, events: Vec<TimelineEvent>) -> Self {
        let cars = case.world.vehicles.len();
        let mut headings: Vec<f64> = (0..cars).map(|_| 0.0).collect();
        headings.extend(case.world.pedestrians.iter().map(initial_heading));
        let mut recording = Self {
            case: case.clone(),
            events,
            times: Vec::new(),
            users: vec![Vec::new(); headings.len()],
            meetings: Vec::new(),
            states: Vec::new(),
            readings: Vec::new(),
            perceived: Vec::new(),
        };
        let end = trace.samples.last().map_or(0.0, |sample| sample.time);
        let mut due = 0.0;
        for moment in trace.samples.chunk_by(|left, right| left.time == right.time) {
            let time = moment[0].time;
            let wanted = time >= due - 1e-9 || time == end;
            let mut places = vec![None; headings.len()];
            for sample in moment {
                let speed = sample.velocity.norm();
                if sample.who < cars {
                    headings[sample.who] = libm::atan2(sample.heading.y, sample.heading.x);
                } else if speed > STANDING {
                    headings[sample.who] = libm::atan2(sample.velocity.y, sample.velocity.x);
                }
                places[sample.who] = Some(Place {
                    x: sample.position.x,
                    y: sample.position.y,
                    speed,
                    heading: headings[sample.who],
                });
            }
            if wanted {
                due = time + INTERVAL;
                recording.times.push(time);
                for (user, place) in recording.users.iter_mut().zip(places) {
                    user.push(place);
                }
            }
        }
        recording.perceived = told_last(&trace.perceived, &recording.times);
        recording
    }

    /// The same with what else is drawn of the run, thinned out likewise. What is known at the ends of steps alone is, at a time within a
    /// step, that of the end of the one before.
    #[must_use]
    pub fn with(mut self, details: Option<&RunDetails>) -> Self {
        let Some(details) = details else { return self };
        let steps: Vec<Option<usize>> = self
            .times
            .iter()
            .map(|time| details.times.partition_point(|end| end <= time).checked_sub(1))
            .collect();
        let values = |all: &[Option<f64>]| -> Vec<Option<f64>> {
            if all.is_empty() { Vec::new() } else { steps.iter().map(|step| all[(*step)?]).collect() }
        };
        let pair = |pair: &PairDetails| PairDetails {
            time_to_collision: values(&pair.time_to_collision),
            straight_on: values(&pair.straight_on),
            ..pair.clone()
        };
        self.meetings = details.pairs.iter().map(pair).collect();
        let reading =
            |reading: &StepReadings| StepReadings { worst: worst_between(reading, &steps), ..*reading };
        self.readings = details.readings.iter().map(reading).collect();
        let state = |state: &ModelState| ModelState {
            values: state.values.iter().map(|value| (value * STATE_DIGITS).round() / STATE_DIGITS).collect(),
            ..state.clone()
        };
        let person = |person: &PersonDetails| PersonDetails {
            states: match person.states.is_empty() {
                true => Vec::new(),
                false => steps.iter().map(|step| person.states[(*step)?].as_ref().map(state)).collect(),
            },
            ..person.clone()
        };
        if details.people.iter().any(|person| !person.quantities.is_empty()) {
            self.states = details.people.iter().map(person).collect();
        }
        self
    }

    /// The same without what was measured over time that no criterion is about.
    #[must_use]
    pub fn about(mut self, criteria: &[Criterion], requests: &Requests) -> Self {
        let about: Vec<usize> =
            criteria.iter().filter_map(|criterion| requests.index(criterion.claim.metric())).collect();
        self.readings.retain(|readings| about.contains(&readings.metric));
        self
    }

    /// What the controller of a vehicle was told of others at its last decision until `time` (s) and was not so, if there is any.
    pub fn perceived(&self, vehicle: usize, time: f64) -> Option<&PerceivedView> {
        PerceivedView::last(&self.perceived, vehicle, time)
    }

    /// The name of a road user by its index.
    pub fn name(&self, who: usize) -> &str {
        let world = &self.case.world;
        match world.vehicles.get(who) {
            Some(vehicle) => &vehicle.name,
            None => &world.pedestrians[who - world.vehicles.len()].name,
        }
    }

    /// Length and width of a road user's footprint in m; a disc has neither corner nor difference.
    pub fn footprint(&self, who: usize) -> (f64, f64, bool) {
        let world = &self.case.world;
        match world.vehicles.get(who) {
            Some(vehicle) => (vehicle.length, vehicle.width, false),
            None => {
                let shape = world.pedestrians[who - world.vehicles.len()].shape;
                let (length, width) = shape.extents();
                (length, width, matches!(shape, Shape::Disc { .. }))
            }
        }
    }

    /// Every pedestrian with every vehicle whose lane lies on its way.
    pub fn pairs(&self) -> Vec<PairCourse> {
        let world = &self.case.world;
        let cars = world.vehicles.len();
        let mut pairs = Vec::new();
        for (vehicle, car) in world.vehicles.iter().enumerate() {
            let path = world.path_of(car);
            for (pedestrian, person) in world.pedestrians.iter().enumerate() {
                if person.follows.is_some() {
                    continue;
                }
                let Some(conflict) = path.met_between(person.start.into(), person.goal.into()) else {
                    continue;
                };
                let across = (person.goal.y - person.start.y).signum();
                let places = self.users[vehicle].iter().zip(&self.users[cars + pedestrian]);
                let way = Vector2::from(person.goal) - Vector2::from(person.start);
                let way = way.try_normalize(0.0).unwrap_or_else(Vector2::y);
                let met = path.course().map(|_| path.along(conflict));
                let point = |(car, person): (&Option<Place>, &Option<Place>)| {
                    let (place, person) = (car.as_ref()?.at(), person.as_ref()?.at() - conflict);
                    Some(match met {
                        None => (path.along(place - conflict), across * person.y),
                        // Along the bend, and along the way that is walked.
                        Some(met) => (path.along(place) - met, person.dot(&way)),
                    })
                };
                pairs.push(PairCourse {
                    vehicle: car.name.clone(),
                    pedestrian: person.name.clone(),
                    points: places.filter_map(point).collect(),
                });
            }
        }
        pairs
    }
}

/// The worst of every step since the time before, `steps` being the last one until each time; no step is left out.
fn worst_between(reading: &StepReadings, steps: &[Option<usize>]) -> Vec<Option<f64>> {
    let mut next = 0;
    let mut worst = |until: usize| {
        let since = &reading.worst[next.min(until)..until];
        next = until;
        since.iter().flatten().copied().reduce(|one, other| reading.worse(one, other))
    };
    let last = steps.len().saturating_sub(1);
    let ends = steps.iter().map(|step| step.map_or(0, |step| step + 1)).enumerate();
    ends.map(|(index, end)| worst(if index == last { reading.worst.len() } else { end })).collect()
}

/// Of each vehicle what it was told last at any of the `times` (s).
fn told_last(perceived: &[PerceivedView], times: &[f64]) -> Vec<PerceivedView> {
    let is_last = |(index, view): &(usize, &PerceivedView)| {
        let next = perceived[index + 1..].iter().find(|next| next.vehicle == view.vehicle);
        let first = times.partition_point(|time| *time < view.time - SAME_TIME);
        let until = next.map_or(f64::INFINITY, |next| next.time - SAME_TIME);
        times.get(first).is_some_and(|time| *time < until)
    };
    perceived.iter().enumerate().filter(is_last).map(|(_, view)| view.clone()).collect()
}

fn initial_heading(person: &PedestrianSetup) -> f64 {
    if let Some(path) = &person.follows {
        let ahead = path.heading(path.along(person.start.into()));
        return libm::atan2(ahead.y, ahead.x);
    }
    libm::atan2(person.goal.y - person.start.y, person.goal.x - person.start.x)
}
