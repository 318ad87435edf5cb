//! When pedestrians that are there may go. Until then they stand where they are, whatever their models want, and look.

use super::change::TIME_TOLERANCE;
use super::contact::Touch;
use super::solid::Solid;
use super::start::{PastArrival, met_by_vehicle};
use scenario::agent::Snapshot;
use scenario::{MayGo, World};

/// The permissions of the pedestrians of a world.
pub(super) struct Permissions {
    each: Vec<Permission>,
    may_go: Vec<bool>,
}

#[derive(Clone, Copy)]
struct Permission {
    /// The place at which the pedestrian meets the path of the vehicle that it waits for, m; 0 if it waits for none.
    place: f64,
    /// When the pedestrian appeared, s.
    appeared: Option<f64>,
    /// Whether a vehicle touched it while it waited.
    touched: bool,
}

impl Permissions {
    /// `None` where all pedestrians may go at once.
    pub fn new(world: &World) -> Option<Self> {
        let of = |setup: &scenario::PedestrianSetup| {
            let place = match setup.may_go {
                MayGo::TimeToArrival { vehicle, .. } => met_by_vehicle(world, setup, vehicle),
                MayGo::AtOnce | MayGo::After(_) => 0.0,
            };
            Permission { place, appeared: None, touched: false }
        };
        let may_go: Vec<_> = world.pedestrians.iter().map(|setup| setup.may_go == MayGo::AtOnce).collect();
        let waits = may_go.contains(&false);
        waits.then(|| Self { each: world.pedestrians.iter().map(of).collect(), may_go })
    }

    /// Which pedestrians may go, once they are there.
    pub fn may_go(&self) -> &[bool] {
        &self.may_go
    }

    /// Lets pedestrians go whose moment has come at `time`, s; the first whose time to arrival is past by more than a step when it appears.
    pub fn update(&mut self, world: &World, now: &Snapshot, time: f64) -> Option<PastArrival> {
        let mut past = None;
        let people = world.pedestrians.iter().zip(&now.pedestrians).enumerate();
        for (pedestrian, (setup, state)) in people {
            let (permission, may_go) = (&mut self.each[pedestrian], &mut self.may_go[pedestrian]);
            if *may_go || !state.present {
                continue;
            }
            let appears = permission.appeared.is_none();
            let waited = time - *permission.appeared.get_or_insert(time);
            *may_go = waited >= setup.may_go.longest() - TIME_TOLERANCE;
            if let MayGo::TimeToArrival { vehicle, reference, time: wanted, .. } = setup.may_go {
                let left = now.vehicles[vehicle].time_to_arrival(permission.place, reference);
                if appears && left < wanted - world.step {
                    past.get_or_insert(PastArrival { pedestrian, vehicle, wanted, left, to_go: true });
                }
                *may_go |= left <= wanted + TIME_TOLERANCE;
            }
        }
        past
    }

    /// Notes which pedestrians vehicles touch.
    pub fn note_touches(&mut self, touches: &[Touch]) {
        for touch in touches {
            if let (Solid::Vehicle(_), Solid::Pedestrian(pedestrian)) = (touch.first, touch.second) {
                self.each[pedestrian].touched = true;
            }
        }
    }

    /// The first pedestrian that is there, could not go and was not touched, with the moment (s) at which it could have gone at the latest.
    pub fn never(&self, world: &World) -> Option<(usize, f64)> {
        let waits = |pedestrian: &usize| !self.may_go[*pedestrian] && !self.each[*pedestrian].touched;
        let mut waiting = (0..self.each.len()).filter(waits);
        waiting.find_map(|pedestrian| {
            let latest = self.each[pedestrian].appeared? + world.pedestrians[pedestrian].may_go.longest();
            Some((pedestrian, latest))
        })
    }
}
