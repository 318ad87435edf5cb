//! What can be seen of road users: positions, motions and sizes.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::steered::Steered;
use crate::{Path, Shape, VehicleReference};

/// A vehicle as anyone may see it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VehicleState {
    /// Where it is on its path and how it moves along it.
    pub motion: Longitudinal,
    /// Where it drives.
    #[serde(flatten)]
    pub path: Path,
    /// m
    pub length: f64,
    /// m
    pub width: f64,
    /// Where it is since its controller steers it; `None`: on its path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steered: Option<Steered>,
    #[serde(skip)]
    known: KnownPose,
}

/// The centre and the heading at a place of a path that bends, which a whole step asks for. It counts while the vehicle is at that
/// place, and is no part of its state.
#[derive(Debug, Clone, Copy, Default)]
struct KnownPose(Option<(f64, Vector2<f64>, Vector2<f64>)>);

impl PartialEq for KnownPose {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Motion along a path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Longitudinal {
    /// Of the vehicle's centre relative to the middle of the crossing in m; negative before it.
    pub travelled: f64,
    /// m/s, never negative.
    pub speed: f64,
    /// Of the step before, m/s².
    pub acceleration: f64,
}

impl Longitudinal {
    /// Moves on by `step` s at a constant acceleration (m/s²); stops at zero speed and reports the mean acceleration
    /// that was realised.
    pub fn accelerate(&mut self, acceleration: f64, step: f64) {
        let before = self.speed;
        let after = before + acceleration * step;
        if after >= 0.0 {
            self.travelled += (before + after) / 2.0 * step;
            self.speed = after;
        } else {
            // Stands after v/|a|, so it covers v²/(2|a|).
            self.travelled -= before * before / (2.0 * acceleration);
            self.speed = 0.0;
        }
        self.acceleration = (self.speed - before) / step;
    }
}

impl VehicleState {
    /// A vehicle on its path, of this length and width (m).
    pub fn new(path: Path, motion: Longitudinal, (length, width): (f64, f64)) -> Self {
        Self { motion, path, length, width, steered: None, known: KnownPose(None) }
    }

    /// The same vehicle in another motion.
    pub fn in_motion(&self, motion: Longitudinal) -> Self {
        Self { motion, ..self.clone() }
    }

    /// Works out its pose for all who will ask for it where it is now.
    #[inline]
    pub fn know_pose(&mut self) {
        if !self.keeps_straight() && self.steered.is_none() {
            let (centre, heading) = self.path.pose(self.motion.travelled);
            self.known = KnownPose(Some((self.motion.travelled, centre, heading)));
        }
    }

    /// The pose on its path.
    #[inline]
    fn on_path(&self) -> (Vector2<f64>, Vector2<f64>) {
        match self.known.0 {
            Some((place, centre, heading)) if place == self.motion.travelled => (centre, heading),
            _ => self.path.pose(self.motion.travelled),
        }
    }

    /// The centre in the world frame.
    #[inline]
    pub fn position(&self) -> Vector2<f64> {
        match &self.steered {
            None if self.known.0.is_some() => self.on_path().0,
            None => self.path.point(self.motion.travelled),
            Some(steered) => steered.centre,
        }
    }

    /// In the world frame, m/s.
    #[inline]
    pub fn velocity(&self) -> Vector2<f64> {
        match &self.steered {
            None => self.path.velocity(self.motion.travelled, self.motion.speed),
            Some(steered) => steered.velocity(self.motion.speed),
        }
    }

    /// Unit vector in which it points.
    #[inline]
    pub fn heading(&self) -> Vector2<f64> {
        match &self.steered {
            None if self.known.0.is_some() => self.on_path().1,
            None => self.path.heading(self.motion.travelled),
            Some(steered) => steered.heading,
        }
    }

