//! Who touches whom: every two bodies of a world, and the moments within a step at which their footprints touch.

use nalgebra::Vector2;

use super::solid::Solid;
use super::turning::{touch_on_a_bend, turns};
use scenario::agent::{Snapshot, velocity_inside};
use scenario::{Body, World};

/// Two footprints that touch during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// A vehicle, if one of them is.
    pub first: Solid,
    /// Never the same body as `first`.
    pub second: Solid,
    /// From the beginning of the step to their first touch in it, s.
    pub moment: f64,
    /// Length of the difference of their velocities then, m/s.
    pub relative_speed: f64,
    /// The velocity of the second against the first then, m/s.
    pub relative_velocity: Vector2<f64>,
    /// Whether they did not touch in the step before.
    pub begins: bool,
}

impl Touch {
    /// Whether it is a collision: of a vehicle, with anything.
    pub fn is_collision(&self) -> bool {
        matches!(self.first, Solid::Vehicle(_))
    }
}

/// Finds the contacts of a run, step by step.
#[derive(Debug, Clone)]
pub struct Contacts {
    boxes: Vec<Body>,
    /// Two bodies, the vehicle first, and whether they touched in the last step.
    pairs: Vec<(Solid, Solid, bool)>,
    found: Vec<Touch>,
}

/// Leaves room for rounding where bodies are too far apart to touch, m.
const SLACK: f64 = 1e-6;

impl Contacts {
    /// Of a world in which nobody touches anybody yet.
    pub fn new(world: &World) -> Self {
        let pairs: Vec<_> = pairs(world).map(|(first, second)| (first, second, false)).collect();
        let found = Vec::with_capacity(pairs.len().min(64));
        Self { boxes: world.road.boxes.clone(), pairs, found }
    }

    /// Follows a step of `duration` s in which everybody moves evenly from one state to the next. Only those who are
    /// there at its beginning touch anything.
    pub fn find(&mut self, before: &Snapshot, after: &Snapshot, duration: f64) -> &[Touch] {
        self.found.clear();
        for (first, second, touching) in &mut self.pairs {
            let moment = touch(*first, *second, before, after, &self.boxes, duration);
            if let Some(moment) = moment {
                let part = moment / duration;
                let velocity = |solid| velocity(solid, before, after, duration, part);
                let relative_velocity = velocity(*second) - velocity(*first);
                self.found.push(Touch {
                    first: *first,
                    second: *second,
                    moment,
                    relative_speed: relative_velocity.norm(),
                    relative_velocity,
                    begins: !*touching,
                });
            }
            *touching = moment.is_some();
        }
        &self.found
    }

    /// Those of the last step.
    pub fn found(&self) -> &[Touch] {
        &self.found
    }

    /// When a vehicle first touches anything in the last step, s after its beginning.
    pub fn collision(&self) -> Option<f64> {
        self.found.iter().filter(|touch| touch.is_collision()).map(|touch| touch.moment).reduce(f64::min)
    }

    /// Forgets what of the last step is later than a moment in it, as it does not happen.
    pub fn end_at(&mut self, moment: f64) {
        self.found.retain(|touch| touch.moment <= moment);
    }
}

/// Every two bodies of which one may move, vehicles with pedestrians first.
pub(super) fn pairs(world: &World) -> impl Iterator<Item = (Solid, Solid)> {
    let (cars, people, boxes) = (world.vehicles.len(), world.pedestrians.len(), world.road.boxes.len());
    let with = |first: fn(usize) -> Solid, count: usize, second: fn(usize) -> Solid, others: usize| {
        (0..count).flat_map(move |one| (0..others).map(move |other| (first(one), second(other))))
    };
    let among = |kind: fn(usize) -> Solid, count: usize| {
        (0..count).flat_map(move |one| (one + 1..count).map(move |other| (kind(one), kind(other))))
    };
    with(Solid::Vehicle, cars, Solid::Pedestrian, people)
        .chain(among(Solid::Vehicle, cars))
        .chain(with(Solid::Vehicle, cars, Solid::Box, boxes))
        .chain(with(Solid::Pedestrian, people, Solid::Box, boxes))
        .chain(among(Solid::Pedestrian, people))
}

fn touch(
    first: Solid,
    second: Solid,
    before: &Snapshot,
    after: &Snapshot,
    boxes: &[Body],
    duration: f64,
) -> Option<f64> {
    let (one, other) = (first.footprint(before, boxes)?, second.footprint(before, boxes)?);
    // Where a body is at the beginning is where its outline is.
    let moved = place(second, after, boxes) - other.centre - (place(first, after, boxes) - one.centre);
    let near = one.radius() + other.radius() + moved.norm() + SLACK;
    if (other.centre - one.centre).norm() > near {
        return None;
    }
    if turns(first, before, after) || turns(second, before, after) {
        return touch_on_a_bend((first, second), (before, after), boxes, duration);
    }
    one.first_contact(&other, moved / duration).filter(|moment| *moment <= duration)
}

/// Where the centre of a body is, m.
fn place(solid: Solid, state: &Snapshot, boxes: &[Body]) -> Vector2<f64> {
    match solid {
        Solid::Vehicle(index) => state.vehicles[index].position(),
        Solid::Pedestrian(index) => state.pedestrians[index].position,
        Solid::Box(index) => Vector2::new(boxes[index].x, boxes[index].y),
    }
}

fn velocity(solid: Solid, before: &Snapshot, after: &Snapshot, duration: f64, part: f64) -> Vector2<f64> {
    match solid {
        Solid::Vehicle(index) => {
            before.vehicles[index].velocity().lerp(&after.vehicles[index].velocity(), part)
        }
        Solid::Pedestrian(index) => {
            velocity_inside(duration, &before.pedestrians[index], &after.pedestrians[index], part)
        }
        Solid::Box(_) => Vector2::zeros(),
    }
}
