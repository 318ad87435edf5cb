//! When bodies touch of which one follows a path that bends or is steered: by steps that no contact can hide in.

use nalgebra::Vector2;

use super::closing::{closes, gap_between, look_before};
use super::geometry::{Footprint, first_contact};
use super::solid::Solid;
use scenario::agent::{PedestrianState, Snapshot, Steered, VehicleState};
use scenario::{Body, Path, Shape};

/// A contact is not looked for beyond this time, s.
pub(super) const HORIZON: f64 = 10.0;

/// A contact ahead is looked for at multiples of this, s: what only grazes for so short a time is no contact.
const LEAST_AHEAD: f64 = 1.0 / 256.0;

/// The same within a step.
const LEAST_IN_STEP: f64 = 1.0 / 1024.0;

/// Two places that are nearer than this are one, m.
const ROUNDING: f64 = 1e-9;

/// What a vehicle grazes for less than this of its way it does not touch, m.
const LEAST_WAY: f64 = 1.0 / 16.0;

/// The outline of a vehicle at a place of its path.
fn vehicle_at(path: &Path, place: f64, (length, width): (f64, f64)) -> Footprint {
    let shape = Shape::Rectangle { length, width };
    let (centre, heading) = path.pose(place);
    Footprint { centre, heading, shape }
}

/// The same but for the path's roughness, and sooner.
fn roughly_at(path: &Path, place: f64, (length, width): (f64, f64)) -> Footprint {
    let shape = Shape::Rectangle { length, width };
    let (centre, heading) = path.rough_pose(place);
    Footprint { centre, heading, shape }
}

/// How far (m) a point of a vehicle may be from where it is roughly.
fn roughness(path: &Path, (length, width): (f64, f64)) -> f64 {
    path.roughness(libm::hypot(length, width) / 2.0)
}

/// The time (s) after which two touch first who move on from now, vehicles along their paths at the speed that they have;
/// `None` if they never do. On bends it is not looked for beyond 10 s.
pub(super) fn contact_ahead(
    (first, second): (Solid, Solid),
    state: &Snapshot,
    boxes: &[Body],
) -> Option<f64> {
    let (one, other) = (Moving::new(first, state, boxes)?, Moving::new(second, state, boxes)?);
    one.meets(&other, 0.0, None)
}

/// The same of a vehicle and a pedestrian.
#[inline]
pub fn contact_with(vehicle: &VehicleState, pedestrian: &PedestrianState) -> Option<f64> {
    match vehicle.keeps_straight() {
        true => first_contact(vehicle, pedestrian, pedestrian.velocity - vehicle.velocity()),
        false => Moving::vehicle(vehicle).meets(&Moving::Person(pedestrian), 0.0, None),
    }
}

/// The same of two vehicles.
pub fn vehicles_meet(one: &VehicleState, other: &VehicleState) -> Option<f64> {
    match one.keeps_straight() && other.keeps_straight() {
        true => Footprint::from(one).first_contact(&other.into(), other.velocity() - one.velocity()),
        false => Moving::vehicle(one).meets(&Moving::vehicle(other), 0.0, None),
    }
}

