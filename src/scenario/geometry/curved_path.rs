//! What is driven: a line at a constant distance beside a reference line, in one direction, with a length of its own.

use std::sync::Arc;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::piece::{Frame, Pose};
use super::{GeometryError, ReferenceLine};
use crate::{Conflict, Direction};

/// The course at a constant distance beside a reference line. Places are metres along the course itself, in the direction of
/// travel, from where it passes its origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct CurvedPath {
    line: Arc<ReferenceLine>,
    /// To the left of the reference line, m.
    offset: f64,
    direction: Direction,
    /// Station of the reference line abreast of which places are 0, m.
    origin: f64,
    /// The course's own length from its beginning to the origin, m.
    before_origin: f64,
    /// The course's own length to where each piece begins, m, and in the end all of it.
    lengths: Vec<f64>,
    /// Stations (m) between which it hardly turns, both ends among them.
    stops: Vec<f64>,
    /// Where it bends without a break, in the order of stations.
    bends: Vec<Bending>,
}

/// A stretch in which a course bends.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bending {
    /// Stations at which it begins and ends, m.
    stations: (f64, f64),
    /// The places abreast of them, m.
    places: (f64, f64),
}

#[derive(Serialize, Deserialize)]
struct Written {
    line: Arc<ReferenceLine>,
    offset: f64,
    direction: Direction,
    origin: f64,
}

/// Where a point lies, seen from a course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathProjection {
    /// The place that is nearest to it, m.
    pub place: f64,
    /// How far it is to the left of the course there, in the direction of travel, m.
    pub left: f64,
    /// Of the course there, to the left in the direction of travel, 1/m.
    pub curvature: f64,
    /// See [`LineProjection::ambiguous`](super::LineProjection::ambiguous).
    pub ambiguous: bool,
}

/// A course may come no nearer to the centre of a bend than this share of its radius leaves.
const LARGEST_SHARE: f64 = 0.95;

/// Between two stops it turns no more than this, rad: whoever crosses it twice there walks along it.
const TURN_BETWEEN: f64 = 0.25;

/// Where a curvature is told as if it changed evenly, it is right to this, 1/m.
pub const EVEN: f64 = 1e-3;

/// A crossing is found to this, m.
const CLOSE: f64 = 1e-12;

impl CurvedPath {
    /// The course `offset` m to the left of a reference line (as the line runs), driven along it or against it, with places
    /// counted from abreast of its station `origin` (m).
    ///
    /// # Errors
    /// If a piece bends so tightly that the course would have a kink there.
    pub fn new(
        line: Arc<ReferenceLine>,
        offset: f64,
        direction: Direction,
        origin: f64,
    ) -> Result<Self, GeometryError> {
        for (index, piece) in line.pieces().enumerate() {
            if piece.tightest() * offset.abs() >= LARGEST_SHARE {
                let (radius, least) = (1.0 / piece.tightest(), offset.abs() / LARGEST_SHARE);
                return Err(GeometryError::TooTight { piece: index + 1, radius, offset, least });
            }
        }
        Ok(Self::beside(line, offset, direction, origin))
    }

    /// The same where [`Self::new`] would find nothing wrong.
    pub fn beside(line: Arc<ReferenceLine>, offset: f64, direction: Direction, origin: f64) -> Self {
        let mut lengths: Vec<f64> = line.placed().map(|(_, from, turned)| from - offset * turned).collect();
        lengths.push(line.length() - offset * line.turned(line.length()));
        let mut stops = vec![0.0];
        for (piece, from, _) in line.placed() {
            let parts = (piece.tightest() * piece.length / TURN_BETWEEN).ceil().max(1.0) as usize;
            stops.extend((1..=parts).map(|part| from + piece.length * part as f64 / parts as f64));
        }
        let before_origin = origin - offset * line.turned(origin);
        let mut path =
            Self { line, offset, direction, origin, before_origin, lengths, stops, bends: Vec::new() };
        path.bends = path.bending();
        path
    }

