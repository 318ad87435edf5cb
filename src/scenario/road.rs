//! The road: lanes, kerbs, one crossing and boxes that block the view.
//!
//! World frame of a straight road: x runs along lane 0 in its direction of travel, y to the left of it. The origin is where the middle
//! of the crossing meets the centre line of lane 0, so lane i lies at y = i * lane width, the near kerb at
//! y = -lane width / 2 and the far kerb at y = (lanes - 1/2) * lane width. Metres.

use std::sync::Arc;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::direction::{Direction, Side};
use super::geometry::{CurvedPath, GeometryError, ReferenceLine};
use super::ground::Ground;
use super::path::Path;
use super::placement::Position;
use super::traffic_signal::{SeenSignal, TrafficSignal};

/// The road as everybody finds it. The world's frame is that of its lane 0: x runs along the lane in its direction of travel, y
/// to the left, and the origin is the middle of the crossing on the lane's centre line, m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Road {
    /// Empty for an inline road without a name.
    pub name: String,
    /// m
    pub lane_width: f64,
    /// From the near side to the far side; never empty.
    pub lanes: Vec<Lane>,
    /// m/s
    pub speed_limit: f64,
    /// Whether a kerb separates carriageway and pavement.
    pub kerbs: bool,
    /// Strips between its lanes where nobody drives, in the order of the lanes that they follow.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub medians: Vec<Median>,
    /// Where pedestrians are meant to cross; its middle is the origin of all places.
    pub crossing: Crossing,
    /// Where else they are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_crossings: Vec<OtherCrossing>,
    /// Parked vehicles and other boxes.
    pub boxes: Vec<Body>,
    /// How it bends; a road without it is straight and endless.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bend: Option<Bend>,
    /// Along lane 0: how steep it is and how well tyres hold on it.
    #[serde(default, skip_serializing_if = "Ground::is_unsaid")]
    pub ground: Ground,
}

/// How a road bends: the line that the centre of lane 0 follows, and where the crossing is on it. The world's frame is then that
/// of the line: starts, goals and boxes lie in it, whatever the road's direction there; [`Road::placed`] puts them there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bend {
    /// The centre line of lane 0; the others lie to the left of it.
    pub line: Arc<ReferenceLine>,
    /// Station of the middle of the crossing, m.
    pub crossing: f64,
}

/// A lane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Lane {
    /// Which way its traffic drives.
    pub direction: Direction,
}

/// A strip between two lanes where nobody drives.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Median {
    /// It lies between this lane and the next.
    pub after: usize,
    /// m
    pub width: f64,
    /// Whether people may wait on it.
    pub refuge: bool,
}

/// A crossing that is not the origin of all places.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OtherCrossing {
    /// As pedestrians say which they use.
    pub name: String,
    /// Its middle along the road, 0 being the middle of the first crossing, m.
    pub along: f64,
    /// What it is.
    pub crossing: Crossing,
}

/// Where pedestrians cross.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Crossing {
    /// Who has priority on it, and when.
    pub kind: CrossingKind,
    /// Extent along the road in m.
    pub width: f64,
}

/// Who has priority on a crossing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CrossingKind {
    /// Pedestrians have priority.
    Zebra,
    /// Vehicles have priority.
    Unmarked,
    /// Those have priority to whom a signal gives it.
    Signalised(TrafficSignal),
}

/// A rectangle along the road where it stands that blocks the view and the way, such as a parked car.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// By which criteria and reports speak of it. It decides nothing in a run, so it is no part of what identifies one; see
    /// [`Road::unnamed`].
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Centre in m.
    pub x: f64,
    /// Centre in m.
    pub y: f64,
    /// Extent along its heading in m.
    pub length: f64,
    /// Extent across its heading in m.
    pub width: f64,
    /// From the x axis to its length, rad; that of the road where it stands.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub heading: f64,
}

fn is_zero(angle: &f64) -> bool {
    *angle == 0.0
}

