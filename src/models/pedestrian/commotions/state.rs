//! What a road user shows the other: its kind of control, its extent and its state on a straight path (§1).

use scenario::Approach;

/// How the actions of a road user work (§1, §2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Actions change the speed over the action duration: a pedestrian.
    Speed,
    /// Actions change the acceleration, which is then held: a vehicle.
    Acceleration,
}

/// The state of a road user along its own path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Signed distance (m) of the centre to the conflict point: positive while approaching.
    pub distance: f64,
    /// Speed (m/s), never negative.
    pub speed: f64,
    /// Acceleration (m/s²).
    pub acceleration: f64,
}

impl From<Approach> for State {
    fn from(Approach { distance, speed, acceleration }: Approach) -> Self {
        Self { distance, speed, acceleration }
    }
}

impl State {
    /// The state `dt` seconds later with the present acceleration; nobody reverses (§2).
    ///
    /// The order of the operations is the published one, which decides the last bit (§6, knife edge).
    #[inline]
    pub fn step(self, dt: f64) -> Self {
        let (distance, speed) = step(self.distance, self.speed, self.acceleration, dt);
        Self { distance, speed, acceleration: self.acceleration }
    }
}

/// Distance and speed after `dt` seconds of acceleration `acceleration` (§2).
#[inline]
pub fn step(distance: f64, speed: f64, acceleration: f64, dt: f64) -> (f64, f64) {
    let travelled = dt * speed + acceleration * (dt * dt) / 2.0;
    (distance - at_least_zero(travelled), at_least_zero(speed + acceleration * dt))
}

/// The larger of `x` and 0, one instruction where `f64::max` (which must treat NaN) needs several.
#[inline]
pub(super) fn at_least_zero(x: f64) -> f64 {
    if x > 0.0 { x } else { 0.0 }
}

/// What does not change about a road user during an encounter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgentBody {
    /// How its actions work.
    pub control: Control,
    /// Half the length (m) of the conflict space along its own path: (own length + other's width)/2 at a right angle.
    pub half_extent: f64,
    /// Cosine of the angle at which its path meets the other's: 0 at a right angle, above 0 where both go the same way.
    pub cosine: f64,
    /// Width (m), which decides the optical expansion seen by the other.
    pub width: f64,
}

impl AgentBody {
    /// Whether the centre at `distance` is inside the conflict space.
    #[inline]
    pub fn occupies(&self, distance: f64) -> bool {
        distance.abs() < self.half_extent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_reverses() {
        let braking = State { distance: 3.0, speed: 0.1, acceleration: -10.0 };
        let after = braking.step(0.1);
        assert_eq!(after.speed, 0.0);
        assert_eq!(after.distance, 3.0);
    }

    #[test]
    fn kinematics_are_second_order() {
        let after = State { distance: 3.0, speed: 1.0, acceleration: 2.0 }.step(0.1);
        assert!((after.distance - 2.89).abs() < 1e-15);
        assert!((after.speed - 1.2).abs() < 1e-15);
    }
}
