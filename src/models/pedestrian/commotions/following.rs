//! How people walk behind each other: an extension, since the published model knows a person alone.
//!
//! Who walks behind somebody is no faster than leaves the room that people in single file were measured to take at their speed,
//! 0.36 m + 1.06 s · v between centres (Seyfried et al. 2005, J. Stat. Mech. P10002). Who is alone is as published.

use sim::{PedestrianState, Scene};

/// Between the centres of two who stand, m.
const STANDING: f64 = 0.36;

/// More for every m/s, s.
const PER_SPEED: f64 = 1.06;

/// The acceleration (m/s²) that brings the walker within a step to the speed that whoever walks before it leaves it; `None` if nobody does.
pub fn limit(scene: &Scene) -> Option<f64> {
    let me = scene.ego();
    let others =
        scene.pedestrians.iter().enumerate().filter(|(index, other)| *index != scene.me && other.present);
    let nearest = others.filter_map(|(_, other)| ahead(me, other)).reduce(f64::min)?;
    let fastest = ((nearest - STANDING) / PER_SPEED).max(0.0);
    Some((fastest - me.velocity.dot(&me.heading)) / scene.step)
}

/// How far ahead somebody is who walks the same way in one's own track, m.
fn ahead(me: &PedestrianState, other: &PedestrianState) -> Option<f64> {
    let offset = other.position - me.position;
    let along = offset.dot(&me.heading);
    let beside = (offset - me.heading * along).norm();
    let (_, width) = me.shape.extents();
    let (_, others) = other.shape.extents();
    let same_way = other.velocity.dot(&me.heading) > 0.0;
    (same_way && along > 0.0 && beside < (width + others) / 2.0).then_some(along)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::pedestrian::test_walk::world;
    use scenario::Shape;

    fn person(y: f64, speed: f64) -> PedestrianState {
        PedestrianState {
            position: Vector2::new(0.0, y),
            velocity: Vector2::new(0.0, speed),
            acceleration: Vector2::zeros(),
            heading: Vector2::y(),
            shape: Shape::Disc { radius: 0.25 },
            present: true,
        }
    }

    fn limit_of(people: &[PedestrianState]) -> Option<f64> {
        let world = world();
        let goal = world.pedestrians[0].goal;
        let (vehicles, road) = (&[][..], &world.road);
        limit(&Scene {
            time: 0.0,
            step: 0.1,
            road,
            crossing: 0,
            me: 0,
            goal,
            legs: (0, 0),
            vehicles,
            pedestrians: people,
            held: false,
        })
    }

    /// At 1.42 m there is room for 1 m/s.
    #[test]
    fn who_follows_has_the_speed_of_the_room_that_is_left() {
        let limit = limit_of(&[person(0.0, 1.4), person(1.42, 1.0)]).unwrap();
        assert!((limit + 4.0).abs() < 1e-9, "{limit}");
        // Of several the nearest counts.
        assert_eq!(limit_of(&[person(0.0, 1.4), person(3.0, 1.0), person(1.42, 1.0)]), Some(limit));
    }

    #[test]
    fn nobody_ahead_in_the_same_track_is_no_limit() {
        let me = person(0.0, 1.4);
        let beside = PedestrianState { position: Vector2::new(0.6, 1.0), ..person(0.0, 1.4) };
        let later = PedestrianState { present: false, ..person(1.0, 1.0) };
        let towards = person(1.0, -1.0);
        for other in [person(-1.0, 1.4), beside, later, towards] {
            assert_eq!(limit_of(&[me, other]), None);
        }
        assert_eq!(limit_of(&[me]), None);
    }
}