impl Body {
    /// Unit vector along its length.
    pub fn along(&self) -> Vector2<f64> {
        if self.heading == 0.0 {
            return Vector2::x();
        }
        Vector2::new(libm::cos(self.heading), libm::sin(self.heading))
    }
}

impl Bend {
    /// Unit vector to the left of the line, abreast of a point.
    fn normal(&self, point: Vector2<f64>) -> Vector2<f64> {
        self.line.pose(self.line.project(point).station).normal()
    }
}

impl Road {
    /// Without the names of its boxes: what decides a run.
    pub fn unnamed(&self) -> Self {
        let mut road = self.clone();
        road.boxes.iter_mut().for_each(|body| body.name.clear());
        road
    }

    /// A street with kerbs and a zebra crossing of 4 m, and nothing that stands on it.
    ///
    /// One lane of 4 m for each direction given, from the near side to the far side; `speed_limit` in m/s.
    pub fn zebra(lanes: &[Direction], speed_limit: f64) -> Self {
        Self {
            name: String::new(),
            lane_width: 4.0,
            lanes: lanes.iter().map(|direction| Lane { direction: *direction }).collect(),
            speed_limit,
            kerbs: true,
            medians: Vec::new(),
            crossing: Crossing { kind: CrossingKind::Zebra, width: 4.0 },
            other_crossings: Vec::new(),
            boxes: Vec::new(),
            bend: None,
            ground: Ground::default(),
        }
    }

    /// Whether its lanes can follow how it bends.
    ///
    /// # Errors
    /// The first lane or kerb that a piece is too tight for.
    pub fn check_bend(&self) -> Result<(), GeometryError> {
        let Some(bend) = &self.bend else { return Ok(()) };
        let lanes = (0..self.lanes.len()).map(|lane| self.lane_centre(lane));
        let offsets = lanes.chain([self.kerb(Side::Near), self.kerb(Side::Far)]);
        offsets.into_iter().try_for_each(|offset| {
            CurvedPath::new(bend.line.clone(), offset, Direction::Forward, bend.crossing).map(drop)
        })
    }

    /// How far a point is to the left of the centre line of lane 0, m; y on a straight road.
    pub fn across(&self, point: Vector2<f64>) -> f64 {
        match &self.bend {
            None => point.y,
            Some(bend) => bend.line.project(point).left,
        }
    }

    /// How far along lane 0 a point is from the middle of the crossing, m; x on a straight road.
    pub fn along(&self, point: Vector2<f64>) -> f64 {
        match &self.bend {
            None => point.x,
            Some(bend) => bend.line.project(point).station - bend.crossing,
        }
    }

    /// How fast somebody at a point comes nearer to the far side of the road who moves at `velocity`, m/s.
    pub fn speed_across(&self, point: Vector2<f64>, velocity: Vector2<f64>) -> f64 {
        match &self.bend {
            None => velocity.y,
            Some(bend) => bend.normal(point).dot(&velocity),
        }
    }

    /// Unit vector along the road, abreast of a point.
    pub fn way_along(&self, point: Vector2<f64>) -> Vector2<f64> {
        match &self.bend {
            None => Vector2::new(1.0, 0.0),
            Some(bend) => bend.line.pose(bend.line.project(point).station).tangent(),
        }
    }

    /// The velocity (m/s) of somebody at a point who crosses the road at a right angle, coming from `side`, at `speed` (m/s).
    pub fn crossing_velocity(&self, point: Vector2<f64>, side: Side, speed: f64) -> Vector2<f64> {
        match &self.bend {
            None => Vector2::new(0.0, side.walking_sign() * speed),
            Some(bend) => bend.normal(point) * (side.walking_sign() * speed),
        }
    }

