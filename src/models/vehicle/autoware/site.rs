//! The crossing and the ego on one axis: s runs along the lane with 0 at the middle of the crossing.

use sim::Observation;

/// The ego on the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ego {
    /// s of the front bumper, m.
    pub front: f64,
    /// s of the rear end, m.
    pub rear: f64,
    /// m
    pub half_width: f64,
    /// m/s
    pub speed: f64,
    /// m/s²
    pub acceleration: f64,
}

/// The crossing as the map has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site {
    /// The edges are at s = -half_width and s = +half_width, m.
    pub half_width: f64,
    /// y of the kerb on the ego's right, m.
    pub right_kerb: f64,
    /// y of the kerb on the ego's left, m.
    pub left_kerb: f64,
}

impl Ego {
    pub fn of(observation: &Observation) -> Self {
        let ego = &observation.ego;
        let centre = ego.travelled;
        Self {
            front: centre + ego.length / 2.0,
            rear: centre - ego.length / 2.0,
            half_width: ego.width / 2.0,
            speed: ego.speed,
            acceleration: ego.acceleration,
        }
    }
}

impl Site {
    pub fn of(observation: &Observation) -> Self {
        let road = &observation.road;
        Self { half_width: road.crossing_width / 2.0, right_kerb: road.right_kerb, left_kerb: road.left_kerb }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A 4 m wide crossing of a 4 m wide road.
    pub const SITE: Site = Site { half_width: 2.0, right_kerb: -2.0, left_kerb: 2.0 };

    /// The sample vehicle with its front bumper at `front`.
    pub fn ego(front: f64, speed: f64) -> Ego {
        Ego { front, rear: front - 4.89, half_width: 0.948, speed, acceleration: 0.0 }
    }
}
