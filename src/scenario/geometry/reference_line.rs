//! Pieces end to end: where a station lies, and which station is nearest to a point.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::GeometryError;
use super::piece::{Piece, Pose, unit};

/// Pieces end to end, of which each begins where and as the one before ends. Stations are metres from its beginning along it;
/// beyond both ends it goes straight on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct ReferenceLine {
    /// Without curvature.
    start: Pose,
    pieces: Vec<PlacedPiece>,
    end: Pose,
    length: f64,
    /// The largest curvature to the right (at most 0) and to the left (at least 0), 1/m.
    tightest: (f64, f64),
}

/// What a line is made from.
#[derive(Serialize, Deserialize)]
struct Written {
    start: Pose,
    pieces: Vec<Piece>,
}

/// A piece where it lies.
#[derive(Debug, Clone, PartialEq)]
struct PlacedPiece {
    piece: Piece,
    /// Station at which it begins, m.
    from: f64,
    /// Its pose there.
    start: Pose,
    /// Half way along it; no point of it is farther from there than half its length.
    middle: Vector2<f64>,
    /// Of a clothoid: poses at even distances along it, both ends among them.
    knots: Vec<Pose>,
}

/// The nearest point of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineProjection {
    /// m
    pub station: f64,
    /// How far the point is to the left of the line there, m.
    pub left: f64,
    /// Of the line there, 1/m.
    pub curvature: f64,
    /// Whether the line bends towards the point within the distance of it, so that the nearest station may jump as it moves.
    pub ambiguous: bool,
}

/// Knots of a clothoid are no farther apart than this, m, …
const KNOTS: f64 = 1.0;

/// … and between them it turns no more than this, rad.
const TURN_BETWEEN: f64 = 0.25;

/// Places and weights of the 4-point rule of Gauss and Legendre on (0, 1): right to 1e-14 m between two knots.
const GAUSS_4: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Steps of Newton's method, at most; …
const STEPS: usize = 20;

/// … it ends with a step below this, m.
const CLOSE: f64 = 1e-12;

impl ReferenceLine {
    /// Pieces end to end from a pose, whose curvature does not matter.
    ///
    /// # Errors
    /// Without pieces, with one that has no length, and with numbers that are not finite.
    pub fn new(start: Pose, pieces: &[Piece]) -> Result<Self, GeometryError> {
        if pieces.is_empty() {
            return Err(GeometryError::Empty);
        }
        let start = Pose { curvature: 0.0, ..start };
        let (mut placed, mut from, mut at) = (Vec::with_capacity(pieces.len()), 0.0, start);
        let mut tightest = (0.0_f64, 0.0_f64);
        for (index, piece) in pieces.iter().enumerate() {
            let numbers = [piece.length, piece.from, piece.to, at.point.x, at.point.y, at.heading];
            if numbers.iter().any(|number| !number.is_finite()) {
                return Err(GeometryError::NotFinite { piece: index + 1 });
            }
            if piece.length <= 0.0 {
                return Err(GeometryError::Length { piece: index + 1, length: piece.length });
            }
            let next = PlacedPiece::new(*piece, from, at);
            at = next.exact(piece.length);
            from += piece.length;
            tightest.0 = tightest.0.min(piece.from).min(piece.to);
            tightest.1 = tightest.1.max(piece.from).max(piece.to);
            placed.push(next);
        }
        let end = Pose { curvature: 0.0, ..at };
        Ok(Self { start, pieces: placed, end, length: from, tightest })
    }

    /// m
    pub fn length(&self) -> f64 {
        self.length
    }

    /// In order.
    pub fn pieces(&self) -> impl ExactSizeIterator<Item = &Piece> {
        self.pieces.iter().map(|placed| &placed.piece)
    }

    /// Where it begins.
    pub fn start(&self) -> Pose {
        self.start
    }

    /// The pose at a station (m). Where curvature jumps it is that of the piece that begins there.
    pub fn pose(&self, station: f64) -> Pose {
        match self.place(station) {
            Place::Before => Pose { point: self.start.point + self.start.tangent() * station, ..self.start },
            Place::On(placed) => placed.pose(station - placed.from),
            Place::Beyond => {
                Pose { point: self.end.point + self.end.tangent() * (station - self.length), ..self.end }
            }
        }
    }