    /// The point at which somebody who walks along `way` from a point steps over the kerb on a side, if that lies ahead.
    pub fn kerb_ahead(&self, side: Side, from: Vector2<f64>, way: Vector2<f64>) -> Option<Vector2<f64>> {
        match &self.bend {
            None => {
                let part = (self.kerb(side) - from.y) / way.y;
                (part.is_finite() && part > 0.0).then(|| from + way * part)
            }
            Some(bend) => {
                let kerb =
                    CurvedPath::beside(bend.line.clone(), self.kerb(side), Direction::Forward, bend.crossing);
                let way = way.try_normalize(0.0)?;
                let met = kerb.crossings(from, way).filter(|met| met.distance > 0.0);
                let nearest = met.min_by(|one, other| one.distance.total_cmp(&other.distance))?;
                Some(from + way * nearest.distance)
            }
        }
    }

    /// The path of whoever drives in a lane.
    pub fn path(&self, lane: usize) -> Path {
        let (centre, direction) = (self.lane_centre(lane), self.lanes[lane].direction);
        match &self.bend {
            None => Path::straight(centre, direction),
            Some(bend) => {
                Path::curved(CurvedPath::beside(bend.line.clone(), centre, direction, bend.crossing))
            }
        }
    }

    /// y of a lane's centre line in m.
    pub fn lane_centre(&self, lane: usize) -> f64 {
        self.beyond_medians(lane as f64 * self.lane_width, lane)
    }

    /// `y` (m) where there is no median, on a lane or beside it.
    fn beyond_medians(&self, y: f64, lane: usize) -> f64 {
        // Where there is none, with the bits that this always had.
        self.medians.iter().filter(|median| median.after < lane).fold(y, |y, median| y + median.width)
    }

    /// y of the two edges of a median, m.
    pub fn edges_of(&self, median: &Median) -> (f64, f64) {
        let near = self.lane_centre(median.after) + self.lane_width / 2.0;
        (near, near + median.width)
    }

    /// y of the lines between every two lanes that nothing lies between, m.
    pub fn lane_lines(&self) -> impl Iterator<Item = f64> {
        let divided = |lane: usize| self.medians.iter().any(|median| median.after + 1 == lane);
        (1..self.lanes.len())
            .filter(move |lane| !divided(*lane))
            .map(|lane| self.beyond_medians((lane as f64 - 0.5) * self.lane_width, lane))
    }

    /// The points at which somebody who goes straight from `start` to `goal` is in the middle of a refuge, in the order in which
    /// they come to them.
    pub fn refuges_between(&self, start: Position, goal: Position) -> Vec<Position> {
        let (from, to): (Vector2<f64>, Vector2<f64>) = (start.into(), goal.into());
        let way = to - from;
        let middles = self.medians.iter().filter(|median| median.refuge).map(|median| {
            let (near, far) = self.edges_of(median);
            (near + far) / 2.0
        });
        let met = middles.filter_map(|middle| match &self.bend {
            None => {
                let part = (middle - from.y) / way.y;
                (part > 0.0 && part < 1.0).then_some(part)
            }
            Some(bend) => {
                let line = CurvedPath::beside(bend.line.clone(), middle, Direction::Forward, bend.crossing);
                let length = way.norm();
                let met = line.crossings(from, way / length).map(|met| met.distance / length);
                met.filter(|part| *part > 0.0 && *part < 1.0).min_by(f64::total_cmp)
            }
        });
        let mut parts: Vec<f64> = met.collect();
        parts.sort_by(f64::total_cmp);
        // Straight across, the place along the road is kept to the bit.
        let at = |part: f64| Position { x: from.x + way.x * part, y: from.y + way.y * part };
        parts.into_iter().map(at).collect()
    }

    /// The crossings with their places along the road (m); the first is the origin.
    pub fn crossings(&self) -> impl Iterator<Item = (f64, &Crossing)> {
        let others = self.other_crossings.iter().map(|other| (other.along, &other.crossing));
        std::iter::once((0.0, &self.crossing)).chain(others)
    }

    /// Whether one of them has a signal.
    pub fn has_signal(&self) -> bool {
        self.crossings().any(|(_, crossing)| crossing.signal().is_some())
    }

