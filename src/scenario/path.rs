//! The path that a vehicle follows: the one place that knows what it looks like in the plane.
//!
//! Places along a path are metres behind the middle of the crossing. A straight path is the centre line of a lane, in its
//! direction of travel; a curved one is a course beside a line that bends.

use std::sync::Arc;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::conflict::Conflict;
use super::geometry::CurvedPath;
use super::{Direction, Position, Side};

/// The path that a vehicle's centre follows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Path(Kind);

/// Straight paths have expressions of their own, so that what is measured on them has the same bits as ever.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
enum Kind {
    Straight {
        /// Of the lane's centre line in the world frame, m.
        #[serde(rename = "lane_centre")]
        y: f64,
        direction: Direction,
    },
    Curved {
        course: Arc<CurvedPath>,
        /// How far the point that follows the course is behind the vehicle's centre, m.
        #[serde(default, skip_serializing_if = "is_zero")]
        behind: f64,
    },
}

fn is_zero(metres: &f64) -> bool {
    *metres == 0.0
}

/// Where a point lies, seen from a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// The place abreast of it, m.
    pub along: f64,
    /// How far it is from the path there, m; positive towards the far side of the road.
    pub beside: f64,
    /// Unit vector in the direction of travel there.
    pub heading: Vector2<f64>,
    /// How far a point that moves along the path moves for each metre of it: less than 1 inside a bend.
    stretch: f64,
    /// 1 where the far side of the road is to the left of the path, −1 where it is to the right.
    far: f64,
    /// Whether the path bends towards it from within its distance, so that the place abreast of it may jump as it moves.
    pub ambiguous: bool,
}

impl Located {
    /// How fast the place abreast of somebody moves who is there and moves at `velocity`, and how fast they come nearer to the
    /// far side of the road, m/s.
    #[inline]
    pub fn speeds(&self, velocity: Vector2<f64>) -> (f64, f64) {
        (velocity.dot(&self.heading) / self.stretch, self.far * self.heading.perp(&velocity))
    }

    /// 1 where the far side of the road is to the left of the path, −1 where it is to the right.
    #[inline]
    pub fn far(&self) -> f64 {
        self.far
    }

    /// How far the point is to the left of the path, in the direction of travel, m.
    #[inline]
    pub fn left(&self) -> f64 {
        self.far * self.beside
    }

    /// Two distances beside the path (m), to its right and to its left, from the near side to the far side of the road: as
    /// [`Self::beside`] counts them.
    #[inline]
    pub fn borders(&self, right: f64, left: f64) -> (f64, f64) {
        if self.far > 0.0 { (-right, left) } else { (-left, right) }
    }

    /// A vector of the world frame as whoever is abreast of it and follows the path sees it: x ahead, y to the left.
    #[inline]
    pub fn turned(&self, vector: Vector2<f64>) -> Vector2<f64> {
        Vector2::new(vector.dot(&self.heading), self.heading.perp(&vector))
    }
}

impl Path {
    /// The centre line of a lane that lies at world `y` (m).
    pub fn straight(y: f64, direction: Direction) -> Self {
        Self(Kind::Straight { y, direction })
    }

    /// How far it is beside the centre line of lane 0 (m, as y of the world frame on a straight road), and which way it goes along it.
    pub(super) fn offset_and_direction(&self) -> (f64, Direction) {
        match &self.0 {
            Kind::Straight { y, direction } => (*y, *direction),
            Kind::Curved { course, .. } => (course.offset(), course.direction()),
        }
    }

    /// A course beside a line that bends.
    pub fn curved(course: CurvedPath) -> Self {
        Self(Kind::Curved { course: Arc::new(course), behind: 0.0 })
    }

    /// The same for a vehicle of which the point follows it that is so far (m, never negative) behind its centre, such as its rear axle.
    /// On a straight path that makes no difference.
    pub fn followed(self, behind: f64) -> Self {
        match self.0 {
            Kind::Curved { course, .. } => Self(Kind::Curved { course, behind }),
            straight => Self(straight),
        }
    }

    /// The course beside a line, if it is not simply straight.
    #[inline]
    pub fn course(&self) -> Option<&CurvedPath> {
        match &self.0 {
            Kind::Straight { .. } => None,
            Kind::Curved { course, .. } => Some(course),
        }
    }

