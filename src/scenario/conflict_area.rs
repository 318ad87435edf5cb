//! Where the ways of a vehicle and a person meet, by their bodies: the stretch of each on which they could touch.

use nalgebra::Vector2;

use super::geometry::CurvedPath;
use super::{Conflict, Path};

/// A stretch of a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// m
    pub from: f64,
    /// m
    pub to: f64,
}

impl Stretch {
    fn about(middle: f64, half: f64) -> Self {
        Self { from: middle - half, to: middle + half }
    }

    /// For models that want one point, m.
    pub fn middle(&self) -> f64 {
        (self.from + self.to) / 2.0
    }

    /// Half its length, m.
    pub fn half(&self) -> f64 {
        (self.to - self.from) / 2.0
    }
}

/// Where the ways of a vehicle and a person cross, with the stretches on which their bodies could touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConflictArea {
    /// Where the lines cross that their centres follow.
    pub point: Conflict,
    /// Cosine of the angle between the directions of both: 0 where they meet at a right angle, above 0 where they go the same way.
    pub cosine: f64,
    /// The places of the vehicle's centre at which its rectangle touches the band that the person walks.
    pub vehicle: Stretch,
    /// The distances of the person's centre along its way, from where it is, at which its body touches what the vehicle sweeps.
    pub pedestrian: Stretch,
}

/// Who walks along a lane at less than this sine of the angle (20°) does not cross it.
const CROSSES: f64 = 0.34;

/// An end of a stretch on a bend is not looked for beyond this, m.
const FARTHEST: f64 = 100.0;

/// An end of a stretch on a bend is looked for in steps of this, m, …
const LOOKS: f64 = 0.05;

/// … and found to this, m.
const CLOSE: f64 = 1e-10;

impl ConflictArea {
    /// Of somebody who crosses a straight path at the angle of this cosine and sine.
    pub(super) fn of_lines(
        point: Conflict,
        (cosine, sine): (f64, f64),
        vehicle: (f64, f64),
        body: (f64, f64),
    ) -> Self {
        let half =
            |own: (f64, f64), other: f64| own.0 / 2.0 + (other / 2.0 + own.1 / 2.0 * cosine.abs()) / sine;
        Self {
            point,
            cosine,
            vehicle: Stretch::about(point.place, half(vehicle, body.1)),
            pedestrian: Stretch::about(point.distance, half(body, vehicle.1)),
        }
    }
}

impl Path {
    /// The conflict of a vehicle that is at `place` of it, of this length and width, with somebody at `from` who walks along the
    /// unit vector `way` and is so long along that and so wide (m each). Of several the first that the vehicle has not left, else the
    /// last; `None` if the person walks along the path, at less than 20° to it.
    pub fn conflict_area(
        &self,
        (place, size): (f64, (f64, f64)),
        (from, way): (Vector2<f64>, Vector2<f64>),
        body: (f64, f64),
    ) -> Option<ConflictArea> {
        let Some(course) = self.course() else {
            let point = self.conflict(from, way)?;
            let (cosine, sine) = (self.heading(place).dot(&way), way.y.abs());
            return (sine >= CROSSES).then(|| ConflictArea::of_lines(point, (cosine, sine), size, body));
        };
        let areas = course
            .crossings(from, way)
            .filter_map(|point| area(self, course, point, size, (from, way), body));
        let left = |area: &ConflictArea| area.vehicle.to < place;
        areas.reduce(|one, other| {
            let nearer = match (left(&one), left(&other)) {
                (false, false) => one.point.place <= other.point.place,
                (true, true) => one.point.place >= other.point.place,
                (one, _) => !one,
            };
            if nearer { one } else { other }
        })
    }
}

