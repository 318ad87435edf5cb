//! The road from above: carriageway, kerbs, lanes, crossing and what stands there, along a bend as lines of short chords.

use nalgebra::Vector2;

use super::plane::{Mark, MarkKind, corners};
use scenario::geometry::CurvedPath;
use scenario::{CrossingKind, Direction, Road, Side, World};
use sim::geometry::Footprint;

/// A chord is no farther than this from the curve that it stands for, m.
const CHORD_ERROR: f64 = 0.02;

/// From the middle of one stripe to that of the next, m.
const STRIPES: f64 = 1.0;

/// Lines that end at another road are looked at every so many metres.
const LOOKS: f64 = 0.1;

/// How far before and behind the point where it meets the other a road is drawn that lies over it, m.
const OVER: f64 = 250.0;

/// Everything of all roads of a world: of its own between two lines across that, so far (m) along it from the middle of the crossing. Where
/// roads cross there are no kerbs and no lines between lanes.
pub(crate) fn world_marks(world: &World, from: f64, to: f64) -> Vec<Mark> {
    let own = road_marks(&world.road, from, to);
    if world.other_roads.is_empty() {
        return own;
    }
    let roads: Vec<&Road> = world.roads().collect();
    let of_others = world.other_roads.iter().map(|road| road_marks(road, -OVER, OVER));
    let mut marks: Vec<Mark> = Vec::new();
    // The road below comes last: its crossings and boxes are seen.
    for (number, found) in of_others.enumerate().map(|(index, found)| (index + 1, found)).chain([(0, own)]) {
        let others: Vec<&Road> =
            roads.iter().enumerate().filter(|(index, _)| *index != number).map(|(_, road)| *road).collect();
        for mark in found {
            match mark.kind {
                MarkKind::Kerb | MarkKind::Lane => marks.extend(outside(&mark, &others)),
                _ => marks.push(mark),
            }
        }
    }
    marks
}

/// Whether a point lies on a road.
pub(crate) fn is_on(road: &Road, point: Vector2<f64>) -> bool {
    let across = road.across(point);
    road.kerb(Side::Near) < across && across < road.kerb(Side::Far)
}

/// What of a line lies on none of some roads.
fn outside(mark: &Mark, roads: &[&Road]) -> Vec<Mark> {
    let mut lines: Vec<Vec<Vector2<f64>>> = Vec::new();
    let mut open = false;
    for pair in mark.points.windows(2) {
        let (from, way) = (pair[0], pair[1] - pair[0]);
        let looks = (way.norm() / LOOKS).ceil().max(1.0) as usize;
        for look in 0..looks {
            let at = |index: usize| from + way * (index as f64 / looks as f64);
            let free = !roads.iter().any(|road| is_on(road, (at(look) + at(look + 1)) / 2.0));
            match (free, open) {
                (true, false) => lines.push(vec![at(look), at(look + 1)]),
                (true, true) => {
                    // A straight line is drawn by its ends.
                    let line = lines.last_mut().expect("one is open");
                    if look > 0 {
                        line.pop();
                    }
                    line.push(at(look + 1));
                }
                (false, _) => {}
            }
            open = free;
        }
    }
    lines.into_iter().map(|points| Mark::line(mark.kind, points)).collect()
}

/// Everything of the road between two lines across it, so far (m) along it from the middle of the crossing.
pub(crate) fn road_marks(road: &Road, from: f64, to: f64) -> Vec<Mark> {
    let (near, far) = (road.kerb(Side::Near), road.kerb(Side::Far));
    let band = |kind: MarkKind, (low, high): (f64, f64), (from, to): (f64, f64)| {
        let mut points = beside(road, low, from, to);
        points.extend(beside(road, high, from, to).into_iter().rev());
        Mark::area(kind, points)
    };
    let mut marks = vec![band(MarkKind::Road, (near, far), (from, to))];
    marks.extend([near, far].map(|offset| Mark::line(MarkKind::Kerb, beside(road, offset, from, to))));
    marks.extend(road.lane_lines().map(|line| Mark::line(MarkKind::Lane, beside(road, line, from, to))));
    marks.extend(road.medians.iter().map(|median| band(MarkKind::Median, road.edges_of(median), (from, to))));
    // Where it meets another, a road that lies over it has something of no width in the place of a crossing.
    for (middle, crossing) in road.crossings().filter(|(_, crossing)| crossing.width > 0.0) {
        let ends = (middle - crossing.width / 2.0, middle + crossing.width / 2.0);
        // Lines between lanes end at it.
        marks.push(band(MarkKind::Road, (near + 0.1, far - 0.1), ends));
        if crossing.kind == CrossingKind::Zebra {
            let mut low = near + STRIPES / 4.0;
            while low + STRIPES / 2.0 <= far {
                marks.push(band(MarkKind::Stripe, (low, low + STRIPES / 2.0), ends));
                low += STRIPES;
            }
        } else {
            marks.push(band(MarkKind::Edge, (near, far), ends));
        }
        // On a refuge nobody drives, and people stand.
        let refuges = road.medians.iter().filter(|median| median.refuge);
        marks.extend(refuges.map(|median| band(MarkKind::Median, road.edges_of(median), ends)));
    }
    marks.extend(stop_lines(road).into_iter().map(|line| Mark::line(MarkKind::StopLine, line)));
    marks.extend(road.boxes.iter().map(|body| Mark::area(MarkKind::Block, corners(&Footprint::from(body)))));
    marks
}

