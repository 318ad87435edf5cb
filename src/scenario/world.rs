//! On which of a world's roads somebody drives, and how they cross each other's ways.

use nalgebra::Vector2;

use super::{CROSSES, Path, PedestrianSetup, Road, Side, VehicleSetup, World};

impl World {
    /// All of its roads: the one that its places are measured on, and those that lie over it.
    pub fn roads(&self) -> impl Iterator<Item = &Road> {
        std::iter::once(&self.road).chain(&self.other_roads)
    }

    /// The road that a vehicle drives on.
    ///
    /// # Panics
    /// If the world does not have it.
    pub fn road_of(&self, setup: &VehicleSetup) -> &Road {
        match setup.road.checked_sub(1) {
            None => &self.road,
            Some(other) => &self.other_roads[other],
        }
    }

    /// Where a vehicle drives.
    ///
    /// # Panics
    /// If the world does not have its road.
    pub fn path_of(&self, setup: &VehicleSetup) -> Path {
        setup.path(self.road_of(setup))
    }

    /// The side of a vehicle's lane that somebody comes from who crosses it, in the sense of the vehicle's road; `None` of who does not
    /// cross it.
    pub fn crosses_from(&self, person: &PedestrianSetup, vehicle: &VehicleSetup) -> Option<Side> {
        if vehicle.road == 0 {
            return person.crosses(&self.road).then_some(person.side);
        }
        let (start, goal) = (Vector2::from(person.start), Vector2::from(person.goal));
        let (path, way) = (self.path_of(vehicle), (goal - start).try_normalize(0.0)?);
        let met = path.met_between(start, goal)?;
        let sine = path.heading(path.along(met)).perp(&way);
        let near = if path.locate(start).beside < 0.0 { Side::Near } else { Side::Far };
        (sine.abs() >= CROSSES).then_some(near)
    }
}
