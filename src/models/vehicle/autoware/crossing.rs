//! Who means to cross, and where his path meets the ego's (specification §1.2, §1.3, §5.1, §5.2).
//!
//! Everything is computed along the pedestrian's own way across: u = y or -y so that he walks towards +u. Both sides
//! of the road are therefore treated alike.

use nalgebra::Vector2;

use super::debounce::{Debounce, Delays};
use super::site::{Ego, Site};
use super::tracker::TrackedTarget;
use scenario::Settings;

/// Below this speed a pedestrian has no heading and counts as wanting to cross, m/s.
const STANDING: f64 = 0.14;

/// How far ahead paths are predicted, s.
const HORIZON: f64 = 10.0;

/// Where the paths of ego and pedestrian meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CollisionPoint {
    /// s, m.
    pub place: f64,
    /// How far the pedestrian still walks to it, m.
    pub walk: f64,
}

#[derive(Debug, Clone, Copy)]
pub struct CrossingConstants {
    min_object_velocity: f64,
    attention_range: f64,
    delays: Delays,
}

/// What is remembered of one pedestrian.
#[derive(Debug, Clone, Copy, Default)]
pub struct Crosser {
    /// +1 if he crosses towards +y, -1 towards -y; `None` before he was first seen.
    direction: Option<f64>,
    intention: Debounce,
}

impl CrossingConstants {
    pub fn new(settings: &Settings) -> Self {
        Self {
            min_object_velocity: settings.number("min_object_velocity"),
            attention_range: settings.number("attention_range"),
            delays: Delays {
                on: settings.number("intention_on_delay"),
                off: settings.number("intention_off_delay"),
            },
        }
    }

    /// Half the stretch of the lane where paths count, m.
    pub fn attention(&self, site: &Site) -> f64 {
        site.half_width + self.attention_range
    }
}

impl Crosser {
    /// Where the pedestrian's predicted paths first meet the ego's, if any does. To be called at every tick.
    pub fn collision_point(
        &mut self,
        target: &TrackedTarget,
        time: f64,
        ego: &Ego,
        site: &Site,
        constants: &CrossingConstants,
    ) -> Option<CollisionPoint> {
        let direction = self.face(target, ego);
        let way = Way::new(target, direction, site);
        let wants = self.intention.update(way.looks_like_crossing(site, constants), time, constants.delays);
        if way.place - target.half_size >= ego.half_width {
            return None;
        }
        let across = wants.then(|| way.over_the_crosswalk(ego.half_width));
        let straight = way.straight_on(ego.half_width, target.half_size);
        let attention = constants.attention(site);
        [across, straight]
            .into_iter()
            .flatten()
            .filter(|point| point.place.abs() <= attention)
            .min_by(|left, right| left.place.total_cmp(&right.place))
    }

    /// Who walks towards the lane, or in it, crosses that way; who stands or turns his back keeps the way he came.
    /// At first it is towards the lane.
    fn face(&mut self, target: &TrackedTarget, ego: &Ego) -> f64 {
        let (y, across) = (target.position.y, target.velocity.y);
        let known = *self.direction.get_or_insert(if y > 0.0 { -1.0 } else { 1.0 });
        let walks_in = y.abs() <= ego.half_width || y * across < 0.0;
        if target.velocity.norm() >= STANDING && across != 0.0 && walks_in {
            self.direction = Some(across.signum());
        }
        self.direction.unwrap_or(known)
    }
}

/// A pedestrian seen along his way across.
struct Way {
    along: f64,
    /// u of his centre, m.
    place: f64,
    /// Along the lane, m/s.
    drift: f64,
    /// Along u, m/s.
    speed: f64,
    near_kerb: f64,
    far_kerb: f64,
}

impl Way {
    fn new(target: &TrackedTarget, direction: f64, site: &Site) -> Self {
        let kerbs = (direction * site.right_kerb, direction * site.left_kerb);
        Self {
            along: target.position.x,
            place: direction * target.position.y,
            drift: target.velocity.x,
            speed: direction * target.velocity.y,
            near_kerb: kerbs.0.min(kerbs.1),
            far_kerb: kerbs.0.max(kerbs.1),
        }
    }

    /// Standing, or walking within 45° of straight across, with the end of the crosswalk within reach.
    fn looks_like_crossing(&self, site: &Site, constants: &CrossingConstants) -> bool {
        let speed = libm::hypot(self.drift, self.speed);
        let faces = speed < STANDING || self.speed >= self.drift.abs();
        let on_road = self.place > self.near_kerb;
        let end = if on_road { self.far_kerb } else { self.near_kerb };
        let inside = on_road && self.place < self.far_kerb && self.along.abs() <= site.half_width;
        let reach = speed.max(constants.min_object_velocity) * HORIZON;
        faces && (inside || libm::hypot(self.along, end - self.place) < reach)
    }

    /// u of the collision point: the middle of the lane, or of what he has left of the ego's path.
    fn meeting(&self, half_width: f64) -> f64 {
        if self.place <= -half_width { 0.0 } else { (self.place + half_width) / 2.0 }
    }

