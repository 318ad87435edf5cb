//! What a look ahead in a bend has shown to be free goes on to be free while both move on nearly as they were taken to: so that whoever
//! comes near nobody is not looked at again and again, and of whoever does only the last moments are.
//!
//! A gap changes no faster than both move, so that a gap known at one moment bounds it before and behind. From two neighbouring moments
//! follows how much of it is left between them at least; as long as neither is farther from where it was taken to be than that, no
//! contact is there.

use scenario::agent::{PedestrianState, VehicleState};

use super::closing::{ROUNDING_OF_GAPS, gap_between};
use super::geometry::Footprint;
use super::turning::{HORIZON, Moving};

/// Looks at a vehicle and a pedestrian ahead, from step to step.
#[derive(Debug, Clone)]
pub struct ContactAhead {
    /// What was found free, if anything was.
    clear: Option<Clear>,
    /// Of that: up to so many seconds after it was looked at, from where the one before ends, the gap is more than so many metres.
    stretches: Vec<(f64, f64)>,
    /// The last moment at which it was looked at how both move, s, and that.
    last: Option<(f64, Motion)>,
    /// When they were last found to touch, s.
    expected: Option<f64>,
}

/// How two move, as far as a vehicle that keeps its path and a pedestrian who goes straight on need to be told.
#[derive(Debug, Clone, Copy)]
struct Motion {
    /// Of the vehicle, m and m/s.
    travelled: f64,
    speed: f64,
    person: PedestrianState,
}

impl Motion {
    fn of(car: &VehicleState, person: &PedestrianState) -> Self {
        Self { travelled: car.motion.travelled, speed: car.motion.speed, person: *person }
    }

    /// How far outlines are at most from where they were taken to be who moved as `self` so many seconds ago and move as `other` now: now,
    /// m, and more for every second from now on, m/s. `most` is how far any point of the vehicle moves for a metre along its path. `None`
    /// if somebody has become another body.
    fn apart(&self, other: &Self, elapsed: f64, most: f64) -> Option<(f64, f64)> {
        if self.person.shape != other.person.shape {
            return None;
        }
        // Who walks on as before turns by what rounding does to their heading.
        let turned =
            (other.person.heading - self.person.heading).norm() * Footprint::from(&self.person).radius();
        let along = (other.travelled - self.travelled - self.speed * elapsed).abs();
        let walked = other.person.position - self.person.position - self.person.velocity * elapsed;
        let faster = (other.speed - self.speed).abs();
        let walks = (other.person.velocity - self.person.velocity).norm();
        Some((most * along + walked.norm() + turned, most * faster + walks))
    }
}

/// A time for which nothing touches if both move on as they do.
#[derive(Debug, Clone, Copy)]
struct Clear {
    /// When it was looked at, s.
    at: f64,
    /// For how long from then on, s.
    lasts: f64,
    motion: Motion,
    /// How far any point of the vehicle moves at most for a metre along its path.
    most: f64,
}

/// It is looked so far ahead, s: what lies beyond the horizon of a contact is needed later.
const AHEAD: f64 = HORIZON + 2.5;

/// Where somebody comes nearer than this nothing is said to be free, m.
const NEAR: f64 = 0.01;

/// What was found free is looked for anew where less than this share of it still is.
const LEAST_LEFT: f64 = 0.8;

/// Looks for what is free, at most.
const LOOKS: usize = 48;

/// Whoever moves otherwise by more than this at the horizon from one step to the next is not looked ahead for, m.
const UNSTEADY: f64 = 1.0;

impl ContactAhead {
    /// Of a pair of which the vehicle follows a path that bends, or does not; allocates what all looks need.
    pub fn new(bends: bool) -> Self {
        Self {
            clear: None,
            stretches: Vec::with_capacity(if bends { LOOKS } else { 0 }),
            last: None,
            expected: None,
        }
    }