    /// A crossing by its number in [`Self::crossings`], with its place along the road (m).
    ///
    /// # Panics
    /// If there are not so many.
    pub fn numbered_crossing(&self, number: usize) -> (f64, &Crossing) {
        match number.checked_sub(1) {
            None => (0.0, &self.crossing),
            Some(other) => (self.other_crossings[other].along, &self.other_crossings[other].crossing),
        }
    }

    /// y of the centre line of the lane that is nearest to a side, m.
    pub fn outer_lane_centre(&self, side: Side) -> f64 {
        self.lane_centre(match side {
            Side::Near => 0,
            Side::Far => self.lanes.len() - 1,
        })
    }

    /// y of the kerb on a side in m.
    pub fn kerb(&self, side: Side) -> f64 {
        match side {
            Side::Near => -self.lane_width / 2.0,
            Side::Far => {
                self.beyond_medians((self.lanes.len() as f64 - 0.5) * self.lane_width, self.lanes.len())
            }
        }
    }
}

impl Crossing {
    /// What its signal shows to vehicles at time `time` (s); `None` without one.
    pub fn seen_signal(&self, time: f64) -> Option<SeenSignal> {
        self.signal().map(|signal| signal.seen(time))
    }

    /// Its signal.
    pub fn signal(&self) -> Option<&TrafficSignal> {
        match &self.kind {
            CrossingKind::Signalised(signal) => Some(signal),
            CrossingKind::Zebra | CrossingKind::Unmarked => None,
        }
    }

    /// Whether pedestrians have priority at time `time` (s).
    pub fn pedestrian_priority(&self, time: f64) -> bool {
        match self.kind {
            CrossingKind::Zebra => true,
            CrossingKind::Unmarked => false,
            CrossingKind::Signalised(signal) => signal.people_have_green(time),
        }
    }
}

impl Path {
    /// y (m) of the edge of the carriageway to the right of the path and of that to its left, seen from it: a kerb of the road or a
    /// median.
    pub fn kerbs(&self, road: &Road) -> (f64, f64) {
        self.between(road, |_| true)
    }

    /// y (m) of where people may wait to the right of the path and to its left, seen from it, who cross it: beyond a kerb of the road or
    /// on a refuge.
    pub fn waiting_places(&self, road: &Road) -> (f64, f64) {
        self.between(road, |median| median.refuge)
    }

    /// y (m) of what is nearest to the right and to the left: a kerb of the road or one of these medians.
    fn between(&self, road: &Road, counts: impl Fn(&Median) -> bool) -> (f64, f64) {
        let (y, direction) = self.offset_and_direction();
        let (mut near, mut far) = (road.kerb(Side::Near) - y, road.kerb(Side::Far) - y);
        for median in road.medians.iter().filter(|median| counts(median)) {
            let (nearer, farther) = road.edges_of(median);
            if farther <= y {
                near = near.max(farther - y);
            } else {
                far = far.min(nearer - y);
            }
        }
        match direction {
            Direction::Forward => (near, far),
            Direction::Backward => (-far, -near),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_lanes(kind: CrossingKind) -> Road {
        let lanes = [Direction::Forward, Direction::Backward];
        Road { crossing: Crossing { kind, width: 4.0 }, ..Road::zebra(&lanes, 30.0 / 3.6) }
    }

    #[test]
    fn kerbs_enclose_the_lanes() {
        let road = two_lanes(CrossingKind::Zebra);
        assert_eq!((road.kerb(Side::Near), road.kerb(Side::Far)), (-2.0, 6.0));
        assert_eq!((road.lane_centre(1), road.path(1)), (4.0, Path::straight(4.0, Direction::Backward)));
    }

    #[test]
    fn signals_give_priority_in_turns() {
        let kind = CrossingKind::Signalised(TrafficSignal::new(60.0, 50.0, 20.0));
        let road = two_lanes(kind);
        let at = |time| road.crossing.pedestrian_priority(time);
        assert_eq!(
            [at(0.0), at(9.9), at(10.0), at(49.9), at(50.0), at(60.0)],
            [true, true, false, false, true, true]
        );
    }
}