    /// To the middle of the near end of the crosswalk, then along it; once on the road to the middle of the far end.
    fn over_the_crosswalk(&self, half_width: f64) -> CollisionPoint {
        let meeting = self.meeting(half_width);
        if self.place <= self.near_kerb {
            let to_end = libm::hypot(self.along, self.near_kerb - self.place);
            return CollisionPoint { place: 0.0, walk: to_end + (meeting - self.near_kerb).max(0.0) };
        }
        let left = self.far_kerb - self.place;
        let share = if left > 0.0 { ((meeting - self.place) / left).clamp(0.0, 1.0) } else { 0.0 };
        CollisionPoint { place: self.along * (1.0 - share), walk: share * libm::hypot(self.along, left) }
    }

    /// On at constant velocity, if that touches the ego's path within the horizon.
    fn straight_on(&self, half_width: f64, half_size: f64) -> Option<CollisionPoint> {
        let to_path = -half_width - half_size - self.place;
        if to_path >= 0.0 && (self.speed <= 0.0 || to_path / self.speed > HORIZON) {
            return None;
        }
        if self.speed < STANDING {
            return Some(CollisionPoint { place: self.along, walk: 0.0 });
        }
        let velocity = Vector2::new(self.drift, self.speed);
        let time = (self.meeting(half_width) - self.place).max(0.0) / self.speed;
        Some(CollisionPoint { place: self.along + self.drift * time, walk: velocity.norm() * time })
    }
}

#[cfg(test)]
mod tests {
    use super::super::site::tests::{SITE, ego};
    use super::*;
    use crate::vehicle::autoware::autoware;

    fn constants() -> CrossingConstants {
        CrossingConstants::new(&autoware().declaration.resolve(&Settings::default()).unwrap())
    }

    fn target(x: f64, y: f64, vx: f64, vy: f64) -> TrackedTarget {
        TrackedTarget { position: Vector2::new(x, y), velocity: Vector2::new(vx, vy), half_size: 0.25 }
    }

    /// The collision point after the target has looked the same for a second.
    fn settled(target: TrackedTarget) -> Option<CollisionPoint> {
        let mut crosser = Crosser::default();
        let mut point = None;
        for k in 0..=10 {
            let time = f64::from(k) * 0.1;
            point = crosser.collision_point(&target, time, &ego(-40.0, 8.0), &SITE, &constants());
        }
        point
    }

    #[test]
    fn a_standing_pedestrian_at_the_kerb_counts_after_the_delay() {
        let mut crosser = Crosser::default();
        let standing = target(0.0, -4.0, 0.0, 0.0);
        let known: Vec<_> = (0..6)
            .map(|k| {
                let time = f64::from(k) * 0.1;
                crosser.collision_point(&standing, time, &ego(-40.0, 8.0), &SITE, &constants())
            })
            .collect();
        assert_eq!(known[..3], [None; 3]);
        assert_eq!(known[3], Some(CollisionPoint { place: 0.0, walk: 4.0 }));
    }

    #[test]
    fn walkers_count_at_once_and_those_beyond_reach_or_past_do_not() {
        let mut crosser = Crosser::default();
        let mut first = |target: TrackedTarget| {
            let mut fresh = std::mem::take(&mut crosser);
            fresh.collision_point(&target, 0.0, &ego(-40.0, 8.0), &SITE, &constants())
        };
        assert_eq!(first(target(0.0, -4.0, 0.0, 1.0)), Some(CollisionPoint { place: 0.0, walk: 4.0 }));
        assert_eq!(first(target(0.0, -4.0, 0.0, -1.0)), None);
        // 2.802 m to the edge of the ego's path take longer than 10 s.
        assert_eq!(first(target(0.0, -4.0, 0.0, 0.28)), None);
        assert!(settled(target(0.0, -15.8, 0.0, 0.0)).is_some());
        assert_eq!(settled(target(0.0, -16.0, 0.0, 0.0)), None);
        assert_eq!(settled(target(0.0, 1.2, 0.0, 1.0)), None);
        assert!(settled(target(0.0, 1.19, 0.0, 1.0)).is_some());
        // Walking along the pavement.
        assert_eq!(settled(target(0.0, -4.0, 1.4, 0.5)).map(|point| point.place), None);
    }

    #[test]
    fn inside_the_path_the_point_moves_to_the_middle_of_what_is_left() {
        let point = settled(target(0.0, 0.0, 0.0, 1.4)).unwrap();
        assert!((point.place, point.walk) == (0.0, 0.474));
    }

    #[test]
    fn beside_the_crosswalk_the_way_leads_over_its_end() {
        let point = settled(target(3.0, -6.0, 0.0, 0.0)).unwrap();
        assert_eq!(point, CollisionPoint { place: 0.0, walk: 7.0 });
        // A walker 5 m after the crosswalk is outside the attention area on his own line.
        let point = settled(target(5.0, -6.0, 0.0, 1.4)).unwrap();
        assert_eq!(point.place, 0.0);
    }

    #[test]
    fn who_has_crossed_and_stands_is_past_until_he_comes_back() {
        let mut crosser = Crosser::default();
        let mut at = |y: f64, speed: f64, time: f64| {
            let seen = target(0.0, y, 0.0, speed);
            crosser.collision_point(&seen, time, &ego(-40.0, 8.0), &SITE, &constants()).is_some()
        };
        assert!(at(-4.0, 1.4, 0.0));
        assert!(at(0.0, 1.4, 3.0));
        assert!(!at(3.0, 1.4, 5.0));
        assert!(!at(3.0, 0.0, 9.0));
        assert!(at(3.0, -1.4, 10.0));
    }
}
