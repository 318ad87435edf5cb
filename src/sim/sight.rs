//! Who is hidden from whom: boxes stand in lines of sight, and so do vehicles and people.
//!
//! A box hides those whose centre is behind it. Of what moves, several may stand before somebody, each narrower than they are. So a body is
//! divided into five strips of equal width, as seen from the eye, and is hidden if three of them are: if the line of sight to the middle of a
//! strip leads through another body. What covers somebody from one side then hides them when it covers their centre, as a box does. Boxes
//! cover strips, too, where something that moves covers one.
//!
//! People look over passenger cars, and past and over each other: from them only boxes and longer vehicles hide others.
//!
//! Nobody hides themselves. A body that reaches over the eye, or over a point that is looked at, hides nothing of it.

use nalgebra::Vector2;

use super::geometry::Footprint;
use scenario::Shape;
use scenario::agent::Scene;

/// The middles of the strips, as shares of half a body's width.
const STRIPS: [f64; 5] = [-0.8, -0.4, 0.0, 0.4, 0.8];

/// So many of them hide a body.
const MOST: usize = 3;

/// Vehicles up to this length are looked over by who stands, m: passenger cars, lower (1.5 m) than the eyes of grown-ups. The car that German
/// streets are designed for (RASt 06) is 4.74 m long and 1.51 m high, the next larger vehicle 6.89 m and 2.7 m, as remembered.
pub const LOOKED_OVER: f64 = 5.5;

/// Whether a body is hidden from an eye by `movers`, which are neither the body itself nor whose eye it is. Of `boxes` counts only what they
/// cover besides: alone they hide whom [`is_behind_a_box`] says.
pub fn is_hidden(
    eye: Vector2<f64>,
    body: &Footprint,
    movers: impl Iterator<Item = Footprint> + Clone,
    boxes: impl Iterator<Item = Footprint> + Clone,
) -> bool {
    let line = body.centre - eye;
    let distance = line.norm();
    let Some(sight) = line.try_normalize(0.0) else { return false };
    let near = movers.filter(|mover| {
        let (way, reach) = (mover.centre - eye, mover.radius() + body.radius());
        let ahead = way.dot(&sight);
        way.perp(&sight).abs() < reach && -reach < ahead && ahead < distance + reach
    });
    if near.clone().next().is_none() {
        return false;
    }
    let points = STRIPS.map(|share| middle_of_strip(body, sight, share));
    let by_movers = points.map(|point| near.clone().any(|mover| covers(&mover, eye, point)));
    if !by_movers.contains(&true) {
        return false;
    }
    let covered = points
        .iter()
        .zip(by_movers)
        .filter(|(point, by_mover)| *by_mover || boxes.clone().any(|one| covers(&one, eye, **point)));
    covered.count() >= MOST
}

/// Whether a body covers a part of another from an eye: one of its strips.
pub fn covers_part(eye: Vector2<f64>, body: &Footprint, other: &Footprint) -> bool {
    let Some(sight) = (body.centre - eye).try_normalize(0.0) else { return false };
    STRIPS.iter().any(|share| covers(other, eye, middle_of_strip(body, sight, *share)))
}

/// Whether a box hides a place from an eye.
pub fn is_behind_a_box(
    eye: Vector2<f64>,
    place: Vector2<f64>,
    mut boxes: impl Iterator<Item = Footprint>,
) -> bool {
    boxes.any(|one| covers(&one, eye, place))
}

/// Whether nothing could hide a vehicle from a pedestrian, so that they see them all.
pub fn sees_all_vehicles(scene: &Scene) -> bool {
    let may_hide = || scene.vehicles.iter().any(|vehicle| vehicle.length > LOOKED_OVER);
    scene.road.boxes.is_empty() && (scene.vehicles.len() == 1 || !may_hide())
}

/// Whether a pedestrian sees a vehicle, by its index: no box hides its centre, and no others that are longer than [`LOOKED_OVER`] hide most of it.
#[inline]
pub fn sees_vehicle(scene: &Scene, vehicle: usize) -> bool {
    scene.vehicles.len() == 1 && scene.road.boxes.is_empty() || sees_past_others(scene, vehicle)
}

#[inline(never)]
fn sees_past_others(scene: &Scene, vehicle: usize) -> bool {
    let hides = |other: usize| other != vehicle && scene.vehicles[other].length > LOOKED_OVER;
    let others = (0..scene.vehicles.len()).filter(|other| hides(*other));
    if scene.road.boxes.is_empty() && others.clone().next().is_none() {
        return true;
    }
    let eye = scene.ego().position;
    let body = Footprint::from(&scene.vehicles[vehicle]);
    let boxes = scene.road.boxes.iter().map(Footprint::from);
    let others = others.map(|other| Footprint::from(&scene.vehicles[other]));
    !is_behind_a_box(eye, body.centre, boxes.clone()) && !is_hidden(eye, &body, others, boxes)
}

/// Whether a body stands in the line from an eye to a point.
fn covers(body: &Footprint, eye: Vector2<f64>, point: Vector2<f64>) -> bool {
    body.is_crossed(eye, point - eye) && !body.is_over(eye) && !body.is_over(point)
}

/// The middle of what a body fills of the line along `sight` that lies at this share of half its width, seen that way, to the left of its centre.
fn middle_of_strip(body: &Footprint, sight: Vector2<f64>, share: f64) -> Vector2<f64> {
    let left = Vector2::new(-sight.y, sight.x);
    let beside = left * (body.reach(left) * share);
    let Shape::Rectangle { length, width } = body.shape else { return body.centre + beside };
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    for (axis, half) in [(body.heading, length / 2.0), (body.across(), width / 2.0)] {
        let (offset, along) = (beside.dot(&axis), sight.dot(&axis));
        if along != 0.0 {
            let (one, other) = ((-half - offset) / along, (half - offset) / along);
            (enter, leave) = (enter.max(one.min(other)), leave.min(one.max(other)));
        }
    }
    body.centre + beside + sight * ((enter + leave) / 2.0)
}

#[cfg(test)]
mod tests;
