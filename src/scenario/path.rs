//! The path that a vehicle follows: the one place that knows what it looks like in the plane.
//!
//! Places along a path are metres behind the middle of the crossing. Every path is straight: the centre line of a lane, in
//! its direction of travel.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::conflict::Conflict;
use super::{Direction, Road, Side};

/// The path that a vehicle's centre follows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// Of the lane's centre line in the world frame, m.
    #[serde(rename = "lane_centre")]
    y: f64,
    direction: Direction,
}

impl Path {
    /// The centre line of a lane that lies at world `y` (m).
    pub fn straight(y: f64, direction: Direction) -> Self {
        Self { y, direction }
    }

    fn sign(&self) -> f64 {
        self.direction.sign()
    }

    /// The point at a place, in the world frame.
    pub fn point(&self, place: f64) -> Vector2<f64> {
        Vector2::new(self.sign() * place, self.y)
    }

    /// The velocity (m/s, world frame) of whoever follows it at `speed`.
    pub fn velocity(&self, speed: f64) -> Vector2<f64> {
        Vector2::new(self.sign() * speed, 0.0)
    }

    /// Unit vector in the direction of travel.
    pub fn heading(&self) -> Vector2<f64> {
        Vector2::new(self.sign(), 0.0)
    }

    /// A vector of the world frame as whoever follows the path sees it: x ahead, y to the left. The other way round it is
    /// the same.
    pub fn turned(&self, vector: Vector2<f64>) -> Vector2<f64> {
        vector * self.sign()
    }

    /// The place abreast of a point.
    pub fn along(&self, point: Vector2<f64>) -> f64 {
        self.sign() * point.x
    }

    /// How fast the place abreast of somebody moves who moves at `velocity`, m/s.
    pub fn speed_along(&self, velocity: Vector2<f64>) -> f64 {
        self.sign() * velocity.x
    }

    /// The place abreast of a point, and how far that is to the left of the path, m.
    pub fn from_world(&self, point: Vector2<f64>) -> Vector2<f64> {
        Vector2::new(self.sign() * point.x, self.sign() * (point.y - self.y))
    }

    /// How far a point is from the path, m; positive towards the far side of the road.
    pub fn beside(&self, point: Vector2<f64>) -> f64 {
        point.y - self.y
    }

    /// How far somebody who crosses from `side` is beyond the path, m; negative before it.
    pub fn beyond(&self, point: Vector2<f64>, side: Side) -> f64 {
        side.walking_sign() * (point.y - self.y)
    }

    /// The place at which the line across the road at world `x` (m) meets it.
    pub fn at_line(&self, x: f64) -> f64 {
        self.sign() * x
    }

    /// The share of the way from one point to another after which it meets the path, if it does.
    pub fn passed_between(&self, from: Vector2<f64>, to: Vector2<f64>) -> Option<f64> {
        let reached =
            |from: f64, to: f64, line: f64| (from < line && to >= line).then(|| (line - from) / (to - from));
        reached(from.y, to.y, self.y).or_else(|| reached(-from.y, -to.y, -self.y))
    }

    /// Distance in m that a way from one point to another, or its continuation, takes to the edge of the lane of width
    /// `lane_width` (m) that somebody who crosses from `side` leaves it by; `None` if it does not lead there.
    pub fn way_to_far_edge(
        &self,
        (from, to): (Vector2<f64>, Vector2<f64>),
        side: Side,
        lane_width: f64,
    ) -> Option<f64> {
        let edge = self.y + side.walking_sign() * lane_width / 2.0;
        let (across, sideways) = (to.y - from.y, to.x - from.x);
        let part = (edge - from.y) / across;
        (part.is_finite() && part >= 0.0).then(|| part * libm::hypot(across, sideways))
    }

    /// y (m) of the kerb to the right and of that to the left of the path, seen from it.
    pub fn kerbs(&self, road: &Road) -> (f64, f64) {
        let (near, far) = (road.kerb(Side::Near) - self.y, road.kerb(Side::Far) - self.y);
        match self.direction {
            Direction::Forward => (near, far),
            Direction::Backward => (-far, -near),
        }
    }

