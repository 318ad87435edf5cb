//! How road users come to a conflict, each along its own path.

use nalgebra::Vector2;

use super::agent::{PedestrianState, SeenPedestrian, VehicleState};
use super::conflict::Conflict;

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