    /// How far it has turned (rad) between its beginning and a station (m).
    pub fn turned(&self, station: f64) -> f64 {
        match self.place(station) {
            Place::Before => 0.0,
            Place::On(placed) => {
                placed.start.heading - self.start.heading + placed.piece.turned(station - placed.from)
            }
            Place::Beyond => self.end.heading - self.start.heading,
        }
    }

    /// The curvature (1/m) at a station (m).
    pub fn curvature(&self, station: f64) -> f64 {
        match self.place(station) {
            Place::On(placed) => placed.piece.curvature(station - placed.from),
            Place::Before | Place::Beyond => 0.0,
        }
    }

    /// The station nearest to a point.
    pub fn project(&self, point: Vector2<f64>) -> LineProjection {
        let before = (point - self.start.point).dot(&self.start.tangent()).min(0.0);
        let beyond = (point - self.end.point).dot(&self.end.tangent()).max(0.0);
        let mut nearest = (before, (point - self.pose(before).point).norm());
        let mut look_at = |station: f64, found: Vector2<f64>| {
            let distance = (point - found).norm();
            if distance < nearest.1 {
                nearest = (station, distance);
            }
            nearest.1
        };
        let mut least = look_at(self.length + beyond, self.end.point + self.end.tangent() * beyond);
        for placed in &self.pieces {
            if (point - placed.middle).norm() - placed.piece.length / 2.0 <= least {
                let way = placed.nearest(point);
                least = look_at(placed.from + way, placed.pose(way).point);
            }
        }
        let station = nearest.0;
        let pose = self.pose(station);
        let left = (point - pose.point).dot(&pose.normal());
        let towards = if left < 0.0 { self.tightest.0 } else { self.tightest.1 };
        LineProjection { station, left, curvature: pose.curvature, ambiguous: towards * left >= 1.0 }
    }

    /// Each piece with the station at which it begins (m) and how far the line has turned there (rad).
    pub(super) fn placed(&self) -> impl Iterator<Item = (&Piece, f64, f64)> {
        self.pieces
            .iter()
            .map(|placed| (&placed.piece, placed.from, placed.start.heading - self.start.heading))
    }

    fn place(&self, station: f64) -> Place<'_> {
        if station < 0.0 {
            return Place::Before;
        }
        let found = self.pieces.iter().find(|placed| station < placed.end());
        found.map_or(Place::Beyond, Place::On)
    }
}

enum Place<'a> {
    Before,
    On(&'a PlacedPiece),
    Beyond,
}

impl PlacedPiece {
    fn new(piece: Piece, from: f64, start: Pose) -> Self {
        let mut placed = Self { piece, from, start, middle: start.point, knots: Vec::new() };
        placed.middle = placed.exact(piece.length / 2.0).point;
        if piece.change() != 0.0 {
            let turning = piece.tightest() * piece.length;
            let parts = (piece.length / KNOTS).max(turning / TURN_BETWEEN).ceil().max(1.0) as usize;
            let knot = |part: usize| placed.exact(piece.length * part as f64 / parts as f64);
            placed.knots = (0..=parts).map(knot).collect();
        }
        placed
    }

    fn end(&self) -> f64 {
        self.from + self.piece.length
    }

    /// The pose after `way` m, worked out from the beginning.
    fn exact(&self, way: f64) -> Pose {
        Pose {
            point: self.start.point + self.piece.led(self.start.heading, way),
            heading: self.start.heading + self.piece.turned(way),
            curvature: self.piece.curvature(way),
        }
    }

    /// The same from the knot before it.
    fn pose(&self, way: f64) -> Pose {
        if self.knots.is_empty() {
            return self.exact(way);
        }
        let parts = self.knots.len() - 1;
        let index = ((way / self.piece.length * parts as f64) as usize).min(parts - 1);
        let knot = &self.knots[index];
        let rest = way - self.piece.length * index as f64 / parts as f64;
        let change = self.piece.change();
        let angle = |way: f64| knot.heading + (knot.curvature + change * way / 2.0) * way;
        let led = GAUSS_4.iter().fold(Vector2::zeros(), |led: Vector2<f64>, (place, weight)| {
            led + unit(angle(rest * place)) * *weight
        });
        Pose {
            point: knot.point + led * rest,
            heading: angle(rest),
            curvature: knot.curvature + change * rest,
        }
    }

