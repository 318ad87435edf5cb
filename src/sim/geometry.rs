//! Footprints in the plane: when they touch and how far apart they are.
//!
//! A vehicle is a rectangle along the road; a pedestrian is a disc or a rectangle along its heading.

use nalgebra::Vector2;

use super::state::{PedestrianState, VehicleState};
use crate::scenario::Shape;

/// Time in s until the footprints first touch if the pedestrian moves at `relative_velocity` (m/s, pedestrian minus
/// vehicle); 0 if they touch now, `None` if they never will.
pub fn first_contact(
    vehicle: &VehicleState,
    pedestrian: &PedestrianState,
    relative_velocity: Vector2<f64>,
) -> Option<f64> {
    let offset = pedestrian.position - vehicle.position();
    let half = Vector2::new(vehicle.length / 2.0, vehicle.width / 2.0);
    match pedestrian.shape {
        Shape::Disc { radius } => {
            // A rectangle rounded by the disc: two rectangles and a circle at each corner.
            let long = box_contact(offset, relative_velocity, half + Vector2::new(radius, 0.0));
            let wide = box_contact(offset, relative_velocity, half + Vector2::new(0.0, radius));
            let corners = CORNERS.map(|corner| {
                circle_contact(offset - half.component_mul(&corner), relative_velocity, radius)
            });
            corners.into_iter().chain([long, wide]).flatten().reduce(f64::min)
        }
        Shape::Rectangle { length, width } => {
            let mut interval = Interval::always();
            for (axis, reach) in separating_axes(half, pedestrian.heading, length, width) {
                interval = interval.within(offset.dot(&axis), relative_velocity.dot(&axis), reach);
            }
            interval.first()
        }
    }
}

/// Smallest distance between the footprints in m; 0 when they touch or overlap.
pub fn distance(vehicle: &VehicleState, pedestrian: &PedestrianState) -> f64 {
    let offset = pedestrian.position - vehicle.position();
    let half = Vector2::new(vehicle.length / 2.0, vehicle.width / 2.0);
    match pedestrian.shape {
        Shape::Disc { radius } => (distance_to_box(offset, half) - radius).max(0.0),
        Shape::Rectangle { length, width } => {
            if first_contact(vehicle, pedestrian, Vector2::zeros()).is_some() {
                return 0.0;
            }
            // The nearest points of two separate rectangles include a corner of one of them.
            let heading = pedestrian.heading;
            let across = Vector2::new(-heading.y, heading.x);
            let own_half = Vector2::new(length / 2.0, width / 2.0);
            let from_corner = |corner: Vector2<f64>| {
                let place = offset + heading * (own_half.x * corner.x) + across * (own_half.y * corner.y);
                distance_to_box(place, half)
            };
            let to_corner = |corner: Vector2<f64>| {
                let place = half.component_mul(&corner) - offset;
                distance_to_box(Vector2::new(place.dot(&heading), place.dot(&across)), own_half)
            };
            CORNERS
                .iter()
                .flat_map(|&corner| [from_corner(corner), to_corner(corner)])
                .fold(f64::INFINITY, f64::min)
        }
    }
}

const CORNERS: [Vector2<f64>; 4] =
    [Vector2::new(1.0, 1.0), Vector2::new(1.0, -1.0), Vector2::new(-1.0, 1.0), Vector2::new(-1.0, -1.0)];

/// The axes on which two rectangles may be separate, with the offset of centres up to which they are not.
fn separating_axes(
    half: Vector2<f64>,
    heading: Vector2<f64>,
    length: f64,
    width: f64,
) -> [(Vector2<f64>, f64); 4] {
    let across = Vector2::new(-heading.y, heading.x);
    [Vector2::x(), Vector2::y(), heading, across].map(|axis| {
        let vehicle = half.x * axis.x.abs() + half.y * axis.y.abs();
        let pedestrian = (length * axis.dot(&heading).abs() + width * axis.dot(&across).abs()) / 2.0;
        (axis, vehicle + pedestrian)
    })
}

/// A stretch of time.
struct Interval {
    from: f64,
    to: f64,
}

impl Interval {
    fn always() -> Self {
        Self { from: f64::NEG_INFINITY, to: f64::INFINITY }
    }

    /// The part during which |offset + speed * t| <= reach.
    fn within(self, offset: f64, speed: f64, reach: f64) -> Self {
        if speed == 0.0 {
            return if offset.abs() <= reach {
                self
            } else {
                Self { from: f64::INFINITY, to: f64::NEG_INFINITY }
            };
        }
        let (enter, leave) = ((-reach - offset) / speed, (reach - offset) / speed);
        Self { from: self.from.max(enter.min(leave)), to: self.to.min(enter.max(leave)) }
    }