    /// The centre, in the world frame, of whoever follows it and is at a place.
    #[inline]
    pub fn point(&self, place: f64) -> Vector2<f64> {
        match &self.0 {
            Kind::Straight { y, direction } => Vector2::new(direction.sign() * place, *y),
            Kind::Curved { .. } => self.pose(place).0,
        }
    }

    /// The velocity (m/s, world frame) of whoever follows it at `speed` and is at `place`.
    #[inline]
    pub fn velocity(&self, place: f64, speed: f64) -> Vector2<f64> {
        match &self.0 {
            Kind::Straight { direction, .. } => Vector2::new(direction.sign() * speed, 0.0),
            Kind::Curved { course, behind } => {
                let frame = course.frame(place - behind);
                (frame.tangent + frame.normal() * (behind * frame.curvature)) * speed
            }
        }
    }

    /// Unit vector in which a body points that follows it and is at a place.
    #[inline]
    pub fn heading(&self, place: f64) -> Vector2<f64> {
        match &self.0 {
            Kind::Straight { direction, .. } => Vector2::new(direction.sign(), 0.0),
            Kind::Curved { course, behind } => course.tangent(place - behind),
        }
    }

    /// The centre of a body that follows it and is at a place, and the unit vector in which it points there.
    pub fn pose(&self, place: f64) -> (Vector2<f64>, Vector2<f64>) {
        match &self.0 {
            Kind::Straight { .. } => (self.point(place), self.heading(place)),
            Kind::Curved { course, behind } => {
                let frame = course.frame(place - behind);
                let ahead = frame.tangent * *behind;
                (if *behind == 0.0 { frame.point } else { frame.point + ahead }, frame.tangent)
            }
        }
    }

    /// The same, sooner: no point of a body that reaches so far (m) from its centre is more than [`Self::roughness`] from where it is.
    pub fn rough_pose(&self, place: f64) -> (Vector2<f64>, Vector2<f64>) {
        match &self.0 {
            Kind::Straight { .. } => self.pose(place),
            Kind::Curved { course, behind } => {
                let frame = course.rough_frame(place - behind);
                (frame.point + frame.tangent * *behind, frame.tangent)
            }
        }
    }

    /// How far (m) a point of a body may be from where [`Self::rough_pose`] has it that is at most `reach` m from its centre.
    pub fn roughness(&self, reach: f64) -> f64 {
        match &self.0 {
            Kind::Straight { .. } => 0.0,
            Kind::Curved { course, behind } => {
                let (point, tangent) = course.roughness();
                point + (behind + reach) * tangent
            }
        }
    }

    /// The same of a body that is at a place, the point of it that would follow the path so far (m) to the left of it, and turned to the
    /// left of its direction (rad).
    pub fn pose_beside(&self, place: f64, offset: f64, angle: f64) -> (Vector2<f64>, Vector2<f64>) {
        let (cosine, sine) = (libm::cos(angle), libm::sin(angle));
        let turned = |ahead: Vector2<f64>| ahead * cosine + Vector2::new(-ahead.y, ahead.x) * sine;
        match &self.0 {
            Kind::Straight { .. } => {
                (self.to_world(Vector2::new(place, offset)), turned(self.heading(place)))
            }
            Kind::Curved { course, behind } => {
                let frame = course.frame(place - behind);
                let heading = turned(frame.tangent);
                (frame.point + frame.normal() * offset + heading * *behind, heading)
            }
        }
    }

    /// A vector of the world frame as whoever follows the path sees it at a place: x ahead, y to the left.
    #[inline]
    pub fn turned(&self, place: f64, vector: Vector2<f64>) -> Vector2<f64> {
        match &self.0 {
            Kind::Straight { direction, .. } => vector * direction.sign(),
            Kind::Curved { .. } => {
                let heading = self.heading(place);
                Vector2::new(vector.dot(&heading), heading.perp(&vector))
            }
        }
    }

    /// The other way round: a vector that somebody sees who is at a place, in the world frame.
    #[inline]
    pub fn turned_back(&self, place: f64, vector: Vector2<f64>) -> Vector2<f64> {
        match &self.0 {
            Kind::Straight { direction, .. } => vector * direction.sign(),
            Kind::Curved { .. } => {
                let heading = self.heading(place);
                heading * vector.x + Vector2::new(-heading.y, heading.x) * vector.y
            }
        }
    }