/// The line across each lane before which its vehicles stop for the signal of a crossing; none without one.
pub(crate) fn stop_lines(road: &Road) -> Vec<Vec<Vector2<f64>>> {
    let signals = road.crossings().filter_map(|(middle, crossing)| {
        crossing.signal().map(|signal| (middle, crossing.width / 2.0 + signal.stop_line))
    });
    let lines = |(middle, before): (f64, f64)| {
        (0..road.lanes.len()).map(move |lane| {
            let along = match road.lanes[lane].direction {
                Direction::Forward => middle - before,
                Direction::Backward => middle + before,
            };
            let centre = road.lane_centre(lane);
            let edge = |share: f64| beside(road, centre + share * road.lane_width, along, along)[0];
            vec![edge(-0.46), edge(0.46)]
        })
    };
    signals.flat_map(lines).collect()
}

/// The outline of each crossing, from kerb to kerb.
pub(crate) fn crossing_areas(road: &Road) -> impl Iterator<Item = Vec<Vector2<f64>>> {
    road.crossings().map(|(middle, crossing)| {
        let (from, to) = (middle - crossing.width / 2.0, middle + crossing.width / 2.0);
        let mut points = beside(road, road.kerb(Side::Near), from, to);
        points.extend(beside(road, road.kerb(Side::Far), from, to).into_iter().rev());
        points
    })
}

/// The line at a constant distance (m, to the left) of the centre line of lane 0, between two lines across the road.
pub(crate) fn beside(road: &Road, offset: f64, from: f64, to: f64) -> Vec<Vector2<f64>> {
    let Some(bend) = &road.bend else { return vec![Vector2::new(from, offset), Vector2::new(to, offset)] };
    let course = CurvedPath::beside(bend.line.clone(), offset, Direction::Forward, bend.crossing);
    let place = |along: f64| course.place_abreast(bend.crossing + along);
    chords(&course, place(from), place(to))
}

/// Points of a course from one place to another, of which chords are near enough to it.
fn chords(course: &CurvedPath, from: f64, to: f64) -> Vec<Vector2<f64>> {
    let mut points = vec![course.point(from)];
    let mut stretches = vec![(from, to)];
    while let Some((from, to)) = stretches.pop() {
        let length = to - from;
        if course.tightest_between(from, to) * length * length / 8.0 > CHORD_ERROR {
            let middle = from + length / 2.0;
            stretches.extend([(middle, to), (from, middle)]);
        } else {
            points.push(course.point(to));
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use scenario::Bend;
    use scenario::geometry::{Piece, Pose, ReferenceLine};

    fn bent(side: f64) -> Road {
        let [one, arc, other] = Piece::turn(1500.0 * side, 9.0 * side, 0.36, 0.85);
        let pieces = [Piece::line(30.0), one, arc, other, Piece::line(40.0)];
        let line = ReferenceLine::new(Pose::origin(), &pieces).unwrap();
        let lanes = [Direction::Forward, Direction::Backward];
        let bend = Bend { line: Arc::new(line), crossing: 38.0 };
        Road { bend: Some(bend), lane_width: 3.0, ..Road::zebra(&lanes, 10.0) }
    }

    /// How far a point is from a chain of chords, m.
    fn from_chords(points: &[Vector2<f64>], point: Vector2<f64>) -> f64 {
        let apart = |pair: &[Vector2<f64>]| {
            let way = pair[1] - pair[0];
            let share = ((point - pair[0]).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
            (point - pair[0] - way * share).norm()
        };
        points.windows(2).map(apart).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn kerbs_and_lanes_are_where_they_are_to_two_centimetres() {
        for side in [1.0, -1.0] {
            let road = bent(side);
            let bend = road.bend.clone().unwrap();
            let marks = road_marks(&road, -50.0, 60.0);
            let of = |kind| marks.iter().filter(move |mark| mark.kind == kind);
            let lines: Vec<&Mark> = of(MarkKind::Kerb).chain(of(MarkKind::Lane)).collect();
            assert_eq!(lines.len(), 3);
            for (mark, offset) in lines.into_iter().zip([-1.5, 4.5, 1.5]) {
                assert!(mark.points.len() > 10 && mark.points.len() < 200, "{} points", mark.points.len());
                for step in -499..600 {
                    let pose = bend.line.pose(38.0 + f64::from(step) * 0.1);
                    let apart = from_chords(&mark.points, pose.point + pose.normal() * offset);
                    assert!(apart <= 0.02, "{side}, {offset} m beside: {apart} m off");
                }
                // And nothing of it is anywhere else.
                for point in &mark.points {
                    assert!((bend.line.project(*point).left - offset).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn a_straight_road_is_drawn_by_its_ends() {
        let marks = road_marks(&Road::zebra(&[Direction::Forward], 10.0), -20.0, 30.0);
        assert_eq!(marks[0].points.len(), 4);
        let stripes: Vec<_> = marks.iter().filter(|mark| mark.kind == MarkKind::Stripe).collect();
        assert_eq!(stripes.len(), 4);
        assert!(
            stripes
                .iter()
                .flat_map(|mark| &mark.points)
                .all(|point| point.x.abs() == 2.0 && point.y.abs() < 2.0)
        );
    }
}