    fn bending(&self) -> Vec<Bending> {
        let mut found: Vec<(f64, f64)> = Vec::new();
        for (piece, start, _) in self.line.placed().filter(|(piece, ..)| piece.tightest() > 0.0) {
            let end = start + piece.length;
            match found.last_mut() {
                Some((_, last)) if *last == start => *last = end,
                _ => found.push((start, end)),
            }
        }
        let abreast = |stations: (f64, f64)| Bending {
            stations,
            places: (self.place_abreast(stations.0), self.place_abreast(stations.1)),
        };
        found.into_iter().map(abreast).collect()
    }

    /// The course `offset` m farther to the left of the reference line.
    pub fn moved(&self, offset: f64) -> Self {
        Self::beside(self.line.clone(), self.offset + offset, self.direction, self.origin)
    }

    /// Station of the reference line abreast of which places are 0, m.
    pub fn origin(&self) -> f64 {
        self.origin
    }

    /// What it lies beside.
    pub fn line(&self) -> &ReferenceLine {
        &self.line
    }

    /// Which way it is driven: along its reference line or against it.
    pub fn direction(&self) -> Direction {
        self.direction
    }

    /// To the left of the reference line, m.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// The places (m) between which it is not simply straight, in the direction of travel.
    pub fn extent(&self) -> (f64, f64) {
        let (one, other) = (self.place_abreast(0.0), self.place_abreast(self.line.length()));
        (one.min(other), one.max(other))
    }

    /// The place abreast of a station (m) of the reference line.
    pub fn place_abreast(&self, station: f64) -> f64 {
        let length = station - self.offset * self.line.turned(station);
        self.direction.sign() * (length - self.before_origin)
    }

    /// The station (m) of the reference line abreast of a place.
    pub fn station(&self, place: f64) -> f64 {
        let length = self.before_origin + self.direction.sign() * place;
        let all = self.lengths[self.lengths.len() - 1];
        if length < 0.0 {
            return length;
        }
        if length >= all {
            return self.line.length() + (length - all);
        }
        // The piece in which it lies; the last length is that of the end.
        let found = self.lengths[1..].iter().position(|end| length < *end).unwrap_or(0);
        let Some((piece, from)) = self.line.piece(found) else { return length };
        from + self.way(piece, length - self.lengths[found])
    }

    /// How far along a piece (m) one is who has driven so far (m) along the course since it began.
    fn way(&self, piece: &super::Piece, driven: f64) -> f64 {
        let (bend, change) = (1.0 - self.offset * piece.from, -self.offset * piece.change() / 2.0);
        match change {
            0.0 => driven / bend,
            _ => 2.0 * driven / (bend + libm::sqrt(bend * bend + 4.0 * change * driven)),
        }
    }

    /// The pose at a place: heading in the direction of travel, curvature to the left of it.
    pub fn pose(&self, place: f64) -> Pose {
        let pose = self.line.pose(self.station(place));
        let point = pose.point + pose.normal() * self.offset;
        let curvature = pose.curvature / (1.0 - pose.curvature * self.offset);
        match self.direction {
            Direction::Forward => Pose { point, heading: pose.heading, curvature },
            Direction::Backward => {
                Pose { point, heading: pose.heading + std::f64::consts::PI, curvature: -curvature }
            }
        }
    }

    /// The curvature (1/m, to the left in the direction of travel) at a place (m).
    pub fn curvature(&self, place: f64) -> f64 {
        self.bend(self.line.curvature(self.station(place)))
    }

    /// A curvature of the line (1/m, to its left) as the course has it, to the left in the direction of travel.
    fn bend(&self, curvature: f64) -> f64 {
        self.direction.sign() * curvature / (1.0 - curvature * self.offset)
    }