/// Somebody who moves on as they do now.
pub(super) enum Moving<'a> {
    Vehicle(&'a VehicleState),
    Beside(Beside<'a>),
    Person(&'a PedestrianState),
    Box(&'a Body),
}

impl<'a> Moving<'a> {
    fn new(solid: Solid, state: &'a Snapshot, boxes: &'a [Body]) -> Option<Self> {
        match solid {
            Solid::Vehicle(index) => Some(Self::vehicle(&state.vehicles[index])),
            Solid::Pedestrian(index) => {
                let person = &state.pedestrians[index];
                person.present.then_some(Self::Person(person))
            }
            Solid::Box(index) => Some(Self::Box(&boxes[index])),
        }
    }

    pub(super) fn vehicle(car: &'a VehicleState) -> Self {
        car.steered.as_ref().map_or(Self::Vehicle(car), |steered| Self::Beside(Beside::new(car, steered)))
    }

    pub(super) fn person(person: &'a PedestrianState) -> Self {
        Self::Person(person)
    }

    /// After so many seconds.
    pub(super) fn outline(&self, time: f64) -> Footprint {
        match self {
            Self::Vehicle(car) => {
                let place = car.motion.travelled + car.motion.speed * time;
                match car.path.course() {
                    Some(_) if time != 0.0 => vehicle_at(&car.path, place, (car.length, car.width)),
                    Some(_) => Footprint::from(*car),
                    None => Footprint { centre: car.path.point(place), ..Footprint::from(*car) },
                }
            }
            Self::Beside(beside) => beside.outline(time),
            Self::Person(person) => {
                Footprint { centre: person.position + person.velocity * time, ..Footprint::from(*person) }
            }
            Self::Box(body) => Footprint::from(*body),
        }
    }

    /// The same but for [`Self::roughness`], and sooner.
    pub(super) fn roughly(&self, time: f64) -> Footprint {
        match self {
            Self::Vehicle(car) if time != 0.0 && car.path.course().is_some() => {
                let place = car.motion.travelled + car.motion.speed * time;
                roughly_at(&car.path, place, (car.length, car.width))
            }
            _ => self.outline(time),
        }
    }

    /// How far (m) a point of it may be from where it is roughly.
    pub(super) fn roughness(&self) -> f64 {
        match self {
            Self::Vehicle(car) => roughness(&car.path, (car.length, car.width)),
            _ => 0.0,
        }
    }

    /// After so many seconds, m/s.
    fn velocity(&self, time: f64) -> Vector2<f64> {
        match self {
            Self::Vehicle(car) => {
                car.path.velocity(car.motion.travelled + car.motion.speed * time, car.motion.speed)
            }
            Self::Beside(beside) => beside.velocity(time),
            Self::Person(person) => person.velocity,
            Self::Box(_) => Vector2::zeros(),
        }
    }

    /// From a time (s) on: whether it turns, and for how long that stays so, s.
    pub(super) fn turns(&self, time: f64) -> (bool, f64) {
        let (car, along) = match self {
            Self::Vehicle(car) => (*car, car.motion.speed),
            Self::Beside(beside) => (beside.car, beside.along),
            Self::Person(_) | Self::Box(_) => return (false, f64::INFINITY),
        };
        if car.path.course().is_none() || along <= 0.0 {
            return (false, f64::INFINITY);
        }
        let place = car.motion.travelled + along * time;
        let straight = car.path.straight_ahead(place);
        let turns = straight <= ROUNDING;
        let ahead = if turns { car.path.bend_ahead(place).max(ROUNDING) } else { straight };
        (turns, ahead / along)
    }

    /// What no point of its outline is faster than between two times (s), m/s.
    pub(super) fn fastest(&self, from: f64, to: f64) -> f64 {
        if let Self::Beside(beside) = self {
            return beside.fastest(from, to);
        }
        let Self::Vehicle(car) = self else { return self.velocity(from).norm() };
        let (place, speed) = (car.motion.travelled, car.motion.speed);
        let (from, to) = (place + speed * from, place + speed * to);
        speed * car.path.most_moved((from, to), (car.length, car.width))
    }

    /// When it first touches another who is known not to touch it for so many seconds, and perhaps expected to touch it then: exactly
    /// while both go straight on, by looks that no contact can hide between where one turns.
    pub(super) fn meets(&self, other: &Self, free: f64, expected: Option<f64>) -> Option<f64> {
        self.meets_from(self.turns(0.0), other, free, expected)
    }

    /// The same where it is known whether it turns now, and for how long that stays so, s.
    pub(super) fn meets_from(
        &self,
        (mut one_turns, mut one_for): (bool, f64),
        other: &Self,
        free: f64,
        expected: Option<f64>,
    ) -> Option<f64> {
        let mut time = 0.0;
        loop {
            let (other_turns, other_for) = other.turns(time);
            let lasts = one_for.min(other_for);
            let found = if time + lasts <= free {
                None
            } else if one_turns || other_turns {
                let end = (time + lasts).min(HORIZON);
                let from = look_before(free, LEAST_AHEAD).max(time);
                let gap = |time: f64| gap_between(&self.outline(time), &other.outline(time));
                let rough = self.roughness() + other.roughness();
                let roughly = |time: f64| gap_between(&self.roughly(time), &other.roughly(time)) - rough;
                let fastest = self.fastest(from, end) + other.fastest(from, end);
                closes(gap, roughly, fastest, (from, end), LEAST_AHEAD, expected)
            } else {
                let velocity = other.velocity(time) - self.velocity(time);
                let met = self.outline(time).first_contact(&other.outline(time), velocity);
                met.filter(|met| *met <= lasts).map(|met| time + met)
            };
            // Whoever has gone straight on from now on is looked at for as long as on a straight road.
            if found.is_some() {
                return found.filter(|found| time == 0.0 || *found <= HORIZON);
            }
            time += lasts;
            if time >= HORIZON {
                return None;
            }
            (one_turns, one_for) = self.turns(time);
        }
    }
}

/// A vehicle that was steered beside its path and is not steered on: it goes on at the angle to its path that it has, straight on
/// beside a straight one.
pub(super) struct Beside<'a> {
    car: &'a VehicleState,
    offset: f64,
    angle: f64,
    /// How fast the place abreast of it moves, m/s.
    along: f64,
    /// How fast it moves to the left of the path, m/s.
    sideways: f64,
}

impl<'a> Beside<'a> {
    fn new(car: &'a VehicleState, steered: &Steered) -> Self {
        let (offset, angle) = (steered.offset, steered.heading_error);
        let inwards = (1.0 - car.path.curvature(car.motion.travelled) * offset).max(0.1);
        let (along, sideways) = (libm::cos(angle) / inwards, libm::sin(angle));
        Self { car, offset, angle, along: car.motion.speed * along, sideways: car.motion.speed * sideways }
    }

    /// After so many seconds.
    fn outline(&self, time: f64) -> Footprint {
        let place = self.car.motion.travelled + self.along * time;
        let (centre, heading) =
            self.car.path.pose_beside(place, self.offset + self.sideways * time, self.angle);
        let shape = Shape::Rectangle { length: self.car.length, width: self.car.width };
        Footprint { centre, heading, shape }
    }

    /// After so many seconds, where it does not turn, m/s.
    fn velocity(&self, time: f64) -> Vector2<f64> {
        let ahead = self.car.path.heading(self.car.motion.travelled + self.along * time);
        ahead * self.along + Vector2::new(-ahead.y, ahead.x) * self.sideways
    }

    /// What no point of its outline is faster than between two times (s), m/s.
    fn fastest(&self, from: f64, to: f64) -> f64 {
        let place = |time: f64| self.car.motion.travelled + self.along * time;
        let bend = self.car.path.tightest_between(place(from), place(to));
        let farthest = self.offset.abs() + self.sideways.abs() * to;
        // Its centre may be as far from the point that follows as half its length.
        let reach = farthest + libm::hypot(self.car.length, self.car.width) / 2.0 + self.car.length / 2.0;
        self.along.abs() * (1.0 + bend * reach) + self.sideways.abs()
    }
}

/// The moment (s) within a step of `duration` s at which two first touch of which one is a vehicle on a bend; `None` too if
/// neither is, for which there is an exact answer.
pub(super) fn touch_on_a_bend(
    (first, second): (Solid, Solid),
    (before, after): (&Snapshot, &Snapshot),
    boxes: &[Body],
    duration: f64,
) -> Option<f64> {
    let outline = |solid: Solid, time: f64| {
        let part = time / duration;
        match solid {
            Solid::Vehicle(index) => {
                let (car, next) = (&before.vehicles[index], &after.vehicles[index].motion);
                if after.vehicles[index].steered.is_some() {
                    return Footprint::from(&car.between(&after.vehicles[index], part));
                }
                let place = car.motion.travelled + part * (next.travelled - car.motion.travelled);
                vehicle_at(&car.path, place, (car.length, car.width))
            }
            Solid::Pedestrian(index) => {
                let (old, new) = (&before.pedestrians[index], &after.pedestrians[index]);
                Footprint { centre: old.position.lerp(&new.position, part), ..Footprint::from(old) }
            }
            Solid::Box(index) => Footprint::from(&boxes[index]),
        }
    };
    let fastest = |solid: Solid| match solid {
        Solid::Vehicle(index) => {
            let (car, next) = (&before.vehicles[index], &after.vehicles[index].motion);
            let (from, to) = (car.motion.travelled, next.travelled);
            if let Some(steered) = &after.vehicles[index].steered {
                let ((centre, heading), radius) = (car.pose(), libm::hypot(car.length, car.width) / 2.0);
                // A chord that is turned evenly: twice what it comes to is more than it ever does.
                let turned = 2.0 * (steered.heading - heading).norm() * radius;
                return ((steered.centre - centre).norm() + turned) / duration;
            }
            (to - from) / duration * car.path.most_moved((from, to), (car.length, car.width))
        }
        Solid::Pedestrian(index) => {
            (after.pedestrians[index].position - before.pedestrians[index].position).norm() / duration
        }
        Solid::Box(_) => 0.0,
    };
    let gap = |time: f64| gap_between(&outline(first, time), &outline(second, time));
    closes(gap, |_| f64::NEG_INFINITY, fastest(first) + fastest(second), (0.0, duration), LEAST_IN_STEP, None)
}

/// Whether a body turns between two states.
pub(super) fn turns(solid: Solid, before: &Snapshot, after: &Snapshot) -> bool {
    let Solid::Vehicle(index) = solid else { return false };
    let (car, next) = (&before.vehicles[index], &after.vehicles[index].motion);
    if let Some(steered) = &after.vehicles[index].steered {
        return steered.heading != car.heading();
    }
    car.path.tightest_between(car.motion.travelled, next.travelled) > 0.0
}

/// The first and the last place (m) of a path at which a vehicle of this size (length, width) touches an outline that lies abreast
/// of `place`; `None` for both if it passes beside it. Where it is `known` to touch something from one place to another, only what is
/// before or behind that is looked for.
pub(crate) fn touched_between(
    path: &Path,
    size: (f64, f64),
    outline: &Footprint,
    place: f64,
    known: Option<(f64, f64)>,
) -> (Option<f64>, Option<f64>) {
    let diagonal = libm::hypot(size.0, size.1);
    let (low, high) = (place - diagonal - outline.radius(), place + diagonal + outline.radius());
    let (fastest, rough) = (path.most_moved((low, high), size), roughness(path, size));
    // Inwards from where it cannot touch, no farther than what is left between the two; backwards in places that are counted backwards.
    let touched = |from: f64, to: f64| {
        let sign = (to - from).signum();
        let gap = |place: f64| gap_between(&vehicle_at(path, sign * place, size), outline);
        let roughly = |place: f64| gap_between(&roughly_at(path, sign * place, size), outline) - rough;
        closes(gap, roughly, fastest, (sign * from, sign * to), LEAST_WAY, None).map(|place| sign * place)
    };
    match known {
        None => {
            let Some(first) = touched(low, high) else { return (None, None) };
            (Some(first), Some(touched(high, first).unwrap_or(first)))
        }
        Some((from, to)) => (
            if low < from { touched(low, from.min(high)) } else { None },
            if high > to { touched(high, to.max(low)) } else { None },
        ),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use proptest::prelude::*;
    use scenario::Direction;
    use scenario::agent::Longitudinal;
    use scenario::geometry::{CurvedPath, Piece, Pose, ReferenceLine};

    use super::*;

    /// 30 m of line, a turn of Euro NCAP with a radius of 9 m, and a line again.
    fn turn() -> Path {
        let [one, arc, other] = Piece::turn(1500.0, 9.0, 0.36, 0.85);
        let pieces = [Piece::line(30.0), one, arc, other, Piece::line(20.0)];
        let line = ReferenceLine::new(Pose::origin(), &pieces).unwrap();
        Path::curved(CurvedPath::new(Arc::new(line), 0.0, Direction::Forward, 30.0).unwrap())
    }

    fn car(travelled: f64, speed: f64) -> VehicleState {
        let motion = Longitudinal { travelled, speed, acceleration: 0.0 };
        VehicleState::new(turn(), motion, (4.36, 1.82))
    }

    fn person(position: Vector2<f64>, velocity: Vector2<f64>, disc: bool) -> PedestrianState {
        let shape =
            if disc { Shape::Disc { radius: 0.25 } } else { Shape::Rectangle { length: 0.6, width: 0.5 } };
        let heading = velocity.try_normalize(1e-9).unwrap_or_else(Vector2::x);
        PedestrianState { position, velocity, acceleration: Vector2::zeros(), heading, shape, present: true }
    }

    proptest! {
        #[test]
        fn the_time_to_a_contact_in_a_turn_is_what_looking_every_millisecond_finds(
            travelled in -15.0..25.0, speed in 0.5..8.0, place in -2.0..30.0, beside in -5.0..5.0,
            walk in 0.0..2.0, way in 0.0..6.3, disc: bool,
        ) {
            let car = car(travelled, speed);
            let at = car.path.to_world(Vector2::new(place, beside));
            let person = person(at, Vector2::new(libm::cos(way), libm::sin(way)) * walk, disc);
            let gap = |time: f64| {
                let mut then = car.clone();
                then.motion.travelled += speed * time;
                let moved = PedestrianState { position: at + person.velocity * time, ..person };
                crate::geometry::distance(&then, &moved)
            };
            let looked = (0..=10_000).map(|step| f64::from(step) * 1e-3).find(|time| gap(*time) == 0.0);
            match (contact_with(&car, &person), looked) {
                (Some(found), Some(looked)) => prop_assert!((looked - found).abs() < 2e-3, "{found}, not {looked}"),
                // What is seen for no longer than a few looks is a graze.
                (None, Some(time)) => prop_assert!(gap(time + 4e-3) > 0.0, "missed one at {time} s"),
                (Some(found), None) => {
                    prop_assert!(found >= 10.0 || gap(found + 4e-3) > 0.0 || gap(found) < 1e-6, "{found} s is none");
                }
                (None, None) => {}
            }
            if let Some(found) = contact_with(&car, &person) {
                prop_assert!(gap(found) < 1e-6, "{} m apart then", gap(found));
            }
        }
    }

    #[test]
    fn the_time_to_a_contact_goes_on_where_the_turn_begins() {
        // Somebody who stands in the lane behind the turn: what the car has driven is gone from it, nothing else.
        let standing = person(turn().to_world(Vector2::new(12.0, 0.2)), Vector2::zeros(), true);
        let of = |travelled: f64| contact_with(&car(travelled, 4.0), &standing).unwrap();
        for step in -300..300 {
            let place = f64::from(step) * 0.01;
            let (one, next) = (of(place), of(place + 0.01));
            assert!((one - next - 0.01 / 4.0).abs() < 1e-6, "{one} s and {next} s from {place} m");
        }
        // A standing car touches nothing, and one beside whom somebody walks by is walked into as on a straight road.
        assert_eq!(contact_with(&car(0.0, 0.0), &standing), None);
    }

    #[test]
    fn places_at_which_it_touches_are_the_outermost() {
        let path = turn();
        let outline =
            Footprint::from(&person(path.to_world(Vector2::new(7.0, -0.8)), Vector2::zeros(), false));
        let (first, last) = touched_between(&path, (4.36, 1.82), &outline, 7.0, None);
        let (first, last) = (first.unwrap(), last.unwrap());
        let touches =
            |place: f64| crate::geometry::apart(&vehicle_at(&path, place, (4.36, 1.82)), &outline) == 0.0;
        let looked: Vec<f64> =
            (0..20_000).map(|step| f64::from(step) * 1e-3 - 5.0).filter(|at| touches(*at)).collect();
        assert!((looked[0] - first).abs() < 2e-3, "{first}, not {}", looked[0]);
        assert!((looked[looked.len() - 1] - last).abs() < 2e-3, "{last}, not {}", looked[looked.len() - 1]);
        let beside = Footprint::from(&person(path.to_world(Vector2::new(7.0, 3.0)), Vector2::zeros(), false));
        assert_eq!(touched_between(&path, (4.36, 1.82), &beside, 7.0, None), (None, None));
        // What is known is not looked for again, what is beyond it is found as ever.
        let again = |known| touched_between(&path, (4.36, 1.82), &outline, 7.0, Some(known));
        assert_eq!(again((first - 0.1, last + 0.1)), (None, None));
        let (one, other) = again((first + 0.5, last - 0.5));
        assert!((one.unwrap() - first).abs() < 1e-9 && (other.unwrap() - last).abs() < 1e-9);
    }
}