    /// How far along it the point of it is that is nearest to `point`, m.
    fn nearest(&self, point: Vector2<f64>) -> f64 {
        let (offset, length) = (point - self.start.point, self.piece.length);
        let ahead = offset.dot(&self.start.tangent());
        if !self.knots.is_empty() {
            return self.nearest_of_clothoid(point);
        }
        if self.piece.from == 0.0 {
            return ahead.clamp(0.0, length);
        }
        // Seen from the centre of the circle, in the sense in which it is driven round.
        let (bend, left) = (self.piece.from, offset.dot(&self.start.normal()));
        let angle = libm::atan2(ahead, (1.0 / bend - left) * bend.signum());
        let round = std::f64::consts::TAU;
        let driven = angle.rem_euclid(round) / bend.abs();
        let whole = round / bend.abs();
        if driven <= length {
            driven
        } else if driven - length < whole - driven {
            length
        } else {
            0.0
        }
    }

    fn nearest_of_clothoid(&self, point: Vector2<f64>) -> f64 {
        let length = self.piece.length;
        let apart = |knot: &Pose| (point - knot.point).norm_squared();
        let knots = self.knots.iter().enumerate();
        let first = knots.min_by(|(_, one), (_, other)| apart(one).total_cmp(&apart(other)));
        let Some((index, knot)) = first else { return 0.0 };
        let from = length * index as f64 / (self.knots.len() - 1) as f64;
        let (mut way, mut pose) = (from, *knot);
        for _ in 0..STEPS {
            let (offset, along) = (point - pose.point, pose.tangent());
            let left = offset.y * along.x - offset.x * along.y;
            let step = offset.dot(&along) / (1.0 - pose.curvature * left).max(0.1);
            let next = (way + step).clamp(0.0, length);
            let moved = (next - way).abs();
            (way, pose) = (next, self.pose(next));
            if moved < CLOSE {
                break;
            }
        }
        // Where it does not converge, which is far inside a bend, the knot is as good.
        if (point - pose.point).norm_squared() <= apart(knot) { way } else { from }
    }
}

impl TryFrom<Written> for ReferenceLine {
    type Error = GeometryError;

    fn try_from(written: Written) -> Result<Self, GeometryError> {
        Self::new(written.start, &written.pieces)
    }
}