    /// The curvature (1/m, to the left) that a vehicle at a place follows: of the course, where the point is that follows it.
    pub fn curvature(&self, place: f64) -> f64 {
        match &self.0 {
            Kind::Straight { .. } => 0.0,
            Kind::Curved { course, behind } => course.curvature(place - behind),
        }
    }

    /// The places (m) of a vehicle at which the curvature that it follows changes, and what it is there (1/m, to the left), as
    /// [`CurvedPath::curvature_changes`] says them.
    pub fn curvature_changes(&self) -> Vec<(f64, f64)> {
        match &self.0 {
            Kind::Straight { .. } => Vec::new(),
            Kind::Curved { course, behind } => {
                course.curvature_changes().into_iter().map(|(place, bend)| (place + behind, bend)).collect()
            }
        }
    }

    /// Whether a body that follows it turns within a distance (m) of a place.
    #[inline]
    pub fn turns_about(&self, place: f64, within: f64) -> bool {
        self.tightest_between(place - within, place + within) > 0.0
    }

    /// The largest curvature (1/m, never negative) that a body follows between two places (m).
    pub fn tightest_between(&self, from: f64, to: f64) -> f64 {
        match &self.0 {
            Kind::Straight { .. } => 0.0,
            Kind::Curved { course, behind } => course.tightest_between(from.min(to) - behind, from.max(to)),
        }
    }

    /// How far any point of a body of this length and width (m) moves at most for each metre along it between two places (m).
    pub fn most_moved(&self, (from, to): (f64, f64), (length, width): (f64, f64)) -> f64 {
        match &self.0 {
            Kind::Straight { .. } => 1.0,
            Kind::Curved { behind, .. } => {
                1.0 + self.tightest_between(from, to) * (libm::hypot(length, width) / 2.0 + behind)
            }
        }
    }

    /// How far (m) a body that is at a place goes straight on; infinite after the last bend.
    pub fn straight_ahead(&self, place: f64) -> f64 {
        match &self.0 {
            Kind::Straight { .. } => f64::INFINITY,
            Kind::Curved { course, behind } => course.straight_ahead(place - behind),
        }
    }

    /// How far (m) the bend goes on that a body is in, until it goes straight on; 0 where it does.
    pub fn bend_ahead(&self, place: f64) -> f64 {
        match &self.0 {
            Kind::Straight { .. } => 0.0,
            Kind::Curved { course, behind } => course.bend_ahead(place - behind),
        }
    }

    /// The tightest bend (1/m, never negative) that is passed by the point that follows the course, while the vehicle's centre is
    /// between two places (m).
    pub fn tightest_followed(&self, (from, to): (f64, f64)) -> f64 {
        match &self.0 {
            Kind::Straight { .. } => 0.0,
            Kind::Curved { course, behind } => course.tightest_between(from - behind, to - behind),
        }
    }

    /// How far a rigid body of this length and width (m) that follows it sweeps to the right and to the left of it about a place, m.
    pub fn swept(&self, place: f64, (length, width): (f64, f64)) -> (f64, f64) {
        match &self.0 {
            Kind::Straight { .. } => (width / 2.0, width / 2.0),
            // Its far end is as far from the point that follows as that of a longer body about it.
            Kind::Curved { course, behind } => course.swept(place, (length + 2.0 * behind, width)),
        }
    }

    /// The most that it sweeps anywhere.
    pub fn most_swept(&self, (length, width): (f64, f64)) -> (f64, f64) {
        match &self.0 {
            Kind::Straight { .. } => (width / 2.0, width / 2.0),
            Kind::Curved { course, behind } => course.most_swept((length + 2.0 * behind, width)),
        }
    }

    /// Where a point lies.
    #[inline]
    pub fn locate(&self, point: Vector2<f64>) -> Located {
        match &self.0 {
            Kind::Straight { y, direction } => {
                let sign = direction.sign();
                Located {
                    along: sign * point.x,
                    beside: point.y - y,
                    heading: Vector2::new(sign, 0.0),
                    stretch: 1.0,
                    far: sign,
                    ambiguous: false,
                }
            }
            Kind::Curved { course, .. } => located(course, point),
        }
    }

