//! One line, arc or clothoid: how far it turns and where it leads, seen from its beginning.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// A point of a curve, where it leads from there and how it bends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// World frame, m.
    pub point: Vector2<f64>,
    /// From the x axis, rad; not wrapped, so that a whole turn is counted.
    pub heading: f64,
    /// To the left, 1/m.
    pub curvature: f64,
}

impl Pose {
    /// At the origin, along x.
    pub fn origin() -> Self {
        Self { point: Vector2::zeros(), heading: 0.0, curvature: 0.0 }
    }

    /// Unit vector along the curve.
    pub fn tangent(&self) -> Vector2<f64> {
        unit(self.heading)
    }

    /// Unit vector to its left.
    pub fn normal(&self) -> Vector2<f64> {
        let along = self.tangent();
        Vector2::new(-along.y, along.x)
    }
}

/// A pose with its heading as a unit vector, for those who would work that out again and again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    /// World frame, m.
    pub(crate) point: Vector2<f64>,
    /// Unit vector along the curve.
    pub(crate) tangent: Vector2<f64>,
    /// To the left, 1/m.
    pub(crate) curvature: f64,
}

impl Frame {
    /// Unit vector to its left.
    pub(crate) fn normal(&self) -> Vector2<f64> {
        Vector2::new(-self.tangent.y, self.tangent.x)
    }
}

impl From<Pose> for Frame {
    fn from(pose: Pose) -> Self {
        Self { point: pose.point, tangent: pose.tangent(), curvature: pose.curvature }
    }
}

/// 1 − x/f₁·(1 − x/f₂·(1 − …)) at x = `square`.
fn series(square: f64, divisors: [f64; 6]) -> f64 {
    divisors.iter().rev().fold(1.0, |sum, divisor| 1.0 - sum * square * (1.0 / divisor))
}

const OF_SINE: [f64; 6] = [6.0, 20.0, 42.0, 72.0, 110.0, 156.0];

/// The unit vector at a small angle (rad) to the x axis: by the series, which below 0.3 rad is right to the last bit but one.
pub(super) fn unit_of_small(angle: f64) -> Vector2<f64> {
    let square = angle * angle;
    let cosine = series(square, [2.0, 12.0, 30.0, 56.0, 90.0, 132.0]);
    Vector2::new(cosine, angle * series(square, OF_SINE))
}

/// Where an arc of length 1 ends that turns by a small angle (rad) from the x axis.
pub(super) fn arc_of_small(angle: f64) -> Vector2<f64> {
    let square = angle * angle;
    let aside = series(square, [12.0, 30.0, 56.0, 90.0, 132.0, 182.0]);
    Vector2::new(series(square, OF_SINE), angle / 2.0 * aside)
}

/// A vector along the x axis turned so that it lies along the unit vector `onto`.
pub(super) fn turned_onto(vector: Vector2<f64>, onto: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(vector.x * onto.x - vector.y * onto.y, vector.x * onto.y + vector.y * onto.x)
}

/// The unit vector at an angle (rad) to the x axis.
pub(super) fn unit(angle: f64) -> Vector2<f64> {
    Vector2::new(libm::cos(angle), libm::sin(angle))
}

/// A line (both curvatures 0), an arc (both equal) or a clothoid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    /// m
    pub length: f64,
    /// At its beginning, to the left, 1/m.
    pub from: f64,
    /// At its end, 1/m.
    pub to: f64,
}

/// An arc that turns less than this over half of it is taken for its chord, rad.
const FLAT: f64 = 1e-9;

/// A clothoid is integrated over parts that turn no more than this, rad.
const PART: f64 = 0.5;

/// Places and weights of the 8-point rule of Gauss and Legendre on (−1, 1), of which the other half is the mirror image.
const GAUSS_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

impl Piece {
    /// A straight line of this length (m).
    pub fn line(length: f64) -> Self {
        Self { length, from: 0.0, to: 0.0 }
    }

