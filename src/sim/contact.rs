//! Who touches whom: every two bodies of a world, and the moments within a step at which their footprints touch.

use nalgebra::Vector2;

use super::geometry::Footprint;
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
    /// Of every body, by where it begins along the x axis.
    reaches: Vec<Reach>,
    /// The pairs that are near enough to be looked at in the last step, in the order of [`pairs`].
    near: Vec<(Solid, Solid)>,
    /// The pairs that touched in the step before.
    touching: Vec<(Solid, Solid)>,
    found: Vec<Touch>,
}

/// Leaves room for rounding where bodies are too far apart to touch, m.
const SLACK: f64 = 1e-6;

/// So many pairs may be near each other before that takes an allocation.
const EXPECTED_PAIRS: usize = 64;

impl Contacts {
    /// Of a world in which nobody touches anybody yet.
    pub fn new(world: &World) -> Self {
        let vehicles = (0..world.vehicles.len()).map(Solid::Vehicle);
        let people = (0..world.pedestrians.len()).map(Solid::Pedestrian);
        let boxes = (0..world.road.boxes.len()).map(Solid::Box);
        Self {
            boxes: world.road.boxes.clone(),
            reaches: vehicles.chain(people).chain(boxes).map(Reach::nowhere).collect(),
            near: Vec::with_capacity(EXPECTED_PAIRS),
            touching: Vec::with_capacity(EXPECTED_PAIRS),
            found: Vec::with_capacity(EXPECTED_PAIRS),
        }
    }

    /// Follows a step of `duration` s in which everybody moves evenly from one state to the next. Only those who are
    /// there at its beginning touch anything.
    pub fn find(&mut self, before: &Snapshot, after: &Snapshot, duration: f64) -> &[Touch] {
        self.touching.clear();
        self.touching.extend(self.found.iter().map(|touch| (touch.first, touch.second)));
        self.found.clear();
        self.find_near(before, after);
        for (first, second) in &self.near {
            let Some(moment) = touch(*first, *second, before, after, &self.boxes, duration) else { continue };
            let part = moment / duration;
            let velocity = |solid| velocity(solid, before, after, duration, part);
            let relative_velocity = velocity(*second) - velocity(*first);
            self.found.push(Touch {
                first: *first,
                second: *second,
                moment,
                relative_speed: relative_velocity.norm(),
                relative_velocity,
                begins: !self.touching.contains(&(*first, *second)),
            });
        }
        &self.found
    }