    /// The place abreast of a point.
    #[inline]
    pub fn along(&self, point: Vector2<f64>) -> f64 {
        match &self.0 {
            Kind::Straight { direction, .. } => direction.sign() * point.x,
            Kind::Curved { course, .. } => course.project(point).place,
        }
    }

    /// How fast the place abreast of somebody moves who is at a point and moves at `velocity`, m/s.
    #[inline]
    pub fn speed_along(&self, point: Vector2<f64>, velocity: Vector2<f64>) -> f64 {
        match &self.0 {
            Kind::Straight { direction, .. } => direction.sign() * velocity.x,
            Kind::Curved { .. } => self.locate(point).speeds(velocity).0,
        }
    }

    /// The place abreast of a point, and how far that is to the left of the path, m.
    #[inline]
    pub fn from_world(&self, point: Vector2<f64>) -> Vector2<f64> {
        match &self.0 {
            Kind::Straight { y, direction } => {
                Vector2::new(direction.sign() * point.x, direction.sign() * (point.y - y))
            }
            Kind::Curved { course, .. } => {
                let found = course.project(point);
                Vector2::new(found.place, found.left)
            }
        }
    }

    /// The point that lies so far (m) along the path and to the left of it.
    pub fn to_world(&self, place: Vector2<f64>) -> Vector2<f64> {
        match &self.0 {
            Kind::Straight { y, direction } => {
                Vector2::new(direction.sign() * place.x, y + direction.sign() * place.y)
            }
            Kind::Curved { course, .. } => {
                let frame = course.frame(place.x);
                frame.point + frame.normal() * place.y
            }
        }
    }

    /// How far a point is from the path, m; positive towards the far side of the road.
    #[inline]
    pub fn beside(&self, point: Vector2<f64>) -> f64 {
        match &self.0 {
            Kind::Straight { y, .. } => point.y - y,
            Kind::Curved { course, .. } => course.direction().sign() * course.project(point).left,
        }
    }

    /// How far somebody who crosses from `side` is beyond the path, m; negative before it.
    #[inline]
    pub fn beyond(&self, point: Vector2<f64>, side: Side) -> f64 {
        side.walking_sign() * self.beside(point)
    }

    /// The place at which the line across the road `x` m along it from the middle of the crossing meets the path; on a straight
    /// road that is the line at world `x`.
    #[inline]
    pub fn at_line(&self, x: f64) -> f64 {
        match &self.0 {
            Kind::Straight { direction, .. } => direction.sign() * x,
            Kind::Curved { course, .. } => course.place_abreast(course.origin() + x),
        }
    }

    /// The line across the road at which a place lies, as [`Self::at_line`] counts lines, m.
    pub fn line_of(&self, place: f64) -> f64 {
        match &self.0 {
            Kind::Straight { direction, .. } => direction.sign() * place,
            Kind::Curved { course, .. } => course.station(place) - course.origin(),
        }
    }

    /// The place at which somebody meets the path who sets out from one point to another; abreast of where they set out if they
    /// do not.
    pub fn met_by(&self, start: Position, goal: Position) -> f64 {
        match &self.0 {
            // Straight across, with the bits that this always had.
            Kind::Straight { .. } if start.x == goal.x => self.at_line(start.x),
            Kind::Straight { .. } => {
                let (from, to): (Vector2<f64>, Vector2<f64>) = (start.into(), goal.into());
                let met = self.conflict(from, to - from).filter(|met| met.distance >= 0.0);
                met.map_or_else(|| self.at_line(start.x), |met| met.place)
            }
            Kind::Curved { course, .. } => {
                let (from, to): (Vector2<f64>, Vector2<f64>) = (start.into(), goal.into());
                let met = (to - from).try_normalize(0.0).and_then(|way| {
                    course.crossings(from, way).filter(|met| met.distance >= 0.0).min_by(nearer)
                });
                met.map_or_else(|| course.project(from).place, |met| met.place)
            }
        }
    }