fn area(
    path: &Path,
    course: &CurvedPath,
    point: Conflict,
    size: (f64, f64),
    (from, way): (Vector2<f64>, Vector2<f64>),
    body: (f64, f64),
) -> Option<ConflictArea> {
    let heading = path.heading(point.place);
    let (cosine, sine) = (heading.dot(&way), heading.perp(&way).abs());
    if sine < CROSSES {
        return None;
    }
    let of_lines = ConflictArea::of_lines(point, (cosine, sine), size, body);
    let within = of_lines.vehicle.half() + of_lines.pedestrian.half() + size.0;
    if !path.turns_about(point.place, within) {
        return Some(of_lines);
    }
    // How far a rectangle along one of two unit vectors reaches across the other.
    let across = |(length, width): (f64, f64), one: Vector2<f64>, other: Vector2<f64>| {
        (length * one.perp(&other).abs() + width * one.dot(&other).abs()) / 2.0
    };
    let in_band = |place: f64| {
        let (centre, heading) = path.pose(place);
        way.perp(&(centre - from)).abs() <= body.1 / 2.0 + across(size, heading, way)
    };
    let is_swept = |distance: f64| {
        let at = course.project(from + way * distance);
        let reach = across(body, way, course.tangent(at.place));
        let (right, left) = path.swept(at.place, size);
        -right - reach <= at.left && at.left <= left + reach
    };
    Some(ConflictArea {
        point,
        cosine,
        vehicle: Stretch { from: end(in_band, point.place, -1.0), to: end(in_band, point.place, 1.0) },
        pedestrian: Stretch {
            from: end(is_swept, point.distance, -1.0),
            to: end(is_swept, point.distance, 1.0),
        },
    })
}

