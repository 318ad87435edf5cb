//! The event timeline of one run: what happened, when and to whom.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::observer::{Observer, Step};
use super::solid::Solid;
use scenario::World;
use scenario::agent::Mode;

/// One thing that happened. Times in s, speeds in m/s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimelineEvent {
    /// s
    pub time: f64,
    /// The road user's name.
    pub who: String,
    /// What happened to it.
    pub what: Happening,
}

/// What may happen to a road user.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Happening {
    /// A pedestrian enters the world.
    Appears,
    /// The model's own word for what it is up to.
    Mode(Mode),
    /// A pedestrian who stood, or has just appeared, walks.
    StartsWalking,
    /// A pedestrian's centre passes the kerb that they start behind, in either direction.
    EntersCarriageway,
    /// Its centre passes the centre line of a vehicle's lane.
    PassesConflictPoint,
    /// A pedestrian's centre passes the opposite kerb, in either direction.
    LeavesCarriageway,
    /// Its centre passes the middle of the crossing.
    PassesCrossing {
        /// The vehicle's, m/s.
        speed: f64,
    },
    /// Speed starts to fall by more than 0.5 m/s².
    Brakes {
        /// The vehicle's as it begins, m/s.
        speed: f64,
    },
    /// A vehicle that its controller steers is more than 0.2 m beside the middle of its lane, having been nearer than half of that.
    Swerves {
        /// Whether to its left.
        left: bool,
    },
    /// A part of a vehicle is over the edge of its lane.
    LeavesLane {
        /// Whether over the left edge.
        left: bool,
    },
    /// All of a vehicle that had left its lane is in it.
    ReturnsToLane,
    /// It moved, and stands.
    Stops,
    /// A vehicle that stood drives.
    Resumes,
    /// A vehicle's centre passes the finish line.
    PassesFinishLine {
        /// The vehicle's, m/s.
        speed: f64,
    },
    /// A vehicle and something else, whoever of the two it is about, begin to touch.
    Collides {
        /// What the other is called.
        with: String,
        /// How fast the two move against each other, m/s.
        relative_speed: f64,
    },
    /// A vehicle whose controller does not see everything is shown it.
    ComesIntoSight {
        /// What the vehicle is called.
        of: String,
    },
    /// It is not shown it any more.
    IsLostFromSight {
        /// What the vehicle is called.
        of: String,
    },
    /// A pedestrian begins to touch another, or a box: no collision.
    Touches {
        /// What the other is called.
        with: String,
        /// How fast the two move against each other, m/s.
        relative_speed: f64,
    },
}

/// Records the events of a run.
#[derive(Debug)]
pub struct Timeline {
    world: Arc<World>,
    events: Vec<TimelineEvent>,
    pedestrian_modes: Vec<Mode>,
    vehicle_modes: Vec<Mode>,
    braking: Vec<bool>,
    swerving: Vec<bool>,
    /// Whether a part of a vehicle is over the edge of its lane.
    outside: Vec<bool>,
    walking: Vec<bool>,
    appeared: Vec<bool>,
}

/// Farther beside the middle of its lane than this a steered vehicle swerves, m.
const SWERVES: f64 = 0.2;

/// Below this a road user stands, m/s.
const STANDING: f64 = 0.01;

impl Timeline {
    /// Of a run of this world that has not begun.
    pub fn new(world: &Arc<World>) -> Self {
        let (cars, people) = (world.vehicles.len(), world.pedestrians.len());
        Self {
            world: world.clone(),
            events: Vec::new(),
            pedestrian_modes: vec![Mode::NONE; people],
            vehicle_modes: vec![Mode::NONE; cars],
            braking: vec![false; cars],
            swerving: vec![false; cars],
            outside: vec![false; cars],
            walking: vec![false; people],
            appeared: vec![false; people],
        }
    }

    /// The events in order of time.
    pub fn into_events(mut self) -> Vec<TimelineEvent> {
        self.events.sort_by(|left, right| left.time.total_cmp(&right.time));
        self.events
    }

    fn add(&mut self, time: f64, who: &str, what: Happening) {
        self.events.push(TimelineEvent { time, who: who.to_string(), what });
    }

    fn follow_vehicle(&mut self, step: &Step, index: usize) {
        let world = self.world.clone();
        let name = &world.vehicles[index].name;
        let (before, after) = (&step.before.vehicles[index].motion, &step.after.vehicles[index].motion);
        let mode = &step.vehicle_modes[index];
        if *mode != self.vehicle_modes[index] {
            self.vehicle_modes[index] = mode.clone();
            self.add(step.time, name, Happening::Mode(mode.clone()));
        }
        let end = step.time + step.duration;
        if let Some(part) = passing(before.travelled, after.travelled, 0.0) {
            let speed = before.speed + part * (after.speed - before.speed);
            self.add(step.time + part * step.duration, name, Happening::PassesCrossing { speed });
        }
        if let Some(part) = passing(before.travelled, after.travelled, world.finish) {
            let speed = before.speed + part * (after.speed - before.speed);
            self.add(step.time + part * step.duration, name, Happening::PassesFinishLine { speed });
        }
        let deceleration = (before.speed - after.speed) / step.duration;
        if deceleration > 0.5 && !self.braking[index] {
            self.braking[index] = true;
            self.add(step.time, name, Happening::Brakes { speed: before.speed });
        } else if deceleration <= 0.0 {
            self.braking[index] = false;
        }
        if before.speed >= STANDING && after.speed < STANDING {
            self.add(end, name, Happening::Stops);
        } else if before.speed < STANDING && after.speed >= STANDING {
            self.add(step.time, name, Happening::Resumes);
        }
        self.follow_steered(step, index);
    }

