//! The course of one run in few numbers, for drawing: where everybody is ten times a second.

use serde::{Deserialize, Serialize};

use super::places::{self, Place};
use super::written_details;
use nalgebra::Vector2;
use scenario::{Case, PedestrianSetup, Shape};
use sim::measure::{PairDetails, PersonDetails, RunDetails};
use sim::{ModelState, TimelineEvent, Trace};

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

fn initial_heading(person: &PedestrianSetup) -> f64 {
    if let Some(path) = &person.follows {
        let ahead = path.heading(path.along(person.start.into()));
        return libm::atan2(ahead.y, ahead.x);
    }
    libm::atan2(person.goal.y - person.start.y, person.goal.x - person.start.x)
}
