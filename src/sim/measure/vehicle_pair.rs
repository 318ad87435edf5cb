//! Whether two vehicles had to do with each other in a run.

use super::passage::{Passage, Reached};
use super::presence::{Closeness, MEETING_TIME, Presence, STANDSTILL};
use crate::turning::vehicles_meet;
use crate::{Step, VehicleState, path_conflicts};
use scenario::{PathConflict, World};

/// Follows two vehicles that a criterion names together.
#[derive(Debug, Clone)]
pub struct VehiclePair {
    /// Their indices in the world.
    pub vehicles: (usize, usize),
    /// Where their ways cross.
    conflicts: Vec<PathConflict>,
    /// Half the widths of their lanes, m.
    half_lanes: (f64, f64),
    moved: bool,
    met: bool,
}

impl VehiclePair {
    /// Of two vehicles of a world.
    pub fn new(world: &World, (one, other): (usize, usize)) -> Self {
        let half_lane = |vehicle: usize| world.road_of(&world.vehicles[vehicle]).lane_width / 2.0;
        Self {
            vehicles: (one, other),
            conflicts: path_conflicts(world, one, other),
            half_lanes: (half_lane(one), half_lane(other)),
            moved: false,
            met: false,
        }
    }

    /// Takes a step; `fastest` has the largest speed so far of each vehicle, m/s.
    pub fn observe(&mut self, step: &Step, fastest: &[f64]) {
        let (one, other) = self.vehicles;
        self.moved |= fastest[one].max(fastest[other]) > STANDSTILL;
        if !self.met {
            let (first, second) = (&step.after.vehicles[one], &step.after.vehicles[other]);
            self.met = vehicles_meet(first, second).is_some()
                || is_close_behind(first, second, (self.half_lanes.0, fastest[one]))
                || is_close_behind(second, first, (self.half_lanes.1, fastest[other]));
        }
    }

    /// What came of it at the end; `passages` has that of each vehicle.
    pub fn presence(&self, passages: &[Passage], touched: bool) -> Presence {
        let (one, other) = (&passages[self.vehicles.0], &passages[self.vehicles.1]);
        let entered = |passage: &Passage, place: f64| passage.reached(place) != Reached::NotYet;
        let both_crossed =
            |met: &PathConflict| entered(one, met.first.from) && entered(other, met.second.from);
        let met = self.moved && (self.met || self.conflicts.iter().any(both_crossed));
        let closest = match (touched, met, self.moved) {
            (true, ..) => Closeness::Touched,
            (_, true, _) => Closeness::Met,
            (.., true) => Closeness::Together,
            _ => Closeness::Apart,
        };
        Presence { closest, moved: self.moved, passed: false }
    }
}

/// Whether a vehicle is behind another in its lane, no more than [`MEETING_TIME`] away at the largest speed that it has had.
fn is_close_behind(behind: &VehicleState, ahead: &VehicleState, (half_lane, fastest): (f64, f64)) -> bool {
    let place = behind.path.locate(ahead.pose().0);
    let gap = place.along - behind.motion.travelled - (behind.length + ahead.length) / 2.0;
    !place.ambiguous
        && place.beside.abs() < half_lane
        && place.along >= behind.motion.travelled
        && gap <= fastest * MEETING_TIME
}