impl From<ReferenceLine> for Written {
    fn from(line: ReferenceLine) -> Self {
        Self { start: line.start, pieces: line.pieces().copied().collect() }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn pieces() -> impl Strategy<Value = Vec<Piece>> {
        let piece =
            (1.0..40.0, -0.12..0.12, -0.12..0.12, 0..3).prop_map(|(length, from, to, kind)| match kind {
                0 => Piece::line(length),
                1 => Piece::clothoid(length, from, from),
                _ => Piece::clothoid(length, from, to),
            });
        proptest::collection::vec(piece, 1..7)
    }

    fn start() -> impl Strategy<Value = Pose> {
        (-50.0..50.0, -50.0..50.0, -4.0..4.0).prop_map(|(x, y, heading)| Pose {
            point: Vector2::new(x, y),
            heading,
            curvature: 0.0,
        })
    }

    /// Turned until it turns no more than a right angle in all, so that no other part of it is nearer.
    fn gentle(pieces: &[Piece]) -> Vec<Piece> {
        let all: f64 = pieces.iter().map(|piece| piece.tightest() * piece.length).sum();
        let less = (std::f64::consts::FRAC_PI_2 / all).min(1.0);
        pieces.iter().map(|piece| Piece { from: piece.from * less, to: piece.to * less, ..*piece }).collect()
    }

    proptest! {
        #[test]
        fn position_and_heading_go_on_from_piece_to_piece(start in start(), pieces in pieces()) {
            let line = ReferenceLine::new(start, &pieces).unwrap();
            let mut at = start;
            let mut station = 0.0;
            for piece in &pieces {
                let found = line.pose(station);
                prop_assert!((found.point - at.point).norm() < 1e-9 && (found.heading - at.heading).abs() < 1e-12);
                // In its inside it is what the piece leads to, though that is worked out from a knot.
                for share in [0.1, 0.37, 0.5, 0.93] {
                    let inside = line.pose(station + share * piece.length);
                    let led = at.point + piece.led(at.heading, share * piece.length);
                    prop_assert!((inside.point - led).norm() < 1e-11);
                }
                at.point += piece.led(at.heading, piece.length);
                at.heading += piece.turned(piece.length);
                station += piece.length;
            }
            prop_assert!((line.turned(station + 3.0) - (at.heading - start.heading)).abs() < 1e-12);
            prop_assert!((line.pose(station + 3.0).point - at.point - unit(at.heading) * 3.0).norm() < 1e-9);
            prop_assert!((line.pose(-3.0).point - start.point + unit(start.heading) * 3.0).norm() < 1e-12);
        }

        #[test]
        fn a_point_beside_the_line_is_found_again(
            start in start(), pieces in pieces(), share in -0.2..1.2, beside in -0.8..0.8f64,
        ) {
            let line = ReferenceLine::new(start, &gentle(&pieces)).unwrap();
            let station = share * line.length();
            let tightest = line.pieces().map(Piece::tightest).fold(1e-3, f64::max);
            let left = beside / tightest;
            let pose = line.pose(station);
            let found = line.project(pose.point + pose.normal() * left);
            let scale = 1.0 + left.abs();
            prop_assert!((found.left - left).abs() < 1e-9 * scale, "{found:?}, not {left}");
            prop_assert!((found.station - station).abs() < 1e-9 * scale, "{found:?}, not {station}");
            prop_assert!(!found.ambiguous);
        }

        #[test]
        fn nothing_of_a_line_is_nearer_than_its_projection(
            start in start(), pieces in pieces(), x in -150.0..150.0, y in -150.0..150.0,
        ) {
            let line = ReferenceLine::new(start, &pieces).unwrap();
            let point = start.point + Vector2::new(x, y);
            let found = line.project(point);
            let pose = line.pose(found.station);
            prop_assert!((pose.point + pose.normal() * found.left - point).norm() < 1e-6);
            for step in -200..=1200 {
                let other = line.pose(line.length() * f64::from(step) / 1000.0);
                prop_assert!((other.point - point).norm() >= found.left.abs() - 1e-9);
            }
        }

        #[test]
        fn the_mirror_image_of_a_line_finds_mirror_images(
            pieces in pieces(), x in -100.0..100.0, y in -100.0..100.0,
        ) {
            let other: Vec<Piece> = pieces.iter().map(|piece| piece.mirrored()).collect();
            let one = ReferenceLine::new(Pose::origin(), &pieces).unwrap().project(Vector2::new(x, y));
            let other = ReferenceLine::new(Pose::origin(), &other).unwrap().project(Vector2::new(x, -y));
            prop_assert!((one.station - other.station).abs() < 1e-9);
            prop_assert!((one.left + other.left).abs() < 1e-9);
            prop_assert_eq!(one.ambiguous, other.ambiguous);
        }

        #[test]
        fn it_is_read_back_as_it_was(start in start(), pieces in pieces()) {
            let line = ReferenceLine::new(start, &pieces).unwrap();
            let text = serde_json::to_string(&line).unwrap();
            prop_assert_eq!(serde_json::from_str::<ReferenceLine>(&text).unwrap(), line);
        }
    }

    #[test]
    fn inside_a_bend_nobody_knows_which_part_is_meant() {
        let pieces = [Piece::line(20.0), Piece::arc(9.0, std::f64::consts::FRAC_PI_2), Piece::line(20.0)];
        let line = ReferenceLine::new(Pose::origin(), &pieces).unwrap();
        let ambiguous = |x, y| line.project(Vector2::new(x, y)).ambiguous;
        assert!(ambiguous(20.0, 9.0) && ambiguous(15.0, 14.0));
        assert!(!ambiguous(20.0, 8.99) && !ambiguous(20.0, -50.0) && !ambiguous(29.0, 0.0));
    }

    #[test]
    fn what_is_no_line_is_refused() {
        let made = |pieces: &[Piece]| ReferenceLine::new(Pose::origin(), pieces).unwrap_err().to_string();
        let line = Piece::line(3.0);
        insta::assert_snapshot!(made(&[]), @"a line needs at least one piece");
        insta::assert_snapshot!(made(&[line, Piece::line(0.0)]), @"piece 2 is 0 m long; its length must be above 0 m");
        insta::assert_snapshot!(made(&[Piece::line(f64::NAN)]), @"piece 1 has a number that is not finite");
        insta::assert_snapshot!(made(&[line, Piece::arc(0.0, 1.0)]), @"piece 2 has a number that is not finite");
    }
}