    /// Finds the pairs that may touch in a step: bodies are sorted along the road, so that nobody is compared with who is far away.
    fn find_near(&mut self, before: &Snapshot, after: &Snapshot) {
        self.near.clear();
        for index in 0..self.reaches.len() {
            self.reaches[index].move_on(before, after, &self.boxes);
            // Hardly anybody changes places with anybody from one step to the next.
            let mut place = index;
            while place > 0 && self.reaches[place].low.x < self.reaches[place - 1].low.x {
                self.reaches.swap(place, place - 1);
                place -= 1;
            }
        }
        for (index, one) in self.reaches.iter().enumerate() {
            let beside = self.reaches[index + 1..].iter().take_while(|other| other.low.x <= one.high.x);
            let near = beside.filter(|other| other.low.y <= one.high.y && one.low.y <= other.high.y);
            self.near.extend(near.filter_map(|other| pair(one.solid, other.solid)));
        }
        if self.near.len() > 1 {
            self.near.sort_unstable_by_key(|(first, second)| place_among_pairs(*first, *second));
        }
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

/// Two bodies of which one may move, in the order in which [`pairs`] names them.
fn pair(one: Solid, other: Solid) -> Option<(Solid, Solid)> {
    let (first, second) = if body_rank(one) <= body_rank(other) { (one, other) } else { (other, one) };
    (!matches!(first, Solid::Box(_))).then_some((first, second))
}

/// Vehicles first, boxes last.
fn body_rank(solid: Solid) -> (u8, usize) {
    match solid {
        Solid::Vehicle(index) => (0, index),
        Solid::Pedestrian(index) => (1, index),
        Solid::Box(index) => (2, index),
    }
}

/// Where a pair stands among [`pairs`].
fn place_among_pairs(first: Solid, second: Solid) -> (u8, usize, usize) {
    let ((one, index), (other, others)) = (body_rank(first), body_rank(second));
    let kind = match (one, other) {
        (0, 1) => 0,
        (0, 0) => 1,
        (0, _) => 2,
        (_, 2) => 3,
        _ => 4,
    };
    (kind, index, others)
}

/// Where a body may touch somebody during a step: a rectangle along the axes of the world.
#[derive(Debug, Clone, Copy)]
struct Reach {
    solid: Solid,
    /// m
    low: Vector2<f64>,
    /// m
    high: Vector2<f64>,
}

impl Reach {
    /// Of a body that is not there.
    fn nowhere(solid: Solid) -> Self {
        let endless = Vector2::new(f64::INFINITY, f64::INFINITY);
        Self { solid, low: endless, high: -endless }
    }

    /// Where its body reaches from one state to the next: bodies whose reaches are apart are too far apart for [`touch`].
    fn move_on(&mut self, before: &Snapshot, after: &Snapshot, boxes: &[Body]) {
        let (centre, next, radius) = match self.solid {
            Solid::Vehicle(index) => {
                let (car, next) = (&before.vehicles[index], &after.vehicles[index]);
                (car.position(), next.position(), Vector2::new(car.length, car.width).norm() / 2.0)
            }
            Solid::Pedestrian(index) if before.pedestrians[index].present => {
                let (person, next) = (&before.pedestrians[index], &after.pedestrians[index]);
                (person.position, next.position, Footprint::from(person).radius())
            }
            Solid::Pedestrian(_) => {
                *self = Self::nowhere(self.solid);
                return;
            }
            // It stays where it was found.
            Solid::Box(_) if self.low.x < f64::INFINITY => return,
            Solid::Box(index) => {
                let body = Footprint::from(&boxes[index]);
                (body.centre, body.centre, body.radius())
            }
        };
        // Twice, since ends are rounded, too.
        let reach = radius + (next - centre).norm() + 2.0 * SLACK;
        let reach = Vector2::new(reach, reach);
        (self.low, self.high) = (centre - reach, centre + reach);
        // Of what is no number nobody knows where it reaches.
        if self.low.x.is_nan() || self.low.y.is_nan() {
            let endless = Vector2::new(f64::INFINITY, f64::INFINITY);
            (self.low, self.high) = (-endless, endless);
        }
    }
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::fixture;
    use scenario::agent::{Longitudinal, PedestrianState, VehicleState};
    use scenario::{Direction, Shape};

    /// Places that are crowded, far away, or no numbers.
    fn place() -> impl Strategy<Value = f64> {
        prop_oneof![40 => -12.0..12.0, 4 => -1e5..1e5, 1 => Just(f64::NAN)]
    }

    proptest! {
        /// What is found of all pairs, in the same order, step by step.
        #[test]
        fn whoever_is_far_away_is_left_out_and_nobody_else(
            cars in proptest::collection::vec((place(), 0_usize..2, 0.0..30.0_f64), 1..8),
            people in proptest::collection::vec((place(), -6.0..6.0_f64, -4.0..4.0_f64, -4.0..4.0_f64, 0_u32..3), 0..4),
            boxes in proptest::collection::vec((place(), -6.0..6.0_f64), 0..3),
        ) {
            let mut world = fixture::world();
            world.vehicles = cars.iter().map(|_| world.vehicles[0].clone()).collect();
            world.pedestrians = people.iter().map(|_| world.pedestrians[0].clone()).collect();
            let body = |(x, y): &(f64, f64)| Body { name: String::new(), x: *x, y: *y, length: 4.0, width: 1.5, heading: 0.3 };
            world.road.boxes = boxes.iter().map(body).collect();
            let state = |time: f64, step: u32| Snapshot {
                vehicles: cars.iter().map(|(travelled, lane, speed)| {
                    let direction = if *lane == 0 { Direction::Forward } else { Direction::Backward };
                    let path = scenario::Path::straight(*lane as f64 * 2.2, direction);
                    let motion =
                        Longitudinal { travelled: travelled + speed * time, speed: *speed, acceleration: 0.0 };
                    VehicleState::new(path, motion, (4.0, 2.0))
                }).collect(),
                pedestrians: people.iter().map(|(x, y, along, across, appears)| PedestrianState {
                    position: Vector2::new(x + along * time, y + across * time),
                    velocity: Vector2::new(*along, *across),
                    acceleration: Vector2::zeros(),
                    heading: Vector2::y(),
                    shape: Shape::Disc { radius: 0.25 },
                    present: step >= *appears,
                }).collect(),
            };
            let (mut contacts, mut touched) = (Contacts::new(&world), Vec::new());
            for step in 0..6 {
                let duration = 0.1;
                let time = f64::from(step) * duration;
                let (before, after) = (state(time, step), state(time + duration, step));
                let found = contacts.find(&before, &after, duration);
                let all = pairs(&world).filter_map(|(first, second)| {
                    Some((first, second, touch(first, second, &before, &after, &world.road.boxes, duration)?))
                });
                let all: Vec<_> = all.collect();
                prop_assert_eq!(found.len(), all.len());
                for (touch, (first, second, moment)) in found.iter().zip(&all) {
                    prop_assert_eq!((touch.first, touch.second), (*first, *second));
                    prop_assert_eq!(touch.moment.to_bits(), moment.to_bits());
                    prop_assert_eq!(touch.begins, !touched.contains(&(*first, *second)));
                }
                touched = all.iter().map(|(first, second, _)| (*first, *second)).collect();
            }
        }
    }
}