/// How far what holds at a place holds on in one direction.
pub(super) fn end(holds: impl Fn(f64) -> bool, place: f64, sign: f64) -> f64 {
    let mut inside = 0.0;
    // Whoever crosses is out again after some lengths of a body.
    while inside < FARTHEST && holds(place + sign * (inside + LOOKS)) {
        inside += LOOKS;
    }
    let mut outside = inside + LOOKS;
    while outside - inside > CLOSE {
        let middle = (inside + outside) / 2.0;
        if holds(place + sign * middle) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    place + sign * inside
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use proptest::prelude::*;

    use super::*;
    use crate::Direction;
    use crate::geometry::{Piece, Pose, ReferenceLine};

    const CAR: (f64, f64) = (4.358, 1.815);
    const ADULT: (f64, f64) = (0.6, 0.5);

    /// The far-side turn of Euro NCAP's CPTA at 10 km/h, which begins at the origin.
    fn turn(side: f64) -> Path {
        let [one, arc, other] =
            Piece::turn(1500.0 * side, 9.0 * side, f64::to_radians(20.62), f64::to_radians(48.76));
        let pieces = [Piece::line(30.0), one, arc, other, Piece::line(30.0)];
        let start = Pose { point: Vector2::new(-30.0, 0.0), ..Pose::origin() };
        let line = Arc::new(ReferenceLine::new(start, &pieces).unwrap());
        Path::curved(CurvedPath::new(line, 0.0, Direction::Forward, 30.0).unwrap())
    }

    fn line(angle: f64) -> Path {
        let start = Pose {
            point: Vector2::new(libm::cos(angle), libm::sin(angle)) * -50.0,
            heading: angle,
            curvature: 0.0,
        };
        let line = Arc::new(ReferenceLine::new(start, &[Piece::line(100.0)]).unwrap());
        Path::curved(CurvedPath::new(line, 0.0, Direction::Forward, 50.0).unwrap())
    }

    #[test]
    fn on_a_straight_road_a_line_says_what_the_closed_form_says() {
        let road = Path::straight(0.0, Direction::Forward);
        for degrees in [90.0, 60.0, 45.0, 30.0, 120.0, 150.0, -90.0, -45.0] {
            let angle = f64::to_radians(degrees);
            let way = Vector2::new(libm::cos(angle), libm::sin(angle));
            let from = Vector2::new(3.0, 1.0) - way * 5.0;
            let one = road.conflict_area((-20.0, CAR), (from, way), ADULT).unwrap();
            let (sine, cosine) = (way.y.abs(), way.x.abs());
            let half = 4.358 / 2.0 + (0.25 + 1.815 / 2.0 * cosine) / sine;
            assert!(
                (one.vehicle.half() - half).abs() < 1e-12
                    && (one.vehicle.middle() - one.point.place).abs() < 1e-12
            );
            assert!((one.cosine - libm::cos(angle)).abs() < 1e-12);
            for turned in [0.0, 0.7, 2.0] {
                let about = nalgebra::Rotation2::new(turned);
                let other =
                    line(turned).conflict_area((-20.0, CAR), (about * from, about * way), ADULT).unwrap();
                for (one, other) in [
                    (one.vehicle.from, other.vehicle.from),
                    (one.vehicle.to, other.vehicle.to),
                    (one.pedestrian.from, other.pedestrian.from),
                    (one.pedestrian.to, other.pedestrian.to),
                    (one.cosine, other.cosine),
                ] {
                    assert!((one - other).abs() < 1e-9, "{degrees}°, {turned}: {one} and {other}");
                }
            }
        }
    }

    #[test]
    fn in_a_turn_the_stretch_before_the_point_is_not_that_behind_it() {
        // 3 m before the turn's end, parallel to the road that the car leaves.
        let from = Vector2::new(20.0, 12.380 - 3.0);
        let found = turn(1.0).conflict_area((-10.0, CAR), (from, -Vector2::x()), ADULT).unwrap();
        let (before, behind) = (found.point.place - found.vehicle.from, found.vehicle.to - found.point.place);
        assert!((before - 2.635).abs() < 1e-3 && (behind - 2.434).abs() < 1e-3, "{before} m and {behind} m");
        let right = turn(-1.0);
        let mirrored =
            right.conflict_area((-10.0, CAR), (Vector2::new(from.x, -from.y), -Vector2::x()), ADULT).unwrap();
        for (one, other) in [
            (found.vehicle.from, mirrored.vehicle.from),
            (found.vehicle.to, mirrored.vehicle.to),
            (found.pedestrian.from, mirrored.pedestrian.from),
            (found.pedestrian.to, mirrored.pedestrian.to),
            (found.cosine, mirrored.cosine),
        ] {
            assert!((one - other).abs() < 1e-9, "{one} and {other}");
        }
    }

    #[test]
    fn the_first_crossing_that_is_not_left_counts() {
        // A way that crosses both legs of the turn.
        let (from, way) = (Vector2::new(-9.0, -6.0), Vector2::new(1.0, 1.0).normalize());
        let path = turn(1.0);
        let at =
            |place: f64| path.conflict_area((place, CAR), (from, way), ADULT).map(|found| found.point.place);
        let (first, then) = (at(-20.0).unwrap(), at(2.0).unwrap());
        assert!((path.point(first) - Vector2::new(-3.0, 0.0)).norm() < 1e-9, "{first}");
        assert!(then > 10.0 && at(300.0) == Some(then), "{then}");
        // Along the lane nobody crosses it.
        assert_eq!(
            path.conflict_area(
                (-20.0, CAR),
                (Vector2::new(-15.0, 1.0), Vector2::new(1.0, -0.1).normalize()),
                ADULT
            )
            .map(|found| libm::acos(found.cosine) > 0.3),
            None
        );
    }

    proptest! {
        #[test]
        fn its_ends_are_where_corners_reach_the_band(place in -5.0..25.0, turned in 0.5..2.6, wide in 0.2..1.0) {
            let path = turn(1.0);
            let heading = path.heading(place);
            let way = nalgebra::Rotation2::new(turned) * heading;
            let from = path.point(place) - way * 6.0;
            let found = path.conflict_area((-15.0, CAR), (from, way), (0.6, wide));
            prop_assume!(found.is_some_and(|found| (found.point.place - place).abs() < 1e-6));
            let found = found.unwrap();
            // Looked at densely, by the corners.
            let touches = |at: f64| {
                let (centre, ahead) = (path.point(at), path.heading(at));
                let left = Vector2::new(-ahead.y, ahead.x);
                let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(x, y)| {
                    way.perp(&(centre + ahead * (CAR.0 / 2.0 * x) + left * (CAR.1 / 2.0 * y) - from))
                });
                let low = corners.into_iter().fold(f64::INFINITY, f64::min);
                let high = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
                low <= wide / 2.0 && high >= -wide / 2.0
            };
            // Where it is out for less than a look is long it may be out or not, and who walks along a leg is followed for 100 m.
            let ends = |step: f64| {
                let (mut at, mut ends) = (found.point.place, Vec::new());
                loop {
                    while touches(at) {
                        at += step;
                        if (at - found.point.place).abs() > FARTHEST {
                            ends.push((at, 2.0 * LOOKS));
                            return ends;
                        }
                    }
                    ends.push((at, 1e-3));
                    let out = (1..).map(|steps| f64::from(steps) * step).take_while(|out| out.abs() < LOOKS);
                    match out.map(|out| at + out).find(|at| touches(*at)) {
                        Some(again) => at = again,
                        None => return ends,
                    }
                }
            };
            for (step, found) in [(1e-4, found.vehicle.to), (-1e-4, found.vehicle.from)] {
                let ends = ends(step);
                let is_one = ends.iter().any(|(at, right_to)| (at - found).abs() < *right_to);
                prop_assert!(is_one, "{ends:?}, not {found}");
            }
        }
    }
}