    /// The share of the way from one point to another after which it meets the path, if it does.
    pub fn passed_between(&self, from: Vector2<f64>, to: Vector2<f64>) -> Option<f64> {
        let reached =
            |from: f64, to: f64, line: f64| (from < line && to >= line).then(|| (line - from) / (to - from));
        match &self.0 {
            Kind::Straight { y, .. } => reached(from.y, to.y, *y).or_else(|| reached(-from.y, -to.y, -y)),
            Kind::Curved { course, .. } => {
                let (from, to) = (course.project(from), course.project(to));
                if from.ambiguous || to.ambiguous {
                    return None;
                }
                reached(from.left, to.left, 0.0).or_else(|| reached(-from.left, -to.left, 0.0))
            }
        }
    }

    /// Distance in m that a way from one point to another, or its continuation, takes to the edge of the lane of width
    /// `lane_width` (m) that somebody who crosses from `side` leaves it by; `None` if it does not lead there.
    pub fn way_to_far_edge(
        &self,
        (from, to): (Vector2<f64>, Vector2<f64>),
        side: Side,
        lane_width: f64,
    ) -> Option<f64> {
        let beyond = side.walking_sign() * lane_width / 2.0;
        match &self.0 {
            Kind::Straight { y, .. } => {
                let edge = y + beyond;
                let (across, sideways) = (to.y - from.y, to.x - from.x);
                let part = (edge - from.y) / across;
                (part.is_finite() && part >= 0.0).then(|| part * libm::hypot(across, sideways))
            }
            Kind::Curved { course, .. } => {
                let way = (to - from).try_normalize(0.0)?;
                let edge = course.moved(beyond);
                let met = edge.crossings(from, way).filter(|met| met.distance >= 0.0);
                met.min_by(nearer).map(|met| met.distance)
            }
        }
    }

    /// Where the straight way from `from` (world frame, m) along the unit vector `way` meets it; `None` if it runs along it.
    pub fn conflict(&self, from: Vector2<f64>, way: Vector2<f64>) -> Option<Conflict> {
        match &self.0 {
            Kind::Straight { y, direction } => {
                // Walking along the road never crosses the lane.
                if way.y == 0.0 {
                    return None;
                }
                let distance = (y - from.y) / way.y;
                Some(Conflict { place: direction.sign() * (from.x + way.x * distance), distance })
            }
            Kind::Curved { course, .. } => course.crossings(from, way).min_by(|one, other| {
                let behind = |met: &Conflict| (met.distance < 0.0, met.distance.abs());
                let (one, other) = (behind(one), behind(other));
                one.0.cmp(&other.0).then(one.1.total_cmp(&other.1))
            }),
        }
    }

    /// The point at which the straight way from one point to another meets it, if it does.
    pub fn met_between(&self, from: Vector2<f64>, to: Vector2<f64>) -> Option<Vector2<f64>> {
        match &self.0 {
            Kind::Straight { y, .. } => {
                let part = (y - from.y) / (to.y - from.y);
                (0.0..=1.0).contains(&part).then(|| Vector2::new(from.x + part * (to.x - from.x), *y))
            }
            Kind::Curved { course, .. } => {
                let (long, way) = ((to - from).norm(), (to - from).try_normalize(0.0)?);
                let met = course.crossings(from, way).filter(|met| (0.0..=long).contains(&met.distance));
                met.min_by(nearer).map(|met| from + way * met.distance)
            }
        }
    }
}

fn located(course: &CurvedPath, point: Vector2<f64>) -> Located {
    let ((found, heading), far) = (course.project_with_heading(point), course.direction().sign());
    Located {
        along: found.place,
        beside: far * found.left,
        heading,
        // Far inside a bend, where nobody knows which part of it is meant, speeds stay finite.
        stretch: (1.0 - found.curvature * found.left).max(0.1),
        far,
        ambiguous: found.ambiguous,
    }
}

fn nearer(one: &Conflict, other: &Conflict) -> std::cmp::Ordering {
    one.distance.total_cmp(&other.distance)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Road;

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
            prop_assert_eq!(path.velocity(place, 3.0), path.heading(place) * 3.0);
            prop_assert_eq!(path.speed_along(point, path.velocity(place, 3.0)), 3.0);
            let offset = Vector2::new(place, y);
            prop_assert_eq!(path.turned_back(place, path.turned(place, offset)), offset);
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
