//! What is said along a road and across it, in the plane.

use nalgebra::{Rotation2, Vector2};

use std::sync::Arc;

use super::geometry::{GeometryError, Piece, Pose, ReferenceLine};
use super::{Bend, Body, Position, Road, Side};

/// A road that turns less than this in all does not come back to itself, rad.
const NEVER_BACK: f64 = std::f64::consts::PI;

/// Whether a road comes back to itself is looked at every so many metres, …
const LOOKS: f64 = 1.0;

/// … and so far beyond its ends, m.
const BEYOND: f64 = 100.0;

impl Bend {
    /// That of a road which is at the point of a pose when it is `station` m behind its beginning, and heads there `angle` (rad) to the
    /// left of that.
    ///
    /// # Errors
    /// A piece that is none.
    pub fn through(met: Pose, angle: f64, pieces: &[Piece], station: f64) -> Result<Self, GeometryError> {
        let there = ReferenceLine::new(Pose::origin(), pieces)?.pose(station);
        let heading = met.heading + angle - there.heading;
        let (cosine, sine, way) = (libm::cos(heading), libm::sin(heading), there.point);
        let turned = Vector2::new(cosine * way.x - sine * way.y, sine * way.x + cosine * way.y);
        let start = Pose { point: met.point - turned, heading, curvature: 0.0 };
        Ok(Self { line: Arc::new(ReferenceLine::new(start, pieces)?), crossing: station })
    }
}

impl Road {
    /// Where another road meets the centre line of lane 0: so far along it from the middle of the first crossing, or on a path from its
    /// beginning (m).
    pub fn met_at(&self, at: f64) -> Pose {
        match &self.bend {
            None => Pose { point: Vector2::new(at, 0.0), ..Pose::origin() },
            Some(bend) => bend.line.pose(at),
        }
    }

    /// The point that lies so far along the centre line of lane 0 from the middle of the crossing, and so far to the left of that line, m;
    /// with the road's heading there (rad).
    pub fn placed(&self, along: f64, across: f64) -> (Position, f64) {
        match &self.bend {
            None => (Position { x: along, y: across }, 0.0),
            Some(bend) => {
                let pose = bend.line.pose(bend.crossing + along);
                let point = pose.point + pose.normal() * across;
                (Position { x: point.x, y: point.y }, pose.heading)
            }
        }
    }

    /// Where somebody from a side starts and where they walk to. Straight across the road, at `along`, they start at `from` and walk to `to`,
    /// both to the left of lane 0; turned to their left by an angle (rad), about the point where they meet the centre of the first lane, the
    /// start is as far from there as before and the goal as far across.
    pub fn way(&self, side: Side, along: f64, (from, to): (f64, f64), turned: f64) -> (Position, Position) {
        if turned == 0.0 {
            return (self.placed(along, from).0, self.placed(along, to).0);
        }
        let (centre, sign) = (self.outer_lane_centre(side), side.walking_sign());
        let (pivot, heading) = self.placed(along, centre);
        let way = Rotation2::new(heading + turned) * Vector2::new(0.0, sign);
        let at = |distance: f64| {
            let point = Vector2::from(pivot) + way * distance;
            Position { x: point.x, y: point.y }
        };
        (at(sign * (from - centre)), at(sign * (to - centre) / libm::cos(turned)))
    }

    /// A body that lies at its place along the road and across it, in the plane and turned with the road.
    pub fn turned_body(&self, body: Body) -> Body {
        let (Position { x, y }, heading) = self.placed(body.x, body.y);
        Body { x, y, heading, ..body }
    }

