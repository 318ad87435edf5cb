//! Where a vehicle is that its controller steers: beside its path, and at an angle to it.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// A vehicle whose controller has answered a curvature. It is where it was steered to, whatever its path.
///
/// Its pose turns about its rear axle, as that of the kinematic bicycle model does.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Steered {
    /// Its centre in the world frame, m.
    pub centre: Vector2<f64>,
    /// Unit vector in which it points.
    pub heading: Vector2<f64>,
    /// How far its rear axle is behind its centre, and its front axle ahead of it, m.
    pub axle: f64,
    /// Of the front wheels, to the left, rad.
    pub steering_angle: f64,
    /// Of the way of its rear axle, to the left, 1/m: what the steering angle makes, but for what the tyres do not hold.
    pub curvature: f64,
    /// How far the point that would follow the path (the centre, or what the vehicle says) is to the left of it, in the direction of
    /// travel, m.
    pub offset: f64,
    /// From the direction of the path there to that of the vehicle, to the left, rad.
    pub heading_error: f64,
}

impl Steered {
    /// In the world frame, at this speed (m/s) of the rear axle, m/s.
    #[inline]
    pub fn velocity(&self, speed: f64) -> Vector2<f64> {
        (self.heading + self.left() * (self.axle * self.curvature)) * speed
    }

    /// Unit vector to its left.
    #[inline]
    pub fn left(&self) -> Vector2<f64> {
        Vector2::new(-self.heading.y, self.heading.x)
    }

    /// A vector of the world frame as it is seen from the vehicle: x ahead, y to the left.
    #[inline]
    pub fn turned(&self, vector: Vector2<f64>) -> Vector2<f64> {
        Vector2::new(vector.dot(&self.heading), self.heading.perp(&vector))
    }

    /// The other way round.
    #[inline]
    pub fn turned_back(&self, vector: Vector2<f64>) -> Vector2<f64> {
        self.heading * vector.x + self.left() * vector.y
    }

    /// Where it is after a `part` of the way from here to where it is `after`: on the chord, and turned evenly. Within a step of
    /// 25 ms and 1 g to the side that is 0.8 mm from where it is.
    pub fn between(&self, after: &Self, part: f64) -> Self {
        let mix = |from: f64, to: f64| from + part * (to - from);
        Self {
            centre: self.centre.lerp(&after.centre, part),
            heading: self.heading.lerp(&after.heading, part).try_normalize(0.0).unwrap_or(after.heading),
            axle: after.axle,
            steering_angle: mix(self.steering_angle, after.steering_angle),
            curvature: mix(self.curvature, after.curvature),
            offset: mix(self.offset, after.offset),
            heading_error: mix(self.heading_error, after.heading_error),
        }
    }
}
