//! Conflicts: where the way of a person meets the path of a vehicle, and how each comes to it.

use nalgebra::Vector2;

use super::agent::{PedestrianState, SeenPedestrian, VehicleState};

/// Where the straight way of a person meets the path of a vehicle; see [`Path::conflict`](super::Path::conflict).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conflict {
    /// Along the vehicle's path, m behind the middle of the crossing.
    pub place: f64,
    /// From where the person is, along its way, m; negative once past it.
    pub distance: f64,
}

/// How a road user comes to a conflict, along its own path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    /// From its centre to the conflict, m; negative once past it.
    pub distance: f64,
    /// m/s
    pub speed: f64,
    /// m/s²
    pub acceleration: f64,
}

impl Conflict {
    /// How the vehicle comes to it.
    pub fn approach(&self, vehicle: &VehicleState) -> Approach {
        Approach {
            distance: self.place - vehicle.motion.travelled,
            speed: vehicle.motion.speed,
            acceleration: vehicle.motion.acceleration,
        }
    }

    /// How the person comes to it, whose way goes along the unit vector `way`.
    pub fn approach_on_foot(&self, person: &PedestrianState, way: Vector2<f64>) -> Approach {
        Approach {
            distance: self.distance,
            speed: person.velocity.dot(&way),
            acceleration: person.acceleration.dot(&way),
        }
    }
}

impl Approach {
    /// How somebody comes to the path of the vehicle that sees it and means to cross that at a right angle: to the left
    /// (`direction` 1) or to the right (−1). Who walks the other way stands, as far as the conflict goes.
    pub fn seen(person: &SeenPedestrian, direction: f64) -> Self {
        Self {
            distance: -direction * person.position.y,
            speed: (direction * person.velocity.y).max(0.0),
            acceleration: direction * person.acceleration.y,
        }
    }
}

/// Half the length (m) of the conflict along the path of the first of two who meet at a right angle: the length of its own
/// body and the width of the other's, (length, width) each.
pub fn half_extent(own: (f64, f64), other: (f64, f64)) -> f64 {
    (own.0 + other.1) / 2.0
}