    /// Its first moment that is not in the past.
    fn first(self) -> Option<f64> {
        (self.from <= self.to && self.to >= 0.0).then(|| self.from.max(0.0))
    }
}

fn box_contact(offset: Vector2<f64>, velocity: Vector2<f64>, half: Vector2<f64>) -> Option<f64> {
    Interval::always().within(offset.x, velocity.x, half.x).within(offset.y, velocity.y, half.y).first()
}

fn circle_contact(offset: Vector2<f64>, velocity: Vector2<f64>, radius: f64) -> Option<f64> {
    let excess = offset.norm_squared() - radius * radius;
    if excess <= 0.0 {
        return Some(0.0);
    }
    let (a, b) = (velocity.norm_squared(), offset.dot(&velocity));
    let discriminant = b * b - a * excess;
    // Approaching, and near enough: the smaller root in the form that does not cancel.
    (b < 0.0 && discriminant >= 0.0).then(|| excess / (-b + discriminant.sqrt()))
}

fn distance_to_box(offset: Vector2<f64>, half: Vector2<f64>) -> f64 {
    Vector2::new((offset.x.abs() - half.x).max(0.0), (offset.y.abs() - half.y).max(0.0)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Direction;
    use crate::sim::Longitudinal;
    use proptest::prelude::*;

    fn car() -> VehicleState {
        VehicleState {
            motion: Longitudinal { travelled: 0.0, speed: 0.0, acceleration: 0.0 },
            lane_centre: 0.0,
            direction: Direction::Forward,
            length: 4.0,
            width: 2.0,
        }
    }

    fn person(x: f64, y: f64, turn: f64, shape: Shape) -> PedestrianState {
        PedestrianState {
            position: Vector2::new(x, y),
            velocity: Vector2::zeros(),
            acceleration: Vector2::zeros(),
            heading: Vector2::new(libm::cos(turn), libm::sin(turn)),
            shape,
            present: true,
        }
    }

    const DISC: Shape = Shape::Disc { radius: 0.5 };
    const SQUARE: Shape = Shape::Rectangle { length: 1.0, width: 1.0 };

    #[test]
    fn head_on_contact() {
        for shape in [DISC, SQUARE] {
            let ahead = person(10.0, 0.0, 0.0, shape);
            assert_eq!(first_contact(&car(), &ahead, Vector2::new(-5.0, 0.0)), Some(1.5));
            assert_eq!(first_contact(&car(), &ahead, Vector2::new(5.0, 0.0)), None);
            assert_eq!(distance(&car(), &ahead), 7.5);
            assert_eq!(first_contact(&car(), &person(2.2, 1.2, 0.0, shape), Vector2::zeros()), Some(0.0));
        }
    }

    #[test]
    fn a_disc_passes_the_corner_that_a_square_hits() {
        // Along x + y = c, past the corner at (2, 1): the disc reaches 0.5 m, the square half its diagonal.
        let contact =
            |c: f64, shape| first_contact(&car(), &person(c, 0.0, 0.0, shape), Vector2::new(-1.0, 1.0));
        assert!(contact(3.69, DISC).is_some() && contact(3.72, DISC).is_none());
        assert!(contact(3.99, SQUARE).is_some() && contact(4.01, SQUARE).is_none());
    }

    #[test]
    fn a_turned_square_reaches_farther() {
        let turned = person(4.0, 0.0, std::f64::consts::FRAC_PI_4, SQUARE);
        assert!((distance(&car(), &turned) - (2.0 - 0.5 * std::f64::consts::SQRT_2)).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn at_the_contact_time_they_touch(
            x in -8.0..8.0, y in -8.0..8.0, turn in 0.0..6.3, vx in -3.0..3.0, vy in -3.0..3.0, square: bool,
        ) {
            let shape = if square { SQUARE } else { DISC };
            let start = person(x, y, turn, shape);
            let velocity = Vector2::new(vx, vy);
            match first_contact(&car(), &start, velocity) {
                Some(time) if time > 0.0 && time < 100.0 => {
                    let at = |t: f64| { let p = start.position + velocity * t; person(p.x, p.y, turn, shape) };
                    prop_assert!(distance(&car(), &at(time)) < 1e-9);
                    prop_assert!(distance(&car(), &at(time * 0.99)) > 0.0);
                }
                Some(_) => {}
                None => for k in 0..200 {
                    let p = start.position + velocity * (f64::from(k) * 0.05);
                    prop_assert!(distance(&car(), &person(p.x, p.y, turn, shape)) > 0.0);
                },
            }
        }
    }
}
