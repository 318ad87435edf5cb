//! Pieces end to end: where a station lies, and which station is nearest to a point.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::GeometryError;
use super::piece::{Frame, Piece, Pose, arc_of_small, turned_onto, unit_of_small};

/// Pieces end to end, of which each begins where and as the one before ends. Stations are metres from its beginning along it;
/// beyond both ends it goes straight on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct ReferenceLine {
    /// Without curvature.
    start: Pose,
    pieces: Vec<PlacedPiece>,
    end: Pose,
    /// Unit vectors along it at both ends.
    directions: (Vector2<f64>, Vector2<f64>),
    length: f64,
    /// The largest curvature to the right (at most 0) and to the left (at least 0), 1/m.
    tightest: (f64, f64),
    /// What rough frames are wrong by at most: their points, m, and their tangents, of 1.
    roughness: (f64, f64),
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
    /// How its curvature changes, 1/m².
    change: f64,
    /// Station at which it begins, m.
    from: f64,
    /// Its pose there.
    start: Pose,
    /// Unit vector along it there.
    direction: Vector2<f64>,
    /// Half way along it; no point of it is farther from there than half its length.
    middle: Vector2<f64>,
    /// Of what bends: poses at even distances along it, both ends among them.
    knots: Vec<Knot>,
    /// The same closer together, for rough frames.
    marks: Marks,
}

/// Frames at even distances along a piece, both ends among them; none of what goes straight.
#[derive(Debug, Clone, PartialEq, Default)]
struct Marks {
    /// From one to the next, m.
    apart: f64,
    frames: Vec<Frame>,
}

