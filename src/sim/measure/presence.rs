//! How close a vehicle and a pedestrian came to a conflict in a run: what a value that was measured of them is worth.

use serde::{Deserialize, Serialize};

use super::events::{half_extent, part_within};
use crate::{PedestrianState, VehicleState};
use scenario::Located;

/// A pedestrian in a vehicle's way has met it if the vehicle is at most so many seconds away at the largest speed that it has had since
/// the pedestrian appeared.
pub const MEETING_TIME: f64 = 5.0;

/// A pedestrian in the way of a vehicle that had moved before they appeared has met it at this distance, too, m: what a car that sets off
/// at 2 m/s² covers in [`MEETING_TIME`].
const MEETING_DISTANCE: f64 = 25.0;

/// At this speed or slower a vehicle stands, m/s: what rounding leaves of a stop is not motion.
pub const STANDSTILL: f64 = 0.01;

/// The most that a vehicle and a pedestrian had to do with each other in a run, from the least to the most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Closeness {
    /// The pedestrian never appeared.
    #[default]
    Absent,
    /// The pedestrian appeared, but the vehicle had left their place behind or had not moved until they were gone.
    Apart,
    /// The pedestrian was there before the rear of the vehicle had left their place behind, and the vehicle had moved.
    Together,
    /// The centre of the vehicle passed the place of the pedestrian while they were there.
    Abreast,
    /// The pedestrian was in the vehicle's lane, or in the strip that its body sweeps.
    InTheWay,
    /// The pedestrian was in the way, and the vehicle no more than [`MEETING_TIME`] away.
    Met,
    /// Their footprints touched.
    Touched,
}

/// What a vehicle and a pedestrian had to do with each other in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Presence {
    /// The most of it.
    pub closest: Closeness,
    /// The vehicle moved while both were together.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub moved: bool,
    /// The centre of the vehicle passed the place of the pedestrian while they were there.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub passed: bool,
}

/// One step of a vehicle and a pedestrian that is there.
pub struct PresenceStep<'a> {
    /// The vehicle at the beginning and at the end of the step.
    pub vehicle: (&'a VehicleState, &'a VehicleState),
    /// The pedestrian at the end.
    pub pedestrian: &'a PedestrianState,
    /// Where the pedestrian is at the beginning and at the end, seen from the vehicle's path.
    pub places: (Located, Located),
    /// Half the width of the vehicle's lane, m.
    pub half_lane: f64,
    /// What the vehicle's body sweeps at the end, as distances beside its path, m.
    pub strip: (f64, f64),
    /// Whether the vehicle has moved in the run by the beginning and by the end of the step.
    pub has_moved: (bool, bool),
    /// Whether the pedestrian may go. Until then a vehicle that passes decides nothing between the two.
    pub may_go: bool,
}

/// Follows the presence of one vehicle and one pedestrian.
#[derive(Debug, Clone, Copy, Default)]
pub struct PresenceMeter {
    presence: Presence,
    /// The largest speed that the vehicle has had at the end of a step since the pedestrian appeared, m/s.
    fastest: f64,
    /// Whether the vehicle had moved before the pedestrian appeared.
    moved_before: bool,
}

impl PresenceMeter {
    /// What was seen so far, but for contacts.
    pub fn presence(&self) -> Presence {
        self.presence
    }

    /// Takes a step in which the pedestrian is there from the beginning.
    pub fn observe(&mut self, step: &PresenceStep) {
        let (before, after) = step.vehicle;
        self.fastest = self.fastest.max(after.motion.speed);
        if self.presence.closest == Closeness::Absent {
            self.moved_before = step.has_moved.0;
        }
        self.reach(Closeness::Apart);
        let (old, new) = step.places;
        // In the middle of a bend the place does not say which part of the way is meant.
        if old.ambiguous || new.ambiguous || !step.has_moved.1 {
            return;
        }
        if self.presence.closest < Closeness::Together {
            let rear = before.motion.travelled - before.length / 2.0;
            if rear > old.along + half_extent(step.pedestrian, &old).x {
                return;
            }
            if step.may_go {
                self.reach(Closeness::Together);
            }
        }
        self.presence.moved |= before.motion.speed.max(after.motion.speed) > STANDSTILL;
        if step.may_go && before.motion.travelled < old.along && after.motion.travelled >= new.along {
            self.presence.passed = true;
            self.reach(Closeness::Abreast);
        }
        if self.presence.closest < Closeness::Met && step.is_in_the_way() {
            let from_standing = if self.moved_before { MEETING_DISTANCE } else { 0.0 };
            let is_near = step.gap() <= from_standing.max(self.fastest * MEETING_TIME);
            self.reach(if is_near { Closeness::Met } else { Closeness::InTheWay });
        }
    }

    fn reach(&mut self, closeness: Closeness) {
        self.presence.closest = self.presence.closest.max(closeness);
    }
}

impl PresenceStep<'_> {
    /// Whether the pedestrian's centre is in the lane or their body in the strip.
    fn is_in_the_way(&self) -> bool {
        let (old, new) = self.places;
        if old.beside.abs() < self.half_lane || new.beside.abs() < self.half_lane {
            return true;
        }
        let (low, high) = self.strip;
        let reach = half_extent(self.pedestrian, &new).y;
        part_within(old.beside, new.beside, (low - reach, high + reach)).is_some()
    }

    /// Between the bodies along the lane, m; negative where they overlap.
    fn gap(&self) -> f64 {
        let (_, place) = self.places;
        let (_, vehicle) = self.vehicle;
        let apart = (place.along - vehicle.motion.travelled).abs();
        apart - vehicle.length / 2.0 - half_extent(self.pedestrian, &place).x
    }
}
