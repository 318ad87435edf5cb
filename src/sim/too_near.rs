//! Pedestrians that begin a way so near to a lane that waiting there is not an option for their model.

use nalgebra::Vector2;

use super::start::{beginning, is_to_come};
use scenario::agent::VehicleState;
use scenario::{PedestrianSetup, World, half_extent};

/// Distances that differ by less are the same, m.
const ROUNDING: f64 = 1e-9;

/// A pedestrian that begins a leg of its way nearer to the centre of a lane than its model can wait.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TooNear {
    /// Index into [`World::pedestrians`].
    pub pedestrian: usize,
    /// Index into [`World::vehicles`]: the one that needs the most room.
    pub vehicle: usize,
    /// 0 at the start, else the number of the refuge on its way.
    pub refuge: usize,
    /// From where it stands to the centre of the vehicle's lane, along its way, m.
    pub distance: f64,
    /// From where on its model can wait, m: half of both bodies and [`Self::margin`].
    pub needed: f64,
    /// What the model keeps from where bodies can meet, m.
    pub margin: f64,
    /// The setting that says so.
    pub setting: &'static str,
}

impl TooNear {
    /// By how much it is too near, m.
    pub fn missing(&self) -> f64 {
        self.needed - self.distance
    }
}

/// Every place from which a pedestrian of the world sets out that is too near to a lane for waiting, with the vehicle that needs the most
/// room there. Vehicles that stand for ever are left out, and so are pedestrians that walk along a lane.
pub fn too_near(world: &World) -> Vec<TooNear> {
    if world.pedestrians.iter().all(|setup| setup.keeps_off().is_none()) {
        return Vec::new();
    }
    let cars = beginning(world).vehicles;
    let people = 0..world.pedestrians.len();
    people.flat_map(|pedestrian| of_pedestrian(world, &cars, pedestrian)).collect()
}

fn of_pedestrian(world: &World, cars: &[VehicleState], pedestrian: usize) -> Vec<TooNear> {
    let setup = &world.pedestrians[pedestrian];
    let (start, goal) = (Vector2::from(setup.start), Vector2::from(setup.goal));
    let (Some((setting, margin)), Some(way)) = (setup.keeps_off(), (goal - start).try_normalize(0.0)) else {
        return Vec::new();
    };
    if setup.follows.is_some() {
        return Vec::new();
    }
    let to_come = |(vehicle, car): &(usize, &VehicleState)| is_to_come(&world.vehicles[*vehicle], car, setup);
    let nearest = |(refuge, from): (usize, Vector2<f64>)| {
        let ends = setup.stops.get(refuge).map_or(goal, |stop| Vector2::from(*stop));
        let leg = (ends - from).dot(&way);
        let each = cars.iter().enumerate().filter(to_come).filter_map(|(vehicle, car)| {
            let (distance, half) = conflict(setup, car, (from, way))?;
            let needed = half + margin;
            let is_met = distance <= leg && distance > -half;
            let found = TooNear { pedestrian, vehicle, refuge, distance, needed, margin, setting };
            (is_met && distance < needed - ROUNDING).then_some(found)
        });
        each.max_by(|one, other| one.missing().total_cmp(&other.missing()))
    };
    let begins = std::iter::once(start).chain(setup.stops.iter().map(|stop| Vector2::from(*stop)));
    begins.enumerate().filter_map(nearest).collect()
}

/// From a place to the middle of the conflict with a vehicle, and half of the conflict, along a way (m); `None` where there is none.
fn conflict(
    setup: &PedestrianSetup,
    car: &VehicleState,
    (from, way): (Vector2<f64>, Vector2<f64>),
) -> Option<(f64, f64)> {
    let (body, size) = (setup.shape.extents(), (car.length, car.width));
    if car.path.course().is_none() && way.x == 0.0 {
        return Some((car.path.conflict(from, way)?.distance, half_extent(body, size)));
    }
    let area = car.path.conflict_area((f64::NEG_INFINITY, size), (from, way), body)?;
    Some((area.pedestrian.middle(), area.pedestrian.half()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use scenario::{Declaration, PedestrianModel, Position};
    use std::sync::Arc;

    /// The distances and needs of a pedestrian with a disc of 0.25 m that keeps 1 m off, before a car 2 m wide.
    fn found(start: f64, stops: &[f64]) -> Vec<(usize, f64, f64)> {
        let mut world = fixture::world();
        let setup = &mut world.pedestrians[0];
        let declaration = Declaration::new("person", "It keeps off.");
        let model = PedestrianModel::new(declaration, |_| unreachable!("it is not built"));
        setup.model.model = (&Arc::new(model.keeping_off(|_| ("D_s", 1.0)))).into();
        setup.start = Position { x: 0.0, y: -start };
        setup.stops = stops.iter().map(|y| Position { x: 0.0, y: *y }).collect();
        let tidy = |metres: f64| (metres * 1e6).round() / 1e6;
        too_near(&world).iter().map(|one| (one.refuge, tidy(one.distance), tidy(one.needed))).collect()
    }

    #[test]
    fn a_start_inside_of_half_of_both_bodies_and_the_margin_is_too_near() {
        let width = fixture::world().vehicles[0].width;
        let needed = (0.5 + width) / 2.0 + 1.0;
        assert_eq!(found(needed, &[]), []);
        assert_eq!(found(needed - 0.1, &[]), [(0, needed - 0.1, needed)]);
        // On the other side of the lane it is never met again.
        assert_eq!(found(-needed, &[]), []);
    }

    #[test]
    fn a_leg_that_begins_behind_the_lane_meets_nothing() {
        assert_eq!(found(5.0, &[3.0]), []);
        assert_eq!(found(5.0, &[-1.0]).len(), 1);
    }
}