    /// How the curvature changes: places (m) in the direction of travel, with the curvature there (1/m, to the left in that direction).
    ///
    /// Between two of them it changes evenly, before the first and behind the last it is 0; two of one place are a jump. Beside the line
    /// the curvature of a clothoid does not change evenly: there it is divided until it is right to 0.001 1/m.
    pub fn curvature_changes(&self) -> Vec<(f64, f64)> {
        let mut all: Vec<(f64, f64)> = Vec::new();
        let mut pieces = self.line.placed().peekable();
        while let Some((piece, from, _)) = pieces.next() {
            let to = pieces.peek().map_or(self.line.length(), |(_, next, _)| *next);
            let parts = self.even_parts(piece);
            all.extend((0..=parts).map(|part| {
                let way = piece.length * part as f64 / parts as f64;
                let (station, curvature) = match part {
                    0 => (from, piece.from),
                    _ if part == parts => (to, piece.to),
                    _ => (from + way, piece.curvature(way)),
                };
                (self.place_abreast(station), self.bend(curvature))
            }));
        }
        if self.direction == Direction::Backward {
            all.reverse();
        }
        let ends = [all.first(), all.last()].map(|end| end.map_or(0.0, |(place, _)| *place));
        let all: Vec<_> = [(ends[0], 0.0)].into_iter().chain(all).chain([(ends[1], 0.0)]).collect();
        let mut changes: Vec<(f64, f64)> = Vec::new();
        for (index, one) in all.iter().enumerate() {
            let before = changes.last().map_or(0.0, |(_, curvature)| *curvature);
            let after = all.get(index + 1).map_or(0.0, |(_, curvature)| *curvature);
            let stays = one.1 == before && one.1 == after;
            if !stays && changes.last() != Some(one) {
                changes.push(*one);
            }
        }
        changes
    }

    /// Into how many parts a piece is divided within which the curvature beside it changes evenly to [`EVEN`].
    fn even_parts(&self, piece: &super::Piece) -> usize {
        if self.offset == 0.0 || piece.from == piece.to {
            return 1;
        }
        // With b = 1 - κ d, the length along the course is the integral of b, and the second derivative of κ / b by it is 3 d κ'² / b⁵.
        let change = (piece.to - piece.from) / piece.length;
        let shares = [piece.from, piece.to].map(|curvature| 1.0 - curvature * self.offset);
        let (least, most) = (shares[0].min(shares[1]), shares[0].max(shares[1]));
        let bent = 3.0 * self.offset.abs() * change * change / (least * least * least * least * least);
        // Of a chord over the length h the error is h² / 8 times that at most.
        (piece.length * most * libm::sqrt(bent / (8.0 * EVEN))).ceil().max(1.0) as usize
    }

    /// The largest curvature (1/m, never negative) between two places (m).
    pub fn tightest_between(&self, from: f64, to: f64) -> f64 {
        let (least, most) = self.bends_between(from, to);
        most.max(-least)
    }

    /// The same with a unit vector for its heading, and sooner.
    pub(crate) fn frame(&self, place: f64) -> Frame {
        self.beside_line(self.line.frame(self.station(place)))
    }

    /// The same but for [`Self::roughness`], and sooner still.
    pub(crate) fn rough_frame(&self, place: f64) -> Frame {
        self.beside_line(self.line.rough_frame(self.station(place)))
    }

    /// What rough frames are wrong by at most: their points, m, and their tangents, of 1.
    pub(crate) fn roughness(&self) -> (f64, f64) {
        let (point, tangent) = self.line.roughness();
        (point + self.offset.abs() * tangent, tangent)
    }

    /// A frame of the line as the course has it abreast of that.
    fn beside_line(&self, frame: Frame) -> Frame {
        let (sign, curvature) = (self.direction.sign(), frame.curvature);
        Frame {
            point: frame.point + frame.normal() * self.offset,
            tangent: frame.tangent * sign,
            curvature: sign * curvature / (1.0 - curvature * self.offset),
        }
    }