/// A pose along a piece, from which its neighbourhood is worked out.
#[derive(Debug, Clone, PartialEq)]
struct Knot {
    /// How far along the piece, m.
    at: f64,
    pose: Pose,
    /// Unit vector along it.
    tangent: Vector2<f64>,
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

/// … and between those of anything that bends it turns no more than this, rad.
const TURN_BETWEEN: f64 = 0.25;

/// Marks of anything that bends are no farther apart than this, m.
const MARKS: f64 = 0.5;

/// Places and weights of the 4-point rule of Gauss and Legendre on (0, 1): right to 1e-14 m between two knots.
const GAUSS_4: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Above what rounding does to frames, m and of 1.
const ROUNDING: f64 = 1e-9;

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
        let (mut tightest, mut roughness) = ((0.0_f64, 0.0_f64), (0.0_f64, 0.0_f64));
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
            let (point, tangent) = next.roughness();
            roughness = (roughness.0.max(point), roughness.1.max(tangent));
            placed.push(next);
        }
        let end = Pose { curvature: 0.0, ..at };
        let directions = (start.tangent(), end.tangent());
        Ok(Self { start, pieces: placed, end, directions, length: from, tightest, roughness })
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
            Place::Before => Pose { point: self.start.point + self.directions.0 * station, ..self.start },
            Place::On(placed) => placed.pose(station - placed.from),
            Place::Beyond => {
                Pose { point: self.end.point + self.directions.1 * (station - self.length), ..self.end }
            }
        }
    }

    /// The same with a unit vector for its heading, and sooner.
    pub(crate) fn frame(&self, station: f64) -> Frame {
        self.frame_by(station, PlacedPiece::frame)
    }

    /// The same but for [`Self::roughness`], and sooner still.
    pub(crate) fn rough_frame(&self, station: f64) -> Frame {
        self.frame_by(station, PlacedPiece::rough_frame)
    }

    /// What rough frames are wrong by at most: their points, m, and their tangents, of 1.
    pub(crate) fn roughness(&self) -> (f64, f64) {
        self.roughness
    }

    #[inline]
    fn frame_by(&self, station: f64, on: impl Fn(&PlacedPiece, f64) -> Frame) -> Frame {
        let straight = |end: &Pose, direction: Vector2<f64>, beyond: f64| Frame {
            point: end.point + direction * beyond,
            tangent: direction,
            curvature: 0.0,
        };
        match self.place(station) {
            Place::Before => straight(&self.start, self.directions.0, station),
            Place::On(placed) => on(placed, station - placed.from),
            Place::Beyond => straight(&self.end, self.directions.1, station - self.length),
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
        self.project_with_frame(point).0
    }

    /// The same with the frame there.
    pub(crate) fn project_with_frame(&self, point: Vector2<f64>) -> (LineProjection, Frame) {
        let before = (point - self.start.point).dot(&self.directions.0).min(0.0);
        let beyond = (point - self.end.point).dot(&self.directions.1).max(0.0);
        let ends = [before, self.length + beyond].map(|station| {
            let frame = self.frame(station);
            (station, frame, (point - frame.point).norm())
        });
        let mut nearest = if ends[1].2 < ends[0].2 { ends[1] } else { ends[0] };
        let mut look_at = |placed: &PlacedPiece| {
            let (way, frame) = placed.nearest(point);
            let distance = (point - frame.point).norm();
            if distance < nearest.2 {
                nearest = (placed.from + way, frame, distance);
            }
            nearest.2
        };
        // Most likely it is on the piece that may come nearest, after which no other need be looked at.
        let may_come = |placed: &PlacedPiece| (point - placed.middle).norm() - placed.piece.length / 2.0;
        let first = (0..self.pieces.len())
            .min_by(|one, other| may_come(&self.pieces[*one]).total_cmp(&may_come(&self.pieces[*other])));
        let mut least = first.map_or(f64::INFINITY, |first| look_at(&self.pieces[first]));
        for (index, placed) in self.pieces.iter().enumerate() {
            if Some(index) != first && may_come(placed) <= least {
                least = look_at(placed);
            }
        }
        let (station, frame, _) = nearest;
        let left = (point - frame.point).dot(&frame.normal());
        let towards = if left < 0.0 { self.tightest.0 } else { self.tightest.1 };
        let ambiguous = towards * left >= 1.0;
        (LineProjection { station, left, curvature: frame.curvature, ambiguous }, frame)
    }

    /// A piece with the station at which it begins (m).
    pub(super) fn piece(&self, index: usize) -> Option<(&Piece, f64)> {
        self.pieces.get(index).map(|placed| (&placed.piece, placed.from))
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
        let direction = start.tangent();
        let (change, middle) = (piece.change(), start.point);
        let (knots, marks) = (Vec::new(), Marks::default());
        let mut placed = Self { piece, change, from, start, direction, middle, knots, marks };
        placed.middle = placed.exact(piece.length / 2.0).point;
        let turning = piece.tightest() * piece.length;
        if turning > 0.0 {
            let along = if change != 0.0 { piece.length / KNOTS } else { 1.0 };
            let parts = along.max(turning / TURN_BETWEEN).ceil().max(1.0) as usize;
            let knot = |part: usize| {
                let at = piece.length * part as f64 / parts as f64;
                let pose = placed.exact(at);
                Knot { at, tangent: pose.tangent(), pose }
            };
            placed.knots = (0..=parts).map(knot).collect();
            let parts = (piece.length / MARKS).ceil().max(1.0);
            let apart = piece.length / parts;
            let frames = (0..=parts as usize).map(|mark| placed.frame(mark as f64 * apart)).collect();
            placed.marks = Marks { apart, frames };
        }
        placed
    }

    /// What rough frames on it are wrong by at most: their points, m, and their tangents, of 1.
    fn roughness(&self) -> (f64, f64) {
        // With the largest way w from a mark, the curvature κ and its change κ': κ w is the angle that is taken, κ' w²/2 what it lacks.
        let way = self.marks.apart / 2.0;
        let (angle, lacks) = (self.piece.tightest() * way, self.change.abs() * way * way / 2.0);
        let turned = angle + lacks;
        let point = way * (turned * turned / 6.0 + turned * turned * turned / 24.0 + lacks / 3.0);
        (point + ROUNDING, lacks + turned * turned * turned + ROUNDING)
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

    /// The knot before a way of so many m, and how far it is from there.
    fn knot(&self, way: f64) -> Option<(&Knot, f64)> {
        let parts = self.knots.len().checked_sub(1)?;
        let index = ((way / self.piece.length * parts as f64) as usize).min(parts - 1);
        let knot = &self.knots[index];
        Some((knot, way - knot.at))
    }

    /// The pose after `way` m, from the knot before it.
    fn pose(&self, way: f64) -> Pose {
        let Some((knot, rest)) = self.knot(way) else {
            return Pose { point: self.start.point + self.direction * way, curvature: 0.0, ..self.start };
        };
        let turned = self.turned_from(knot, rest);
        let curvature = knot.pose.curvature + self.change * rest;
        Pose { point: self.led_from(knot, rest), heading: knot.pose.heading + turned, curvature }
    }

    /// The same with a unit vector for its heading.
    fn frame(&self, way: f64) -> Frame {
        let Some((knot, rest)) = self.knot(way) else {
            let point = self.start.point + self.direction * way;
            return Frame { point, tangent: self.direction, curvature: 0.0 };
        };
        Frame {
            point: self.led_from(knot, rest),
            tangent: turned_onto(unit_of_small(self.turned_from(knot, rest)), knot.tangent),
            curvature: knot.pose.curvature + self.change * rest,
        }
    }

    /// The same but for what is neglected of the second order and above, from the nearest mark.
    fn rough_frame(&self, way: f64) -> Frame {
        let Marks { apart, frames } = &self.marks;
        let Some(last) = frames.len().checked_sub(1) else { return self.frame(way) };
        let mark = ((way / apart + 0.5) as usize).min(last);
        let (frame, rest) = (&frames[mark], way - mark as f64 * apart);
        let (normal, angle) = (frame.normal(), frame.curvature * rest);
        Frame {
            point: frame.point + (frame.tangent + normal * (angle / 2.0)) * rest,
            tangent: (frame.tangent + normal * angle) * (1.0 - angle * angle / 2.0),
            curvature: frame.curvature + self.change * rest,
        }
    }

    /// How far it turns within `rest` m of a knot, rad.
    fn turned_from(&self, knot: &Knot, rest: f64) -> f64 {
        (knot.pose.curvature + self.change * rest / 2.0) * rest
    }

    /// Where it leads from a knot within `rest` m.
    fn led_from(&self, knot: &Knot, rest: f64) -> Vector2<f64> {
        if self.change == 0.0 {
            let led = arc_of_small(self.turned_from(knot, rest));
            return knot.pose.point + turned_onto(led, knot.tangent) * rest;
        }
        let led = GAUSS_4.iter().fold(Vector2::zeros(), |led: Vector2<f64>, (place, weight)| {
            led + unit_of_small(self.turned_from(knot, rest * place)) * *weight
        });
        knot.pose.point + turned_onto(led, knot.tangent) * rest
    }

    /// How far along it the point of it is that is nearest to `point`, m, and the frame there.
    fn nearest(&self, point: Vector2<f64>) -> (f64, Frame) {
        if self.change != 0.0 {
            return self.nearest_of_clothoid(point);
        }
        let (offset, length) = (point - self.start.point, self.piece.length);
        let ahead = offset.dot(&self.direction);
        if self.piece.from == 0.0 {
            let way = ahead.clamp(0.0, length);
            return (way, self.frame(way));
        }
        // Seen from the centre of the circle, in the sense in which it is driven round.
        let (bend, left) = (self.piece.from, self.direction.perp(&offset));
        let angle = libm::atan2(ahead, (1.0 / bend - left) * bend.signum());
        let round = std::f64::consts::TAU;
        let driven = angle.rem_euclid(round) / bend.abs();
        let whole = round / bend.abs();
        let way = if driven <= length {
            driven
        } else if driven - length < whole - driven {
            length
        } else {
            0.0
        };
        (way, self.frame(way))
    }

    fn nearest_of_clothoid(&self, point: Vector2<f64>) -> (f64, Frame) {
        let length = self.piece.length;
        let apart = |knot: &Knot| (point - knot.pose.point).norm_squared();
        let mut nearest = (0, f64::INFINITY);
        for (index, knot) in self.knots.iter().enumerate() {
            let distance = apart(knot);
            if distance < nearest.1 {
                nearest = (index, distance);
            }
        }
        let knot = &self.knots[nearest.0];
        let from = knot.at;
        let at_knot = Frame { point: knot.pose.point, tangent: knot.tangent, curvature: knot.pose.curvature };
        let (mut way, mut frame) = (from, at_knot);
        for _ in 0..STEPS {
            let (offset, along) = (point - frame.point, frame.tangent);
            let left = offset.y * along.x - offset.x * along.y;
            let step = offset.dot(&along) / (1.0 - frame.curvature * left).max(0.1);
            let next = (way + step).clamp(0.0, length);
            let moved = (next - way).abs();
            (way, frame) = (next, self.frame(next));
            if moved < CLOSE {
                break;
            }
        }
        // Where it does not converge, which is far inside a bend, the knot is as good.
        if (point - frame.point).norm_squared() <= nearest.1 { (way, frame) } else { (from, at_knot) }
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

    use super::super::piece::unit;
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
                    let frame = line.frame(station + share * piece.length);
                    prop_assert!((frame.point - inside.point).norm() == 0.0);
                    prop_assert!((frame.tangent - inside.tangent()).norm() < 1e-13);
                    prop_assert_eq!(frame.curvature, inside.curvature);
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
