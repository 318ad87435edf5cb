//! What several meters read off a run in the same way: followed once a step for all of them, and only where one of them asks.

use super::jerk::Jerk;
use super::speed_drop::SpeedDrop;
use crate::Step;

/// What the meters of a run ask to be followed.
#[derive(Debug, Clone, Default)]
pub struct Followed {
    jerks: Vec<Jerk>,
    drops: Vec<SpeedDrop>,
    looks_ahead: bool,
    vehicles: Vec<(usize, usize)>,
}

/// A jerk that is followed.
#[derive(Debug, Clone, Copy)]
pub struct FollowedJerk(usize);

/// A drop of speed that is followed.
#[derive(Debug, Clone, Copy)]
pub struct FollowedDrop(usize);

impl Followed {
    /// The jerk of a vehicle over windows of so many seconds; steps are mostly `step` s.
    pub fn jerk(&mut self, vehicle: usize, window: f64, step: f64) -> FollowedJerk {
        FollowedJerk(known_or(
            &mut self.jerks,
            |one| one.is(vehicle, window),
            || Jerk::new(vehicle, window, step),
        ))
    }

    /// The drop of a vehicle's speed over a window (s), not below standstill (m/s); steps are mostly `step` s.
    pub fn speed_drop(&mut self, vehicle: usize, of: (f64, f64), step: f64) -> FollowedDrop {
        FollowedDrop(known_or(
            &mut self.drops,
            |one| one.is(vehicle, of),
            || SpeedDrop::new(vehicle, of, step),
        ))
    }

    /// Times to collision.
    pub fn look_ahead(&mut self) {
        self.looks_ahead = true;
    }

    /// What two vehicles have to do with each other, in whatever order they are named.
    pub(super) fn vehicle_pair(&mut self, (one, other): (usize, usize)) {
        let pair = (one.min(other), one.max(other));
        if !self.vehicles.contains(&pair) {
            self.vehicles.push(pair);
        }
    }

    pub(super) fn vehicle_pairs(&self) -> &[(usize, usize)] {
        &self.vehicles
    }

    pub(super) fn looks_ahead(&self) -> bool {
        self.looks_ahead
    }

    pub(super) fn observe(&mut self, step: &Step) {
        self.jerks.iter_mut().for_each(|one| one.observe(step));
        self.drops.iter_mut().for_each(|one| one.observe(step));
    }

    pub(super) fn of_jerk(&self, FollowedJerk(index): FollowedJerk) -> &Jerk {
        &self.jerks[index]
    }

    pub(super) fn of_drop(&self, FollowedDrop(index): FollowedDrop) -> &SpeedDrop {
        &self.drops[index]
    }
}

/// The place of the one that is meant, which is added if it is not there.
fn known_or<T>(all: &mut Vec<T>, is_it: impl Fn(&T) -> bool, new: impl FnOnce() -> T) -> usize {
    all.iter().position(is_it).unwrap_or_else(|| {
        all.push(new());
        all.len() - 1
    })
}