    /// The point at a place, m.
    pub fn point(&self, place: f64) -> Vector2<f64> {
        self.frame(place).point
    }

    /// Unit vector in the direction of travel at a place.
    pub fn tangent(&self, place: f64) -> Vector2<f64> {
        self.frame(place).tangent
    }

    /// The smallest and the largest curvature (1/m, to the left in the direction of travel) between two places (m).
    pub fn bends_between(&self, from: f64, to: f64) -> (f64, f64) {
        let [one, other] = [from, to].map(|place| self.before_origin + self.direction.sign() * place);
        let (low, high) = (one.min(other), one.max(other));
        let mut found = (f64::INFINITY, f64::NEG_INFINITY);
        let mut take = |bend: f64| found = (found.0.min(bend), found.1.max(bend));
        for (index, (piece, start, _)) in self.line.placed().enumerate() {
            let (begins, ends) = (self.lengths[index], self.lengths[index + 1]);
            if begins > high {
                break;
            }
            if ends < low {
                continue;
            }
            if piece.from == piece.to {
                take(self.bend(piece.from));
                continue;
            }
            for length in [low, high] {
                let way = if length < begins {
                    0.0
                } else if length >= ends {
                    piece.length
                } else {
                    // As a station has it.
                    start + self.way(piece, length - begins) - start
                };
                take(self.bend(piece.curvature(way.clamp(0.0, piece.length))));
            }
        }
        if low < 0.0 || high > self.lengths[self.lengths.len() - 1] {
            take(0.0);
        }
        found
    }

    /// How far a rigid body of this length and width (m) whose middle follows the course sweeps to the right and to the left of it about
    /// a place, m: half its width where it goes straight. In a bend its corners swing out, by the tightest bend that is under it.
    pub fn swept(&self, place: f64, (length, width): (f64, f64)) -> (f64, f64) {
        swung_out(self.bends_between(place - length / 2.0, place + length / 2.0), (length, width))
    }

    /// The most that it sweeps anywhere.
    pub fn most_swept(&self, size: (f64, f64)) -> (f64, f64) {
        let (from, to) = self.extent();
        swung_out(self.bends_between(from - 1.0, to + 1.0), size)
    }

    /// How far (m) it goes straight on from a place; infinite after its last bend.
    pub fn straight_ahead(&self, place: f64) -> f64 {
        let station = self.station(place);
        let (begins, at) = match self.direction {
            Direction::Forward => match self.bends.iter().find(|bend| bend.stations.1 > station) {
                Some(bend) => (bend.stations.0 > station, bend.places.0),
                None => return f64::INFINITY,
            },
            Direction::Backward => match self.bends.iter().rfind(|bend| bend.stations.0 < station) {
                Some(bend) => (bend.stations.1 < station, bend.places.1),
                None => return f64::INFINITY,
            },
        };
        if begins { at - place } else { 0.0 }
    }

    /// How far (m) the bend goes on in which a place is, until the course goes straight on; 0 where it does.
    pub fn bend_ahead(&self, place: f64) -> f64 {
        let station = self.station(place);
        let inside = |bend: &&Bending| {
            let (start, end) = bend.stations;
            match self.direction {
                Direction::Forward => start <= station && station < end,
                Direction::Backward => start < station && station <= end,
            }
        };
        let end = |bend: &Bending| match self.direction {
            Direction::Forward => bend.places.1,
            Direction::Backward => bend.places.0,
        };
        self.bends.iter().find(inside).map_or(0.0, |bend| end(bend) - place)
    }

    /// Where a point lies.
    pub fn project(&self, point: Vector2<f64>) -> PathProjection {
        self.project_with_heading(point).0
    }

