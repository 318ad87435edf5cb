//! The course of one run in few numbers, for drawing: where everybody is ten times a second.

use serde::{Deserialize, Serialize};

use super::places::{self, Place};
use nalgebra::Vector2;
use scenario::{Case, PedestrianSetup, Shape};
use sim::{TimelineEvent, Trace};

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
/// Below this a heading is that of before, m/s.
const STANDING: f64 = 0.01;

impl Recording {
    /// Thins out `trace`, which must be that of `case`.
    pub fn new(case: &Case, trace: &Trace, events: Vec<TimelineEvent>) -> Self {
        let cars = case.world.vehicles.len();
        let mut headings: Vec<f64> = (0..cars).map(|_| 0.0).collect();
        headings.extend(case.world.pedestrians.iter().map(initial_heading));
        let mut recording =
            Self { case: case.clone(), events, times: Vec::new(), users: vec![Vec::new(); headings.len()] };
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
