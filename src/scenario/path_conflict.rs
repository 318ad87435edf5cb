//! Where the paths of two vehicles cross, by their bodies: the stretch of each on which they could touch.

use nalgebra::Vector2;

use super::conflict_area::{ConflictArea, Stretch, end};
use super::{CROSSES, Conflict, Path};

/// Where the paths of two vehicles cross, with the stretches on which their bodies could touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathConflict {
    /// The places at which the paths cross, m: of the first, and of the second.
    pub places: (f64, f64),
    /// Cosine of the angle between the directions of both there.
    pub cosine: f64,
    /// The places of the first vehicle's centre at which its rectangle touches what the second sweeps, …
    pub first: Stretch,
    /// … and the other way round.
    pub second: Stretch,
}

impl PathConflict {
    /// The other way round.
    #[must_use]
    pub fn swapped(self) -> Self {
        let Self { places, cosine, first, second } = self;
        Self { places: (places.1, places.0), cosine, first: second, second: first }
    }
}

/// On two paths that both bend crossings are looked for in steps of this, m, …
const LOOKS: f64 = 0.5;

/// … and found to this, m.
const CLOSE: f64 = 1e-12;

/// What a body sweeps is looked at by outlines that are so far apart on its path, m.
const OUTLINES: f64 = 0.05;

/// The centre of a rectangle and the unit vector along its length, in the world frame.
type Pose = (Vector2<f64>, Vector2<f64>);

impl Path {
    /// The conflicts of a vehicle that follows this path from a place (m) on with one that follows another, each with its place, length and
    /// width (m), as far as `reach` (m) ahead of both, in the order in which the first comes to them. Paths that cross at less than 20°
    /// merge, they do not cross.
    ///
    /// Stretches are exact where both go straight on, else right to 0.1 mm.
    pub fn conflicts_with(
        &self,
        (place, size): (f64, (f64, f64)),
        other: (&Self, f64, (f64, f64)),
        reach: f64,
    ) -> Vec<PathConflict> {
        let (path, from, others) = other;
        let ahead = |(one, two): &(f64, f64)| {
            (place..=place + reach).contains(one) && (from..=from + reach).contains(two)
        };
        let met = self.crossings_with(path, (place, place + reach));
        let mut found: Vec<PathConflict> = met
            .into_iter()
            .filter(ahead)
            .filter_map(|places| conflict((self, size), (path, others), places))
            .collect();
        found.sort_by(|one, two| one.places.0.total_cmp(&two.places.0));
        found
    }

    /// Whether it never bends.
    fn is_line(&self) -> bool {
        self.course().is_none_or(|course| course.line().pieces().all(|piece| piece.tightest() == 0.0))
    }

    /// The places (m) of both at which they cross; where both bend, only those between two places of this one.
    fn crossings_with(&self, other: &Self, between: (f64, f64)) -> Vec<(f64, f64)> {
        if other.is_line() {
            let (from, way) = (other.point(0.0), other.heading(0.0));
            return self.crossed_by(from, way).into_iter().map(|met| (met.place, met.distance)).collect();
        }
        if self.is_line() {
            let (from, way) = (self.point(0.0), self.heading(0.0));
            return other.crossed_by(from, way).into_iter().map(|met| (met.distance, met.place)).collect();
        }
        let left = |place: f64| other.locate(self.point(place)).left();
        let looks = ((between.1 - between.0) / LOOKS).ceil().clamp(0.0, 1e6) as usize;
        let mut found = Vec::new();
        let mut last = (between.0, left(between.0));
        for look in 1..=looks {
            let place = between.0 + LOOKS * look as f64;
            let next = (place, left(place));
            // Where the nearest part of the other path jumps, nothing is crossed.
            if (last.1 <= 0.0) != (next.1 <= 0.0) && (next.1 - last.1).abs() < 2.0 * LOOKS {
                let met = crossed(left, last, next);
                found.push((met, other.along(self.point(met))));
            }
            last = next;
        }
        found
    }

    /// Where the line through a point along a unit vector crosses it.
    fn crossed_by(&self, from: Vector2<f64>, way: Vector2<f64>) -> Vec<Conflict> {
        match self.course() {
            Some(course) => course.crossings(from, way).collect(),
            None => self.conflict(from, way).into_iter().collect(),
        }
    }
}

