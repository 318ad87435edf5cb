//! The ground of a road: how steep it is and how well tyres hold on it.

use serde::{Deserialize, Serialize};

use super::agent::Longitudinal;
use super::{Direction, Expression, Origin};

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;

/// What a road's ground does to vehicles, in a direction: that of lane 0 in a [`Road`](super::Road).
///
/// A vehicle whose dynamics give it the acceleration `a` is accelerated by `clamp(a, -μ g, μ g) - g sin(atan(gradient))`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Ground {
    /// Rise per metre of the level, positive uphill; `None`: nobody says, so level.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient: Option<f64>,
    /// Coefficient of friction μ between tyres and road; `None`: nobody says, so vehicles are limited by their dynamics alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
}

impl Ground {
    /// Whether nothing is said of it.
    pub fn is_unsaid(&self) -> bool {
        *self == Self::default()
    }

    /// As whoever drives in `direction` finds it.
    pub fn towards(&self, direction: Direction) -> Self {
        Self { gradient: self.gradient.map(|gradient| direction.sign() * gradient), ..*self }
    }

    /// The largest acceleration and deceleration that tyres transmit, m/s²; infinite if nobody says.
    pub fn grip(&self) -> f64 {
        self.friction.map_or(f64::INFINITY, |friction| friction * GRAVITY)
    }

    /// What gravity takes from the acceleration, m/s²; negative downhill.
    pub fn slope(&self) -> f64 {
        // sin(atan(x))
        self.gradient.map_or(0.0, |gradient| GRAVITY * gradient / libm::sqrt(1.0 + gradient * gradient))
    }

    /// Moves a vehicle on by `step` s on it whose dynamics give it an acceleration (m/s²) all the while.
    ///
    /// One that stands is held by its brake until its dynamics accelerate it by more than gravity takes: it rolls neither back nor off.
    pub fn accelerate(&self, motion: &mut Longitudinal, acceleration: f64, step: f64) {
        if motion.speed == 0.0 && acceleration <= 0.0 {
            motion.acceleration = 0.0;
            return;
        }
        let grip = self.grip();
        motion.accelerate(acceleration.clamp(-grip, grip) - self.slope(), step);
    }
}

/// The ground of a road as it is declared: its numbers may still depend on variations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeclaredGround {
    /// Rise per metre along lane 0, positive uphill.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient: Option<Expression>,
    /// Coefficient of friction between tyres and road.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Expression>,
    /// Where the first of them is said.
    pub origin: Origin,
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn moving(speed: f64) -> Longitudinal {
        Longitudinal { travelled: 0.0, speed, acceleration: 0.0 }
    }

    fn ground(gradient: f64, friction: f64) -> Ground {
        Ground { gradient: Some(gradient), friction: Some(friction) }
    }

    #[test]
    fn gravity_pulls_by_the_sine_of_the_slope() {
        for gradient in [-0.3, -0.05, 0.0, 0.05, 0.3] {
            let expected = GRAVITY * libm::sin(libm::atan(gradient));
            assert!((ground(gradient, 1.0).slope() - expected).abs() < 1e-14);
        }
        assert_eq!((Ground::default().slope(), Ground::default().grip()), (0.0, f64::INFINITY));
        assert_eq!(ground(0.05, 0.5).grip(), 4.903325);
    }

    #[test]
    fn whoever_stands_is_held_until_it_pulls_more_than_gravity() {
        let after = |gradient: f64, acceleration: f64| {
            let mut motion = moving(0.0);
            ground(gradient, 0.5).accelerate(&mut motion, acceleration, 1.0);
            motion.speed
        };
        let slope = ground(0.1, 0.5).slope();
        // Uphill and downhill, braking and doing nothing.
        for gradient in [-0.1, 0.1] {
            assert_eq!([-3.0, 0.0].map(|acceleration| after(gradient, acceleration)), [0.0, 0.0]);
        }
        assert_eq!(after(0.1, 0.9 * slope), 0.0);
        assert!((after(0.1, 1.5 * slope) - 0.5 * slope).abs() < 1e-12);
        assert!((after(-0.1, 0.5) - 0.5 - slope).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn what_is_not_needed_changes_nothing(
            speed in 0.0..30.0, acceleration in -9.0..9.0, step in 0.001..0.2, friction in 0.92..1.5,
        ) {
            let (mut level, mut plain) = (moving(speed), moving(speed));
            ground(0.0, friction).accelerate(&mut level, acceleration, step);
            plain.accelerate(acceleration, step);
            prop_assert_eq!(level, plain);
        }

        #[test]
        fn the_other_way_up_is_down(gradient in -0.3..0.3, friction in 0.05..1.5) {
            let road = ground(gradient, friction);
            prop_assert_eq!(road.towards(Direction::Forward), road);
            prop_assert_eq!(road.towards(Direction::Backward), ground(-gradient, friction));
            prop_assert_eq!(road.towards(Direction::Backward).slope(), -road.slope());
        }
    }
}