    /// The same with the unit vector in the direction of travel there.
    pub(crate) fn project_with_heading(&self, point: Vector2<f64>) -> (PathProjection, Vector2<f64>) {
        let (found, frame) = self.line.project_with_frame(point);
        let (place, sign) = (self.place_abreast(found.station), self.direction.sign());
        let projection = PathProjection {
            place,
            left: sign * (found.left - self.offset),
            curvature: sign * found.curvature / (1.0 - found.curvature * self.offset),
            ambiguous: found.ambiguous,
        };
        (projection, frame.tangent * sign)
    }
}

impl CurvedPath {
    /// Where the straight line through `from` along the unit vector `way` crosses it, in any order.
    pub fn crossings(&self, from: Vector2<f64>, way: Vector2<f64>) -> impl Iterator<Item = Conflict> {
        let off = move |station: f64| way.perp(&(self.point_abreast(station) - from));
        let last = self.stops.len() - 1;
        let (end, before) = (self.stops[last], -1.0);
        // Beyond its ends it goes straight on, so that there the crossing is where a straight line has it.
        let rays = [(0.0, before, off(0.0), off(before)), (end, end + 1.0, off(end), off(end + 1.0))];
        let beyond = rays.into_iter().filter_map(|(from, to, at, next)| {
            let share = at / (at - next);
            let counts = share > 0.0 || (share == 0.0 && to > from);
            (share.is_finite() && counts).then_some(from + share * (to - from))
        });
        let inside = (0..last).filter_map(move |index| {
            let (low, high) = (self.stops[index], self.stops[index + 1]);
            root(off, (low, off(low)), (high, off(high)))
        });
        beyond.chain(inside).map(move |station| Conflict {
            place: self.place_abreast(station),
            distance: (self.point_abreast(station) - from).dot(&way),
        })
    }

    fn point_abreast(&self, station: f64) -> Vector2<f64> {
        self.beside_line(self.line.frame(station)).point
    }
}

/// How far a rigid body of this length and width (m) comes to the right and to the left of the course by the smallest and the largest
/// curvature under it (1/m, to the left).
fn swung_out((least, most): (f64, f64), (length, width): (f64, f64)) -> (f64, f64) {
    let half = width / 2.0;
    let swings_out = |bend: f64| {
        if bend <= 0.0 {
            return half;
        }
        let radius = 1.0 / bend;
        libm::hypot(radius + half, length / 2.0) - radius
    };
    (swings_out(most), swings_out(-least))
}

/// Where a function is 0 whose values at both ends differ in sign: by the false position with halving (Illinois). The end of one
/// stretch is the beginning of the next, where it counts.
fn root(value: impl Fn(f64) -> f64, mut one: (f64, f64), mut other: (f64, f64)) -> Option<f64> {
    if one.1 == 0.0 {
        return Some(one.0);
    }
    if other.1 == 0.0 || (one.1 < 0.0) == (other.1 < 0.0) {
        return None;
    }
    for _ in 0..100 {
        let next = (one.0 * other.1 - other.0 * one.1) / (other.1 - one.1);
        let found = (next, value(next));
        if found.1 == 0.0 || (next - other.0).abs() < CLOSE {
            return Some(next);
        }
        if (found.1 < 0.0) != (other.1 < 0.0) {
            one = other;
        } else {
            one.1 /= 2.0;
        }
        other = found;
    }
    Some(other.0)
}

impl TryFrom<Written> for CurvedPath {
    type Error = GeometryError;

    fn try_from(written: Written) -> Result<Self, GeometryError> {
        Self::new(written.line, written.offset, written.direction, written.origin)
    }
}

