//! Which part of the plane is shown, and who of it is outside.

use nalgebra::Vector2;

use super::plane::{Frame, corners};
use super::road::beside;
use scenario::{Side, World};
use sim::geometry::Footprint;

/// What is farther from the crossing than this is left out of the picture, m.
const NEAR: f64 = 45.0;

/// Boxes that are farther from it are, too, m.
const NEAR_BOXES: f64 = 30.0;

/// How much of a road is shown before and behind where it meets another, m.
const JUNCTION: f64 = 10.0;

/// On every side, m.
const ROOM: f64 = 2.5;

/// What matters of a world: the crossings that people use, starts and goals of people, boxes near it, vehicles (`cars`) and other `places` that are
/// not too far away.
pub(crate) fn view(
    world: &World,
    cars: impl IntoIterator<Item = Vector2<f64>>,
    places: impl IntoIterator<Item = Vector2<f64>>,
) -> Frame {
    let road = &world.road;
    let mut used: Vec<usize> = world.pedestrians.iter().map(|person| person.crossing).collect();
    used.sort_unstable();
    used.dedup();
    let mut points = Vec::new();
    for other in &world.other_roads {
        points.extend(beside(other, other.kerb(Side::Near), -JUNCTION, JUNCTION));
        points.extend(beside(other, other.kerb(Side::Far), -JUNCTION, JUNCTION));
    }
    // Where nobody walks, the crossing is where nothing happens.
    for number in if used.is_empty() && points.is_empty() { vec![0] } else { used } {
        let (at, crossing) = road.numbered_crossing(number);
        let (from, to) = (at - crossing.width / 2.0 - 4.0, at + crossing.width / 2.0 + 4.0);
        points.extend(beside(road, road.kerb(Side::Near), from, to));
        points.extend(beside(road, road.kerb(Side::Far), from, to));
    }
    let middle = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
    let near = |within: f64| move |point: &Vector2<f64>| (point - middle).norm() <= within;
    let people = world.pedestrians.iter().flat_map(|one| [one.start, one.goal].map(Vector2::from));
    points.extend(people.filter(near(NEAR)));
    let boxes = road.boxes.iter().flat_map(|body| corners(&Footprint::from(body)));
    points.extend(boxes.filter(near(NEAR_BOXES)));
    points.extend(cars.into_iter().chain(places).filter(near(NEAR)));
    let frame = Frame::around(points, ROOM).unwrap_or(Frame { low: middle, high: middle });
    frame.at_least(Vector2::new(24.0, 10.0))
}