    /// As [`contact_with`](crate::contact_with), of a pair that is asked for at one time (s) after another.
    pub fn look(&mut self, time: f64, car: &VehicleState, person: &PedestrianState) -> Option<f64> {
        if car.keeps_straight() || car.steered.is_some() {
            return super::contact_with(car, person);
        }
        let motion = Motion::of(car, person);
        // Where it goes straight on for longer than is looked ahead in bends there is an exact answer, for any time.
        let moving = Moving::vehicle(car);
        let (turns, lasts) = moving.turns(0.0);
        if !turns && lasts >= HORIZON {
            return super::contact_with(car, person);
        }
        let free = self.clear.map_or(0.0, |clear| clear.free(time, &motion, &self.stretches));
        let before = self.last.replace((time, motion));
        if free >= HORIZON {
            return None;
        }
        let expected = self.expected.map(|moment| moment - time);
        let found = moving.meets_from((turns, lasts), &Moving::person(person), free, expected);
        self.expected = found.map(|found| time + found);
        if self.clear.is_none_or(|clear| free <= clear.worth(time)) {
            let steady = before.is_some_and(|(earlier, before)| {
                let apart = before.apart(&motion, time - earlier, 1.0);
                apart.is_some_and(|(now, later)| now + later * HORIZON <= UNSTEADY)
            });
            self.clear = steady
                .then(|| Clear::found(time, (car, person), &moving, motion, &mut self.stretches))
                .flatten();
        }
        found
    }
}

impl Clear {
    fn found(
        at: f64,
        (car, person): (&VehicleState, &PedestrianState),
        moving: &Moving,
        motion: Motion,
        stretches: &mut Vec<(f64, f64)>,
    ) -> Option<Self> {
        let other = Moving::person(person);
        let fastest = moving.fastest(0.0, AHEAD) + other.fastest(0.0, AHEAD);
        let rough = moving.roughness() + other.roughness();
        let gap = |time: f64| gap_between(&moving.roughly(time), &other.roughly(time)) - rough;
        let (mut time, mut left) = (0.0, gap(0.0));
        stretches.clear();
        while time < AHEAD && left >= NEAR && stretches.len() < LOOKS {
            let next = (time + left / fastest).min(AHEAD);
            let then = gap(next);
            stretches.push((next, (left + then - fastest * (next - time)) / 2.0));
            (time, left) = (next, then);
        }
        let (from, size) = (car.motion.travelled, (car.length, car.width));
        // Also where it comes to if it is a little faster.
        let most = car.path.most_moved((from, from + reach(car.motion.speed)), size);
        (time > 0.0).then_some(Self { at, lasts: time, motion, most })
    }

    /// For how long from a time (s) on nothing touches who move so then, s.
    fn free(&self, time: f64, motion: &Motion, stretches: &[(f64, f64)]) -> f64 {
        let elapsed = time - self.at;
        // The vehicle comes no farther than where the tightest bend was looked for.
        let farthest = self.motion.travelled + reach(self.motion.speed);
        if elapsed < 0.0
            || motion.travelled < self.motion.travelled
            || motion.travelled + AHEAD * motion.speed > farthest
        {
            return 0.0;
        }
        let Some((now, later)) = self.motion.apart(motion, elapsed, self.most) else { return 0.0 };
        let ahead = stretches.iter().filter(|(end, _)| *end >= elapsed);
        ahead
            .take_while(|(end, left)| *left > now + later * (end - elapsed) + ROUNDING_OF_GAPS)
            .last()
            .map_or(0.0, |(end, _)| end - elapsed)
    }

    /// What of it is worth keeping at a time (s) if so much is still free, s: all of the horizon, where it was looked so far.
    fn worth(&self, time: f64) -> f64 {
        if self.lasts >= AHEAD { HORIZON } else { LEAST_LEFT * (self.lasts - (time - self.at)).max(0.0) }
    }
}