impl From<CurvedPath> for Written {
    fn from(path: CurvedPath) -> Self {
        Self { line: path.line, offset: path.offset, direction: path.direction, origin: path.origin }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geometry::Piece;

    fn bend(side: f64) -> Arc<ReferenceLine> {
        let (wide, tight) = (1.0 / 1500.0 * side, 1.0 / 9.0 * side);
        let pieces = [
            Piece::line(15.0),
            Piece::clothoid(6.4, wide, tight),
            Piece::arc(9.0 * side, 0.85),
            Piece::clothoid(6.4, tight, wide),
            Piece::line(10.0),
            Piece::arc(-30.0 * side, 1.0),
        ];
        Arc::new(ReferenceLine::new(Pose::origin(), &pieces).unwrap())
    }

    proptest! {
        #[test]
        fn between_its_changes_the_curvature_is_what_they_say(
            offset in prop::sample::select(vec![0.0, 3.5, -3.5, 6.0]), backward: bool, left: bool, place in -60.0..80.0,
        ) {
            let direction = if backward { Direction::Backward } else { Direction::Forward };
            let path = CurvedPath::new(bend(if left { 1.0 } else { -1.0 }), offset, direction, 20.0).unwrap();
            let changes = path.curvature_changes();
            prop_assert!(changes.is_sorted_by(|one, other| one.0 <= other.0));
            let next = changes.partition_point(|(at, _)| *at <= place);
            let told = match (next.checked_sub(1), changes.get(next)) {
                (Some(before), Some(after)) => {
                    let before = changes[before];
                    before.1 + (after.1 - before.1) * (place - before.0) / (after.0 - before.0)
                }
                _ => 0.0,
            };
            let apart = (told - path.curvature(place)).abs();
            let tolerance = if offset == 0.0 { 1e-12 } else { EVEN };
            prop_assert!(apart < tolerance, "{apart} at {place}, {} changes", changes.len());
            prop_assert!((path.curvature(place) - path.pose(place).curvature).abs() < 1e-15);
            // In the middle of lane 0 there are no more than there are: three jumps and an end, two each, and where the clothoids meet the arc.
            prop_assert!(offset != 0.0 || changes.len() == 10, "{changes:?}");
        }

        #[test]
        fn its_length_is_that_of_its_chords(offset in -4.0..4.0, backward: bool) {
            let direction = if backward { Direction::Backward } else { Direction::Forward };
            let path = CurvedPath::new(bend(1.0), offset, direction, 20.0).unwrap();
            let line = path.line();
            let steps = 40_000;
            let at = |step: i32| line.length() * f64::from(step) / f64::from(steps);
            let point = |step| {
                let pose = line.pose(at(step));
                pose.point + pose.normal() * offset
            };
            let chords: f64 = (0..steps).map(|step| (point(step + 1) - point(step)).norm()).sum();
            let (low, high) = path.extent();
            prop_assert!((high - low - chords).abs() < 1e-6, "{} m, not {chords} m", high - low);
        }

        #[test]
        fn a_place_is_found_again(
            offset in -7.0..7.0, backward: bool, place in -40.0..90.0, left in -1.0..1.0f64, side: bool,
        ) {
            let direction = if backward { Direction::Backward } else { Direction::Forward };
            let side = if side { 1.0 } else { -1.0 };
            let path = CurvedPath::new(bend(side), offset, direction, 20.0).unwrap();
            prop_assert!((path.place_abreast(path.station(place)) - place).abs() < 1e-11);
            let pose = path.pose(place);
            let found = path.project(pose.point + pose.normal() * left);
            prop_assert!((found.place - place).abs() < 1e-8 && (found.left - left).abs() < 1e-9, "{found:?}");
            let (frame, rough, roughness) = (path.frame(place), path.rough_frame(place), path.roughness());
            prop_assert!((frame.point - rough.point).norm() <= roughness.0 && roughness.0 < 0.02, "{roughness:?}");
            prop_assert!((frame.tangent - rough.tangent).norm() <= roughness.1 && roughness.1 < 0.01, "{roughness:?}");
            let curvature = pose.curvature;
            prop_assert!((found.curvature - curvature).abs() < 1e-6 || curvature != path.pose(place + 1e-6).curvature);
            // Its tangent is where it goes, and as fast as places say: no step of it is longer than its arc.
            let next = path.pose(place + 1e-5).point - pose.point;
            prop_assert!((next / 1e-5 - pose.tangent()).norm() < 1e-4);
        }

        #[test]
        fn the_tightest_bend_is_no_less_than_any_between(
            offset in -7.0..7.0, from in -30.0..60.0, long in 0.0..20.0, share in 0.0..1.0,
        ) {
            let path = CurvedPath::new(bend(1.0), offset, Direction::Backward, 20.0).unwrap();
            let tightest = path.tightest_between(from, from + long);
            let within = path.pose(from + share * long).curvature;
            prop_assert!(within.abs() <= tightest + 1e-12);
            let (least, most) = path.bends_between(from, from + long);
            prop_assert!(least - 1e-12 <= within && within <= most + 1e-12);
            // The whole of it sweeps as far as the farthest of its places does, and no farther.
            let (right, left) = path.most_swept((4.4, 1.8));
            let swept = (-60..100).map(|place| path.swept(f64::from(place), (4.4, 1.8)));
            let most = swept.fold((0.0_f64, 0.0_f64), |most, one| (most.0.max(one.0), most.1.max(one.1)));
            prop_assert!((right - most.0).abs() < 1e-9 && (left - most.1).abs() < 1e-9, "{most:?}, not {right} {left}");
            let straight = path.straight_ahead(from);
            prop_assert_eq!(straight > 0.0, path.tightest_between(from, from + straight.min(1e3) * 0.999) == 0.0);
            prop_assert!(straight > 1e3 || path.pose(from + straight + 1e-3).curvature != 0.0);
            let bend = path.bend_ahead(from);
            prop_assert!(bend == 0.0 || path.pose(from + bend * 0.999).curvature != 0.0);
            prop_assert!(path.pose(from + bend + 1e-9).curvature == 0.0, "it still bends");
            prop_assert_eq!(bend > 0.0, straight == 0.0);
        }
    }

    #[test]
    fn places_begin_at_the_origin() {
        for direction in [Direction::Forward, Direction::Backward] {
            let path = CurvedPath::new(bend(1.0), 3.5, direction, 20.0).unwrap();
            assert!((path.station(0.0) - 20.0).abs() < 1e-12);
            let there = path.line().pose(20.0);
            assert!((path.pose(0.0).point - there.point - there.normal() * 3.5).norm() < 1e-12);
        }
    }

    #[test]
    fn against_the_line_everything_is_the_other_way_round() {
        let forward = CurvedPath::new(bend(1.0), 2.0, Direction::Forward, 20.0).unwrap();
        let backward = CurvedPath::new(bend(1.0), 2.0, Direction::Backward, 20.0).unwrap();
        for place in [-25.0, -3.0, 0.0, 4.0, 60.0] {
            let (one, other) = (forward.pose(place), backward.pose(-place));
            assert_eq!((one.point, one.curvature), (other.point, -other.curvature));
            assert!((one.tangent() + other.tangent()).norm() < 1e-15);
        }
    }

    #[test]
    fn a_lane_inside_too_tight_a_bend_is_refused() {
        let made = |offset| CurvedPath::new(bend(1.0), offset, Direction::Forward, 0.0).map(drop);
        assert_eq!((made(8.54), made(-8.54)), (Ok(()), Ok(())));
        insta::assert_snapshot!(made(8.6).unwrap_err(), @"piece 2 has a radius of 9.000 m, too tight for a lane whose centre is 8.6 m beside the line: the radius must be above 9.053 m, or the lanes narrower");
        let read = serde_json::to_string(&CurvedPath::new(bend(1.0), 2.0, Direction::Forward, 0.0).unwrap());
        let tight = read.unwrap().replace("\"offset\":2.0", "\"offset\":9.0");
        assert!(serde_json::from_str::<CurvedPath>(&tight).unwrap_err().to_string().contains("too tight"));
    }
}