    /// Two stations (m) of a road that comes back to itself, which then lie on each other.
    pub fn comes_back(&self) -> Option<(f64, f64)> {
        let Bend { line, .. } = self.bend.as_ref()?;
        let turned: f64 = line.pieces().map(|piece| (piece.from + piece.to).abs() / 2.0 * piece.length).sum();
        if turned < NEVER_BACK {
            return None;
        }
        let (near, far) = (self.kerb(Side::Near), self.kerb(Side::Far));
        let (from, to) = (-BEYOND, line.length() + BEYOND);
        let looks = ((to - from) / LOOKS).ceil() as usize;
        let station = |look: usize| from + (to - from) * look as f64 / looks as f64;
        let across: Vec<(Vector2<f64>, Vector2<f64>)> = (0..=looks)
            .map(|look| {
                let pose = line.pose(station(look));
                (pose.point + pose.normal() * near, pose.point + pose.normal() * far)
            })
            .collect();
        let lefts = |(one, other): (Vector2<f64>, Vector2<f64>), point: Vector2<f64>| {
            (other - one).perp(&(point - one)) > 0.0
        };
        // Two pieces of the road, each between two lines across it, of which a side of one crosses a side of the other.
        let crosses = |one: (Vector2<f64>, Vector2<f64>), other: (Vector2<f64>, Vector2<f64>)| {
            lefts(one, other.0) != lefts(one, other.1) && lefts(other, one.0) != lefts(other, one.1)
        };
        let line_across = |look: usize| across[look];
        let sides = |look: usize| {
            let (here, next) = (line_across(look), line_across(look + 1));
            [(here.0, next.0), (here.1, next.1)]
        };
        for one in 0..looks {
            for other in one + 2..looks {
                let touch = sides(one).iter().any(|here| {
                    crosses(*here, line_across(other))
                        || sides(other).iter().any(|there| crosses(*here, *there))
                });
                if touch {
                    return Some((station(one), station(other)));
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};
    use std::sync::Arc;

    use super::*;
    use crate::Direction;
    use crate::geometry::{Piece, Pose, ReferenceLine};

    fn road(pieces: &[Piece], crossing: f64) -> Road {
        let line = Arc::new(ReferenceLine::new(Pose::origin(), pieces).unwrap());
        Road { bend: Some(Bend { line, crossing }), ..Road::zebra(&[Direction::Forward], 10.0) }
    }

    fn near(found: Position, x: f64, y: f64) {
        assert!((found.x - x).abs() < 1e-9 && (found.y - y).abs() < 1e-9, "{found:?}, not {x} m and {y} m");
    }

    #[test]
    fn places_turn_with_the_road() {
        // 10 m straight, then a quarter of a circle to the left about (10, 20), then along y from (30, 20) on.
        let road = road(
            &[Piece::line(10.0), Piece::arc(20.0, FRAC_PI_2), Piece::line(30.0)],
            10.0 + 10.0 * PI + 5.0,
        );
        near(road.placed(0.0, 0.0).0, 30.0, 25.0);
        near(road.placed(0.0, 3.0).0, 27.0, 25.0);
        near(road.placed(-5.0 - 10.0 * PI, 3.0).0, 10.0, 3.0);
        // Beyond its ends it goes straight on.
        near(road.placed(-25.0 - 10.0 * PI, -1.0).0, -10.0, -1.0);
        near(road.placed(95.0, 1.0).0, 29.0, 120.0);
        let van = Body { name: String::new(), x: 1.0, y: -3.0, length: 5.0, width: 2.0, heading: 0.0 };
        let placed = road.turned_body(van);
        assert!((placed.x - 33.0).abs() < 1e-9 && (placed.y - 26.0).abs() < 1e-9, "{placed:?}");
        assert!((placed.along() - Vector2::y()).norm() < 1e-9);
    }

    #[test]
    fn a_way_is_turned_about_the_first_lane_to_the_left_of_who_walks_it() {
        let straight = Road::zebra(&[Direction::Forward, Direction::Backward], 10.0);
        // From the near side, whose left is against x; 30° to the left.
        let (start, goal) = straight.way(Side::Near, 1.0, (-6.0, 8.0), PI / 6.0);
        near(start, 1.0 + 3.0, -6.0 * libm::cos(PI / 6.0));
        near(goal, 1.0 - 8.0 * libm::tan(PI / 6.0), 8.0);
        // From the far side, about the far lane at 4 m.
        let (start, goal) = straight.way(Side::Far, 1.0, (10.0, -4.0), PI / 6.0);
        near(start, 1.0 - 3.0, 4.0 + 6.0 * libm::cos(PI / 6.0));
        near(goal, 1.0 + 8.0 * libm::tan(PI / 6.0), -4.0);
        let (start, goal) = straight.way(Side::Near, 1.0, (-6.0, 8.0), 0.0);
        assert_eq!((start, goal), (Position { x: 1.0, y: -6.0 }, Position { x: 1.0, y: 8.0 }));
    }

    #[test]
    fn a_road_that_comes_back_to_itself_is_found() {
        let back = |pieces: &[Piece]| road(pieces, 5.0).comes_back();
        // Round a hairpin and back beside itself: no two places are one.
        assert_eq!(back(&[Piece::line(50.0), Piece::arc(10.0, PI), Piece::line(50.0)]), None);
        // Over three quarters and more of a circle it crosses what it came from.
        let found = back(&[Piece::line(50.0), Piece::arc(10.0, 1.5 * PI), Piece::line(50.0)]);
        assert!(found.is_some_and(|(one, other)| one < 50.0 && other > 90.0), "{found:?}");
        // Two hairpins too near to each other for the lanes.
        let narrow = [Piece::line(50.0), Piece::arc(2.5, 1.02 * PI), Piece::line(50.0)];
        assert!(back(&narrow).is_some());
        // It weaves, but never back.
        assert_eq!(back(&[Piece::arc(20.0, 1.5), Piece::arc(-20.0, 3.0), Piece::arc(20.0, 1.5)]), None);
    }
}