    /// An arc about `radius` (m, positive to the left) over `angle` (rad, positive).
    pub fn arc(radius: f64, angle: f64) -> Self {
        Self { length: radius.abs() * angle, from: 1.0 / radius, to: 1.0 / radius }
    }

    /// A clothoid of this length (m) from one curvature (1/m) to another.
    pub fn clothoid(length: f64, from: f64, to: f64) -> Self {
        Self { length, from, to }
    }

    /// A turn by a clothoid of `clothoid` rad from `wide` (m) to `radius` (m), an arc of `arc` rad, and the clothoid back;
    /// both radii positive to the left. Euro NCAP writes its turns so, with 1500 m for `wide`.
    pub fn turn(wide: f64, radius: f64, clothoid: f64, arc: f64) -> [Self; 3] {
        let (from, to) = (1.0 / wide, 1.0 / radius);
        let length = 2.0 * clothoid / (from + to).abs();
        [Self::clothoid(length, from, to), Self::arc(radius, arc), Self::clothoid(length, to, from)]
    }

    /// The same to the other side.
    pub fn mirrored(self) -> Self {
        Self { from: -self.from, to: -self.to, ..self }
    }

    /// The largest curvature in it, 1/m; never negative.
    pub fn tightest(&self) -> f64 {
        self.from.abs().max(self.to.abs())
    }

    /// Where it leads from a point (m) and a unit vector: to its end.
    pub fn followed_from(&self, point: Vector2<f64>, heading: Vector2<f64>) -> (Vector2<f64>, Vector2<f64>) {
        let led = turned_onto(self.led(0.0, self.length), heading);
        let ahead = turned_onto(unit(self.turned(self.length)), heading);
        // Again and again the length of a unit vector would drift.
        (point + led, ahead.try_normalize(0.0).unwrap_or(heading))
    }

    /// How its curvature changes, 1/m².
    pub(super) fn change(&self) -> f64 {
        if self.from == self.to { 0.0 } else { (self.to - self.from) / self.length }
    }

    /// The curvature (1/m) after `way` m.
    pub(super) fn curvature(&self, way: f64) -> f64 {
        self.from + self.change() * way
    }

    /// How far it has turned (rad) after `way` m.
    pub(super) fn turned(&self, way: f64) -> f64 {
        self.from * way + self.change() * way * way / 2.0
    }

    /// Where it has led after `way` m, for one who begins at the origin along `heading` (rad).
    pub(super) fn led(&self, heading: f64, way: f64) -> Vector2<f64> {
        if self.change() != 0.0 {
            return self.integrated(heading, way);
        }
        let half = self.from * way / 2.0;
        let chord = if half.abs() < FLAT { way } else { way * libm::sin(half) / half };
        unit(heading + half) * chord
    }

