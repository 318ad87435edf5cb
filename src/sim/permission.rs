//! When pedestrians that are there may go. Until then they stand where they are, whatever their models want, and look.

use super::change::TIME_TOLERANCE;
use super::start::{PastArrival, met_by_vehicle};
use scenario::agent::Snapshot;
use scenario::{MayGo, World};

/// The permissions of the pedestrians of a world.
pub(super) struct Permissions {
    each: Vec<Permission>,
}

#[derive(Clone, Copy)]
struct Permission {
    /// The place at which the pedestrian meets the path of the vehicle that it waits for, m; 0 if it waits for none.
    place: f64,
    /// When the pedestrian appeared, s.
    appeared: Option<f64>,
    may_go: bool,
}

impl Permissions {
    /// `None` where all pedestrians may go at once.
    pub fn new(world: &World) -> Option<Self> {
        let of = |setup: &scenario::PedestrianSetup| {
            let place = match setup.may_go {
                MayGo::TimeToArrival { vehicle, .. } => met_by_vehicle(world, setup, vehicle),
                MayGo::AtOnce | MayGo::After(_) => 0.0,
            };
            Permission { place, appeared: None, may_go: setup.may_go == MayGo::AtOnce }
        };
        let each: Vec<_> = world.pedestrians.iter().map(of).collect();
        each.iter().any(|permission| !permission.may_go).then_some(Self { each })
    }

    /// Whether a pedestrian may go.
    pub fn may_go(&self, pedestrian: usize) -> bool {
        self.each[pedestrian].may_go
    }

    /// Lets pedestrians go whose moment has come at `time`, s; the first whose time to arrival is past by more than a step when it appears.
    pub fn update(&mut self, world: &World, now: &Snapshot, time: f64) -> Option<PastArrival> {
        let mut past = None;
        let people = world.pedestrians.iter().zip(&now.pedestrians).enumerate();
        for (pedestrian, (setup, state)) in people {
            let permission = &mut self.each[pedestrian];
            if permission.may_go || !state.present {
                continue;
            }
            let appears = permission.appeared.is_none();
            let waited = time - *permission.appeared.get_or_insert(time);
            permission.may_go = waited >= setup.may_go.longest() - TIME_TOLERANCE;
            if let MayGo::TimeToArrival { vehicle, reference, time: wanted, .. } = setup.may_go {
                let left = now.vehicles[vehicle].time_to_arrival(permission.place, reference);
                if appears && left < wanted - world.step {
                    past.get_or_insert(PastArrival { pedestrian, vehicle, wanted, left, to_go: true });
                }
                permission.may_go |= left <= wanted + TIME_TOLERANCE;
            }
        }
        past
    }

    /// The first pedestrian that is there and could not go, with the moment (s) at which it could have at the latest.
    pub fn never(&self, world: &World) -> Option<(usize, f64)> {
        let mut people = world.pedestrians.iter().zip(&self.each).enumerate();
        people.find_map(|(pedestrian, (setup, permission))| {
            let appeared = permission.appeared.filter(|_| !permission.may_go)?;
            Some((pedestrian, appeared + setup.may_go.longest()))
        })
    }
}