/// Where a function is 0 that has another sign at one end than at the other.
fn crossed(value: impl Fn(f64) -> f64, (mut low, at_low): (f64, f64), (mut high, _): (f64, f64)) -> f64 {
    while high - low > CLOSE * (1.0 + high.abs()) {
        let middle = (low + high) / 2.0;
        if middle <= low || middle >= high {
            break;
        }
        if (value(middle) <= 0.0) == (at_low <= 0.0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low + high) / 2.0
}

fn conflict(
    (one, size): (&Path, (f64, f64)),
    (other, others): (&Path, (f64, f64)),
    places: (f64, f64),
) -> Option<PathConflict> {
    let (ahead, aside) = (one.heading(places.0), other.heading(places.1));
    let (cosine, sine) = (ahead.dot(&aside), ahead.perp(&aside).abs());
    if sine < CROSSES {
        return None;
    }
    let point = Conflict { place: places.0, distance: places.1 };
    let of_lines = ConflictArea::of_lines(point, (cosine, sine), size, others);
    let reach = of_lines.vehicle.half() + of_lines.pedestrian.half() + size.0 + others.0;
    let straight = !one.turns_about(places.0, reach) && !other.turns_about(places.1, reach);
    let (first, second) = match straight {
        true => (of_lines.vehicle, of_lines.pedestrian),
        false => (
            stretch((one, size, places.0), (other, others, places.1), reach),
            stretch((other, others, places.1), (one, size, places.0), reach),
        ),
    };
    Some(PathConflict { places, cosine, first, second })
}

/// The places about a crossing at which a rectangle that follows a path touches what another sweeps about it.
fn stretch(
    (path, size, place): (&Path, (f64, f64), f64),
    (other, others, met): (&Path, (f64, f64), f64),
    reach: f64,
) -> Stretch {
    let count = (reach / OUTLINES).ceil() as i32;
    let swept: Vec<Pose> =
        (-count..=count).map(|index| other.pose(met + f64::from(index) * OUTLINES)).collect();
    let touches = |at: f64| {
        let pose = path.pose(at);
        swept.iter().any(|outline| overlap((&pose, size), (outline, others)))
    };
    Stretch { from: end(touches, place, -1.0), to: end(touches, place, 1.0) }
}

/// Whether two rectangles touch: no side of either separates them.
fn overlap((one, size): (&Pose, (f64, f64)), (other, others): (&Pose, (f64, f64))) -> bool {
    let apart = other.0 - one.0;
    let across = |ahead: Vector2<f64>| Vector2::new(-ahead.y, ahead.x);
    let reach = |(length, width): (f64, f64), ahead: Vector2<f64>, axis: Vector2<f64>| {
        (length * ahead.dot(&axis).abs() + width * ahead.perp(&axis).abs()) / 2.0
    };
    [one.1, across(one.1), other.1, across(other.1)]
        .into_iter()
        .all(|axis| apart.dot(&axis).abs() <= reach(size, one.1, axis) + reach(others, other.1, axis))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::Rotation2;
    use proptest::prelude::*;

    use super::*;
    use crate::Direction;
    use crate::geometry::{CurvedPath, Piece, Pose, ReferenceLine};

    const CAR: (f64, f64) = (4.5, 1.8);
    const TRUCK: (f64, f64) = (8.0, 2.5);

    /// Pieces that are at `point` after 50 m, where they head in this direction (rad).
    fn through(point: Vector2<f64>, heading: f64, pieces: &[Piece], station: f64) -> Path {
        let probe = ReferenceLine::new(Pose::origin(), pieces).unwrap().pose(station);
        let turned = heading - probe.heading;
        let start =
            Pose { point: point - Rotation2::new(turned) * probe.point, heading: turned, curvature: 0.0 };
        let line = Arc::new(ReferenceLine::new(start, pieces).unwrap());
        Path::curved(CurvedPath::new(line, 0.0, Direction::Forward, station).unwrap())
    }

    fn lines(angle: f64, turned: f64) -> (Path, Path) {
        let line = |heading: f64| through(Vector2::new(3.0, -2.0), heading, &[Piece::line(100.0)], 50.0);
        (line(turned), line(turned + angle))
    }

    fn corners(
        (centre, ahead): (Vector2<f64>, Vector2<f64>),
        (length, width): (f64, f64),
    ) -> [Vector2<f64>; 4] {
        let left = Vector2::new(-ahead.y, ahead.x);
        [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]
            .map(|(x, y)| centre + ahead * (x * length / 2.0) + left * (y * width / 2.0))
    }

    #[test]
    fn at_a_right_angle_it_is_half_the_length_and_half_the_others_width() {
        let (one, other) = lines(std::f64::consts::FRAC_PI_2, 0.3);
        let found = one.conflicts_with((-40.0, CAR), (&other, -40.0, TRUCK), 100.0);
        let [met] = found[..] else { panic!("{found:?}") };
        for (found, expected) in [
            (met.places.0, 0.0),
            (met.places.1, 0.0),
            (met.first.from, -(4.5 + 2.5) / 2.0),
            (met.first.to, (4.5 + 2.5) / 2.0),
            (met.second.from, -(8.0 + 1.8) / 2.0),
            (met.second.to, (8.0 + 1.8) / 2.0),
        ] {
            assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
        }
        // Who is past it, or does not come so far, meets nobody.
        assert_eq!(one.conflicts_with((1.0, CAR), (&other, -40.0, TRUCK), 100.0), []);
        assert_eq!(one.conflicts_with((-40.0, CAR), (&other, -40.0, TRUCK), 30.0), []);
    }

    #[test]
    fn who_runs_along_another_does_not_cross_it() {
        for degrees in [0.0, 15.0, 170.0, 180.0, 355.0] {
            let (one, other) = lines(f64::to_radians(degrees), 0.0);
            assert_eq!(one.conflicts_with((-40.0, CAR), (&other, -40.0, CAR), 100.0), [], "{degrees}°");
        }
    }

    #[test]
    fn two_that_bend_meet_as_often_as_they_do() {
        // An S that a C crosses once, found from either.
        let bent = [Piece::line(20.0), Piece::arc(30.0, 1.0), Piece::arc(-30.0, 1.0), Piece::line(20.0)];
        let one = through(Vector2::zeros(), 0.0, &bent, 50.0);
        let other = through(Vector2::zeros(), 1.3, &[Piece::arc(40.0, 2.0)], 40.0);
        let found = one.conflicts_with((-50.0, CAR), (&other, -40.0, TRUCK), 100.0);
        let [met] = found[..] else { panic!("{found:?}") };
        assert!(met.places.0.abs() < 1e-9 && met.places.1.abs() < 1e-9, "{met:?}");
        let back = other.conflicts_with((-40.0, TRUCK), (&one, -50.0, CAR), 100.0);
        let swapped = back[0].swapped();
        for (one, other) in [
            (met.first.from, swapped.first.from),
            (met.first.to, swapped.first.to),
            (met.second.from, swapped.second.from),
            (met.second.to, swapped.second.to),
        ] {
            assert!((one - other).abs() < 1e-9, "{one} and {other}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// Against polygons: the corners of one against the band that the other sweeps, densely.
        #[test]
        fn on_lines_its_ends_are_where_corners_reach_the_band(angle in 0.36_f64..2.78, turned in 0.0..6.2, swap: bool) {
            let (one, other) = lines(if swap { -angle } else { angle }, turned);
            let met = one.conflicts_with((-45.0, CAR), (&other, -45.0, TRUCK), 100.0)[0];
            let (from, way) = (other.point(0.0), other.heading(0.0));
            let touches = |at: f64| {
                let sides = corners(one.pose(at), CAR).map(|corner| way.perp(&(corner - from)));
                let low = sides.into_iter().fold(f64::INFINITY, f64::min);
                let high = sides.into_iter().fold(f64::NEG_INFINITY, f64::max);
                low <= TRUCK.1 / 2.0 && high >= -TRUCK.1 / 2.0
            };
            for (end, inwards) in [(met.first.from, 1.0), (met.first.to, -1.0)] {
                prop_assert!(touches(end + inwards * 1e-9) && !touches(end - inwards * 1e-9), "{end}");
            }
        }

        /// Turned as a whole, mirrored or swapped, it is the same.
        #[test]
        fn it_is_the_same_from_everywhere(angle in 0.4..2.7, turned in 0.0..6.2, radius in 15.0..60.0) {
            let bent = [Piece::line(30.0), Piece::arc(radius, 1.0), Piece::line(30.0)];
            let mirrored = bent.map(Piece::mirrored);
            let station = 32.0;
            let pair = |side: f64, turned: f64| {
                let pieces = if side > 0.0 { &bent } else { &mirrored };
                let one = through(Vector2::new(1.0, 2.0), turned, pieces, station);
                let other = through(Vector2::new(1.0, 2.0), turned + side * angle, &[Piece::line(80.0)], 40.0);
                one.conflicts_with((-30.0, CAR), (&other, -30.0, TRUCK), 60.0)[0]
            };
            let first = pair(1.0, 0.0);
            for again in [pair(1.0, turned), pair(-1.0, turned)] {
                for (one, other) in [
                    (first.first.from, again.first.from),
                    (first.first.to, again.first.to),
                    (first.second.from, again.second.from),
                    (first.second.to, again.second.to),
                    (first.cosine, again.cosine),
                ] {
                    prop_assert!((one - other).abs() < 1e-8, "{one} and {other}");
                }
            }
        }
    }
}