    fn integrated(&self, heading: f64, way: f64) -> Vector2<f64> {
        let turning = self.from.abs().max(self.curvature(way).abs()) * way.abs();
        let parts = (turning / PART).ceil().max(1.0);
        let half = way / parts / 2.0;
        let mut led = Vector2::zeros();
        for part in 0..parts as usize {
            let middle = (2 * part + 1) as f64 * half;
            for (place, weight) in GAUSS_8 {
                for place in [-place, place] {
                    led += unit(heading + self.turned(middle + half * place)) * weight;
                }
            }
        }
        led * half
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Simpson's rule in many steps: nothing in common with how it is done above.
    fn summed(piece: &Piece, way: f64) -> Vector2<f64> {
        let steps = 4000;
        let width = way / f64::from(steps);
        let weight = |step| if step == 0 || step == steps { 1.0 } else { 2.0 + 2.0 * f64::from(step % 2) };
        let slope = (piece.to - piece.from) / piece.length;
        let angle = |at: f64| (piece.from + slope * at / 2.0) * at;
        (0..=steps).map(|step| unit(angle(f64::from(step) * width)) * weight(step)).sum::<Vector2<f64>>()
            * (width / 3.0)
    }

    proptest! {
        #[test]
        fn it_leads_where_sums_lead(
            length in 0.1..120.0, from in -0.2..0.2, to in -0.2..0.2, share in -0.5..1.5, kind in 0..3,
        ) {
            let piece = match kind {
                0 => Piece::line(length),
                1 => Piece::clothoid(length, from, from),
                _ => Piece::clothoid(length, from, to),
            };
            let way = share * length;
            prop_assert!((piece.led(0.0, way) - summed(&piece, way)).norm() < 1e-9);
            prop_assert!((piece.turned(length) - (piece.from + piece.to) / 2.0 * length).abs() < 1e-12);
        }

        #[test]
        fn the_other_side_is_its_mirror_image(
            length in 0.1..120.0, from in -0.2..0.2, to in -0.2..0.2, share in 0.0..1.0,
        ) {
            let piece = Piece::clothoid(length, from, to);
            let (one, other) = (piece.led(0.0, share * length), piece.mirrored().led(0.0, share * length));
            prop_assert_eq!((one.x, one.y), (other.x, -other.y));
        }
    }

    #[test]
    fn small_angles_have_the_unit_vectors_of_any_angle() {
        for step in -300..=300 {
            let angle = f64::from(step) * 1e-3;
            assert!((unit_of_small(angle) - unit(angle)).norm() < 3e-16, "{angle} rad");
            let arc = Piece::clothoid(1.0, angle, angle);
            assert!((arc_of_small(angle) - arc.led(0.0, 1.0)).norm() < 3e-15, "{angle} rad");
        }
    }

    #[test]
    fn an_arc_that_hardly_bends_is_a_line() {
        for bend in [0.0, 1e-13, 1e-11, 1e-9, 1e-7] {
            let led = Piece::clothoid(100.0, bend, bend).led(0.0, 100.0);
            assert!((led - Vector2::new(100.0, bend * 5000.0)).norm() < 1e-8, "{bend}: {led}");
        }
    }

    #[test]
    fn a_quarter_of_a_circle_ends_beside_its_centre() {
        for side in [1.0, -1.0] {
            let arc = Piece::arc(9.0 * side, std::f64::consts::FRAC_PI_2);
            let led = arc.led(0.0, arc.length);
            assert!((led - Vector2::new(9.0, 9.0 * side)).norm() < 1e-12);
        }
    }

    /// Turns of Euro NCAP's CPTA: radius (m), angle of each clothoid and of the arc (degrees), and how far the turn reaches
    /// along the road that it leaves and along that it enters, m. The first three are far-side turns at 10, 15 and 20 km/h, the last
    /// is a near-side turn at 10 km/h.
    #[test]
    fn turns_of_euro_ncap_reach_as_far_as_in_its_protocol() {
        let turns = [
            (9.0, 20.62, 48.76, 12.380),
            (11.75, 20.93, 48.14, 16.217),
            (14.75, 21.79, 46.42, 20.577),
            (8.0, 22.85, 44.3, 11.351),
        ];
        for (radius, clothoid, arc, reach) in turns {
            for side in [1.0, -1.0] {
                let pieces = Piece::turn(
                    1500.0 * side,
                    radius * side,
                    f64::to_radians(clothoid),
                    f64::to_radians(arc),
                );
                let (mut at, mut heading) = (Vector2::zeros(), 0.0);
                for piece in pieces {
                    at += piece.led(heading, piece.length);
                    heading += piece.turned(piece.length);
                }
                assert!((heading - side * std::f64::consts::FRAC_PI_2).abs() < 1e-12, "{heading}");
                let found = (at.x, at.y * side);
                assert!(
                    (found.0 - reach).abs() < 5e-4 && (found.1 - reach).abs() < 5e-4,
                    "{radius}: {found:?}"
                );
            }
        }
    }
}