    /// Where the straight way from `from` (world frame, m) along the unit vector `way` meets it; `None` if it runs along it.
    pub fn conflict(&self, from: Vector2<f64>, way: Vector2<f64>) -> Option<Conflict> {
        // Walking along the road never crosses the lane.
        if way.y == 0.0 {
            return None;
        }
        let distance = (self.y - from.y) / way.y;
        Some(Conflict { place: self.sign() * (from.x + way.x * distance), distance })
    }

    /// The point at which the straight way from one point to another meets it, if it does.
    pub fn met_between(&self, from: Vector2<f64>, to: Vector2<f64>) -> Option<Vector2<f64>> {
        let part = (self.y - from.y) / (to.y - from.y);
        (0.0..=1.0).contains(&part).then(|| Vector2::new(from.x + part * (to.x - from.x), self.y))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn path(y: f64, backward: bool) -> Path {
        Path::straight(y, if backward { Direction::Backward } else { Direction::Forward })
    }

    proptest! {
        #[test]
        fn a_place_is_found_again(y in -10.0..10.0, backward: bool, place in -1e3..1e3) {
            let path = path(y, backward);
            let point = path.point(place);
            prop_assert_eq!(path.along(point), place);
            prop_assert_eq!((path.beside(point), path.from_world(point).y), (0.0, 0.0));
            prop_assert_eq!(path.velocity(3.0), path.heading() * 3.0);
            prop_assert_eq!(path.speed_along(path.velocity(3.0)), 3.0);
            let offset = Vector2::new(place, y);
            prop_assert_eq!(path.turned(path.turned(offset)), offset);
        }

        #[test]
        fn where_a_way_meets_it_both_are(
            y in -10.0..10.0, backward: bool, x in -50.0..50.0, from in -10.0..10.0, turn in 0.1..3.0,
        ) {
            let path = path(y, backward);
            let (from, way) = (Vector2::new(x, from), Vector2::new(libm::cos(turn), libm::sin(turn)));
            let conflict = path.conflict(from, way).unwrap();
            let met = from + way * conflict.distance;
            prop_assert!((path.point(conflict.place) - met).norm() < 1e-9 * (1.0 + met.norm()));
            // Turning round changes the sign of the distance and nothing else.
            let back = path.conflict(from, -way).unwrap();
            prop_assert_eq!((back.place, back.distance), (conflict.place, -conflict.distance));
            // A walk beyond it passes it once, there, whichever way.
            let to = met + way * conflict.distance;
            let share = path.passed_between(from, to);
            if conflict.distance.abs() > 1e-6 {
                prop_assert!((share.unwrap() - 0.5).abs() < 1e-6);
                prop_assert!((path.met_between(from, to).unwrap() - met).norm() < 1e-6);
                for side in [Side::Near, Side::Far] {
                    prop_assert!(path.beyond(from, side) * path.beyond(to, side) < 0.0);
                }
            }
        }
    }

    #[test]
    fn along_it_nobody_meets_it() {
        let path = path(2.0, true);
        assert_eq!(path.conflict(Vector2::new(1.0, 0.0), Vector2::x()), None);
        assert_eq!(path.passed_between(Vector2::new(1.0, 0.0), Vector2::new(9.0, 0.0)), None);
        assert_eq!(path.met_between(Vector2::new(1.0, 0.0), Vector2::new(9.0, 1.0)), None);
        let way = (Vector2::new(0.0, 0.0), Vector2::new(3.0, 4.0));
        assert_eq!(path.way_to_far_edge(way, Side::Near, 4.0), Some(5.0));
        assert_eq!(path.way_to_far_edge((way.1, way.0), Side::Near, 4.0), Some(0.0));
        assert_eq!(path.way_to_far_edge((way.0, Vector2::x()), Side::Near, 4.0), None);
    }

    #[test]
    fn kerbs_are_seen_from_it() {
        let road = Road::zebra(&[Direction::Forward, Direction::Backward], 10.0);
        assert_eq!(road.path(0).kerbs(&road), (-2.0, 6.0));
        assert_eq!(road.path(1).kerbs(&road), (-2.0, 6.0));
        assert_eq!((road.outer_lane_centre(Side::Near), road.outer_lane_centre(Side::Far)), (0.0, 4.0));
    }
}