/// How far a vehicle of this speed (m/s) comes while it is looked ahead, if it becomes a little faster, m.
fn reach(speed: f64) -> f64 {
    2.0 * AHEAD * speed + 10.0
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::Vector2;
    use proptest::prelude::*;

    use super::*;
    use crate::contact_with;
    use scenario::agent::Longitudinal;
    use scenario::geometry::{CurvedPath, Piece, Pose, ReferenceLine};
    use scenario::{Direction, Path, Shape};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]
        /// Cars that brake and people who turn back or change their speed: bit for bit what looking anew in every step finds.
        #[test]
        fn looking_from_step_to_step_finds_what_looking_anew_finds(
            (travelled, speed, brake) in (-25.0..10.0, 0.5..9.0, -0.4..0.2_f64), (place, beside) in (-5.0..30.0, -6.0..6.0),
            (walk, way, change) in (0.0..2.0, 0.0..6.3, -0.02..0.02_f64), (from, to) in (0_usize..160, 0_usize..160),
            backward: bool, turned in 0_usize..200, turning in -0.002..0.002_f64,
        ) {
            let [one, arc, other] = Piece::turn(1500.0, 9.0, 0.36, 0.85);
            let pieces = [Piece::line(30.0), one, arc, other, Piece::line(20.0)];
            let line = ReferenceLine::new(Pose::origin(), &pieces).unwrap();
            let direction = if backward { Direction::Backward } else { Direction::Forward };
            let path = Path::curved(CurvedPath::new(Arc::new(line), 1.0, direction, 30.0).unwrap());
            let motion = Longitudinal { travelled, speed, acceleration: 0.0 };
            let mut car = VehicleState::new(path.clone(), motion, (4.36, 1.82));
            let heading = Vector2::new(libm::cos(way), libm::sin(way));
            let mut person = PedestrianState {
                position: path.to_world(Vector2::new(place, beside)), velocity: heading * walk, acceleration: Vector2::zeros(),
                heading, shape: Shape::Rectangle { length: 0.6, width: 0.5 }, present: true,
            };
            let mut ahead = ContactAhead::new(true);
            for step in 0..160 {
                let time = f64::from(step) * 0.025;
                if (from..to).contains(&(step as usize)) {
                    car.motion.speed = (car.motion.speed + brake * 0.5).clamp(0.0, 9.0);
                    person.velocity += heading * change;
                }
                let aside = Vector2::new(-person.heading.y, person.heading.x);
                person.heading = (person.heading + aside * turning).normalize();
                if step as usize == turned {
                    (person.velocity, person.heading) = (-person.velocity, -person.heading);
                }
                car.motion.travelled += car.motion.speed * 0.025;
                person.position += person.velocity * 0.025;
                prop_assert_eq!(ahead.look(time, &car, &person), contact_with(&car, &person), "in step {}", step);
            }
        }
    }

    /// A car on an arc, and somebody who stands so far to the left of its middle, m.
    fn car_before_somebody(beside: f64) -> (VehicleState, PedestrianState) {
        let line = ReferenceLine::new(Pose::origin(), &[Piece::arc(40.0, 2.0)]).unwrap();
        let path = Path::curved(CurvedPath::new(Arc::new(line), 0.0, Direction::Forward, 0.0).unwrap());
        let person = PedestrianState {
            position: path.to_world(Vector2::new(30.0, beside)),
            velocity: Vector2::zeros(),
            acceleration: Vector2::zeros(),
            heading: Vector2::y(),
            shape: Shape::Disc { radius: 0.25 },
            present: true,
        };
        let motion = Longitudinal { travelled: 0.0, speed: 5.0, acceleration: 0.0 };
        (VehicleState::new(path, motion, (4.4, 1.8)), person)
    }

    #[test]
    fn what_is_free_is_not_looked_at_again() {
        let (mut car, person) = car_before_somebody(3.0);
        let (mut ahead, mut looks) = (ContactAhead::new(true), Vec::new());
        for step in 0..100 {
            assert_eq!(ahead.look(f64::from(step) * 0.025, &car, &person), None);
            looks.extend(ahead.clear.as_ref().map(|clear| clear.at));
            car.motion.travelled += 5.0 * 0.025;
        }
        looks.dedup();
        assert_eq!(looks.len(), 1, "looked at again at {looks:?} s");
    }

    #[test]
    fn of_who_is_hit_only_the_last_moments_are_looked_at_again() {
        let (mut car, person) = car_before_somebody(0.4);
        let (mut ahead, mut looks, mut left_out) = (ContactAhead::new(true), Vec::new(), 0);
        for step in 0..200 {
            let time = f64::from(step) * 0.025;
            let motion = Motion::of(&car, &person);
            let free = ahead.clear.map_or(0.0, |clear| clear.free(time, &motion, &ahead.stretches));
            let found = ahead.look(time, &car, &person).expect("it comes straight at them");
            assert_eq!(Some(found), contact_with(&car, &person), "at {time} s");
            assert!(free <= found, "free for {free} s before a contact in {found} s");
            left_out += u32::from(free > found - 0.05);
            looks.extend(ahead.clear.as_ref().map(|clear| clear.at));
            car.motion.travelled += 5.0 * 0.025;
        }
        looks.dedup();
        assert!(left_out > 190 && looks.len() < 5, "{left_out} begun at the end, looked at {looks:?} s");
    }
}