    /// The centre in the world frame, and the unit vector in which it points.
    #[inline]
    pub fn pose(&self) -> (Vector2<f64>, Vector2<f64>) {
        match &self.steered {
            None => self.on_path(),
            Some(steered) => (steered.centre, steered.heading),
        }
    }

    /// Whether it drives on a straight lane and nobody steers it: its outline then lies along the x axis of the world.
    #[inline]
    pub fn keeps_straight(&self) -> bool {
        self.steered.is_none() && self.path.course().is_none()
    }

    /// The same vehicle after a `part` of the way from here to where it is `after`.
    pub fn between(&self, after: &Self, part: f64) -> Self {
        let mix = |from: f64, to: f64| from + part * (to - from);
        let mut between = after.clone();
        between.motion.travelled = mix(self.motion.travelled, after.motion.travelled);
        between.motion.speed = mix(self.motion.speed, after.motion.speed);
        if let Some(to) = &after.steered {
            let from = self.steered.unwrap_or_else(|| {
                let (centre, heading) = self.pose();
                let curvature = self.path.curvature(self.motion.travelled);
                Steered { centre, heading, curvature, offset: 0.0, heading_error: 0.0, ..*to }
            });
            between.steered = Some(from.between(to, part));
        }
        between
    }

    /// A vector of the world frame as it is seen from the vehicle: x ahead, y to the left.
    #[inline]
    pub fn turned(&self, vector: Vector2<f64>) -> Vector2<f64> {
        match &self.steered {
            None => self.path.turned(self.motion.travelled, vector),
            Some(steered) => steered.turned(vector),
        }
    }

    /// The other way round: what is seen from the vehicle, in the world frame.
    #[inline]
    pub fn turned_back(&self, vector: Vector2<f64>) -> Vector2<f64> {
        match &self.steered {
            None => self.path.turned_back(self.motion.travelled, vector),
            Some(steered) => steered.turned_back(vector),
        }
    }

    /// Distance that a part of the vehicle still has to go to a place on its path; negative once past it, m.
    #[inline]
    pub fn distance_to(&self, place: f64, reference: VehicleReference) -> f64 {
        let ahead = match reference {
            VehicleReference::Centre => 0.0,
            VehicleReference::Front => self.length / 2.0,
        };
        place - self.motion.travelled - ahead
    }

    /// Time to cover [`Self::distance_to`] at the present speed in s; infinite when standing before it, negative
    /// once past it.
    #[inline]
    pub fn time_to_arrival(&self, place: f64, reference: VehicleReference) -> f64 {
        let distance = self.distance_to(place, reference);
        if distance == 0.0 { 0.0 } else { distance / self.motion.speed }
    }
}

/// A pedestrian as anyone may see it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PedestrianState {
    /// Centre in the world frame, m.
    pub position: Vector2<f64>,
    /// m/s
    pub velocity: Vector2<f64>,
    /// Of the step before, m/s².
    pub acceleration: Vector2<f64>,
    /// Unit vector: the way it faces, which is the way it last walked, at first towards its goal.
    pub heading: Vector2<f64>,
    /// Its footprint, which turns with `heading`.
    pub shape: Shape,
    /// Whether it is in the world yet. Nobody sees it before.
    pub present: bool,
}

/// Everything that can be seen at one moment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// In the order of the world.
    pub vehicles: Vec<VehicleState>,
    /// In the order of the world, with those who have not appeared.
    pub pedestrians: Vec<PedestrianState>,
}

/// A pedestrian either accelerates evenly over a step of `duration` s or takes its new velocity at once; which of both
/// shows in how far it came. The velocity after `part` of the step, m/s.
pub fn velocity_inside(
    duration: f64,
    old: &PedestrianState,
    new: &PedestrianState,
    part: f64,
) -> Vector2<f64> {
    let even = (old.velocity + new.velocity) * (duration / 2.0);
    let accelerates = ((new.position - old.position) - even).norm() <= 1e-9;
    if accelerates { old.velocity.lerp(&new.velocity, part) } else { new.velocity }
}