    /// How a vehicle that is steered keeps its lane.
    fn follow_steered(&mut self, step: &Step, index: usize) {
        let (car, end) = (&step.after.vehicles[index], step.time + step.duration);
        let Some(steered) = &car.steered else { return };
        let world = self.world.clone();
        let setup = &world.vehicles[index];
        let (name, offset) = (&setup.name, steered.offset);
        if !self.swerving[index] && offset.abs() > SWERVES {
            self.swerving[index] = true;
            self.add(end, name, Happening::Swerves { left: offset > 0.0 });
        } else if offset.abs() < SWERVES / 2.0 {
            self.swerving[index] = false;
        }
        let (sine, cosine) = (libm::sin(steered.heading_error).abs(), libm::cos(steered.heading_error).abs());
        let reach = (car.length * sine + car.width * cosine) / 2.0;
        let beside = car.path.locate(steered.centre).left();
        let is_outside = beside.abs() + reach > world.road_of(setup).lane_width / 2.0;
        if is_outside != self.outside[index] {
            self.outside[index] = is_outside;
            let what = match is_outside {
                true => Happening::LeavesLane { left: beside > 0.0 },
                false => Happening::ReturnsToLane,
            };
            self.add(end, name, what);
        }
    }

    fn follow_pedestrian(&mut self, step: &Step, index: usize) {
        let world = self.world.clone();
        let name = &world.pedestrians[index].name;
        let (before, after) = (&step.before.pedestrians[index], &step.after.pedestrians[index]);
        let mode = &step.pedestrian_modes[index];
        if *mode != self.pedestrian_modes[index] {
            self.pedestrian_modes[index] = mode.clone();
            self.add(step.time, name, Happening::Mode(mode.clone()));
        }
        if !self.walking[index] && after.velocity.norm() >= STANDING {
            self.walking[index] = true;
            self.add(step.time, name, Happening::StartsWalking);
        } else if self.walking[index] && after.velocity.norm() < STANDING {
            self.walking[index] = false;
            self.add(step.time + step.duration, name, Happening::Stops);
        }
        let side = world.pedestrians[index].side;
        for (side, what) in
            [(side, Happening::EntersCarriageway), (side.opposite(), Happening::LeavesCarriageway)]
        {
            let kerb = world.road.kerb(side);
            let (from, to) = (world.road.across(before.position), world.road.across(after.position));
            if let Some(part) = passing_either_way(from, to, kerb) {
                self.add(step.time + part * step.duration, name, what);
            }
        }
        let lane = |vehicle: usize| (world.vehicles[vehicle].road, world.vehicles[vehicle].lane);
        for (vehicle, car) in step.before.vehicles.iter().enumerate() {
            // Told once of all that drive there.
            if (0..vehicle).any(|other| lane(other) == lane(vehicle)) {
                continue;
            }
            if let Some(part) = car.path.passed_between(before.position, after.position) {
                let time = step.time + part * step.duration;
                self.add(time, name, Happening::PassesConflictPoint);
            }
        }
    }

    /// Told of the pedestrian, or else of the vehicle that comes first.
    fn follow_contacts(&mut self, step: &Step) {
        for touch in step.contacts.iter().filter(|touch| touch.begins) {
            let (who, with) = match (touch.first, touch.second) {
                (car @ Solid::Vehicle(_), person @ Solid::Pedestrian(_)) => (person, car),
                other => other,
            };
            let (with, relative_speed) = (with.name(&self.world).to_string(), touch.relative_speed);
            let what = if touch.is_collision() {
                Happening::Collides { with, relative_speed }
            } else {
                Happening::Touches { with, relative_speed }
            };
            let world = self.world.clone();
            self.add(step.time + touch.moment, who.name(&world), what);
        }
    }
}

impl Timeline {
    fn follow_sightings(&mut self, step: &Step) {
        for sighting in step.sightings.iter().filter(|sighting| sighting.moment <= step.duration) {
            let world = self.world.clone();
            let of = world.vehicles[sighting.vehicle].name.clone();
            let what = if sighting.seen {
                Happening::ComesIntoSight { of }
            } else {
                Happening::IsLostFromSight { of }
            };
            self.add(step.time + sighting.moment, sighting.who.name(&world), what);
        }
    }
}

impl Observer for Timeline {
    fn observe(&mut self, step: &Step) {
        // Before what comes of it at the same moment.
        self.follow_sightings(step);
        for index in 0..self.world.vehicles.len() {
            self.follow_vehicle(step, index);
        }
        for index in 0..self.world.pedestrians.len() {
            if step.before.pedestrians[index].present {
                if !self.appeared[index] {
                    self.appeared[index] = true;
                    self.add(step.time, &self.world.clone().pedestrians[index].name, Happening::Appears);
                }
                self.follow_pedestrian(step, index);
            }
        }
        self.follow_contacts(step);
    }
}

/// The share of the step after which a rising quantity reaches `line`.
fn passing(before: f64, after: f64, line: f64) -> Option<f64> {
    (before < line && after >= line).then(|| (line - before) / (after - before))
}

fn passing_either_way(before: f64, after: f64, line: f64) -> Option<f64> {
    passing(before, after, line).or_else(|| passing(-before, -after, -line))
}
